//! Everything that is known of one point.

use serde_json::{Map, Value, json};

use super::output::{short, signed};
use super::point::coordinates;
use crate::certify::{Claim, Decision, Guarantee};
use crate::filippov::{Eigenvalues, Oscillator};
use crate::friction::{Column, Curve, Law};
use crate::map::limits::{EpsilonLimit, Limit, Ray};
use crate::map::{self, AttractingCycle, Method, Regime, Verdict};
use crate::point::Point;
use crate::simulate::naive::NaiveVerdict;
use crate::simulate::slip_count::{SlipCount, count_slip_cycles};
use crate::simulate::slip_cycle::{Kick, SlipCycle, slip_cycles};
use crate::simulate::{self, CriticalDamping, Dynamics, Fate, Flow, Landing, NoCriticalDamping, Range};

/// What one method says.
#[derive(Debug)]
pub(super) struct MethodAnswer {
    /// The method.
    pub(super) method: Method,
    /// Its verdict.
    pub(super) verdict: Verdict,
    /// As in a map: of a test the signed distance in c to the edge of presence, -infinity where the test
    /// claims none; of the simulation the scaled grazing margin m / V, NaN where the flow has none.
    pub(super) margin: f64,
    /// The edge of presence; `None` where the method has none at c >= 0.
    pub(super) critical_c: Option<f64>,
    /// Why the verdict is neither presence nor absence.
    pub(super) reason: Option<String>,
}

/// All answers but the second engine's.
#[derive(Debug)]
pub(super) struct Answer {
    /// The friction law.
    pub(super) law: Law,
    /// The point.
    pub(super) point: Point,
    /// Bound on the error of the grazing margin that the simulation aimed at.
    pub(super) tolerance: f64,
    /// The oscillator there.
    pub(super) oscillator: Oscillator,
    /// One answer per method that was asked.
    pub(super) methods: Vec<MethodAnswer>,
    /// The flow by the return map.
    pub(super) flow: Flow,
    /// The exact critical damping; negative where no legal damping is small enough for a cycle.
    pub(super) critical: Result<CriticalDamping, NoCriticalDamping>,
    /// The long-run behaviour.
    pub(super) regime: Regime,
    /// The cycle that attracts.
    pub(super) cycle: Option<AttractingCycle>,
    /// The boundary of the basin of steady slip in the bistable regime, and the kicks onto it.
    pub(super) basin: Option<(SlipCycle, Kick)>,
}

impl Answer {
    /// Asks `methods`.
    pub(super) fn of(
        law: &Law,
        point: &Point,
        tolerance: f64,
        methods: impl Iterator<Item = Method>,
    ) -> Self {
        let column = law.column(point);
        let oscillator = Oscillator::new(law, point);
        let flow = simulate::flow(&oscillator, tolerance);
        let critical = simulate::critical_damping(&column, tolerance);
        let methods = methods
            .map(|method| match method {
                Method::Test(test) => of_test(method, &(test.claim)(&column), &column, point.damping),
                Method::Simulation => of_simulation(&flow, &critical),
                Method::Naive(naive, knobs) => of_naive(method, naive.decide(&oscillator, &knobs).verdict),
            })
            .collect();
        let regime = map::regime(&oscillator, &flow);
        let cycle = map::attracting_cycle(&oscillator, &flow, regime, tolerance);
        let basin = map::basin_boundary(&oscillator, regime, tolerance);
        Self {
            law: law.clone(),
            point: *point,
            tolerance,
            oscillator,
            methods,
            flow,
            critical,
            regime,
            cycle,
            basin,
        }
    }

    /// The dampings c >= 0 between which steady slip and stick-slip both attract: from where the equilibrium
    /// becomes stable to c*, with the error of the latter. The landing is another matter.
    pub(super) fn bistable_band(&self) -> Option<[f64; 3]> {
        let epsilon = self.point.epsilon;
        let becomes_stable = self.oscillator.curve.weakening(self.oscillator.belt_speed) / epsilon;
        let root = self.critical.as_ref().ok()?;
        // No zero with a sign: this is printed.
        let from = if becomes_stable > 0.0 { becomes_stable } else { 0.0 };
        (from < root.c).then_some([from, root.c, root.error])
    }

