//! The interface of a receiver of computed tiles.

use super::{Account, TileData};

/// A receiver of tiles. The workers call [`Sink::pack`] in parallel, one thread calls [`Sink::write`]; tiles
/// arrive in any order, each exactly once.
pub trait Sink: Sync {
    /// A packed tile.
    type Packed: Send;
    /// Reason why a tile could not be written.
    type Error: Send + std::error::Error + 'static;

    /// Packs a tile for writing: the expensive part, done by the workers.
    ///
    /// # Errors
    /// The sink's own.
    fn pack(&self, data: &TileData) -> Result<Self::Packed, Self::Error>;

    /// Writes a packed tile. Its account is complete only now, since it includes the packing.
    ///
    /// # Errors
    /// The sink's own.
    fn write(&self, packed: Self::Packed, account: &Account) -> Result<(), Self::Error>;
}
