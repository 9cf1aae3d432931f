//! The parallel engine: tiles are computed and packed by the workers of a pool, and written by the
//! calling thread. A bounded channel between them bounds memory; every tile's content depends on the plan
//! alone, so maps are equal for any number of threads.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::sync_channel;
use std::time::{Duration, Instant};

use super::account::{Account, FailedCell, MethodAccount, count, failed_cells};
use super::audit::{Audit, Draws};
use super::proved::Proved;
use super::quantity::describe;
use super::simulation::{End, Paths, Simulated, simulate};
use super::{Field, Method, MethodCells, Plan, PlaneCurves, Regime, Runs, Sink, Tile, TileData, Verdict};
use crate::certify::Claim;
use crate::filippov::Oscillator;
use crate::friction::Column;
use crate::simulate::return_map::{Turn, turns_of};
use crate::simulate::slip_cycle::{SlipCycle, slip_cycles};

/// How a computation is steered from outside.
pub struct Control<'a> {
    /// Number of worker threads; all cores if `None`.
    pub threads: Option<usize>,
    /// Called with the number of cells just computed, from any worker.
    pub on_cells: &'a (dyn Fn(usize) + Sync),
    /// Set to true to stop after the tiles in work.
    pub stop: &'a AtomicBool,
}

/// What one method did.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodSummary {
    /// The method.
    pub method: Method,
    /// Cells computed.
    pub cells: u64,
    /// Seconds that the workers spent on it, summed over them (elapsed time, not processor time).
    pub seconds: f64,
    /// Cells of each verdict, in the order of [`Verdict::ALL`].
    pub counts: [u64; 5],
}

/// What a run did.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Cells of the grid.
    pub cells: u64,
    /// Wall-clock seconds.
    pub seconds: f64,
    /// Worker threads.
    pub threads: usize,
    /// One entry per method of the plan.
    pub methods: Vec<MethodSummary>,
    /// How many cells each path of `simulation` decided.
    pub paths: Paths,
    /// Evaluations of the right-hand side by `simulation`.
    pub rhs: u64,
    /// The self-audit.
    pub audit: Audit,
    /// Seconds that the workers spent on the self-audit.
    pub audit_seconds: f64,
    /// Seconds that the workers spent packing tiles.
    pub pack_seconds: f64,
    /// The first failed cells.
    pub failed_cells: Vec<FailedCell>,
    /// What is proved between the nodes, if the plan asks for that; see [`super::prove`].
    pub proved: Option<Proved>,
    /// The curves of codimension one, if they were asked for; see [`super::curves_of`].
    pub curves: Vec<PlaneCurves>,
    /// Seconds that these took.
    pub curves_seconds: f64,
}

impl Summary {
    /// The summary of a run whose tiles' accounts sum up to `account`.
    #[must_use]
    pub fn new(plan: &Plan, account: Account, threads: usize, seconds: f64) -> Self {
        let mut audit = account.audit;
        audit.sort();
        let methods = plan.methods.iter().zip(account.methods);
        Self {
            cells: plan.grid.cells() as u64,
            seconds,
            threads,
            methods: methods
                .map(|(&method, MethodAccount { seconds, counts })| MethodSummary {
                    method,
                    cells: account.cells,
                    seconds,
                    counts,
                })
                .collect(),
            paths: account.paths,
            rhs: account.rhs,
            audit,
            audit_seconds: account.audit_seconds,
            pack_seconds: account.pack_seconds,
            failed_cells: account.failed,
            proved: None,
            curves: Vec::new(),
            curves_seconds: 0.0,
        }
    }
}

/// Why a computation ended early.
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

/// One computed tile and what it cost.
struct Computed {
    data: TileData,
    seconds: Vec<Duration>,
    paths: Paths,
    rhs: u64,
    audit: Audit,
    audit_seconds: Duration,
}

/// A tile on its way to the writer.
struct Message<P> {
    packed: P,
    account: Account,
}

