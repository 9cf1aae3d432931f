//! The lines of the page: questions and answers, section by section.

use super::Line;
use super::intervals::{self, digits_of_data};
use super::units::{Unit, Written, with_error};
use crate::palette;
use slipmap_figure::text::{Rich, join, rich};
pub use slipmap_machine::assessment::{Assessment, NeededKick, Undetermined};
use slipmap_machine::risk::{Risk, Spread, Uncertain, WithError, WithLimits, is_uncertain};
use slipmap_machine::{AREA, Coefficients, Dimension, Friction, Motion, PRESSURE};
use slipmap_model::filippov::Stability;
use slipmap_model::friction::Table;
use slipmap_numbers::text::{known_part, rounded};

/// A heading and its lines.
pub(crate) type Section = (&'static str, Vec<Line>);

pub(super) fn quantity<'a>(value: f64, unit: impl Into<Unit<'a>>) -> Rich {
    unit.into().number(value, 4)
}

/// A limit of the damping, with its standard error where that is known; the critical damping else with its
/// numerical error, where that reaches the digits.
pub(super) fn damping_limit(all: &Assessment, damping: f64, digits: usize, unit: Unit) -> Rich {
    let numerical = all.numerical_error_of(damping);
    match all.standard_error_of(damping) {
        Some(standard_error) if standard_error >= numerical => with_error(damping, standard_error, 4, unit),
        _ => with_error(damping, numerical, digits, unit),
    }
}

fn line(name: &str, value: Rich) -> Line {
    (rich(name), value)
}

pub(super) fn sections(
    all: &Assessment,
    written: &Written,
    uncertain: &[Uncertain],
    risk: Option<&Risk>,
) -> Vec<Section> {
    let mut sections = vec![("Machine", given(all, written, uncertain)), ("Limits", limits(all, written))];
    const UNCERTAIN: &str = "Uncertain quantities";
    match risk {
        Some(risk) => sections.push((UNCERTAIN, risk_lines(all, written, risk))),
        None if is_uncertain(&all.machine, uncertain) => {
            let why = rich("not determined: no critical damping was found for any draw");
            sections.push((UNCERTAIN, vec![line("probability that it may stick-slip", why)]));
        }
        None => {}
    }
    sections.push(("Motion", motion(all, written)));
    sections.push(("Critical damping changes with", sensitivities(all, written, uncertain)));
    sections.push(("What is proved and what is computed", proved(all, uncertain)));
    sections
}

/// The quantity of this name with its unit and its spread: "2 kg ± 0.05 (sd)", "225 N s/m, 150 to 300 (uniform)".
fn with_spread(name: &str, value: f64, unit: Unit, uncertain: &[Uncertain]) -> Rich {
    let text = quantity(value, unit);
    let number = |value: f64, digits: usize| unit.unnamed().number(value, digits);
    match uncertain.iter().find(|(known, _)| *known == name).map(|(_, spread)| spread.at(value)) {
        None => text,
        Some(Spread::Normal { sd } | Spread::Relative { sd }) => {
            text.then(" ± ").then(number(sd, 3)).then(" (sd)")
        }
        Some(spread @ Spread::Joint { .. }) => {
            with_error(value, spread.sd(value), 4, unit).then(" (of the fit)")
        }
        Some(Spread::Uniform { min, max }) => {
            let ends = number(min, 4).then(" to ").then(number(max, 4));
            text.then(", ").then(ends).then(" (uniform)")
        }
    }
}

/// The machine as it was given.
fn given(all: &Assessment, written: &Written, uncertain: &[Uncertain]) -> Vec<Line> {
    let machine = &all.machine;
    let of =
        |name: &str, value: f64| with_spread(name, value, Unit::of(&all.machine, written, name), uncertain);
    let named = |name: &str, value: f64| line(&machine.motion.words(name), of(name, value));
    let mut given = vec![named("mass", machine.mass), named("stiffness", machine.stiffness)];
    if machine.normal_force_is_known {
        // With a radius the force is written, and the torque is shown.
        let is_written = machine.quantities().contains(&("normal_force", machine.normal_force));
        let unit = match is_written {
            true => Unit::of(&all.machine, written, "normal_force"),
            false => machine.motion.unit(Dimension::Force).into(),
        };
        let force = with_spread("normal_force", machine.normal_force, unit, uncertain);
        // What is given in its place has the spread.
        for (name, value) in machine.quantities() {
            if [PRESSURE, AREA].contains(&name) {
                given.push(named(name, value));
            }
        }
        given.push(line(&machine.motion.words("normal_force"), force));
    }
    given.extend(given_friction(all, written, uncertain));
    given.push(named("belt_speed", machine.belt_speed));
    let ratio = rich(" (damping ratio ").then(Rich::number(all.behaviour.damping_ratio, 3)).then(")");
    given.push(line("damping", of("damping", machine.damping).then(ratio)));
    given
}

