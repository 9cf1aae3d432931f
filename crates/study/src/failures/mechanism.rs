//! The mechanisms by which methods fail (theory, "Where methods fail"), and their attribution.

use super::FailureKind;
use slipmap_certify::{Claim, Decision};
use slipmap_column::{Method, Verdict};
use slipmap_model::filippov::Oscillator;
use slipmap_model::flow::{Failure, Fate};
use slipmap_model::friction::Column;
use slipmap_orbits::naive::{NaiveKnobs, NaiveMethod};

/// The cause of a failure of a method at a cell, which [`Mechanism::explanation`] explains.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mechanism {
    FirstOrderInEps,
    Circle,
    Node,
    Overshoot,
    Smoothing,
    StickBand,
    Chatter,
    /// The orbit is above the belt line, or inside the stick band, for less than a step, and both crossings
    /// are missed.
    MissedDoubleCrossing,
    TangentStart,
    Transient,
    StepError,
    /// The test claims nothing about the column: a test of first order in eps where the law does not depend on it.
    NoClaim,
    OneSided,
    Gap,
    LandingUnproved,
    Breakdown(Failure),
    Unexplained,
}

impl Mechanism {
    /// The name of the mechanism, and the explanation of a failure by it.
    fn words(self) -> (&'static str, &'static str) {
        use Mechanism::*;
        match self {
            FirstOrderInEps => {
                ("first_order_in_eps", "the condition is of first order in eps, and eps is finite here")
            }
            Circle => ("circle", "energy is balanced along a circle, and the orbit is not quite one"),
            Node => ("node", "|D| reaches 2 along the orbit, which is far from a circle and may never turn"),
            Overshoot => ("overshoot", "the orbit lands beyond the stick segment and crosses for ever"),
            Smoothing => (
                "smoothing",
                "within a few widths d of the belt line smoothed friction neither holds nor lets go",
            ),
            StickBand => (
                "stick_band",
                "the stick band is wider than the orbit's distance from the belt, or is left off the exit point",
            ),
            Chatter => ("chatter", "fixed steps chatter about the belt line and leave it off the exit point"),
            MissedDoubleCrossing => {
                ("missed_double_crossing", "the orbit is beyond the belt line for less than a step")
            }
            TangentStart => ("tangent_start", "events next to a start on the belt line are ignored"),
            Transient => ("transient", "the orbit has not settled in the turns it was given"),
            StepError => ("step_error", "errors of the adaptive steps add up to more than the margin"),
            NoClaim => ("no_claim", "the test says nothing about this law at this point"),
            OneSided => ("one_sided", "the test claims the other side only"),
            Gap => ("gap", "between the test's claims of presence and absence, or exactly where they meet"),
            LandingUnproved => (
                "landing_unproved",
                "the orbit comes back, but its landing on the stick segment is not proved",
            ),
            Breakdown(Failure::StepBudget) => ("breakdown_step_budget", "the step budget ran out"),
            Breakdown(Failure::Quota) => ("breakdown_quota", "the orbit takes more work than its quota"),
            Breakdown(Failure::StepUnderflow) => ("breakdown_step_underflow", "the step size underflowed"),
            Breakdown(Failure::NotFinite) => ("breakdown_not_finite", "the orbit left the finite numbers"),
            Unexplained => {
                ("unexplained", "no removal of a known defect that the step budget allows mends it")
            }
        }
    }

    pub fn name(self) -> &'static str {
        self.words().0
    }

    pub fn explanation(self) -> &'static str {
        self.words().1
    }
}

/// The mechanism by which `method` fails at damping `c` of a column, where the orbit has the given fate.
pub(super) fn of(method: Method, column: &Column, c: f64, kind: FailureKind, fate: &Fate) -> Mechanism {
    match method {
        Method::Test(test) if kind == FailureKind::Undecided => undecided(&test.claim(column), c),
        Method::Test(test) => of_test(test.name, column, c, kind, fate),
        Method::Simulation | Method::Direct => Mechanism::Unexplained,
        Method::Naive(naive, knobs) => {
            of_naive(naive, &knobs, &Oscillator::in_column(column, c), Verdict::from(fate))
        }
    }
}

/// The mechanism by which a claim leaves a cell undecided.
fn undecided(claim: &Claim, c: f64) -> Mechanism {
    if c < claim.present_below && c < claim.sticks_from {
        Mechanism::LandingUnproved
    } else if claim.present_below.is_infinite() && claim.absent_above.is_infinite() {
        Mechanism::NoClaim
    } else if claim.present_below.is_finite() && claim.absent_above.is_finite() {
        Mechanism::Gap
    } else {
        Mechanism::OneSided
    }
}

