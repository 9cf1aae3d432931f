//! Margins interpolated along columns and in grids, compared with single turns, and their work.

use slipmap::friction::{Column, Expression, Law, Table};
use slipmap::orbits::margins::{Margins, margins};
use slipmap::orbits::return_map::{Turn, turns_of};

/// Numbers in [0, 1) from a Weyl sequence: fills a box evenly and reproducibly.
fn spread(i: usize, axis: i32) -> f64 {
    // Powers of the inverse root of the generalised golden ratio in four dimensions.
    (0.5 + (i + 1) as f64 * 0.856_674_883_854_502_8_f64.powi(axis + 1)).fract()
}

/// Columns of Stribeck's law: alpha in [0, 1], beta in [0, 0.5], gamma in [0, 4], V in [0.2, 1.5].
fn stribeck(epsilon: f64, count: usize) -> Vec<Column> {
    let column = |i: usize| {
        let [alpha, beta, gamma, v] = std::array::from_fn(|axis| spread(i, axis as i32));
        let point = Law::Stribeck.point(epsilon, &[alpha, 0.5 * beta, 4.0 * gamma], 0.2 + 1.3 * v, 0.0);
        Law::Stribeck.column(&point.unwrap())
    };
    (0..count).map(column).collect()
}

/// Dampings from 0 to `most`.
fn axis(most: f64, cells: usize) -> Vec<f64> {
    (0..cells).map(|i| most * i as f64 / (cells - 1) as f64).collect()
}

/// Statistics of the margins of some columns.
#[derive(Debug, Default)]
struct Found {
    cells: usize,
    interpolated: usize,
    rhs: u64,
    rhs_of_single_turns: u64,
}

fn rhs(turn: &Turn) -> u64 {
    let (Turn::Complete { rhs, .. } | Turn::HandOver { rhs }) = turn;
    u64::from(*rhs)
}

/// The margin, its error and the evaluations of each cell, as a [`Turn`].
fn turns(found: &Margins) -> Vec<Turn> {
    let cells = found.margins.iter().zip(&found.errors).zip(&found.rhs);
    cells
        .map(|((&margin, &error), &rhs)| match margin.is_nan() {
            true => Turn::HandOver { rhs },
            false => Turn::Complete { margin, error, rhs },
        })
        .collect()
}

/// Compares margins of columns, each by itself, and their errors with single turns at tolerance `sharp`.
fn compare(columns: &[Column], cs: &[f64], tolerance: f64, sharp: f64) -> Found {
    compare_margins(&margins(columns, &[], cs, tolerance), columns, cs, tolerance, sharp)
}

fn compare_margins(margins: &Margins, columns: &[Column], cs: &[f64], tolerance: f64, sharp: f64) -> Found {
    let mut found = Found::default();
    for (column, turns) in columns.iter().zip(turns(margins).chunks(cs.len())) {
        let single = turns_of(column, cs, tolerance);
        for (((turn, exact), single), c) in turns.iter().zip(turns_of(column, cs, sharp)).zip(&single).zip(cs)
        {
            found.cells += 1;
            found.rhs += rhs(turn);
            found.rhs_of_single_turns += rhs(single);
            match (turn, exact) {
                (
                    Turn::Complete { margin, error, rhs: own },
                    Turn::Complete { margin: exact, error: blur, .. },
                ) => {
                    found.interpolated += usize::from(*own == 0);
                    let off = (margin - exact).abs();
                    assert!(off <= error + blur, "{tolerance:e} {column:?} {c}: {turn:?} is off by {off:e}");
                    assert!(*own > 0 || *error <= tolerance, "{tolerance:e} {column:?} {c}: {turn:?}");
                }
                (Turn::Complete { .. }, Turn::HandOver { .. }) => {}
                (Turn::HandOver { .. }, _) => {
                    assert!(matches!(single, Turn::HandOver { .. }), "{column:?} {c}")
                }
            }
        }
    }
    found
}

#[test]
fn interpolated_margins_are_within_their_error() {
    // From columns that six nodes describe to columns that no polynomial describes.
    for (epsilon, most, cells) in [
        (0.05, 1.0, 20),
        (0.02, 3.0, 20),
        (0.1, 3.0, 20),
        (0.1, 3.0, 64),
        (0.2, 3.0, 64),
        (0.5, 0.2, 20),
        (1.0, 0.1, 64),
        (1.0, 1.0, 64),
        (2.0, 0.1, 20),
    ] {
        for tolerance in [1e-6, 1e-9, 1e-12] {
            compare(&stribeck(epsilon, 60), &axis(most, cells), tolerance, 1e-15);
        }
    }
}

