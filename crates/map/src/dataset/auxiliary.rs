//! Auxiliary variables of a machine's map: its axes, and quantities along them, in SI units.

use super::Value;
use crate::machine::SiUnits;
use crate::map::{AxisRole, Grid, dimension};

/// A variable along some of the axes, stored in one piece.
#[derive(Clone, Debug, PartialEq)]
pub struct Auxiliary {
    /// Its name, one of [`AUXILIARY`].
    pub name: &'static str,
    /// Its values, row-major along its axes.
    pub values: Vec<f64>,
    /// Its attributes, apart from fingerprints.
    pub attributes: Vec<(&'static str, Value)>,
}

/// Name, axis and description of the auxiliary coordinate variables of the CF conventions: axes in SI units.
const COORDINATES: [(&str, AxisRole, &str); 2] = [
    ("belt_speed_si", AxisRole::BeltSpeed, "belt speed"),
    ("damping_si", AxisRole::Damping, "damping coefficient"),
];

/// Name of the variable with the probability that a machine with uncertain quantities may stick-slip, over
/// belt speed and damping.
pub const PROBABILITY: &str = "stick_slip_probability";

/// The names of all auxiliary variables.
pub const AUXILIARY: [&str; 3] = [COORDINATES[0].0, COORDINATES[1].0, PROBABILITY];

/// Positions of the axes of an auxiliary variable; `None` if there is no such variable.
pub fn axes_of(name: &str, grid: &Grid) -> Option<Vec<usize>> {
    let roles = match name {
        PROBABILITY => vec![AxisRole::BeltSpeed, AxisRole::Damping],
        _ => vec![COORDINATES.iter().find(|(known, ..)| *known == name)?.1],
    };
    let position = |role: AxisRole| grid.axes().iter().position(|axis| axis.role == role);
    roles.into_iter().map(position).collect()
}

/// The variable with the probability that a machine may stick-slip, row-major along belt speed and damping,
/// from a number of draws at each belt speed.
pub fn probability(values: Vec<f64>, draws: usize) -> Auxiliary {
    let coordinates: Vec<&str> = COORDINATES.iter().map(|(name, ..)| *name).collect();
    Auxiliary {
        name: PROBABILITY,
        values,
        attributes: vec![
            ("long_name", "probability that the machine may stick-slip".into()),
            ("units", "1".into()),
            ("coordinates", coordinates.join(" ").into()),
            ("draws", Value::Integers(vec![i64::try_from(draws).unwrap_or(i64::MAX)])),
            ("standard_error_at_most", (0.5 / (draws as f64).sqrt()).into()),
        ],
    }
}

/// The number x that a user gave in SI units, from the product (x / unit) * unit, which may differ from x by
/// two units in the last place: the number with the fewest digits within that distance.
fn as_given(product: f64) -> f64 {
    let [up, down] = [f64::next_up, f64::next_down].map(|step| [step(product), step(step(product))]);
    let near = [product, up[0], down[0], up[1], down[1]];
    let digits = |x: &f64| format!("{x:e}").len();
    near.into_iter().min_by_key(digits).unwrap_or(product)
}

/// Belt speeds and dampings of a machine's map in SI units.
pub fn coordinates(grid: &Grid, si: &SiUnits) -> Vec<Auxiliary> {
    let along = |(name, role, words): (&'static str, AxisRole, &str)| {
        let axis = grid.axes().iter().find(|axis| axis.role == role)?;
        let dimension = dimension::of_axis(role)?;
        Some(Auxiliary {
            name,
            values: axis.values.iter().map(|value| as_given(value * si.factor(dimension))).collect(),
            attributes: vec![("long_name", words.into()), ("units", si.unit(dimension).into())],
        })
    };
    COORDINATES.into_iter().filter_map(along).collect()
}

/// The SI attributes of a variable over the first `rank` axes of the grid: its auxiliary coordinates, by the
/// CF conventions, and, if it has a physical dimension, its SI unit and the factor from its numbers to it.
pub fn attributes_of(name: &str, rank: usize, grid: &Grid, si: &SiUnits) -> Vec<(&'static str, Value)> {
    let has = |coordinate: &&str| axes_of(coordinate, grid).is_some_and(|axes| axes[0] < rank);
    let coordinates: Vec<&str> = COORDINATES.iter().map(|(name, ..)| *name).filter(has).collect();
    let mut attributes = vec![("coordinates", coordinates.join(" ").into())];
    if let Some(dimension) = dimension::of_variable(name) {
        attributes.push(("si_factor", si.factor(dimension).into()));
        attributes.push(("si_units", si.unit(dimension).into()));
    }
    attributes
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_numbers::random::Random;

    /// Of random decimals and units.
    #[test]
    fn numbers_in_si_units_are_those_that_were_given() {
        let mut random = Random(5);
        let mut differ = 0;
        for _ in 0..20_000 {
            let given = (random.unit() * 1e6).round() / 1e5;
            let unit = 0.01 + random.unit();
            let product = given / unit * unit;
            differ += u32::from(product != given);
            assert_eq!(as_given(product), given);
        }
        assert!(differ > 1000, "{differ}");
        for kept in [0.0, 1.0 / 3.0, f64::MIN_POSITIVE, 1e300] {
            assert!((as_given(kept) - kept).abs() <= 2.0 * f64::EPSILON * kept, "{kept}");
        }
    }
}
