//! The answer of the page in a sentence.

use super::lines::{damping_limit, percent, quantity};
use super::units::with_error;
use super::units::{Unit, Written};
use slipmap_column::{Attractors, Regime};
use slipmap_figure::text::{Rich, capital, rich};
use slipmap_machine::Motion;
pub use slipmap_machine::assessment::{Assessment, DampingLimit, LeftOpen, Undetermined};
use slipmap_machine::assessment::{End, Statement};
use slipmap_machine::risk::{Risk, WithError};

/// The behaviour at the working point, and the damping above which the vibration ends.
pub(super) fn in_words(all: &Assessment, written: &Written) -> Rich {
    let (machine, does) = (&all.machine, &all.behaviour);
    let limit = |damping: f64| damping_limit(all, damping, 3, Unit::of(&all.machine, written, "damping"));
    let place = quantity(machine.belt_speed, Unit::of(&all.machine, written, "belt_speed")).then(" and ");
    let place = place.then(quantity(machine.damping, Unit::of(&all.machine, written, "damping")));
    let (sentence, regimes) = match all.left_open().filter(|open| !open.limits.is_empty()) {
        Some(open) => (undecided(all, written, place, &open), open.regimes),
        None => {
            let does_what = capital(&does_what(all));
            let does_what = rich(&does_what).then(" at ").then(place).then(vibration(all));
            (does_what.then(growth(all)), vec![does.regime])
        }
    };
    let some = |of: fn(Attractors) -> bool| regimes.iter().any(|regime| of(regime.attractors()));
    let may_stick = some(|it| it.stick_slip) || sticks(all) == Some(true);
    let vibrates = may_stick || some(|it| it.slip || it.crossing);
    if matches!(does.regime, Regime::Failed | Regime::Neutral) && !vibrates {
        return sentence.then(".");
    }
    let ends_stick_slip = does.critical_damping.filter(|_| may_stick);
    match (vibrates, ends_stick_slip, all.vibrates_below_damping) {
        (true, Some(stick_slip), Some(every))
            if every > stick_slip * (1.0 + 1e-6) && stick_slip > machine.damping =>
        {
            let first = sentence.then("; more than ").then(limit(stick_slip)).then(" ends stick-slip");
            first.then(", more than ").then(limit(every)).then(" every vibration.")
        }
        (true, _, Some(every)) => {
            sentence.then("; more than ").then(limit(every)).then(" ends the vibration.")
        }
        (true, Some(stick_slip), None) => {
            sentence.then("; more than ").then(limit(stick_slip)).then(" ends stick-slip.")
        }
        (false, _, Some(every)) if every > 0.0 => {
            sentence.then("; it may vibrate below ").then(limit(every)).then(".")
        }
        _ => sentence.then("."),
    }
}

/// "At this damping it stick-slips by itself up to 15 rpm, after a knock up to 154 rpm.", of some belt speeds or of all;
/// empty where the speeds at which it does are not one interval from the least on.
pub(super) fn over_speeds(all: &Assessment, written: &Written, speeds: Option<[f64; 2]>) -> Rich {
    let unit = Unit::of(&all.machine, written, "belt_speed");
    // `None` where it is not told in one number.
    let end = |statement: Statement| {
        let of = &all.speeds[statement as usize];
        match of.holds.as_slice() {
            [] => Some(None).filter(|_| of.unknown.is_empty()),
            [[End::Tried(_), end]] => Some(Some(*end)),
            _ => None,
        }
    };
    let (Some(always), Some(Some(may))) = (end(Statement::AlwaysSticks), end(Statement::MayStick)) else {
        return Rich::default();
    };
    let [least, most] = speeds.unwrap_or([0.0, f64::INFINITY]);
    let is_all = |end: &End| end.value() >= most;
    let up_to = |end: End| match (is_all(&end), end) {
        (true, _) => rich(" at all of them"),
        (false, End::At { value, .. }) => rich(" up to ").then(unit.number(value, 3)),
        (false, end) => rich(" up to at least ").then(unit.number(end.value(), 3)),
    };
    let number = |value: f64| unit.unnamed().number(value, 3);
    let range = number(least).then(" to ").then(number(most)).with_unit(unit.name);
    let begins = match speeds {
        Some(_) => rich("From ").then(range).then(" at this damping it stick-slips"),
        None => rich("At this damping it stick-slips"),
    };
    if may.value() <= least {
        return begins.then(" at none.");
    }
    // A knock is a push of the mass.
    match always.filter(|end| end.value() > least) {
        None => begins.then(" only after a knock,").then(up_to(may)).then("."),
        Some(always) => {
            let by_itself = begins.then(" by itself").then(up_to(always));
            let is_more = may.value() > always.value() * (1.0 + 1e-3) && !is_all(&always);
            let knock = is_more.then(|| rich(", after a knock").then(up_to(may)));
            by_itself.then(knock.unwrap_or_default()).then(".")
        }
    }
}

