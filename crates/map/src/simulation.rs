//! The method `simulation` on the columns of a tile.
//!
//! Along a column every orbit shrinks as c grows (the right-hand side of the scalar form increases with the
//! divergence), so the fates occur in a fixed order: crosses for ever, sticks, spirals inward. One root, or
//! two bisections, label a column of any length. Between neighbouring columns critical dampings are
//! interpolated, see [`super::interpolation`].

use std::ops::Range;

use super::Runs;
use super::interpolation::Interpolated;
use slipmap_certify::{Claim, Columns, Dampings, Decision, landing};
use slipmap_column::critical::critical_dampings;
use slipmap_column::{CriticalDamping, End, NoCriticalDamping, Verdict};
use slipmap_model::filippov::Oscillator;
use slipmap_model::friction::Column;
use slipmap_numbers::named_sums;
use slipmap_orbits::far_loops::FarLoops;
use slipmap_orbits::flow;

named_sums! {
    /// Number of cells that each path decided.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    #[derive(serde::Serialize, serde::Deserialize)]
    pub struct Paths of u64 {
        /// Columns decided whole by the certificate `symmetric`, never simulated.
        pub(crate) certificate,
        /// By comparison with a critical damping interpolated between columns of the same tile.
        pub interpolation,
        /// By comparison with the column's critical damping, solved for.
        pub(crate) critical_surface,
        /// By the order of fates, between two simulated cells of the column with equal fates.
        pub(crate) order,
        /// By an orbit of their own.
        pub(crate) orbit,
    }
}

/// The result of the simulation on the cells of a tile.
#[derive(Debug, Default)]
pub(super) struct Simulated {
    /// The end of each cell's orbit, column by column.
    pub(crate) ends: Runs<End>,
    /// Critical damping of each column, where it was wanted or computed to label cells.
    pub(crate) critical: Vec<Option<CriticalDamping>>,
    /// Number of columns in whose search for a requested critical damping an engine gave no answer.
    pub(crate) without_critical: u64,
    pub(crate) paths: Paths,
    pub(crate) rhs: u64,
}

/// Which critical dampings are wanted besides those that label cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wanted {
    /// None.
    None,
    /// Those at legal dampings.
    Legal,
    /// Those of all columns.
    All,
}

/// Decides the cells of `columns` at the dampings `cs`; `known` holds the answers for interpolated columns.
pub(super) fn simulate(
    columns: &Columns,
    cs: &[f64],
    tolerance: f64,
    wanted: Wanted,
    known: &Interpolated,
) -> Simulated {
    let mut done = Simulated { critical: vec![None; columns.len()], ..Simulated::default() };
    let first = if wanted == Wanted::None { tolerance.max(ENOUGH_FOR_MOST) } else { tolerance };
    by_column(columns, cs, [first, tolerance, tolerance.min(FINEST)], known, &mut done);
    if wanted != Wanted::None {
        complete_critical(columns, tolerance, wanted, &mut done);
    }
    done
}

/// Computes the critical dampings that were not needed to label the cells.
fn complete_critical(columns: &Columns, tolerance: f64, wanted: Wanted, done: &mut Simulated) {
    let mut numbers = Vec::new();
    for (number, critical) in done.critical.iter().enumerate() {
        // Where the certificate excludes a cycle at every c >= 0 there is no critical damping.
        let is_legal = || wanted == Wanted::All || columns.symmetric(number).absent_above >= 0.0;
        if critical.is_some() || !is_legal() {
            continue;
        }
        numbers.push(number);
    }
    let searched: Vec<Column> = numbers.iter().map(|&number| columns[number].clone()).collect();
    for (number, found) in numbers.into_iter().zip(critical_dampings(&searched, tolerance)) {
        match found {
            Ok(critical) => {
                done.rhs += critical.rhs;
                done.critical[number] = Some(critical);
            }
            Err(_) => done.without_critical += 1,
        }
    }
}

/// The verdicts of the method `simulation` on the cells of `columns` at the dampings `cs`, column by column.
#[must_use]
pub fn decide(columns: &[Column], cs: &[f64], tolerance: f64) -> Vec<Verdict> {
    simulate(&Columns::new(columns), cs, tolerance, Wanted::None, &Interpolated::none())
        .ends
        .values()
        .map(End::verdict)
        .collect()
}

