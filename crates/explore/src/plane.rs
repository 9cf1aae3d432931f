//! Planes of parameter space: the contents of a request, and the grids of its cells.

use std::ops::Range;

use serde::Deserialize;

use super::place::Place;
use super::refusal::Refusal;
use super::show::Show;
use slipmap_certify::Guarantee;
use slipmap_column::Method;
use slipmap_config::{check_law, range_nodes};
use slipmap_map::{Field, Grid};
use slipmap_model::friction::Law;
use slipmap_page::units::UnitSystem;

/// Largest number of cells of a picture along one axis.
const MOST_POINTS: usize = 4096;
/// Largest number of cells of a picture.
const MOST_CELLS: usize = 1 << 22;

/// One axis of a picture: cells of equal width, linear or logarithmic, between two ends.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct AxisRequest {
    pub(super) axis: String,
    from: f64,
    pub(super) to: f64,
    #[serde(default)]
    pub(super) log: bool,
    points: usize,
    /// The first of the cells that are wanted, and one past the last; all of them by default.
    #[serde(default)]
    part: Option<[usize; 2]>,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct PlaneRequest {
    #[serde(flatten)]
    pub(super) place: Place,
    pub(super) x: AxisRequest,
    pub(super) y: AxisRequest,
    /// Name of a variable of a map, `decider`, or `difference:METHOD:METHOD`.
    #[serde(default)]
    show: String,
    /// Whether a figure has the boundaries of the regimes.
    #[serde(default)]
    pub(super) curves: bool,
    /// Whether the fold curves are requested instead of all others: for formulas and tables folds are slow.
    #[serde(default)]
    pub(super) folds: bool,
}

impl AxisRequest {
    /// The values at the middle of the cells. They lie inside the ends, which may themselves be illegal (V =
    /// 0).
    pub(super) fn nodes(&self) -> Result<Vec<f64>, Refusal> {
        self.between(self.points, 0.5 / self.points as f64)
    }

    /// The cells that are wanted.
    fn part(&self) -> Result<Range<usize>, Refusal> {
        let [from, to] = self.part.unwrap_or([0, self.points]);
        match from < to && to <= self.points {
            true => Ok(from..to),
            false => Err(Refusal::malformed(format!("no cells {from} to {to} along {}", self.axis))),
        }
    }

    /// `points` values; the first and the last lie a share `half` of the axis inside its ends.
    pub(super) fn between(&self, points: usize, half: f64) -> Result<Vec<f64>, Refusal> {
        let AxisRequest { from, to, log, .. } = *self;
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

pub(super) struct Slice {
    pub(super) grid: Grid,
    /// Positions of the axes across and up.
    pub x: usize,
    pub y: usize,
    /// The units of a machine's numbers.
    pub(super) units: UnitSystem,
}

impl PlaneRequest {
    /// The grid with the values from `nodes_of` on both axes.
    pub(super) fn slice(
        &self,
        nodes_of: impl Fn(&AxisRequest) -> Result<Vec<f64>, Refusal>,
    ) -> Result<Slice, Refusal> {
        if self.x.axis == self.y.axis {
            let problem = "both directions show the same axis";
            return Err(Refusal::bad_input(problem, "choose two different axes"));
        }
        let [across, up] = [nodes_of(&self.x)?, nodes_of(&self.y)?];
        if across.len() * up.len() > MOST_CELLS {
            return Err(Refusal::bad_input("the picture has too many cells", "ask for fewer"));
        }
        if let Some(machine) = self.place.machine()? {
            let varied = [(self.x.axis.as_str(), across), (self.y.axis.as_str(), up)];
            let grid = Grid::of_machine(&machine, &varied)?;
            let place =
                |side: &AxisRequest| grid.axes().iter().position(|axis| axis.name == side.axis).unwrap_or(0);
            let (x, y) = (place(&self.x), place(&self.y));
            return Ok(Slice { units: UnitSystem::of_grid(&grid), grid, x, y });
        }
        let (law, values) = self.place.read(&[&self.x.axis, &self.y.axis])?;
        let names = law.axis_names();
        let position = |side: &AxisRequest| {
            let found = names.iter().position(|name| *name == side.axis);
            let unknown =
                || Refusal::malformed(format!("the law `{}` has no axis {}", law.name(), side.axis));
            found.ok_or_else(unknown)
        };
        let (x, y) = (position(&self.x)?, position(&self.y)?);
        let mut nodes: Vec<Vec<f64>> = values.into_iter().map(|value| vec![value]).collect();
        (nodes[x], nodes[y]) = (across, up);
        let grid = Grid::new(law, nodes)?;
        check_corners(&grid)?;
        Ok(Slice { grid, x, y, units: UnitSystem::default() })
    }

    /// The grid of the picture, which is legal somewhere, or of the part of it that is wanted.
    pub(super) fn cells(&self) -> Result<Slice, Refusal> {
        let whole = self.slice(AxisRequest::nodes)?;
        let grid = whole.grid.part(whole.x, self.x.part()?).part(whole.y, self.y.part()?);
        Ok(Slice { grid, ..whole })
    }

    /// The quantity shown, its methods, and its field in a map.
    pub(super) fn show(&self, grid: &Grid) -> Result<(Show, Vec<Method>, Option<Field>), Refusal> {
        let unknown =
            || Refusal::bad_input(format!("there is nothing called `{}`", self.show), "reload the page");
        let method = |name: &str| Method::by_name(name).ok_or_else(unknown);
        if let Some(pair) = self.show.strip_prefix("difference:") {
            let (a, b) = pair.split_once(':').ok_or_else(unknown)?;
            let pair = [method(a)?, method(b)?];
            return Ok((Show::Difference(pair.each_ref().map(Method::name)), pair.to_vec(), None));
        }
        if self.show == "decider" {
            // The weakest first, as in the report: cells that it decides need no other method.
            let rigorous = Method::usual().filter(|it| it.guarantee() == Guarantee::FiniteEpsilon);
            return Ok((Show::Decider, rigorous.chain([Method::Simulation]).collect(), None));
        }
        let (field, method) = Field::of_variable(&self.show).ok_or_else(unknown)?;
        if matches!(field, Field::EpsilonLimit | Field::Sensitivity) {
            return Err(unknown());
        }
        let method = method.unwrap_or(Method::Simulation);
        let name = match field {
            Field::CriticalC => format!("{}{}", Field::critical_of(grid)[0], method.name()),
            _ => self.show.clone(),
        };
        Ok((Show::Variable(name), vec![method], Some(field)))
    }
}

/// Checks that the law is legal in the middle of a plane or at one of two opposite corners.
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
            Err(wrong) => first = first.or(Some(wrong.into())),
        }
    }
    first.map_or(Ok(()), Err)
}