fn given_friction(all: &Assessment, written: &Written, uncertain: &[Uncertain]) -> Vec<Line> {
    let machine = &all.machine;
    match &machine.friction {
        Friction::Coefficients(law, of) => {
            let number = |name: &str, value: f64| {
                with_spread(name, value, Unit::of(&all.machine, written, name), uncertain)
            };
            let rest = number("static_friction", of.static_friction);
            let kinetic = number("kinetic_friction", of.kinetic_friction);
            let width = number("stribeck_velocity", of.stribeck_velocity);
            let words = machine.words_of_friction().trim_start_matches("coefficient of ");
            let mut lines = vec![
                line("friction law", Rich::foreign(law.name())),
                line(&format!("{words} at rest, kinetic"), rest.then(", ").then(kinetic)),
            ];
            if Coefficients::names(law).any(|name| name == "stribeck_velocity") {
                lines.push(line("Stribeck velocity", width));
            }
            if of.strengthening > 0.0 {
                lines.push(line("strengthening", number("strengthening", of.strengthening)));
            }
            lines
        }
        Friction::Formula(formula, parameters) => {
            let name = machine.words_of_friction();
            let mut lines = vec![line(name, Rich::foreign(&formula.text()))];
            if formula.may_drop() {
                lines.push(line(&format!("{name} at rest"), Rich::number(formula.static_level(), 4)));
            }
            let named = formula.parameters().iter().zip(parameters.as_slice());
            let values = named.map(|(of, value)| {
                let is_fitted = |it: &&Uncertain| it.0 == of.name && matches!(it.1, Spread::Joint { .. });
                let is_fitted = uncertain.iter().any(|it| is_fitted(&it));
                let unit = match is_fitted {
                    true => machine.motion.unit_of_fitted(of.name, !machine.normal_force_is_known).into(),
                    false => Unit::of(machine, written, of.name),
                };
                Rich::foreign(&format!("{} = ", of.name)).then(with_spread(of.name, *value, unit, uncertain))
            });
            if !parameters.as_slice().is_empty() {
                lines.push(line("with", join(values)));
            }
            lines
        }
        Friction::Measured(table) => {
            let unit = if machine.normal_force_is_known { "" } else { machine.motion.unit(Dimension::Force) };
            let name = machine.words_of_friction();
            vec![line(name, table_in_words(table)), line("at rest", quantity(table.static_level(), unit))]
        }
    }
}

/// "pad.csv, 11 rows without standard errors", "pad.csv, 11 rows, standard errors (third column) 0.001 to
/// 0.008", "pad.csv, 33 rows averaged at 11 slip speeds, standard errors (by their scatter) 0.002".
fn table_in_words(table: &Table) -> Rich {
    let (rows, readings) = (table.data().count(), table.source().readings);
    let is_reduced = table.root_of_covariance().is_some();
    let averaged = readings > rows && !is_reduced;
    let count = match (is_reduced, averaged) {
        (true, _) => format!("{readings} rows reduced to a curve"),
        (false, true) => format!("{readings} rows averaged at {rows} slip speeds"),
        (false, false) => format!("{rows} rows"),
    };
    let text = Rich::foreign(&format!("{}, {count}", table.origin()));
    let Some(errors) = table.standard_errors() else { return text.then(" without standard errors") };
    let [least, most] = [f64::min, f64::max].map(|of| errors.iter().copied().reduce(of).unwrap_or(0.0));
    let range = if least < most {
        Rich::number(least, 2).then(" to ").then(Rich::number(most, 2))
    } else {
        Rich::number(most, 2)
    };
    let from = match (is_reduced || table.source().named_errors, averaged) {
        (_, true) => " (by their scatter)",
        (true, _) => "",
        (false, _) => " (third column)",
    };
    text.then(Rich::foreign(&format!(", standard errors{from} "))).then(range)
}

