//! The engineer's page: an assessment of a machine at its working point, on one page as a figure or as HTML.

use std::convert::Infallible;
use std::sync::{Mutex, PoisonError};

use super::document;
use super::figure::axis::{AXIS, SMALL_TEXT, Scale, TEXT};
use super::figure::legend::{Legend, Sample};
use super::figure::palette;
use super::figure::panels::{BOTTOM_MARGIN, Panel, TITLE_MARGIN, left_margin, wrap};
use super::figure::region::{cell_edges, outlines};
use super::figure::scene::{Anchor, Fill, Marker, Rect, Scene};
use super::figure::{Scene as Figure, bifurcations};
use super::text::{Rich, rich};
use super::units::{UnitSystem, join};
use crate::assessment::{Assessment, Undetermined};
use crate::behaviour::Limit;
use crate::friction::Column;
use crate::machine::{Dimension, Friction, Model, Motion, scatter};
use crate::map::{
    self, Account, Control, Field, Grid, Method, Plan, Plane, PlaneCurve, PlaneCurves, PlanePoint, Regime,
    Sink, TileData,
};
use crate::point::Point;
use crate::risk::{Estimate, Risk};
use crate::simulate::bifurcation::Bifurcation;
use crate::simulate::critical::critical_dampings;

/// Number of nodes of the regime figure along each axis.
const NODES: usize = 41;
/// Accuracy of its cells.
const TOLERANCE: f64 = 1e-8;
/// Size of the page: A4, in points.
const PAGE: (f64, f64) = (595.0, 842.0);
const MARGIN: f64 = 42.0;

/// The page. Its figures are computed when it is drawn.
#[derive(Debug)]
pub(crate) struct MachinePage<'a> {
    /// Questions and answers, section by section.
    pub(crate) sections: Vec<(&'static str, Vec<(Rich, Rich)>)>,
    /// The answer in a sentence.
    pub(crate) answer: Rich,
    all: &'a Assessment,
    title: Rich,
}

impl<'a> MachinePage<'a> {
    /// The page of a machine, the working point at `all.machine`.
    pub(crate) fn new(title: &str, all: &'a Assessment, risk: Option<&Risk>) -> Self {
        let mut sections = sections(all);
        if let Some(risk) = risk {
            sections.insert(2, ("Uncertain quantities", risk_lines(all, risk)));
        }
        Self { sections, answer: in_words(all), all, title: Rich::foreign(title) }
    }

    /// The regimes around the working point, and the weights of slip speeds.
    fn figures(&self) -> (Figure, Option<Figure>) {
        (regimes(self.all), (!self.all.influence.is_empty()).then(|| influence(self.all)))
    }

    /// One page of A4.
    pub(crate) fn scene(&self) -> Scene {
        let mut scene = Scene::new(PAGE.0, PAGE.1);
        let mut y = MARGIN + 6.0;
        scene.text((MARGIN, y), &self.title, 12.0, Anchor::Start);
        y += 2.0;
        for line in lines_of_page(&self.answer) {
            y += TEXT + 3.0;
            scene.text((MARGIN, y), &line, TEXT, Anchor::Start);
        }
        y += 6.0;
        for (heading, lines) in &self.sections {
            y += 13.0;
            scene.text((MARGIN, y), &rich(heading), TEXT + 1.0, Anchor::Start);
            scene.line(&[(MARGIN, y + 3.0), (PAGE.0 - MARGIN, y + 3.0)], &AXIS);
            y += 4.0;
            for (name, value) in lines {
                y += TEXT + 2.6;
                scene.text((MARGIN, y), name, TEXT, Anchor::Start);
                scene.text((MARGIN + 250.0, y), value, TEXT, Anchor::Start);
            }
        }
        y += 18.0;
        let half = 0.5 * (PAGE.0 - 2.0 * MARGIN);
        let (regimes, influence) = self.figures();
        scene.place((MARGIN, y), &regimes);
        if let Some(influence) = &influence {
            scene.place((MARGIN + half + 6.0, y), influence);
        }
        scene
    }