    /// Up to which eps each method says what the flow says, the other parameters being as they are. Much more
    /// work than all other answers.
    pub(super) fn limits(&self) -> Vec<EpsilonLimit> {
        let ray = Ray::new(&self.law, &self.point, self.tolerance);
        self.methods.iter().map(|answer| ray.limit(answer.method)).collect()
    }

    /// Everything that is not an attractor is left out of [`Answer`]; this is all of it.
    pub(super) fn dynamics(&self) -> Result<Dynamics, simulate::Failure> {
        simulate::dynamics(&self.oscillator, &self.flow, self.tolerance)
    }

    /// Where and when the orbit sticks, if it does.
    pub(super) fn landing(&self) -> Option<Landing> {
        landing(&self.flow)
    }

    /// The cycles that slip all the time below the belt line.
    pub(super) fn slip_cycles(&self) -> Result<Vec<SlipCycle>, simulate::Failure> {
        slip_cycles(&self.oscillator, self.tolerance)
    }

    /// How many of them there are, as far as that is proved.
    pub(super) fn slip_count(&self) -> SlipCount {
        count_slip_cycles(&self.oscillator)
    }

    /// Everything, for `--json`, with the flow of the second engine.
    pub(super) fn json(&self, direct: &Flow) -> Value {
        let point: Map<String, Value> = coordinates(&self.law, &self.point)
            .into_iter()
            .map(|(name, value)| (name.to_owned(), json!(value)))
            .collect();
        let methods: Map<String, Value> = self
            .methods
            .iter()
            .zip(self.limits())
            .map(|(answer, limit)| {
                let entry = json!({
                    "verdict": answer.verdict.name(),
                    "margin": answer.margin,
                    "critical_c": answer.critical_c,
                    "guarantee": answer.method.guarantee().name(),
                    "equation": answer.method.equation(),
                    "reason": answer.reason,
                    "epsilon_limit": limit_json(limit.equal),
                    "epsilon_limit_sound": limit_json(limit.sound),
                });
                (answer.method.name().to_owned(), entry)
            })
            .collect();
        let critical = match &self.critical {
            Ok(root) => json!({ "value": root.c, "error": root.error, "rhs": root.rhs, "reason": null }),
            Err(why) => json!({ "value": null, "error": null, "rhs": null, "reason": why.to_string() }),
        };
        let oscillator = &self.oscillator;
        let eigenvalues = match oscillator.eigenvalues() {
            Eigenvalues::Complex { re, im } => json!([{ "re": re, "im": -im }, { "re": re, "im": im }]),
            Eigenvalues::Real { slow, fast } => json!([{ "re": slow, "im": 0.0 }, { "re": fast, "im": 0.0 }]),
        };
        json!({
            "law": self.law.name(),
            "point": point,
            "tolerance": self.tolerance,
            "methods": methods,
            "flow": { "return_map": flow_json(&self.flow), "direct": flow_json(direct) },
            "critical_c": critical,
            "regime": self.regime.name(),
            "equilibrium": {
                "x1": oscillator.equilibrium_x1(),
                "x2": 0.0,
                "divergence": oscillator.divergence(oscillator.belt_speed),
                "type": equilibrium_type(oscillator),
                "eigenvalues": eigenvalues,
            },
            "sliding_segment": {
                "from_x1": oscillator.upper_tangency_x1(),
                "to_x1": oscillator.exit_x1(),
                "x2": oscillator.belt_speed,
            },
            "exit_point": { "x1": oscillator.exit_x1(), "x2": oscillator.belt_speed },
            "landing": self.landing().map(|landing| landing_json(&landing)),
            "bistable_band": self.bistable_band().map(|[from, to, error]| {
                json!({ "from_c": from, "to_c": to, "error": error })
            }),
            "attracting_cycle": self.cycle.map(|cycle| json!({
                "period": cycle.period,
                "x1": range_json(cycle.displacement),
                "x2": range_json(cycle.velocity),
                "multiplier": cycle.multiplier,
            })),
            "basin_boundary": self.basin.map(|(cycle, kick)| json!({
                "cycle": slip_cycle_json(&cycle),
                "kick": { "forward": kick.forward, "backward": kick.backward },
            })),
            "cycles": match self.dynamics() {
                Ok(dynamics) => dynamics_json(&dynamics, &self.slip_count()),
                Err(failure) => json!({ "reason": failure.to_string() }),
            },
        })
    }
}

