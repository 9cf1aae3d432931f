//! Maps about a machine are shown in its SI units.

use super::text::{Rich, rich};
use crate::machine::{MOTION_ATTRIBUTE, Machine, Motion, SI_ATTRIBUTE};
use crate::map::{Axis, AxisRole};
use crate::store::{MapFile, Value};

/// The machine that a map is about; `None` for a map in dimensionless terms.
pub(super) fn machine(map: &MapFile) -> Option<Machine> {
    let Some(Value::Reals(numbers)) = map.attributes().get(SI_ATTRIBUTE) else { return None };
    let name = map.text(MOTION_ATTRIBUTE)?;
    let motion = Motion::ALL.into_iter().find(|motion| motion.name() == name)?;
    Some(Machine::from_array(motion, numbers.as_slice().try_into().ok()?))
}

/// How an axis is written on figures.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct AxisName {
    /// What it is called.
    pub(super) name: Rich,
    /// What the numbers along it are multiplied by.
    pub(super) unit: f64,
}

/// How an axis of a map is written.
pub(super) fn axis_name(map: &MapFile, axis: &Axis) -> AxisName {
    let shown = |words: &str, unit: f64, of: &str| AxisName { name: rich(&format!("{words}, {of}")), unit };
    match machine(map).map(|machine| (machine.units(), machine.motion)) {
        Some((units, motion)) if axis.role == AxisRole::BeltSpeed => {
            shown("belt speed", units.velocity, motion.velocity())
        }
        // Maps of machines have eps = 1.
        Some((units, motion)) if axis.role == AxisRole::Damping => {
            shown("damping", units.damping, motion.damping())
        }
        _ => AxisName { name: Rich::symbol(&axis.name), unit: 1.0 },
    }
}
