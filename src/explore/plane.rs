//! Pictures of planes: one colour or one number for each cell of a grid over two axes.

use std::convert::Infallible;
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use rayon::prelude::*;
use serde::Deserialize;
use serde_json::json;

use super::catalogue::{deciders, differences, kinds_json};
use super::machine::{BELT_SPEED, DAMPING, dimensionless};
use super::place::{Place, check_law};
use super::refusal::Refusal;
use super::tabs::Turn;
use crate::certify::Guarantee;
use crate::config::range_nodes;
use crate::dataset::{Cells, Schema};
use crate::friction::{Column, Law};
use crate::machine::{Machine, Model, Units};
use crate::map::{
    Account, ComputeError, Control, Field, Grid, Method, Plan, Plane, PlaneCurve, PlaneCurves, PlanePoint,
    Queue, Sink, TileData, Verdict, compute_tiles,
};
use crate::report::figure::bifurcations::line_style;
use crate::report::figure::palette::{self, Kind};
use crate::report::{Label, UnitSystem};
use crate::simulate::bifurcation::Bifurcation;
use crate::simulate::critical::critical_dampings;
use crate::store::{MapFile, Pick};

/// Largest number of cells of a picture along one axis.
const MOST_POINTS: usize = 4096;
/// Largest number of cells of a picture.
const MOST_CELLS: usize = 1 << 22;
/// Number of cells of a tile, after each of which a superseded request may stop: many if c is an axis, since
/// a column's answer costs little more than one cell of it.
const TILE_WITH_COLUMNS: usize = 1 << 14;
const TILE_OF_SINGLE_CELLS: usize = 512;

/// One axis of a picture: cells of equal width, linear or logarithmic, between two ends.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct Side {
    axis: String,
    from: f64,
    to: f64,
    #[serde(default)]
    log: bool,
    points: usize,
}

/// The requested picture.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct PlaneRequest {
    pub(super) turn: Turn,
    #[serde(flatten)]
    pub(super) place: Place,
    x: Side,
    y: Side,
    /// Name of a variable of a map, `decider`, or `difference:METHOD:METHOD`.
    #[serde(default)]
    show: String,
    /// Whether a figure has the boundaries of the regimes.
    #[serde(default)]
    pub(super) curves: bool,
    /// Whether the fold curves are requested, or all others: for formulas and tables they take much longer.
    #[serde(default)]
    folds: bool,
    /// Whether the cells of the given map are shown where it has them.
    #[serde(default)]
    stored: bool,
}

