//! Restricts access: refuses requests to another host or from another origin, and instructs the browser to
//! load nothing from other places.
//!
//! Any web page can send requests to the loopback address. Its `Origin` header reveals it; where another name
//! was bound to this address on purpose, the `Host` header does.

use axum::extract::{Request, State};
use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, HOST, ORIGIN, REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS,
};
use axum::http::{HeaderName, HeaderValue};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::refusal::Refusal;

/// The content security policy: the page loads only its own files, and pictures that it has made itself.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; \
                      connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// The host names of this server.
#[derive(Clone, Debug)]
pub(super) struct Names([String; 2]);

impl Names {
    pub(super) fn of_port(port: u16) -> Self {
        Self(["127.0.0.1", "localhost"].map(|name| format!("{name}:{port}")))
    }

    fn check(&self, request: &Request) -> Result<(), Refusal> {
        let headers = request.headers();
        let is_own = |host: &[u8]| self.0.iter().any(|name| name.as_bytes() == host);
        if !headers.get(HOST).is_some_and(|host| is_own(host.as_bytes())) {
            return Err(Refusal::foreign("the request is for another host"));
        }
        let origin = headers.get(ORIGIN).map(HeaderValue::as_bytes);
        match origin.is_none_or(|origin| origin.strip_prefix(b"http://").is_some_and(is_own)) {
            true => Ok(()),
            false => Err(Refusal::foreign("the request comes from another page")),
        }
    }
}

/// Passes only requests of the page itself, and restricts what the page may load.
pub(super) async fn protect(State(names): State<Names>, request: Request, next: Next) -> Response {
    let mut response = match names.check(&request) {
        Ok(()) => next.run(request).await,
        Err(refusal) => refusal.into_response(),
    };
    let headers = response.headers_mut();
    let settings: [(HeaderName, &'static str); 6] = [
        (CONTENT_SECURITY_POLICY, POLICY),
        (X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (REFERRER_POLICY, "no-referrer"),
        (CACHE_CONTROL, "no-store"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
        (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    ];
    for (name, value) in settings {
        headers.insert(name, HeaderValue::from_static(value));
    }
    response
}
