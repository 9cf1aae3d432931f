//! The one door to the answers of the page: a path and a body in, a status and bytes out.

use std::sync::atomic::AtomicBool;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use slipmap_config::{About, LawText, check_names};

use super::place::{Place, at_json};
use super::plane::PlaneRequest;
use super::point::PointRequest;
use super::refusal::Refusal;
use super::{catalogue, law, quantities};

/// Largest size of a body in bytes: a measured law of ten thousand rows is smaller.
pub const LONGEST_BODY: usize = 1 << 20;

/// The status, as of HTTP, and the body of the answer to a request with this body; a set `stop` ends work early. A
/// refusal is JSON.
pub fn ask(path: &str, body: &[u8], stop: &AtomicBool) -> (u16, Vec<u8>) {
    match answer(path, body, stop) {
        Ok(answer) => (200, answer),
        Err(refusal) => refusal.answer(),
    }
}

fn answer(path: &str, body: &[u8], stop: &AtomicBool) -> Result<Vec<u8>, Refusal> {
    if body.len() > LONGEST_BODY {
        return Err(Refusal::too_long(LONGEST_BODY));
    }
    let answer = match path {
        "plane" => return read::<PlaneRequest>(body)?.picture(stop),
        "law" => law(&read(body)?)?,
        "dimensionless" => dimensionless(&read(body)?)?,
        "curves" => read::<PlaneRequest>(body)?.boundaries(stop)?,
        "texts" => read::<PlaneRequest>(body)?.texts()?,
        "glance" => read::<PointRequest>(body)?.glance(stop)?,
        "point" => read::<PointRequest>(body)?.probe(stop)?,
        "figure" => read::<PointRequest>(body)?.figure(stop)?,
        _ => return Err(Refusal::malformed("there is nothing here")),
    };
    Ok(answer.to_string().into_bytes())
}

fn read<T: DeserializeOwned>(body: &[u8]) -> Result<T, Refusal> {
    serde_json::from_slice(body)
        .map_err(|why| Refusal::malformed(format!("the request cannot be read: {why}")))
}

/// A law that was typed or dropped; with a motion, the law of a machine.
#[derive(Deserialize)]
struct LawRequest {
    #[serde(flatten)]
    law: LawText,
    #[serde(default)]
    motion: Option<String>,
}

/// The axes of a law, or of a machine.
fn law(request: &LawRequest) -> Result<Value, Refusal> {
    let (law, axes) = match &request.motion {
        None => {
            let law = law::law_of(&request.law, About::Oscillator)?;
            let axes = catalogue::axes(&law);
            (law, axes)
        }
        Some(motion) => {
            let motion = quantities::motion_of(motion)?;
            let law = law::law_of(&request.law, About::Machine(motion))?;
            check_names(&law)?;
            let axes = quantities::axes(&law, motion, &request.law.axes, request.law.holds_forces(&law));
            (law, axes)
        }
    };
    Ok(json!({ "name": law.name(), "axes": axes }))
}

/// Converts a place to dimensionless numbers.
fn dimensionless(place: &Place) -> Result<Value, Refusal> {
    let (law, point) = place.point()?;
    Ok(json!({ "law": law::law_json(&law), "at": at_json(&law, &point) }))
}
