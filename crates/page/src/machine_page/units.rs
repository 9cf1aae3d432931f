//! The units in which the page tells quantities: those of the configuration, or those of SI.

use slipmap_figure::text::Rich;
use slipmap_machine::Machine;
use slipmap_map::Shown;

/// The units of a configuration, by quantity; `None` is the SI unit.
pub type Written = [(&'static str, Option<Shown>)];

/// A unit in which a number in SI units is shown: its name and its size in SI.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unit<'a> {
    pub(super) name: &'a str,
    pub(super) size: f64,
}

/// The SI unit of this name.
impl<'a> From<&'a str> for Unit<'a> {
    fn from(name: &'a str) -> Self {
        Self { name, size: 1.0 }
    }
}

impl<'a> Unit<'a> {
    /// The unit in which a quantity of a machine was written.
    pub(super) fn of(machine: &Machine, written: &'a Written, quantity: &str) -> Self {
        let shown = written.iter().find(|(known, _)| *known == quantity);
        match shown.and_then(|(_, shown)| shown.as_ref()) {
            Some(Shown { unit, size }) => Self { name: unit, size: *size },
            None => machine.unit(quantity).into(),
        }
    }

    /// The same unit where its name is written later.
    pub(super) fn unnamed(self) -> Self {
        Self { name: "", ..self }
    }

    /// A number in SI units, to `digits` digits: "60 rpm".
    pub(super) fn number(self, value: f64, digits: usize) -> Rich {
        Rich::number(value / self.size, digits).with_unit(self.name)
    }
}

/// A number in SI units and its error, where that reaches the digits: "171 ± 20 N s/m".
pub(super) fn with_error<'a>(value: f64, error: f64, digits: usize, unit: impl Into<Unit<'a>>) -> Rich {
    let Unit { name, size } = unit.into();
    Rich::with_error(value / size, error / size, digits).with_unit(name)
}
