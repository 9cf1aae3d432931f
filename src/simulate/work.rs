//! The budget of work of one computation of cycles.
//!
//! A computation of cycles needs many orbits, some of which may be stiff. All of them share one budget, so
//! that the computation ends even if they are. A part that exceeds the budget fails with
//! [`Failure::StepBudget`].

use std::cell::Cell;

use super::Failure;
use crate::friction::Curve;

/// Largest number of evaluations of the right-hand side of the Stribeck law, see [`Curve::cost`]: half a
/// second of one orbit. The backbones and cycles of moderate parameters take a tenth of it.
const QUESTION: u64 = 7_000_000;

/// The rest of a budget.
#[derive(Debug)]
pub(super) struct Work {
    left: Cell<u64>,
    /// Cost of an evaluation of the law itself.
    cost: u64,
    /// Whether orbits see the compiled law. Its digits depend on what it was compiled for before.
    pub(super) compiles: bool,
}

impl Work {
    /// The whole budget for oscillators with this law.
    pub(super) fn of_question(curve: &Curve) -> Self {
        Self { left: Cell::new(QUESTION), cost: curve.cost(), compiles: false }
    }

    /// The same for a question that takes a backbone, which compiles the law.
    pub(super) fn of_backbone(curve: &Curve) -> Self {
        Self { compiles: curve.cost() > 1, ..Self::of_question(curve) }
    }

    /// Subtracts evaluations of the law itself from the budget.
    ///
    /// # Errors
    /// [`Failure::StepBudget`] if it does not hold them.
    pub(super) fn spend(&self, evaluations: u64) -> Result<(), Failure> {
        self.spend_compiled(evaluations.saturating_mul(self.cost))
    }

    /// The same for evaluations of the compiled law, each of which takes about as long as one of the Stribeck
    /// law.
    pub(super) fn spend_compiled(&self, evaluations: u64) -> Result<(), Failure> {
        let left = self.left.get().checked_sub(evaluations);
        // Behind the first evaluations that it does not hold no further work may begin.
        self.left.set(left.unwrap_or(0));
        left.map(|_| ()).ok_or(Failure::StepBudget)
    }
}
