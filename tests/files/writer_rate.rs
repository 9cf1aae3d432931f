//! Number of tiles per second that the single writing process can store: the limit of a run on many machines.
//!
//! A measurement, not a test: `cargo test --release --test files writer_rate:: -- --ignored --nocapture`, run
//! by `scripts/mpi`.

use std::sync::Mutex;
use std::time::Instant;

use slipmap::friction::Law;
use slipmap::map::{Account, Control, Grid, Plan, Queue, Sink, TileData, compute_tiles};
use slipmap::store::{Existing, PackedTile, Packer, PartialMap, Provenance, StoreError};

/// All seven verdicts on a box of `tiles` tiles, each of `layers` values of gamma by 256 by 256 cells, across
/// the boundary of existence.
fn plan(layers: usize, tiles: usize) -> Plan {
    let nodes = 256;
    let axis = |from: f64, to: f64, n: usize| -> Vec<f64> {
        (0..n).map(|i| from + (to - from) * i as f64 / (n - 1).max(1) as f64).collect()
    };
    let outer = (tiles as f64).sqrt().ceil() as usize;
    let nodes = vec![
        vec![0.05],
        axis(0.0, 0.9, outer),
        vec![0.1],
        axis(0.1, 4.0, outer * layers),
        axis(0.2, 1.5, nodes),
        axis(0.0, 1.0, nodes),
    ];
    let tile_shape = vec![1, 1, 1, layers, nodes[4].len(), nodes[5].len()];
    Plan::builder(Grid::new(Law::Stribeck, nodes).unwrap())
        .audit_cells(0)
        .tile_shape(tile_shape)
        .build()
        .unwrap()
}

/// Keeps tiles, and the messages with which other processes send them.
struct Sample(Packer, Mutex<Vec<(TileData, Account, Vec<u8>)>>);

impl Sink for Sample {
    type Packed = (TileData, PackedTile);
    type Error = StoreError;

    fn pack(&self, data: &TileData) -> Result<Self::Packed, StoreError> {
        Ok((data.clone(), self.0.pack(data)))
    }

    fn write(&self, (data, packed): Self::Packed, account: &Account) -> Result<(), StoreError> {
        let message = self.0.to_bytes(&packed, account);
        self.1.lock().unwrap().push((data, account.clone(), message));
        Ok(())
    }
}

#[test]
#[ignore = "a measurement: prints a table"]
fn rate_of_the_writer() {
    println!(
        "cells_per_tile,tiles,message_bytes_per_tile,computing_microseconds_per_tile,writing_microseconds_per_tile,\
         journal_bytes_per_cell,cores_per_writer"
    );
    for (layers, tiles) in [(1, 4000), (1, 16000), (1, 64000), (16, 400), (16, 1600), (16, 6400)] {
        let plan = plan(layers, tiles);
        let cells: usize = plan.tile_shape().iter().product();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.h5");
        let count = plan.tile_count();
        // A few tiles, evenly spread, represent all.
        let sample: Vec<bool> = (0..count).map(|tile| !(tile + 1).is_multiple_of(count / 25)).collect();
        let sink = Sample(Packer::new(&plan), Mutex::default());
        let queue = Queue::new(sample);
        let control = Control { threads: Some(1), ..Control::default() };
        let start = Instant::now();
        compute_tiles(&plan, &sink, &control, &|| queue.take()).unwrap();
        let tiles = sink.1.into_inner().unwrap();
        let computing = start.elapsed().as_secs_f64() / tiles.len() as f64;
        let bytes = tiles.iter().map(|(.., message)| message.len()).sum::<usize>() / tiles.len();

        let map = PartialMap::begin(&path, &plan, &Provenance::default(), Existing::Refuse).unwrap();
        let mut writing = 0.0;
        for number in 0..count {
            let (data, account, _) = &tiles[number % tiles.len()];
            let tile = plan.grid().tile(plan.tile_shape(), number);
            let packed = map.packer().pack(&TileData { tile, ..data.clone() });
            let message = map.packer().to_bytes(&packed, account);
            let start = Instant::now();
            let (packed, account) = map.packer().from_bytes(&message).unwrap();
            map.write(packed, &account).unwrap();
            writing += start.elapsed().as_secs_f64() / count as f64;
        }
        let journal = std::fs::metadata(folder.path().join("map.h5.part")).unwrap().len();
        println!(
            "{},{count},{bytes},{:.1},{:.1},{:.4},{:.0}",
            cells,
            1e6 * computing,
            1e6 * writing,
            journal as f64 / (count * cells) as f64,
            computing / writing
        );
    }
}
