//! Certificates of the universal surface: JSON files of tiles, written by `slipmap run`, verified by `slipmap check
//! --proof`.

use std::io::{self, BufRead as _, Read as _, Write as _};
use std::path::Path;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::output::{self, count, short};
use super::{Ended, Failure};
use crate::certify::recheck;
use crate::certify::validated::surface::Surface;
use crate::certify::validated::tile::{GroupBox, MODES, Tile, UNIT};

/// What a certificate calls itself.
const FORMAT: &str = "slipmap proof 1";
/// How every proof begins, of whatever format.
const BEGINNING: &str = "{\"format\":\"slipmap proof ";
/// What it says, for whoever opens it.
const STATEMENT: &str = "With v' = w, w' = -v + D w, D = -C + A/(1 + k s)^2 - 2 b s, s = 1 - v, the orbit from (1, 0) \
    comes back to v = 1 (or runs away) for C < C* and not for C > C*. In the domain of each tile |C* - sum of viscous[m] \
    T_i T_j T_l| <= radius, m = i + 3 (j + 9 l), T Chebyshev polynomials of A, k, b scaled to [-1, 1] over the domain. \
    Integers are multiples of unit; zeros at the end of a list are left out. Cosines and sines are the witness, see the \
    documentation of slipmap::certify::recheck. In the boxes `open` nothing is claimed.";

/// The file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Stored {
    format: String,
    statement: String,
    written_by: String,
    unit: f64,
    domain: GroupBox,
    open: Vec<GroupBox>,
    tiles: Vec<StoredTile>,
}

/// A tile in the file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StoredTile {
    domain: GroupBox,
    radius: f64,
    viscous: Vec<i64>,
    cosines: Vec<Vec<i64>>,
    sines: Vec<Vec<i64>>,
}

impl StoredTile {
    #[allow(clippy::cast_possible_truncation)] // coefficients are multiples of the unit below 2^17
    fn of(tile: &Tile) -> Self {
        let row = |row: &Vec<f64>| {
            let length = row.iter().rposition(|c| *c != 0.0).map_or(0, |last| last + 1);
            row[..length].iter().map(|c| (c / UNIT).round() as i64).collect()
        };
        Self {
            domain: tile.domain,
            radius: tile.radius,
            viscous: row(&tile.viscous),
            cosines: tile.cosines.iter().map(row).collect(),
            sines: tile.sines.iter().map(row).collect(),
        }
    }

    /// The tile; too long lists make one that no check confirms.
    #[allow(clippy::cast_precision_loss)] // larger integers are no coefficients of a tile, and become others
    fn tile(&self) -> Tile {
        let row = |row: &Vec<i64>| {
            let mut row: Vec<f64> = row.iter().map(|c| *c as f64 * UNIT).collect();
            row.resize(row.len().max(MODES), 0.0);
            row
        };
        Tile {
            domain: self.domain,
            radius: self.radius,
            viscous: row(&self.viscous),
            cosines: self.cosines.iter().map(row).collect(),
            sines: self.sines.iter().map(row).collect(),
        }
    }
}

/// Whether there is a proof at `path`, or nothing yet in a plain file: what may be replaced.
pub(super) fn may_replace(path: &Path) -> bool {
    let mut first = Vec::new();
    // In this order: opening a pipe would wait for its other end.
    path.metadata().is_ok_and(|metadata| metadata.is_file())
        && std::fs::File::open(path)
            .and_then(|file| file.take(BEGINNING.len() as u64).read_to_end(&mut first))
            .is_ok_and(|_| first == BEGINNING.as_bytes() || first.is_empty())
}

/// Writes the certificate of a surface, all at once.
pub(super) fn write(surface: &Surface, path: &Path, overwrite: bool) -> Result<(), Failure> {
    let broken = |error: &dyn std::fmt::Display| {
        Failure::Broken(format!("{}: the proof cannot be written: {error}", path.display()))
    };
    let stored = Stored {
        format: FORMAT.into(),
        statement: STATEMENT.into(),
        written_by: format!("slipmap {} (git {})", env!("CARGO_PKG_VERSION"), env!("SLIPMAP_GIT")),
        unit: UNIT,
        domain: surface.domain(),
        open: surface.open().collect(),
        tiles: surface.tiles().map(StoredTile::of).collect(),
    };
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    crate::store::create_folders(folder).map_err(|error| broken(&error))?;
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        // Those of any new file; the default of temporary files is readable by their owner only.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder).map_err(|error| broken(&error))?;
    let text = serde_json::to_string(&stored).map_err(|error| broken(&error))?;
    // A line a tile, for people who look at differences.
    let text = text.replace("{\"domain\"", "\n{\"domain\"");
    file.write_all(text.as_bytes()).and_then(|()| file.write_all(b"\n")).map_err(|error| broken(&error))?;
    let named = if overwrite { file.persist(path) } else { file.persist_noclobber(path) };
    named.map(drop).map_err(|error| broken(&error.error))
}

