//! The answers of every method about one point, and the simulated flow there.

use std::cell::OnceCell;

use super::result::BistableBand;
use crate::behaviour::needed_slip_speed;
use crate::method_answer::{MethodAnswer, of_test};
use crate::second_opinion::{Opinion, Witness};
use slipmap_certify::slip_count::{SlipCount, count_slip_cycles};
use slipmap_column::crossing::{CrossingCycles, crossing_cycles, stick_slip_cycle};
use slipmap_column::limits::{EpsilonLimit, NoEpsilonLimit, Ray};
use slipmap_column::sensitivity::{NoSensitivity, Sensitivity, sensitivity};
use slipmap_column::slip_cycle::CyclesUnknown;
use slipmap_column::{
    BasinBoundary, Behaviour, Change, ChangeKind, CriticalDamping, Method, NoCriticalDamping, Regime,
    SticksFrom, Verdict,
};
use slipmap_model::filippov::{HopfRate, Oscillator, Stability};
use slipmap_model::flow::{Failure, Fate, Flow};
use slipmap_model::friction::Law;
use slipmap_model::point::Point;
use slipmap_numbers::text::{rounded, short, signed, with_error};
use slipmap_orbits::Cycle;
use slipmap_orbits::far_loops::FarLoops;
use slipmap_orbits::naive::NaiveVerdict;

/// All answers except those of the second engine.
#[derive(Debug)]
pub struct Answer {
    /// The friction law.
    pub law: Law,
    /// The point.
    pub point: Point,
    /// Requested bound on the error of the scaled grazing margin of the simulation.
    pub tolerance: f64,
    /// The oscillator at the point.
    pub oscillator: Oscillator,
    /// One answer for each requested method.
    pub methods: Vec<MethodAnswer>,
    /// The flow by arcs and c*; too close to call where the direct engine contradicts it.
    pub flow: Flow,
    /// The flow that these told.
    pub told: Flow,
    /// How two engines contradict each other, if they do.
    pub contradiction: Option<String>,
    /// The exact critical damping; negative where no legal damping is small enough for a cycle.
    pub critical: Result<CriticalDamping, NoCriticalDamping>,
    /// The long-run behaviour.
    pub regime: Regime,
    /// The cycles that slip all the time below the belt line, by growing amplitude.
    pub slip: Result<Vec<Cycle>, CyclesUnknown>,
    /// The attracting cycle; `None` where there is none.
    pub cycle: Option<Cycle>,
    /// The edge of its basin; `None` where it attracts from every start.
    pub basin: Option<BasinBoundary>,
    /// See [`Self::changes`]; computed on first use.
    changes: OnceCell<Vec<Change>>,
    /// See [`Self::slip_count`]; computed on first use.
    slip_count: OnceCell<SlipCount>,
}

/// eps c that no answer distinguishes from 0.
const NO_DAMPING: f64 = 1e-9;

impl Answer {
    /// Computes the answers of `methods`.
    pub fn of(law: &Law, point: &Point, tolerance: f64, methods: impl Iterator<Item = Method>) -> Self {
        let column = law.column(point);
        let oscillator = Oscillator::new(law, point);
        let flow = slipmap_orbits::flow(&oscillator, tolerance);
        let critical = slipmap_column::critical_damping(&column, tolerance);
        let methods = methods
            .map(|method| match method {
                Method::Test(test) => of_test(test, &column, point.damping),
                Method::Simulation => of_simulation(law, point, &flow, &critical),
                Method::Direct => of_direct(law, point, slipmap_witness::flow(&oscillator, tolerance).fate),
                Method::Naive(naive, knobs) => {
                    of_naive(method, law, naive.decide(&oscillator, &knobs).verdict)
                }
            })
            .collect();
        let slipmap_column::LongRun { regime, slip, cycle, basin } =
            slipmap_column::long_run(&oscillator, &flow, tolerance);
        Self {
            law: law.clone(),
            point: *point,
            tolerance,
            oscillator,
            methods,
            told: flow,
            contradiction: None,
            flow,
            critical,
            regime,
            slip,
            cycle,
            basin,
            changes: OnceCell::new(),
            slip_count: OnceCell::new(),
        }
    }

    /// The answers of `methods`, and the flow of the direct engine. What that engine contradicts is not known.
    pub fn of_both_engines(
        law: &Law,
        point: &Point,
        tolerance: f64,
        methods: impl Iterator<Item = Method>,
    ) -> (Self, Flow) {
        // Its flow is told in full beside the methods.
        let methods = methods.filter(|method| *method != Method::Direct);
        let mut answer = Self::of(law, point, tolerance, methods);
        let oscillator = answer.oscillator.clone();
        let witness = Witness::of(&oscillator, tolerance);
        let direct = answer.heed(|told| {
            let (direct, opinion) = witness.asked_about(told);
            (*direct, opinion)
        });
        (answer, direct)
    }