/// A tolerance of the critical damping that decides all cells of most columns.
const ENOUGH_FOR_MOST: f64 = 1e-6;
/// The tolerance that decides cells within the error of the requested one.
const FINEST: f64 = 1e-13;
/// Error of eps c* below which no orbit knows more.
const SHARP: f64 = 1e-12;

/// The method by which the cells of a column are labelled.
enum Path {
    /// By interpolation, with the end of each cell.
    Interpolated(Vec<End>),
    /// By the certificate `symmetric`, which decides every cell: the verdicts in their order.
    Certificate([(Decision, usize); 4]),
    /// By a root search for the column's critical damping.
    Root(Claim),
}

/// Labels whole columns: by interpolation where it decides every cell; by certificate where that does; else by comparison with one root per column. A root's error is
/// about the first of the `tolerances`, or the second where a cell lies within the first error.
fn by_column(
    columns: &Columns,
    cs: &[f64],
    tolerances: [f64; 3],
    known: &Interpolated,
    done: &mut Simulated,
) {
    let tolerance = tolerances[1];
    let mut dampings = Dampings::new(cs);
    let path = |(number, column): (usize, &Column)| {
        let ends = cs.iter().map(|&c| known.end(number, column, c));
        if let Some(ends) = ends.collect::<Option<_>>() {
            return Path::Interpolated(ends);
        }
        let claim = columns.symmetric(number);
        let decisions = dampings.decide(&claim);
        let is_decided =
            decisions.iter().all(|&(decision, cells)| decision != Decision::Undecided || cells == 0);
        match is_decided {
            true => Path::Certificate(decisions),
            false => Path::Root(claim),
        }
    };
    let paths: Vec<Path> = columns.iter().enumerate().map(path).collect();
    let rooted = columns.iter().zip(&paths).filter(|(_, path)| matches!(path, Path::Root(_)));
    let rooted: Vec<Column> = rooted.map(|(column, _)| column.clone()).collect();
    let mut roots = labelling_roots(&rooted, cs, tolerances).into_iter();
    for (number, (column, path)) in columns.iter().zip(paths).enumerate() {
        match path {
            Path::Interpolated(ends) => {
                done.paths.interpolation += cs.len() as u64;
                done.ends.extend(ends);
            }
            Path::Certificate(decisions) => {
                done.paths.certificate += cs.len() as u64;
                for (decision, cells) in decisions {
                    let end = if decision == Decision::Present { End::Sticks } else { End::Inward };
                    done.ends.push(end, cells);
                }
            }
            Path::Root(claim) => match roots.next() {
                Some(Ok(critical)) => {
                    done.critical[number] = Some(critical);
                    done.paths.critical_surface +=
                        column_by_root(column, cs, &claim, critical, tolerance, done);
                }
                Some(Err(_)) | None => by_order(column, cs, tolerance, done),
            },
        }
    }
}

/// The critical dampings of columns, to the first of the `tolerances`, or to the next ones where cells at the
/// dampings `cs` lie within the error.
fn labelling_roots(
    columns: &[Column],
    cs: &[f64],
    [first, finer @ ..]: [f64; 3],
) -> Vec<Result<CriticalDamping, NoCriticalDamping>> {
    let mut roots = critical_dampings(columns, first);
    let mut last = first;
    for tolerance in finer.into_iter().filter(|tolerance| *tolerance < first) {
        let is_open = |number: &usize| match &roots[*number] {
            Ok(root) => !near(root, cs).is_empty() && !is_sharp(root, &columns[*number]),
            // It may be found with another tolerance, which is tried once.
            Err(_) => last == first,
        };
        let open: Vec<usize> = (0..roots.len()).filter(is_open).collect();
        let again: Vec<Column> = open.iter().map(|&number| columns[number].clone()).collect();
        for (number, root) in open.into_iter().zip(critical_dampings(&again, tolerance)) {
            roots[number] = match (roots[number], root) {
                (Ok(coarse), Ok(fine)) => Ok(CriticalDamping { rhs: coarse.rhs + fine.rhs, ..fine }),
                (coarse, fine) => fine.or(coarse),
            };
        }
        last = tolerance;
    }
    roots
}