/// 0 for never; a text where the limit is beyond all that was looked at, since JSON knows no infinity.
fn limit_json(limit: Limit) -> Value {
    match limit {
        Limit::Never | Limit::UpTo(_) => json!(limit.value()),
        Limit::Throughout => json!("inf"),
    }
}

fn range_json(range: Range) -> Value {
    json!({ "from": range.lo, "to": range.hi })
}

fn slip_cycle_json(cycle: &SlipCycle) -> Value {
    json!({
        "stable": cycle.is_stable(),
        "multiplier": cycle.multiplier,
        "period": cycle.period,
        "x1": range_json(cycle.displacement),
        "x2": range_json(cycle.velocity),
    })
}

fn dynamics_json(dynamics: &Dynamics, count: &SlipCount) -> Value {
    let crossing: Vec<Value> = dynamics
        .crossing
        .iter()
        .map(|cycle| {
            json!({
                "stable": cycle.is_stable(),
                "multiplier": cycle.multiplier,
                "period": cycle.period,
                "beyond_exit": cycle.beyond_exit,
                "x1": range_json(cycle.displacement),
                "x2": range_json(cycle.velocity),
            })
        })
        .collect();
    json!({
        "stick_slip": dynamics.stick_slip.map(|cycle| json!({
            "stable": true,
            "multiplier": 0.0,
            "period": cycle.period,
            "x1": range_json(cycle.displacement),
            "x2": range_json(cycle.velocity),
        })),
        "slip": dynamics.slip.iter().map(slip_cycle_json).collect::<Vec<_>>(),
        "slip_count": {
            "proved": count.exact(),
            "at_least": count.at_least,
            "at_most": count.at_most,
            "open": count.open.iter().copied().map(range_json).collect::<Vec<_>>(),
        },
        "crossing": crossing,
    })
}

/// What a closed-form test says.
fn of_test(method: Method, claim: &Claim, column: &Column, c: f64) -> MethodAnswer {
    let decision = claim.decide(c);
    let edge = claim.present_below;
    let reason = (decision == Decision::Undecided)
        .then(|| why_inapplicable(method, claim, column).unwrap_or_else(|| why_undecided(claim, c)));
    MethodAnswer {
        method,
        verdict: decision.into(),
        margin: claim.margin(c),
        critical_c: (edge >= 0.0).then_some(edge),
        reason,
    }
}

/// Why a test says nothing about the law of a column, if it is the law.
fn why_inapplicable(method: Method, claim: &Claim, column: &Column) -> Option<String> {
    if *claim != Claim::NOTHING {
        return None;
    }
    match method.guarantee() {
        Guarantee::Asymptotic => column.curve.first_order(column.belt_speed).err().map(|why| why.to_string()),
        Guarantee::Validated => (!matches!(column.curve, Curve::Stribeck(_)))
            .then(|| "the proof covers the law stribeck only".into()),
        Guarantee::FiniteEpsilon | Guarantee::Numerical | Guarantee::None => None,
    }
}

