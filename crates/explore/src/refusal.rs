//! Reason why a request is refused: the crate's own message, and the place in a formula that it is about.

use serde::Serialize;

use slipmap_config::Wrong;
use slipmap_map::{GridError, PlanError};
use slipmap_model::friction::PointError;
use slipmap_numbers::text::with_short_quotes;

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Refusal {
    /// As of HTTP.
    #[serde(skip)]
    status: u16,
    problem: String,
    /// The remedy; empty if the problem states it.
    remedy: String,
    /// First character of a formula concerned, and one past the last.
    #[serde(skip_serializing_if = "Option::is_none")]
    place: Option<[usize; 2]>,
}

impl Refusal {
    fn new(status: u16, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        let problem = with_short_quotes(&problem.into());
        Self { status, problem, remedy: remedy.into(), place: None }
    }

    /// The request is not one that the page sends.
    pub(super) fn malformed(problem: impl Into<String>) -> Self {
        Self::new(400, problem, "reload the page")
    }

    /// The request names something that does not exist or is illegal.
    pub(super) fn bad_input(problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::new(422, problem, remedy)
    }

    /// The request came from another page, or to another host name.
    pub fn foreign(problem: impl Into<String>) -> Self {
        Self::new(403, problem, "open the address that `slipmap explore` has printed")
    }

    /// The body of the request is too long.
    pub fn too_long(bytes: usize) -> Self {
        let problem = format!("the request is longer than {} KiB", bytes >> 10);
        Self::new(413, problem, "give a shorter table or formula")
    }

    /// Nobody waits for the answer any more.
    pub(super) fn stopped() -> Self {
        Self::new(503, "the request was given up", "try again")
    }

    /// The request exceeded its time limit.
    pub fn out_of_time(seconds: u64) -> Self {
        let problem = format!("this took longer than {seconds} s");
        Self::new(503, problem, "show a smaller region, or a simpler quantity")
    }

    /// A bug of this program.
    pub fn broken(problem: impl Into<String>) -> Self {
        Self::new(500, problem, "please report it")
    }

    /// The status and the body of the answer.
    pub fn answer(&self) -> (u16, Vec<u8>) {
        (self.status, serde_json::to_vec(self).unwrap_or_default())
    }
}

impl From<Wrong> for Refusal {
    fn from(wrong: Wrong) -> Self {
        match wrong.place {
            // The page marks it in the formula.
            Some(_) => Self { place: wrong.place, ..Self::bad_input(wrong.problem, wrong.remedy) },
            None => Self::bad_input(wrong.words(""), wrong.remedy),
        }
    }
}

impl From<PointError> for Refusal {
    fn from(error: PointError) -> Self {
        Self::bad_input(error.to_string(), "choose other values")
    }
}

impl From<GridError> for Refusal {
    fn from(error: GridError) -> Self {
        Self::bad_input(error.to_string(), "choose other values")
    }
}

impl From<PlanError> for Refusal {
    fn from(error: PlanError) -> Self {
        Self::bad_input(error.to_string(), "choose other values")
    }
}
