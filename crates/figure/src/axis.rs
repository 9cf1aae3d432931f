//! Axes: scales and ticks.

use super::scene::{Stroke, text_width};
use super::style;
use super::text::Rich;
use slipmap_numbers::spacing::is_logarithmic;

/// Size of the numbers at ticks and in legends, in points.
pub const SMALL_TEXT: f64 = 7.0;
/// Size of axis labels and panel titles, in points.
pub const TEXT: f64 = 8.0;

/// Lines of frames and ticks.
pub const AXIS: Stroke = Stroke::solid(style::BLACK, 0.6);

/// Length of a tick, inward.
const TICK: f64 = 3.0;

/// The map from numbers to positions along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    pub from: f64,
    pub to: f64,
    pub log: bool,
    /// Factor by which numbers are multiplied where they are written.
    pub shown: f64,
    /// No ticks below it: what is drawn there has no number on the scale.
    pub ticks_from: f64,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// Its number on the scale.
    pub value: f64,
    /// Its label; empty for a minor tick.
    pub label: Rich,
}

impl Tick {
    /// Length of its line; minor ticks are shorter.
    pub fn length(&self) -> f64 {
        if self.label.pieces.is_empty() { 0.6 * TICK } else { TICK }
    }
}

/// The least and the greatest of some numbers; infinity and minus infinity if there are none.
pub fn extremes(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    numbers.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

impl Scale {
    /// A linear scale; a single number gets a range around it. Ends beyond the largest doubles are moved there.
    pub fn linear(from: f64, to: f64) -> Self {
        let room = if from == 0.0 { 1.0 } else { 0.5 * from.abs() };
        let [from, to] = if to > from { [from, to] } else { [from - room, from + room] };
        Self {
            from: from.max(f64::MIN),
            to: to.min(f64::MAX),
            log: false,
            shown: 1.0,
            ticks_from: f64::NEG_INFINITY,
        }
    }

    /// A logarithmic scale of positive numbers; a single number gets a range around it. Ends beyond the
    /// smallest and the largest double are moved there.
    pub fn logarithmic(from: f64, to: f64) -> Self {
        let [from, to] = if to > from { [from, to] } else { [from / 2.0, from * 2.0] };
        Self {
            from: from.max(f64::from_bits(1)),
            to: to.min(f64::MAX),
            log: true,
            shown: 1.0,
            ticks_from: f64::NEG_INFINITY,
        }
    }

    /// A scale of positive numbers, logarithmic where they extend over more than a factor of five.
    pub fn of_range(from: f64, to: f64) -> Self {
        if to > 5.0 * from { Self::logarithmic(from, to) } else { Self::linear(from, to) }
    }

    /// The scale that fits the nodes of an axis.
    pub fn of_nodes(values: &[f64]) -> Self {
        let (first, last) = (values[0], values[values.len() - 1]);
        if values.len() > 2 && is_logarithmic(values) {
            Self::logarithmic(first, last)
        } else {
            Self::linear(first, last)
        }
    }

    /// Position of a number: 0 at the start, 1 at the end.
    pub fn unit(&self, value: f64) -> f64 {
        if self.log {
            // Differences of logarithms, because the ratio of two numbers may overflow.
            (value.ln() - self.from.ln()) / (self.to.ln() - self.from.ln())
        } else {
            // Halves, because the difference of two numbers may overflow.
            let span = self.to - self.from;
            if span.is_finite() {
                (value - self.from) / span
            } else {
                (0.5 * value - 0.5 * self.from) / (0.5 * self.to - 0.5 * self.from)
            }
        }
    }

    /// The number at a position, inverse of [`Scale::unit`].
    pub fn value(&self, unit: f64) -> f64 {
        if self.log {
            (self.from.ln() * (1.0 - unit) + self.to.ln() * unit).exp().clamp(self.from, self.to)
        } else {
            self.from * (1.0 - unit) + self.to * unit
        }
    }

    /// The same scale, with its numbers written in another unit.
    pub fn in_unit(self, shown: f64) -> Self {
        Self { shown, ..self }
    }

    /// Ticks, about `most` of them labelled.
    pub fn ticks(&self, most: usize) -> Vec<Tick> {
        let [from, to] = [self.from, self.to].map(|end| (end * self.shown).clamp(f64::MIN, f64::MAX));
        let written = Self { from, to, shown: 1.0, ..*self };
        let ticks = if self.log { written.log_ticks(most.max(2)) } else { written.linear_ticks(most.max(2)) };
        let ticks = ticks.into_iter().map(|tick| Tick { value: tick.value / self.shown, ..tick });
        ticks.filter(|tick| tick.value >= self.ticks_from).collect()
    }

    /// Ticks at the two ends only, where no round numbers lie between: next to the smallest or the largest
    /// doubles, or if the ends are almost equal.
    fn end_ticks(&self) -> Vec<Tick> {
        let tick = |value: f64| Tick { value, label: Rich::number(value, 3) };
        vec![tick(self.from), tick(self.to)]
    }

    fn linear_ticks(&self, most: usize) -> Vec<Tick> {
        let span = self.to - self.from;
        let rough = span / most as f64;
        let resolved = 1e3 * f64::EPSILON * self.from.abs().max(self.to.abs());
        if !(rough >= f64::MIN_POSITIVE && rough > resolved && span.is_finite()) {
            return self.end_ticks();
        }
        let power = 10.0_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|step| *step >= rough);
        let step = step.unwrap_or(10.0 * power);
        let slack = 1e-9 * span;
        let first = (self.from / step - slack / step).ceil() as i64;
        let last = (self.to / step + slack / step).floor() as i64;
        let values: Vec<f64> = (first..=last).map(|i| i as f64 * step).collect();
        let largest = values.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        values
            .into_iter()
            .map(|value| {
                let label = if (1e-4..1e5).contains(&largest) && decimals < 5 {
                    Rich::foreign(&format!("{value:.decimals$}").replace('-', "−"))
                } else {
                    let digits = 1 + (largest / step).log10().ceil().max(0.0) as usize;
                    Rich::number(if value.abs() < slack { 0.0 } else { value }, digits)
                };
                Tick { value, label }
            })
            .collect()
    }

    fn log_ticks(&self, most: usize) -> Vec<Tick> {
        let (low, high) = (self.from * (1.0 - 1e-9), self.to * (1.0 + 1e-9));
        let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
        let decades = high.log10() - low.log10();
        if !(decades > 0.0 && decades.is_finite()) {
            return self.end_ticks();
        }
        // Labels at powers of ten; on short axes also at 2 and 5 times these.
        let every = ((decades / most as f64).ceil() as i32).max(1);
        let labelled: &[u8] = match decades {
            d if d < 0.8 => &[1, 2, 3, 4, 5, 6, 8],
            d if d < 1.7 && most > 3 => &[1, 2, 5],
            _ => &[1],
        };
        let mut ticks = Vec::new();
        for exponent in first..=last {
            for factor in 1..10u8 {
                let value = f64::from(factor) * 10.0_f64.powi(exponent);
                if !(low..=high).contains(&value) || (every > 1 && factor > 1) {
                    continue;
                }
                let label = if labelled.contains(&factor) && (factor > 1 || exponent.rem_euclid(every) == 0) {
                    log_label(factor, exponent, (self.from, self.to))
                } else {
                    Rich::default()
                };
                ticks.push(Tick { value, label });
            }
        }
        if ticks.len() < 2 { self.end_ticks() } else { ticks }
    }
}

