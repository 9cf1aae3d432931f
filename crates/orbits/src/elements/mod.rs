//! The damping at which the orbit of a given amplitude closes, for every friction law, by Newton's method for
//! the whole orbit at once.
//!
//! In the polar form of `polar` an orbit through the maximum `radius` of x2 is a function p =
//! ln(r / radius) of the angle with
//!
//! ```text
//! p' = g(th, p; C) = D sin^2 th / (1 + D sin th cos th),   D = w(V - radius e^p cos th) - C,   p(0) = 0
//! ```
//!
//! and, for one C, p(2 pi) = 0. The turn is cut into elements, and p' is a polynomial on each, with p' = g at
//! Gauss's nodes. A step of Newton's method solves the linear equation for (dp, dC) by the integrating factor
//! exp(A), A the integral of a = dg/dp. The first iterate is the circle p = 0, with C the mean of w with the
//! weight sin^2.
//!
//! **Elements.** The weakening rate is compiled to polynomials on pieces of slip speeds ([`Weakening`]).
//! Elements end where the orbit passes from one piece to the next, so that g is smooth on each, at the
//! corners of a measured law too. The slip speed rises on (0, pi) and falls on (pi, 2 pi), since x2' = -r
//! sin th: the orbit passes each end of a piece at most once on either side. These angles follow the orbit
//! from step to step. The error of an angle has an effect of second order only, because w is continuous.
//!
//! **Error of the iteration.** Let rho = g - p' be the residual of an iterate. To first order its C is wrong
//! by the mean of W rho over that of W dg/dC, W = exp(-A). The sum of the sizes, which cannot vanish by
//! chance, stands for the first.
//!
//! **Error of the elements.** The method is Gauss's collocation, whose error at the end of the turn is that
//! of a product of two functions that each are resolved to first order. Two indicators are added: twice the
//! change of C from the last, coarser elements; and the square of the error that their polynomials leave
//! between their nodes, which cannot vanish by chance. Both are errors of the coarser elements. Twice as many
//! nodes have twice the order. From the first rung to the second their power 3/2, with a factor, is therefore
//! a sufficient estimate where the largest |w| is at most 1.
//!
//! **Error of corners.** The end of an element may lie off the corner of a measured law. Then w is wrong by
//! at most the jump of its slope times that distance, over the angles between, and so is C with the weight
//! sin^2.
//!
//! **Error of the form.** The bound of the law's polynomials (theory, "One form for every law").

mod arithmetic;
mod element;
mod orbit;

use std::sync::LazyLock;

use super::polar::Closing;
use orbit::{Orbit, Problem, Step};
use slipmap_model::friction::Weakening;
use slipmap_numbers::gauss::{MOST, Rule};
use slipmap_numbers::vectorized;

