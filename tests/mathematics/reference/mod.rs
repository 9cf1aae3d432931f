//! The reference tables of `tests/data`, made by `scripts/evidence/reference.py` in 150 to 200 bit arithmetic that
//! shares nothing with the crate. Their numbers are correct to f64 rounding, and so are the parameters:
//! parsing a column gives the very f64 that the reference used.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;
use slipmap::friction::Law;
use slipmap::point::Point;

/// A row of `critical_damping.csv`.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct CriticalPoint {
    pub epsilon: f64,
    pub alpha: f64,
    pub beta: f64,
    pub gamma: f64,
    #[serde(rename = "V")]
    pub belt_speed: f64,
    /// Damping at which the grazing margin vanishes.
    pub critical_c: f64,
}

/// A row of `margins.csv`: the fate of the orbit from the exit point.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct MarginPoint {
    pub epsilon: f64,
    pub alpha: f64,
    pub beta: f64,
    pub gamma: f64,
    #[serde(rename = "c")]
    pub damping: f64,
    #[serde(rename = "V")]
    pub belt_speed: f64,
    /// Scaled grazing margin m / V of the lower flow continued beyond the belt line; `None` where |D| >= 2
    /// along it, or where it is singular.
    pub margin: Option<f64>,
    /// x2' at the first return to the belt line from below; `None` for [`ReferenceFate::Inward`].
    pub landing_speed: Option<f64>,
    pub fate: ReferenceFate,
    /// Time from the exit point to the landing; this and the next two are `None` unless the orbit sticks.
    pub slip_time: Option<f64>,
    /// Time from the landing to the exit point.
    pub stick_time: Option<f64>,
    pub landing_x1: Option<f64>,
}

/// The fates in the reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReferenceFate {
    /// It sticks at its first return.
    Sticks,
    /// It crosses the belt line once and sticks when it comes back to it.
    SticksFromAbove,
    /// It crosses and crosses back, and does not stick in six more loops.
    CrossesForever,
    /// It never comes back to the belt line.
    Inward,
}

impl CriticalPoint {
    /// The point of parameter space at damping `c`.
    pub fn at(&self, c: f64) -> Point {
        stribeck(self.epsilon, self.alpha, self.beta, self.gamma, self.belt_speed, c)
    }
}

impl MarginPoint {
    /// The point of parameter space.
    pub fn point(&self) -> Point {
        stribeck(self.epsilon, self.alpha, self.beta, self.gamma, self.belt_speed, self.damping)
    }
}

fn stribeck(epsilon: f64, alpha: f64, beta: f64, gamma: f64, belt_speed: f64, damping: f64) -> Point {
    Law::Stribeck.point(epsilon, &[alpha, beta, gamma], belt_speed, damping).unwrap()
}

/// All rows of `critical_damping.csv`.
pub fn critical_points() -> Vec<CriticalPoint> {
    rows("critical_damping.csv")
}

/// All rows of `columns.csv`, which `scripts/evidence/columns.c` wrote.
pub fn column_points() -> Vec<CriticalPoint> {
    rows("columns.csv")
}

/// All rows of the table in the format of `columns.csv` that the variable SLIPMAP_COLUMNS names.
pub fn other_column_points() -> Vec<CriticalPoint> {
    let path = std::env::var("SLIPMAP_COLUMNS").expect("SLIPMAP_COLUMNS names no file");
    rows(&path)
}

/// All rows of `margins.csv`.
pub fn margin_points() -> Vec<MarginPoint> {
    rows("margins.csv")
}

/// The path of a table.
pub fn data_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// All rows of one file.
pub fn rows<Row: DeserializeOwned>(name: &str) -> Vec<Row> {
    let read = || -> Result<Vec<Row>, csv::Error> {
        csv::ReaderBuilder::new().comment(Some(b'#')).from_path(data_path(name))?.into_deserialize().collect()
    };
    read().unwrap_or_else(|error| panic!("{name}: {error}"))
}