/// The label of a tick on a logarithmic axis: plain numbers if all are short.
fn log_label(factor: u8, exponent: i32, (from, to): (f64, f64)) -> Rich {
    if from > 0.8e-3 && to < 1.2e3 {
        return Rich::number(f64::from(factor) * 10.0_f64.powi(exponent), 3);
    }
    let power = Rich::power_of_ten(exponent);
    if factor == 1 { power } else { Rich::foreign(&format!("{factor} × ")).then(power) }
}

/// Width of the widest number at ticks.
pub fn text_width_of(ticks: &[Tick]) -> f64 {
    ticks.iter().map(|tick| text_width(&tick.label, SMALL_TEXT)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_around_extreme_numbers_are_ranges_of_numbers() {
        for [from, to] in [[1.9e306, f64::INFINITY], [f64::MAX; 2], [0.0, 4e-323], [f64::from_bits(1); 2]] {
            let scale = Scale::logarithmic(from, to);
            let values = [0.0, 0.5, 1.0].map(|unit| scale.value(unit));
            assert!(values.iter().all(|value| *value > 0.0 && value.is_finite()), "{values:?}");
            assert!(values[0] < values[2]);
        }
        let infinite = [f64::NEG_INFINITY, f64::INFINITY];
        for [from, to] in [[1.7e308, f64::INFINITY], infinite, [f64::MAX; 2], [f64::MIN; 2]] {
            let scale = Scale::linear(from, to).in_unit(10.0);
            let values = [0.0, 0.5, 1.0].map(|unit| scale.value(unit));
            assert!(values.iter().all(|value| value.is_finite()), "{values:?}");
            assert!(values[0] < values[2]);
            assert!(scale.ticks(5).iter().all(|tick| tick.value.is_finite()), "{scale:?}");
        }
    }

    fn labels(scale: Scale, most: usize) -> Vec<String> {
        let ticks = scale.ticks(most);
        ticks.iter().map(|tick| tick.label.plain()).filter(|label| !label.is_empty()).collect()
    }

    #[test]
    fn ticks_are_round_numbers_of_the_unit_that_is_shown() {
        // A velocity of 0.4 m/s as the unit: ticks at full tenths of m/s, positioned on the scale.
        let scale = Scale::linear(0.0, 1.0).in_unit(0.4);
        assert_eq!(labels(scale, 4), ["0.0", "0.1", "0.2", "0.3", "0.4"]);
        let places: Vec<f64> = scale.ticks(4).iter().map(|tick| tick.value).collect();
        // The rounding errors of a multiplication and a division.
        for (place, expected) in places.iter().zip([0.0, 0.25, 0.5, 0.75, 1.0]) {
            assert!((place - expected).abs() <= 4.0 * f64::EPSILON, "{places:?}");
        }
        assert_eq!(labels(Scale::logarithmic(1.0, 100.0).in_unit(10.0), 4), ["10", "100", "1000"]);
    }

    #[test]
    fn ticks_are_few_and_finite_on_any_axis() {
        let extremes = [5e-324, 1e-310, 1e-300, 1e-5, 1.0, 1.0 + 1e-15, 1e5, 1e16, 2e16, 1e300, 1e308];
        for from in [f64::MIN, -1e-300, 0.0].into_iter().chain(extremes) {
            for to in extremes.into_iter().chain([f64::MAX]).filter(|to| *to > from) {
                let mut scales = vec![Scale::linear(from, to)];
                if from > 0.0 {
                    scales.push(Scale::logarithmic(from, to));
                }
                for scale in scales {
                    let ticks = scale.ticks(7);
                    assert!((2..=6000).contains(&ticks.len()), "{scale:?}: {}", ticks.len());
                    let labelled = labels(scale, 7).len();
                    assert!((1..=14).contains(&labelled), "{scale:?}: {labelled}");
                    for tick in ticks {
                        let unit = scale.unit(tick.value);
                        assert!((-0.01..=1.01).contains(&unit), "{scale:?} {tick:?} at {unit}");
                    }
                    assert!((from..=to).contains(&scale.value(0.5)), "{scale:?}");
                }
            }
        }
    }

    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(labels(Scale::linear(0.0, 1.0), 5), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(Scale::linear(-1.0, 3.0), 4), ["−1", "0", "1", "2", "3"]);
        assert_eq!(labels(Scale::logarithmic(0.1, 10.0), 5), ["0.1", "1", "10"]);
        assert_eq!(labels(Scale::logarithmic(1e-9, 1e-3), 3), ["10⁻⁹", "10⁻⁶", "10⁻³"]);
        // A single number has an axis around it.
        assert!(labels(Scale::linear(2.0, 2.0), 4).contains(&"2.0".to_owned()));
        assert!(labels(Scale::logarithmic(0.5, 0.5), 4).contains(&"0.5".to_owned()));
    }

    #[test]
    fn scales_go_there_and_back() {
        for scale in [Scale::linear(-2.0, 5.0), Scale::logarithmic(1e-3, 20.0)] {
            for unit in [0.0, 0.3, 1.0] {
                // Two roundings of numbers near 1.
                assert!((scale.unit(scale.value(unit)) - unit).abs() < 1e-14);
            }
        }
    }
}