/// Residual, as an error of C in units of the largest |w|, from which the iteration does not recover.
const HOPELESS: f64 = 10.0;
/// Distance from the border of the domain of the polar form from which the iteration does not recover.
const FARTHEST_OUTSIDE: f64 = -0.3;
/// Error of C, in units of the largest |w|, below which the steps converge quadratically.
const NEAR: f64 = 0.03;
/// Safety factor of the error predicted from quadratic convergence.
const PREDICTION: f64 = 10.0;
/// Nodes per element, and the parts into which each element of the rung before is cut.
const LADDER: [(usize, usize); 5] = [(4, 1), (8, 1), (8, 2), (8, 2), (8, 2)];
/// Error of C on the first rungs, in units of the largest |w|, below which the iteration gains nothing.
const FLOORS: [f64; 2] = [1e-6, 1e-10];
/// Error of C, in units of the largest |w|, that the finest rung may leave where less is requested.
pub(super) const WORST: f64 = 1e-8;
/// Largest |w| for which the second rung is trusted to converge faster than the first.
const LARGEST_WITH_ORDER: f64 = 1.0;
/// Smallest tolerance for which that faster convergence is used: for smaller ones a further rung costs little
/// of what the answer is for.
const FINEST_WITH_ORDER: f64 = 1e-8;
/// The error of the second rung is at most this times the power 3/2 of the first rung's, in units of the
/// largest |w|: of random tables and formulas it was at most 0.8 times that power.
const ORDER_FACTOR: f64 = 10.0;
/// Largest accepted distance of the end of a span from the orbit's passage, in units of the narrower piece.
const OFF: f64 = 0.02;
/// Largest accepted error of C by a corner, in units of the tolerance times the largest |w|.
const OFF_AT_CORNERS: f64 = 1e-3;
/// Safety factor of the error by misplaced corners.
const MISPLACED: f64 = 2.0;
/// Error of dC / d ln r, in units of the last step of C, not yet in it: the value for orbits on which D is
/// small.
const SLOPE_BY_CHANGE: f64 = 2.0;
/// Largest number of elements.
const MOST_ELEMENTS: usize = 1 << 15;
/// Number of evaluations after which no further steps begin: more than twice those of an orbit with thousands
/// of elements.
const MOST_EVALUATIONS: u64 = 1 << 18;
/// Largest number of steps of Newton's method on one rung; four are usual on the first, two on the others.
const MOST_STEPS: usize = 15;
/// Round-off of C, in units of the largest weakening rate on the orbit: sums of some hundred terms of that
/// size with random signs of error.
const ROUND_OFF: f64 = 8.0 * f64::EPSILON;

static RULES: LazyLock<(Rule<4>, Rule<8>)> = LazyLock::new(|| (Rule::gauss(), Rule::gauss()));

/// Values at the nodes of an element as a sum of those at the nodes of the element that contains it, one
/// matrix for each part, `[k][j]` as in [`Rule`]; for each rung but the first.
static TRANSFERS: LazyLock<Vec<Vec<[[f64; MOST]; MOST]>>> = LazyLock::new(|| {
    let nodes = |size: usize| match size {
        4 => RULES.0.nodes.to_vec(),
        _ => RULES.1.nodes.to_vec(),
    };
    let interpolate = |size: usize, values: &[f64; MOST], x: f64| match size {
        4 => RULES.0.interpolate(values, x),
        _ => RULES.1.interpolate(values, x),
    };
    let matrix = |from: usize, to: usize, part: usize, parts: usize| {
        let mut matrix = [[0.0; MOST]; MOST];
        for (k, row) in matrix.iter_mut().enumerate().take(from) {
            let mut unit = [0.0; MOST];
            unit[k] = 1.0;
            for (value, x) in row.iter_mut().zip(nodes(to)) {
                let inside = (2.0 * part as f64 + 1.0 + x) / parts as f64 - 1.0;
                *value = interpolate(from, &unit, inside);
            }
        }
        matrix
    };
    LADDER
        .windows(2)
        .map(|rungs| {
            let [(from, _), (to, parts)] = [rungs[0], rungs[1]];
            (0..parts).map(|part| matrix(from, to, part, parts)).collect()
        })
        .collect()
});

/// Result of [`solve_rung`].
struct Solved {
    /// Error left by the iteration.
    left: f64,
    /// Error of the iterate at the start.
    left_at_first: f64,
    /// dC / d ln r before the last step, and before the first of several.
    slope: f64,
    slope_at_first: Option<f64>,
    /// The last change of C.
    change: f64,
    rhs: u64,
}

