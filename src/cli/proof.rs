//! Certificates as files: written by `slipmap run`, verified by `slipmap check --proof`.

use std::io::{self, BufRead as _, Read as _, Write as _};
use std::path::Path;

use serde_json::json;

use super::output::{checked, count, exact, number_of, short, without_control_characters};
use super::report::existing;
use super::{Ended, Failure};
use crate::certify::certificate::{Certificate, Checked, Subject};
use crate::certify::point_certificate::PointCertificate;
use crate::certify::validated::surface::Surface;
use crate::certify::validated::tile::GroupBox;
use crate::files::{create_folders, folder_of, publish_file, temporary_in};

/// Largest size in bytes of a certificate that is read: more than a hundred thousand tiles.
const LONGEST: u64 = 1 << 30;

/// State of a certificate's path.
#[derive(Debug)]
pub(super) enum PathState {
    /// Nothing, or an empty file.
    Nothing,
    /// A certificate, with the identity of the run that wrote it if it records one.
    Proof(Option<String>),
    /// Something else, which is never replaced.
    Other,
    /// The path cannot be examined.
    OutOfReach(io::Error),
}

/// Examines the path of a certificate.
pub(super) fn state(path: &Path) -> PathState {
    match path.symlink_metadata() {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return PathState::Nothing,
        Err(error) => return PathState::OutOfReach(error),
        // In this order: opening a pipe would wait for its other end.
        Ok(_) if !path.metadata().is_ok_and(|metadata| metadata.is_file()) => return PathState::Other,
        Ok(_) => {}
    }
    match read(path) {
        Ok(Some((_, text))) => PathState::Proof(Certificate::parse(&text).ok().and_then(|read| read.run)),
        Ok(None) => match path.metadata().map(|metadata| metadata.len()) {
            Ok(0) => PathState::Nothing,
            _ => PathState::Other,
        },
        Err(_) => PathState::Other,
    }
}

/// Reads the text of a certificate; `None` if the file is not a certificate.
fn read(path: &Path) -> io::Result<Option<(Subject, String)>> {
    // Check the beginning first: another file may never end.
    let mut file = io::BufReader::new(std::fs::File::open(path)?);
    if !file.fill_buf()?.trim_ascii_start().starts_with(b"{") {
        return Ok(None);
    }
    let mut text = String::new();
    if file.take(LONGEST).read_to_string(&mut text)? as u64 == LONGEST {
        return Err(io::Error::other("it is longer than any proof"));
    }
    Ok(Subject::of(&text).map(|subject| (subject, text)))
}

/// Refuses a path for the certificate of a point that exists and may not be replaced, or is not a proof.
pub(super) fn check_place(path: &Path, overwrite: bool) -> Result<(), Failure> {
    let name = path.display();
    let (problem, help) = match state(path) {
        PathState::Nothing => return Ok(()),
        PathState::Proof(_) if overwrite => return Ok(()),
        PathState::Proof(_) => {
            ("exists already".into(), "add --overwrite to replace it, or choose another name")
        }
        PathState::Other => ("is not a proof, and only proofs are replaced".into(), "choose another name"),
        PathState::OutOfReach(error) => (format!("cannot be written: {error}"), "choose another name"),
    };
    Err(Failure::bad_input(format!("--proof {name} {problem}"), help))
}

/// Writes the certificate of a surface atomically. Replaces an existing one if `overwrite` is set, or if it
/// was written by the same run before it was stopped.
pub(super) fn write(surface: &Surface, run: &str, path: &Path, overwrite: bool) -> Result<(), Failure> {
    let own = || matches!(state(path), PathState::Proof(Some(writer)) if writer == run);
    write_text(Certificate::of(surface, run).text(), path, overwrite || own())
}

/// Writes the text of a certificate atomically.
pub(super) fn write_text(
    text: serde_json::Result<String>,
    path: &Path,
    replace: bool,
) -> Result<(), Failure> {
    let broken = |error: &dyn std::fmt::Display| {
        Failure::Broken(format!("{}: the proof cannot be written: {error}", path.display()))
    };
    let text = text.map_err(|error| broken(&error))?;
    let written = create_folders(folder_of(path)).and_then(|()| {
        let mut file = temporary_in(folder_of(path))?;
        file.write_all(text.as_bytes())?;
        publish_file(file, path, existing(replace))
    });
    written.map_err(|error| broken(&error))
}

/// Verifies a certificate.
pub(super) fn check(path: &Path, as_json: bool) -> Result<Ended, Failure> {
    let name = path.display();
    let bad = |problem: String, help: &str| Failure::bad_input(format!("{name}: {problem}"), help);
    let (subject, text) = read(path)
        .and_then(|proof| proof.ok_or_else(|| io::Error::other("it is not a proof")))
        .map_err(|error| {
            bad(
                format!("cannot be read: {error}"),
                "name a certificate: of `run` by validated.proof, or of `probe --proof`",
            )
        })?;
    if subject == Subject::Point {
        let certificate = PointCertificate::parse(&text)
            .map_err(|error| bad(error.to_string(), "use the version of slipmap that wrote it"))?;
        return check_point(path, &certificate, as_json);
    }
    let certificate = Certificate::parse(&text).map_err(|error| {
        bad(error.to_string(), "name a file that this version of `slipmap run` wrote for validated.proof")
    })?;
    let Checked { domain, tiles, confirmed, largest_radius, open_share, problems } = certificate.check();
    let json = json!({
        "proof": path.to_string_lossy(),
        "sound": problems.is_empty(),
        "tiles": tiles,
        "confirmed": confirmed,
        "largest_radius": largest_radius,
        "open_share": open_share,
        "problems": problems,
    });
    let GroupBox { a, k, b } = domain;
    let what = format!(
        "{name}: C*(A, k, b) over A {a:?}, k {k:?}, b {b:?}\n\
         (A = epsilon gamma (1 - alpha), k = epsilon gamma V, b = epsilon beta V, C = epsilon c)\n\
         {} of {} proved again, C* known to {} or better there; {} % of the domain is open",
        count(confirmed),
        number_of(tiles, "tile"),
        short(largest_radius),
        short(100.0 * open_share)
    );
    checked(as_json, &json, &what, &problems, "every claim is confirmed by the barriers of certify::recheck")
}

fn check_point(path: &Path, certificate: &PointCertificate, as_json: bool) -> Result<Ended, Failure> {
    let problems = certificate.check();
    let [lo, hi] = certificate.critical_c;
    let json = json!({
        "proof": path.to_string_lossy(),
        "sound": problems.is_empty(),
        "verdict": certificate.verdict,
        "critical_c": [lo, hi],
        "problems": problems,
    });
    let end = |c: Option<f64>| c.map_or("unknown".into(), exact);
    let what = format!(
        "{}: one point, {}; critical c from {} to {}",
        path.display(),
        without_control_characters(&certificate.verdict),
        end(lo),
        end(hi)
    );
    let sound = "every claim is proved again, from the law and the parameters alone";
    checked(as_json, &json, &what, &problems, sound)
}
