//! The answers of every method about one point, and the simulated flow there.

use std::cell::OnceCell;

use super::result::BistableBand;
use crate::behaviour::needed_slip_speed;
use slipmap_certify::curve;
use slipmap_certify::slip_count::{SlipCount, count_slip_cycles};
use slipmap_certify::{Claim, Decision, Guarantee};
use slipmap_column::crossing::{CrossingCycles, crossing_cycles, stick_slip_cycle};
use slipmap_column::limits::{Limit, Ray};
use slipmap_column::sensitivity::{NoSensitivity, Sensitivity, sensitivity};
use slipmap_column::slip_cycle::Unknown;
use slipmap_column::{
    BasinBoundary, CriticalDamping, HALVINGS, Method, NoCriticalDamping, Regime, Verdict, sticks_from,
};
use slipmap_model::filippov::{HopfRate, Oscillator, Stability};
use slipmap_model::flow::{Failure, Fate, Flow};
use slipmap_model::friction::{Column, Law};
use slipmap_model::point::Point;
use slipmap_numbers::text::{rounded, short, signed};
use slipmap_orbits::Cycle;
use slipmap_orbits::far_loops::FarLoops;
use slipmap_orbits::naive::NaiveVerdict;

/// The answer of one method.
#[derive(Debug)]
pub struct MethodAnswer {
    /// The method.
    pub method: Method,
    /// Its verdict.
    pub verdict: Verdict,
    /// The margin as in a map: for a test the signed distance in c to the edge of presence, -infinity where
    /// the test claims no presence; for the simulation the scaled grazing margin m / V, NaN where the flow
    /// has none.
    pub margin: f64,
    /// The edge of presence; `None` where the method has none at c >= 0, or none that is known to 1 %.
    pub critical_c: Option<f64>,
    /// Estimate of its absolute error; `None` for methods whose edge is exact to rounding.
    pub critical_c_error: Option<f64>,
    /// Reason why the verdict is neither presence nor absence.
    pub reason: Option<String>,
}

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
    /// The flow by the return map.
    pub flow: Flow,
    /// The exact critical damping; negative where no legal damping is small enough for a cycle.
    pub critical: Result<CriticalDamping, NoCriticalDamping>,
    /// The long-run behaviour.
    pub regime: Regime,
    /// The cycles that slip all the time below the belt line, by growing amplitude.
    pub slip: Result<Vec<Cycle>, Unknown>,
    /// The attracting cycle; `None` where there is none.
    pub cycle: Option<Cycle>,
    /// The edge of its basin; `None` where it attracts from every start.
    pub basin: Option<BasinBoundary>,
    /// See [`Self::slip_count`]; computed on first use.
    slip_count: OnceCell<SlipCount>,
}