/// The probability of stick-slip from the spreads of the inputs and the errors of the friction; may be empty.
pub(super) fn uncertainty(all: &Assessment, written: &Written, risk: Option<&Risk>) -> Rich {
    let Some(risk) = risk else { return Rich::default() };
    let share = match (risk.failed, risk.probability.limits.map(percent)) {
        (0, _) => format!("of {} %", percent(risk.probability.value)),
        (failed, [low, high]) => {
            format!("between {low} and {high} %, as {failed} of {} draws have no answer", risk.draws + failed)
        }
    };
    let begins =
        if all.is_left_open() { " It" } else { "That is for the nominal values. With their spreads it" };
    let by_itself =
        format!(" vibrates by itself with a probability of {} %, and may", percent(risk.by_itself.value));
    let probability = rich(begins).then(rich(&by_itself)).then(" stick-slip with one ").then(rich(&share));
    let rarest = risk.rare_by.iter().rev().find_map(|rare| Some((rare.probability, rare.damping.as_ref()?)));
    match rarest {
        // Without damping the probability is smaller still.
        Some((_, damping)) if damping.value == 0.0 => probability.then("."),
        Some((share, damping)) => {
            let damping = Unit::of(&all.machine, written, "damping").number(damping.value, 3);
            let share = Rich::number(100.0 * share, 2);
            probability.then("; above ").then(damping).then(" that is below ").then(share).then(" %.")
        }
        None => probability.then("."),
    }
}

/// Whether the stick-slip cycle attracts where the regime is not determined in full.
fn sticks(all: &Assessment) -> Option<bool> {
    all.undetermined.as_ref().and_then(|Undetermined { sticks, .. }| *sticks)
}

/// "At 0.2 m/s and 180 N s/m the data leave open what it does: it ...; or it ... The damping lies within two
/// standard errors of 171 ± 20 N s/m, below which steady slip is unstable".
fn undecided(
    all: &Assessment,
    written: &Written,
    place: Rich,
    LeftOpen { limits, regimes, .. }: &LeftOpen,
) -> Rich {
    let unit = Unit::of(&all.machine, written, "damping");
    let mut sentence = match all.behaviour.regime {
        Regime::Failed | Regime::Neutral => {
            rich(&capital(&does_what(all))).then(" at ").then(place).then(". ")
        }
        _ => {
            let all: Vec<String> = regimes.iter().map(|regime| attracts(*regime)).collect();
            let all = all.join("; or it ").replace(",;", ";");
            let behaviours = format!(" the data leave open what it does: it {}. ", all.trim_end_matches(','));
            rich("At ").then(place).then(rich(&behaviours))
        }
    };
    for (number, (limit, WithError { value, standard_error })) in limits.iter().enumerate() {
        let begins =
            if number == 0 { "The damping lies within two standard errors of " } else { ", and of " };
        let below = match limit {
            DampingLimit::Hopf => ", below which steady slip is unstable",
            DampingLimit::Critical => ", above which it cannot stick-slip",
        };
        sentence =
            sentence.then(rich(begins)).then(with_error(*value, *standard_error, 4, unit)).then(rich(below));
    }
    sentence
}

/// "stick-slips from every start", "slips steadily or stick-slips, depending on the start,".
fn does_what(all: &Assessment) -> String {
    match (all.behaviour.regime, sticks(all)) {
        (Regime::Failed | Regime::Neutral, Some(true)) => "stick-slips at least from some starts".into(),
        (Regime::Neutral, _) => "small swings about steady slip neither grow nor decay".into(),
        (Regime::Failed, _) => "what it does is not determined".into(),
        (regime, _) => attracts(regime),
    }
}

/// As [`does_what`], for a regime that is determined.
fn attracts(regime: Regime) -> String {
    let Attractors { equilibrium, slip, stick_slip, crossing } = regime.attractors();
    // Clauses of more than one attractor are short: commas separate them.
    let several = [equilibrium, slip, stick_slip, crossing].iter().filter(|it| **it).count() > 1;
    let does = [
        (equilibrium, "slips steadily", "slips steadily from every start"),
        (slip, "vibrates without sticking", "vibrates from every start, without sticking,"),
        (stick_slip, "stick-slips", "stick-slips from every start"),
        (crossing, "overtakes the belt at every turn", "overtakes the belt at every turn, from every start,"),
    ];
    let does: Vec<&str> =
        does.iter().filter(|(is, ..)| *is).map(|(_, of, alone)| if several { *of } else { *alone }).collect();
    match does.as_slice() {
        [first @ .., last] if several => format!("{} or {last}, depending on the start,", first.join(", ")),
        _ => does.concat(),
    }
}

/// "; a disturbance of steady slip grows by the factor e in 0.02 s": how long it may take to begin.
fn growth(all: &Assessment) -> Rich {
    all.behaviour.growth_time.map_or_else(Rich::default, |time| {
        rich("; a disturbance of steady slip grows by the factor e in ")
            .then(Rich::number(time, 2))
            .with_unit("s")
    })
}

/// " (75 Hz, 0.41 mm)": frequency and amplitude of the attracting cycle.
fn vibration(all: &Assessment) -> Rich {
    let Some((period, amplitude)) = all.period.zip(all.behaviour.amplitude) else { return Rich::default() };
    let amplitude = match all.machine.motion {
        Motion::Translation => Rich::number(1e3 * amplitude, 2).with_unit("mm"),
        Motion::Rotation => Rich::number(amplitude, 2).with_unit("rad"),
    };
    let frequency = Rich::number(1.0 / period, 2).with_unit("Hz");
    rich(" (").then(frequency).then(", ").then(amplitude).then(")")
}
