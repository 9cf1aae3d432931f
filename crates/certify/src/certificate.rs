//! Certificates of the universal surface C*(A, k, b): JSON text that is verified by another
//! argument than its proof.
//!
//! A certificate may come from anybody, so it proves nothing until it is checked. [`Certificate::parse`]
//! accepts only the keys of the format, with finite numbers; [`Certificate::check`] proves every claim again
//! by [`super::recheck`] and compares the statement with that of the format. `written_by` and `run` record
//! where a certificate comes from and are not verified.
//!
//! Numbers mean the nearest doubles; the coefficients of polynomials are integer multiples of `unit`. The
//! values count, not the bytes: another program may have written the text again, with its own order of keys
//! and spaces.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::recheck::{self, divides};
use super::validated::surface::Surface;
use super::validated::tile::{GroupBox, MODES, Tile, UNIT};
use list::List;

pub(super) mod list;

const FORMAT: &str = "slipmap proof 1";
/// First bytes of every certificate that this program writes, in any version of the format.
const BEGINNING: &str = "{\"format\":\"slipmap proof ";
/// The statement of every certificate.
const STATEMENT: &str = "With v' = w, w' = -v + D w, D = -C + A/(1 + k s)^2 - 2 b s, s = 1 - v, the orbit from (1, 0) \
    comes back to v = 1 (or runs away) for C < C* and not for C > C*. In the domain of each tile |C* - sum of viscous[m] \
    T_i T_j T_l| <= radius, m = i + 3 (j + 9 l), T Chebyshev polynomials of A, k, b scaled to [-1, 1] over the domain. \
    Integers are multiples of unit; zeros at the end of a list are left out. Cosines and sines are the witness, see the \
    documentation of slipmap::certify::recheck. In the boxes `open` nothing is claimed.";
/// From here on different integers are the same f64; no coefficient is that large.
const BEYOND: f64 = (1_u64 << 53) as f64;

/// Largest number of tiles, and of open boxes, of a certificate that is read.
pub(super) const MOST_BOXES: usize = 1 << 20;
/// Largest number of harmonics of a witness.
const MOST_HARMONICS: usize = 512;

/// What a certificate is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// The universal surface: [`Certificate`].
    Surface,
    /// One point: [`super::point_certificate::PointCertificate`].
    Point,
    /// A box of any law's parameters: [`super::law_certificate::LawCertificate`].
    Law,
}

impl Subject {
    /// The subject of the certificate with this text, of any version of its format; `None` for other texts.
    /// For certificates written by this program the first bytes are enough: `text` may be cut off.
    pub fn of(text: &str) -> Option<Self> {
        #[derive(Deserialize)]
        struct Named {
            format: String,
        }
        let beginning = "{\"format\":\"";
        let named;
        let format = match text.strip_prefix(beginning).filter(|_| text.starts_with(BEGINNING)) {
            Some(rest) => rest,
            None => {
                named = serde_json::from_str::<Named>(text).ok()?.format;
                &named
            }
        };
        let beginnings = [
            ("slipmap proof of a point ", Subject::Point),
            ("slipmap proof of a law ", Subject::Law),
            ("slipmap proof ", Subject::Surface),
        ];
        beginnings
            .into_iter()
            .find(|(beginning, _)| format.starts_with(beginning))
            .map(|(_, subject)| subject)
    }
}

/// A certificate that has been parsed but not verified.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    format: String,
    statement: String,
    written_by: String,
    /// The run that it names as its origin.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub run: Option<String>,
    unit: f64,
    /// The groups that it speaks of.
    pub domain: GroupBox,
    open: List<GroupBox, MOST_BOXES>,
    tiles: List<StoredTile, MOST_BOXES>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StoredTile {
    domain: GroupBox,
    radius: f64,
    viscous: Row,
    cosines: List<Row, MOST_HARMONICS>,
    sines: List<Row, MOST_HARMONICS>,
}

/// The coefficients of a polynomial of a tile.
type Row = List<Multiple, MODES>;

/// An integer, which other programs may write with a decimal point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "f64")]
struct Multiple(i64);

impl TryFrom<f64> for Multiple {
    type Error = &'static str;

    fn try_from(x: f64) -> Result<Self, Self::Error> {
        match x.fract() == 0.0 && x.abs() < BEYOND {
            true => Ok(Self(x as i64)),
            false => Err("a coefficient is not an integer below 2^53"),
        }
    }
}

/// The result of a check.
#[derive(Clone, Debug, PartialEq)]
pub struct Checked {
    /// Number of tiles.
    pub tiles: usize,
    /// Number of tiles that were proved again.
    pub confirmed: usize,
    /// The largest error of a proved critical damping, in scaled units.
    pub largest_radius: f64,
    /// Share of the domain in which nothing is claimed; valid if there are no problems.
    pub open_share: f64,
    /// All problems; the certificate is sound if there are none.
    pub problems: Vec<String>,
}

