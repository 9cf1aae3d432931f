//! Pictures of planes: one colour or one number for each cell of a grid over two axes.

use std::collections::HashSet;
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};

use serde_json::json;

use super::catalogue::kinds_json;
use super::plane::{PlaneRequest, Slice};
use super::refusal::Refusal;
use super::show::Show;
use slipmap_column::{Method, Verdict};
use slipmap_map::dataset::{Cells, Schema, Variable};
use slipmap_map::{ComputeError, Control, Each, Field, Plan, Queue, TileData, compute_tiles};
use slipmap_page::palette::CellKind;

/// Number of cells of a tile, after each of which a superseded request may stop: many if c is an axis, since
/// a column's answer costs little more than one cell of it. Tiles that are interpolated have the usual size.
const TILE_WITH_COLUMNS: usize = 1 << 13;
const TILE_OF_SINGLE_CELLS: usize = 512;

impl PlaneRequest {
    /// The picture: a line of JSON that describes it, then a code (one byte) or a number (four bytes) for
    /// each cell, line by line from the lowest.
    pub(super) fn picture(&self, stop: &AtomicBool) -> Result<Vec<u8>, Refusal> {
        let slice = self.cells()?;
        let (show, methods, field) = self.show(&slice.grid)?;
        let control = Control { stop, ..Control::default() };
        let (cells, kinds) = computed(&slice, &show, methods, field, &control)?;
        let axes = slice.grid.axes();
        let [width, height] = [slice.x, slice.y].map(|axis| axes[axis].values.len());
        // Numbers are in the units of their label.
        let label = match &show {
            Show::Variable(name) => slice.units.variable(name).text().plain(),
            Show::Difference(_) | Show::Decider => String::new(),
        };
        let head = json!({
            "width": width,
            "height": height,
            "label": label,
            "kinds": kinds.map(|kinds| kinds_json(&kinds)),
        });
        let mut bytes = head.to_string().into_bytes();
        // Numbers of four bytes begin at a multiple of four.
        while bytes.len() % 4 != 3 {
            bytes.push(b' ');
        }
        bytes.push(b'\n');
        match cells {
            CellValues::Codes(codes) => bytes.extend(codes.iter().map(|code| code.to_le_bytes()[0])),
            CellValues::Reals(reals) => bytes.extend(reals.iter().flat_map(|real| real.to_le_bytes())),
        }
        Ok(bytes)
    }
}

enum CellValues {
    Codes(Vec<i8>),
    Reals(Vec<f32>),
}

/// The cells of a picture computed by the engine, and the meanings of codes.
fn computed(
    slice: &Slice,
    show: &Show,
    methods: Vec<Method>,
    field: Option<Field>,
    control: &Control,
) -> Result<(CellValues, Option<Vec<CellKind>>), Refusal> {
    let Slice { grid, x, y, .. } = slice;
    let with_columns = grid.axes().len() - 1 == *x.max(y);
    let plan = Plan::builder(grid.clone()).methods(methods).fields(field).audit_cells(0).build()?;
    let plan = if plan.interpolates() {
        plan
    } else {
        let cells = if with_columns { TILE_WITH_COLUMNS } else { TILE_OF_SINGLE_CELLS };
        Plan { tile_shape: grid.tile_shape(cells), ..plan }
    };
    let picture = Picture::new(&plan, show, *x, *y)?;
    let sink = Each(|data: &TileData| picture.fill(data));
    let queue = Queue::new(plan.tile_count(), HashSet::new());
    match compute_tiles(&plan, &sink, control, &|| queue.take()) {
        Ok(_) => {}
        Err(ComputeError::Interrupted) => return Err(Refusal::stopped()),
        Err(ComputeError::Threads(why)) => return Err(Refusal::broken(why)),
        Err(ComputeError::Sink(never)) => match never {},
    }
    let kinds = show.kinds(&picture.methods);
    Ok((picture.cells.into_inner().unwrap_or_else(PoisonError::into_inner), kinds))
}

/// Receives tiles into a picture.
struct Picture<'a> {
    show: &'a Show,
    methods: Vec<Method>,
    /// What is shown, unless it is derived from verdicts.
    variable: Option<Variable>,
    x: usize,
    y: usize,
    width: usize,
    cells: Mutex<CellValues>,
}

impl<'a> Picture<'a> {
    fn new(plan: &Plan, show: &'a Show, x: usize, y: usize) -> Result<Self, Refusal> {
        let axes = plan.grid.axes();
        let (width, height) = (axes[x].values.len(), axes[y].values.len());
        let variable = match show {
            Show::Variable(name) => {
                let found = Schema::of(plan).variables.into_iter().find(|variable| variable.name == *name);
                let unknown =
                    || Refusal::bad_input(format!("there is nothing called `{name}`"), "reload the page");
                Some(found.ok_or_else(unknown)?)
            }
            Show::Difference(_) | Show::Decider => None,
        };
        let is_codes = variable.as_ref().is_none_or(|variable| variable.codes().is_some());
        let cells = Mutex::new(match is_codes {
            true => CellValues::Codes(vec![Verdict::NotComputed.code(); width * height]),
            false => CellValues::Reals(vec![f32::NAN; width * height]),
        });
        Ok(Self { show, methods: plan.methods.to_vec(), variable, x, y, width, cells })
    }

    fn derived(&self, data: &TileData) -> Vec<i8> {
        let methods = data.methods.iter();
        let verdicts: Vec<Vec<i8>> =
            methods.map(|method| method.verdicts.values().map(Verdict::code).collect()).collect();
        let codes = |cell: usize| verdicts.iter().map(|of_method| of_method[cell]).collect::<Vec<i8>>();
        (0..data.tile.cells()).map(|cell| self.show.derived(&self.methods, &codes(cell))).collect()
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

    fn fill(&self, data: &TileData) {
        let found = self.variable.as_ref().map(|variable| variable.cells(data));
        let codes = match &found {
            Some(Cells::Codes(codes)) => codes.values().collect(),
            Some(Cells::Reals(_)) => Vec::new(),
            None => self.derived(data),
        };
        let mut cells = self.cells.lock().unwrap_or_else(PoisonError::into_inner);
        match (&mut *cells, found) {
            (CellValues::Reals(all), Some(Cells::Reals(reals))) => {
                // A critical damping does not vary along c: `each` cells share one number.
                let each = data.tile.cells() / reals.len().max(1);
                self.scatter(data, |cell, place| all[place] = reals[cell / each] as f32);
            }
            (CellValues::Codes(all), _) => self.scatter(data, |cell, place| all[place] = codes[cell]),
            (CellValues::Reals(_), _) => unreachable!("numbers are numbers"),
        }
    }
}
