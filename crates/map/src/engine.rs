//! The parallel engine: worker threads compute and pack tiles, and the calling thread writes them. A bounded
//! channel between them limits the memory. The content of a tile depends on the plan alone, so a map is the
//! same for any number of threads.

use std::cell::LazyCell;
use std::collections::HashSet;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::sync_channel;

use rayon::ThreadPool;

use super::account::{Account, MethodAccount, count, failed_cells};
use super::audit::Draws;
use super::contradictions::contradictions;
use super::interpolation::Interpolated;
use super::proved::Proved;
use super::quantity::describe;
use super::shard::Shard;
use super::simulation::{Simulated, Wanted, simulate};
use super::{Field, MethodCells, Plan, PlaneCurves, Runs, Sink, Tile, TileData};
use crate::clock::timed;
use slipmap_certify::{Claim, Columns, Dampings};
use slipmap_column::{End, Method, Regime, Verdict};
use slipmap_model::filippov::Oscillator;
use slipmap_model::friction::Column;

/// The number of threads, the callbacks and the interruption of a computation.
pub struct Control<'a> {
    /// Number of worker threads; all cores if `None`.
    pub threads: Option<usize>,
    /// Called with the number of cells just computed, from any worker.
    pub on_cells: &'a (dyn Fn(usize) + Sync),
    /// Called after each plane of curves, from any worker.
    pub on_plane: &'a (dyn Fn() + Sync),
    /// Called with the number of boxes of parameters of which a proof was tried so far.
    pub on_boxes: &'a (dyn Fn(usize) + Sync),
    /// Set to true to stop after the current tiles.
    pub stop: &'a AtomicBool,
}

impl Default for Control<'_> {
    /// All cores, no callbacks, never stopped.
    fn default() -> Self {
        static NEVER: AtomicBool = AtomicBool::new(false);
        Self { threads: None, on_cells: &|_| (), on_plane: &|| (), on_boxes: &|_| (), stop: &NEVER }
    }
}

/// The result of a run, without the cells themselves.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Wall-clock seconds.
    pub seconds: f64,
    /// Number of worker threads.
    pub threads: usize,
    /// The sum of the accounts of all tiles, with the disagreements of the audit in the order of the grid.
    pub account: Account,
    /// The proofs between the nodes, if the plan requests them.
    pub proved: Option<Proved>,
    /// The curves of codimension one, if the plan requests them.
    pub curves: Vec<PlaneCurves>,
    /// Wall-clock seconds that the curves took.
    pub curves_seconds: f64,
}

/// Reason why a computation ended early.
#[derive(Debug, thiserror::Error)]
pub enum ComputeError<E: std::error::Error> {
    /// [`Control::stop`] was set.
    #[error("interrupted")]
    Interrupted,
    /// The worker threads could not be started.
    #[error("cannot start the worker threads: {0}")]
    Threads(String),
    /// The sink failed.
    #[error(transparent)]
    Sink(E),
}

/// The tiles of a plan, each handed out once. It takes memory for those that are finished only: a grid may have more tiles
/// than memory has bytes.
#[derive(Debug)]
pub struct Queue {
    next: AtomicUsize,
    tiles: usize,
    finished: HashSet<usize>,
    shard: Shard,
}

impl Queue {
    /// The queue of the tiles of a number of `tiles` that are not `finished`.
    #[must_use]
    pub fn new(tiles: usize, finished: HashSet<usize>) -> Self {
        Self { next: AtomicUsize::new(0), tiles, finished, shard: Shard::WHOLE }
    }

    /// Those of them that belong to a shard.
    #[must_use]
    pub fn of_shard(self, shard: Shard) -> Self {
        Self { shard, ..self }
    }

    /// Number of the next tile to compute; `None` when none is left.
    pub fn take(&self) -> Option<usize> {
        loop {
            let tile = self.shard.tile(self.next.fetch_add(1, Ordering::Relaxed));
            let tile = tile.filter(|&tile| tile < self.tiles)?;
            if !self.finished.contains(&tile) {
                return Some(tile);
            }
        }
    }
}

/// Ends the work of all workers where one panics: else the panic would be seen at their end.
struct EndsAll<'a>(&'a AtomicBool);

impl Drop for EndsAll<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.store(true, Ordering::Relaxed);
        }
    }
}

