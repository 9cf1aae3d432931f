//! The files of the page, inside the program.

use axum::extract::Path;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};

use super::refusal::Refusal;

/// Name, media type and content of each file.
const FILES: [(&str, &str, &str); 16] = [
    ("style.css", "text/css", include_str!("assets/style.css")),
    ("icon.svg", "image/svg+xml", include_str!("assets/icon.svg")),
    ("main.js", SCRIPT, include_str!("assets/main.js")),
    ("server.js", SCRIPT, include_str!("assets/server.js")),
    ("state.js", SCRIPT, include_str!("assets/state.js")),
    ("scale.js", SCRIPT, include_str!("assets/scale.js")),
    ("paint.js", SCRIPT, include_str!("assets/paint.js")),
    ("plane.js", SCRIPT, include_str!("assets/plane.js")),
    ("glance.js", SCRIPT, include_str!("assets/glance.js")),
    ("overlay.js", SCRIPT, include_str!("assets/overlay.js")),
    ("controls.js", SCRIPT, include_str!("assets/controls.js")),
    ("point.js", SCRIPT, include_str!("assets/point.js")),
    ("elements.js", SCRIPT, include_str!("assets/elements.js")),
    ("gallery.js", SCRIPT, include_str!("assets/gallery.js")),
    ("leave.js", SCRIPT, include_str!("assets/leave.js")),
    ("legend.js", SCRIPT, include_str!("assets/legend.js")),
];
const SCRIPT: &str = "text/javascript";

pub(super) async fn page() -> Response {
    ([(CONTENT_TYPE, "text/html; charset=utf-8")], include_str!("assets/index.html")).into_response()
}

pub(super) async fn file(Path(name): Path<String>) -> Result<Response, Refusal> {
    let found = FILES.iter().find(|(known, ..)| *known == name);
    let (_, kind, content) = found.ok_or_else(|| Refusal::malformed("the page has no such file"))?;
    Ok(([(CONTENT_TYPE, *kind)], *content).into_response())
}
