//! The physical dimension of the axes and variables of a map, for the conversion of dimensionless numbers to
//! a machine's SI units.

use super::AxisRole;
use crate::machine::Dimension;

/// The dimension of an axis; `None` for eps and for the parameters of friction laws. Those are pure numbers
/// or, in laws given by formula, have the formula's units.
pub(crate) fn of_axis(role: AxisRole) -> Option<Dimension> {
    match role {
        AxisRole::BeltSpeed => Some(Dimension::Velocity),
        AxisRole::Damping => Some(Dimension::Damping),
        AxisRole::Epsilon | AxisRole::Law(_) => None,
    }
}

/// The dimension of a variable by its name in the map; `None` for pure numbers and codes. Margins of
/// closed-form tests are distances in the damping; `margin_simulation` is the scaled grazing margin m / V, a
/// pure number.
pub(crate) fn of_variable(name: &str) -> Option<Dimension> {
    match name {
        "margin_simulation" => None,
        "stick_time" | "slip_time" | "cycle_period" => Some(Dimension::Time),
        "landing_x1" | "cycle_amplitude_x1" => Some(Dimension::Length),
        "cycle_amplitude_x2" | "boundary_velocity" | "kick_forward" | "kick_backward" => {
            Some(Dimension::Velocity)
        }
        _ if name.starts_with("critical_c_") || name.starts_with("margin_") => Some(Dimension::Damping),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Field, Quantity};

    #[test]
    fn every_variable_of_a_map_has_its_dimension() {
        // A variable without one is a pure number; these are all of them.
        let pure = [
            "crossings",
            "cycle_multiplier",
            "slip_cycles",
            "boundary_multiplier",
            "epsilon_limit",
            // A damping by a velocity or by a pure number, which has no unit of its own here.
            "dc_d",
        ];
        for quantity in Field::ALL.into_iter().flat_map(|field| Quantity::of(field, 1, 0)) {
            let dimension = of_variable(quantity.name());
            assert_eq!(dimension.is_none(), pure.contains(&quantity.name()), "{}", quantity.name());
        }
        assert_eq!(of_variable("critical_c_symmetric"), Some(Dimension::Damping));
        assert_eq!(of_variable("verdict_symmetric"), None);
        assert_eq!(of_variable("regime"), None);
    }
}