/// Verifies a certificate.
pub(super) fn check(path: &Path, as_json: bool) -> Result<Ended, Failure> {
    let name = path.display();
    let bad = |problem: String, help: &str| Failure::BadInput(format!("{name}: {problem}\n  help: {help}"));
    let mut text = String::new();
    std::fs::File::open(path)
        .and_then(|file| {
            // What begins otherwise may never end.
            let mut file = io::BufReader::new(file);
            let begins = file.fill_buf()?.starts_with(BEGINNING.as_bytes());
            if begins {
                file.read_to_string(&mut text).map(drop)
            } else {
                Err(io::Error::other("it is no proof"))
            }
        })
        .map_err(|error| bad(format!("cannot be read: {error}"), "name a file written by `slipmap run`"))?;
    let stored: Stored = serde_json::from_str(&text).map_err(|error| {
        bad(format!("is no proof: {error}"), "name a file that `slipmap run` wrote for validated.proof")
    })?;
    if stored.format != FORMAT || stored.unit != UNIT {
        return Err(bad(
            format!("is a proof of another format: {}, unit {:e}", stored.format, stored.unit),
            "use the version of slipmap that wrote it",
        ));
    }
    let found: Vec<_> = stored.tiles.par_iter().map(|tile| recheck::verify(&tile.tile())).collect();
    let mut problems: Vec<String> = found
        .iter()
        .enumerate()
        .filter_map(|(i, found)| {
            let doubt = found.as_ref().err()?;
            let GroupBox { a, k, b } = stored.tiles[i].domain;
            let claim = short(stored.tiles[i].radius);
            Some(format!("tile {} (A {a:?}, k {k:?}, b {b:?}) claims a radius of {claim}: {doubt}", i + 1))
        })
        .collect();
    let mut boxes: Vec<GroupBox> = stored.tiles.iter().map(|tile| tile.domain).collect();
    boxes.extend(&stored.open);
    if !recheck::covers(&stored.domain, &boxes) {
        problems.push("tiles and open boxes do not cover the stated domain".into());
    }
    let confirmed = found.iter().filter(|found| found.is_ok()).count();
    let widest = stored.tiles.iter().map(|tile| tile.radius).fold(0.0, f64::max);
    let volume = |one: &GroupBox| -> f64 {
        let ranges = one.ranges().into_iter().zip(stored.domain.ranges());
        let wide = ranges.filter(|(_, [lo, hi])| hi > lo);
        wide.map(|([lo, hi], [whole_lo, whole_hi])| (hi - lo) / (whole_hi - whole_lo)).product()
    };
    let open: f64 = stored.open.iter().map(volume).sum();
    if as_json {
        output::json(&json!({
            "proof": path.to_string_lossy(),
            "sound": problems.is_empty(),
            "tiles": stored.tiles.len(),
            "confirmed": confirmed,
            "largest_radius": widest,
            "open_share": open,
            "problems": problems,
        }))?;
    } else {
        let mut out = io::stdout().lock();
        let GroupBox { a, k, b } = stored.domain;
        writeln!(
            out,
            "{name}: C*(A, k, b) over A {a:?}, k {k:?}, b {b:?}\n\
             {} of {} tiles proved again, C* known to {} or better there; {} % of the domain is open",
            count(confirmed),
            count(stored.tiles.len()),
            short(widest),
            short(100.0 * open)
        )?;
        if problems.is_empty() {
            writeln!(out, "sound: every claim is confirmed by the barriers of certify::recheck")?;
        } else {
            writeln!(out, "{} problem{}:", problems.len(), if problems.len() == 1 { "" } else { "s" })?;
        }
        for problem in &problems {
            writeln!(out, "  {problem}")?;
        }
    }
    Ok(if problems.is_empty() { Ended::Fine } else { Ended::Flawed })
}