impl Checked {
    /// The result for tiles that claim these `radii`, in a `domain` with `open` boxes.
    pub(super) fn new<Box: AsRef<[[f64; 2]]>>(
        radii: impl ExactSizeIterator<Item = f64>,
        confirmed: usize,
        domain: impl AsRef<[[f64; 2]]>,
        open: impl Iterator<Item = Box>,
        problems: Vec<String>,
    ) -> Self {
        let share = |one: Box| -> f64 {
            let wide = one.as_ref().iter().zip(domain.as_ref()).filter(|(_, [lo, hi])| hi > lo);
            wide.map(|([lo, hi], [from, to])| (hi - lo) / (to - from)).product()
        };
        Self {
            tiles: radii.len(),
            confirmed,
            largest_radius: radii.fold(0.0, f64::max),
            open_share: open.map(share).fold(0.0, |sum, share| sum + share),
            problems,
        }
    }
}

/// Reason why a text is not a certificate.
#[derive(Debug, thiserror::Error)]
pub enum NoCertificate {
    /// The text is not JSON, or has other keys or values than a certificate.
    #[error("is not a proof: {0}")]
    Malformed(#[from] serde_json::Error),
    /// The certificate has another version of the format.
    #[error("is a proof of another format: {format}, unit {unit:e}")]
    OtherFormat {
        /// The format that it names.
        format: String,
        /// Its unit.
        unit: f64,
    },
}

impl Certificate {
    /// The certificate of a surface, written by this program in the run that `run` identifies.
    #[must_use]
    pub fn of(surface: &Surface, written_by: &str, run: &str) -> Self {
        Self {
            format: FORMAT.into(),
            statement: STATEMENT.into(),
            written_by: written_by.into(),
            run: Some(run.into()),
            unit: UNIT,
            domain: surface.domain,
            open: surface.open().collect(),
            tiles: surface.tiles().map(StoredTile::of).collect(),
        }
    }

    /// Parses a certificate without verifying its claims.
    ///
    /// # Errors
    /// [`NoCertificate`].
    pub fn parse(text: &str) -> Result<Self, NoCertificate> {
        let read: Self = serde_json::from_str(text)?;
        if read.format != FORMAT || read.unit != UNIT {
            return Err(NoCertificate::OtherFormat { format: read.format, unit: read.unit });
        }
        Ok(read)
    }

    /// Its JSON text, with one line per tile so that differences can be read.
    ///
    /// # Errors
    /// None is known: the numbers of a surface are finite.
    pub fn text(&self) -> serde_json::Result<String> {
        Ok(serde_json::to_string(self)?.replace("{\"domain\"", "\n{\"domain\"") + "\n")
    }

    /// Verifies every claim, by [`super::recheck`].
    #[must_use]
    pub fn check(&self) -> Checked {
        let mut problems = Vec::new();
        if self.statement != STATEMENT {
            problems.push("its statement is not the one that this format proves".into());
        }
        let boxes = self.tiles.iter().map(|tile| &tile.domain).chain(self.open.iter());
        let boxes: Vec<_> = boxes.map(GroupBox::ranges).collect();
        if let Err(fault) = divides(&self.domain.ranges(), &boxes) {
            problems.push(format!("tiles (counted first) and open boxes do not divide the domain: {fault}"));
        }
        let found: Vec<Option<String>> = self.tiles.par_iter().map(StoredTile::doubt).collect();
        let confirmed = found.iter().filter(|doubt| doubt.is_none()).count();
        for (i, (doubt, tile)) in found.into_iter().zip(self.tiles.iter()).enumerate() {
            let GroupBox { a, k, b } = tile.domain;
            problems.extend(doubt.map(|doubt| {
                format!(
                    "tile {} (A {a:?}, k {k:?}, b {b:?}) claims a radius of {:e}: {doubt}",
                    i + 1,
                    tile.radius
                )
            }));
        }
        let radii = self.tiles.iter().map(|tile| tile.radius);
        let open = self.open.iter().map(GroupBox::ranges);
        Checked::new(radii, confirmed, self.domain.ranges(), open, problems)
    }
}

impl StoredTile {
    fn of(tile: &Tile) -> Self {
        let row = |row: &Vec<f64>| {
            let length = row.iter().rposition(|c| *c != 0.0).map_or(0, |last| last + 1);
            row[..length].iter().map(|c| Multiple((c / UNIT).round() as i64)).collect()
        };
        Self {
            domain: tile.domain,
            radius: tile.radius,
            viscous: row(&tile.viscous),
            cosines: tile.cosines.iter().map(row).collect(),
            sines: tile.sines.iter().map(row).collect(),
        }
    }

    /// The reason why its claim is not confirmed; `None` if it is.
    fn doubt(&self) -> Option<String> {
        recheck::verify(&self.tile()).err().map(|doubt| doubt.to_string())
    }

    /// The tile.
    fn tile(&self) -> Tile {
        let row = |row: &Row| {
            let mut row: Vec<f64> = row.iter().map(|c| c.0 as f64 * UNIT).collect();
            row.resize(MODES, 0.0);
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