#[test]
fn margins_of_other_laws_are_within_their_error() {
    for law in [Law::Exponential, Law::Lorentzian] {
        let column = |i: usize| {
            let [mu, vs, eta, v] = std::array::from_fn(|axis| spread(i, axis as i32));
            let point = law.point(1.0, &[mu, 1.0 + 9.0 * vs, 0.02 * eta], 0.2 + 0.8 * v, 0.0);
            law.column(&point.unwrap())
        };
        let found = compare(&(0..30).map(column).collect::<Vec<_>>(), &axis(0.1, 20), 1e-9, 1e-13);
        assert!(3 * found.interpolated > found.cells, "{law:?} {found:?}");
    }
}

/// A grid of columns: the values along each axis, and all columns, the last axis fastest.
struct GridOfColumns {
    axes: Vec<Vec<f64>>,
    columns: Vec<Column>,
}

impl GridOfColumns {
    /// Of a law at this eps: its parameters, then the belt speed, in ranges with numbers of values.
    fn new(law: &Law, epsilon: f64, ranges: &[(f64, f64, usize)]) -> Self {
        // Steps that are not quite equal.
        let value = |(from, to, count): (f64, f64, usize), i: usize| {
            from + (to - from) * (i as f64 + 0.3 * spread(i, 0)) / count as f64
        };
        let axes: Vec<Vec<f64>> =
            ranges.iter().map(|&range| (0..range.2).map(|i| value(range, i)).collect()).collect();
        let mut points = vec![Vec::new()];
        for values in &axes {
            let with =
                |point: &Vec<f64>| values.iter().map(|&v| [&point[..], &[v]].concat()).collect::<Vec<_>>();
            points = points.iter().flat_map(with).collect();
        }
        let column = |point: &Vec<f64>| {
            let (belt_speed, parameters) = point.split_last().unwrap();
            law.column(&law.point(epsilon, parameters, *belt_speed, 0.0).unwrap())
        };
        Self { columns: points.iter().map(column).collect(), axes }
    }

    fn compare(&self, cs: &[f64], tolerance: f64, sharp: f64) -> Found {
        let margins = margins(&self.columns, &self.axes, cs, tolerance);
        compare_margins(&margins, &self.columns, cs, tolerance, sharp)
    }
}

#[test]
fn interpolated_margins_of_grids_are_within_their_error() {
    // From a grid that one polynomial describes to one in which none does.
    for (epsilon, slowest, widest, most, shares) in [
        (0.05, 0.2, 4.0, 1.0, [0.8, 0.75, 0.3]),
        (0.05, 0.02, 8.0, 1.0, [0.4, 0.35, 0.2]),
        (0.2, 0.2, 3.0, 1.5, [0.0; 3]),
    ] {
        let ranges = [(0.2, 0.4, 2), (0.1, 0.2, 3), (0.1, widest, 12), (slowest, 1.5, 14)];
        let grid = GridOfColumns::new(&Law::Stribeck, epsilon, &ranges);
        for (tolerance, share) in [1e-6, 1e-9, 1e-12].into_iter().zip(shares) {
            let found = grid.compare(&axis(most, 12), tolerance, 1e-15);
            let interpolated = found.interpolated as f64;
            assert!(interpolated >= share * found.cells as f64, "{epsilon} {widest} {tolerance:e} {found:?}");
        }
    }
}

#[test]
fn margins_of_grids_of_other_laws_are_within_their_error() {
    for law in [Law::Exponential, Law::Lorentzian] {
        let ranges = [(0.5, 0.7, 4), (3.0, 5.0, 5), (0.0, 0.02, 2), (0.4, 0.8, 8)];
        let found = GridOfColumns::new(&law, 1.0, &ranges).compare(&axis(0.1, 12), 1e-9, 1e-13);
        assert!(3 * found.interpolated > found.cells, "{law:?} {found:?}");
    }
}

/// Smooth formulas are interpolated; those with a narrow step or with |u|, which has a corner where orbits go
/// beyond the belt line, and tables are not.
#[test]
fn margins_of_grids_of_formulas_are_within_their_error() {
    let rows: Vec<(f64, f64)> =
        (0..20).map(|i| 0.25 * f64::from(i)).map(|u| (u, 0.5 + 0.5 * (-0.5 * u).exp())).collect();
    let formula = |text: &str| Law::Expression(Expression::new(text, 1.0).unwrap());
    for (law, is_smooth) in [
        (formula("mu + (1 - mu)*exp(-u/vs) + 0.001*u^2"), true),
        (formula("1 - 0.1*mu*tanh(u/vs) + 0.01*sin(2*u)"), true),
        // Between the nodes of an axis.
        (formula("mu + (1 - mu)*exp(-u/vs) - 0.1*exp(-((vs - 4.24)/0.04)^2)*(1 - exp(-u))"), true),
        (formula("mu + (1 - mu)*exp(-u/vs) + 0.01 - 0.01*tanh((u - 0.5)*1e4)/tanh(5e3) - 0.02*mu/mu"), false),
        (Law::Table(Table::new("rows", &rows, 1.0).unwrap()), false),
    ] {
        let of_law = match is_smooth {
            true => [(0.5, 0.7, 3), (3.0, 5.0, 24), (0.4, 0.8, 6)],
            // Their turns are slow.
            false => [(0.5, 0.7, 1), (3.0, 5.0, 2), (0.4, 0.8, 2)],
        };
        let ranges = if law.parameters().is_empty() { &of_law[2..] } else { &of_law[..] };
        let found = GridOfColumns::new(&law, 0.5, ranges).compare(
            &axis(0.1, if is_smooth { 12 } else { 5 }),
            1e-9,
            1e-12,
        );
        if is_smooth {
            assert!(3 * found.interpolated > found.cells, "{} {found:?}", law.definition());
        } else {
            assert_eq!(found.interpolated, 0, "{} {found:?}", law.definition());
        }
    }
}

