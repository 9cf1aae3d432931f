//! Measures time and error of one contestant.

use std::hint::black_box;
use std::time::Duration;

use super::cells::Cell;
use super::contestants::{Answer, Contestant, ContestantKind, Output, Solver, closed_form};
use slipmap_column::Verdict;
use slipmap_map::clock::thread_time;
use slipmap_model::filippov::Oscillator;

/// Statistics of errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    pub count: usize,
    pub median: f64,
    /// The 95 % quantile.
    pub high: f64,
    pub worst: f64,
}

impl Errors {
    /// Computes the statistics; `None` if there are no errors.
    pub(crate) fn of(mut sizes: Vec<f64>) -> Option<Self> {
        sizes.sort_by(f64::total_cmp);
        let at = |q: f64| sizes[((q * sizes.len() as f64).ceil() as usize).max(1) - 1];
        let worst = *sizes.last()?;
        Some(Self { count: sizes.len(), median: at(0.5), high: at(0.95), worst })
    }
}

/// Numbers of wrong and missing verdicts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Labels {
    pub cells: usize,
    pub wrong: usize,
    /// Number of cells without a verdict: undecided or failed.
    pub none: usize,
}

impl Labels {
    fn add(&mut self, verdict: Verdict, truth: Verdict) {
        self.cells += 1;
        match verdict {
            Verdict::Present | Verdict::Absent => self.wrong += usize::from(verdict != truth),
            Verdict::Undecided | Verdict::Failed | Verdict::NotComputed => self.none += 1,
        }
    }

    /// Share of cells without the right verdict.
    pub fn missed(&self) -> Option<f64> {
        (self.cells > 0).then(|| (self.wrong + self.none) as f64 / self.cells as f64)
    }

    /// Share of cells with the wrong verdict.
    pub fn mistaken(&self) -> Option<f64> {
        (self.cells > 0).then(|| self.wrong as f64 / self.cells as f64)
    }
}

/// The measurements of one contestant at one setting.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    pub kind: ContestantKind,
    pub name: String,
    /// Name and value of its parameter.
    pub setting: Option<(String, f64)>,
    /// Number of cells that it answered: all, or as many as its time allowed.
    pub cells: usize,
    /// Processor time per cell in seconds.
    pub seconds: f64,
    /// Error of the scaled grazing margin; for methods without one, that of the critical damping, converted.
    pub margin: Option<Errors>,
    /// Error of the critical damping; for methods without one, the converted error of the margin.
    pub critical: Option<Errors>,
    /// Number of cells without an answer although there is a margin or critical damping.
    pub unanswered: usize,
    /// Verdicts near the boundary; `None` if no such cell was measured.
    pub near: Option<Labels>,
    /// Verdicts anywhere.
    pub anywhere: Option<Labels>,
    /// Whether it is on the Pareto front of time and largest error.
    pub front_error: bool,
    /// Whether it is on the Pareto front of time and share of cells without the right verdict.
    pub front_labels: bool,
}

/// Least number of cells measured, even for slow contestants.
const LEAST_CELLS: usize = 4;
/// Least duration of a timed pass, reached by repetition: a thousand ticks of the clock.
const LONG_ENOUGH: Duration = Duration::from_micros(500);
/// Number of passes; the fastest counts.
const PASSES: usize = 5;

/// Measures a contestant on `cells`, or on as many of the first of them as take about `seconds`.
pub(crate) fn measure(contestant: &Contestant, cells: &[Cell], seconds: f64) -> Row {
    let budget = Duration::from_secs_f64(seconds);
    let (count, time, answers) = match contestant.solver {
        Solver::Batch(decide) => timed(cells, cells.len(), budget, |cells| decide(cells, contestant.setting)),
        Solver::Each(decide) => one_by_one(cells, budget, |cell| decide(cell, contestant.setting)),
        Solver::Test(test) => one_by_one(cells, budget, |cell| closed_form(test, cell)),
        Solver::Naive(method, knobs) => one_by_one(cells, budget, |cell| {
            let oscillator = Oscillator::in_column(&cell.column, cell.point.damping);
            let verdict = method.decide(&oscillator, &knobs).verdict.into();
            Answer { verdict, margin: None, critical: None }
        }),
    };
    let (mut near, mut anywhere, mut unanswered) = (Labels::default(), Labels::default(), 0);
    let mut errors = Sizes::default();
    for (answer, cell) in answers.iter().zip(cells) {
        let labels = if cell.near { &mut near } else { &mut anywhere };
        labels.add(answer.verdict, cell.verdict);
        unanswered += usize::from(!errors.add(contestant.output, answer, cell));
    }
    if let Solver::Naive(method, knobs) = contestant.solver {
        let decide = |cell: &Cell, c: f64| {
            method.decide(&Oscillator::in_column(&cell.column, c), &knobs).verdict.into()
        };
        search(cells, budget, decide, &mut errors);
    }
    Row {
        kind: contestant.kind,
        name: contestant.name.into(),
        setting: contestant.knob.map(|knob| (knob.into(), contestant.setting)),
        cells: count,
        seconds: time / count.max(1) as f64,
        margin: Errors::of(errors.margin),
        critical: Errors::of(errors.critical),
        unanswered,
        near: Some(near),
        anywhere: Some(anywhere),
        front_error: false,
        front_labels: false,
    }
}