/// Newton steps on one rung, until the error of C is `enough` times `unit`, the largest |w|, which is found on the
/// circle. `transfers` are the matrices from the orbit of the rung before to this one; `None` where it starts from
/// the circle. `Err` with the number of evaluations where there is no solution.
#[inline(always)]
fn solve_rung<const N: usize>(
    orbit: &mut Orbit<'_>,
    rule: &Rule<N>,
    transfers: Option<&[[[f64; MOST]; MOST]]>,
    enough: f64,
    unit: &mut f64,
) -> Result<Solved, u64> {
    if let Some(transfers) = transfers {
        orbit.refine(transfers);
        orbit.place(rule);
        return orbit.newton(rule, enough, *unit);
    }
    *unit = orbit.start(rule);
    let spent = orbit.cost::<N>();
    match orbit.newton(rule, enough, *unit) {
        Ok(solved) => Ok(Solved { rhs: spent + solved.rhs, ..solved }),
        Err(rhs) => Err(spent + rhs),
    }
}

impl Orbit<'_> {
    /// Steps of Newton's method until the error of C that is left is `tolerance` times `unit`; `Err` with the
    /// number of evaluations where it is not reached.
    #[inline(always)]
    fn newton<const N: usize>(&mut self, rule: &Rule<N>, tolerance: f64, unit: f64) -> Result<Solved, u64> {
        let enough = (0.1 * tolerance + ROUND_OFF) * unit;
        let mut rhs = 0;
        let mut left_at_first = f64::NAN;
        let mut first: Option<Step> = None;
        let kinked = !self.problem.weakening.corners().is_empty();
        let (mut before, mut moved, mut is_rough) = (f64::NAN, false, false);
        for steps in 0..MOST_STEPS {
            let step = self.step(rule);
            rhs += self.cost::<N>();
            if steps == 0 {
                left_at_first = step.left;
            }
            let whole = self.advance(rule, step.change);
            // From here the iteration does not recover.
            let lost = step.left > HOPELESS * unit || step.room < FARTHEST_OUTSIDE;
            if lost || !self.viscous.is_finite() {
                return Err(rhs);
            }
            // Where the law has corners, the ends of spans are checked below. A step after they have moved
            // overestimates the curvature.
            if before < NEAR * unit && (kinked || !moved) {
                let curvature = step.left / (before * before);
                let is_first = is_rough || self.curvature == 0.0;
                self.curvature = match moved {
                    true if self.curvature > 0.0 => self.curvature,
                    false if !is_first => self.curvature.max(curvature),
                    _ => curvature,
                };
                is_rough = moved && is_first;
            }
            // The error left after the step.
            let after = PREDICTION * self.curvature * step.left * step.left;
            let is_predicted = self.curvature > 0.0 && (kinked || !moved) && step.left < NEAR * unit;
            let left = if is_predicted { after.min(step.left) } else { step.left };
            let settled = whole && left <= enough;
            before = step.left;
            moved = (kinked || !settled) && self.follow(OFF, OFF_AT_CORNERS * tolerance * unit).ok_or(rhs)?;
            if settled && !moved {
                let slope_at_first = first.map(|first| first.slope());
                let solved = Solved {
                    left,
                    left_at_first,
                    slope: step.slope(),
                    slope_at_first,
                    change: step.change,
                    rhs,
                };
                return if step.room > 0.0 { Ok(solved) } else { Err(rhs) };
            }
            if moved {
                self.place(rule);
            }
            first = first.or(Some(step));
        }
        Err(rhs)
    }
}

/// A closed orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closed {
    /// The C at which it closes.
    pub closing: Closing,
    /// -x2 at the lowest point of the orbit.
    pub depth: f64,
}

