//! The summary on the first screen of a report.

use super::figure::picks;
use super::tables::{friction, undetermined_regimes};
use super::view::View;
use super::{Confusion, Report, SIMULATION};
use slipmap_column::Verdict;
use slipmap_figure::axis::extremes;
use slipmap_figure::text::join;
use slipmap_figure::text::{Rich, rich};
use slipmap_machine::Dimension;
use slipmap_machine::behaviour::behaviour;
use slipmap_map::dataset::auxiliary::PROBABILITY;
use slipmap_numbers::text::count;
use slipmap_page::percent;

/// Bound on the error of the scaled grazing margin for a machine.
const TOLERANCE: f64 = 1e-9;

/// The smallest and the largest probability that the machine may stick-slip; `None` for a map without them.
fn probabilities(view: &View) -> Option<(f64, f64)> {
    let map = view.map;
    let axes = map.grid().axes().len();
    let all: Vec<usize> = (0..axes).collect();
    let values = map
        .has_probability()
        .then(|| map.real_slice(PROBABILITY, &picks(map, &all, &vec![0; axes], axes)).ok());
    let values = values.flatten()?;
    let (least, most) = extremes(values.iter().copied().filter(|value| value.is_finite()));
    (least <= most).then_some((least, most))
}

/// The lines of the summary: a name and its value.
pub(super) fn summary(view: &View, report: &Report) -> Vec<(Rich, Rich)> {
    let map = view.map;
    let axes = map.grid().axes();
    let mut lines = Vec::new();
    let mut line = |name: &str, value: Rich| lines.push((rich(name), value));
    if let Some(model) = view.model() {
        let (point, si) = (&model.point, &model.si);
        let quantity = |value: f64, dimension| Rich::number(value, 4).with_unit(si.unit(dimension));
        // In the units of the axes, as the figures are.
        let speed_axis = view.axis(&axes[axes.len() - 2]);
        let in_axis = |si: f64| Rich::number(si * speed_axis.factor, 4).with_unit(&speed_axis.unit);
        let speed = in_axis(point.belt_speed * si.velocity);
        let damping = quantity(point.damping * si.damping, Dimension::Damping);
        let at_speed = rich(" at ").then(speed_axis.name.clone()).then(" ").then(speed.clone());
        let does = behaviour(&model, TOLERANCE);
        if let Some(held) = view.model_words() {
            line("machine of these lines", held);
        }
        if let Some(critical) = does.critical_damping {
            let error = does.critical_damping_error.unwrap_or(0.0);
            let value = Rich::with_error(critical, error, 4).with_unit(si.unit(Dimension::Damping));
            line("critical damping", value.then(at_speed.clone()));
        }
        if let Some(critical) = does.critical_belt_speed.value() {
            let value = in_axis(critical).then(" at damping ");
            line(&format!("critical {}", speed_axis.name.plain()), value.then(damping.clone()));
        }
        if let Some(amplitude) = does.amplitude {
            let at = at_speed.then(" and damping ").then(damping);
            line("amplitude", quantity(amplitude, Dimension::Length).then(at));
        }
        line("natural frequency", Rich::number(does.natural_frequency, 4).then(" Hz"));
    }
    if let Some((least, most)) = probabilities(view) {
        let range = match least == most {
            true => percent(least),
            false => format!("{} to {}", percent(least), percent(most)),
        };
        let words = format!("{range} % over the map, {PROBABILITY} in it");
        line("probability that it may stick-slip, by the uncertain quantities", Rich::foreign(&words));
    }
    let cells = count(map.grid().cells() as u64);
    line("friction law", Rich::foreign(map.grid().law().name()).then(": ").then(friction(view)));
    let extents = axes
        .iter()
        .filter(|axis| axis.values.len() > 1)
        .map(|axis| rich(&format!("{} ", axis.values.len())).then(view.axis(axis).extent(&axis.values, 4)));
    let extents = join(extents);
    let separator = rich(if extents.pieces.is_empty() { "" } else { ": " });
    line("cells", Rich::foreign(&cells).then(separator).then(extents));
    let verdicts = &report.verdicts;
    let total = |method: usize, verdict: Verdict| -> u64 {
        verdicts.confusion[method].iter().map(|counts| counts.method(verdict)).sum()
    };
    if let Some(simulation) = verdicts.simulation {
        let (present, absent) = (total(simulation, Verdict::Present), total(simulation, Verdict::Absent));
        line(
            "stick-slip cycle",
            Rich::foreign(&format!(
                "in {} cells by simulation; none in {}; {} without a verdict",
                count(present),
                count(absent),
                count(map.grid().cells() as u64 - present - absent)
            )),
        );
    }
    let mut proved = Vec::new();
    let mut wrong = Vec::new();
    for (number, method) in map.methods().iter().enumerate().filter(|(_, method)| method.name() != SIMULATION)
    {
        let name = method.name().replace('_', " ");
        let confusion = &verdicts.confusion[number];
        let mistakes: u64 = confusion
            .iter()
            .map(|c| c.pair(Verdict::Absent, Verdict::Present) + c.pair(Verdict::Present, Verdict::Absent))
            .sum();
        let decided: u64 = confusion.iter().map(Confusion::claims).sum();
        let percent = 100.0 * decided as f64 / map.grid().cells() as f64;
        let claims = |what: String| match decided {
            0 => Rich::foreign(&format!("{name} no claims")),
            _ => Rich::foreign(&what),
        };
        if method.guarantee().is_rigorous() {
            proved.push(claims(format!("{name} {percent:.1} %")));
        } else if verdicts.simulation.is_some() {
            wrong.push(claims(format!("{name} {}", count(mistakes))));
        }
    }
    if !proved.is_empty() {
        let all = 100.0 * verdicts.proved as f64 / map.grid().cells() as f64;
        line("decided by proof", Rich::foreign(&format!("{all:.1} % of the cells: ")).then(join(proved)));
    }
    if !wrong.is_empty() {
        line("wrong cells", join(wrong));
    }
    let unknown = undetermined_regimes(map).unwrap_or(0);
    if unknown > 0 {
        line("regime not determined", Rich::foreign(&format!("in {} cells", count(unknown))));
    }
    if let Some(cells) = map.number("audit_cells") {
        let against = map.number("audit_disagreements").unwrap_or(f64::NAN);
        line(
            "audit",
            Rich::foreign(&format!(
                "{} cells decided again by the direct engine, {} contradicted",
                count(cells as u64),
                count(against as u64)
            )),
        );
    }
    lines
}
