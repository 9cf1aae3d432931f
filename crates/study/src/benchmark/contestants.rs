//! The methods and engines that are compared, each at several settings of its main parameter.

use slipmap_certify::{TESTS, Test, curve};
use slipmap_column::Verdict;
use slipmap_column::critical::critical_dampings;
use slipmap_model::filippov::Oscillator;
use slipmap_model::friction::Column;
use slipmap_numbers::named;
use slipmap_orbits::naive::{NaiveKnobs, NaiveMethod};

use super::cells::Cell;

named! {
    /// Kind of a contestant, with its name in tables.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum ContestantKind {
        /// A closed-form test.
        ClosedForm => "closed form",
        /// An engine of this program.
        Engine => "engine",
        /// A simulation as commonly written.
        Naive => "naive",
        /// Another program.
        Peer => "peer",
    }
}

/// The answer about a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Answer {
    pub(crate) verdict: Verdict,
    /// The scaled grazing margin, if it is computed.
    pub(crate) margin: Option<f64>,
    /// The critical damping of the cell's column, if it is computed.
    pub critical: Option<f64>,
}

/// The function that computes a contestant's answers.
#[derive(Clone, Copy, Debug)]
pub(super) enum Solver {
    /// A closed-form test, cell by cell.
    Test(&'static Test),
    /// An engine, cell by cell, at a setting.
    Each(fn(&Cell, f64) -> Answer),
    /// An engine that takes all cells in one call and vectorises over them.
    Batch(fn(&[Cell], f64) -> Vec<Answer>),
    /// A naive method, cell by cell: verdicts only; its critical damping is found by bisection.
    Naive(NaiveMethod, NaiveKnobs),
}

/// The numbers that a contestant computes besides verdicts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Output {
    Margins,
    CriticalDampings,
    Nothing,
}

/// A method at one setting of its parameter.
#[derive(Clone, Copy, Debug)]
pub struct Contestant {
    /// The method or engine.
    pub name: &'static str,
    pub kind: ContestantKind,
    /// Name of its parameter; `None` for a method without one.
    pub(crate) knob: Option<&'static str>,
    pub setting: f64,
    pub(super) solver: Solver,
    pub(super) output: Output,
}

/// Compares `c` with a critical damping and its error.
fn compare(c: f64, critical: Option<(f64, f64)>) -> Answer {
    let verdict = match critical {
        Some((critical, error)) if c < critical - error => Verdict::Present,
        Some((critical, error)) if c > critical + error => Verdict::Absent,
        Some(_) => Verdict::Undecided,
        None => Verdict::Failed,
    };
    Answer { verdict, margin: None, critical: critical.map(|(critical, _)| critical) }
}

#[inline]
pub(super) fn closed_form(test: &Test, cell: &Cell) -> Answer {
    let claim = test.claim(&cell.column);
    let verdict = Verdict::from(claim.decide(cell.point.damping));
    Answer { verdict, margin: None, critical: Some(claim.present_below) }
}

/// The middle of the proved enclosure.
fn validated(cell: &Cell, _: f64) -> Answer {
    let range = curve::prove(&cell.column).critical();
    let is_known = range.lo.is_finite() && range.hi.is_finite();
    compare(
        cell.point.damping,
        is_known.then_some((0.5 * (range.lo + range.hi), 0.5 * (range.hi - range.lo))),
    )
}

fn critical_damping(cells: &[Cell], tolerance: f64) -> Vec<Answer> {
    let columns: Vec<Column> = cells.iter().map(|cell| cell.column.clone()).collect();
    let roots = critical_dampings(&columns, tolerance).into_iter().zip(cells);
    roots
        .map(|(root, cell)| compare(cell.point.damping, root.ok().map(|root| (root.c, root.error))))
        .collect()
}

fn direct(cell: &Cell, tolerance: f64) -> Answer {
    let flow = slipmap_witness::flow(&Oscillator::in_column(&cell.column, cell.point.damping), tolerance);
    let margin = Some(flow.margin).filter(|margin| margin.is_finite());
    Answer { verdict: Verdict::from(&flow.fate), margin, critical: None }
}

/// As a map of one cell decides it.
fn simulation(cell: &Cell, tolerance: f64) -> Answer {
    let columns = std::slice::from_ref(&cell.column);
    let verdicts = slipmap_map::decide(columns, &[cell.point.damping], tolerance);
    Answer { verdict: verdicts[0], margin: None, critical: None }
}

/// All contestants, each method with its settings from coarse to fine.
///
/// The parameters: `tolerance` for engines (the requested error of the margin; for `critical_damping`
/// relative to the divergence) and for `event_step` (the error per step), `smoothing_width` for `smoothed`,
/// `stick_band_width` for `stick_band`, `step` for `fixed_step`. All other parameters of the naive methods
/// have their default values.
#[must_use]
pub fn contestants() -> Vec<Contestant> {
    let fixed =
        |name, kind, solver, output| Contestant { name, kind, knob: None, setting: f64::NAN, solver, output };
    let test = |test: &'static Test| {
        fixed(test.name, ContestantKind::ClosedForm, Solver::Test(test), Output::CriticalDampings)
    };
    let mut all: Vec<Contestant> = TESTS.iter().map(test).collect();
    all.push(fixed("validated", ContestantKind::Engine, Solver::Each(validated), Output::CriticalDampings));
    let engines = [
        ("critical_damping", Solver::Batch(critical_damping), Output::CriticalDampings),
        ("simulation", Solver::Each(simulation), Output::Nothing),
        ("direct", Solver::Each(direct), Output::Margins),
    ];
    for (name, solver, output) in engines {
        for setting in [1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14] {
            let knob = Some("tolerance");
            all.push(Contestant { knob, setting, ..fixed(name, ContestantKind::Engine, solver, output) });
        }
    }
    for method in NaiveMethod::ALL {
        let (knob, settings): (_, &[f64]) = match method {
            NaiveMethod::Smoothed => ("smoothing_width", &[1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 1e-4]),
            NaiveMethod::StickBand => ("stick_band_width", &[1e-1, 1e-2, 1e-3, 1e-4, 1e-5]),
            NaiveMethod::FixedStep => ("step", &[1e-1, 3e-2, 1e-2, 3e-3, 1e-3]),
            NaiveMethod::EventStep => ("tolerance", &[1e-3, 1e-5, 1e-7, 1e-9, 1e-11]),
        };
        for &setting in settings {
            let knobs = NaiveKnobs::default();
            let knobs = match method {
                NaiveMethod::Smoothed => NaiveKnobs { smoothing_width: setting, ..knobs },
                NaiveMethod::StickBand => NaiveKnobs { stick_band_width: setting, ..knobs },
                NaiveMethod::FixedStep => NaiveKnobs { step: setting, ..knobs },
                NaiveMethod::EventStep => NaiveKnobs { tolerance: setting, ..knobs },
            };
            let solver = Solver::Naive(method, knobs);
            let one = fixed(method.name(), ContestantKind::Naive, solver, Output::Nothing);
            all.push(Contestant { knob: Some(knob), setting, ..one });
        }
    }
    all
}
