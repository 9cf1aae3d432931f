//! The quotas of work: each piece of knowledge has a fixed one.
//!
//! What a piece needs more than its quota is not known, with that as the reason. Nothing is borrowed from another piece nor
//! made whole again, so that an answer does not depend on what was asked before.

use std::cell::Cell;

use slipmap_model::flow::Failure;
use slipmap_model::friction::Curve;

/// A piece of knowledge of a column, or of one of its dampings, with its quota: a number of evaluations of the right-hand
/// side of the Stribeck law (see [`Curve::cost`]), some 50 to 70 ns each. Those of a point add up to about two seconds;
/// usual laws take a thousandth of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Piece {
    /// The fate of the orbit from the exit point at one damping, and its landing.
    Fate,
    /// The damping at which that orbit grazes; with a drop also that of the orbit at rest on the belt line.
    Critical,
    /// The backbones that are tried first, together.
    CoarseBackbones,
    /// The backbone of full accuracy.
    FineBackbone,
    /// The less accurate one that is told where that exceeds its quota.
    RoughBackbone,
    /// The slip cycles at one damping, together.
    SlipCycles,
    /// The way onto the edge of a basin.
    Kick,
    /// The loops beyond the exit point at one damping: whether some cross for ever, or all cycles among them.
    Loops,
    /// The damping from which on orbits from the exit point stick.
    SticksFrom,
    /// The derivatives of the critical damping, or the shares of slip speeds in it.
    Sensitivity,
    /// The test function of a bifurcation at one place of a plane.
    Test,
}

impl Piece {
    /// Its quota.
    #[must_use]
    pub const fn quota(self) -> u64 {
        match self {
            Piece::FineBackbone => 7_000_000,
            Piece::Critical | Piece::Test => 4_000_000,
            Piece::Fate => 5_000_000,
            Piece::CoarseBackbones
            | Piece::RoughBackbone
            | Piece::SticksFrom
            | Piece::Sensitivity
            | Piece::Loops => 3_000_000,
            Piece::SlipCycles => 2_000_000,
            Piece::Kick => 1_000_000,
        }
    }
}

/// How much of the quotas is used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Effort {
    /// All: at a point.
    #[default]
    Whole,
    /// A share, where many columns are asked for one answer: less is known then, and nothing else is told.
    Small,
}

/// The share of [`Effort::Small`], as its inverse.
const SMALL: u64 = 20;

/// The rest of a quota.
#[derive(Debug, Default)]
pub struct Work {
    left: Cell<u64>,
    /// Evaluations so far, of the law itself or of its compiled form.
    done: Cell<u64>,
    /// Evaluations of the Stribeck law that the quota was asked for.
    spent: Cell<u64>,
    /// Cost of an evaluation of the law itself.
    cost: u64,
    /// Whether an optional part has failed.
    gave_up: Cell<bool>,
}

impl Work {
    /// The quota of a piece, for oscillators with this law.
    pub fn of(piece: Piece, curve: &Curve) -> Self {
        Self::with(Effort::Whole, piece, curve)
    }

    /// What an effort has of it.
    pub fn with(effort: Effort, piece: Piece, curve: &Curve) -> Self {
        let share = match effort {
            Effort::Whole => 1,
            Effort::Small => SMALL,
        };
        Self { left: Cell::new(piece.quota() / share), cost: curve.cost(), ..Self::default() }
    }

    /// One of `parts` equal parts of it.
    #[must_use]
    pub fn part(self, parts: usize) -> Self {
        self.left.set(self.left.get() / parts.max(1) as u64);
        self
    }

    /// Notes evaluations, whether or not the quota holds them.
    pub fn count(&self, evaluations: u64) {
        self.done.set(self.done.get() + evaluations);
    }

    /// All evaluations so far.
    pub fn done(&self) -> u64 {
        self.done.get()
    }

    /// What the quota was asked for so far, in evaluations of the Stribeck law.
    pub fn spent(&self) -> u64 {
        self.spent.get()
    }

    /// The evaluations of the Stribeck law that are left.
    pub fn left(&self) -> u64 {
        self.left.get()
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

    /// Subtracts evaluations of the law itself from the quota.
    ///
    /// # Errors
    /// [`Failure::Quota`] if it does not hold them.
    pub fn spend(&self, evaluations: u64) -> Result<(), Failure> {
        self.spend_compiled(evaluations.saturating_mul(self.cost))
    }

    /// Subtracts evaluations of the compiled law, each of which takes about as long as one of the Stribeck
    /// law.
    ///
    /// # Errors
    /// [`Failure::Quota`] if it does not hold them.
    pub fn spend_compiled(&self, evaluations: u64) -> Result<(), Failure> {
        self.spent.set(self.spent.get().saturating_add(evaluations));
        let left = self.left.get().checked_sub(evaluations);
        // After the first evaluations that exceed the quota no further work may begin.
        self.left.set(left.unwrap_or(0));
        left.map(|_| ()).ok_or(Failure::Quota)
    }

    /// Why an orbit that no engine closed is not known.
    pub fn why_not_closed(&self) -> Failure {
        if self.left.get() == 0 { Failure::Quota } else { Failure::StepUnderflow }
    }
}
