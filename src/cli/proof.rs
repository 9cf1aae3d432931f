//! Certificates as files: written by `slipmap run`, verified by `slipmap check --proof`.

use std::io::{self, BufRead as _, Read as _, Write as _};
use std::path::Path;

use serde_json::json;

use super::output::{checked, count, exact, number_of, short, without_control_characters};
use super::report::{existing, unwritten};
use super::{Ended, Failure, WRITTEN_BY};
use slipmap_certify::certificate::{Certificate, Checked, Format as _, NoCertificate, Subject};
use slipmap_certify::law_certificate::LawCertificate;
use slipmap_certify::point_certificate::PointCertificate;
use slipmap_certify::validated::tile::GroupBox;
use slipmap_files::{create_folders, folder_of, publish_file, temporary_in};
use slipmap_map::Proofs;

/// Largest size in bytes of a certificate that is read: twenty thousand tiles of the universal surface.
const LONGEST: u64 = 1 << 28;

/// Reads the text of a certificate; `None` if the file is not a certificate.
fn read(path: &Path) -> io::Result<Option<(Subject, String)>> {
    let metadata = path.metadata()?;
    if !(metadata.is_file() || metadata.is_dir()) {
        // Opening a pipe would wait for its other end.
        return Err(io::Error::other("it is not a proof, but a pipe or a device"));
    }
    // Check the beginning first: another file may never end.
    let mut file = io::BufReader::new(std::fs::File::open(path)?);
    if !file.fill_buf()?.trim_ascii_start().starts_with(b"{") {
        return Ok(None);
    }
    let mut text = String::new();
    if file.take(LONGEST).read_to_string(&mut text)? as u64 == LONGEST {
        return Err(io::Error::other("it is longer than any proof"));
    }
    Ok(Subject::of(&text)?.map(|subject| (subject, text)))
}

/// Writes the certificate of a run's proofs atomically.
pub(super) fn write(proofs: &Proofs, path: &Path, replace: bool) -> Result<(), Failure> {
    let text = match proofs {
        Proofs::Surface(surface) => Certificate::of(surface, WRITTEN_BY).text(),
        Proofs::Law(law) => LawCertificate::of(law, WRITTEN_BY).text(),
    };
    write_text(text, path, replace)
}

/// Writes the text of a certificate atomically.
pub(super) fn write_text(
    text: serde_json::Result<String>,
    path: &Path,
    replace: bool,
) -> Result<(), Failure> {
    let text = text.map_err(|error| Failure::Broken(format!("cannot form the proof: {error}")))?;
    let written = create_folders(folder_of(path)).and_then(|()| {
        let mut file = temporary_in(folder_of(path))?;
        file.write_all(text.as_bytes())?;
        publish_file(file, path, existing(replace))
    });
    written.map_err(|error| unwritten(path, &error))
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
    let other_version =
        |error: NoCertificate| bad(error.to_string(), "use the version of slipmap that wrote it");
    match subject {
        Subject::Point => check_point(path, &PointCertificate::parse(&text).map_err(other_version)?, as_json),
        Subject::Surface => {
            let certificate = Certificate::parse(&text).map_err(other_version)?;
            let GroupBox { a, k, b } = certificate.domain;
            let what = format!(
                "C*(A, k, b) over A {a:?}, k {k:?}, b {b:?}\n\
                 (A = epsilon gamma (1 - alpha), k = epsilon gamma V, b = epsilon beta V, C = epsilon c)"
            );
            let sound =
                "every claim is proved again by a second argument, curves that the flow crosses one way";
            check_boxes(path, &what, certificate.check(), sound, as_json)
        }
        Subject::Law => {
            let certificate = LawCertificate::parse(&text).map_err(other_version)?;
            let ranges = certificate.axes.iter().zip(certificate.domain.iter());
            let ranges =
                ranges.map(|(name, range)| format!("{} {range:?}", without_control_characters(name)));
            let what = format!("C* = epsilon c* over {}", ranges.collect::<Vec<_>>().join(", "));
            let sound =
                "every claim is proved again by the prover that made it, from the law and the boxes alone";
            check_boxes(path, &what, certificate.check(), sound, as_json)
        }
    }
}

fn check_boxes(
    path: &Path,
    what: &str,
    found: Checked,
    sound: &str,
    as_json: bool,
) -> Result<Ended, Failure> {
    let Checked { tiles, confirmed, largest_radius, mean_radius, open_share, problems } = found;
    let json = json!({
        "proof": path.to_string_lossy(),
        "sound": problems.is_empty(),
        "tiles": tiles,
        "confirmed": confirmed,
        "largest_radius": largest_radius,
        "mean_radius": mean_radius,
        "open_share": open_share,
        "problems": problems,
    });
    let what = format!(
        "{}: {what}\n{} of {} proved again, {} % of the domain: there C* is known to {} on average, {} at worst",
        path.display(),
        count(confirmed),
        number_of(tiles, "tile"),
        short(100.0 * (1.0 - open_share)),
        short(mean_radius),
        short(largest_radius)
    );
    checked(as_json, &json, &what, &problems, sound)
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
    let sound = "orbits are proved again to cross every curve one way, from the law and the numbers of the curves alone";
    checked(as_json, &json, &what, &problems, sound)
}
