//! Enclosures of real numbers.

/// A closed interval [lo, hi] that encloses every value of a function.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Range {
    /// Lower bound.
    #[serde(rename = "from")]
    pub lo: f64,
    /// Upper bound.
    #[serde(rename = "to")]
    pub hi: f64,
}

impl Range {
    /// The range of no numbers: its hull with another range is that range.
    pub const EMPTY: Range = Range { lo: f64::INFINITY, hi: f64::NEG_INFINITY };

    /// The range of the numbers from the first one to the last.
    #[must_use]
    pub fn of(numbers: impl IntoIterator<Item = f64>) -> Range {
        numbers.into_iter().fold(Range::EMPTY, |range, x| range.hull(Range { lo: x, hi: x }))
    }

    /// The smallest range that contains both ranges.
    #[must_use]
    pub fn hull(self, other: Range) -> Range {
        Range { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// Whether `other` is within this range.
    #[must_use]
    pub fn contains(self, other: Range) -> bool {
        self.lo <= other.lo && other.hi <= self.hi
    }

    /// Whether `value` is outside.
    #[must_use]
    pub fn excludes(self, value: f64) -> bool {
        self.lo > value || self.hi < value
    }

    /// This range, widened by `by` on both sides and rounded outwards.
    #[must_use]
    pub fn widened(self, by: f64) -> Range {
        Range { lo: (self.lo - by).next_down(), hi: (self.hi + by).next_up() }
    }
}
