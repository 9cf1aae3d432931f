//! What is to be computed.

use super::{Grid, Method, Quantity};

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
    /// `landing_x1`, `stick_time`, `slip_time` and `crossings`.
    Landing,
    /// Period, amplitudes and multiplier of the attracting cycle.
    Cycle,
    /// The unstable slip cycle around steady slip, and the kicks that start stick-slip.
    Basin,
    /// `epsilon_limit_METHOD`.
    EpsilonLimit,
}

impl Field {
    /// Every field.
    pub const ALL: [Field; 8] = [
        Field::Verdict,
        Field::Margin,
        Field::CriticalC,
        Field::Regime,
        Field::Landing,
        Field::Cycle,
        Field::Basin,
        Field::EpsilonLimit,
    ];

    /// Name in configurations.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Field::Verdict => "verdict",
            Field::Margin => "margin",
            Field::CriticalC => "critical_c",
            Field::Regime => "regime",
            Field::Landing => "landing",
            Field::Cycle => "cycle",
            Field::Basin => "basin",
            Field::EpsilonLimit => "epsilon_limit",
        }
    }

    /// Whether it comes from the simulated flow, whatever the methods.
    #[must_use]
    pub fn needs_flow(self) -> bool {
        match self {
            Field::Verdict | Field::Margin | Field::CriticalC => false,
            Field::Regime | Field::Landing | Field::Cycle | Field::Basin | Field::EpsilonLimit => true,
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
    /// The stored fields, in the order of [`Field::ALL`]; [`Field::Verdict`] is always among them.
    pub fields: Vec<Field>,
    /// How `simulation` decides cells.
    pub engine: Engine,
    /// Bound on the error of the scaled grazing margin m / V that the simulation aims at.
    pub tolerance: f64,
    /// Number of cells that the direct engine decides again.
    pub audit_cells: usize,
    /// Boxes of scaled parameters that the method `validated`, if it is among the methods, tries to prove in
    /// order to decide what lies between the nodes; 0 for none.
    pub proof_boxes: usize,
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

    /// The quantities of the stored fields, in the order in which a map lists them.
    #[must_use]
    pub fn quantities(&self) -> Vec<Quantity> {
        self.fields.iter().flat_map(|field| Quantity::of(*field, self.methods.len())).collect()
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
            Field::Landing | Field::Cycle | Field::Basin | Field::EpsilonLimit => {
                8 * cells * Quantity::of(*field, self.methods.len()).len() as u128
            }
        };
        self.fields.iter().map(per_field).sum()
    }
}