/// The quantity shown.
#[derive(Clone, Debug)]
pub(super) enum Show {
    /// A variable of a map.
    Variable(String),
    /// The difference of the verdicts of two methods, by their names.
    Difference([&'static str; 2]),
    /// The first method in the order of the plan that decides.
    Decider,
}

impl Show {
    /// Meanings of the codes of a picture; `None` for numbers.
    pub(super) fn kinds(&self, methods: &[Method]) -> Option<Vec<Kind>> {
        match self {
            Show::Variable(name) if name == "regime" => Some(palette::regimes()),
            Show::Variable(name) if name.starts_with("verdict_") => Some(palette::verdicts()),
            Show::Variable(_) => None,
            Show::Difference([a, b]) => Some(differences(a, b)),
            Show::Decider => Some(deciders(methods)),
        }
    }

    /// The code of a cell with these verdicts.
    pub(super) fn derived(&self, methods: &[Method], said: &[i8]) -> i8 {
        match self {
            Show::Difference(pair) => {
                // Plans sort methods.
                let of = |name: &str| methods.iter().position(|method| method.name() == name).unwrap_or(0);
                let [a, b] = pair.map(|name| said[of(name)]);
                difference(a, b)
            }
            Show::Decider | Show::Variable(_) => {
                let decides = |code: &i8| *code == Verdict::Present.code() || *code == Verdict::Absent.code();
                said.iter().position(decides).map_or(-1, |first| first as i8)
            }
        }
    }
}

impl Side {
    /// The values at the middle of the cells. They lie inside the ends, which may themselves be illegal (V =
    /// 0).
    fn nodes(&self) -> Result<Vec<f64>, Refusal> {
        self.between(self.points, 0.5 / self.points as f64)
    }

    /// A number of values, the first and the last a share `half` of the axis from its ends.
    fn between(&self, points: usize, half: f64) -> Result<Vec<f64>, Refusal> {
        let Side { from, to, log, .. } = *self;
        let bad = |problem: String, remedy: &str| Err(Refusal::bad_input(problem, remedy));
        if !(2..=MOST_POINTS).contains(&points) {
            return bad(format!("{points} cells along {}", self.axis), "ask for 2 to 4096");
        }
        if !(from.is_finite() && to.is_finite() && from < to) {
            return bad(format!("{} from {from} to {to}", self.axis), "the axis must increase");
        }
        if log && from <= 0.0 {
            return bad(format!("the logarithmic axis {} begins at {from}", self.axis), "begin above 0");
        }
        let at = |share: f64| match log {
            true => from * (to / from).powf(share),
            false => from + (to - from) * share,
        };
        let nodes = range_nodes(at(half), at(1.0 - half), points, log);
        match nodes.windows(2).all(|pair| pair[0] < pair[1]) {
            true => Ok(nodes),
            false => {
                bad(format!("{} from {from} to {to}", self.axis), "the ends are too close to be told apart")
            }
        }
    }
}

/// A side of a picture and its nodes.
type Nodes<'a> = (&'a Side, Vec<f64>);

/// A part of a picture, and its place there: first column and row.
type Part = (Slice, [usize; 2]);

/// A plane of a grid.
pub(super) struct Slice {
    pub(super) grid: Grid,
    /// Positions of the axes across and up.
    pub(super) x: usize,
    pub(super) y: usize,
    /// The units of a machine's numbers.
    pub(super) units: UnitSystem,
}

impl Show {
    /// The label of the numbers of a variable in these units.
    fn label(&self, units: &UnitSystem) -> Option<Label> {
        match self {
            Show::Variable(name) => Some(units.variable(name)),
            Show::Difference(_) | Show::Decider => None,
        }
    }
}

impl PlaneRequest {
    /// Both sides with their nodes, across and up.
    fn sides(
        &self,
        nodes_of: impl Fn(&Side) -> Result<Vec<f64>, Refusal>,
    ) -> Result<[Nodes<'_>; 2], Refusal> {
        if self.x.axis == self.y.axis {
            return Err(Refusal::bad_input(
                "both directions show the same axis",
                "choose two different axes",
            ));
        }
        let sides = [(&self.x, nodes_of(&self.x)?), (&self.y, nodes_of(&self.y)?)];
        match sides[0].1.len() * sides[1].1.len() > MOST_CELLS {
            true => Err(Refusal::bad_input("the picture has too many cells", "ask for fewer")),
            false => Ok(sides),
        }
    }

    /// The grid with the values that `nodes` gives for both axes: of a machine belt speed and damping.
    fn slice(&self, nodes_of: impl Fn(&Side) -> Result<Vec<f64>, Refusal>) -> Result<Slice, Refusal> {
        let sides = self.sides(nodes_of)?;
        if let Some(machine) = self.place.machine()? {
            if !sides.iter().all(|(side, _)| [BELT_SPEED, DAMPING].contains(&side.axis.as_str())) {
                return Err(Refusal::bad_input(
                    "a map of a machine has the axes belt speed and damping",
                    "show these two to take them along",
                ));
            }
            return self.of_machine(&machine, &[&sides[0], &sides[1]]);
        }
        let (law, values) = self.place.read()?;
        let names = Grid::axis_names(&law);
        let position = |side: &Side| {
            let found = names.iter().position(|name| *name == side.axis);
            let unknown =
                || Refusal::malformed(format!("the law `{}` has no axis {}", law.name(), side.axis));
            found.ok_or_else(unknown)
        };
        let (x, y) = (position(&self.x)?, position(&self.y)?);
        let mut nodes: Vec<Vec<f64>> = values.into_iter().map(|value| vec![value]).collect();
        let [(_, across), (_, up)] = sides;
        (nodes[x], nodes[y]) = (across, up);
        let grid = Grid::new(law, nodes)?;
        check_corners(&grid)?;
        Ok(Slice { grid, x, y, units: UnitSystem::default() })
    }