/// Times the answers cell by cell, for as many cells as `budget` allows.
fn one_by_one(
    cells: &[Cell],
    budget: Duration,
    decide: impl Fn(&Cell) -> Answer,
) -> (usize, f64, Vec<Answer>) {
    // Warm up: tables are computed on first use.
    if let Some(first) = cells.first() {
        black_box(decide(first));
    }
    let start = thread_time();
    let late = |(i, cell): (usize, &Cell)| {
        black_box(decide(cell));
        i + 1 >= LEAST_CELLS && thread_time() - start > budget
    };
    let affordable = cells.iter().enumerate().position(late).map_or(cells.len(), |last| last + 1);
    timed(cells, affordable, budget, |cells| cells.iter().map(&decide).collect())
}

/// Times the first `count` cells; returns their answers too.
fn timed(
    cells: &[Cell],
    count: usize,
    budget: Duration,
    mut decide: impl FnMut(&[Cell]) -> Vec<Answer>,
) -> (usize, f64, Vec<Answer>) {
    let cells = &cells[..count];
    let start = thread_time();
    let mut answers = black_box(decide(cells));
    let once = thread_time() - start;
    let repeats = (LONG_ENOUGH.as_secs_f64() / once.as_secs_f64().max(1e-9)).ceil().max(1.0) as u32;
    let mut least = once;
    for _ in 1..PASSES {
        let begin = thread_time();
        if begin - start > budget {
            break;
        }
        for _ in 0..repeats {
            answers = black_box(decide(black_box(cells)));
        }
        least = least.min((thread_time() - begin) / repeats);
    }
    (count, least.as_secs_f64(), answers)
}

/// Errors as margins and as dampings.
#[derive(Default)]
struct Sizes {
    margin: Vec<f64>,
    critical: Vec<f64>,
}

impl Sizes {
    /// Adds the error of an answer; returns false if the answer lacks a number that exists.
    fn add(&mut self, output: Output, answer: &Answer, cell: &Cell) -> bool {
        let reference = &cell.reference;
        if let (Some(margin), Some(exact)) = (answer.margin, &reference.margin) {
            let error = exact.distance(margin);
            self.margin.push(error);
            self.critical.extend(reference.slope.map(|slope| error / slope));
            return true;
        }
        let (Some(exact), Some(slope)) = (&reference.critical, reference.slope) else {
            // A column without a boundary has only a margin.
            return output != Output::Margins;
        };
        match answer.critical.filter(|critical| critical.is_finite()) {
            Some(critical) => {
                self.add_damping(exact.distance(critical), slope);
                true
            }
            None => output == Output::Nothing,
        }
    }

    fn add_damping(&mut self, error: f64, slope: f64) {
        self.critical.push(error);
        self.margin.push(error * slope);
    }
}

/// Smallest and largest distance from the critical damping in the search for a boundary.
const NEAREST: f64 = 1e-9;
const FARTHEST: f64 = 4.0;

/// Searches the damping at which the verdicts of a method change, in the columns of the cells near the
/// boundary, as many as `budget` allows. Where they do not change between c = 0 and [`FARTHEST`] above the
/// critical damping, the distance searched counts as the error; the true error is larger.
fn search(cells: &[Cell], budget: Duration, decide: impl Fn(&Cell, f64) -> Verdict, errors: &mut Sizes) {
    let start = thread_time();
    for (number, cell) in cells.iter().filter(|cell| cell.near).enumerate() {
        if number >= LEAST_CELLS / 2 && thread_time() - start > budget {
            break;
        }
        let (Some(exact), Some(slope)) = (&cell.reference.critical, cell.reference.slope) else { continue };
        let critical = exact.value.value();
        let present = |offset: f64| decide(cell, critical + offset) == Verdict::Present;
        // Presence at c* means a boundary above it. The distance is multiplied until the verdict changes,
        // then halved in ratio until it is known to 5 %.
        let above = present(0.0);
        let side = if above { 1.0 } else { -1.0 };
        let farthest = if above { FARTHEST } else { critical };
        let (mut inner, mut outer) = (0.0, NEAREST);
        while outer < farthest && present(side * outer) == above {
            (inner, outer) = (outer, 8.0 * outer);
        }
        outer = outer.min(farthest);
        if outer < farthest || present(side * outer) != above {
            while outer > 1.05 * inner && outer > NEAREST {
                let middle = if inner == 0.0 { 0.5 * outer } else { (inner * outer).sqrt() };
                if present(side * middle) == above {
                    inner = middle;
                } else {
                    outer = middle;
                }
            }
        }
        errors.add_damping(outer, slope);
    }
}