    /// Leaves unknown what the `witness` contradicts, which tells its flow and what that says of a verdict.
    fn heed(&mut self, witness: impl Fn(Verdict) -> (Flow, Opinion)) -> Flow {
        let told = Verdict::from(&self.flow.fate);
        let (direct, opinion) = witness(told);
        // The verdict that c* promises.
        let off = self.critical.as_ref().map_or(0.0, |root| self.point.damping - root.c);
        let is_clear = self.critical.as_ref().is_ok_and(|root| off.abs() > root.error);
        let promised = if off < 0.0 { Verdict::Present } else { Verdict::Absent };
        let (by_critical, of_critical) = if is_clear { witness(promised) } else { (direct, Opinion::None) };
        // Below c* the orbit returns to the belt line, but need not stick.
        let is_promised = off < 0.0 && direct.fate == Fate::CrossesForever;
        let mut said = Vec::new();
        if is_clear && of_critical == Opinion::Contradicts && !is_promised {
            let Ok(root) = &self.critical else { return direct };
            said.push(format!("the critical damping is {}", with_error(root.c, root.error)));
            self.critical = Err(NoCriticalDamping::Contradicted);
        }
        let is_flow = told.is_decision() && opinion == Opinion::Contradicts;
        if is_flow {
            said.insert(0, format!("by its arcs the orbit from the exit point {}", words(&self.flow.fate)));
        }
        if said.is_empty() {
            return direct;
        }
        let by_direct = if is_flow { direct } else { by_critical };
        let reason = format!(
            "two engines contradict each other: {}; by the direct engine the orbit {}",
            said.join(", and "),
            words(&by_direct.fate)
        );
        for answer in self.methods.iter_mut().filter(|answer| answer.method == Method::Simulation) {
            answer.reason = Some(reason.clone());
            answer.verdict = Verdict::Undecided;
            if self.critical.is_err() {
                (answer.critical_c, answer.critical_c_error) = (None, None);
            }
        }
        self.contradiction = Some(reason);
        self.flow =
            Flow { fate: Fate::TooCloseToCall, margin: f64::NAN, margin_error: f64::NAN, ..self.flow };
        (self.regime, self.cycle, self.basin) = (Regime::Failed, None, None);
        by_direct
    }

    /// The dampings C = eps c at which the behaviour changes at this belt speed.
    pub fn changes(&self) -> &[Change] {
        let Oscillator { curve, belt_speed, .. } = &self.oscillator;
        self.changes.get_or_init(|| Behaviour::new(curve, *belt_speed).changes().to_vec())
    }

    /// The dampings c >= 0 between which steady slip and stick-slip both attract: from the damping at which
    /// the equilibrium becomes stable, or, on fast belts, at which the orbit from the exit point ceases to
    /// cross for ever, to c*. `None` where the two are not known to differ.
    pub fn bistable_band(&self) -> Option<BistableBand> {
        let root = self.critical.as_ref().ok().filter(|_| self.contradiction.is_none())?;
        let epsilon = self.point.epsilon;
        let change = |kind: ChangeKind| self.changes().iter().find(|change| change.kind == kind);
        let stable = change(ChangeKind::Hopf).map_or(0.0, |hopf| hopf.viscous.max(0.0) / epsilon);
        let crossing = change(ChangeKind::Crossing);
        let between = crossing.map_or([0.0; 2], |crossing| crossing.between.map(|end| end / epsilon));
        let between = between.map(|end| end.max(stable));
        let failure = crossing.and_then(|crossing| crossing.failure);
        let from = SticksFrom { between, failure };
        let [least, sticking] = between;
        (sticking + root.error < root.c).then(|| BistableBand {
            from_c: from.known(),
            from_c_between: between,
            from_c_reason: from.known().is_none().then(|| match failure {
                None => "orbits between them are too close to call".into(),
                Some(failure) => beyond_data_or(failure, &self.law, &Point { damping: least, ..self.point }),
            }),
            to_c: root.c,
            error: root.error,
        })
    }