/// Computes tiles into `sink`. The workers call `next` for the number of the next tile, until it returns
/// `None`. Returns the sum of the tiles' accounts, and the number of workers.
///
/// # Errors
/// [`ComputeError`]; the sink may then lack tiles whose numbers `next` has returned.
pub fn compute_tiles<S: Sink>(
    plan: &Plan,
    sink: &S,
    control: &Control,
    next: &(dyn Fn() -> Option<usize> + Sync),
) -> Result<(Account, usize), ComputeError<S::Error>> {
    let draws = Draws::new(plan);
    let failed = AtomicBool::new(false);
    let compute = || {
        let number = next()?;
        if control.stop.load(Ordering::Relaxed) || failed.load(Ordering::Relaxed) {
            return None;
        }
        let message = work(plan, sink, &draws, &plan.grid.tile(&plan.tile_shape, number));
        if let Ok((_, account)) = &message {
            (control.on_cells)(account.cells as usize);
        }
        Some(message)
    };
    let mut sum = Account::none(plan);
    let mut outcome = Ok(());
    let mut take = |message: Result<(S::Packed, Account), S::Error>| {
        if outcome.is_err() {
            return;
        }
        let written = message.and_then(|(packed, account)| {
            let (written, seconds) = timed(|| sink.write(packed, &account));
            written.map(|()| (account, seconds))
        });
        match written {
            Ok((account, seconds)) => {
                sum.add(account);
                sum.stages.write += seconds;
            }
            Err(error) => {
                failed.store(true, Ordering::Relaxed);
                outcome = Err(error);
            }
        }
    };
    let threads = match super::pool(control.threads) {
        // WebAssembly has no threads.
        Err(_) if cfg!(target_family = "wasm") => {
            std::iter::from_fn(compute).for_each(take);
            1
        }
        Err(error) => return Err(ComputeError::Threads(error.to_string())),
        Ok(pool) => {
            let threads = pool.current_num_threads();
            in_parallel(&pool, &failed, &compute, &mut take)
                .map_err(|error| ComputeError::Threads(error.to_string()))?;
            threads
        }
    };
    outcome.map_err(ComputeError::Sink)?;
    if control.stop.load(Ordering::Relaxed) {
        return Err(ComputeError::Interrupted);
    }
    Ok((sum, threads))
}

/// Calls `compute` in all workers of a pool until it returns `None`, and `take` in this thread with what it returns.
fn in_parallel<T: Send>(
    pool: &ThreadPool,
    failed: &AtomicBool,
    compute: &(dyn Fn() -> Option<T> + Sync),
    take: &mut dyn FnMut(T),
) -> std::io::Result<()> {
    let (sender, receiver) = sync_channel(2 * pool.current_num_threads());
    std::thread::scope(|scope| {
        let workers = move || {
            pool.broadcast(|_| {
                let (sender, _ends_all) = (sender.clone(), EndsAll(failed));
                while let Some(message) = compute() {
                    if sender.send(message).is_err() {
                        break;
                    }
                }
            });
        };
        std::thread::Builder::new().spawn_scoped(scope, workers)?;
        receiver.into_iter().for_each(take);
        Ok(())
    })
}

/// Computes and packs one tile.
fn work<S: Sink>(
    plan: &Plan,
    sink: &S,
    draws: &Draws,
    tile: &Tile,
) -> Result<(S::Packed, Account), S::Error> {
    let (data, mut account) = compute_tile(plan, draws, tile);
    let (packed, packing) = timed(|| sink.pack(&data));
    let ((), counting) = timed(|| {
        for (method, cells) in account.methods.iter_mut().zip(&data.methods) {
            method.counts = count(&cells.verdicts);
        }
        account.contradictions = contradictions(&data);
        account.failed = failed_cells(&plan.grid, &data);
    });
    account.stages.pack = packing + counting;
    Ok((packed?, account))
}

