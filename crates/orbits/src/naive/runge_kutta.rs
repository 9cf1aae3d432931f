//! The integrators of the naive methods: the classical Runge-Kutta step and adaptive steps like those of
//! `ode45` and `solve_ivp`.

use slipmap_model::flow::Failure;
use slipmap_numbers::TimesPlus as _;

/// A state (x1, x2).
pub(super) type State = [f64; 2];

/// Nodes and rows of the Dormand-Prince 5(4) pair; the last row is the solution of order 5.
const ROWS: [&[f64]; 6] = [
    &[1.0 / 5.0],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
    &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
    &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];

/// Solution of order 5 less that of order 4.
const ERROR: [f64; 7] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0];

#[inline]
fn moved(state: &State, h: f64, weights: &[f64], slopes: &[State]) -> State {
    let sum = |i: usize| weights.iter().zip(slopes).map(|(weight, slope)| weight * slope[i]).sum::<f64>();
    [h.times_plus(sum(0), state[0]), h.times_plus(sum(1), state[1])]
}

/// A step of the classical method of order 4.
pub(super) fn classical(state: &State, h: f64, field: &mut impl FnMut(&State) -> State) -> State {
    let k1 = field(state);
    let k2 = field(&moved(state, 0.5 * h, &[1.0], &[k1]));
    let k3 = field(&moved(state, 0.5 * h, &[1.0], &[k2]));
    let k4 = field(&moved(state, h, &[1.0], &[k3]));
    moved(state, h / 6.0, &[1.0, 2.0, 2.0, 1.0], &[k1, k2, k3, k4])
}

/// A step of order 5 and the estimate of its local error.
pub(super) fn dormand_prince(
    state: &State,
    h: f64,
    field: &mut impl FnMut(&State) -> State,
) -> (State, State) {
    let mut slopes = [[0.0; 2]; 7];
    slopes[0] = field(state);
    let mut next = *state;
    for (stage, row) in ROWS.iter().enumerate() {
        next = moved(state, h, row, &slopes);
        slopes[stage + 1] = field(&next);
    }
    (next, moved(&[0.0; 2], h, &ERROR, &slopes))
}

/// Step size control as in `solve_ivp`: the error in units of tolerance (1 + |x|), in the mean square of the
/// components, may not exceed 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Control {
    tolerance: f64,
    /// Order of the error estimate plus one.
    exponent: f64,
    /// The step to try next.
    pub(super) step: f64,
}

impl Control {
    /// Control of a pair whose error estimate falls like the power `exponent` of the step.
    pub(super) fn new(tolerance: f64, exponent: f64) -> Self {
        Self { tolerance, exponent, step: 1e-3 }
    }

    /// Decides whether a step of length `h` is accurate enough, and sets the next step.
    ///
    /// # Errors
    /// The step size underflows, or the error is not a number.
    pub(super) fn accepts(
        &mut self,
        h: f64,
        [from, to]: [&State; 2],
        error: &State,
        time: f64,
    ) -> Result<bool, Failure> {
        let part = |i: usize| error[i] / (self.tolerance * (1.0 + from[i].abs().max(to[i].abs())));
        let norm = (0.5 * (part(0) * part(0) + part(1) * part(1))).sqrt();
        if norm.is_nan() {
            return Err(Failure::NotFinite);
        }
        let factor = (0.9 * norm.powf(-1.0 / self.exponent)).clamp(0.2, 10.0);
        let accepted = norm < 1.0;
        self.step = h * if accepted { factor } else { factor.min(1.0) };
        if !accepted && self.step <= 10.0 * f64::EPSILON * time.abs().max(1.0) {
            return Err(Failure::StepUnderflow);
        }
        Ok(accepted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Error after one turn of the harmonic oscillator in `steps` steps.
    fn turn(steps: u32, mut step: impl FnMut(&State, f64) -> State) -> f64 {
        let h = std::f64::consts::TAU / f64::from(steps);
        let end = (0..steps).fold([1.0, 0.0], |state, _| step(&state, h));
        (end[0] - 1.0).hypot(end[1])
    }

    fn harmonic(x: &State) -> State {
        [x[1], -x[0]]
    }

    #[test]
    fn orders_are_four_and_five() {
        // On halving the step the error must fall by about 2^order.
        let order = |errors: [f64; 2]| (errors[0] / errors[1]).log2();
        let classical_order = order([40, 80].map(|n| turn(n, |x, h| classical(x, h, &mut harmonic))));
        assert!((3.8..4.3).contains(&classical_order), "{classical_order}");
        let pair = |n| turn(n, |x, h| dormand_prince(x, h, &mut harmonic).0);
        let pair_order = order([20, 40].map(pair));
        assert!((4.7..5.6).contains(&pair_order), "{pair_order}");
        // The estimate of the local error must fall by 2^5, one power more than the order of the lower
        // solution.
        let estimate = |h: f64| {
            let error = dormand_prince(&[0.6, 0.8], h, &mut harmonic).1;
            error[0].hypot(error[1])
        };
        let estimate_order = order([0.2, 0.1].map(estimate));
        assert!((4.7..5.3).contains(&estimate_order), "{estimate_order}");
    }
}