/// The tiles of a plan, each handed out once.
#[derive(Debug)]
pub struct Queue {
    next: AtomicUsize,
    finished: Vec<bool>,
}

impl Queue {
    /// The tiles that are not `finished` yet: one entry per tile of the grid.
    #[must_use]
    pub fn new(finished: Vec<bool>) -> Self {
        Self { next: AtomicUsize::new(0), finished }
    }

    /// Number of the next tile to compute; `None` when all are handed out.
    pub fn take(&self) -> Option<usize> {
        loop {
            let number = self.next.fetch_add(1, Ordering::Relaxed);
            match self.finished.get(number) {
                Some(true) => {}
                Some(false) => return Some(number),
                None => return None,
            }
        }
    }
}

/// Computes the map of `plan` into `sink`.
///
/// # Errors
/// [`ComputeError`]; the sink then holds an incomplete map.
pub fn compute<S: Sink>(plan: &Plan, sink: &S, control: &Control) -> Result<Summary, ComputeError<S::Error>> {
    let start = Instant::now();
    let queue = Queue::new(vec![false; plan.grid.tile_count(&plan.tile_shape)]);
    let (account, threads) = compute_tiles(plan, sink, control, &|| queue.take())?;
    Ok(Summary::new(plan, account, threads, start.elapsed().as_secs_f64()))
}

/// Computes into `sink` the tiles whose numbers `next` hands out to the workers, until it gives `None`. The
/// sum of their accounts, and the number of workers.
///
/// # Errors
/// [`ComputeError`]; tiles that were handed out may then be missing in the sink.
pub fn compute_tiles<S: Sink>(
    plan: &Plan,
    sink: &S,
    control: &Control,
    next: &(dyn Fn() -> Option<usize> + Sync),
) -> Result<(Account, usize), ComputeError<S::Error>> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(control.threads.unwrap_or(0))
        .build()
        .map_err(|error| ComputeError::Threads(error.to_string()))?;
    let threads = pool.current_num_threads();
    let draws = Draws::new(plan);
    let failed = AtomicBool::new(false);
    let (sender, receiver) = sync_channel::<Result<Message<S::Packed>, S::Error>>(2 * threads);

    let mut sum = Account::none(plan);
    let mut outcome = Ok(());
    std::thread::scope(|scope| {
        let (failed, draws, pool) = (&failed, &draws, &pool);
        scope.spawn(move || {
            pool.broadcast(|_| {
                let sender = sender.clone();
                while let Some(number) = next() {
                    if control.stop.load(Ordering::Relaxed) || failed.load(Ordering::Relaxed) {
                        break;
                    }
                    let message = work(plan, sink, draws, &plan.grid.tile(&plan.tile_shape, number));
                    if let Ok(message) = &message {
                        (control.on_cells)(message.account.cells as usize);
                    }
                    if sender.send(message).is_err() {
                        break;
                    }
                }
            });
        });
        for message in receiver {
            if outcome.is_err() {
                continue;
            }
            let written = message.and_then(|message| {
                sink.write(message.packed, &message.account)?;
                Ok(message.account)
            });
            match written {
                Ok(account) => sum.add(account),
                Err(error) => {
                    failed.store(true, Ordering::Relaxed);
                    outcome = Err(ComputeError::Sink(error));
                }
            }
        }
    });
    outcome?;
    if control.stop.load(Ordering::Relaxed) {
        return Err(ComputeError::Interrupted);
    }
    Ok((sum, threads))
}