/// The C at which the orbit through the maximum `radius` of x2, 0 < `radius` <= V, closes, with an error of
/// at most `tolerance` in units of the largest |w|; `Err` with the number of evaluations where the polar
/// form does not apply or no rung reaches that.
pub fn closed_orbit(
    weakening: &Weakening,
    belt_speed: f64,
    radius: f64,
    tolerance: f64,
) -> Result<Closed, u64> {
    let farthest = belt_speed + radius;
    if !(farthest <= weakening.reach() && weakening.is_resolved(belt_speed - radius, farthest)) {
        return Err(0);
    }
    let (four, eight) = &*RULES;
    let mut orbit = Orbit::circle(Problem { weakening, belt_speed, radius });
    let mut unit = 0.0;
    let mut rhs = 0;
    let mut before: Option<[f64; 2]> = None;
    for (rung, (nodes, parts)) in LADDER.into_iter().enumerate() {
        if orbit.elements.len() * parts > MOST_ELEMENTS || rhs > MOST_EVALUATIONS {
            return Err(rhs);
        }
        let transfers = before.map(|_| &TRANSFERS[rung - 1][..]);
        let enough = tolerance.max(FLOORS.get(rung).copied().unwrap_or(0.0));
        let solved = match nodes {
            4 => vectorized(
                #[inline(always)]
                || solve_rung(&mut orbit, four, transfers, enough, &mut unit),
            ),
            _ => vectorized(
                #[inline(always)]
                || solve_rung(&mut orbit, eight, transfers, enough, &mut unit),
            ),
        };
        let solved = solved.map_err(|spent| rhs + spent)?;
        let Solved { left, left_at_first, slope, slope_at_first, change, rhs: spent } = solved;
        rhs += spent;
        let viscous = orbit.viscous;
        if let Some([before, slope_before]) = before {
            let coarser = 2.0 * (viscous - before).abs() + left_at_first * left_at_first / unit;
            // These are the errors of half as many nodes, whose order is half that of the present ones.
            let uncertain = match rung {
                1 if unit <= LARGEST_WITH_ORDER && tolerance >= FINEST_WITH_ORDER => {
                    coarser.min(ORDER_FACTOR * coarser * (coarser / unit).sqrt())
                }
                _ => coarser,
            };
            let last = rung + 1 == LADDER.len() || orbit.elements.len() > MOST_ELEMENTS / 2;
            let allowed = if last { tolerance.max(WORST) } else { tolerance + 4.0 * ROUND_OFF };
            if uncertain <= allowed * unit {
                let form = weakening.error(belt_speed - radius, belt_speed + orbit.depth()).bound();
                // Orbits that follow the law itself are more accurate then.
                if !(form <= tolerance.max(WORST) * unit) {
                    return Err(rhs);
                }
                let misplaced = orbit.misplaced().map(|error| MISPLACED * error);
                let error = uncertain + left + misplaced[0] + ROUND_OFF * unit + form;
                // The errors by the elements, by the last step, by corners in the weights, and of C.
                let coarser = (slope - slope_at_first.unwrap_or(slope_before)).abs();
                let slope_error =
                    coarser + SLOPE_BY_CHANGE * change.abs() + misplaced[1] * slope.abs() + error;
                let closing = Closing { viscous, error, rhs, slope: Some([slope, slope_error]) };
                return Ok(Closed { closing, depth: orbit.depth() });
            }
        }
        before = Some([viscous, slope]);
    }
    Err(rhs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_model::friction::{Expression, Law};
    use slipmap_model::point::LawParameters;

    /// Where a formula was not compiled well enough its polynomials have no closed orbit: the law itself is
    /// followed.
    #[test]
    fn polynomials_that_miss_the_law_have_no_closed_orbit() {
        let law = Law::Expression(Expression::new("1 - 0.3*tanh(2*u) + 0.01*u^2", 1.0).unwrap());
        let compiled = law.curve(1.0, &LawParameters::new(&[])).compiled(4.0);
        let of_error =
            |error: f64| closed_orbit(&Weakening::clone(&compiled).with_error(error), 1.0, 0.8, 1e-10);
        let exact = closed_orbit(&compiled, 1.0, 0.8, 1e-10).unwrap().closing;
        // An error within the tolerance is part of that of the orbit.
        let closing = of_error(1e-11).unwrap().closing;
        assert!((closing.viscous - exact.viscous).abs() < 1e-15 && closing.error >= 1e-11, "{closing:?}");
        for error in [1e-7, 1e-5, 1e-3] {
            assert!(of_error(error).is_err(), "{error}");
        }
    }
}
