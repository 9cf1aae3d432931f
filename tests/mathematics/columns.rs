//! The critical damping, and verdicts near it, of columns that are hard to solve: strong weakening, nodes,
//! large k.

use crate::reference::{CriticalPoint, column_points, other_column_points};
use crate::sample::returns;
use slipmap::certify::curve;
use slipmap::column::critical::critical_dampings;
use slipmap::column::{Regime, Verdict, regime};
use slipmap::filippov::Oscillator;
use slipmap::flow::{Failure, Fate, Flow};
use slipmap::friction::{Column, Law, Table};
use slipmap::map::decide;
use slipmap::orbits::flow;
use slipmap::witness;

/// Relative accuracy of the tables.
const TABLE: f64 = 1e-16;

fn columns(points: &[CriticalPoint]) -> Vec<Column> {
    points.iter().map(|point| Law::Stribeck.column(&point.at(0.0))).collect()
}

/// Results on a table of columns.
#[derive(Debug, Default)]
struct Found {
    /// Critical dampings, or verdicts.
    answers: usize,
    /// Number of answers that were withheld.
    withheld: usize,
    /// The answers that are wrong by more than their errors.
    wrong: Vec<String>,
}

impl Found {
    #[track_caller]
    fn is_right(&self, least: usize) {
        assert!(self.wrong.is_empty(), "{} wrong:\n{}", self.wrong.len(), self.wrong.join("\n"));
        assert!(self.answers >= least, "{} answers, {} withheld", self.answers, self.withheld);
    }
}

/// Compares c* and its error with the reference.
fn dampings(points: &[CriticalPoint], tolerance: f64) -> Found {
    let mut all = Found::default();
    for (point, found) in points.iter().zip(critical_dampings(&columns(points), tolerance)) {
        match found {
            Ok(found) => {
                all.answers += 1;
                let off = (found.c - point.critical_c).abs() - TABLE * point.critical_c;
                if off > found.error {
                    all.wrong.push(format!("{tolerance:e} {point:?}: {found:?} is off by {off:e}"));
                }
            }
            Err(_) => all.withheld += 1,
        }
    }
    all
}

/// Distances from c* in units of the weakening rate.
const STEPS: [f64; 7] = [1e-13, 1e-11, 1e-9, 1e-8, 1e-7, 1e-5, 1e-2];
/// Distances at which a coarse critical damping decides all cells of a column.
const FAR_STEPS: [f64; 2] = [1e-5, 1e-2];

/// The verdicts of a column.
type Decide = fn(&Column, &[f64], f64) -> Vec<Verdict>;

fn by_comparison(column: &Column, cs: &[f64], tolerance: f64) -> Vec<Verdict> {
    decide(std::slice::from_ref(column), cs, tolerance)
}

fn directly(column: &Column, cs: &[f64], tolerance: f64) -> Vec<Verdict> {
    let fate = |&c: &f64| witness::decisive_flow(&Oscillator::in_column(column, c), tolerance).fate;
    cs.iter().map(|c| Verdict::from(&fate(c))).collect()
}

fn by_orbits(column: &Column, cs: &[f64], tolerance: f64) -> Vec<Verdict> {
    cs.iter().map(|&c| Verdict::from(&flow(&Oscillator::in_column(column, c), tolerance).fate)).collect()
}

fn by_proof(column: &Column, cs: &[f64], _: f64) -> Vec<Verdict> {
    let claim = curve::prove(column).claim();
    cs.iter().map(|&c| claim.decide(c).into()).collect()
}

