//! A part of the turn on which p' is one polynomial.

use super::arithmetic::{apply, dot, first, turned};
use slipmap_numbers::Aligned;
use slipmap_numbers::TimesPlus as _;
use slipmap_numbers::elementary::sin_cos;
use slipmap_numbers::gauss::{MOST, Rule};

/// Values at the nodes.
type Values = Aligned<MOST>;

/// A part of the turn on which p' is one polynomial.
#[derive(Clone, Debug, Default)]
pub(super) struct Element {
    /// Number of the law's piece.
    pub(super) piece: usize,
    pub(super) middle: f64,
    /// Half its width.
    pub(super) half: f64,
    pub(super) cos: Values,
    pub(super) sin_cos: Values,
    pub(super) sin_squared: Values,
    /// p at the nodes, and at the end.
    pub(super) log_r: Values,
    pub(super) end: f64,
    /// p' at the nodes.
    pub(super) slope: Values,
    /// p' after the step of Newton's method, without dC and by dC; while it is prepared, g and dg/dC.
    pub(super) next: Values,
    pub(super) by_damping: Values,
    /// dg/dp, and the residual g - p'.
    pub(super) a: Values,
    pub(super) rho: Values,
}

impl Element {
    pub(super) fn new(piece: usize) -> Self {
        Self { piece, ..Self::default() }
    }

    /// Moves it to this `middle`, which has the sine and cosine `at_middle`, with this half of its width.
    #[inline(always)]
    pub(super) fn place<const N: usize>(
        &mut self,
        rule: &Rule<N>,
        middle: f64,
        half: f64,
        at_middle: [f64; 2],
    ) {
        // An element without width gives no derivative of p'.
        if self.half > 0.0 && (middle, half) != (self.middle, self.half) {
            let bend = apply(&rule.derivative, &first(&self.slope));
            for (j, bend) in bend.into_iter().enumerate() {
                // Extrapolation is limited to half of the old half-width.
                let shift = (half - self.half).times_plus(rule.nodes[j], middle - self.middle) / self.half;
                self.slope[j] += bend * shift.clamp(-0.5, 0.5);
            }
        }
        (self.middle, self.half) = (middle, half);
        for j in 0..N {
            let [sin, cos] = turned(at_middle, sin_cos(half * rule.nodes[j]));
            (self.cos[j], self.sin_cos[j], self.sin_squared[j]) = (cos, sin * cos, sin * sin);
        }
    }

    /// Integrates p' from the value `start` of p at the beginning; returns p at the end.
    #[inline(always)]
    pub(super) fn integrate<const N: usize>(&mut self, rule: &Rule<N>, start: f64) -> f64 {
        let slope = first::<N>(&self.slope);
        let rise = apply(&rule.antiderivative, &slope);
        for (log_r, rise) in self.log_r.iter_mut().zip(rise) {
            *log_r = self.half.times_plus(rise, start);
        }
        self.end = self.half.times_plus(dot(&rule.weights, &slope), start);
        self.end
    }
}
