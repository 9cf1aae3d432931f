//! Bodies of requests: JSON of bounded length.

use axum::Json;
use axum::extract::{FromRequest, Request};
use axum::http::StatusCode;
use serde::de::DeserializeOwned;

use super::refusal::Refusal;

/// Largest size of a body in bytes: a measured law of ten thousand rows is smaller.
pub(super) const LONGEST_BODY: usize = 1 << 20;

/// The parsed body of a request.
pub(super) struct JsonBody<T>(pub(super) T);

impl<S: Send + Sync, T: DeserializeOwned> FromRequest<S> for JsonBody<T> {
    type Rejection = Refusal;

    async fn from_request(request: Request, state: &S) -> Result<Self, Refusal> {
        // Only JSON: a form of a foreign page can send text, but this type only after a preflight request.
        let parsed = Json::from_request(request, state).await;
        parsed.map(|Json(parsed)| JsonBody(parsed)).map_err(|why| match why.status() {
            StatusCode::PAYLOAD_TOO_LARGE => Refusal::too_long(LONGEST_BODY),
            _ => Refusal::malformed(format!("the request cannot be read: {}", why.body_text())),
        })
    }
}