/// Computes and packs one tile.
fn work<S: Sink>(plan: &Plan, sink: &S, draws: &Draws, tile: &Tile) -> Result<Message<S::Packed>, S::Error> {
    let computed = compute_tile(plan, draws, tile);
    let start = Instant::now();
    let packed = sink.pack(&computed.data)?;
    let pack_seconds = start.elapsed().as_secs_f64();
    let methods: Vec<MethodAccount> = computed
        .data
        .methods
        .iter()
        .zip(&computed.seconds)
        .map(|(cells, seconds)| MethodAccount {
            seconds: seconds.as_secs_f64(),
            counts: count(&cells.verdicts),
        })
        .collect();
    let failures = Verdict::ALL.iter().position(|verdict| *verdict == Verdict::Failed);
    let any_failed = failures.is_some_and(|failed| methods.iter().any(|method| method.counts[failed] > 0));
    let account = Account {
        cells: tile.cells() as u64,
        methods,
        paths: computed.paths,
        rhs: computed.rhs,
        audit: computed.audit,
        audit_seconds: computed.audit_seconds.as_secs_f64(),
        pack_seconds,
        failed: if any_failed { failed_cells(plan, &computed.data) } else { Vec::new() },
    };
    Ok(Message { packed, account })
}

/// Computes one tile: all methods, and the optional fields.
fn compute_tile(plan: &Plan, draws: &Draws, tile: &Tile) -> Computed {
    let columns: Vec<Column> =
        (0..tile.columns()).map(|column| plan.grid.column(&tile.column_index(column))).collect();
    let cs = &plan.grid.dampings()[tile.damping_range()];
    let mut seconds = Vec::with_capacity(plan.methods.len());
    let mut methods = Vec::with_capacity(plan.methods.len());
    let mut simulated = None;
    for &method in &plan.methods {
        let start = Instant::now();
        methods.push(match method {
            Method::Test(test) => closed_form(plan, method, test.claim, &columns, cs),
            Method::Simulation => {
                let (cells, ends) = simulation(plan, method, &columns, cs);
                simulated = Some(ends);
                cells
            }
            Method::Naive(naive, knobs) => {
                let verdicts = oscillators(&columns, cs)
                    .map(|oscillator| Verdict::from(naive.decide(&oscillator, &knobs).verdict))
                    .collect();
                // These methods know neither margins nor critical dampings.
                let nothing = |field, length| vec![f64::NAN; if plan.stores(field) { length } else { 0 }];
                MethodCells {
                    method,
                    verdicts,
                    margins: nothing(Field::Margin, columns.len() * cs.len()),
                    critical: nothing(Field::CriticalC, columns.len()),
                }
            }
        });
        seconds.push(start.elapsed());
    }
    let (paths, rhs) = simulated.as_ref().map_or((Paths::default(), 0), |s: &Simulated| (s.paths, s.rhs));
    let mut data = TileData { tile: tile.clone(), methods, regime: Runs::new(), quantities: Vec::new() };
    if plan.fields.iter().any(|field| field.needs_flow()) {
        let simulated =
            simulated.unwrap_or_else(|| simulate(&columns, cs, plan.engine, plan.tolerance, false));
        if plan.stores(Field::Regime) {
            let regime = |(oscillator, end): (Oscillator, &End)| regime_of(&oscillator, *end);
            data.regime = oscillators(&columns, cs).zip(&simulated.ends).map(regime).collect();
        }
        data.quantities = describe(plan, tile, &simulated.ends);
    }
    let start = Instant::now();
    let verdicts: Vec<&Runs<Verdict>> = data.methods.iter().map(|cells| &cells.verdicts).collect();
    let audit = draws.audit(plan, tile, &verdicts);
    Computed { audit, audit_seconds: start.elapsed(), data, seconds, paths, rhs }
}

/// The cells of a tile, column by column.
fn oscillators(columns: &[Column], cs: &[f64]) -> impl Iterator<Item = Oscillator> {
    columns.iter().flat_map(move |column| cs.iter().map(move |&c| Oscillator::in_column(column, c)))
}

