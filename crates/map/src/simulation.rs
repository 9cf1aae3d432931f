//! The method `simulation` on the columns of a tile.
//!
//! Along a column every orbit shrinks as c grows (the right-hand side of the scalar form increases with the
//! divergence), so the fates occur in a fixed order: crosses for ever, sticks, spirals inward. One root, or
//! two bisections, label a column of any length. Between neighbouring columns critical dampings are
//! interpolated, see [`super::interpolation`].

use std::ops::Range;

use super::interpolation::Interpolated;
use super::{Engine, Runs};
use slipmap_certify::{Claim, Columns, Dampings, Decision, landing};
use slipmap_column::critical::critical_dampings;
use slipmap_column::{CriticalDamping, End, NoCriticalDamping, Verdict};
use slipmap_model::filippov::Oscillator;
use slipmap_model::friction::Column;
use slipmap_numbers::named_sums;
use slipmap_orbits::far_loops::FarLoops;
use slipmap_orbits::flow;
use slipmap_orbits::margins::{Margins, margins};
use slipmap_orbits::return_map::{flow_after_turn, is_resolved};

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
        /// By their margin or their own orbit: the return map, or arcs where the map does not apply.
        pub(crate) return_map,
        /// By the direct engine, because the plan requests it.
        pub(crate) direct,
    }
}

/// The result of the simulation on the cells of a tile.
#[derive(Debug, Default)]
pub(super) struct Simulated {
    /// The end of each cell's orbit, column by column.
    pub(crate) ends: Runs<End>,
    /// Margins of the cells, if the engine computed them.
    pub(crate) margins: Option<Margins>,
    /// Critical damping of each column, where it was requested or computed to label cells.
    pub(crate) critical: Vec<Option<CriticalDamping>>,
    /// Number of columns in whose search for a requested critical damping an engine gave no answer.
    pub(crate) without_critical: u64,
    pub(crate) paths: Paths,
    pub(crate) rhs: u64,
}

impl Simulated {
    /// Computes the margins of all cells, and adds their work to `rhs`.
    pub(super) fn count_margins(
        &mut self,
        columns: &[Column],
        axes: &[Vec<f64>],
        cs: &[f64],
        tolerance: f64,
    ) -> Margins {
        let found = margins(columns, axes, cs, tolerance);
        self.rhs += found.rhs.iter().map(|&rhs| u64::from(rhs)).sum::<u64>();
        found
    }
}

/// Decides the cells of `columns` at the dampings `cs`; `known` holds the answers for interpolated columns.
/// `axes` are the coordinates of the grid that the columns form; empty if they form none.
pub(super) fn simulate(
    columns: &Columns,
    axes: &[Vec<f64>],
    cs: &[f64],
    engine: Engine,
    tolerance: f64,
    want_critical: bool,
    known: &Interpolated,
) -> Simulated {
    let mut done = Simulated { critical: vec![None; columns.len()], ..Simulated::default() };
    match engine {
        Engine::Direct => {
            for column in columns.iter() {
                for &c in cs {
                    let answer = slipmap_witness::decisive_flow(&Oscillator::in_column(column, c), tolerance);
                    done.rhs += answer.rhs;
                    done.ends.push(End::of(&answer), 1);
                }
            }
            done.paths.direct = done.ends.len() as u64;
        }
        Engine::ReturnMap => {
            let found = done.count_margins(columns, axes, cs, tolerance);
            let cells = cs.len().max(1);
            let of_columns = found.margins.chunks(cells).zip(found.errors.chunks(cells));
            for (column, (margins, errors)) in columns.iter().zip(of_columns) {
                return_map_column(column, cs, [margins, errors], tolerance, &mut done);
            }
            done.margins = Some(found);
        }
        Engine::CriticalSurface | Engine::Auto => {
            let first = if want_critical { tolerance } else { tolerance.max(ENOUGH_FOR_MOST) };
            by_column(columns, cs, engine, [first, tolerance], known, &mut done);
        }
    }
    if want_critical {
        complete_critical(columns, tolerance, &mut done);
    }
    done
}