    /// The known part of a regime that is not determined in full: "the equilibrium and the stick-slip cycle
    /// attract". The unknown part, with its reason, is that of the cycles.
    pub fn known_of_regime(&self) -> Option<String> {
        let equilibrium = match self.oscillator.stability() {
            Stability::Attracts => "the equilibrium attracts",
            Stability::Neutral => "the equilibrium is neutral",
            Stability::Repels => "the equilibrium is unstable",
        };
        let stick_slip = match self.flow.fate {
            Fate::Sticks(_) => ", the stick-slip cycle attracts",
            Fate::SpiralsInward | Fate::CrossesForever => ", no stick-slip cycle exists",
            Fate::TooCloseToCall | Fate::Failed(_) => "",
        };
        matches!(self.regime, Regime::Failed | Regime::Neutral)
            .then(|| format!("{equilibrium}{stick_slip}; whether other cycles attract is not determined"))
    }

    /// Whether c* is 0 up to rounding errors that do not matter.
    pub fn critical_is_zero(&self) -> bool {
        let Oscillator { curve, belt_speed, .. } = &self.oscillator;
        let rounding = HopfRate::new(curve, *belt_speed).rounding().min(NO_DAMPING);
        self.critical.is_ok_and(|CriticalDamping { c, error, .. }| {
            self.point.epsilon * c.abs() <= rounding && self.point.epsilon * error <= NO_DAMPING
        })
    }

    /// For each method the eps up to which its verdict equals that of the flow, with the other parameters
    /// fixed. Takes much longer than all other answers; without `slow`, which is `validated` and the naive
    /// methods, a fifth of that.
    pub fn limits(&self, slow: bool) -> Vec<EpsilonLimit> {
        let ray = Ray::new(&self.law, &self.point, self.tolerance);
        let is_slow =
            |method| matches!(method, Method::Direct | Method::Naive(..)) || method == Method::validated();
        let limit = |method| match slow || !is_slow(method) {
            true => ray.limit(method),
            false => EpsilonLimit::Unknown(NoEpsilonLimit::NotSought),
        };
        self.methods.iter().map(|answer| limit(answer.method)).collect()
    }

    /// Derivatives of the critical damping.
    pub fn sensitivity(&self) -> Result<Sensitivity, NoSensitivity> {
        // A finer one takes no less.
        if self.critical == Err(NoCriticalDamping::Quota) {
            return Err(NoCriticalDamping::Quota.into());
        }
        sensitivity(&self.law.column(&self.point))
    }

    /// The stick-slip cycle, if there is one.
    pub(crate) fn stick_slip_cycle(&self) -> Result<Option<Cycle>, Failure> {
        stick_slip_cycle(&self.oscillator, &self.flow, self.tolerance)
    }

    /// The cycles that cross the belt line and never stick, at slip speeds at which friction resists.
    pub fn crossing_cycles(&self) -> CrossingCycles {
        crossing_cycles(&self.oscillator, &self.far_loops(), self.tolerance)
    }

    fn far_loops(&self) -> FarLoops<'_> {
        FarLoops::where_friction_resists(&self.oscillator.curve, self.oscillator.belt_speed)
    }

    /// Which crossing cycles are left out, if there may be some.
    pub fn left_out(&self) -> Option<String> {
        self.far_loops().left_out_from().map(slipmap_column::left_out)
    }

    /// The reason why cycles are unknown; where their orbits leave the data of a measured law, how far those
    /// should reach.
    pub fn why_unknown(&self, why: CyclesUnknown) -> String {
        match why {
            CyclesUnknown::Orbit(failure) => beyond_data_or(failure, &self.law, &self.point),
            CyclesUnknown::TooClose
            | CyclesUnknown::NotClosed
            | CyclesUnknown::Neutral
            | CyclesUnknown::FarOut => why.to_string(),
        }
    }

    /// Proved bounds on the number of slip cycles.
    pub fn slip_count(&self) -> &SlipCount {
        self.slip_count.get_or_init(|| count_slip_cycles(&self.oscillator))
    }
}

/// What an orbit from the exit point does.
fn words(fate: &Fate) -> &'static str {
    match fate {
        Fate::Sticks(_) => "sticks again",
        Fate::SpiralsInward => "spirals inward",
        Fate::CrossesForever => "crosses the belt line for ever",
        Fate::TooCloseToCall => "is too close to call",
        Fate::Failed(_) => "is not known",
    }
}

