//! The units in which the page tells quantities: those of the configuration, or those of SI.

use slipmap_figure::text::Rich;
use slipmap_map::machine::{Dimension, Machine};
use slipmap_map::map::Shown;

/// The units of a configuration, by quantity; `None` is the SI unit.
pub type Written = [(&'static str, Option<Shown>)];

/// A unit and its size in SI.
#[derive(Clone, Debug)]
pub(super) struct Unit {
    pub(super) name: String,
    pub(super) size: f64,
}

impl Unit {
    /// The unit of a quantity of this dimension.
    pub(super) fn of(machine: &Machine, written: &Written, quantity: &str, dimension: Dimension) -> Self {
        let shown =
            written.iter().find(|(known, _)| *known == quantity).and_then(|(_, shown)| shown.as_ref());
        match shown {
            Some(Shown { unit, size }) => Self { name: unit.clone(), size: *size },
            None => Self { name: machine.motion.unit(dimension).to_owned(), size: 1.0 },
        }
    }

    /// A number in SI in this unit: "60 rpm".
    pub(super) fn quantity(&self, value: f64) -> Rich {
        Rich::number(value / self.size, 4).with_unit(&self.name)
    }
}
