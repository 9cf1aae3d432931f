//! Bodies of requests: JSON of bounded length that arrives in bounded time.

use std::time::Duration;

use axum::body::Bytes;
use axum::extract::{FromRequest, Request};
use axum::http::header::CONTENT_TYPE;
use serde::de::DeserializeOwned;

use super::refusal::Refusal;

/// Largest size of a body in bytes: a measured law of ten thousand rows is smaller.
pub(super) const LONGEST_BODY: usize = 1 << 20;
/// Time limit for the arrival of a body.
const PATIENCE: Duration = Duration::from_secs(5);

/// The parsed body of a request.
pub(super) struct JsonBody<T>(pub(super) T);

impl<S: Send + Sync, T: DeserializeOwned> FromRequest<S> for JsonBody<T> {
    type Rejection = Refusal;

    async fn from_request(request: Request, state: &S) -> Result<Self, Refusal> {
        // A form of a foreign page can send text, but this type only after a preflight request.
        let is_json = |value: &axum::http::HeaderValue| value.as_bytes().starts_with(b"application/json");
        if !request.headers().get(CONTENT_TYPE).is_some_and(is_json) {
            return Err(Refusal::malformed("the body is not declared to be JSON"));
        }
        let body = tokio::time::timeout(PATIENCE, Bytes::from_request(request, state)).await;
        let body = body.map_err(|_| Refusal::too_slow())?;
        // On a live connection a body fails only by its length.
        let body = body.map_err(|_| Refusal::too_long(LONGEST_BODY))?;
        let parsed = serde_json::from_slice(&body);
        parsed
            .map(JsonBody)
            .map_err(|error| Refusal::malformed(format!("the request cannot be read: {error}")))
    }
}