    /// The dimensionless grid of a machine with these nodes, in SI units, of its belt speed, its damping, or both.
    fn of_machine(&self, machine: &Machine, sides: &[&Nodes]) -> Result<Slice, Refusal> {
        let (law, values) = dimensionless(machine, self.place.law.small)?;
        let units = machine.units();
        let mut nodes: Vec<Vec<f64>> = values.into_iter().map(|value| vec![value]).collect();
        let last = nodes.len() - 1;
        // Sides with one node, as far as the picture is concerned.
        let mut places = [0, 1];
        for (side, values) in sides {
            let (position, unit) = match side.axis.as_str() {
                BELT_SPEED => (last - 1, units.velocity),
                _ => (last, units.damping),
            };
            nodes[position] = values.iter().map(|value| value / unit).collect();
            places[usize::from(std::ptr::eq(*side, &self.y))] = position;
        }
        let units = UnitSystem::of_machine(machine.si());
        Ok(Slice { grid: Grid::new(law, nodes)?, x: places[0], y: places[1], units })
    }

    /// The machines of a plane, as far as they are legal, each with its place: first column and row.
    ///
    /// Belt speeds and dampings share a law. Any other quantity changes the units, so that each of its values has a
    /// grid of its own.
    fn machines(&self, machine: &Machine) -> Result<(Vec<Part>, [usize; 2]), Refusal> {
        let sides = self.sides(Side::nodes)?;
        let known: Vec<&str> = machine.quantities().into_iter().map(|(name, _)| name).collect();
        if let Some((side, _)) = sides.iter().find(|(side, _)| !known.contains(&side.axis.as_str())) {
            return Err(Refusal::malformed(format!("the machine has no quantity {}", side.axis)));
        }
        let size = [sides[0].1.len(), sides[1].1.len()];
        let (shared, varied): (Vec<&Nodes>, Vec<&Nodes>) =
            sides.iter().partition(|(side, _)| [BELT_SPEED, DAMPING].contains(&side.axis.as_str()));
        let counts: Vec<usize> = varied.iter().map(|(_, nodes)| nodes.len()).collect();
        let slice = |number: usize| {
            let mut machine = machine.clone();
            let (mut rest, mut corner) = (number, [0, 0]);
            for ((side, nodes), count) in varied.iter().zip(&counts) {
                machine = machine.with(&side.axis, nodes[rest % count])?;
                corner[usize::from(std::ptr::eq(*side, &self.y))] = rest % count;
                rest /= count;
            }
            if !machine.is_legal() {
                return None;
            }
            Some((self.of_machine(&machine, &shared).ok()?, corner))
        };
        Ok(((0..counts.iter().product()).into_par_iter().filter_map(slice).collect(), size))
    }

    /// The grid of the picture.
    pub(super) fn cells(&self) -> Result<Slice, Refusal> {
        self.slice(Side::nodes)
    }

    /// Both axes with the values at the middle of the cells.
    pub(super) fn sides_of_cells(&self) -> Result<[(&str, Vec<f64>); 2], Refusal> {
        Ok(self.sides(Side::nodes)?.map(|(side, nodes)| (side.axis.as_str(), nodes)))
    }

    /// Whether the axes across and up are logarithmic.
    pub(super) fn logarithmic(&self) -> [bool; 2] {
        [self.x.log, self.y.log]
    }

    /// The quantity shown, its methods, and its field in a map.
    pub(super) fn show(&self) -> Result<(Show, Vec<Method>, Option<Field>), Refusal> {
        let unknown =
            || Refusal::bad_input(format!("there is nothing called `{}`", self.show), "reload the page");
        let method = |name: &str| Method::by_name(name).ok_or_else(unknown);
        if let Some(pair) = self.show.strip_prefix("difference:") {
            let (a, b) = pair.split_once(':').ok_or_else(unknown)?;
            let pair = [method(a)?, method(b)?];
            return Ok((Show::Difference(pair.each_ref().map(Method::name)), pair.to_vec(), None));
        }
        if self.show == "decider" {
            // The weakest first, as in the report: cells that it decides need no other.
            let rigorous = Method::usual().filter(|it| it.guarantee() == Guarantee::FiniteEpsilon);
            return Ok((Show::Decider, rigorous.chain([Method::Simulation]).collect(), None));
        }
        let variable = Show::Variable(self.show.clone());
        for (prefix, field) in
            [("verdict_", Field::Verdict), ("margin_", Field::Margin), ("critical_c_", Field::CriticalC)]
        {
            if let Some(name) = self.show.strip_prefix(prefix) {
                return Ok((variable, vec![method(name)?], Some(field)));
            }
        }
        let fields = [Field::Regime, Field::Landing, Field::Cycle, Field::Basin];
        let holds = |field: &Field| match field {
            Field::Regime => self.show == "regime",
            field => {
                crate::map::Quantity::of(*field, 1, 0).iter().any(|quantity| quantity.name() == self.show)
            }
        };
        let field = fields.into_iter().find(holds).ok_or_else(unknown)?;
        Ok((variable, vec![Method::Simulation], Some(field)))
    }