/// The mechanism by which a closed-form test answers wrongly.
fn of_test(name: &str, column: &Column, c: f64, kind: FailureKind, fate: &Fate) -> Mechanism {
    if *fate == Fate::CrossesForever {
        return Mechanism::Overshoot;
    }
    // The same test without the expansion in eps.
    let finite = match name {
        "perturbation" => Some(slipmap_certify::harmonic_balance::TEST),
        "bendixson_leading" => Some(slipmap_certify::bendixson::TEST),
        _ => None,
    };
    let mended = finite.is_some_and(|test| {
        let wrong = match kind {
            FailureKind::WrongPresence => Decision::Present,
            FailureKind::WrongAbsence | FailureKind::Undecided | FailureKind::Failed => Decision::Absent,
        };
        test.claim(column).decide(c) != wrong
    });
    let range = column.curve.weakening_range(0.0, 2.0 * column.belt_speed);
    let viscous = column.epsilon * c;
    if mended {
        Mechanism::FirstOrderInEps
    } else if (range.lo - viscous).abs().max((range.hi - viscous).abs()) >= 2.0 {
        Mechanism::Node
    } else if matches!(name, "perturbation" | "harmonic_balance") {
        Mechanism::Circle
    } else {
        Mechanism::Unexplained
    }
}

/// The mechanism by which a naive method answers wrongly or breaks down: the first of its defects without
/// which it is right.
fn of_naive(naive: NaiveMethod, knobs: &NaiveKnobs, oscillator: &Oscillator, truth: Verdict) -> Mechanism {
    let (n, d) = (*knobs, naive);
    // A grazing orbit is beyond the belt line for a time of a few times the square root of its margin: steps
    // of 1e-3 resolve this down to margins of 1e-7.
    let short = |n: NaiveKnobs| NaiveKnobs { longest_step: 1e-3, ..n };
    let transient = (Mechanism::Transient, NaiveKnobs { turns: n.turns.saturating_mul(10), ..n });
    let error = (Mechanism::StepError, NaiveKnobs { tolerance: (1e-4 * n.tolerance).max(1e-13), ..n });
    let removals: Vec<(Mechanism, NaiveKnobs)> = match d {
        NaiveMethod::Smoothed => {
            let finer = |by: f64| NaiveKnobs { smoothing_width: by * n.smoothing_width, ..n };
            let smoothing = [0.1, 0.01].map(|by| (Mechanism::Smoothing, finer(by)));
            smoothing.into_iter().chain([transient, error]).collect()
        }
        NaiveMethod::StickBand => {
            let finer = |by: f64| NaiveKnobs { stick_band_width: by * n.stick_band_width, ..n };
            vec![
                (Mechanism::MissedDoubleCrossing, short(n)),
                (Mechanism::StickBand, finer(0.01)),
                (Mechanism::StickBand, short(finer(0.01))),
                transient,
                error,
            ]
        }
        NaiveMethod::FixedStep => {
            let finer = |by: f64| (Mechanism::Chatter, NaiveKnobs { step: by * n.step, ..n });
            let finest = NaiveKnobs { step: 1e-3 * n.step, turns: n.turns.min(5), ..n };
            vec![finer(0.1), finer(0.01), (Mechanism::Chatter, finest), transient]
        }
        NaiveMethod::EventStep => vec![
            (Mechanism::TangentStart, NaiveKnobs { start_pause: 1e-9, ..n }),
            (Mechanism::MissedDoubleCrossing, short(n)),
            (Mechanism::MissedDoubleCrossing, NaiveKnobs { longest_step: 3e-5, turns: 1, ..n }),
            (Mechanism::TangentStart, short(NaiveKnobs { start_pause: 1e-9, ..n })),
            transient,
            error,
        ],
    };
    let mended = |knobs: &NaiveKnobs| Verdict::from(naive.decide(oscillator, knobs).verdict) == truth;
    let found = removals.iter().find(|(_, knobs)| mended(knobs)).map(|(mechanism, _)| *mechanism);
    found.unwrap_or_else(|| match naive.decide(oscillator, knobs).verdict {
        slipmap_orbits::naive::NaiveVerdict::Failed(failure) => Mechanism::Breakdown(failure),
        _ => Mechanism::Unexplained,
    })
}
