//! The direct engine asked for a second opinion: one comparison for points and for the audit of maps.

use std::cell::OnceCell;

use slipmap_column::Verdict;
use slipmap_model::filippov::Oscillator;
use slipmap_model::flow::Flow;

/// What the direct engine says of a verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Opinion {
    /// It says the same.
    Agrees,
    /// Within its error it does not decide.
    WithinMargin,
    /// It says otherwise.
    Contradicts,
    /// It does not know.
    None,
}

/// The direct engine as a second opinion on an orbit from the exit point.
pub struct Witness<'a> {
    oscillator: &'a Oscillator,
    tolerance: f64,
    first: Flow,
    second: OnceCell<Flow>,
}

impl<'a> Witness<'a> {
    /// Its flow with this tolerance.
    pub fn of(oscillator: &'a Oscillator, tolerance: f64) -> Self {
        let first = slipmap_witness::flow(oscillator, tolerance);
        Self { oscillator, tolerance, first, second: OnceCell::new() }
    }

    /// What it says of a decision, and the flow by which it does.
    pub fn asked_about(&self, stored: Verdict) -> (&Flow, Opinion) {
        let mut direct = &self.first;
        if stored.is_decision() && contradicts(direct, stored) {
            direct =
                self.second.get_or_init(|| slipmap_witness::flow(self.oscillator, finer(self.tolerance)));
        }
        let opinion = match Verdict::from(&direct.fate) {
            Verdict::Failed | Verdict::NotComputed => Opinion::None,
            Verdict::Undecided => Opinion::WithinMargin,
            found if found == stored => Opinion::Agrees,
            Verdict::Present | Verdict::Absent => {
                match direct.margin.abs() <= direct.margin_error + self.tolerance {
                    true => Opinion::WithinMargin,
                    false => Opinion::Contradicts,
                }
            }
        };
        (direct, opinion)
    }
}

/// Whether a flow decides, and its verdict differs from the stored one.
fn contradicts(flow: &Flow, stored: Verdict) -> bool {
    let found = Verdict::from(&flow.fate);
    found.is_decision() && found != stored
}

/// The tolerance of the second computation.
fn finer(tolerance: f64) -> f64 {
    (1e-3 * tolerance).max(slipmap_witness::FINEST).min(tolerance)
}