    /// The picture: a line of JSON that describes it, then a code (one byte) or a number (four bytes) for
    /// each cell, line by line from the lowest. Taken from `map` if that is requested and has it, else
    /// computed.
    pub(super) fn picture(&self, map: Option<&MapFile>, stop: &AtomicBool) -> Result<Vec<u8>, Refusal> {
        let started = Instant::now();
        let (show, methods, field) = self.show()?;
        let is_shared = |side: &Side| [BELT_SPEED, DAMPING].contains(&side.axis.as_str());
        if let Some(machine) = self.place.machine()?.filter(|_| !(is_shared(&self.x) && is_shared(&self.y))) {
            let (slices, size) = self.machines(&machine)?;
            let (cells, kinds) = computed_each(&slices, size, &show, &methods, field, stop)?;
            let label = show.label(&UnitSystem::of_machine(machine.si()));
            return Ok(written(size, label.as_ref(), cells, kinds, started));
        }
        let slice = self.cells()?;
        let stored = map.filter(|_| self.stored).map_or(Ok(None), |map| stored(map, &slice, &show))?;
        let (mut cells, kinds) = match stored {
            Some(cells) => (cells, show.kinds(&methods).map(with_nothing)),
            None => computed(&slice, &show, methods, field, &Control { stop, ..Control::default() })?,
        };
        let axes = slice.grid.axes();
        let size = [slice.x, slice.y].map(|axis| axes[axis].values.len());
        let label = show.label(&slice.units);
        cells.convert(label.as_ref());
        Ok(written(size, label.as_ref(), cells, kinds, started))
    }

    /// The boundaries of the long-run behaviour.
    pub(super) fn boundaries(&self, stop: &AtomicBool) -> Result<serde_json::Value, Refusal> {
        // The nodes between the ends show whether an axis is logarithmic. The ends themselves may be illegal.
        const NODES: usize = 9;
        const ROOM: f64 = 1e-4;
        if let Some(machine) = self.place.machine()? {
            return self.boundaries_of_machine(&machine, NODES, ROOM, stop);
        }
        let Slice { grid, x, y, .. } = self.slice(|side| side.between(NODES, ROOM))?;
        let held = vec![0; grid.axes().len()];
        let found = PlaneCurves::of_kinds(&self.bifurcations(), &grid, Plane::new(x, y, held), stop);
        if stop.load(std::sync::atomic::Ordering::Relaxed) {
            return Err(Refusal::overtaken());
        }
        Ok(curves_json(&found.curves, [1.0, 1.0]))
    }

    /// The boundaries in a plane of a machine, in SI units: all of them over belt speed and damping; over damping and
    /// another quantity the Hopf and the grazing curve, which are one damping for each value; else none.
    fn boundaries_of_machine(
        &self,
        machine: &Machine,
        nodes: usize,
        room: f64,
        stop: &AtomicBool,
    ) -> Result<serde_json::Value, Refusal> {
        let sides = self.sides(|side| side.between(nodes, room))?;
        let is = |side: usize, name: &str| sides[side].0.axis == name;
        if let Some(up) = [1, 0].into_iter().find(|&side| is(side, DAMPING) && !is(1 - side, BELT_SPEED)) {
            if self.folds {
                return Ok(curves_json(&[], [1.0, 1.0]));
            }
            let (other, highest) = (sides[1 - up].0, sides[up].0.to);
            let found = limits(machine, &other.axis, &other.between(LIMITS, room)?, highest, up == 0);
            return Ok(curves_json(&found, [1.0, 1.0]));
        }
        if !sides.iter().all(|(side, _)| [BELT_SPEED, DAMPING].contains(&side.axis.as_str())) {
            return Ok(curves_json(&[], [1.0, 1.0]));
        }
        let Slice { grid, x, y, .. } = self.of_machine(machine, &[&sides[0], &sides[1]])?;
        let plane = Plane::new(x, y, vec![0; grid.axes().len()]);
        let found = PlaneCurves::of_kinds(&self.bifurcations(), &grid, plane, stop);
        if stop.load(std::sync::atomic::Ordering::Relaxed) {
            return Err(Refusal::overtaken());
        }
        let Units { velocity, damping, .. } = machine.units();
        Ok(curves_json(
            &found.curves,
            if is(0, BELT_SPEED) { [velocity, damping] } else { [damping, velocity] },
        ))
    }