/// Whether an orbit would know no more than a critical damping.
fn is_sharp(critical: &CriticalDamping, column: &Column) -> bool {
    critical.error * column.epsilon <= SHARP
}

/// Those of the dampings `cs` that lie within the error of a critical damping: all, if the error is not a number.
fn near(critical: &CriticalDamping, cs: &[f64]) -> Range<usize> {
    let CriticalDamping { c: critical, error, .. } = critical;
    cs.partition_point(|c| *c < critical - error)..cs.partition_point(|c| !(*c > critical + error))
}

/// Labels one column from its critical damping; returns the number of cells that comparison decided.
fn column_by_root(
    column: &Column,
    cs: &[f64],
    claim: &Claim,
    critical: CriticalDamping,
    tolerance: f64,
    done: &mut Simulated,
) -> u64 {
    done.rhs += critical.rhs;
    // Before `returning` orbits return, and stick or land beyond the stick segment; from `inward` on they
    // spiral inward. Cells between are within the error of the boundary: undecided where that is small, else each gets
    // an orbit of its own.
    let Range { start: returning, end: inward } = near(&critical, cs);
    // A certificate that claims presence nowhere has not computed `sticks_from`.
    let sticks_from = match claim.present_below > 0.0 {
        true => claim.sticks_from,
        false if returning > 0 => landing::sticks_from(column, critical.c - critical.error),
        false => 0.0,
    };
    let sticking = cs.partition_point(|&c| c < sticks_from).min(returning);
    let sticking = if sticking > 0 && none_crosses_for_ever(column) { 0 } else { sticking };
    by_order(column, &cs[..sticking], tolerance, done);
    done.ends.push(End::Sticks, returning - sticking);
    let followed = if is_sharp(&critical, column) { returning } else { inward };
    for &c in &cs[returning..followed] {
        let answer = flow(&Oscillator::in_column(column, c), tolerance);
        done.rhs += answer.rhs;
        done.ends.push(End::of(&answer), 1);
    }
    done.ends.push(End::TooClose, inward - followed);
    done.ends.push(End::Inward, cs.len() - inward);
    done.paths.orbit += (followed - returning) as u64;
    (returning - sticking + cs.len() - followed) as u64
}

/// Whether no orbit of a column crosses the belt line for ever, by the bounds of its friction (theory, "Any friction law").
fn none_crosses_for_ever(column: &Column) -> bool {
    let Column { curve, belt_speed, .. } = column;
    curve.is_proved_to_resist() && FarLoops::new(curve, *belt_speed).inward_from(0.0) == 0.0
}

/// Labels cells by the order of fates along the column: computes the orbits of the first and the last cell,
/// and bisects every interval between whose two cells the fates differ. Next to a cell whose fate is
/// undecided, cells are computed one by one.
fn by_order(column: &Column, cs: &[f64], tolerance: f64, done: &mut Simulated) {
    let mut orbit = |c: f64| {
        let answer = flow(&Oscillator::in_column(column, c), tolerance);
        done.rhs += answer.rhs;
        done.paths.orbit += 1;
        End::of(&answer)
    };
    let mut ends: Vec<Option<End>> = vec![None; cs.len()];
    let mut intervals = Vec::new();
    if let Some(last) = cs.len().checked_sub(1) {
        ends[0] = Some(orbit(cs[0]));
        if last > 0 {
            ends[last] = Some(orbit(cs[last]));
            intervals.push((0, last));
        }
    }
    while let Some((from, to)) = intervals.pop() {
        if to - from < 2 {
            continue;
        }
        let settled = |end: Option<End>| matches!(end, Some(End::Sticks | End::Inward | End::Crosses));
        if ends[from] == ends[to] && settled(ends[from]) {
            let end = ends[from];
            ends[from + 1..to].fill(end);
            done.paths.order += (to - from - 1) as u64;
        } else {
            let middle = from + (to - from) / 2;
            ends[middle] = Some(orbit(cs[middle]));
            intervals.extend([(from, middle), (middle, to)]);
        }
    }
    done.ends.extend(ends.into_iter().map(|end| end.unwrap_or(End::Failed)));
}
