//! Common simulation methods, each as in its literature. They are included to be measured, not trusted.
//!
//! * `smoothed` replaces sign(s) by tanh(s/d), d the knob `smoothing_width`, and integrates by adaptive
//!   Runge-Kutta 5(4). The mass sticks where |x2 - V| <= 5 d and |x1 + eps c x2| < 1. Known defect: a bias of
//!   O(d) in x2, hence of O(d / (eps V)) in the critical damping.
//! * `stick_band` is the switch model of stick, transition and slip by |x2 - V| < eta, eta the knob
//!   `stick_band_width`, integrated alike without events. The mass sticks in the stick branch. Known defects:
//!   steps jump the band, and the band catches what passes below the belt.
//! * `fixed_step` integrates the field with sign(x2 - V), where sign(0) = 0, by classical Runge-Kutta with
//!   steps of the knob `step`, h. The mass sticks where the belt line is met within a step and |x1 + eps c
//!   x2| < 1. Known defect: chatter of size O(h) on the belt, so that the orbit leaves the belt off the exit
//!   point.
//! * `event_step` integrates the field of the side on which the orbit was last seen by Dormand-Prince 8(5,3)
//!   with large steps. The mass sticks where x2 - V changed its sign between the ends of a step, and
//!   |x1 + eps c V| < 1 there. Known defects: two crossings inside one step go unseen; the start at a
//!   tangency needs a pause, the knob `start_pause`, which hides short arcs.
//!
//! Sources: for `smoothed` and `stick_band` R. I. Leine, D. H. van Campen, A. de Kraker and L. van den Steen,
//! *Stick-slip vibrations induced by alternate friction models*, Nonlinear Dynamics 16 (1998), whose
//! smoothing is (2/pi) arctan(s/d) where codes written since mostly take tanh; for `fixed_step` any
//! textbook; for `event_step` the event rule of SciPy's `solve_ivp` and of MATLAB's `ode45`.
//!
//! **Verdict.** These methods do not use the exit point, so all but `event_step` start where the mass sticks,
//! in the middle of the stick segment. The orbit is followed for `turns` turns, counted by x2 falling
//! through zero; it stick-slips if it still sticks in the last of them, that is, if it has met the belt
//! within the limits of static friction. An orbit that does not turn (an overdamped one) is given the time
//! that as many stick-slip cycles could take, and must stick in the second half of it. `event_step` switches
//! between the exact stick phase and slipping, so it starts at the exit point, and its verdict is that of the
//! first return.

mod event_step;
mod followed;
mod runge_kutta;

use slipmap_model::filippov::Oscillator;
use slipmap_model::flow::Failure;
use slipmap_numbers::named;

named! {
    /// A naive method, with its name in configurations and map files.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum NaiveMethod {
        /// Friction smoothed by tanh.
        Smoothed => "smoothed",
        /// The switch model with a band of slip speeds that counts as sticking.
        StickBand => "stick_band",
        /// Fixed steps of the discontinuous field.
        FixedStep => "fixed_step",
        /// Events by change of sign between the ends of large steps.
        EventStep => "event_step",
    }
}

/// The parameters that the methods leave to their user, on which their verdicts depend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NaiveKnobs {
    /// Width d of tanh(s/d), a velocity.
    pub smoothing_width: f64,
    /// Half width eta of the band |x2 - V| < eta that counts as sticking, a velocity.
    pub stick_band_width: f64,
    /// Step h of `fixed_step`, a time.
    pub step: f64,
    /// Target relative and absolute error per step of the adaptive integrators.
    pub tolerance: f64,
    /// Longest step of the adaptive integrators, a time; infinite if it is not limited, as is usual.
    pub longest_step: f64,
    /// Number of turns after which the orbit is taken to have settled, at least 1.
    pub turns: u32,
    /// Time after a start on the belt line during which `event_step` ignores events. At 0 the start itself is
    /// an event.
    pub start_pause: f64,
}