/// The limits of belt speed and damping.
fn limits(all: &Assessment, written: &Written) -> Vec<Line> {
    let does = &all.behaviour;
    let unit = Unit::of(&all.machine, written, "damping");
    let [of_slope, of_mean] = digits_of_data(all);
    let of_damping = |damping: f64| damping_limit(all, damping, of_slope, unit);
    let errors = all.standard_errors;
    let none = |limit: Option<WithError>| match limit {
        // Errors that may make it positive.
        Some(limit) if limit.value + 2.0 * limit.standard_error > 0.0 => {
            let limit = with_error(limit.value, limit.standard_error, 4, unit);
            rich("none by the curve through the data: ").then(limit)
        }
        _ => rich("none: it needs no damping"),
    };
    let critical = match (does.critical_damping, does.critical_damping_error) {
        (Some(damping), numerical) => {
            let of_data = all.standard_error_of(damping).unwrap_or(0.0);
            let apart = |error: &f64| *error > of_data && !Rich::shows_error(damping, *error, of_slope);
            let numerical = numerical.filter(apart).map_or_else(Rich::default, |error| {
                rich(" (numerical error ").then(unit.unnamed().number(error, 2)).then(")")
            });
            of_damping(damping).then(numerical)
        }
        _ if does.critical_damping_is_known => none(errors.and_then(|errors| errors.critical_damping)),
        _ => why_no_critical(all, written)
            .map_or_else(|| rich("not determined"), |why| rich("not determined: ").then(why)),
    };
    let mut limits = regime_lines(all);
    limits.extend(intervals::of_speeds(all, written));
    limits.extend(intervals::of_dampings(all, written));
    if intervals::sticks_from_the_least(all) {
        limits.push(line("may stick-slip below damping", critical));
    }
    limits.extend([
        line(
            "steady slip is unstable below damping",
            match all.hopf_damping > 0.0 {
                true => of_damping(all.hopf_damping),
                false if all.hopf_damping == 0.0 => rich("none: any damping makes it attract"),
                false => none(errors.map(|errors| errors.hopf_damping)),
            },
        ),
        line(
            "vibrates at all (stick-slip or slip cycle) below damping",
            match all.vibrates_below_damping {
                Some(0.0) => rich("none: it needs no damping"),
                Some(damping) => of_damping(damping),
                None => not_determined(all.slip_cycles_unknown.as_deref()),
            },
        ),
    ]);
    if let Some(errors) = errors {
        let words = format!("standard error by {}; not known of the other limits", errors.from.in_words());
        limits.push(line("the number behind ± is the", Rich::foreign(&words)));
    }
    limits.extend(unmeasured(all));
    limits.extend(all.needed_for_speeds.map(|needed| {
        let unit = all.machine.motion.unit(Dimension::Velocity);
        let needed = rich("about ").then(Rich::number(needed, 3)).with_unit(unit);
        line("measure up to", needed.then(": for the highest belt speed at which it may stick-slip"))
    }));
    if let Some(margin) = all.safety_margin() {
        limits.push(line("damping over critical damping", Rich::number(margin, of_mean)));
    }
    limits
}

/// Share of the weight of the friction's slope that may lie between two rows of a table.
const LARGEST_GAP: f64 = 0.4;

/// The slip speeds between two rows of measured friction on which the critical damping depends most, where more of
/// the weight lies between them than a curve through the rows can be trusted with.
fn unmeasured(all: &Assessment) -> Option<Line> {
    let Friction::Measured(table) = &all.machine.friction else { return None };
    let half = all.influence.first()?.slip_speed;
    let rows: Vec<f64> = table.data().map(|(speed, _)| speed).collect();
    let share = |ends: &[f64]| -> f64 {
        let inside =
            |middle: f64| (ends[1].min(middle + half) - ends[0].max(middle - half)).max(0.0) / (2.0 * half);
        all.influence.iter().map(|part| part.share * inside(part.slip_speed)).sum()
    };
    let (ends, share) =
        rows.windows(2).map(|ends| (ends, share(ends))).max_by(|one, other| one.1.total_cmp(&other.1))?;
    let unit = all.machine.motion.unit(Dimension::Velocity);
    let words = format!(
        "{} and {} {unit}: {:.0} % of the weight of the friction's slope lies between these rows",
        rounded(ends[0], 3),
        rounded(ends[1], 3),
        100.0 * share
    );
    (share > LARGEST_GAP).then(|| line("measure between", Rich::foreign(&words)))
}

