//! One step of the explicit Runge-Kutta method of Dormand and Prince, order 8, for planar systems.
//!
//! The coefficients are those of the program DOP853 in Hairer, Nørsett and Wanner, *Solving Ordinary
//! Differential Equations I*, 2nd ed. (Springer 1993), section II.10; the tests of this file check the
//! quadrature conditions and the order of both the step and its error estimate. The other engines have their
//! own table: this one shares nothing with them but the friction law.

/// A number stored as the unevaluated sum of two, so that thousands of small increments can be added with one
/// rounding error in all (Kahan; here with Knuth's two-sum, which needs no ordering).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Compensated {
    high: f64,
    low: f64,
}

impl Compensated {
    /// The sum rounded to one number.
    #[inline]
    pub(super) fn value(self) -> f64 {
        self.high
    }

    /// `self + increment`.
    #[inline]
    #[must_use]
    pub(super) fn plus(self, increment: f64) -> Self {
        let added = increment + self.low;
        let high = self.high + added;
        let kept = high - self.high;
        let low = (self.high - (high - kept)) + (added - kept);
        Self { high, low }
    }

    /// `self + increment`, rounded to one number.
    #[inline]
    fn offset(self, increment: f64) -> f64 {
        self.high + (increment + self.low)
    }
}

impl From<f64> for Compensated {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Increment {
    /// Increments of the two coordinates.
    pub(super) by: [f64; 2],
    /// Estimate of the local error in the Euclidean norm; it shrinks like the 8th power of the step.
    pub(super) error: f64,
}

/// A step of length `h` of z' = slope(z) from `start`, where the slope is `first`. It evaluates `slope`
/// eleven times.
///
/// # Errors
/// The error of `slope`, if it refuses one of the stages.
#[inline]
pub(super) fn step<E>(
    start: [Compensated; 2],
    first: [f64; 2],
    h: f64,
    mut slope: impl FnMut([f64; 2]) -> Result<[f64; 2], E>,
) -> Result<Increment, E> {
    let mut slopes = [first; 12];
    for (done, weights) in STAGES.iter().enumerate() {
        let mut by = [0.0; 2];
        for (stage, weight) in weights.iter().enumerate() {
            add(&mut by, *weight, slopes[stage]);
        }
        slopes[done + 1] = slope([start[0].offset(h * by[0]), start[1].offset(h * by[1])])?;
    }
    let [mut by, mut fifth, mut third] = [[0.0; 2]; 3];
    for (stage, weights) in WEIGHTS {
        add(&mut by, weights[0], slopes[stage]);
        add(&mut fifth, weights[1], slopes[stage]);
        add(&mut third, weights[2], slopes[stage]);
    }
    // Two embedded estimates, of orders 5 and 3, combined into one of the method's order.
    let fifth = fifth[0].hypot(fifth[1]);
    let mixed = fifth.hypot(0.1 * third[0].hypot(third[1]));
    let error = if mixed > 0.0 { h * fifth * (fifth / mixed) } else { 0.0 };
    Ok(Increment { by: [h * by[0], h * by[1]], error })
}

/// Adds a slope times its weight.
#[inline]
fn add(sum: &mut [f64; 2], weight: f64, slope: [f64; 2]) {
    sum[0] += weight * slope[0];
    sum[1] += weight * slope[1];
}

/// Root of the sum of squares of the first weights in [`WEIGHTS`]: how far independent rounding errors of the
/// slopes are amplified by a step of unit length.
pub(super) const ROUNDING_AMPLIFICATION: f64 = 7.57;

/// Weights of the earlier slopes in stages 2 to 12.
const STAGES: [&[f64]; 11] = [
    &[0.05260015195876773],
    &[0.0197250569845379, 0.0591751709536137],
    &[0.02958758547680685, 0.0, 0.08876275643042054],
    &[0.2413651341592667, 0.0, -0.8845494793282861, 0.924834003261792],
    &[0.037037037037037035, 0.0, 0.0, 0.17082860872947386, 0.12546768756682242],
    &[0.037109375, 0.0, 0.0, 0.17025221101954405, 0.06021653898045596, -0.017578125],
    &[
        0.03709200011850479,
        0.0,
        0.0,
        0.17038392571223998,
        0.10726203044637328,
        -0.015319437748624402,
        0.008273789163814023,
    ],
    &[
        0.6241109587160757,
        0.0,
        0.0,
        -3.3608926294469414,
        -0.868219346841726,
        27.59209969944671,
        20.154067550477894,
        -43.48988418106996,
    ],
    &[
        0.47766253643826434,
        0.0,
        0.0,
        -2.4881146199716677,
        -0.590290826836843,
        21.230051448181193,
        15.279233632882423,
        -33.28821096898486,
        -0.020331201708508627,
    ],
    &[
        -0.9371424300859873,
        0.0,
        0.0,
        5.186372428844064,
        1.0914373489967295,
        -8.149787010746927,
        -18.52006565999696,
        22.739487099350505,
        2.4936055526796523,
        -3.0467644718982196,
    ],
    &[
        2.273310147516538,
        0.0,
        0.0,
        -10.53449546673725,
        -2.0008720582248625,
        -17.9589318631188,
        27.94888452941996,
        -2.8589982771350235,
        -8.87285693353063,
        12.360567175794303,
        0.6433927460157636,
    ],
];

/// The slopes that have a weight, by number, with their weights in the result of order 8 and in the estimates
/// made with results of orders 5 and 3.
const WEIGHTS: [(usize, [f64; 3]); 8] = [
    (0, [0.054293734116568765, 0.01312004499419488, -0.18980075407240762]),
    (5, [4.450312892752409, -1.2251564463762044, 4.450312892752409]),
    (6, [1.8915178993145003, -0.4957589496572502, 1.8915178993145003]),
    (7, [-5.801203960010585, 1.6643771824549864, -5.801203960010585]),
    (8, [0.3111643669578199, -0.35032884874997366, -0.4226823213237919]),
    (9, [-0.1521609496625161, 0.3341791187130175, -0.1521609496625161]),
    (10, [0.20136540080403034, 0.08192320648511571, 0.20136540080403034]),
    (11, [0.04471061572777259, -0.022355307863886294, 0.02265179219836082]),
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    /// Nodes c of the stages: the sums of their weights.
    fn nodes() -> [f64; 12] {
        let mut nodes = [0.0; 12];
        for (node, weights) in nodes[1..].iter_mut().zip(STAGES) {
            *node = weights.iter().sum();
        }
        nodes
    }

    #[test]
    fn the_quadrature_conditions_hold_up_to_order_eight() {
        let nodes = nodes();
        assert!((nodes[11] - 1.0).abs() < 1e-13, "the last stage lies at the end of the step");
        for power in 0..8 {
            let moment = |which: usize| {
                WEIGHTS.iter().map(|(stage, weights)| weights[which] * nodes[*stage].powi(power)).sum::<f64>()
            };
            let [sum, fifth, third] = [0, 1, 2].map(moment);
            let exact = 1.0 / f64::from(power + 1);
            // The weights' magnitudes sum to 13, each rounded to 2^-53 of itself.
            assert!((sum - exact).abs() < 20.0 * f64::EPSILON, "power {power}: {sum}");
            // The order 5 and order 3 companions satisfy the first five and three conditions.
            assert!(power > 4 || fifth.abs() < 20.0 * f64::EPSILON, "power {power}: {fifth}");
            assert!(power > 2 || third.abs() < 20.0 * f64::EPSILON, "power {power}: {third}");
        }
        let amplification = WEIGHTS.iter().map(|(_, [b, ..])| b * b).sum::<f64>().sqrt();
        assert!((amplification - ROUNDING_AMPLIFICATION).abs() < 0.01);
    }

    /// A pendulum far from its linear range, so that every kind of order condition matters.
    fn pendulum([angle, speed]: [f64; 2]) -> Result<[f64; 2], Infallible> {
        Ok([speed, -angle.sin() - 0.1 * speed * speed])
    }

    fn swing(steps: u32) -> ([f64; 2], f64) {
        let h = 4.0 / f64::from(steps);
        let mut state = [Compensated::from(2.0), Compensated::from(0.5)];
        let mut error = 0.0;
        for _ in 0..steps {
            let here = state.map(Compensated::value);
            let by = step(state, pendulum(here).unwrap(), h, pendulum).unwrap();
            state = [state[0].plus(by.by[0]), state[1].plus(by.by[1])];
            error += by.error;
        }
        (state.map(Compensated::value), error)
    }

    #[test]
    fn error_and_estimate_fall_with_the_eighth_power() {
        let distance = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
        let (reference, _) = swing(160);
        let runs = [10, 20].map(swing);
        let errors = runs.map(|(end, _)| distance(end, reference));
        let order = (errors[0] / errors[1]).log2();
        assert!((7.3..9.5).contains(&order), "order {order} from errors {errors:?}");
        let estimate = (runs[0].1 / runs[1].1).log2();
        assert!((6.3..8.5).contains(&estimate), "the summed estimate falls with order {estimate}");
        for ((_, estimate), error) in runs.iter().zip(errors) {
            assert!(error < *estimate, "error {error:e} above its estimate {estimate:e}");
        }
    }

    #[test]
    fn compensation_keeps_what_plain_sums_lose() {
        let tenth = 0.1_f64;
        let sum = (0..1_000_000).fold(Compensated::default(), |sum, _| sum.plus(tenth));
        // 0.1 is stored 5.55e-18 too large; the sum of a million of them is 1e5 + 5.55e-12.
        assert!((sum.value() - 1e5).abs() <= 2e-11, "{}", sum.value() - 1e5);
    }
}
