//! How the orbit of a cell ends.

use super::Verdict;
use slipmap_model::flow::{Fate, Flow};

/// The fate of a cell's orbit, without its details.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// It sticks again.
    Sticks,
    /// It spirals inward.
    Inward,
    /// It crosses the belt line for ever.
    Crosses,
    /// Undecided: the margin is within its error.
    TooClose,
    /// No engine followed it.
    Failed,
}

impl From<&Fate> for End {
    fn from(fate: &Fate) -> Self {
        match fate {
            Fate::Sticks(_) => End::Sticks,
            Fate::SpiralsInward => End::Inward,
            Fate::CrossesForever => End::Crosses,
            Fate::TooCloseToCall => End::TooClose,
            Fate::Failed(_) => End::Failed,
        }
    }
}

impl From<&Fate> for Verdict {
    fn from(fate: &Fate) -> Self {
        End::from(fate).verdict()
    }
}

impl End {
    /// The end of a flow.
    pub fn of(flow: &Flow) -> Self {
        (&flow.fate).into()
    }

    /// Whether the orbit returns to the belt line; `None` if that is unknown.
    pub fn returns(self) -> Option<bool> {
        match self {
            End::Sticks | End::Crosses => Some(true),
            End::Inward => Some(false),
            End::TooClose | End::Failed => None,
        }
    }

    /// The verdict on the stick-slip cycle.
    pub fn verdict(self) -> Verdict {
        match self {
            End::Sticks => Verdict::Present,
            End::Inward | End::Crosses => Verdict::Absent,
            End::TooClose => Verdict::Undecided,
            End::Failed => Verdict::Failed,
        }
    }
}
