//! What is to be computed.

use super::{Grid, Method};

/// How the method `simulation` decides cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// Every cell by integration in (x1, x2).
    Direct,
    /// Every cell by the scalar return map.
    ReturnMap,
    /// One critical damping per column, cells by comparison.
    CriticalSurface,
    /// The cheapest path whose error bound decides the cell.
    Auto,
}

impl Engine {
    /// Every engine.
    pub const ALL: [Engine; 4] = [Engine::Auto, Engine::CriticalSurface, Engine::ReturnMap, Engine::Direct];

    /// Name in configurations.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Engine::Direct => "direct",
            Engine::ReturnMap => "return_map",
            Engine::CriticalSurface => "critical_surface",
            Engine::Auto => "auto",
        }
    }
}

/// A quantity a map can store.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// `verdict_METHOD`, always stored.
    Verdict,
    /// `margin_METHOD`.
    Margin,
    /// `critical_c_METHOD`, without the damping axis.
    CriticalC,
    /// `regime`.
    Regime,
    /// `landing_x1`, `stick_time` and `slip_time`.
    Landing,
}

impl Field {
    /// Every field.
    pub const ALL: [Field; 5] =
        [Field::Verdict, Field::Margin, Field::CriticalC, Field::Regime, Field::Landing];

    /// Name in configurations.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Field::Verdict => "verdict",
            Field::Margin => "margin",
            Field::CriticalC => "critical_c",
            Field::Regime => "regime",
            Field::Landing => "landing",
        }
    }
}

/// A validated job.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The grid.
    pub grid: Grid,
    /// The methods, in the order of [`Method::all`], without repetition.
    pub methods: Vec<Method>,
    /// The stored fields; [`Field::Verdict`] is always among them.
    pub fields: Vec<Field>,
    /// How `simulation` decides cells.
    pub engine: Engine,
    /// Bound on the error of the scaled grazing margin m / V that the simulation aims at.
    pub tolerance: f64,
    /// Number of cells that the direct engine decides again.
    pub audit_cells: usize,
    /// Shape of the tiles, see [`Grid::tile_shape`].
    pub tile_shape: Vec<usize>,
    /// How hard the stored map is compressed: 0 (not at all) to 9 (smallest file).
    pub compression: u8,
}

impl Plan {
    /// Whether `field` is to be stored.
    #[must_use]
    pub fn stores(&self, field: Field) -> bool {
        self.fields.contains(&field)
    }

    /// Bytes of the map before compression.
    #[must_use]
    pub fn bytes(&self) -> u128 {
        let cells = self.grid.cells() as u128;
        let columns = cells / self.grid.dampings().len().max(1) as u128;
        let methods = self.methods.len() as u128;
        let per_field = |field: &Field| match field {
            Field::Verdict => methods * cells,
            Field::Margin => 8 * methods * cells,
            Field::CriticalC => 8 * methods * columns,
            Field::Regime => cells,
            Field::Landing => 24 * cells,
        };
        self.fields.iter().map(per_field).sum()
    }
}
