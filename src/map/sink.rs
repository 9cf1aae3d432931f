//! Where computed tiles go.

use super::{Account, Method, Regime, Runs, Tile, Verdict};

/// What one method says of the cells of a tile.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodCells {
    /// The method.
    pub method: Method,
    /// Verdicts, row-major over the tile's shape.
    pub verdicts: Runs<Verdict>,
    /// Margins, row-major over the tile's shape; empty unless stored.
    pub margins: Vec<f64>,
    /// Critical damping of each column, row-major over the tile's shape without the damping axis; empty
    /// unless stored. NaN where the column has no critical damping c >= 0.
    pub critical: Vec<f64>,
}

/// Everything computed for one tile.
#[derive(Clone, Debug, PartialEq)]
pub struct TileData {
    /// The tile.
    pub tile: Tile,
    /// One entry per method of the plan, in its order.
    pub methods: Vec<MethodCells>,
    /// Regimes, row-major over the tile's shape; empty unless stored.
    pub regime: Runs<Regime>,
    /// The values of each of the plan's [`Plan::quantities`](super::Plan::quantities), in its order, row-major
    /// over the tile's shape.
    pub quantities: Vec<Vec<f64>>,
}

/// A receiver of tiles. The workers call [`Sink::pack`] in parallel, one thread calls [`Sink::write`];
/// tiles arrive in any order, each exactly once.
pub trait Sink: Sync {
    /// A tile made ready for writing.
    type Packed: Send;
    /// Why a tile could not be written.
    type Error: Send + std::error::Error + 'static;

    /// Makes a tile ready for writing: the expensive part, done by the workers.
    ///
    /// # Errors
    /// The sink's own.
    fn pack(&self, data: &TileData) -> Result<Self::Packed, Self::Error>;

    /// Writes a packed tile. Its account is known only now: packing is part of it.
    ///
    /// # Errors
    /// The sink's own.
    fn write(&self, packed: Self::Packed, account: &Account) -> Result<(), Self::Error>;
}
