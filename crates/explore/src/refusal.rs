//! Reason why a request is refused: the crate's own message, and the place in a formula that it is about.

use axum::Json;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use serde::Serialize;

use slipmap_config::Wrong;
use slipmap_map::{GridError, PlanError};
use slipmap_model::friction::PointError;
use slipmap_numbers::text::with_short_quotes;

#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Refusal {
    #[serde(skip)]
    status: StatusCode,
    problem: String,
    /// The remedy; empty if the problem states it.
    remedy: String,
    /// First character of a formula concerned, and one past the last.
    #[serde(skip_serializing_if = "Option::is_none")]
    place: Option<[usize; 2]>,
}

impl Refusal {
    fn new(status: StatusCode, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        let problem = with_short_quotes(&problem.into());
        Self { status, problem, remedy: remedy.into(), place: None }
    }

    /// The request is not one that the page sends.
    pub(super) fn malformed(problem: impl Into<String>) -> Self {
        Self::new(StatusCode::BAD_REQUEST, problem, "reload the page")
    }

    /// The request names something that does not exist or is illegal.
    pub(super) fn bad_input(problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::new(StatusCode::UNPROCESSABLE_ENTITY, problem, remedy)
    }

    /// The request came from another page, or to another host name.
    pub(super) fn foreign(problem: impl Into<String>) -> Self {
        Self::new(StatusCode::FORBIDDEN, problem, "open the address that `slipmap explore` has printed")
    }

    /// The body of the request is too long.
    pub(super) fn too_long(bytes: usize) -> Self {
        let problem = format!("the request is longer than {} KiB", bytes >> 10);
        Self::new(StatusCode::PAYLOAD_TOO_LARGE, problem, "give a shorter table or formula")
    }

    /// Nobody waits for the answer any more.
    pub(super) fn stopped() -> Self {
        Self::new(StatusCode::SERVICE_UNAVAILABLE, "the request was given up", "try again")
    }

    /// The request exceeded its time limit.
    pub(super) fn out_of_time(seconds: u64) -> Self {
        let problem = format!("this took longer than {seconds} s");
        Self::new(StatusCode::SERVICE_UNAVAILABLE, problem, "show a smaller region, or a simpler quantity")
    }

    /// A bug of this program.
    pub(super) fn broken(problem: impl Into<String>) -> Self {
        Self::new(StatusCode::INTERNAL_SERVER_ERROR, problem, "please report it")
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

impl IntoResponse for Refusal {
    fn into_response(self) -> Response {
        (self.status, Json(self)).into_response()
    }
}