/// Compares verdicts at dampings on both sides of c*, from far to near, with the reference.
fn verdicts(points: &[CriticalPoint], decide: Decide, steps: &[f64], tolerance: f64) -> Found {
    let mut all = Found::default();
    for point in points {
        let column = Law::Stribeck.column(&point.at(0.0));
        let scale = point.gamma * (1.0 - point.alpha);
        let mut cs: Vec<f64> = steps
            .iter()
            .flat_map(|step| [point.critical_c - step * scale, point.critical_c + step * scale])
            .filter(|c| *c >= 0.0)
            .collect();
        cs.sort_by(f64::total_cmp);
        for (verdict, &c) in decide(&column, &cs, tolerance).into_iter().zip(&cs) {
            let right = match verdict {
                Verdict::Present => c < point.critical_c,
                // Below c* the orbit may cross the belt line for ever.
                Verdict::Absent => {
                    c > point.critical_c
                        || matches!(
                            witness::flow(&Oscillator::in_column(&column, c), 1e-12).fate,
                            Fate::CrossesForever | Fate::TooCloseToCall
                        )
                }
                Verdict::Undecided | Verdict::Failed | Verdict::NotComputed => {
                    all.withheld += 1;
                    continue;
                }
            };
            all.answers += 1;
            if !right {
                all.wrong.push(format!("{tolerance:e} {point:?} at {c:?}: {verdict:?}"));
            }
        }
    }
    all
}

#[test]
fn hard_critical_dampings_have_true_errors() {
    let all = column_points();
    let few: Vec<CriticalPoint> = all.iter().step_by(8).copied().collect();
    // All at the default tolerance.
    for (tolerance, points) in [(1e-6, &few), (1e-8, &few), (1e-9, &all), (1e-10, &few), (1e-13, &few)] {
        dampings(points, tolerance).is_right(99 * points.len() / 100);
    }
}

#[test]
fn verdicts_next_to_the_boundary_hold_where_it_is_hard_to_find() {
    let points = column_points();
    let every = |n: usize| points.iter().step_by(n).copied().collect::<Vec<_>>();
    let ways: [(Decide, &[f64], usize); 4] = [
        (by_comparison, &STEPS, 1),
        (by_comparison, &FAR_STEPS, 1),
        (by_orbits, &STEPS, 10),
        (directly, &STEPS, 100),
    ];
    // More at the default tolerance; all others in the ignored test below.
    for (tolerance, share) in [(1e-6, 16), (1e-9, 4), (1e-13, 16)] {
        for (decide, steps, few) in ways {
            let points = every(share * few);
            verdicts(&points, decide, steps, tolerance).is_right(points.len() * steps.len());
        }
    }
}

/// At c* the margin vanishes, so the margin that `direct` returns is its error. Steps that went past a steep
/// part of the law next to the belt line once missed it, by up to 78 times the stated error.
#[test]
fn margins_have_true_errors_where_laws_are_steep() {
    for tolerance in [1e-6, 1e-9, 1e-12] {
        for point in column_points() {
            let oscillator = Oscillator::new(&Law::Stribeck, &point.at(point.critical_c));
            let Flow { margin, margin_error, .. } = witness::flow(&oscillator, tolerance);
            // An orbit that runs far past the line has no margin; larger errors are not proportional to their
            // causes, and a verdict takes eight times them.
            let factor = if margin_error > 1e-4 { 8.0 } else { 1.0 };
            let wrong = margin.abs() > factor * margin_error;
            assert!(!wrong, "{tolerance:e} {point:?}: {margin:e} {margin_error:e}");
        }
    }
}

/// A cell that a map at default settings labelled absent, though it lies below c*: the error of c* was
/// underestimated.
#[test]
fn a_cell_just_below_the_critical_damping_is_present() {
    let point = CriticalPoint {
        epsilon: 0.9924807815966055,
        alpha: 0.19684561584687224,
        beta: 0.01809632782821418,
        gamma: 3.7719290304827346,
        belt_speed: 0.4295949795433118,
        critical_c: 0.606_171_800_598_076_2,
    };
    dampings(&[point], 1e-9).is_right(1);
    let column = Law::Stribeck.column(&point.at(0.0));
    for decide in [by_comparison, by_orbits, directly] {
        let verdicts = decide(&column, &[0.6, 0.606_171_75, 0.7], 1e-9);
        assert_eq!(verdicts, [Verdict::Present, Verdict::Present, Verdict::Absent]);
    }
}

