//! A validated description of a computation.

use super::{Axis, AxisRole, Field, Grid, Plane, Quantity, tiles};
use slipmap_certify::validated;
use slipmap_column::{DEFAULT_TOLERANCE, Method, TOLERANCES, limits};
use slipmap_model::friction::Column;
use slipmap_orbits::Piece;

/// Largest number of dampings for which columns are interpolated: with more, each column serves many cells.
const MOST_DAMPINGS_INTERPOLATED: usize = 2;

/// The validated description of a map to be computed; [`Plan::builder`] makes it.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The axes.
    pub grid: Grid,
    /// The methods, in the order of [`Method::all`], without repetition.
    pub methods: Vec<Method>,
    /// The fields, in the order of [`Field::ALL`]; [`Field::Verdict`] is always among them.
    pub fields: Vec<Field>,
    /// Tolerance of simulations.
    pub tolerance: f64,
    /// Number of cells that the witness decides again.
    pub audit_cells: usize,
    /// Number of boxes to be proved between the nodes.
    pub proof_boxes: usize,
    /// Planes whose curves are traced.
    pub planes: Vec<Plane>,
    /// Number of nodes of a tile along each axis.
    pub tile_shape: Vec<usize>,
    /// Level of deflate.
    pub compression: u8,
}

/// Default number of cells that the direct engine decides again.
pub const DEFAULT_AUDIT_CELLS: usize = 1000;
/// Default number of boxes that `validated` tries to prove, in about half a minute.
pub const DEFAULT_PROOF_BOXES: usize = 32;
/// Largest number of cells that the direct engine decides again, in hours.
pub const MOST_AUDIT_CELLS: usize = 10_000_000;
/// Default compression of a map.
pub const DEFAULT_COMPRESSION: u8 = 2;

/// Reason why a plan cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// There is no method.
    #[error("a plan needs at least one method")]
    NoMethod,
    /// The tolerance is not in `TOLERANCES`.
    #[error("the tolerance is {0:?}; it must be between {min:?} and {max:?}", min = TOLERANCES.start(), max = TOLERANCES.end())]
    Tolerance(f64),
    /// The audit is larger than `MOST_AUDIT_CELLS`.
    #[error("an audit of {0} cells; at most {MOST_AUDIT_CELLS} can be decided again")]
    AuditCells(usize),
    /// The compression is above 9.
    #[error("the compression is {0}; it must be between 0 and 9")]
    Compression(u8),
    /// The tile's shape does not fit the grid.
    #[error(
        "tiles of the shape {0:?} do not divide a grid of the shape {1:?}: every axis needs at least one node of its own"
    )]
    TileShape(Vec<usize>, Vec<usize>),
    /// A plane does not lie in the grid.
    #[error("there is no plane of the axes {x} and {y} in this grid: it needs two different axes of several nodes each, and a node of every other", x = .0.x, y = .0.y)]
    Plane(Plane),
}

/// Builder of a [`Plan`]; the defaults are those of configurations.
#[derive(Clone, Debug)]
#[must_use]
pub struct PlanBuilder {
    plan: Plan,
    tile_shape: Option<Vec<usize>>,
}