/// Why a claim says nothing at damping `c`.
fn why_undecided(claim: &Claim, c: f64) -> String {
    let Claim { sticks_from, present_below, absent_above } = *claim;
    if c < present_below && c < sticks_from {
        let from = match sticks_from.is_finite() {
            true => format!("c >= {} would rule that out", short(sticks_from)),
            false => "no damping rules that out".into(),
        };
        return format!("the orbit returns, but might land beyond the stick segment; {from}");
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

/// What the simulated flow says.
fn of_simulation(flow: &Flow, critical: &Result<CriticalDamping, NoCriticalDamping>) -> MethodAnswer {
    let root = critical.as_ref().ok().map(|critical| critical.c);
    MethodAnswer {
        method: Method::Simulation,
        verdict: verdict(&flow.fate),
        margin: flow.margin,
        critical_c: root.filter(|&root| root >= 0.0),
        reason: match flow.fate {
            Fate::TooCloseToCall => Some(format!(
                "the grazing margin {} is smaller than its error {}",
                signed(flow.margin),
                short(flow.margin_error)
            )),
            Fate::Failed(failure) => Some(failure.to_string()),
            Fate::Sticks(_) | Fate::SpiralsInward | Fate::CrossesForever => None,
        },
    }
}

/// What a naive method says.
fn of_naive(method: Method, verdict: NaiveVerdict) -> MethodAnswer {
    let reason = match verdict {
        NaiveVerdict::Failed(failure) => Some(failure.to_string()),
        NaiveVerdict::Sticks { .. } | NaiveVerdict::NeverSticks => None,
    };
    MethodAnswer { method, verdict: verdict.into(), margin: f64::NAN, critical_c: None, reason }
}

/// The verdict that a fate means.
pub(super) fn verdict(fate: &Fate) -> Verdict {
    match fate {
        Fate::Sticks(_) => Verdict::Present,
        Fate::SpiralsInward | Fate::CrossesForever => Verdict::Absent,
        Fate::TooCloseToCall => Verdict::Undecided,
        Fate::Failed(_) => Verdict::Failed,
    }
}

/// Where and when the orbit sticks, if it does.
pub(super) fn landing(flow: &Flow) -> Option<Landing> {
    match flow.fate {
        Fate::Sticks(landing) => Some(landing),
        _ => None,
    }
}

/// A fate in one word.
pub(super) fn fate_name(fate: &Fate) -> &'static str {
    match fate {
        Fate::Sticks(_) => "sticks",
        Fate::SpiralsInward => "spirals_inward",
        Fate::CrossesForever => "crosses_forever",
        Fate::TooCloseToCall => "too_close_to_call",
        Fate::Failed(_) => "failed",
    }
}

/// "unstable focus" and the like.
pub(super) fn equilibrium_type(oscillator: &Oscillator) -> &'static str {
    match oscillator.eigenvalues() {
        Eigenvalues::Complex { re, .. } if re < 0.0 => "stable focus",
        Eigenvalues::Complex { re, .. } if re > 0.0 => "unstable focus",
        Eigenvalues::Complex { .. } => "centre of the linearisation",
        Eigenvalues::Real { slow, .. } if slow < 0.0 => "stable node",
        Eigenvalues::Real { .. } => "unstable node",
    }
}

/// How many slip cycles were found, and what is proved of their number.
pub(super) fn slip_count_words(found: usize, count: &SlipCount) -> String {
    let number = |n: u32| if n == 0 { "none".to_owned() } else { n.to_string() };
    if let Some(exact) = count.exact() {
        return match usize::try_from(exact) {
            Ok(exact) if exact == found => format!("{}, count proved", number(count.at_least)),
            _ => format!("{found} found, but {} proved: try a smaller tolerance", number(count.at_least)),
        };
    }
    let open = count.open.iter().map(|open| format!("{} to {}", short(open.lo), short(open.hi)));
    let open: Vec<String> = open.collect();
    let mut words = format!("{found} found, count not proved");
    if !open.is_empty() {
        words.push_str(&format!(": nothing is proved where the maximum of x2 is in {}", open.join(", ")));
    } else if let Some(most) = count.at_most {
        words.push_str(&format!(": {} to {most} are possible", count.at_least));
    }
    words
}

/// A regime in words.
pub(super) fn regime_words(regime: Regime) -> &'static str {
    match regime {
        Regime::Equilibrium => "steady slip at the equilibrium is the only attractor",
        Regime::StickSlip => "the stick-slip cycle is the only attractor",
        Regime::Bistable => "the equilibrium and the stick-slip cycle both attract",
        Regime::PureSlip => "a cycle that slips all the time below the belt line",
        Regime::Crossing => "a cycle that crosses the belt line and never sticks",
        Regime::Failed => "not determined",
        Regime::PureSlipAndStickSlip => {
            "a cycle that slips all the time and the stick-slip cycle both attract"
        }
        Regime::PureSlipAndEquilibrium => "a cycle that slips all the time and the equilibrium both attract",
    }
}

fn flow_json(flow: &Flow) -> Value {
    json!({
        "fate": fate_name(&flow.fate),
        "verdict": verdict(&flow.fate).name(),
        "margin": flow.margin,
        "margin_error": flow.margin_error,
        "rhs": flow.rhs,
        "landing": landing(flow).map(|landing| landing_json(&landing)),
        "reason": match flow.fate {
            Fate::Failed(failure) => Some(failure.to_string()),
            _ => None,
        },
    })
}

fn landing_json(landing: &Landing) -> Value {
    json!({
        "x1": landing.x1,
        "slip_time": landing.slip_time,
        "stick_time": landing.stick_time,
        "period": landing.slip_time + landing.stick_time,
        "crossings": landing.crossings,
    })
}