/// Computes one tile: all methods, and the optional fields. The account still lacks the entries that [`work`]
/// derives from the verdicts.
fn compute_tile(plan: &Plan, draws: &Draws, tile: &Tile) -> (TileData, Account) {
    let mut account = Account { cells: tile.cells() as u64, ..Account::default() };
    // Nodes without a column are computed as another one, and then made blank.
    let mut blank = Vec::new();
    let other = LazyCell::new(|| plan.grid.some_column());
    let (all, taken): (Vec<Column>, f64) = timed(|| {
        let found = plan.grid.columns(tile).enumerate();
        let or_blank = |(at, column): (usize, Option<Column>)| {
            column.unwrap_or_else(|| {
                blank.push(at);
                (*other).clone()
            })
        };
        found.map(or_blank).collect()
    });
    account.stages.columns = taken;
    let columns = Columns::new(&all);
    let cs = &plan.grid.dampings()[tile.damping_range()];
    let mut methods = Vec::with_capacity(plan.methods.len());
    let mut simulated = None;
    let needs_flow =
        plan.methods.contains(&Method::Simulation) || plan.fields.iter().any(|field| field.needs_flow());
    let (known, taken) = timed(|| match needs_flow {
        true => Interpolated::of_tile(plan, tile, &columns),
        false => Interpolated::none(),
    });
    account.stages.interpolation = taken;
    for &method in &plan.methods {
        let (cells, taken) = timed(|| match method {
            Method::Test(test) => closed_form(plan, method, &test.claims(&columns), cs),
            Method::Simulation => {
                let (cells, ends) = simulation(plan, method, &columns, cs, &known);
                simulated = Some(ends);
                cells
            }
            Method::Direct | Method::Naive(..) => {
                let decide = |column: &Column, c: f64| {
                    let oscillator = Oscillator::in_column(column, c);
                    match method {
                        Method::Naive(naive, knobs) => naive.decide(&oscillator, &knobs).verdict.into(),
                        _ => (&slipmap_witness::decisive_flow(&oscillator, plan.tolerance).fate).into(),
                    }
                };
                let verdicts =
                    columns.iter().flat_map(|column| cs.iter().map(move |&c| decide(column, c))).collect();
                // These methods have neither margins nor critical dampings.
                let no_numbers = |field, length| vec![f64::NAN; if plan.stores(field) { length } else { 0 }];
                MethodCells {
                    margins: no_numbers(Field::Margin, columns.len() * cs.len()),
                    critical: no_numbers(Field::CriticalC, columns.len()),
                    ..MethodCells::new(method, verdicts)
                }
            }
        });
        methods.push(cells);
        account.methods.push(MethodAccount { seconds: taken, ..MethodAccount::default() });
    }
    account.rhs = known.rhs;
    if let Some(Simulated { paths, rhs, without_critical, critical, .. }) = &simulated {
        account.paths = *paths;
        account.rhs += rhs;
        // A column may lie in several tiles.
        if tile.damping_range().start == 0 {
            account.unknown.critical = *without_critical;
        }
        if plan.stores(Field::CriticalC) && tile.damping_range().start == 0 {
            let withheld = critical.iter().flatten().filter(|found| found.known().is_err());
            account.unknown.inaccurate = withheld.count() as u64;
        }
    }
    let mut data = TileData { tile: tile.clone(), methods, regime: Runs::new(), quantities: Vec::new() };
    if plan.fields.iter().any(|field| field.needs_flow()) {
        let (simulated, taken) = timed(|| {
            simulated.unwrap_or_else(|| simulate(&columns, cs, plan.tolerance, Wanted::None, &known))
        });
        account.stages.fields += taken;
        let (described, taken) = timed(|| describe(plan, tile, &columns, &simulated.ends, &known));
        account.left_out_from = described.left_out_from;
        account.stages.regime = described.regime_seconds;
        account.stages.fields += taken - described.regime_seconds;
        (data.regime, data.quantities) = (described.regimes, described.quantities);
    }
    data.blank_out(&blank);
    account.blank = (blank.len() * cs.len()) as u64;
    let verdicts: Vec<&Runs<Verdict>> = data.methods.iter().map(|cells| &cells.verdicts).collect();
    (account.audit, account.stages.audit) = timed(|| draws.audit(plan, tile, &verdicts));
    account.unknown.regimes = data.regime.count(|regime| regime == Regime::Failed);
    if !data.regime.is_empty() {
        account.unknown.regimes -= account.blank;
    }
    (data, account)
}

/// Evaluates a closed-form test on the columns of a tile, cell by cell.
fn closed_form(plan: &Plan, method: Method, claims: &[Claim], cs: &[f64]) -> MethodCells {
    let mut cells = MethodCells::new(method, Runs::new());
    let mut dampings = Dampings::new(cs);
    for claim in claims {
        for (decision, length) in dampings.decide(claim) {
            cells.verdicts.push(decision.into(), length);
        }
        if plan.stores(Field::Margin) {
            cells.margins.extend(cs.iter().map(|&c| claim.margin(c)));
        }
        if plan.stores(Field::CriticalC) {
            cells.critical.push(claim.edge().unwrap_or(f64::NAN));
        }
    }
    cells
}

/// Simulates the flow on the columns of a tile.
fn simulation(
    plan: &Plan,
    method: Method,
    columns: &Columns,
    cs: &[f64],
    known: &Interpolated,
) -> (MethodCells, Simulated) {
    let want_critical = plan.stores(Field::CriticalC);
    let wanted = match (plan.stores(Field::Margin), want_critical) {
        (true, _) => Wanted::All,
        (false, true) => Wanted::Legal,
        (false, false) => Wanted::None,
    };
    let simulated = simulate(columns, cs, plan.tolerance, wanted, known);
    let mut cells = MethodCells::new(method, simulated.ends.map(End::verdict));
    if plan.stores(Field::Margin) {
        let edges = simulated
            .critical
            .iter()
            .map(|critical| critical.and_then(|found| found.known().ok()).map_or(f64::NAN, |found| found.c));
        cells.margins.extend(edges.flat_map(|edge| cs.iter().map(move |c| edge - c)));
    }
    if want_critical {
        for critical in &simulated.critical {
            let (value, error) = match critical.map(|found| (found, found.known())) {
                Some((found, Ok(_))) if found.c >= 0.0 => (found.c, found.error),
                // The error says why there is no value.
                Some((found, Err(_))) => (f64::NAN, found.error),
                Some((_, Ok(_))) | None => (f64::NAN, f64::NAN),
            };
            cells.critical.push(value);
            cells.critical_errors.push(error);
        }
    }
    (cells, simulated)
}
