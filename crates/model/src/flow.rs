//! The words in which every engine tells the fate of the orbit from the exit point.

/// Place and times of sticking again, and of the stick-slip cycle that follows.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Landing {
    /// x1 at which the mass begins to stick.
    pub x1: f64,
    /// Time from the exit point to the landing.
    pub slip_time: f64,
    /// Time of sticking, from the landing to the exit point.
    pub stick_time: f64,
    /// Number of crossings of the belt line before sticking: 0, or 1 if it sticks from above; `None` where the
    /// orbit lands within its error of the end of the stick segment. It then sticks there in both cases.
    pub crossings: Option<u32>,
}

/// The fate of the orbit from the exit point.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Fate {
    /// It sticks again: a stick-slip limit cycle exists.
    Sticks(Landing),
    /// Its first turn closes inside itself: it never comes back to the belt line.
    SpiralsInward,
    /// It crosses the belt line, comes back through it without sticking, and so, orbits being nested,
    /// never sticks.
    CrossesForever,
    /// The grazing margin is smaller than its error estimate.
    TooCloseToCall,
    /// The integration failed.
    Failed(Failure),
}

/// Reason why an integration failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error, serde::Serialize, serde::Deserialize)]
pub enum Failure {
    /// The step budget ran out.
    #[error("the step budget ran out")]
    StepBudget,
    /// The fixed quota of work of this piece of knowledge is spent.
    #[error("it takes more work than its quota")]
    Quota,
    /// The step size underflowed before the tolerance was met.
    #[error("the step size underflowed before the tolerance was met")]
    StepUnderflow,
    /// The state left the finite numbers, or the slip speeds for which a law given by data is known.
    #[error("the orbit left the finite numbers, or the data of the law")]
    NotFinite,
}

/// The answer of an engine at one point, and its cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow {
    /// The fate of the orbit.
    pub fate: Fate,
    /// The scaled grazing margin m / V: the distance beyond the belt line (negative: short of it) of the
    /// first maximum of x2 in the lower flow, continued. -1 where the orbit tends to a node without a maximum
    /// (the limit of ever smaller ones), NaN where it runs far past the belt line.
    pub margin: f64,
    /// Estimate of the absolute error of `margin`.
    pub margin_error: f64,
    /// Number of evaluations of the right-hand side.
    pub rhs: u64,
}

impl Flow {
    /// Place and times of sticking, if the orbit sticks.
    pub fn landing(&self) -> Option<Landing> {
        match self.fate {
            Fate::Sticks(landing) => Some(landing),
            _ => None,
        }
    }
}