/// A closed-form test on the columns of a tile.
fn closed_form(
    plan: &Plan,
    method: Method,
    claim: fn(&Column) -> Claim,
    columns: &[Column],
    cs: &[f64],
) -> MethodCells {
    let mut cells = MethodCells { method, verdicts: Runs::new(), margins: Vec::new(), critical: Vec::new() };
    for column in columns {
        let claim = claim(column);
        // Along the axis: undecided below sticks_from, present, undecided, absent.
        let present_to = cs.partition_point(|&c| c < claim.present_below);
        let present_from = cs.partition_point(|&c| c < claim.sticks_from).min(present_to);
        let absent_from = cs.partition_point(|&c| c <= claim.absent_above).max(present_to);
        for (length, verdict) in [
            (present_from, Verdict::Undecided),
            (present_to - present_from, Verdict::Present),
            (absent_from - present_to, Verdict::Undecided),
            (cs.len() - absent_from, Verdict::Absent),
        ] {
            cells.verdicts.push(verdict, length);
        }
        if plan.stores(Field::Margin) {
            cells.margins.extend(cs.iter().map(|&c| claim.margin(c)));
        }
        if plan.stores(Field::CriticalC) {
            let critical = claim.present_below;
            cells.critical.push(if (0.0..f64::INFINITY).contains(&critical) { critical } else { f64::NAN });
        }
    }
    cells
}

/// The simulated flow on the columns of a tile.
fn simulation(plan: &Plan, method: Method, columns: &[Column], cs: &[f64]) -> (MethodCells, Simulated) {
    let want_critical = plan.stores(Field::CriticalC);
    let simulated = simulate(columns, cs, plan.engine, plan.tolerance, want_critical);
    let mut cells = MethodCells {
        method,
        verdicts: simulated.ends.iter().map(|end| end.verdict()).collect(),
        margins: Vec::new(),
        critical: Vec::new(),
    };
    if plan.stores(Field::Margin) {
        for column in columns {
            cells.margins.extend(turns_of(column, cs, plan.tolerance).iter().map(|turn| match *turn {
                Turn::Complete { margin, .. } => margin,
                Turn::HandOver { .. } => f64::NAN,
            }));
        }
    }
    if want_critical {
        cells.critical.extend(simulated.critical.iter().map(|critical| match critical {
            Some(critical) if critical.c >= 0.0 => critical.c,
            Some(_) | None => f64::NAN,
        }));
    }
    (cells, simulated)
}

/// The regime of a point whose orbit from the exit point ends as `flow` says.
#[must_use]
pub fn regime(oscillator: &Oscillator, flow: &crate::simulate::Flow) -> Regime {
    regime_of(oscillator, End::of(flow))
}

/// Relative error of the turns by which slip cycles are sought.
const SLIP_TOLERANCE: f64 = 1e-10;

/// An orbit that spirals inward around an unstable equilibrium must tend to a slip cycle between the two
/// (Poincare-Bendixson); around a stable one the equilibrium attracts. A stick-slip cycle around a stable
/// equilibrium coexists with it. Laws other than those that weaken less and less may have further slip
/// cycles, which are looked for.
pub(super) fn regime_of(oscillator: &Oscillator, end: End) -> Regime {
    let stable = oscillator.eigenvalues().is_stable();
    let slips = match end {
        End::Crosses | End::TooClose | End::Failed => false,
        End::Sticks | End::Inward if oscillator.curve.weakens_less_and_less() => {
            end == End::Inward && !stable
        }
        End::Sticks | End::Inward => match slip_cycles(oscillator, SLIP_TOLERANCE) {
            Ok(cycles) => cycles.iter().any(SlipCycle::is_stable),
            Err(_) => return Regime::Failed,
        },
    };
    match end {
        End::Sticks if slips => Regime::PureSlipAndStickSlip,
        End::Sticks if stable => Regime::Bistable,
        End::Sticks => Regime::StickSlip,
        End::Inward if slips && stable => Regime::PureSlipAndEquilibrium,
        End::Inward if stable => Regime::Equilibrium,
        End::Inward => Regime::PureSlip,
        End::Crosses => Regime::Crossing,
        End::TooClose | End::Failed => Regime::Failed,
    }
}
