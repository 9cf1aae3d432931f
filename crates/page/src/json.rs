//! What the page says, for programs: `slipmap machine --json`.

use crate::machine_page::{known_in_words, why_no_critical, why_no_kick};
use serde_json::{Value, json};
use slipmap_machine::assessment::{
    Assessment, DampingLimit, Intervals, LeftOpen, NeededKick, StandardErrors, Statement,
};
use slipmap_machine::behaviour::Limit;
use slipmap_machine::risk::Risk;

/// A limit with its status: what its value means.
fn limit(limit: Limit) -> Value {
    let (status, value) = match limit {
        Limit::Below(value) => ("limit", Some(value)),
        Limit::Between(low, high) => return json!({ "status": "between", "value": [low, high] }),
        Limit::AtLeast(value) => ("at_least", Some(value)),
        Limit::NoneUpTo(value) => ("none", Some(value)),
        Limit::NotDetermined => ("not_determined", None),
    };
    json!({ "status": status, "value": value })
}

/// As [`limit`], with the reason where there is one why it is not determined.
fn reasoned(of: Limit, why: Option<String>) -> Value {
    let mut limit = limit(of);
    if let (Limit::NotDetermined, Some(why)) = (of, why) {
        limit["reason"] = why.into();
    }
    limit
}

/// Where each statement holds. An end that is not known, or that is one of what was tried, is null; the numbers
/// of `known` are those between which the statement holds.
fn intervals(of: &[Intervals]) -> Value {
    let each = Statement::ALL.into_iter().zip(of).map(|(statement, of)| {
        let intervals = of.holds.iter().map(|ends| {
            let [from, to] = ends.map(|end| end.located());
            json!({
                "from": from.map(|[value, _]| value),
                "from_error": from.map(|[_, error]| error),
                "to": to.map(|[value, _]| value),
                "to_error": to.map(|[_, error]| error),
                "known": ends.map(|end| end.value()),
            })
        });
        let intervals: Vec<Value> = intervals.collect();
        (
            statement.name().to_owned(),
            json!({ "intervals": intervals, "not_known": of.unknown, "tried": of.tried }),
        )
    });
    Value::Object(each.collect())
}

/// A limit of the damping that is `None` where it is unknown; none is needed where it is not positive.
fn of_damping(limit: Option<f64>) -> Limit {
    match limit {
        Some(damping) if damping > 0.0 => Limit::Below(damping),
        Some(_) => Limit::NoneUpTo(0.0),
        None => Limit::NotDetermined,
    }
}

/// The name of a limit of the damping in `limits`.
fn key_of(limit: DampingLimit) -> &'static str {
    match limit {
        DampingLimit::Hopf => "steady_slip_unstable_below_damping",
        DampingLimit::Critical => "may_stick_slip_below_damping",
    }
}

/// What the page says.
pub fn to_json(all: &Assessment, risk: Option<&Risk>) -> Value {
    let (machine, does) = (&all.machine, &all.behaviour);
    let [slip, stick] = does.slip_and_stick_time.map_or([None; 2], |times| times.map(Some));
    let error = |of: fn(StandardErrors) -> Option<f64>| all.standard_errors.and_then(of);
    let open = all.left_open();
    let (status, kick, reason) = match all.needed_kick() {
        NeededKick::Kick(kick) => ("kick", Some(kick), None),
        NeededKick::NotNeeded => ("not_needed", None, None),
        NeededKick::None => ("none", None, None),
        NeededKick::NotDetermined => ("not_determined", None, why_no_kick(all)),
    };
    // What a hammer or the loss of a load gives to the mass, N s.
    let impulse = kick.map(|kick| kick.times(machine.mass));
    let error_of_kick = all.standard_errors.and_then(|errors| errors.kick).filter(|_| kick.is_some());
    let motion = json!({
        "needed_slip_speed": does.needed_slip_speed,
        "needed_slip_speed_for_belt_speeds": all.needed_for_speeds,
        "natural_frequency": does.natural_frequency,
        "period": all.period,
        "slip_time": slip,
        "stick_time": stick,
        "amplitude": does.amplitude,
        "velocity_amplitude": all.velocity_amplitude,
        "severity": all.severity,
        "growth_time": does.growth_time,
        "fragile_from_before_end_of_stick_seconds": all.fragile.map(|[before, _]| before),
        "fragile_for_seconds": all.fragile.map(|[_, lasts]| lasts),
        "kick_status": status,
        "kick_reason": reason,
        "kick_forward": kick.map(|kick| kick.forward),
        "kick_backward": kick.map(|kick| kick.backward),
        "kick_forward_impulse": impulse.map(|kick| kick.forward),
        "kick_backward_impulse": impulse.map(|kick| kick.backward),
        "kick_forward_standard_error": error_of_kick.map(|kick| kick.forward),
        "kick_backward_standard_error": error_of_kick.map(|kick| kick.backward),
    });
    let mut page = json!({
        "law": machine.friction.law_name(),
        "motion": machine.motion.name(),
        "machine": machine.quantities().into_iter().map(|(name, value)| (name.to_owned(), json!(value))).collect::<Value>(),
        "regime": does.regime.name(),
        "regime_known": all.undetermined.as_ref().map(|it| known_in_words(it.sticks, it.stability)),
        "regime_reasons": all.undetermined.as_ref().map(|it| &it.reasons),
        "regimes_left_open_by_data": open.as_ref().map(LeftOpen::names),
        "damping_within_two_standard_errors_of": open.map(|open| {
            open.limits.iter().map(|(limit, _)| key_of(*limit)).collect::<Vec<_>>()
        }),
        "standard_errors_from": all.standard_errors.map(|errors| errors.from),
        "warnings": machine.doubts(),
        "always_stick_slips_below_belt_speed": all.always_below_speed.value(),
        "may_stick_slip_below_belt_speed": does.critical_belt_speed.value(),
        "always_stick_slips_below_damping": all.always_below_damping.value(),
        "may_stick_slip_below_damping": all.may_stick_below_damping().value(),
        "may_stick_slip_below_damping_error": does.critical_damping_error,
        "may_stick_slip_below_damping_standard_error": error(|errors| errors.critical_damping.map(|of| of.standard_error)),
        "steady_slip_unstable_below_damping": all.hopf_damping,
        "steady_slip_unstable_below_damping_standard_error": error(|errors| Some(errors.hopf_damping.standard_error)),
        "vibrates_below_damping": all.vibrates_below_damping,
        "may_stick_slip_below_belt_speed_standard_error": error(|errors| errors.critical_belt_speed.map(|of| of.standard_error)),
        "limits": {
            "always_stick_slips_below_belt_speed": limit(all.always_below_speed),
            "may_stick_slip_below_belt_speed": limit(does.critical_belt_speed),
            "always_stick_slips_below_damping": limit(all.always_below_damping),
            "may_stick_slip_below_damping": reasoned(
                all.may_stick_below_damping(),
                why_no_critical(all, &[]).map(|why| why.plain()),
            ),
            "steady_slip_unstable_below_damping": limit(of_damping(Some(all.hopf_damping))),
            "vibrates_below_damping": reasoned(
                of_damping(all.vibrates_below_damping),
                all.slip_cycles_unknown.clone(),
            ),
        },
        "belt_speeds": intervals(&all.speeds),
        "dampings": intervals(&all.dampings),
        "damping_over_critical": all.safety_margin(),
        "sensitivities": all.sensitivities,
        "influence": all.influence,
        "proofs": all.proofs,
        "risk": risk,
    });
    if let (Some(page), Value::Object(motion)) = (page.as_object_mut(), motion) {
        page.extend(motion);
    }
    page
}