    /// The kinds of curves that are requested.
    fn bifurcations(&self) -> Vec<Bifurcation> {
        Bifurcation::ALL.into_iter().filter(|kind| (*kind == Bifurcation::Fold) == self.folds).collect()
    }
}

/// Number of values of a quantity at which the limits of the damping are computed first, and their accuracy.
const LIMITS: usize = 33;
const ACCURACY: f64 = 1e-8;
/// Where a curve bends by more than this share of the picture, there are further values; so many times.
const BEND: f64 = 2e-3;
const REFINEMENTS: usize = 8;

/// The Hopf damping and the critical damping, in SI units, at a value of another quantity; NaN where there is none.
#[derive(Clone, Copy)]
struct Limit {
    value: f64,
    hopf: f64,
    grazing: f64,
}

impl Limit {
    /// Those of legal machines.
    fn of(machine: &Machine, name: &str, values: &[f64]) -> Vec<Self> {
        let model = |&value: &f64| {
            let machine = machine.with(name, value).filter(Machine::is_legal)?;
            Some((value, machine.model()?))
        };
        let models: Vec<_> = values.iter().filter_map(model).collect();
        let columns: Vec<_> = models.iter().map(|(_, model)| model.column()).collect();
        let roots = critical_dampings(&columns, ACCURACY)
            .into_iter()
            .map(|root| root.map_or(f64::NAN, |root| root.c));
        let limit = |(((value, model), column), root): ((&(f64, Model), &Column), f64)| {
            let unit = model.si.units.damping;
            Self {
                value: *value,
                hopf: column.curve.weakening(column.belt_speed) * unit,
                grazing: root * unit,
            }
        };
        models.iter().zip(&columns).zip(roots).map(limit).collect()
    }