    /// The title of the page, with its subject.
    pub(crate) fn caption(&self) -> Rich {
        rich("Assessment of a machine: ").then(self.title.clone())
    }

    /// The page as self-contained HTML.
    pub(crate) fn html(&self) -> String {
        let mut body = format!("<p>{}</p>\n", self.answer.html());
        for (heading, lines) in &self.sections {
            body.push_str(&format!("<h2>{heading}</h2>\n<dl class=\"summary\">\n"));
            for (name, value) in lines {
                body.push_str(&format!("<dt>{}</dt><dd>{}</dd>\n", name.html(), value.html()));
            }
            body.push_str("</dl>\n");
        }
        let (regimes, influence) = self.figures();
        let figures = [
            (
                "regimes",
                Some(&regimes),
                "Long-run behaviour over belt speed and damping; mark: the working point.",
            ),
            ("influence", influence.as_ref(), "Share of each slip speed in the critical damping."),
        ];
        for (name, figure, words) in figures {
            if let Some(figure) = figure {
                let svg = figure.svg(name, &rich(words));
                body.push_str(&format!("<figure>\n{svg}<figcaption>{words}</figcaption>\n</figure>\n"));
            }
        }
        document::page(&self.title, &body)
    }
}

/// The lines of a text as wide as the page.
fn lines_of_page(text: &Rich) -> Vec<Rich> {
    // It measures small text.
    wrap(text, (PAGE.0 - 2.0 * MARGIN) * SMALL_TEXT / TEXT)
}

fn quantity(value: f64, unit: &str) -> Rich {
    Rich::number(value, 4).with_unit(unit)
}