/// "not determined", with the reason.
fn not_determined(why: Option<&str>) -> Rich {
    Rich::foreign(&why.map_or_else(|| "not determined".into(), |why| format!("not determined: {why}")))
}

/// The reason why a critical damping is not told.
pub(crate) fn why_no_critical(all: &Assessment, written: &Written) -> Option<Rich> {
    let does = &all.behaviour;
    let error = does.critical_damping_error.filter(|_| does.critical_damping.is_none())?;
    let error = Unit::of(&all.machine, written, "damping").number(error, 2);
    Some(rich("its error, ").then(error).then(", is more than 1 % of it"))
}

/// What the page says of a kick that the errors of the data leave open.
const KICK_LEFT_OPEN: &str = "the data leave open whether one is needed, and how large it is";

/// The reason why a kick is not determined: the data, that of the regime, or why slip cycles are unknown.
pub(crate) fn why_no_kick(all: &Assessment) -> Option<&str> {
    let of_regime = || all.undetermined.as_ref().and_then(|found| found.reasons.first());
    let of_motion = || of_regime().or(all.slip_cycles_unknown.as_ref()).map(String::as_str);
    all.is_left_open().then_some(KICK_LEFT_OPEN).or_else(of_motion)
}

/// Frequencies, times, amplitudes and kicks at the working point.
fn motion(all: &Assessment, written: &Written) -> Vec<Line> {
    let does = &all.behaviour;
    let [_, digits] = digits_of_data(all);
    // Velocities in the unit of the belt speed.
    let unit = |dimension: Dimension| match dimension {
        Dimension::Velocity => Unit::of(&all.machine, written, "belt_speed"),
        _ => all.machine.motion.unit(dimension).into(),
    };
    let of = |value: f64, dimension: Dimension| unit(dimension).number(value, digits);
    use Dimension::{Impulse, Length, Time, Velocity};
    let mut motion = vec![line("undamped natural frequency", quantity(does.natural_frequency, "Hz"))];
    if let Some(period) = all.period {
        let frequency = rich(" (").then(Rich::number(1.0 / period, digits)).then(" Hz)");
        motion.push(line("period of the vibration", of(period, Time).then(frequency)));
    }
    if let Some([slip, stick]) = does.slip_and_stick_time {
        motion.push(line("slip time, stick time", of(slip, Time).then(", ").then(of(stick, Time))));
    }
    if let Some(amplitude) = does.amplitude {
        motion.push(line("amplitude, half of peak to peak", of(amplitude, Length)));
    }
    if let Some(amplitude) = all.velocity_amplitude {
        motion.push(line("velocity amplitude", of(amplitude, Velocity)));
    }
    if let Some(severity) = all.severity {
        motion.push(line(
            "severity: (largest − smallest) / (2 mean) slip speed",
            Rich::number(severity, digits),
        ));
    }
    if let Some(time) = does.growth_time {
        let slope = Rich::number(time, digits_of_data(all)[0]).with_unit("s");
        motion.push(line("a disturbance of steady slip grows by the factor e in", slope));
    }
    let with_belt = match all.machine.motion {
        Motion::Translation => "kick that starts it: with the belt, against it",
        Motion::Rotation => "kick that starts it: with the rotation, against it",
    };
    let kick = |value: Rich| line("kick that starts it", value);
    motion.push(match all.needed_kick() {
        NeededKick::Kick(kick) => {
            let of = |value: f64, error: Option<f64>, dimension: Dimension| {
                let unit = unit(dimension);
                match (error, &all.machine.friction) {
                    (Some(error), _) => with_error(value, error, 4, unit),
                    // The errors of the data are not known, but they are seldom below a per cent.
                    (None, Friction::Measured(_)) => unit.number(value, 2),
                    (None, _) => quantity(value, unit),
                }
            };
            let errors = all.standard_errors.and_then(|errors| errors.kick);
            let both = |factor: f64, dimension: Dimension| {
                let (kick, errors) = (kick.times(factor), errors.map(|errors| errors.times(factor)));
                let forward = of(kick.forward, errors.map(|errors| errors.forward), dimension);
                forward.then(", ").then(of(kick.backward, errors.map(|errors| errors.backward), dimension))
            };
            let impulse = both(all.machine.mass, Impulse);
            line(with_belt, both(1.0, Velocity).then("; as impulses ").then(impulse))
        }
        NeededKick::NotNeeded => kick(rich("none is needed")),
        NeededKick::None => kick(rich("no kick of steady slip does")),
        NeededKick::NotDetermined => kick(not_determined(why_no_kick(all))),
    });
    if let Some([before, lasts]) = all.fragile {
        let of = |time: f64| quantity(time, "s");
        let when = rich("from ").then(of(before)).then(" before the mass leaves, for ").then(of(lasts));
        motion.push(line("a disturbance against the belt ends it", when));
    }
    motion
}

