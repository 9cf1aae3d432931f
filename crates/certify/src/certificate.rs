//! Certificates of the universal surface C*(A, k, b): JSON text that is verified by another
//! argument than its proof.
//!
//! A certificate may come from anybody, so it proves nothing until it is checked. [`Format::parse`]
//! accepts only the keys of the format, with finite numbers; [`Certificate::check`] proves every claim again
//! by [`super::recheck`] and compares the statement with that of the format. `written_by` records
//! where a certificate comes from and is not verified.
//!
//! Numbers mean the nearest doubles; the coefficients of polynomials are integer multiples of `unit`. The
//! values count, not the bytes: another program may have written the text again, with its own order of keys
//! and spaces.

use rayon::prelude::*;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::recheck::{self, divides};
use super::validated::surface::Surface;
use super::validated::tile::{GroupBox, MODES, Tile, UNIT};
use list::List;

pub(super) mod list;

/// From here on different integers are the same f64; no coefficient is that large.
const BEYOND: f64 = (1_u64 << 53) as f64;

/// Largest number of tiles, and of open boxes, of a certificate that is read.
pub(super) const MOST_BOXES: usize = 1 << 20;
/// Largest number of harmonics of a witness.
const MOST_HARMONICS: usize = 512;

/// The JSON text of certificates about one subject.
pub trait Format: Serialize + DeserializeOwned {
    /// Its name, with its version.
    const NAME: &'static str;
    /// The statement of every certificate.
    const STATEMENT: &'static str;

    /// The name and the statement that a certificate has.
    fn head(&self) -> [&str; 2];

    /// Parses a certificate without verifying its claims.
    ///
    /// # Errors
    /// [`NoCertificate`].
    fn parse(text: &str) -> Result<Self, NoCertificate> {
        let read: Self = serde_json::from_str(text)?;
        let [name, _] = read.head();
        match name == Self::NAME {
            true => Ok(read),
            false => Err(NoCertificate::OtherFormat(name.into())),
        }
    }

    /// Its JSON text, with one line per tile so that differences can be read.
    ///
    /// # Errors
    /// None is known: the numbers of a certificate are finite.
    fn text(&self) -> serde_json::Result<String> {
        Ok(serde_json::to_string(self)?.replace("{\"domain\"", "\n{\"domain\"") + "\n")
    }

    /// The problem of a certificate with another statement.
    fn other_statement(&self) -> Vec<String> {
        let [_, statement] = self.head();
        let problem = "its statement is not the one that this format proves";
        if statement == Self::STATEMENT { Vec::new() } else { vec![problem.into()] }
    }
}

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
    /// The subject of the certificate with this text, of any version of its format; `None` for other formats.
    ///
    /// # Errors
    /// The text is not JSON, or names no format.
    pub fn of(text: &str) -> serde_json::Result<Option<Self>> {
        #[derive(Deserialize)]
        struct Named {
            format: String,
        }
        let Named { format } = serde_json::from_str(text)?;
        let beginnings = [
            ("slipmap proof of a point ", Subject::Point),
            ("slipmap proof of a law ", Subject::Law),
            ("slipmap proof ", Subject::Surface),
        ];
        let begins = |(begins, subject)| format.starts_with(begins).then_some(subject);
        Ok(beginnings.into_iter().find_map(begins))
    }
}

/// A certificate that has been parsed but not verified.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    format: String,
    statement: String,
    written_by: String,
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
    /// Its mean over the volume of the tiles.
    pub mean_radius: f64,
    /// Share of the domain in which nothing is claimed; valid if there are no problems.
    pub open_share: f64,
    /// All problems; the certificate is sound if there are none.
    pub problems: Vec<String>,
}

