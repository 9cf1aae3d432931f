//! The cost of one answer, and the limits of the machine; scripts/study kernels makes a table of both.
//!
//! ```text
//! limits peaks                    divisions and fused multiply-adds per second of one thread
//! limits time KERNEL N            seconds and right-hand sides for N cells, after checking the answers
//! limits count KERNEL N PASSES    the same work PASSES times, for a program that counts instructions
//! ```
//! Kernels: `critical_damping`, `symmetric`, `instability`, `direct`.

#![allow(clippy::expect_used)] // a bench whose points are wrong stops

use std::hint::black_box;
use std::process::ExitCode;

use pulp::{Arch, Simd, WithSimd};
use slipmap::certify;
use slipmap::column::critical::critical_dampings;
use slipmap::filippov::Oscillator;
use slipmap::friction::{Column, Law};
use slipmap::point::Point;
use slipmap::witness;
use slipmap_map::clock::thread_time;
use slipmap_numbers::random::Random;

/// The tolerance of maps.
const TOLERANCE: f64 = 1e-9;

/// Number of independent chains of one operation: enough to hide its latency.
const CHAINS: usize = 10;
const ROUNDS: usize = 200_000;

struct Peak {
    divide: bool,
}

impl WithSimd for Peak {
    /// Number of operations per pass.
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let mut chains: [S::f64s; CHAINS] =
            std::array::from_fn(|i| simd.splat_f64s(black_box(1.0 + 1e-3 * i as f64)));
        let factor = simd.splat_f64s(black_box(1.000_000_1));
        for _ in 0..ROUNDS {
            for chain in &mut chains {
                *chain = if self.divide {
                    simd.div_f64s(*chain, factor)
                } else {
                    simd.mul_add_f64s(*chain, factor, factor)
                };
            }
        }
        black_box(chains);
        (CHAINS * ROUNDS * S::F64_LANES) as f64
    }
}

/// Operations per second, the best of several runs.
fn peak(divide: bool) -> f64 {
    let rate = |_| {
        let start = thread_time();
        let operations = Arch::new().dispatch(Peak { divide });
        operations / (thread_time() - start).as_secs_f64()
    };
    (0..20).map(rate).fold(0.0, f64::max)
}

/// Cells in the forms that the kernels need.
struct Cells {
    points: Vec<Point>,
    columns: Vec<Column>,
}

/// Random cells of the box for which speeds are stated: eps = 0.05, alpha in [0, 1], beta in [0, 0.5], gamma
/// in [0, 4], c in [0, 1], V in [0.2, 1.5].
fn cells(count: usize) -> Cells {
    let mut random = Random(20_260_414);
    let mut cells = Cells { points: Vec::new(), columns: Vec::new() };
    for _ in 0..count {
        let law = [random.unit(), 0.5 * random.unit(), 4.0 * random.unit()];
        let (damping, belt_speed) = (random.unit(), 0.2 + 1.3 * random.unit());
        let point = Law::Stribeck.point(0.05, &law, belt_speed, damping).expect("a legal point");
        cells.columns.push(Law::Stribeck.column(&point));
        cells.points.push(point);
    }
    cells
}

/// The answers of a kernel for all cells: number of right-hand sides, and a number per cell to check.
type Kernel = fn(&Cells) -> (u64, Vec<f64>);

const KERNELS: [(&str, Kernel); 4] = [
    ("critical_damping", |cells| {
        let found = critical_dampings(&cells.columns, TOLERANCE);
        let rhs = found.iter().flatten().map(|critical| critical.rhs).sum();
        (rhs, found.into_iter().map(|critical| critical.map_or(f64::NAN, |critical| critical.c)).collect())
    }),
    ("symmetric", |cells| edges(cells, &certify::symmetric::TEST)),
    ("instability", |cells| edges(cells, &certify::instability::TEST)),
    ("direct", |cells| {
        let mut rhs = 0;
        let margins = cells.points.iter().map(|point| {
            let flow = witness::flow(&Oscillator::new(&Law::Stribeck, point), TOLERANCE);
            rhs += flow.rhs;
            flow.margin
        });
        let margins = margins.collect();
        (rhs, margins)
    }),
];

fn edges(cells: &Cells, test: &certify::Test) -> (u64, Vec<f64>) {
    (0, cells.columns.iter().map(|column| test.claim(black_box(column)).present_below).collect())
}

/// The answers must equal those of the independent engine, and the closed forms must be lower bounds.
fn check(name: &str, cells: &Cells, answers: &[f64]) {
    let roots =
        || critical_dampings(&cells.columns, 1e-13).into_iter().map(|root| root.map_or(f64::NAN, |r| r.c));
    match name {
        "direct" => {
            for (point, margin) in cells.points.iter().zip(answers) {
                let exact = witness::flow(&Oscillator::new(&Law::Stribeck, point), 1e-12).margin;
                // The direct engine gives no margin to an orbit that runs far past the belt line.
                let right =
                    if exact.is_nan() { !(*margin <= 0.1) } else { (margin - exact).abs() <= TOLERANCE };
                assert!(right, "{name}: {point:?}: {margin} not {exact}");
            }
        }
        "critical_damping" => {
            for (root, answer) in roots().zip(answers) {
                // The tolerance is relative to A and b, and c* is their order divided by eps.
                assert!((answer - root).abs() <= 5.0 * TOLERANCE / 0.05, "{name}: {answer} not {root}");
            }
        }
        _ => {
            for (root, answer) in roots().zip(answers) {
                assert!(*answer <= root + 1e-9, "{name}: {answer} above {root}");
            }
        }
    }
}

fn run(arguments: &[String]) -> Result<(), String> {
    let usage = "limits peaks | limits time KERNEL N | limits count KERNEL N PASSES";
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    // Cargo runs benches with the flag --bench.
    let (passes, name, count) = match words[..] {
        ["peaks"] => {
            println!("{:e} {:e}", peak(true), peak(false));
            return Ok(());
        }
        ["time", name, count] => (None, name, count),
        ["count", name, count, passes] => (Some(passes.parse::<u32>().map_err(|_| usage)?), name, count),
        _ => return Err(usage.into()),
    };
    let kernel = KERNELS.iter().find(|(other, _)| *other == name).ok_or("no such kernel")?.1;
    let count: usize = count.parse().map_err(|_| usage)?;
    let all = cells(count);
    // Tables are computed on first use, with the first cells.
    let few = cells(count.min(256));
    check(name, &few, &kernel(&few).1);
    if let Some(passes) = passes {
        for _ in 0..passes {
            black_box(kernel(black_box(&all)));
        }
        return Ok(());
    }
    let mut best = f64::INFINITY;
    let mut rhs = 0;
    for _ in 0..15 {
        let start = thread_time();
        rhs = black_box(kernel(black_box(&all))).0;
        best = best.min((thread_time() - start).as_secs_f64());
    }
    println!("{best:e} {rhs}");
    Ok(())
}

fn main() -> ExitCode {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    arguments.retain(|argument| argument != "--bench");
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::from(2)
        }
    }
}
