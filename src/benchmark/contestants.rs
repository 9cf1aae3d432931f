//! Who takes part: each method and engine at each setting of its own knob.

use crate::certify::{TESTS, Test};
use crate::filippov::Oscillator;
use crate::friction::Column;
use crate::map::{self, Engine, Verdict};
use crate::point::ScaledGroups;
use crate::simulate::critical::critical_dampings;
use crate::simulate::naive::{NaiveKnobs, NaiveMethod};
use crate::simulate::return_map::{Turn, turns};
use crate::simulate::{Fate, Flow, direct, surface};

use super::cells::Cell;

/// What a contestant is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A closed-form test.
    ClosedForm,
    /// An engine of this program.
    Engine,
    /// A simulation as its users write it.
    Naive,
    /// Somebody else's program.
    Peer,
}

impl Kind {
    /// The word in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Kind::ClosedForm => "closed form",
            Kind::Engine => "engine",
            Kind::Naive => "naive",
            Kind::Peer => "peer",
        }
    }
}

/// What is said of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Answer {
    pub verdict: Verdict,
    /// The scaled grazing margin, from those who compute it.
    pub margin: Option<f64>,
    /// The critical damping of the cell's column, from those who compute it.
    pub critical: Option<f64>,
}

/// How a contestant answers.
#[derive(Clone, Copy, Debug)]
pub(super) enum Way {
    /// A closed-form test, cell by cell.
    Test(&'static Test),
    /// An engine, cell by cell, at a setting.
    Each(fn(&Cell, f64) -> Answer),
    /// An engine, all cells in one call, vectors of them side by side.
    Batch(fn(&[Cell], f64) -> Vec<Answer>),
    /// A naive method, cell by cell, verdicts alone; the critical damping has to be searched for.
    Naive(NaiveMethod, NaiveKnobs),
}

/// What a contestant says besides verdicts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Gives {
    Margins,
    CriticalDampings,
    Nothing,
}

/// A method at one setting of its knob.
#[derive(Clone, Copy, Debug)]
pub struct Contestant {
    /// The method or engine.
    pub name: &'static str,
    /// What it is.
    pub kind: Kind,
    /// Its knob; `None` for a method that has none.
    pub knob: Option<&'static str>,
    /// Where the knob stands.
    pub setting: f64,
    pub(super) way: Way,
    pub(super) gives: Gives,
}

fn verdict_of(flow: &Flow) -> Verdict {
    match flow.fate {
        Fate::Sticks(_) => Verdict::Present,
        Fate::SpiralsInward | Fate::CrossesForever => Verdict::Absent,
        Fate::TooCloseToCall => Verdict::Undecided,
        Fate::Failed(_) => Verdict::Failed,
    }
}

/// By comparison with a critical damping and its error.
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
    let claim = (test.claim)(&cell.column);
    let verdict = Verdict::from(claim.decide(cell.point.damping));
    Answer { verdict, margin: None, critical: Some(claim.present_below) }
}

fn universal_surface(cell: &Cell, _: f64) -> Answer {
    let critical = surface::critical_damping(&cell.column).map(|found| (found.c, found.error));
    compare(cell.point.damping, critical)
}

fn critical_surface(cells: &[Cell], tolerance: f64) -> Vec<Answer> {
    let columns: Vec<Column> = cells.iter().map(|cell| cell.column.clone()).collect();
    let roots = critical_dampings(&columns, tolerance).into_iter().zip(cells);
    roots
        .map(|(root, cell)| compare(cell.point.damping, root.ok().map(|root| (root.c, root.error))))
        .collect()
}

fn return_map(cells: &[Cell], tolerance: f64) -> Vec<Answer> {
    let groups: Vec<ScaledGroups> = cells.iter().filter_map(scaled).collect();
    if groups.len() < cells.len() {
        // The vectors are for the Stribeck law; for others there is no reference either.
        return vec![Answer { verdict: Verdict::Failed, margin: None, critical: None }; cells.len()];
    }
    let turns = turns(&groups, tolerance);
    turns
        .iter()
        .map(|turn| match *turn {
            Turn::Complete { margin, error, .. } => {
                let verdict = match () {
                    () if margin > error => Verdict::Present,
                    () if margin < -error => Verdict::Absent,
                    () => Verdict::Undecided,
                };
                Answer { verdict, margin: Some(margin), critical: None }
            }
            Turn::HandOver { .. } => Answer { verdict: Verdict::Failed, margin: None, critical: None },
        })
        .collect()
}

/// The groups of a cell of the Stribeck law.
fn scaled(cell: &Cell) -> Option<ScaledGroups> {
    let &[alpha, beta, gamma] = cell.point.law.as_slice() else { return None };
    let rate = cell.point.epsilon * gamma;
    Some(ScaledGroups {
        a: rate * (1.0 - alpha),
        k: rate * cell.point.belt_speed,
        b: cell.point.epsilon * beta * cell.point.belt_speed,
        c: cell.point.epsilon * cell.point.damping,
    })
}

fn direct(cell: &Cell, tolerance: f64) -> Answer {
    let flow = direct::flow(&Oscillator::in_column(&cell.column, cell.point.damping), tolerance);
    let margin = Some(flow.margin).filter(|margin| margin.is_finite());
    Answer { verdict: verdict_of(&flow), margin, critical: None }
}

fn auto(cell: &Cell, tolerance: f64) -> Answer {
    let columns = std::slice::from_ref(&cell.column);
    let verdicts = map::decide(columns, &[cell.point.damping], Engine::Auto, tolerance);
    Answer { verdict: verdicts[0], margin: None, critical: None }
}

/// Everyone, each method with its settings from coarse to fine.
///
/// The knobs: `tolerance` for engines (the error of the margin that is aimed at; for `critical_surface`
/// relative to the divergence) and for `event_step` (the error per step), `smoothing_width` for `smoothed`,
/// `stick_band_width` for `stick_band`, `step` for `fixed_step`. All other choices of the naive methods have
/// their default values.
#[must_use]
pub fn contestants() -> Vec<Contestant> {
    let fixed = |name, kind, way, gives| Contestant { name, kind, knob: None, setting: f64::NAN, way, gives };
    let test =
        |test: &'static Test| fixed(test.name, Kind::ClosedForm, Way::Test(test), Gives::CriticalDampings);
    let mut all: Vec<Contestant> = TESTS.iter().map(test).collect();
    let table = Way::Each(universal_surface);
    all.push(fixed("universal_surface", Kind::Engine, table, Gives::CriticalDampings));
    let engines = [
        ("critical_surface", Way::Batch(critical_surface), Gives::CriticalDampings),
        ("return_map", Way::Batch(return_map), Gives::Margins),
        ("auto", Way::Each(auto), Gives::Nothing),
        ("direct", Way::Each(direct), Gives::Margins),
    ];
    for (name, way, gives) in engines {
        for setting in [1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14] {
            let knob = Some("tolerance");
            all.push(Contestant { knob, setting, ..fixed(name, Kind::Engine, way, gives) });
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
            let way = Way::Naive(method, knobs);
            let one = fixed(method.name(), Kind::Naive, way, Gives::Nothing);
            all.push(Contestant { knob: Some(knob), setting, ..one });
        }
    }
    all
}