    /// By how much this one is off the straight line between its neighbours.
    fn bend(self, before: Self, after: Self) -> f64 {
        let share = (self.value - before.value) / (after.value - before.value);
        let off = |of: fn(Self) -> f64| (of(before) + share * (of(after) - of(before)) - of(self)).abs();
        off(|limit| limit.hopf).max(off(|limit| limit.grazing))
    }
}

/// The Hopf and the grazing curve of a machine over another quantity, in a picture with dampings up to `highest`;
/// `turned` if the damping is the horizontal axis.
fn limits(machine: &Machine, name: &str, values: &[f64], highest: f64, turned: bool) -> Vec<PlaneCurve> {
    let mut found = Limit::of(machine, name, values);
    for _ in 0..REFINEMENTS {
        let bent = found.windows(3).filter(|near| near[1].bend(near[0], near[2]) > BEND * highest);
        let middle = |a: Limit, b: Limit| 0.5 * (a.value + b.value);
        let mut more: Vec<f64> =
            bent.flat_map(|near| [middle(near[0], near[1]), middle(near[1], near[2])]).collect();
        more.dedup();
        if more.is_empty() {
            break;
        }
        found.append(&mut Limit::of(machine, name, &more));
        found.sort_by(|a, b| a.value.total_cmp(&b.value));
    }
    let curve = |bifurcation, of: fn(&Limit) -> f64| {
        let points = found.iter().filter(|limit| of(limit) >= 0.0).map(|limit| {
            let (x, y) = if turned { (of(limit), limit.value) } else { (limit.value, of(limit)) };
            PlanePoint { x, y, error: ACCURACY }
        });
        PlaneCurve { bifurcation, points: points.collect() }
    };
    vec![
        curve(Bifurcation::Hopf, |limit| limit.hopf),
        curve(Bifurcation::GrazingSliding, |limit| limit.grazing),
    ]
}

/// Curves with their style, their points multiplied by the units of the axes.
fn curves_json(curves: &[PlaneCurve], [across, up]: [f64; 2]) -> serde_json::Value {
    let one = |curve: &PlaneCurve| {
        let (stroke, words) = line_style(curve.bifurcation);
        let points: Vec<[f64; 2]> =
            curve.points.iter().map(|point| [point.x * across, point.y * up]).collect();
        json!({
            "name": curve.bifurcation.name(),
            "words": words,
            "color": stroke.color,
            "width": stroke.width,
            "dash": stroke.dash,
            "points": points,
        })
    };
    json!({ "curves": curves.iter().map(one).collect::<Vec<_>>() })
}

/// A picture as it is sent.
fn written(
    [width, height]: [usize; 2],
    label: Option<&Label>,
    cells: Values,
    kinds: Option<Vec<Kind>>,
    started: Instant,
) -> Vec<u8> {
    let label = label.map_or_else(String::new, |label| label.text().plain());
    let head = json!({
        "width": width,
        "height": height,
        "label": label,
        "kinds": kinds.map(|kinds| kinds_json(&kinds)),
        "seconds": started.elapsed().as_secs_f64(),
    });
    let mut bytes = head.to_string().into_bytes();
    // Numbers of four bytes begin at a multiple of four.
    while bytes.len() % 4 != 3 {
        bytes.push(b' ');
    }
    bytes.push(b'\n');
    match cells {
        Values::Codes(codes) => bytes.extend(codes.iter().map(|code| code.to_le_bytes()[0])),
        Values::Reals(reals) => bytes.extend(reals.iter().flat_map(|real| real.to_le_bytes())),
    }
    bytes
}

/// Checks the law at the corners and in the middle of a plane; cells between them may still fail.
fn check_corners(grid: &Grid) -> Result<(), Refusal> {
    if !matches!(grid.law().as_written(), Law::Expression(_)) {
        return Ok(());
    }
    let shape = grid.shape();
    let mut first = None;
    // One legal point is enough to draw; elsewhere the picture shows that the method failed.
    for share in [0.5, 0.0, 1.0] {
        let index: Vec<usize> = shape.iter().map(|len| ((len - 1) as f64 * share) as usize).collect();
        match check_law(grid.law(), &grid.point(&index)) {
            Ok(()) => return Ok(()),
            Err(refusal) => first = first.or(Some(refusal)),
        }
    }
    first.map_or(Ok(()), Err)
}

/// The cells of a picture computed by the engine, and the meanings of codes.
fn computed(
    slice: &Slice,
    show: &Show,
    methods: Vec<Method>,
    field: Option<Field>,
    control: &Control,
) -> Result<(Values, Option<Vec<Kind>>), Refusal> {
    let Slice { grid, x, y, .. } = slice;
    let with_columns = grid.axes().len() - 1 == *x.max(y);
    let tile_shape = grid.tile_shape(if with_columns { TILE_WITH_COLUMNS } else { TILE_OF_SINGLE_CELLS });
    let plan =
        Plan::builder(grid.clone()).methods(methods).fields(field).audit_cells(0).tile_shape(tile_shape);
    let plan = plan.build()?;
    let sink = Picture::new(&plan, show, *x, *y)?;
    let queue = Queue::new(vec![false; plan.tile_count()]);
    match compute_tiles(&plan, &sink, control, &|| queue.take()) {
        Ok(_) => {}
        Err(ComputeError::Interrupted) => return Err(Refusal::overtaken()),
        Err(ComputeError::Threads(why)) => return Err(Refusal::broken(why)),
        Err(ComputeError::Sink(never)) => match never {},
    }
    let kinds = show.kinds(&sink.methods);
    Ok((sink.cells.into_inner().unwrap_or_else(PoisonError::into_inner), kinds))
}

/// The cells of a picture of this size, put together from slices at these places.
fn computed_each(
    slices: &[Part],
    [width, height]: [usize; 2],
    show: &Show,
    methods: &[Method],
    field: Option<Field>,
    stop: &AtomicBool,
) -> Result<(Values, Option<Vec<Kind>>), Refusal> {
    // The slices are what threads share.
    let control = Control { stop, threads: Some(1), ..Control::default() };
    let found: Vec<_> = slices
        .par_iter()
        .map(|(slice, corner)| {
            let (mut cells, kinds) = computed(slice, show, methods.to_vec(), field, &control)?;
            cells.convert(show.label(&slice.units).as_ref());
            let axes = slice.grid.axes();
            Ok((*corner, axes[slice.x].values.len(), cells, kinds))
        })
        .collect::<Result<_, Refusal>>()?;
    let is_codes = show.kinds(methods).is_some();
    let mut all = match is_codes {
        true => Values::Codes(vec![Verdict::NotComputed.code(); width * height]),
        false => Values::Reals(vec![f32::NAN; width * height]),
    };
    let mut kinds = show.kinds(methods);
    for ([column, row], across, cells, of_slice) in found {
        kinds = of_slice;
        let place = |cell: usize| (row + cell / across) * width + column + cell % across;
        match (&mut all, cells) {
            (Values::Codes(all), Values::Codes(cells)) => {
                cells.into_iter().enumerate().for_each(|(cell, code)| all[place(cell)] = code);
            }
            (Values::Reals(all), Values::Reals(cells)) => {
                cells.into_iter().enumerate().for_each(|(cell, real)| all[place(cell)] = real);
            }
            _ => unreachable!("slices of one picture show the same"),
        }
    }
    Ok((all, kinds))
}

/// The code of cells beyond a map, which no variable uses.
const NOT_STORED: i8 = i8::MIN;

/// The kinds of a map's variable, and that of cells beyond the map.
fn with_nothing(mut kinds: Vec<Kind>) -> Vec<Kind> {
    let words = "not in the map".into();
    kinds.push(Kind { code: NOT_STORED, name: "not_stored", fill: palette::NOT_COMPUTED, words });
    kinds
}

/// The cells of a picture as stored in a map: those of the nearest nodes, none beyond its ends. `None` if the
/// map is of another law or does not have the quantity.
fn stored(map: &MapFile, slice: &Slice, show: &Show) -> Result<Option<Values>, Refusal> {
    let Slice { grid, x, y, .. } = slice;
    let Show::Variable(name) = show else { return Ok(None) };
    if map.grid().law() != grid.law() || !map.has(name) || name.starts_with("critical_c_") {
        return Ok(None);
    }
    let axes = map.grid().axes();
    let picks: Vec<Pick> = (0..axes.len())
        .map(|axis| match axis == *x || axis == *y {
            true => Pick::Every(1),
            false => Pick::Node(axes[axis].nearest(grid.axes()[axis].values[0])),
        })
        .collect();
    // The stored node nearest to each cell; none for cells beyond an end by more than the step there.
    let nearest = |axis: usize| -> Vec<Option<usize>> {
        let nodes = &axes[axis].values;
        let last = nodes.len() - 1;
        let beyond = |value: f64| match nodes.len() {
            1 => value != nodes[0],
            _ => {
                value < nodes[0] - 0.5 * (nodes[1] - nodes[0])
                    || value > nodes[last] + 0.5 * (nodes[last] - nodes[last - 1])
            }
        };
        let values = grid.axes()[axis].values.iter();
        values.map(|&value| (!beyond(value)).then(|| axes[axis].nearest(value))).collect()
    };
    let (across, up) = (nearest(*x), nearest(*y));
    let at = |i: usize, j: usize| if x < y { [i, j] } else { [j, i] };
    let failed = |error: crate::store::StoreError| Refusal::broken(error.to_string());
    let places = || up.iter().flat_map(|j| across.iter().map(move |i| i.zip(*j)));
    if show.kinds(&[]).is_some() {
        let cells = map.code_slice(name, &picks).map_err(failed)?;
        let code = |place: Option<(usize, usize)>| place.map_or(NOT_STORED, |(i, j)| cells[&at(i, j)[..]]);
        return Ok(Some(Values::Codes(places().map(code).collect())));
    }
    let cells = map.real_slice(name, &picks).map_err(failed)?;
    let number = |place: Option<(usize, usize)>| place.map_or(f32::NAN, |(i, j)| cells[&at(i, j)[..]] as f32);
    Ok(Some(Values::Reals(places().map(number).collect())))
}

/// The cells of a picture.
enum Values {
    Codes(Vec<i8>),
    Reals(Vec<f32>),
}

impl Values {
    /// Converts dimensionless numbers to the unit of the label.
    fn convert(&mut self, label: Option<&Label>) {
        if let (Values::Reals(reals), Some(label)) = (self, label)
            && label.factor != 1.0
        {
            reals.iter_mut().for_each(|real| *real = (f64::from(*real) * label.factor) as f32);
        }
    }
}

/// Receives tiles into a picture.
struct Picture<'a> {
    show: &'a Show,
    methods: Vec<Method>,
    schema: Schema,
    x: usize,
    y: usize,
    width: usize,
    height: usize,
    cells: Mutex<Values>,
}

