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

#[cfg(test)]
mod tests {
    use super::*;

    /// Width, height and codes of a picture.
    fn picture(asked: &Value) -> (usize, usize, Vec<u8>) {
        let (status, mut bytes) = ask("plane", asked.to_string().as_bytes(), &AtomicBool::new(false));
        assert_eq!(status, 200, "{}", String::from_utf8_lossy(&bytes));
        let end = bytes.iter().position(|&byte| byte == b'\n').unwrap();
        let cells = bytes.split_off(end + 1);
        let head: Value = serde_json::from_slice(&bytes).unwrap();
        let size = |name: &str| head[name].as_u64().unwrap() as usize;
        (size("width"), size("height"), cells)
    }

    /// Workers of a browser compute strips; where friction at rest is below the kinetic one, a whole strip is illegal.
    #[test]
    fn a_picture_is_the_sum_of_its_parts() {
        let at = json!({
            "mass": 2.0, "stiffness": 5e5, "damping": 100.0, "normal_force": 1000.0, "static_friction": 0.4,
            "kinetic_friction": 0.25, "stribeck_velocity": 0.05, "strengthening": 0.0, "belt_speed": 0.2,
        });
        for (up, to) in [("static_friction", 0.8), ("damping", 500.0)] {
            let asked = json!({
                "law": { "name": "exponential" }, "motion": "translation", "at": at, "show": "regime",
                "x": { "axis": "belt_speed", "from": 0.0, "to": 0.6, "points": 9 },
                "y": { "axis": up, "from": 0.0, "to": to, "points": 12 },
            });
            let (width, height, whole) = picture(&asked);
            assert!((width, height) == (9, 12) && whole.iter().any(|&code| code != whole[0]));
            let mut rows = Vec::new();
            for part in [[0, 3], [3, 4], [4, 12]] {
                let mut asked = asked.clone();
                asked["y"]["part"] = json!(part);
                let (width, height, cells) = picture(&asked);
                assert_eq!((width, height), (9, part[1] - part[0]));
                rows.extend(cells);
            }
            assert_eq!(rows, whole, "{up}");
            for part in [[0, 5], [5, 9]] {
                let mut asked = asked.clone();
                asked["x"]["part"] = json!(part);
                let (width, _, cells) = picture(&asked);
                for (i, code) in cells.iter().enumerate() {
                    assert_eq!(*code, whole[i / width * 9 + part[0] + i % width], "{up} {i}");
                }
            }
            let mut wrong = asked;
            wrong["x"]["part"] = json!([4, 10]);
            assert_eq!(ask("plane", wrong.to_string().as_bytes(), &AtomicBool::new(false)).0, 400);
        }
    }
}