/// A feature that a single value of an axis meets, and few of the cells that are compared.
#[test]
fn margins_are_not_interpolated_over_a_narrow_feature() {
    let (ranges, cs) = ([(3.0, 5.0, 48), (0.4, 0.8, 6)], axis(0.1, 12));
    let law = |at: f64| {
        let feature = format!("0.01*exp(-((vs - {at})/0.005)^2)*(1 - exp(-u))");
        Law::Expression(Expression::new(&format!("0.6 + 0.4*exp(-u/vs) - {feature}"), 1.0).unwrap())
    };
    let values = GridOfColumns::new(&law(4.0), 0.5, &ranges).axes[0].clone();
    for (i, &at) in values.iter().enumerate().skip(3).step_by(5) {
        let grid = GridOfColumns::new(&law(at), 0.5, &ranges);
        let all = margins(&grid.columns, &grid.axes, &cs, 1e-9);
        let interpolated = all.rhs.iter().filter(|rhs| **rhs == 0).count();
        assert!(3 * interpolated > all.rhs.len(), "{at} {interpolated}");
        let columns = i * ranges[1].2..(i + 1) * ranges[1].2;
        let cells = columns.start * cs.len()..columns.end * cs.len();
        let at_feature = Margins {
            margins: all.margins[cells.clone()].to_vec(),
            errors: all.errors[cells.clone()].to_vec(),
            rhs: all.rhs[cells].to_vec(),
        };
        compare_margins(&at_feature, &grid.columns[columns], &cs, 1e-9, 1e-12);
    }
}

/// Where the divergence is large, or the dampings are few or equal, every cell has its own turn.
#[test]
fn columns_that_no_polynomial_describes_are_not_interpolated() {
    for (columns, cs) in [
        (stribeck(20.0, 50), axis(0.1, 20)),
        (stribeck(0.05, 50), axis(100.0, 20)),
        (stribeck(0.05, 50), axis(1.0, 4)),
        (stribeck(0.05, 50), vec![0.5; 20]),
        (stribeck(0.05, 50), vec![f64::NAN; 20]),
    ] {
        let turns = turns(&margins(&columns, &[], &cs, 1e-9));
        let single: Vec<Turn> = columns.iter().flat_map(|column| turns_of(column, &cs, 1e-9)).collect();
        assert_eq!(format!("{turns:?}"), format!("{single:?}"));
    }
    assert_eq!(margins(&stribeck(0.05, 2), &[], &[], 1e-9), Margins::default());
}

#[test]
fn a_column_does_not_feel_its_neighbours() {
    let (columns, cs) = (stribeck(0.1, 60), axis(3.0, 20));
    let together = turns(&margins(&columns, &[], &cs, 1e-9));
    for (column, turns) in columns.iter().zip(together.chunks(cs.len())) {
        assert_eq!(self::turns(&margins(std::slice::from_ref(column), &[], &cs, 1e-9)), turns);
    }
}

/// Evaluations of the right-hand side per cell in the box for which speeds are stated: of single turns, of
/// columns each by itself, and of columns that form a grid.
#[test]
fn work_counter() {
    let found = compare(&stribeck(0.05, 1000), &axis(1.0, 20), 1e-9, 1e-12);
    assert_eq!((found.rhs_of_single_turns / 20_000, found.rhs / 20_000), (47, 18), "{found:?}");
    let ranges = [(0.4, 1.0, 1), (0.2, 0.4, 8), (0.0, 4.0, 16), (0.2, 1.5, 16)];
    let found = GridOfColumns::new(&Law::Stribeck, 0.05, &ranges).compare(&axis(1.0, 20), 1e-9, 1e-12);
    assert_eq!((found.rhs_of_single_turns / 40_960, found.rhs / 40_960), (43, 2), "{found:?}");
}