impl Default for NaiveKnobs {
    /// Values found in published codes for oscillators of unit mass and stiffness: 1e-3 for smoothing, 1e-4
    /// for the band, 1e-8 for both tolerances; some 600 fixed steps per turn; 20 turns.
    fn default() -> Self {
        Self {
            smoothing_width: 1e-3,
            stick_band_width: 1e-4,
            step: 1e-2,
            tolerance: 1e-8,
            longest_step: f64::INFINITY,
            turns: 20,
            start_pause: 0.1,
        }
    }
}

/// The verdict of a naive method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NaiveVerdict {
    /// The orbit stick-slips.
    Sticks {
        /// The last time between leaving the belt and sticking to it, by the method's own detection.
        slip_time: f64,
        /// The last time between two falls of x2 through zero, or for `event_step` of slip and stick; `None` if there were
        /// not two.
        period: Option<f64>,
    },
    /// It slips, or crosses the belt line, all the time.
    NeverSticks,
    /// No answer.
    Failed(Failure),
}

/// The result of following an orbit.
type Followed = Result<NaiveVerdict, Failure>;

/// The answer of a naive method, and its cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NaiveAnswer {
    /// The verdict.
    pub verdict: NaiveVerdict,
    /// Number of evaluations of the right-hand side.
    pub rhs: u64,
}

/// Largest number of evaluations of the right-hand side of the Stribeck law: a hundred times the cost of
/// the default parameters at moderate parameters of the oscillator, a third of a second.
const RHS_BUDGET: u64 = 6_000_000;

/// Largest number of evaluations of the right-hand side for this oscillator.
fn rhs_budget(oscillator: &Oscillator) -> u64 {
    RHS_BUDGET / oscillator.curve.cost()
}

impl NaiveMethod {
    /// One phrase for legends and `long_name`.
    pub fn long_name(self) -> &'static str {
        match self {
            NaiveMethod::Smoothed => "orbit of the oscillator with friction smoothed by tanh",
            NaiveMethod::StickBand => "orbit of the switch model with a stick band",
            NaiveMethod::FixedStep => "orbit by fixed Runge-Kutta steps of the discontinuous field",
            NaiveMethod::EventStep => "orbit by large steps with events at their ends",
        }
    }

    /// What the method computes, in a few words.
    pub fn equation(self) -> &'static str {
        match self {
            NaiveMethod::Smoothed => "sign(x2 - V) replaced by tanh((x2 - V)/d)",
            NaiveMethod::StickBand => "Leine et al. 1998: |x2 - V| < eta counts as sticking",
            NaiveMethod::FixedStep => "classical Runge-Kutta with sign(x2 - V)",
            NaiveMethod::EventStep => "event: x2 - V changes its sign between the ends of a step",
        }
    }

    /// Runs the method on one oscillator. It uses at most 6 million evaluations of the right-hand side,
    /// fewer for laws that are more expensive (see `Curve::cost`).
    #[must_use]
    pub fn decide(self, oscillator: &Oscillator, knobs: &NaiveKnobs) -> NaiveAnswer {
        let mut rhs = 0;
        let result = match self {
            NaiveMethod::Smoothed => followed::smoothed(oscillator, knobs, &mut rhs),
            NaiveMethod::StickBand => followed::stick_band(oscillator, knobs, &mut rhs),
            NaiveMethod::FixedStep => followed::fixed_step(oscillator, knobs, &mut rhs),
            NaiveMethod::EventStep => event_step::decide(oscillator, knobs, &mut rhs),
        };
        NaiveAnswer { verdict: result.unwrap_or_else(NaiveVerdict::Failed), rhs }
    }
}

/// A time sufficient for `turns` stick-slip cycles: a turn takes about 2 pi, sticking at most 2/V.
fn enough_time(oscillator: &Oscillator, turns: u32) -> f64 {
    f64::from(turns) * (2.0 * std::f64::consts::TAU + 2.0 / oscillator.belt_speed)
}
