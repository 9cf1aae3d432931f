//! The budget of work of one computation of cycles.
//!
//! A computation of cycles needs many orbits, some of which may be stiff. All of them share one budget, so
//! that the computation ends even if they are. A part that exceeds the budget fails with
//! [`Failure::StepBudget`].

use std::cell::Cell;

use slipmap_model::flow::Failure;
use slipmap_model::friction::Curve;

/// Largest number of evaluations of the right-hand side of the Stribeck law, see [`Curve::cost`]: half a
/// second of one orbit. The backbones and cycles of moderate parameters take a tenth of it.
pub const QUESTION: u64 = 7_000_000;

/// Largest number of evaluations for the fate of one orbit, in the same unit. A turn takes about 20 to 200
/// steps of a dozen; that of a formula which oscillates on a fast belt takes up to some ten thousand. An
/// expensive law has at least [`FEWEST`] evaluations of its own.
const ORBIT: u64 = 4_000_000;
const FEWEST: u64 = 60_000;

/// The rest of a budget.
#[derive(Debug, Default)]
pub struct Work {
    left: Cell<u64>,
    /// Evaluations so far, of the law itself or of its compiled form.
    done: Cell<u64>,
    /// Evaluations of the Stribeck law that the budget was asked for.
    spent: Cell<u64>,
    /// Cost of an evaluation of the law itself.
    cost: u64,
    /// Whether an optional part has failed.
    gave_up: Cell<bool>,
}

impl Work {
    /// The whole budget for oscillators with this law.
    pub fn of_question(curve: &Curve) -> Self {
        Self { left: Cell::new(QUESTION), cost: curve.cost(), ..Self::default() }
    }

    /// The whole budget for one orbit.
    pub fn of_orbit(curve: &Curve) -> Self {
        let work = Self::of_question(curve);
        work.left.set(ORBIT.max(FEWEST * work.cost));
        work
    }

    /// Notes evaluations, whether or not the budget holds them.
    pub fn count(&self, evaluations: u64) {
        self.done.set(self.done.get() + evaluations);
    }

    /// All evaluations so far.
    pub fn done(&self) -> u64 {
        self.done.get()
    }

    /// What the budget was asked for so far, in evaluations of the Stribeck law.
    pub fn spent(&self) -> u64 {
        self.spent.get()
    }

    /// Ends the work: nothing is left of the budget.
    pub fn end(&self) {
        self.left.set(0);
    }

    /// Makes the budget whole again, for a second attempt.
    pub fn renew(&self) {
        self.left.set(QUESTION);
    }

    /// Tries what the work can do without, with half of the rest, and not again once that has failed.
    pub fn optional<T>(&self, part: impl FnOnce() -> Result<T, Failure>) -> Option<T> {
        if self.gave_up.get() {
            return None;
        }
        let kept = self.left.get() / 2;
        self.left.set(self.left.get() - kept);
        let done = part().ok();
        self.left.set(self.left.get() + kept);
        self.gave_up.set(done.is_none());
        done
    }

    /// Subtracts evaluations of the law itself from the budget.
    ///
    /// # Errors
    /// [`Failure::StepBudget`] if it does not hold them.
    pub fn spend(&self, evaluations: u64) -> Result<(), Failure> {
        self.spend_compiled(evaluations.saturating_mul(self.cost))
    }

    /// Subtracts evaluations of the compiled law, each of which takes about as long as one of the Stribeck
    /// law.
    pub fn spend_compiled(&self, evaluations: u64) -> Result<(), Failure> {
        self.spent.set(self.spent.get().saturating_add(evaluations));
        let left = self.left.get().checked_sub(evaluations);
        // After the first evaluations that exceed the budget no further work may begin.
        self.left.set(left.unwrap_or(0));
        left.map(|_| ()).ok_or(Failure::StepBudget)
    }
}
