//! The interface of a receiver of computed tiles.

use std::convert::Infallible;

use super::{Account, TileData};

/// A receiver of tiles. The workers call [`Sink::pack`] in parallel, and one thread calls [`Sink::write`].
/// Each tile arrives exactly once, in any order.
pub trait Sink: Sync {
    /// A packed tile.
    type Packed: Send;
    /// Reason why a tile could not be written.
    type Error: Send + std::error::Error + 'static;

    /// Packs a tile for writing. This is the expensive part; the workers execute it.
    ///
    /// # Errors
    /// The sink's own.
    fn pack(&self, data: &TileData) -> Result<Self::Packed, Self::Error>;

    /// Writes a packed tile. Its account includes the packing, so it is complete only now.
    ///
    /// # Errors
    /// The sink's own.
    fn write(&self, packed: Self::Packed, account: &Account) -> Result<(), Self::Error>;
}

/// A receiver that calls a function of each tile, in parallel.
pub struct Each<F: Fn(&TileData) + Sync>(pub F);

impl<F: Fn(&TileData) + Sync> Sink for Each<F> {
    type Packed = ();
    type Error = Infallible;

    fn pack(&self, data: &TileData) -> Result<(), Infallible> {
        (self.0)(data);
        Ok(())
    }

    fn write(&self, (): (), _: &Account) -> Result<(), Infallible> {
        Ok(())
    }
}
