//! The kernels, from the closed forms to the full flow, on the same random cells:
//!
//! ```text
//! cargo bench --bench kernels
//! ```
//! Every answer is checked before it is timed.

#![allow(clippy::expect_used)] // a bench whose answers are wrong stops

mod common;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use slipmap::certify::{self, TESTS};
use slipmap::filippov::Oscillator;
use slipmap::friction::Law;
use slipmap::simulate::critical::critical_dampings;
use slipmap::simulate::return_map::{Turn, turns};
use slipmap::simulate::{Fate, flow, surface};
use slipmap::witness;

use common::{TOLERANCE, columns, groups, points};

fn main() {
    divan::main();
}

const CELLS: usize = 4096;
const FEW: usize = 256;

/// A closed form: the claim of a whole column.
#[divan::bench(args = TESTS.iter().map(|test| test.name))]
fn closed_form(bencher: Bencher, name: &str) {
    let test = certify::by_name(name).expect("a test's own name");
    let columns = columns(&points(CELLS));
    let roots = critical_dampings(&columns, TOLERANCE);
    for (column, root) in columns.iter().zip(roots) {
        let (claim, root) = ((test.claim)(column), root.expect("a root in this box"));
        let theorem = test.guarantee == certify::Guarantee::FiniteEpsilon;
        assert!(!theorem || claim.present_below <= root.c + root.error, "{name} {column:?}");
        assert!(!theorem || claim.absent_above >= root.c - root.error, "{name} {column:?}");
    }
    bencher.counter(ItemsCount::new(CELLS)).bench(|| {
        for column in black_box(&columns) {
            black_box((test.claim)(column));
        }
    });
}

/// The margin of one orbit, by tolerance.
#[divan::bench(args = [1e-6, 1e-9, 1e-12])]
fn return_map(bencher: Bencher, tolerance: f64) {
    let points = points(CELLS);
    let groups = groups(&points);
    for (turn, point) in turns(&groups, tolerance).iter().zip(points.iter().take(FEW)) {
        let Turn::Complete { margin, .. } = *turn else { panic!("{point:?}: handed over") };
        let exact = witness::flow(&Oscillator::new(&Law::Stribeck, point), 1e-13);
        // The direct engine gives no margin to an orbit that runs far past the belt line.
        let right = if exact.margin.is_nan() {
            margin > 0.1
        } else {
            (margin - exact.margin).abs() <= tolerance + exact.margin_error
        };
        assert!(right, "{point:?}: {margin} {exact:?}");
    }
    bencher.counter(ItemsCount::new(CELLS)).bench(|| turns(black_box(&groups), tolerance));
}

/// The root of one column.
#[divan::bench(args = [1e-6, 1e-9, 1e-12])]
fn critical_damping(bencher: Bencher, tolerance: f64) {
    let columns = columns(&points(CELLS));
    let (loose, tight) = (critical_dampings(&columns, tolerance), critical_dampings(&columns, 1e-14));
    for (loose, tight) in loose.into_iter().zip(tight) {
        let (loose, tight) = (loose.expect("a root in this box"), tight.expect("a root in this box"));
        assert!((loose.c - tight.c).abs() <= loose.error + tight.error);
    }
    bencher.counter(ItemsCount::new(CELLS)).bench(|| critical_dampings(black_box(&columns), tolerance));
}

/// The same root from the table of all columns.
#[divan::bench]
fn universal_surface(bencher: Bencher) {
    let columns = columns(&points(CELLS));
    let known: Vec<_> = columns.iter().map(surface::critical_damping).collect();
    for (known, root) in known.iter().zip(critical_dampings(&columns, 1e-14)) {
        let root = root.expect("a root in this box");
        assert!(known.is_none_or(|known| (known.c - root.c).abs() <= known.error + root.error));
    }
    bencher.counter(ItemsCount::new(CELLS)).bench(|| {
        for column in black_box(&columns) {
            black_box(surface::critical_damping(column));
        }
    });
}

/// The fate of one orbit, landing included.
#[divan::bench]
fn fate(bencher: Bencher) {
    let oscillators: Vec<Oscillator> =
        points(FEW).iter().map(|point| Oscillator::new(&Law::Stribeck, point)).collect();
    for oscillator in &oscillators {
        let answers = [flow(oscillator, TOLERANCE), witness::flow(oscillator, TOLERANCE)];
        let sticks = answers.map(|answer| matches!(answer.fate, Fate::Sticks(_)));
        assert_eq!(sticks[0], sticks[1], "{oscillator:?}");
    }
    bencher.counter(ItemsCount::new(FEW)).bench(|| {
        for oscillator in black_box(&oscillators) {
            black_box(flow(oscillator, TOLERANCE));
        }
    });
}

/// The full flow in (v, w), with its events.
#[divan::bench(args = [1e-6, 1e-9, 1e-12])]
fn direct_flow(bencher: Bencher, tolerance: f64) {
    let oscillators: Vec<Oscillator> =
        points(FEW).iter().map(|point| Oscillator::new(&Law::Stribeck, point)).collect();
    for oscillator in &oscillators {
        let (loose, tight) = (witness::flow(oscillator, tolerance), witness::flow(oscillator, 1e-13));
        let apart = (loose.margin - tight.margin).abs() > loose.margin_error + tight.margin_error;
        assert!(!apart, "{oscillator:?}: {loose:?} {tight:?}");
    }
    bencher.counter(ItemsCount::new(FEW)).bench(|| {
        for oscillator in black_box(&oscillators) {
            black_box(witness::flow(oscillator, tolerance));
        }
    });
}