impl Checked {
    /// Verifies that `tiles`, each with its box and its radius, and the boxes `open` divide `domain`, and that
    /// no tile has a doubt, which is worded to follow its number.
    pub(super) fn tiles<T: Sync, Box: AsRef<[[f64; 2]]>>(
        mut problems: Vec<String>,
        domain: &[[f64; 2]],
        tiles: &[T],
        stated: impl Fn(&T) -> (Box, f64),
        open: impl Iterator<Item = Box>,
        doubt: impl Fn(&T) -> Option<String> + Send + Sync,
    ) -> Self {
        let (mut boxes, radii): (Vec<Box>, Vec<f64>) = tiles.iter().map(stated).unzip();
        boxes.extend(open);
        if let Err(fault) = divides(domain, &boxes) {
            problems.push(format!("tiles (counted first) and open boxes do not divide the domain: {fault}"));
        }
        let doubts: Vec<Option<String>> = tiles.par_iter().map(doubt).collect();
        let confirmed = doubts.iter().filter(|doubt| doubt.is_none()).count();
        let numbered = (1..).zip(doubts).filter_map(|(i, doubt)| Some(format!("tile {i} {}", doubt?)));
        problems.extend(numbered);
        let share = |one: &Box| -> f64 {
            let wide = one.as_ref().iter().zip(domain).filter(|(_, [lo, hi])| hi > lo);
            wide.map(|([lo, hi], [from, to])| (hi - lo) / (to - from)).product()
        };
        let shares: Vec<f64> = boxes.iter().map(share).collect();
        let (closed, open) = shares.split_at(tiles.len());
        let sum = |all: &mut dyn Iterator<Item = f64>| all.fold(0.0, |sum, one| sum + one);
        let volume = sum(&mut closed.iter().copied());
        let weighted = sum(&mut closed.iter().zip(&radii).map(|(share, radius)| share * radius));
        Self {
            tiles: tiles.len(),
            confirmed,
            mean_radius: if tiles.is_empty() { 0.0 } else { weighted / volume },
            open_share: sum(&mut open.iter().copied()),
            largest_radius: radii.into_iter().fold(0.0, f64::max),
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
    #[error("is a proof of another format: {0}")]
    OtherFormat(String),
}

impl Format for Certificate {
    const NAME: &'static str = "slipmap proof 1";
    const STATEMENT: &'static str = "With v' = w, w' = -v + D w, D = -C + A/(1 + k s)^2 - 2 b s, s = 1 - v, the orbit \
        from (1, 0) comes back to v = 1 (or runs away) for C < C* and not for C > C*. In the domain of each tile \
        |C* - sum of viscous[m] T_i T_j T_l| <= radius, m = i + 3 (j + 9 l), T Chebyshev polynomials of A, k, b scaled to \
        [-1, 1] over the domain. Integers are multiples of unit; zeros at the end of a list are left out. Cosines and \
        sines are the witness, see the documentation of slipmap::certify::recheck. In the boxes `open` nothing is claimed.";

    fn head(&self) -> [&str; 2] {
        [&self.format, &self.statement]
    }
}

impl Certificate {
    /// The certificate of a surface, written by this program.
    #[must_use]
    pub fn of(surface: &Surface, written_by: &str) -> Self {
        Self {
            format: Self::NAME.into(),
            statement: Self::STATEMENT.into(),
            written_by: written_by.into(),
            unit: UNIT,
            domain: surface.domain,
            open: surface.open().collect(),
            tiles: surface.tiles().map(StoredTile::of).collect(),
        }
    }

    /// Verifies every claim, by [`super::recheck`].
    #[must_use]
    pub fn check(&self) -> Checked {
        let mut problems = self.other_statement();
        if self.unit != UNIT {
            problems.push(format!("its unit is {:e}, not {UNIT:e}", self.unit));
        }
        let stated = |tile: &StoredTile| (tile.domain.ranges(), tile.radius);
        let open = self.open.iter().map(GroupBox::ranges);
        Checked::tiles(problems, &self.domain.ranges(), &self.tiles, stated, open, StoredTile::doubt)
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
        let GroupBox { a, k, b } = self.domain;
        let doubt = recheck::verify(&self.tile()).err()?;
        Some(format!("(A {a:?}, k {k:?}, b {b:?}) claims a radius of {:e}: {doubt}", self.radius))
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
