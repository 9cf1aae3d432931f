//! Whole maps, all seven verdicts, by each engine and number of threads:
//!
//! ```text
//! cargo bench --bench maps
//! ```
//! Maps stay in memory; scripts/study scaling measures maps that are written. Every engine's verdicts are checked
//! against those of `direct` before it is timed.

#![allow(clippy::expect_used)] // a bench whose answers are wrong stops

use std::convert::Infallible;
use std::sync::{Mutex, PoisonError};

use divan::Bencher;
use divan::counter::ItemsCount;
use slipmap::friction::Law;
use slipmap::map::{Account, Control, Engine, Grid, Method, Plan, Runs, Sink, TileData, Verdict, run};

fn main() {
    divan::main();
}

/// The verdicts of `simulation` by tile, in the order of the tiles.
#[derive(Default)]
struct Verdicts(Mutex<Vec<(usize, Runs<Verdict>)>>);

impl Sink for Verdicts {
    type Packed = (usize, Runs<Verdict>);
    type Error = Infallible;

    fn pack(&self, data: &TileData) -> Result<Self::Packed, Infallible> {
        let simulation = data.methods.iter().find(|cells| cells.method == Method::Simulation);
        Ok((data.tile.number, simulation.map(|cells| cells.verdicts.clone()).unwrap_or_default()))
    }

    fn write(&self, packed: Self::Packed, _: &Account) -> Result<(), Infallible> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(packed);
        Ok(())
    }
}

fn axis(from: f64, to: f64, points: usize) -> Vec<f64> {
    (0..points).map(|i| from + (to - from) * i as f64 / (points - 1) as f64).collect()
}

/// n^5 cells of the box for which speeds are stated.
fn plan(engine: Engine, n: usize) -> Plan {
    let nodes = vec![
        vec![0.05],
        axis(0.0, 1.0, n),
        axis(0.0, 0.5, n),
        axis(0.0, 4.0, n),
        axis(0.2, 1.5, n),
        axis(0.0, 1.0, n),
    ];
    let grid = Grid::new(Law::Stribeck, nodes).expect("ascending axes");
    Plan::builder(grid)
        .engine(engine)
        .audit_cells(0)
        .tile_shape([1, 2, n, n, n, n])
        .compression(0)
        .build()
        .expect("a legal plan")
}

fn verdicts(plan: &Plan, threads: usize) -> Vec<(usize, Runs<Verdict>)> {
    let sink = Verdicts::default();
    let control = Control { threads: Some(threads), ..Control::default() };
    run(plan, &sink, &control).expect("a sink that never fails");
    let mut tiles = sink.0.into_inner().unwrap_or_else(PoisonError::into_inner);
    tiles.sort_by_key(|(number, _)| *number);
    tiles
}

/// One engine, one thread.
#[divan::bench(args = Engine::ALL.map(Engine::name), sample_count = 10)]
fn engine(bencher: Bencher, name: &str) {
    let engine = Engine::ALL.into_iter().find(|engine| engine.name() == name).expect("an engine's own name");
    let plan = plan(engine, 6);
    let direct = self::plan(Engine::Direct, 6);
    assert_eq!(verdicts(&plan, 1), verdicts(&direct, 1), "{name}");
    bencher.counter(ItemsCount::new(plan.grid().cells())).bench_local(|| verdicts(&plan, 1));
}

/// The engine `auto`, by nodes per axis and threads.
#[divan::bench(args = [(16, 1), (16, 2), (24, 1), (24, 2)], sample_count = 10)]
fn auto(bencher: Bencher, (n, threads): (usize, usize)) {
    let plan = plan(Engine::Auto, n);
    assert_eq!(verdicts(&plan, threads), verdicts(&plan, 1));
    bencher.counter(ItemsCount::new(plan.grid().cells())).bench_local(|| verdicts(&plan, threads));
}