/// The answer of the simulated flow.
fn of_simulation(
    law: &Law,
    point: &Point,
    flow: &Flow,
    critical: &Result<CriticalDamping, NoCriticalDamping>,
) -> MethodAnswer {
    let root = critical.as_ref().ok();
    MethodAnswer {
        method: Method::Simulation,
        verdict: Verdict::from(&flow.fate),
        margin: root.and_then(|root| root.known().ok()).map_or(f64::NAN, |root| root.c - point.damping),
        critical_c: root.and_then(|root| root.known().ok()).map(|root| root.c).filter(|c| *c >= 0.0),
        critical_c_error: root.filter(|root| root.c >= 0.0 || root.known().is_err()).map(|root| root.error),
        reason: match flow.fate {
            Fate::TooCloseToCall => Some(why_too_close(flow.margin, flow.margin_error)),
            Fate::Failed(failure) => Some(beyond_data(law, point).unwrap_or_else(|| failure.to_string())),
            Fate::Sticks(_) | Fate::SpiralsInward | Fate::CrossesForever => None,
        },
    }
}

/// The reason why an orbit is too close to a boundary to call, given its scaled margin and the error of that.
fn why_too_close(margin: f64, error: f64) -> String {
    let [margin_text, error_text] = [signed(margin), short(error)];
    match (margin, error) {
        _ if margin.abs() <= error => {
            format!(
                "the first turn ends {margin_text} V from the belt line, and the error of that distance is {error_text} V"
            )
        }
        _ if margin > error => "the orbit comes back to the exit point within its error".into(),
        _ if margin < -error => {
            format!(
                "the first turn ends {margin_text} V from the belt line, and the error of that distance, {error_text} V, is \
                 large and little less"
            )
        }
        _ if error.is_finite() => format!(
            "whether the orbit from the exit point comes back to the belt line is within its error, {error_text} V"
        ),
        _ => "the error of the orbit from the exit point exceeds all numbers before it comes back or settles"
            .into(),
    }
}

/// The failure of an orbit; of one that leaves the data of a measured law, how far those should reach.
fn beyond_data_or(failure: Failure, law: &Law, point: &Point) -> String {
    let beyond = (failure == Failure::NotFinite).then(|| beyond_data(law, point)).flatten();
    beyond.unwrap_or_else(|| failure.to_string())
}

/// The problem if the law is measured and the orbit from the exit point leaves its data: the slip speed at
/// which the data end, and the one up to which they are needed.
fn beyond_data(law: &Law, point: &Point) -> Option<String> {
    let Law::Table(table) = law else { return None };
    let needed = needed_slip_speed(law, point)?;
    Some(format!(
        "the orbit leaves the data of {}, which end at slip speed {}: it needs them up to about {}",
        table.origin(),
        short(table.fastest()),
        rounded(needed, 3)
    ))
}

/// The answer of the direct engine as a method.
fn of_direct(law: &Law, point: &Point, fate: Fate) -> MethodAnswer {
    MethodAnswer {
        method: Method::Direct,
        verdict: Verdict::from(&fate),
        margin: f64::NAN,
        critical_c: None,
        critical_c_error: None,
        reason: match fate {
            Fate::TooCloseToCall => Some("its orbit is too close to call".into()),
            Fate::Failed(failure) => Some(beyond_data_or(failure, law, point)),
            Fate::Sticks(_) | Fate::SpiralsInward | Fate::CrossesForever => None,
        },
    }
}

