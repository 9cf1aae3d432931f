//! The physical dimension of the variables of a map, for a machine's SI units.

use super::{Field, Quantity};
use slipmap_machine::Dimension;

/// The dimension of a variable by its name in the map; `None` for pure numbers and codes. Margins
/// are distances in the damping.
pub fn of_variable(name: &str) -> Option<Dimension> {
    match name {
        _ if Field::is_critical(name) || name.starts_with("margin_") => Some(Dimension::Damping),
        _ => Quantity::by_name(name).and_then(|quantity| quantity.about().dimension),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variables_have_their_dimensions() {
        assert_eq!(of_variable("kick_forward"), Some(Dimension::Velocity));
        assert_eq!(of_variable("cycle_multiplier"), None);
        assert_eq!(of_variable("margin_symmetric"), Some(Dimension::Damping));
        assert_eq!(of_variable("margin_simulation"), Some(Dimension::Damping));
        assert_eq!(of_variable("critical_c_symmetric"), Some(Dimension::Damping));
        assert_eq!(of_variable("critical_c_error_simulation"), Some(Dimension::Damping));
        assert_eq!(of_variable("critical_damping_symmetric"), Some(Dimension::Damping));
        assert_eq!(of_variable("verdict_symmetric"), None);
        assert_eq!(of_variable("regime"), None);
    }
}
