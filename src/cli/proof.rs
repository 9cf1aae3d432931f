//! Certificates as files: written by `slipmap run` and `slipmap probe`, verified by `slipmap check --proof`.

use std::io::{self, BufRead as _, Read as _, Write as _};
use std::path::Path;

use serde_json::json;

use super::output::{checked, exact, number_of, short, without_control_characters};
use super::report::{existing, unwritten};
use super::{Ended, Failure};
use slipmap_certify::certificate::{Certificate, Checked, NoCertificate, Part};
use slipmap_certify::curve::Shares;
use slipmap_files::{create_folders, folder_of, publish_file, temporary_in};

/// Largest size in bytes of a certificate that is read: some fifty thousand boxes.
const LONGEST: u64 = 1 << 28;

/// Reads the text of a certificate; `None` if the file is not JSON.
fn read(path: &Path) -> io::Result<Option<String>> {
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
    Ok(Some(text))
}

/// Writes a certificate atomically.
pub(super) fn write(certificate: &Certificate, path: &Path, replace: bool) -> Result<(), Failure> {
    let text =
        certificate.text().map_err(|error| Failure::Broken(format!("cannot form the proof: {error}")))?;
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
    let other = "name a certificate: of `run` by validated.proof, or of `probe --proof`";
    let text = read(path)
        .and_then(|proof| proof.ok_or_else(|| io::Error::other("it is not a proof")))
        .map_err(|error| bad(format!("cannot be read: {error}"), other))?;
    let certificate = Certificate::parse(&text).map_err(|error| match error {
        NoCertificate::Malformed(_) => bad(error.to_string(), other),
        NoCertificate::OtherFormat(_) => bad(error.to_string(), "use the version of slipmap that wrote it"),
    })?;
    let Checked { boxes, parts, problems } = certificate.check();
    let told = |(part, shares): (&Part, &Shares)| {
        let critical = part.critical().map(|ends| ends.map(|c| c.is_finite().then_some(c)));
        json!({
            "present": shares.present,
            "absent": shares.absent,
            "undecided": shares.undecided(),
            "verdict": part.decision().map(|decision| decision.name()),
            "critical_c": critical,
        })
    };
    let json = json!({
        "proof": path.to_string_lossy(),
        "sound": problems.is_empty(),
        "boxes": boxes,
        "parts": certificate.parts.iter().zip(&parts).map(told).collect::<Vec<_>>(),
        "problems": problems,
    });
    let ranges = |part: &Part| {
        let axes = certificate.axes.iter().map(String::as_str).chain(["c"]);
        let all = axes.zip(part.domain.iter().chain([&part.c]));
        let told = all.map(|(name, [lo, hi])| {
            let name = without_control_characters(name);
            if lo == hi {
                format!("{name} {}", exact(*lo))
            } else {
                format!("{name} {} to {}", exact(*lo), exact(*hi))
            }
        });
        told.collect::<Vec<_>>().join(", ")
    };
    let percent = |share: f64| format!("{} %", short(100.0 * share));
    let lines = certificate.parts.iter().zip(&parts).take(MOST_LINES).map(|(part, shares)| {
        let what = match (part.decision(), part.critical()) {
            (Some(decision), Some([lo, hi])) => {
                let end = |c: f64| if c.is_finite() { exact(c) } else { "unknown".into() };
                format!("{}; critical c from {} to {}", decision.name(), end(lo), end(hi))
            }
            _ => format!(
                "present in {} at least, absent in {}",
                percent(shares.present),
                percent(shares.absent)
            ),
        };
        format!("{}: {what}", ranges(part))
    });
    let lines: Vec<String> = lines.collect();
    let what = format!("{}: {}\n{}", path.display(), number_of(boxes, "proof"), lines.join("\n"));
    let sound = "orbits are proved again to cross every curve one way, from the law and the numbers of the curves alone";
    checked(as_json, &json, what.trim_end(), &problems, sound)
}

/// Largest number of parts that are told one by one.
const MOST_LINES: usize = 20;