/// Sensitivities below this, in per cent for 1 %, are told as that: no quantity is known so well that they matter.
const LEAST_SENSITIVITY: f64 = 1e-3;

/// By how much the critical damping changes with each quantity, and how much of its uncertainty comes from each.
fn sensitivities(all: &Assessment, written: &Written, uncertain: &[Uncertain]) -> Vec<Line> {
    let machine = &all.machine;
    if all.sensitivities.is_empty() {
        let words = match all.behaviour.critical_damping {
            None if all.behaviour.critical_damping_is_known => "not at all: there is none",
            _ => "by an unknown amount: no critical damping is known next to it",
        };
        return vec![line("any quantity", rich(words))];
    }
    let values = machine.quantities();
    let lines = all.sensitivities.iter().map(|of| {
        let name = match of.quantity {
            "normal_force" if !machine.normal_force_is_known => "all friction forces".into(),
            name => machine.words(name),
        };
        if of.critical_damping.is_nan() {
            let error = Rich::number(of.critical_damping_error, 2);
            let why = rich("not known: its error, ").then(error).then(" % for 1 %, is too large");
            return (Rich::foreign(&name), why);
        }
        if of.critical_damping.abs() + of.critical_damping_error < LEAST_SENSITIVITY {
            let least = Rich::number(LEAST_SENSITIVITY, 1).then(" % for 1 %");
            return (Rich::foreign(&name), rich("less than ").then(least));
        }
        let per_cent = Rich::with_error(of.critical_damping, of.critical_damping_error, 3).then(" % for 1 %");
        // To first order.
        let spread = uncertain.iter().find(|(known, _)| *known == of.quantity).map(|(_, spread)| spread);
        let value = values.iter().find(|(known, _)| *known == of.quantity).map(|(_, value)| *value);
        let moved = spread.zip(value).zip(all.behaviour.critical_damping);
        let moved = moved.map(|((spread, value), critical)| {
            (of.critical_damping * critical * spread.sd(value) / value).abs()
        });
        let by_spread = moved.filter(|moved| *moved > 0.0).map_or_else(Rich::default, |moved| {
            rich("; by its spread ± ").then(Unit::of(&all.machine, written, "damping").number(moved, 2))
        });
        (Rich::foreign(&name), per_cent.then(by_spread))
    });
    lines.collect()
}

fn proved(all: &Assessment, uncertain: &[Uncertain]) -> Vec<Line> {
    let is_fitted = uncertain.iter().any(|(_, spread)| matches!(spread, Spread::Joint { .. }));
    let of_curve = match all.machine.friction {
        Friction::Measured(_) => ", for the curve through the data",
        // A probability beside it is of all that the errors leave.
        _ if is_fitted => ", for the fitted curve and no other within its errors",
        _ if !uncertain.is_empty() => ", for the values alone, without their spread",
        _ => "",
    };
    let deciding: Vec<_> = all.proofs.iter().filter(|proof| proof.verdict != "undecided").collect();
    let proved = match deciding.first() {
        Some(first) => {
            let tests: Vec<&str> = deciding.iter().map(|proof| proof.test).collect();
            format!("{}, proved by {}{of_curve}", first.verdict, tests.join(", ").replace('_', " "))
        }
        None => "no proof decides it".to_owned(),
    };
    let computed = format!("computed, with an error where it reaches the digits that are printed{of_curve}");
    vec![
        line("stick-slip cycle at the working point", Rich::foreign(&proved)),
        line("all numbers above", Rich::foreign(&computed)),
    ]
}

