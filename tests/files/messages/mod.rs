//! A sink that records the messages that other processes send to the writing process.

use std::sync::Mutex;

use slipmap::map::{Account, Sink, TileData};
use slipmap::store::{PackedTile, Packer, StoreError};

/// Records each message.
pub struct Messages(pub Packer, pub Mutex<Vec<Vec<u8>>>);

impl Sink for Messages {
    type Packed = PackedTile;
    type Error = StoreError;

    fn pack(&self, data: &TileData) -> Result<PackedTile, StoreError> {
        Ok(self.0.pack(data))
    }

    fn write(&self, packed: PackedTile, account: &Account) -> Result<(), StoreError> {
        self.1.lock().unwrap().push(self.0.to_bytes(&packed, account));
        Ok(())
    }
}