/// The code of [`differences`] for the verdicts of two methods.
fn difference(a: i8, b: i8) -> i8 {
    const PRESENT: i8 = Verdict::Present as i8;
    const ABSENT: i8 = Verdict::Absent as i8;
    const UNDECIDED: i8 = Verdict::Undecided as i8;
    match (a, b) {
        (PRESENT, PRESENT) => 0,
        (ABSENT, ABSENT) => 1,
        (PRESENT, ABSENT) => 2,
        (ABSENT, PRESENT) => 3,
        (UNDECIDED, PRESENT | ABSENT | UNDECIDED) | (PRESENT | ABSENT, UNDECIDED) => 4,
        _ => 5,
    }
}

impl<'a> Picture<'a> {
    fn new(plan: &Plan, show: &'a Show, x: usize, y: usize) -> Result<Self, Refusal> {
        let schema = Schema::of(plan);
        let axes = plan.grid().axes();
        let (width, height) = (axes[x].values.len(), axes[y].values.len());
        let codes = match show {
            Show::Variable(name) => {
                let variable = schema.variables.iter().find(|variable| variable.name == *name);
                let unknown =
                    || Refusal::bad_input(format!("there is nothing called `{name}`"), "reload the page");
                variable.ok_or_else(unknown)?.codes().is_some()
            }
            Show::Difference(_) | Show::Decider => true,
        };
        let cells = match codes {
            true => Values::Codes(vec![Verdict::NotComputed.code(); width * height]),
            false => Values::Reals(vec![f32::NAN; width * height]),
        };
        let methods = plan.methods().to_vec();
        Ok(Self { show, methods, schema, x, y, width, height, cells: Mutex::new(cells) })
    }