/// A strong node whose turns the finest equal steps do not resolve: this cell was labelled absent.
#[test]
fn a_cell_next_to_the_boundary_of_a_strong_node_is_not_absent() {
    let point = Law::Stribeck.point(0.0733348, &[0.552363, 0.0, 486.682], 0.428924, 0.0).unwrap();
    let column = Law::Stribeck.column(&point);
    // c* is 3.515115118568438.
    for decide in [by_comparison, by_orbits, directly] {
        let verdict = decide(&column, &[3.5151151185466523], 1e-9)[0];
        assert!(matches!(verdict, Verdict::Present | Verdict::Undecided), "{verdict:?}");
    }
}

/// Where the equilibrium is stable at every damping, no certificate bounds the landing speed: on fast belts
/// the orbit crosses the belt line. Such cells were labelled present.
#[test]
fn fast_belts_without_a_certificate_are_not_present() {
    let lorentzian = |belt_speed: f64| {
        Law::Lorentzian.point(1.0, &[0.038_736_392_456_021_56, 5.568_060_014_426_585, 0.0], belt_speed, 0.0)
    };
    let stribeck =
        |belt_speed: f64| Law::Stribeck.point(1.0, &[0.0, 1e-4 / belt_speed, 0.5], belt_speed, 0.0);
    let mut crossing = 0;
    for belt_speed in [50.0, 100.0, 1e3, 1e5, 2e5, 341_783.448, 1e6] {
        for (law, point) in [(Law::Lorentzian, lorentzian(belt_speed)), (Law::Stribeck, stribeck(belt_speed))]
        {
            let column = law.column(&point.unwrap());
            let critical = critical_dampings(std::slice::from_ref(&column), 1e-9).remove(0).unwrap().c;
            let cs = [0.0, 0.3, 0.6, 0.9, 1.1].map(|share| share * critical);
            for decide in [by_comparison, by_orbits] {
                for (verdict, c) in decide(&column, &cs, 1e-9).into_iter().zip(cs) {
                    let witness = witness::flow(&Oscillator::in_column(&column, c), 1e-9);
                    let expected = match witness.fate {
                        Fate::Sticks(_) => Verdict::Present,
                        Fate::SpiralsInward | Fate::CrossesForever => Verdict::Absent,
                        Fate::TooCloseToCall | Fate::Failed(_) => continue,
                    };
                    crossing += usize::from(witness.fate == Fate::CrossesForever);
                    assert!([expected, Verdict::Undecided].contains(&verdict), "{column:?} {c}: {verdict:?}");
                }
            }
        }
    }
    assert!(crossing > 60, "{crossing}");
}

/// Measured friction that dips next to rest: bounds of the even part are far from the boundary, and at the
/// lower one orbits leave the table. Such columns had no critical damping and no regime.
#[test]
fn a_table_with_a_dip_next_to_rest_has_its_boundary() {
    for (dip, belt_speed) in [(0.93, 0.35), (0.9, 0.1)] {
        let data =
            [(0.0, 1.0), (0.006, dip), (0.008, 0.945), (0.03, 0.9), (0.2, 0.7), (1.0, 0.6), (3.0, 0.6)];
        let law = Law::Table(Table::new("dip", &data, 1.0).unwrap());
        let column = law.column(&law.point(1.0, &[], belt_speed, 0.0).unwrap());
        let found = critical_dampings(std::slice::from_ref(&column), 1e-9).remove(0);
        let found = found.unwrap_or_else(|problem| panic!("{dip} {belt_speed}: {problem}"));
        // A few errors away on either side the direct engine decides the fate, if c >= 0 there.
        for side in [-1.0, 1.0] {
            let c = found.c + side * (10.0 * found.error + 1e-6);
            let oscillator = Oscillator::in_column(&column, c);
            let fate = witness::flow(&oscillator, 1e-11).fate;
            let back = returns(&fate).unwrap_or_else(|| panic!("{dip} {belt_speed} {c}: {fate:?}"));
            assert!(c < 0.0 || back == (side < 0.0), "{dip} {belt_speed}: {found:?}, {c}");
        }
        for share in [0.5, 0.99, 1.01, 2.0] {
            let oscillator = Oscillator::in_column(&column, share * found.c.abs());
            let answer = flow(&oscillator, 1e-10);
            assert_ne!(regime(&oscillator, &answer), Regime::Failed, "{dip} {belt_speed} {share} {found:?}");
        }
    }
}

