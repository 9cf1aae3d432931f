//! Where computed tiles go.

use super::{Account, TileData};

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