fn of_naive(method: Method, law: &Law, verdict: NaiveVerdict) -> MethodAnswer {
    let reason = match (verdict, law) {
        (NaiveVerdict::Failed(Failure::NotFinite), Law::Table(table)) => Some(format!(
            "its orbit left the data of {}, which end at slip speed {}",
            table.origin(),
            short(table.fastest())
        )),
        (NaiveVerdict::Failed(failure), _) => Some(failure.to_string()),
        (NaiveVerdict::Sticks { .. } | NaiveVerdict::NeverSticks, _) => None,
    };
    MethodAnswer {
        method,
        verdict: verdict.into(),
        margin: f64::NAN,
        critical_c: None,
        critical_c_error: None,
        reason,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_model::friction::{Expression, Table};

    /// Orbits pass the end of the data: what the proof does not decide has no margin of presence, and its
    /// reason.
    #[test]
    fn a_proof_that_decides_nothing_says_why() {
        let law = Law::Table(Table::new("short", &[(0.0, 1.0), (0.5, 0.8), (1.5, 0.7)], 1.0).unwrap());
        let point = law.point(1.0, &[], 1.0, 0.05).unwrap();
        let validated = Method::Test(&slipmap_certify::validated::TEST);
        let answer = Answer::of(&law, &point, 1e-9, std::iter::once(validated));
        let MethodAnswer { verdict, margin, reason, .. } = &answer.methods[0];
        assert!(*verdict == Verdict::Undecided && !(*margin > 0.0), "{verdict:?} {margin}");
        let reason = reason.as_deref().unwrap();
        assert!(reason.contains("what is known of the law ends"), "{reason}");
    }

    /// Of a law with more waves than pieces the balance of energy has no sign; of data that end there is
    /// none.
    #[test]
    fn a_balance_that_is_not_known_says_so() {
        let waves = Law::Expression(Expression::new("1 - 0.001*sin(30000*u)", 1.0).unwrap());
        let table = Law::Table(Table::new("short", &[(0.0, 1.0), (0.5, 0.8), (1.5, 0.7)], 1.0).unwrap());
        for (law, said) in
            [(waves, "the balance of energy is known to +- "), (table, "not known at all slip")]
        {
            let point = law.point(1.0, &[], 1.0, 0.1).unwrap();
            let column = law.column(&point);
            let answer = of_test(&slipmap_certify::harmonic_balance::TEST, &column, 0.1);
            assert_eq!((answer.verdict, answer.critical_c), (Verdict::Undecided, None));
            assert!(answer.reason.as_deref().unwrap().contains(said), "{:?}", answer.reason);
        }
    }

    /// Orbits that are too close to call have margins within their errors, or beyond them, or none.
    #[test]
    fn the_reason_of_an_orbit_that_is_too_close_is_so() {
        for (margin, error, said) in [
            (1e-12, 2e-12, "+1e-12 V from the belt line, and the error of that distance is 2e-12 V"),
            (-5e-9, 1e-9, "-5e-9 V from the belt line, and the error of that distance, 1e-9 V, is large"),
            (0.3, 1e-9, "comes back to the exit point"),
            (f64::NAN, 2e10, "within its error, 2e10 V"),
            (f64::NAN, f64::NAN, "exceeds all numbers"),
            (f64::NAN, f64::INFINITY, "exceeds all numbers"),
        ] {
            let why = why_too_close(margin, error);
            assert!(why.contains(said) && !why.contains("- is"), "{why}");
        }
    }

    /// The divergence is so large that the polar angle of the orbit is not monotone, and the count of slip
    /// cycles may be missing: curves prove both verdicts.
    #[test]
    fn a_steep_brake_is_decided_by_curves() {
        let law = Law::Exponential;
        for (c, expected) in [(0.9, Verdict::Absent), (0.15, Verdict::Present)] {
            let point = law.point(1.0, &[0.6, 0.05, 0.0], 0.5, c).unwrap();
            let answer = Answer::of(&law, &point, 1e-9, std::iter::once(Method::validated()));
            let [validated] = &answer.methods[..] else { unreachable!() };
            assert_eq!((validated.verdict, &validated.reason), (expected, &None), "{validated:?}");
        }
    }

    /// Neither engine is believed where they contradict each other, and the reason tells both.
    #[test]
    fn what_the_direct_engine_contradicts_is_not_known() {
        let (law, values) = (Law::Exponential, [0.6, 0.05, 0.0]);
        for (c, share) in [(0.1, "sticks again"), (0.4, "spirals inward")] {
            let point = law.point(1.0, &values, 0.5, c).unwrap();
            let (agreed, direct) = Answer::of_both_engines(&law, &point, 1e-9, Method::usual());
            let verdict = Verdict::from(&agreed.flow.fate);
            assert!(agreed.contradiction.is_none() && verdict == Verdict::from(&direct.fate));
            assert_eq!(words(&agreed.flow.fate), share);
            // The other engine sees the orbit of the other side of c*.
            let other = law.point(1.0, &values, 0.5, 0.5 - c).unwrap();
            let (_, direct) = Answer::of_both_engines(&law, &other, 1e-9, Method::usual());
            let mut answer = Answer::of(&law, &point, 1e-9, Method::usual());
            answer.heed(|told| match Verdict::from(&direct.fate) == told {
                true => (direct, Opinion::Agrees),
                false => (direct, Opinion::Contradicts),
            });
            let simulation = answer.methods.iter().find(|of| of.method == Method::Simulation).unwrap();
            assert_eq!((simulation.verdict, answer.regime), (Verdict::Undecided, Regime::Failed));
            assert_eq!((simulation.critical_c, answer.critical.is_ok()), (None, false));
            assert!(answer.bistable_band().is_none() && answer.cycle.is_none());
            let reason = simulation.reason.as_deref().unwrap();
            for said in [words(&answer.told.fate), words(&direct.fate), "contradict each other", "0.18879"] {
                assert!(reason.contains(said), "{reason}");
            }
        }
    }
}