/// The undamped orbit leaves a table that ends early, so its fate is unknown; orbits near c* stay inside.
#[test]
fn a_table_that_ends_early_has_its_boundary() {
    let friction = [1.0, 0.93, 0.945, 0.9, 0.7, 0.65, 0.6, 0.6];
    let dip = [0.0, 0.006, 0.008, 0.03, 0.2, 0.4, 1.0, 3.0].into_iter().zip(friction).collect::<Vec<_>>();
    let c_of = |rows: usize, belt_speed: f64| {
        let law = Law::Table(Table::new("dip", &dip[..rows], 1.0).unwrap());
        let column = law.column(&law.point(1.0, &[], belt_speed, 0.0).unwrap());
        let undamped = witness::flow(&Oscillator::in_column(&column, 0.0), 1e-9).fate;
        (critical_dampings(std::slice::from_ref(&column), 1e-9).remove(0), undamped)
    };
    for belt_speed in [0.06, 0.07, 0.08] {
        let (whole, known) = c_of(8, belt_speed);
        let (short, unknown) = c_of(6, belt_speed);
        assert!(
            matches!(known, Fate::Sticks(_)) && unknown == Fate::Failed(Failure::NotFinite),
            "{unknown:?}"
        );
        let (whole, short) = (whole.unwrap(), short.unwrap());
        assert!((whole.c - short.c).abs() <= whole.error + short.error, "{whole:?} {short:?}");
    }
}

#[test]
fn proofs_hold_next_to_the_boundary() {
    let few: Vec<CriticalPoint> = column_points().into_iter().step_by(40).collect();
    verdicts(&few, by_proof, &STEPS, 0.0).is_right(6 * few.len());
}

#[test]
#[ignore = "minutes"]
fn proofs_hold_next_to_the_boundary_of_every_column() {
    let found = verdicts(&column_points(), by_proof, &STEPS, 0.0);
    println!("{} decided, {} withheld", found.answers, found.withheld);
    found.is_right(8000);
}

/// Ten thousand columns, written by `scripts/evidence/columns.c` to the file that SLIPMAP_COLUMNS names. Prints
/// results/columns-DATE.csv row by row.
#[test]
#[ignore = "an hour, with the table that scripts/evidence/columns.c writes, see results/README.md"]
fn ten_thousand_other_columns() {
    let points = other_column_points();
    let every = |n: usize| points.iter().step_by(n).copied().collect::<Vec<_>>();
    let mut wrong = Vec::new();
    let mut row = |what: &str, tolerance: f64, points: &[CriticalPoint], found: Found| {
        let Found { answers, withheld, wrong: these } = found;
        println!("{what},{tolerance:e},{},{answers},{withheld},{}", points.len(), these.len());
        wrong.extend(these);
    };
    println!("what,tolerance,columns,answers,withheld,wrong");
    for tolerance in [1e-6, 1e-8, 1e-9, 1e-10, 1e-13] {
        row("critical_damping", tolerance, &points, dampings(&points, tolerance));
    }
    let ways: [(&str, Decide, &[f64], usize); 4] = [
        ("verdicts", by_comparison, &STEPS, 1),
        ("verdicts_far", by_comparison, &FAR_STEPS, 4),
        ("verdicts_of_orbits", by_orbits, &STEPS, 20),
        ("verdicts_direct", directly, &STEPS, 200),
    ];
    for (what, decide, steps, few) in ways {
        let points = every(few);
        for tolerance in [1e-6, 1e-9, 1e-13] {
            row(what, tolerance, &points, verdicts(&points, decide, steps, tolerance));
        }
    }
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}