/// Why a point is absent that no enclosure of the orbit from the exit point decides.
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
                Method::Test(test) => of_test(method, &test.claim(&column), &column, point.damping),
                Method::Simulation => of_simulation(law, point, &flow, &critical),
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
            flow,
            critical,
            regime,
            slip,
            cycle,
            basin,
            slip_count: OnceCell::new(),
        }
    }

    /// The dampings c >= 0 between which steady slip and stick-slip both attract: from the damping at which
    /// the equilibrium becomes stable, or, on fast belts, at which the orbit from the exit point ceases to
    /// cross for ever, to c*. `None` where the two are not known to differ.
    pub fn bistable_band(&self) -> Option<BistableBand> {
        let epsilon = self.point.epsilon;
        let Oscillator { curve, belt_speed, .. } = &self.oscillator;
        let becomes_stable = HopfRate::new(curve, *belt_speed).value() / epsilon;
        let root = self.critical.as_ref().ok()?;
        // Avoids -0, since this is printed.
        let from = if becomes_stable > 0.0 { becomes_stable } else { 0.0 };
        if from + root.error >= root.c {
            return None;
        }
        let from = sticks_from(&self.law.column(&self.point), [from, root.c], HALVINGS, self.tolerance);
        let [least, sticking] = from.between;
        (sticking + root.error < root.c).then(|| BistableBand {
            from_c: from.known(),
            from_c_between: from.between,
            from_c_reason: from.known().is_none().then(|| match from.failure {
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
    pub fn limits(&self, slow: bool) -> Vec<Limit> {
        let ray = Ray::new(&self.law, &self.point, self.tolerance);
        let is_slow = |method| matches!(method, Method::Naive(..)) || method == Method::validated();
        let limit = |method| match slow || !is_slow(method) {
            true => ray.limit(method),
            false => Limit::Unknown(slipmap_column::limits::Unknown::NotSought),
        };
        self.methods.iter().map(|answer| limit(answer.method)).collect()
    }

    /// Derivatives of the critical damping.
    pub fn sensitivity(&self) -> Result<Sensitivity, NoSensitivity> {
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
    pub fn why_unknown(&self, why: Unknown) -> String {
        match why {
            Unknown::Orbit(failure) => beyond_data_or(failure, &self.law, &self.point),
            Unknown::TooClose | Unknown::NotClosed | Unknown::Neutral | Unknown::FarOut => why.to_string(),
        }
    }

    /// Proved bounds on the number of slip cycles.
    pub fn slip_count(&self) -> &SlipCount {
        self.slip_count.get_or_init(|| count_slip_cycles(&self.oscillator))
    }
}

/// The answer of a closed-form test.
pub(crate) fn of_test(method: Method, claim: &Claim, column: &Column, c: f64) -> MethodAnswer {
    let decision = claim.decide(c);
    let reason = (decision == Decision::Undecided).then(|| {
        why_inapplicable(method, claim, column).unwrap_or_else(|| {
            let reason = why_undecided(claim, c);
            why_not_sharp(method, claim, column)
                .map_or(reason.clone(), |obstacle| format!("{reason}; {obstacle}"))
        })
    });
    MethodAnswer {
        method,
        verdict: decision.into(),
        margin: claim.margin(c),
        critical_c: claim.edge(),
        critical_c_error: None,
        reason,
    }
}

/// The reason, if a property of the law itself makes a test inapplicable.
fn why_inapplicable(method: Method, claim: &Claim, column: &Column) -> Option<String> {
    if *claim != Claim::NOTHING {
        return None;
    }
    if !column.curve.is_normal() {
        return Some(
            "a coefficient of the friction law is too small for the full accuracy of double precision".into(),
        );
    }
    match method.guarantee() {
        Guarantee::Asymptotic => {
            let is_first_order = matches!(method, Method::Test(test) if test.first_order);
            let no_first_order = is_first_order.then(|| column.first_order().err()).flatten();
            let is_unknown = || column.curve.mean_weakening(column.belt_speed).is_nan();
            let unknown = "the friction law is not known at all slip speeds up to 2 V";
            no_first_order.map(|why| why.to_string()).or_else(|| is_unknown().then(|| unknown.into()))
        }
        Guarantee::Validated => curve::prove(column).stop.map(|stop| stop.to_string()),
        Guarantee::FiniteEpsilon => (!column.curve.is_enclosed(2.0 * column.belt_speed))
            .then(|| "the friction law has no proved bounds at all slip speeds up to 2 V".into()),
        Guarantee::Numerical | Guarantee::None => None,
    }
}

/// The reason why a proof claims less than there is, or a balance of energy leaves a band.
fn why_not_sharp(method: Method, claim: &Claim, column: &Column) -> Option<String> {
    if method.guarantee() == Guarantee::Asymptotic {
        // Its two edges differ by the error of the balance of energy.
        let error = 0.5 * (claim.absent_above - claim.present_below);
        let told = |error| format!("the balance of energy is known to +- {} only", short(error));
        return (error > 0.0 && error.is_finite()).then(|| told(error));
    }
    let is_proved = method.guarantee() == Guarantee::Validated;
    is_proved.then(|| curve::prove(column).stop.map(|stop| stop.to_string()))?
}

/// The reason why a claim is undecided at damping `c`.
fn why_undecided(claim: &Claim, c: f64) -> String {
    let Claim { sticks_from, present_below, absent_above } = *claim;
    if c < present_below && c < sticks_from {
        let from = match sticks_from.is_finite() {
            true => format!("c >= {} would rule that out", short(sticks_from)),
            false => "no damping rules that out".into(),
        };
        return format!("the orbit does not spiral inward, but might land beyond the stick segment; {from}");
    }
    match (present_below >= 0.0, absent_above.is_finite()) {
        (true, true) => format!(
            "the test claims presence below c = {} and absence above c = {} only",
            short(present_below),
            short(absent_above)
        ),
        (true, false) => {
            format!("the test claims presence only, and that below c = {}", short(present_below))
        }
        (false, true) => format!(
            "the test claims absence only at these parameters, and that above c = {}",
            short(absent_above)
        ),
        (false, false) => "the test claims presence only, and none at these parameters".into(),
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
        margin: flow.margin,
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
            let answer = of_test(
                Method::by_name("harmonic_balance").unwrap(),
                &slipmap_certify::harmonic_balance::TEST.claim(&column),
                &column,
                0.1,
            );
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
}