/// Computes the critical dampings that were not needed to label the cells.
fn complete_critical(columns: &Columns, tolerance: f64, done: &mut Simulated) {
    let mut numbers = Vec::new();
    for (number, critical) in done.critical.iter().enumerate() {
        // Where the certificate excludes a cycle at every c >= 0 there is no critical damping.
        if critical.is_some() || columns.symmetric(number).absent_above < 0.0 {
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
pub fn decide(columns: &[Column], cs: &[f64], engine: Engine, tolerance: f64) -> Vec<Verdict> {
    simulate(&Columns::new(columns), &[], cs, engine, tolerance, false, &Interpolated::none())
        .ends
        .values()
        .map(End::verdict)
        .collect()
}

/// A tolerance of the critical damping that decides all cells of most columns.
const ENOUGH_FOR_MOST: f64 = 1e-6;

/// Decides every cell of a column by its margin, and by an orbit of its own where the margin leaves its sign
/// or the landing undecided.
fn return_map_column(
    column: &Column,
    cs: &[f64],
    [margins, errors]: [&[f64]; 2],
    tolerance: f64,
    done: &mut Simulated,
) {
    let lands = certainly_lands(column);
    for ((&c, &margin), &error) in cs.iter().zip(margins).zip(errors) {
        let known = match is_resolved(margin, error) {
            true if margin < -error => Some(End::Inward),
            true if margin > error && lands(c, margin + error) => Some(End::Sticks),
            _ => None,
        };
        let end = known.unwrap_or_else(|| {
            let answer = flow_after_turn(&Oscillator::in_column(column, c), margin, tolerance);
            done.rhs += answer.rhs;
            End::of(&answer)
        });
        done.ends.push(end, 1);
    }
    done.paths.return_map += cs.len() as u64;
}

/// A function of c and the margin m > 0 that returns whether the orbit certainly lands on the stick segment.
/// In the lower flow, continued beyond the landing, r grows while D > 0. So r <= V (1 + m) at the landing,
/// and wL^2 = r^2 - V^2 bounds the landing speed. At negative slip speeds D is that of the continuation; it
/// is at least D(0) if -phi' falls with the slip speed.
fn certainly_lands(column: &Column) -> impl Fn(f64, f64) -> bool {
    let (convex, at_rest) = (column.curve.weakening_is_convex(), column.curve.weakening(0.0));
    let (epsilon, belt_speed) = (column.epsilon, column.belt_speed);
    let fastest = 2.0 - column.curve.drop();
    move |c, margin| {
        convex && at_rest - epsilon * c > 0.0 && belt_speed * (margin * (2.0 + margin)).sqrt() < fastest
    }
}

/// The method by which the cells of a column are labelled.
enum Path {
    /// By interpolation, with the end of each cell.
    Interpolated(Vec<End>),
    /// By the certificate `symmetric`, which decides every cell: the verdicts in their order.
    Certificate([(Decision, usize); 4]),
    /// By a root search for the column's critical damping.
    Root(Claim),
}

/// Labels whole columns: by interpolation where it decides every cell; for `auto` by certificate where that
/// does; else by comparison with one root per column. A root's error is
/// about the first of the `tolerances`, or the second where a cell lies within the first error.
fn by_column(
    columns: &Columns,
    cs: &[f64],
    engine: Engine,
    tolerances: [f64; 2],
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
        match engine == Engine::Auto && is_decided {
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

/// The critical dampings of columns, to the first of the `tolerances`, or to the second where cells at the
/// dampings `cs` lie within the error of the first.
fn labelling_roots(
    columns: &[Column],
    cs: &[f64],
    [first, second]: [f64; 2],
) -> Vec<Result<CriticalDamping, NoCriticalDamping>> {
    let mut roots = critical_dampings(columns, first);
    if second < first {
        let settles = |root: &CriticalDamping| near(root, cs).is_empty();
        let open = (0..roots.len()).filter(|&number| !roots[number].as_ref().is_ok_and(settles));
        let open: Vec<usize> = open.collect();
        let again: Vec<Column> = open.iter().map(|&number| columns[number].clone()).collect();
        for (number, root) in open.into_iter().zip(critical_dampings(&again, second)) {
            let spent = roots[number].map_or(0, |root| root.rhs);
            roots[number] = root.map(|root| CriticalDamping { rhs: root.rhs + spent, ..root });
        }
    }
    roots
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
    // spiral inward. Cells between are within the error of the boundary: each gets an orbit of its own.
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
    for &c in &cs[returning..inward] {
        let answer = flow(&Oscillator::in_column(column, c), tolerance);
        done.rhs += answer.rhs;
        done.ends.push(End::of(&answer), 1);
    }
    done.ends.push(End::Inward, cs.len() - inward);
    done.paths.return_map += (inward - returning) as u64;
    (returning - sticking + cs.len() - inward) as u64
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
        done.paths.return_map += 1;
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