/// The attractors at the working point; where they are not determined, what is known and why the rest is not.
pub(super) fn regime_lines(all: &Assessment) -> Vec<Line> {
    const NAME: &str = "regime at the working point";
    let Some(Undetermined { sticks, stability, reasons }) = &all.undetermined else {
        let words = |regime| palette::regime(regime).words;
        let words = all
            .left_open()
            .map_or_else(|| words(all.behaviour.regime).into_owned(), |open| open.in_words(words));
        return vec![(rich(NAME), rich(&words))];
    };
    let mut lines = vec![
        (rich(NAME), rich("not determined in full")),
        (rich("what is known of it"), rich(&known_in_words(*sticks, *stability))),
    ];
    let whys = reasons.iter().map(|why| (rich("what is not, and why"), Rich::foreign(why)));
    lines.extend(whys);
    lines
}

/// What is known of a regime that is not determined in full.
pub(crate) fn known_in_words(sticks: Option<bool>, stability: Stability) -> String {
    let stick_slip = match sticks {
        Some(true) => "the stick-slip cycle attracts, ",
        Some(false) => "no stick-slip cycle exists, ",
        None => "",
    };
    let steady = match stability {
        Stability::Attracts => "steady slip attracts",
        Stability::Neutral => "steady slip neither attracts nor repels within rounding errors",
        Stability::Repels => "steady slip is unstable",
    };
    format!("{stick_slip}{steady}")
}

/// The probability of stick-slip, and the dampings for given probabilities.
fn risk_lines(all: &Assessment, written: &Written, risk: &Risk) -> Vec<Line> {
    let unit = Unit::of(&all.machine, written, "damping");
    let limits = |estimate: &WithLimits| {
        let [low, high] = estimate.limits.map(|limit| unit.unnamed().number(limit, 4));
        let value = unit.unnamed().number(estimate.value, 4);
        // Draws that hardly differ have limits that do not differ in print.
        let interval = match low.plain() == high.plain() {
            true => rich(""),
            false => rich(" (").then(low).then(" to ").then(high).then(")"),
        };
        value.then(interval).with_unit(unit.name)
    };
    let noun = if risk.draws == 1 { "draw" } else { "draws" };
    let mut lines = vec![
        (
            rich("probability that it vibrates by itself: steady slip is unstable"),
            rich(&percentage(&risk.by_itself)),
        ),
        (
            rich("probability that it may stick-slip (95 % limits)"),
            rich(&percentage(&risk.probability)).then(rich(&format!(", {} {noun}", risk.draws))),
        ),
    ];
    if risk.critical_damping_error > risk.standard_error.unwrap_or(0.0) {
        let error = unit.number(risk.critical_damping_error, 2);
        lines.push((rich("largest error met of a draw's critical damping"), error));
    }
    if let Some(error) = risk.standard_error {
        // As it stands after the critical damping.
        let critical = all.behaviour.critical_damping.unwrap_or(0.0);
        let error = unit.size * known_part(critical / unit.size, error / unit.size)[1];
        let value = unit.number(error, 2).then(", part of each draw");
        lines.push((rich("standard error of critical damping, by friction"), value));
    }
    for rare in &risk.rare_by {
        let share = Rich::number(100.0 * rare.probability, 4);
        let name = rich("damping above which that probability is below ").then(share).then(" %");
        let value = match &rare.damping {
            Some(damping) if damping.limits[1] == 0.0 => rich("none: it needs no damping"),
            Some(damping) => limits(damping),
            None => rich("too few draws"),
        };
        lines.push((name, value));
    }
    lines.push((rich("limits in brackets"), rich("those of the sampling by draws alone, 95 %")));
    lines
}

/// A share in per cent, to two decimals. A share that is not 0 or 1 but would be printed so is given as
/// "< 0.01" or "> 99.99".
pub fn percent(share: f64) -> String {
    match 100.0 * share {
        0.0 => "0".into(),
        100.0 => "100".into(),
        percent if percent < 0.01 => "< 0.01".into(),
        percent if percent > 99.99 => "> 99.99".into(),
        percent => {
            let text = format!("{percent:.2}");
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        }
    }
}

/// A share in per cent with its limits, where these differ in print.
pub(super) fn percentage(share: &WithLimits) -> String {
    let [low, high] = share.limits.map(percent);
    let interval = if low == high { String::new() } else { format!(" ({low} to {high})") };
    format!("{}{interval} %", percent(share.value))
}