fn sections(all: &Assessment) -> Vec<(&'static str, Vec<(Rich, Rich)>)> {
    let (machine, does) = (&all.machine, &all.behaviour);
    let unit = |dimension| machine.motion.unit(dimension);
    let of = |value: f64, dimension: Dimension| quantity(value, unit(dimension));
    use Dimension::{Damping, Force, Length, Mass, Stiffness, Time, Velocity};
    let line = |name: &str, value: Rich| (rich(name), value);
    let of_velocity = |value: f64| of(value, Velocity);
    let mut given =
        vec![line("mass", of(machine.mass, Mass)), line("stiffness", of(machine.stiffness, Stiffness))];
    if machine.normal_force_is_known {
        given.push(line("normal force", of(machine.normal_force, Force)));
    }
    match &machine.friction {
        Friction::Coefficients(law, of) => {
            let rest = quantity(of.static_friction, "").then(", ");
            given.push(line("friction law", Rich::foreign(law.name())));
            let both = rest.then(quantity(of.kinetic_friction, ""));
            given.push(line("coefficient of friction at rest, kinetic", both));
            given.push(line("Stribeck velocity", of_velocity(of.stribeck_velocity)));
            if of.strengthening > 0.0 {
                given.push(line("strengthening", quantity(of.strengthening, "")));
            }
        }
        Friction::Formula(formula, parameters) => {
            given.push(line("coefficient of friction", Rich::foreign(formula.text())));
            let named = formula.parameters().iter().zip(parameters.as_slice());
            let values = named
                .map(|(of, value)| Rich::foreign(&format!("{} = ", of.name)).then(Rich::number(*value, 4)));
            if !parameters.as_slice().is_empty() {
                given.push(line("with", join(values)));
            }
        }
        Friction::Measured(table) => {
            let (name, unit) = match machine.normal_force_is_known {
                true => ("coefficient of friction", ""),
                false => ("friction force", unit(Force)),
            };
            given.push(line(name, Rich::foreign(table.origin())));
            given.push(line("at rest", quantity(table.static_level(), unit)));
        }
    }
    given.push(line("belt speed", of(machine.belt_speed, Velocity)));
    let ratio = rich(" (damping ratio ").then(Rich::number(does.damping_ratio, 3)).then(")");
    given.push(line("damping", of(machine.damping, Damping).then(ratio)));

    let with_error = |damping: f64| match all.standard_error_of(damping) {
        Some(error) => {
            let error = Rich::number(error, 2);
            of(damping, Damping).then(", ± ").then(error).then(" by the standard errors of the data")
        }
        None => of(damping, Damping),
    };
    let critical = match (does.critical_damping, does.critical_damping_error) {
        (Some(damping), _) if all.standard_error_of(damping).is_some() => with_error(damping),
        (Some(damping), Some(error)) => {
            Rich::number(damping, 4).then(" ± ").then(Rich::number(error, 2)).with_unit(unit(Damping))
        }
        _ if does.critical_damping_is_known => rich("none: it needs no damping"),
        _ => rich("not determined"),
    };
    let below = |limit: &Limit, otherwise: &str| match limit {
        Limit::Below(speed) => of(*speed, Velocity),
        Limit::Everywhere => rich("any, up to 1,000 times the belt speed"),
        Limit::NotFound => rich(otherwise),
    };
    let mut limits = regime_lines(all);
    limits.extend([
        line(
            "stick-slips whatever the start below belt speed",
            below(&all.always_below_speed, "none was found"),
        ),
        line("may stick-slip below belt speed", below(&does.critical_belt_speed, "no limit was found")),
        line(
            "stick-slips whatever the start below damping",
            all.always_below_damping.map_or_else(|| rich("none was found"), with_error),
        ),
        line("may stick-slip below damping", critical),
        line(
            "steady slip is unstable below damping",
            match all.hopf_damping > 0.0 {
                true => with_error(all.hopf_damping),
                false => rich("none: it needs no damping"),
            },
        ),
        line(
            "vibrates at all (stick-slip or slip cycle) below damping",
            match all.vibrates_below_damping {
                Some(0.0) => rich("none: it needs no damping"),
                Some(damping) => with_error(damping),
                None => rich("not determined"),
            },
        ),
    ]);
    if all.standard_errors.is_some() {
        let words = "not known; they depend on the slope of the data there";
        limits.push(line("standard errors of the other limits", rich(words)));
    }
    if let Some(margin) = all.safety_margin() {
        limits.push(line("damping over critical damping", quantity(margin, "")));
    }

    let mut motion = vec![line("undamped natural frequency", quantity(does.natural_frequency, "Hz"))];
    if let Some(period) = all.period {
        let frequency = rich(" (").then(quantity(1.0 / period, "Hz")).then(")");
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
    match all.kick {
        Some(kick) => motion.push(line(
            "kick that starts it: with the belt, against it",
            of(kick.forward, Velocity).then(", ").then(of(kick.backward, Velocity)),
        )),
        None => motion.push(line(
            "kick that starts it",
            rich(match does.regime {
                Regime::StickSlip | Regime::PureSlip | Regime::Crossing => "none is needed",
                Regime::Equilibrium => "no kick of steady slip does",
                // A cycle that crosses the belt line may be started by a kick that is not computed.
                _ => "not determined",
            }),
        )),
    }

    let unknown =
        line("any quantity", rich("by an unknown amount: no critical damping was found next to it"));
    let sensitivities = all.sensitivities.is_empty().then_some(unknown).into_iter();
    let sensitivities = sensitivities.chain(all.sensitivities.iter().map(|s| {
        let text = rich("").then(Rich::number(s.critical_damping, 3)).then(" % for 1 %");
        let name = match s.quantity {
            "normal_force" if !machine.normal_force_is_known => "all friction forces".into(),
            name => name.replace('_', " ").replace("stribeck", "Stribeck"),
        };
        line(&name, text)
    }));
    let mut sections = vec![
        ("Machine", given),
        ("Limits", limits),
        ("Motion", motion),
        ("Critical damping changes with", sensitivities.collect()),
    ];
    let deciding: Vec<_> = all.proofs.iter().filter(|proof| proof.verdict != "undecided").collect();
    let proved = match deciding.first() {
        Some(first) => {
            let tests: Vec<&str> = deciding.iter().map(|proof| proof.test).collect();
            format!("{}, proved by {}", first.verdict, tests.join(", ").replace('_', " "))
        }
        None => "no proof decides it".to_owned(),
    };
    sections.push((
        "What is proved and what is computed",
        vec![
            line("stick-slip cycle at the working point", Rich::foreign(&proved)),
            line("all numbers above", rich("computed: orbits to 1e-9, sensitivities to 1e-5")),
        ],
    ));
    sections
}

/// What attracts at the working point; where that is not determined what is known of it, and why the rest is not.
fn regime_lines(all: &Assessment) -> Vec<(Rich, Rich)> {
    const NAME: &str = "regime at the working point";
    let Some(Undetermined { sticks, is_stable, reasons }) = &all.undetermined else {
        return vec![(rich(NAME), rich(&palette::regime(all.behaviour.regime).words))];
    };
    let stick_slip = match sticks {
        Some(true) => "the stick-slip cycle attracts, ",
        Some(false) => "no stick-slip cycle exists, ",
        None => "",
    };
    let steady = if *is_stable { "steady slip attracts" } else { "steady slip is unstable" };
    let mut lines = vec![
        (rich(NAME), rich("not determined in full")),
        (rich("what is known of it"), rich(&format!("{stick_slip}{steady}"))),
    ];
    let whys = reasons.iter().map(|why| (rich("what is not, and why"), Rich::foreign(why)));
    lines.extend(whys);
    if let Friction::Measured(table) = &all.machine.friction
        && let Some((turns, rows)) = scatter(table)
    {
        let name = format!("the table changes its direction at {turns} of {rows} rows");
        let advice = "average neighbouring rows into 10 to 20 speeds, with their errors";
        lines.push((rich(&name), rich(advice)));
    }
    lines
}

/// The answer in a sentence.
fn in_words(all: &Assessment) -> Rich {
    let (machine, does) = (&all.machine, &all.behaviour);
    let of = |value: f64, dimension| quantity(value, machine.motion.unit(dimension));
    let motion = |words: &str| {
        let place = rich(words).then(" at ").then(of(machine.belt_speed, Dimension::Velocity));
        let place = place.then(" and ").then(of(machine.damping, Dimension::Damping));
        let Some((period, amplitude)) = all.period.zip(does.amplitude) else { return place };
        let amplitude = match machine.motion {
            Motion::Translation => Rich::number(1e3 * amplitude, 2).with_unit("mm"),
            Motion::Rotation => Rich::number(amplitude, 2).with_unit("rad"),
        };
        let frequency = Rich::number(1.0 / period, 2).with_unit("Hz");
        place.then(" (").then(frequency).then(", ").then(amplitude).then(")")
    };
    let limit = |damping: f64| Rich::number(damping, 3).with_unit(machine.motion.unit(Dimension::Damping));
    let (words, vibrates) = match does.regime {
        Regime::StickSlip => ("Stick-slips from every start", true),
        Regime::Bistable => ("Slips steadily or stick-slips, as it starts,", true),
        Regime::PureSlip => ("Vibrates from every start, without sticking,", true),
        Regime::Equilibrium => ("Slips steadily from every start", false),
        Regime::Failed => match &all.undetermined {
            Some(Undetermined { sticks: Some(true), .. }) => ("Stick-slips at least from some starts", true),
            _ => return motion("What it does is not determined").then("."),
        },
        regime => {
            let words = palette::regime(regime).words;
            return motion(&format!("Does, as it starts, one of: {words};")).then(".");
        }
    };
    let sentence = motion(words);
    let (stick_slip, all_vibration) = (does.critical_damping, all.vibrates_below_damping);
    match (vibrates, stick_slip, all_vibration) {
        (true, Some(stick_slip), Some(every))
            if every > stick_slip * (1.0 + 1e-6) && stick_slip > machine.damping =>
        {
            let first = sentence
                .then("; more than ")
                .then(limit(stick_slip))
                .then(" ends stick-slip")
                .then(", ")
                .then("more than ");
            first.then(limit(every)).then(" every vibration.")
        }
        (true, _, Some(every)) => sentence.then("; more than ").then(limit(every)).then(" ends it."),
        (true, Some(stick_slip), None) => {
            sentence.then("; more than ").then(limit(stick_slip)).then(" ends stick-slip.")
        }
        (false, _, Some(every)) if every > 0.0 => {
            sentence.then("; it may vibrate below ").then(limit(every)).then(".")
        }
        _ => sentence.then("."),
    }
}

/// The probability of stick-slip, and the dampings for given probabilities.
fn risk_lines(all: &Assessment, risk: &Risk) -> Vec<(Rich, Rich)> {
    let unit = all.machine.motion.unit(Dimension::Damping);
    let limits = |estimate: &Estimate| {
        let [low, high] = estimate.limits.map(|limit| Rich::number(limit, 4));
        let value = Rich::number(estimate.value, 4);
        // Draws that hardly differ have limits that do not differ in print.
        let interval = match low.plain() == high.plain() {
            true => rich(""),
            false => rich(" (").then(low).then(" to ").then(high).then(")"),
        };
        value.then(interval).with_unit(unit)
    };
    let mut lines = vec![(
        rich("probability that it may stick-slip (95 % limits)"),
        rich(&percentage(&risk.probability)).then(rich(&format!(", {} draws", risk.draws))),
    )];
    if risk.critical_damping_error > 0.0 {
        let error = Rich::number(risk.critical_damping_error, 2).with_unit(unit);
        lines.push((rich("largest error met of a draw's critical damping"), error));
    }
    if let Some(error) = risk.standard_error {
        let value = Rich::number(error, 3).then(Rich::foreign(&format!(" {unit}, part of each draw")));
        lines.push((rich("standard error of critical damping, by friction"), value));
    }
    for rare in &risk.rare_by {
        let name = rich("damping that makes it ").then(Rich::number(100.0 * rare.probability, 4)).then(" %");
        let value = rare.damping.as_ref().map_or_else(|| rich("too few draws"), limits);
        lines.push((name, value));
    }
    lines.push((rich("limits in brackets"), rich("those of the sampling by draws alone, 95 %")));
    lines
}

/// A share in per cent, to two decimals: what would be printed as 0 or 100 but is not is given as beyond the
/// last number that can be.
fn percent(share: f64) -> String {
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
fn percentage(share: &Estimate) -> String {
    let [low, high] = share.limits.map(percent);
    let interval = if low == high { String::new() } else { format!(" ({low} to {high})") };
    format!("{}{interval} %", percent(share.value))
}

/// Width of a figure on the page, in points.
const FIGURE: f64 = 252.0;

/// Codes of regimes, column by column.
#[derive(Default)]
struct Columns(Mutex<Vec<(usize, Vec<i8>)>>);

impl Sink for Columns {
    type Packed = (usize, Vec<i8>);
    type Error = Infallible;

    fn pack(&self, data: &TileData) -> Result<Self::Packed, Infallible> {
        Ok((data.tile.number, data.regime.values().map(Regime::code).collect()))
    }

    fn write(&self, column: Self::Packed, _: &Account) -> Result<(), Infallible> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(column);
        Ok(())
    }
}

/// Codes of the regimes over belt speeds (slower) and dampings.
fn regimes_over(grid: &Grid) -> Option<Vec<Vec<i8>>> {
    let mut column = vec![1; grid.axes().len()];
    *column.last_mut()? = grid.dampings().len();
    let plan = Plan::builder(grid.clone())
        .methods([Method::Simulation])
        .fields([Field::Verdict, Field::Regime])
        .tolerance(TOLERANCE)
        .audit_cells(0)
        .tile_shape(column)
        .build();
    let columns = Columns::default();
    map::run(&plan.ok()?, &columns, &Control::default()).ok()?;
    let mut columns = columns.0.into_inner().unwrap_or_else(PoisonError::into_inner);
    columns.sort_unstable();
    Some(columns.into_iter().map(|(_, codes)| codes).collect())
}

/// The Hopf damping and the critical damping over belt speeds: of every law in little time, which
/// continuation in the plane is not.
fn limits(grid: &Grid, point: &Point, speeds: &[f64]) -> Vec<PlaneCurve> {
    let columns: Vec<Column> =
        speeds.iter().map(|&belt_speed| grid.law().column(&Point { belt_speed, ..*point })).collect();
    let hopf = columns.iter().map(|column| column.curve.weakening(column.belt_speed) / column.epsilon);
    let grazing =
        critical_dampings(&columns, TOLERANCE).into_iter().map(|root| root.map_or(f64::NAN, |root| root.c));
    let curve = |bifurcation, dampings: Vec<f64>| {
        let all = speeds.iter().zip(dampings).filter(|(_, damping)| damping.is_finite());
        let points = all.map(|(&x, y)| PlanePoint { x, y, error: TOLERANCE }).collect();
        PlaneCurve { bifurcation, points }
    };
    vec![curve(Bifurcation::Hopf, hopf.collect()), curve(Bifurcation::GrazingSliding, grazing.collect())]
}

/// The panel of a figure, and the width of its labels.
fn panel(x: Scale, y: Scale) -> (Panel, f64) {
    const HEIGHT: f64 = 150.0;
    let labels = Panel::y_labels_width(y, HEIGHT);
    let left = left_margin(labels);
    let rect = Rect { x: left, y: TITLE_MARGIN, w: FIGURE - left - 12.0, h: HEIGHT };
    (Panel { rect, x, y }, labels)
}

/// The regimes around the working point, with the curves between them.
fn regimes(all: &Assessment) -> Scene {
    let machine = &all.machine;
    let units = machine.units();
    let does = &all.behaviour;
    let speed = does.critical_belt_speed.value().unwrap_or(machine.belt_speed).max(machine.belt_speed) * 1.4;
    let damping =
        does.critical_damping.unwrap_or(machine.damping).max(machine.damping).max(1e-3 * units.damping) * 1.6;
    let nodes = |to: f64, least: f64| -> Vec<f64> {
        (0..NODES).map(|i| (i as f64 / (NODES - 1) as f64 * to).max(least)).collect()
    };
    let speeds = nodes(speed / units.velocity, 0.02 * speed / units.velocity / NODES as f64);
    let dampings = nodes(damping / units.damping, 0.0);
    let system = UnitSystem::of_machine(machine.si());
    let velocity = system.quantity("belt speed", Rich::default(), "", Some(Dimension::Velocity));
    let friction = system.quantity("damping", Rich::default(), "", Some(Dimension::Damping));
    let x = Scale::linear(speeds[0], speeds[NODES - 1]).in_unit(velocity.factor);
    let y = Scale::linear(0.0, dampings[NODES - 1]).in_unit(friction.factor);
    let mut scene = Scene::new(FIGURE, 0.0);
    let (panel, labels) = panel(x, y);
    panel.title(&mut scene, &rich("Regimes; diamond: the working point"));
    let mut legend = Legend::default();
    let Some(Model { law, point, .. }) = machine.model() else { return scene };
    let mut axes = vec![vec![1.0]];
    axes.extend(point.law.as_slice().iter().map(|value| vec![*value]));
    axes.extend([speeds.clone(), dampings.clone()]);
    let grid = Grid::new(law, axes).ok();
    let cells = grid.as_ref().and_then(regimes_over).unwrap_or_default();
    let code = |i: usize, j: usize| cells.get(i).and_then(|column: &Vec<i8>| column.get(j)).copied();
    let edges = (cell_edges(&speeds, x), cell_edges(&dampings, y));
    for kind in palette::regimes() {
        let areas = outlines(&panel, &edges.0, &edges.1, |i, j| code(i, j) == Some(kind.code));
        if !areas.is_empty() {
            scene.area(&areas, kind.fill);
            legend.add(Sample::Area(kind.fill), rich(&kind.words));
        }
    }
    if let Some(grid) = grid {
        let last = grid.axes().len() - 1;
        let plane = Plane::new(last - 1, last, vec![0; last + 1]);
        let curves = PlaneCurves { plane, curves: limits(&grid, &point, &speeds) };
        bifurcations::draw(&mut scene, &panel, &curves, &mut legend);
    }
    let here = panel.place(machine.belt_speed / units.velocity, machine.damping / units.damping);
    scene.marker(Marker::Diamond, here, 8.0, palette::WHITE, true);
    scene.marker(Marker::Diamond, here, 6.0, palette::VERMILION, true);
    panel.named_axes(&mut scene, &velocity.text(), &friction.text(), labels);
    legend.below(&mut scene, panel.rect.x, panel.rect.y + panel.rect.h + BOTTOM_MARGIN);
    scene
}

/// The weights of slip speeds, as bars.
fn influence(all: &Assessment) -> Scene {
    let parts = &all.influence;
    let width = parts[0].slip_speed * 2.0;
    let most = parts.iter().map(|part| part.share).fold(0.0, f64::max);
    let (x, y) = (Scale::linear(0.0, width * parts.len() as f64), Scale::linear(0.0, 105.0 * most));
    let mut scene = Scene::new(FIGURE, 0.0);
    let (panel, labels) = panel(x, y);
    for part in parts {
        let low = panel.place(part.slip_speed - 0.5 * width, 0.0);
        let high = panel.place(part.slip_speed + 0.5 * width, 100.0 * part.share);
        scene.rect(
            Rect { x: low.0, y: high.1, w: high.0 - low.0, h: low.1 - high.1 },
            Fill::plain(palette::SKY),
        );
    }
    let velocity = all.machine.motion.unit(Dimension::Velocity);
    panel.title(&mut scene, &rich("Slip speeds of the friction curve that matter"));
    let name = Rich::foreign(&format!("slip speed, {velocity}"));
    panel.named_axes(&mut scene, &name, &rich("share in the critical damping, %"), labels);
    scene.height = panel.rect.y + panel.rect.h + BOTTOM_MARGIN + SMALL_TEXT;
    scene
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assessment::assess;
    use crate::friction::{Expression, Law, Table};
    use crate::machine::{Machine, example};
    use crate::point::LawParameters;
    use crate::report::figure::scene::text_width;

    #[test]
    fn a_critical_damping_that_was_not_found_is_not_told_as_none() {
        let mut all = assess(&example(Law::Exponential)).unwrap();
        let words = |all: &Assessment| {
            let all_lines = sections(all).into_iter().flat_map(|(_, lines)| lines);
            let mut values = all_lines.filter(|(name, _)| name.plain() == "may stick-slip below damping");
            values.next().unwrap().1.plain()
        };
        assert!(words(&all).contains("N s/m"));
        all.behaviour.critical_damping = None;
        assert_eq!(words(&all), "none: it needs no damping");
        all.behaviour.critical_damping_is_known = false;
        assert_eq!(words(&all), "not determined");
    }

    #[test]
    fn what_is_known_of_an_undetermined_regime_is_told() {
        let row = |i: i32| (0.01 * f64::from(i), 0.4 - 0.002 * f64::from(i) + 0.005 * f64::from(i % 2));
        let table = Table::new("a rig", &(0..60).map(row).collect::<Vec<_>>(), 0.4).unwrap();
        let mut all = assess(&example(Law::Exponential)).unwrap();
        all.machine.friction = Friction::Measured(table);
        all.behaviour.regime = Regime::Failed;
        let reasons = vec!["slip cycles: the step budget ran out".to_owned()];
        all.undetermined = Some(Undetermined { sticks: Some(true), is_stable: false, reasons });
        let lines = regime_lines(&all).into_iter();
        let lines: Vec<_> =
            lines.map(|(name, value)| format!("{}: {}", name.plain(), value.plain())).collect();
        let expected = [
            "regime at the working point: not determined in full",
            "what is known of it: the stick-slip cycle attracts, steady slip is unstable",
            "what is not, and why: slip cycles: the step budget ran out",
            "the table changes its direction at 58 of 60 rows: average neighbouring rows into 10 to 20 speeds, with \
             their errors",
        ];
        assert_eq!(lines, expected);
        assert!(in_words(&all).plain().starts_with("Stick-slips at least from some starts at "));
    }

    #[test]
    fn the_answer_is_a_sentence() {
        let machine = |damping: f64| {
            let law = Expression::new("0.25 + 0.15*exp(-(u/0.05)^2)", 1.0).unwrap();
            let friction = Friction::Formula(law, LawParameters::new(&[]));
            let [mass, stiffness, normal_force, belt_speed] = [2.0, 5e5, 1000.0, 0.06];
            let like = example(Law::Stribeck);
            Machine { friction, mass, stiffness, normal_force, belt_speed, damping, ..like }
        };
        let words = |damping: f64| in_words(&assess(&machine(damping)).unwrap()).plain();
        let sticking = words(1000.0);
        assert!(
            sticking.starts_with("Stick-slips from every start at 0.06 m/s and 1000 N s/m ("),
            "{sticking}"
        );
        assert!(sticking.contains(" mm); more than 14") && sticking.contains(" ends stick-slip, more than "));
        let lines = lines_of_page(&in_words(&assess(&machine(1000.0)).unwrap()));
        let widest = lines.iter().map(|line| text_width(line, TEXT)).fold(0.0, f64::max);
        assert!(lines.len() == 2 && widest <= PAGE.0 - 2.0 * MARGIN, "{widest}: {lines:?}");
        let slipping = words(1500.0);
        assert!(slipping.starts_with("Vibrates from every start, without sticking, at "), "{slipping}");
        assert!(slipping.contains("; more than 1") && slipping.ends_with(" ends it."), "{slipping}");
        let still = words(3000.0);
        assert!(still.starts_with("Slips steadily from every start at 0.06 m/s"), "{still}");
        assert!(still.contains("; it may vibrate below 1"), "{still}");
    }

    #[test]
    fn measured_coefficients_under_a_normal_force_of_one_are_no_forces() {
        let data = [(0.0, 0.4), (0.02, 0.35), (0.1, 0.31), (0.5, 0.3)];
        let friction = Friction::Measured(Table::new("a rig", &data, 0.4).unwrap());
        let mut all = assess(&Machine { friction, normal_force: 1.0, ..example(Law::Stribeck) }).unwrap();
        let words = |all: &Assessment| {
            let lines = sections(all).into_iter().flat_map(|(_, lines)| lines);
            let lines = lines.map(|(name, value)| format!("{}: {}", name.plain(), value.plain()));
            lines.collect::<Vec<_>>().join("\n")
        };
        let text = words(&all);
        assert!(text.contains("normal force: 1 N\ncoefficient of friction: a rig\nat rest: 0.4\n"), "{text}");
        all.machine.normal_force_is_known = false;
        let text = words(&all);
        assert!(
            !text.contains("normal force: ") && text.contains("friction force: a rig\nat rest: 0.4 N\n"),
            "{text}"
        );
    }

    #[test]
    fn shares_are_printed_as_people_read_them() {
        let print = |value, limits| percentage(&Estimate { value, limits });
        assert_eq!(print(1.0, [0.999_98, 1.0]), "100 (> 99.99 to 100) %");
        assert_eq!(print(1.0, [1.0, 1.0]), "100 %");
        assert_eq!(print(6.77e-15, [6.7e-15, 6.8e-15]), "< 0.01 %");
        assert_eq!(print(0.0, [0.0, 0.001_28]), "0 (0 to 0.13) %");
        assert_eq!(print(0.25, [0.231, 0.26]), "25 (23.1 to 26) %");
    }
}