/// Defines the methods of the builder that set one field of the plan.
macro_rules! choices {
    ($($(#[$doc:meta])* $name:ident: $Value:ty,)+) => {
        $($(#[$doc])*
        pub fn $name(mut self, $name: $Value) -> Self {
            self.plan.$name = $name;
            self
        })+
    };
}

impl PlanBuilder {
    choices! {
        /// Bound on the error that the simulation aims at, see [`DEFAULT_TOLERANCE`].
        tolerance: f64,
        /// Number of cells that the direct engine decides again; a grid with fewer cells is audited
        /// completely.
        audit_cells: usize,
        /// Number of boxes of scaled parameters that the method `validated` tries to prove, to decide points
        /// between the nodes; 0 for none. Used only with the method `validated` and the Stribeck law.
        proof_boxes: usize,
        /// Compression of the stored map: 0 (none) to 9 (smallest file).
        compression: u8,
    }

    /// The methods of the map, in any order. Default: [`Method::usual`].
    pub fn methods(mut self, methods: impl IntoIterator<Item = Method>) -> Self {
        self.plan.methods = methods.into_iter().collect();
        self
    }

    /// The fields to store besides verdicts, in any order. Default: none.
    pub fn fields(mut self, fields: impl IntoIterator<Item = Field>) -> Self {
        self.plan.fields = fields.into_iter().collect();
        self
    }

    /// The planes whose curves of codimension one are computed. Default: none.
    pub fn planes(mut self, planes: impl IntoIterator<Item = Plane>) -> Self {
        self.plan.planes = planes.into_iter().collect();
        self
    }

    /// Shape of the tiles, slowest axis first. A tile is the task of one worker, and a chunk of the map file.
    /// Default: a shape that depends on the rest of the plan.
    pub fn tile_shape(mut self, shape: impl Into<Vec<usize>>) -> Self {
        self.tile_shape = Some(shape.into());
        self
    }

    /// Validates and makes the plan.
    ///
    /// # Errors
    /// The first error found.
    pub fn build(self) -> Result<Plan, PlanError> {
        let Self { mut plan, tile_shape } = self;
        if plan.methods.is_empty() {
            return Err(PlanError::NoMethod);
        }
        // Maps and tables list methods and fields in a fixed order, whatever the order of the request.
        let wanted = std::mem::take(&mut plan.methods);
        let chosen = |known: Method| wanted.iter().find(|method| **method == known).copied();
        plan.methods = Method::all().filter_map(chosen).collect();
        let wanted = std::mem::take(&mut plan.fields);
        plan.fields = Field::ALL
            .into_iter()
            .filter(|field| *field == Field::Verdict || wanted.contains(field))
            .collect();
        if !TOLERANCES.contains(&plan.tolerance) {
            return Err(PlanError::Tolerance(plan.tolerance));
        }
        if plan.audit_cells > MOST_AUDIT_CELLS {
            return Err(PlanError::AuditCells(plan.audit_cells));
        }
        if plan.compression > 9 {
            return Err(PlanError::Compression(plan.compression));
        }
        // Without the simulation there is nothing to audit.
        let simulated = plan.methods.contains(&Method::Simulation);
        plan.audit_cells = if simulated { plan.audit_cells.min(plan.grid.cells()) } else { 0 };
        let proves = plan.has_box() && plan.methods.contains(&Method::Test(&validated::TEST));
        plan.proof_boxes = if proves { plan.proof_boxes } else { 0 };
        if let Some(plane) = plan.planes.iter().find(|plane| !lies_in(plane, plan.grid.axes())) {
            return Err(PlanError::Plane(plane.clone()));
        }
        let shape = plan.grid.shape();
        plan.tile_shape = match tile_shape {
            None if plan.interpolates() && !plan.has_orbits() => {
                let cells = tiles::cells(plan.grid.cells(), false);
                plan.grid.even_tile_shape(cells.max(tiles::LEAST_CELLS_INTERPOLATED))
            }
            None => {
                let cells = tiles::cells(plan.grid.cells(), plan.has_orbits());
                // Columns that differ only in eps share their cycles unless the law contains eps, so one tile
                // contains them.
                let whole_columns = cells / plan.grid.dampings().len().max(1);
                let together = if plan.grid.shares_laws() { shape[0].min(whole_columns).max(1) } else { 1 };
                let mut tile = plan.grid.tile_shape(cells / together);
                tile[0] = tile[0].max(together);
                tile
            }
            Some(tile) if tile.len() == shape.len() && !tile.contains(&0) => tile,
            Some(tile) => return Err(PlanError::TileShape(tile, shape)),
        };
        Ok(plan)
    }
}

/// Returns whether a plane has two different axes of several nodes, and a node of every other axis.
fn lies_in(plane: &Plane, axes: &[Axis]) -> bool {
    let extends = |axis: usize| axes.get(axis).is_some_and(|axis| axis.values.len() > 1);
    plane.x != plane.y
        && extends(plane.x)
        && extends(plane.y)
        && plane.held.len() == axes.len()
        && plane.held.iter().zip(axes).all(|(&node, axis)| node < axis.values.len())
}

impl Plan {
    /// Returns whether every cell needs orbits of its own, so that columns cannot be labelled as a whole.
    fn has_orbits(&self) -> bool {
        let of_method = |method: &Method| match method {
            Method::Direct | Method::Naive(..) => true,
            Method::Test(_) => *method == Method::validated(),
            Method::Simulation => false,
        };
        let of_field = |field: &Field| !self.quantities_of(*field).is_empty();
        self.methods.iter().any(of_method) || self.fields.iter().any(of_field)
    }

    /// Returns whether the simulation's answers may be interpolated between columns: with few dampings, a law
    /// other than Stribeck's, and either backbones or no critical dampings and margins to store.
    pub fn interpolates(&self) -> bool {
        if !self.methods.contains(&Method::Simulation)
            || self.grid.dampings().len() > MOST_DAMPINGS_INTERPOLATED
            // What is interpolated takes C(V) for eps c*.
            || self.grid.law().may_drop()
        {
            return false;
        }
        let column = self.grid.some_column();
        column.curve.stribeck().is_none()
            && (self.interpolates_backbones(&column)
                || !self.stores(Field::CriticalC) && !self.stores(Field::Margin))
    }

    /// Returns whether backbones for the regime may be interpolated; corners would take too many nodes.
    pub(super) fn interpolates_backbones(&self, Column { curve, belt_speed, .. }: &Column) -> bool {
        self.stores(Field::Regime)
            && curve.corners().is_empty()
            && !curve.has_one_slip_cycle_at_most(*belt_speed)
    }

    /// Whether the axes span a box of a law's parameters of which points between the nodes can be proved. Of a
    /// machine that is so where belt speed and damping alone vary.
    pub fn has_box(&self) -> bool {
        let varies = |axis: &Axis| axis.role == AxisRole::Quantity && axis.values.len() > 1;
        self.grid.law().is_enclosed_over_boxes() && !self.grid.axes().iter().any(varies)
    }

    /// A plan for every cell of `grid`, with the defaults of configurations.
    pub fn builder(grid: Grid) -> PlanBuilder {
        PlanBuilder {
            plan: Plan {
                grid,
                methods: Method::usual().collect(),
                fields: Vec::new(),
                tolerance: DEFAULT_TOLERANCE,
                audit_cells: DEFAULT_AUDIT_CELLS,
                proof_boxes: DEFAULT_PROOF_BOXES,
                planes: Vec::new(),
                tile_shape: Vec::new(),
                compression: DEFAULT_COMPRESSION,
            },
            tile_shape: None,
        }
    }

    /// Number of tiles.
    #[must_use]
    pub fn tile_count(&self) -> usize {
        self.grid.tile_count(&self.tile_shape)
    }

    /// Returns whether `field` is stored.
    #[must_use]
    pub fn stores(&self, field: Field) -> bool {
        self.fields.contains(&field)
    }

    /// The quantities of the stored fields, in the order in which a map lists them.
    #[must_use]
    pub fn quantities(&self) -> Vec<Quantity> {
        self.fields.iter().flat_map(|field| self.quantities_of(*field)).collect()
    }

    fn quantities_of(&self, field: Field) -> Vec<Quantity> {
        Quantity::of(field, self.methods.len(), self.grid.axes().len() - 1)
    }

    /// Bound of the right-hand sides of the cells, in units of those of the Stribeck law, by the quotas. Most pieces of
    /// knowledge take a thousandth of theirs.
    pub fn most_work(&self) -> u128 {
        let quota = |pieces: &[Piece]| pieces.iter().map(|piece| u128::from(piece.quota())).sum::<u128>();
        let stored = |field, work: u128| if self.stores(field) { work } else { 0 };
        use Piece::{CoarseBackbones, Critical, Fate, FineBackbone, Kick, Loops, RoughBackbone, SlipCycles};
        // C* in two accuracies, and C(V) of a curve without its drop; coarse backbones of its own and to be interpolated.
        let of_column = quota(&[Critical, Critical, Critical])
            + quota(&[CoarseBackbones, CoarseBackbones, FineBackbone, RoughBackbone])
            + stored(Field::Sensitivity, quota(&[Critical, Critical, Piece::Sensitivity]));
        let orbits = self.methods.len() as u128 * quota(&[Fate]);
        let of_cell = orbits
            + stored(Field::Regime, quota(&[Loops]))
            + stored(Field::Landing, quota(&[Fate, Fate]))
            + stored(Field::Cycle, quota(&[Fate, Fate, SlipCycles, Loops]))
            + stored(Field::Basin, quota(&[SlipCycles, Kick]))
            + stored(Field::EpsilonLimit, 2 * self.methods.len() as u128 * u128::from(limits::WORK));
        // Tiles that part the dampings of a column ask for it once each.
        let dampings = self.grid.dampings().len();
        let parts = dampings.div_ceil(self.tile_shape.last().copied().unwrap_or(dampings).max(1)) as u128;
        let columns = self.grid.column_count() as u128;
        columns * parts * of_column + self.grid.cells() as u128 * of_cell
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_model::friction::{Expression, Law};
    use slipmap_model::point::LawParameters;

    #[test]
    fn tiles_span_eps_unless_the_law_contains_it() {
        let nodes = |count: u32| (1..=count).map(|i| 0.01 * f64::from(i)).collect::<Vec<_>>();
        for (text, together) in [("exp(-u)", true), ("1 - eps*u/(1 + u)", false)] {
            let law = Law::Expression(Expression::new(text, 1.0).unwrap());
            for (epsilons, dampings) in [(20, 50), (200, 1), (200, 500)] {
                let grid =
                    Grid::new(law.clone(), vec![nodes(epsilons), nodes(400), nodes(dampings)]).unwrap();
                let plan = Plan::builder(grid).methods([Method::Simulation]).fields([Field::Regime]);
                let shape = plan.build().unwrap().tile_shape;
                assert_eq!(shape[2], dampings as usize, "{text}: {shape:?}");
                let most = (1 << 16) / shape[2];
                assert_eq!(shape[0] == most.min(epsilons as usize), together, "{text}: {shape:?}");
            }
        }
        let law = Expression::new("exp(-u)", 1.0).unwrap();
        let [one, other] =
            [0.1, 0.2].map(|eps| Law::Expression(law.clone()).curve(eps, &LawParameters::new(&[])));
        assert_eq!(one, other);
    }

    #[test]
    fn illegal_plans_are_refused() {
        let nodes = [vec![0.1], vec![0.4], vec![0.2], vec![2.0], vec![1.0], vec![0.0, 0.3]];
        let grid = Grid::new(Law::Stribeck, nodes.to_vec()).unwrap();
        let plan = || Plan::builder(grid.clone());
        let plane = Plane { x: 0, y: 5, held: vec![0; 6] };
        for (builder, words) in [
            (plan().methods([]), "at least one method"),
            (plan().tolerance(f64::NAN), "the tolerance is NaN"),
            (plan().tolerance(0.1), "the tolerance is 0.1"),
            (plan().audit_cells(1_000_000_000_000), "an audit of 1000000000000 cells"),
            (plan().compression(10), "the compression is 10"),
            (plan().tile_shape([]), "tiles of the shape []"),
            (plan().tile_shape([1, 1, 1, 1, 1, 0]), "tiles of the shape [1, 1, 1, 1, 1, 0]"),
            (plan().planes([plane]), "there is no plane of the axes 0 and 5"),
        ] {
            let refused = builder.build().unwrap_err().to_string();
            assert!(refused.contains(words), "{refused}");
        }
        assert!(plan().build().is_ok());
    }
}