    fn derived(&self, data: &TileData) -> Vec<i8> {
        let methods = data.methods.iter();
        let verdicts: Vec<Vec<i8>> =
            methods.map(|method| method.verdicts.values().map(Verdict::code).collect()).collect();
        let said = |cell: usize| verdicts.iter().map(|of_method| of_method[cell]).collect::<Vec<i8>>();
        (0..data.tile.cells()).map(|cell| self.show.derived(&self.methods, &said(cell))).collect()
    }

    /// Calls `put` with the place in the picture of each cell of the tile, in the tile's order.
    fn scatter(&self, data: &TileData, mut put: impl FnMut(usize, usize)) {
        let (outer, inner) = (self.x.min(self.y), self.x.max(self.y));
        let ranges = &data.tile.ranges;
        let mut cell = 0;
        for i in ranges[outer].clone() {
            for j in ranges[inner].clone() {
                let (column, row) = if self.x < self.y { (i, j) } else { (j, i) };
                put(cell, row * self.width + column);
                cell += 1;
            }
        }
    }
}

impl Sink for Picture<'_> {
    type Packed = ();
    type Error = Infallible;

    fn pack(&self, data: &TileData) -> Result<(), Infallible> {
        let variable = match self.show {
            Show::Variable(name) => self.schema.variables.iter().find(|variable| variable.name == *name),
            Show::Difference(_) | Show::Decider => None,
        };
        let found = variable.map(|variable| variable.cells(data));
        let codes = match &found {
            Some(Cells::Codes(codes)) => codes.values().collect(),
            Some(Cells::Reals(_)) => Vec::new(),
            None => self.derived(data),
        };
        let mut cells = self.cells.lock().unwrap_or_else(PoisonError::into_inner);
        match (&mut *cells, found) {
            (Values::Reals(all), Some(Cells::Reals(reals))) => {
                // A critical damping has no cells along c.
                let each = data.tile.cells() / reals.len().max(1);
                self.scatter(data, |cell, place| all[place] = reals[cell / each] as f32);
            }
            (Values::Codes(all), _) => self.scatter(data, |cell, place| all[place] = codes[cell]),
            (Values::Reals(_), _) => unreachable!("numbers are numbers"),
        }
        debug_assert_eq!(
            self.width * self.height,
            match &*cells {
                Values::Codes(codes) => codes.len(),
                Values::Reals(reals) => reals.len(),
            }
        );
        Ok(())
    }

    fn write(&self, (): (), _: &Account) -> Result<(), Infallible> {
        Ok(())
    }
}
