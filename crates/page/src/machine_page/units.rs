//! The units in which the page tells quantities: those of the configuration, or those of SI.

use slipmap_figure::text::Rich;
use slipmap_machine::{BELT_SPEED, Machine, Motion};
use slipmap_map::Shown;

/// The units of a configuration, by quantity; `None` is the SI unit.
pub type Written = [(&'static str, Option<Shown>)];

/// rad/s.
const RPM: f64 = std::f64::consts::TAU / 60.0;
/// Parts of units of speed per angle.
const PER_ANGLE: [&str; 8] = ["rpm", "RPM", "rad", "rev", "deg", "1/min", "U/min", "r/min"];

/// A unit in which a number in SI units is shown: its name and its size in SI.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unit<'a> {
    pub(super) name: &'a str,
    pub(super) size: f64,
    /// Another unit with its size, in which a speed on a disc is told, too.
    pub(super) also: Option<(&'static str, f64)>,
}

/// The SI unit of this name.
impl<'a> From<&'a str> for Unit<'a> {
    fn from(name: &'a str) -> Self {
        Self { name, size: 1.0, also: None }
    }
}

impl<'a> Unit<'a> {
    /// The unit in which a quantity of a machine was written.
    pub(super) fn of(machine: &Machine, written: &'a Written, quantity: &str) -> Self {
        let shown = written.iter().find(|(known, _)| *known == quantity);
        let shown = shown.and_then(|(_, shown)| shown.as_ref());
        let radius = machine.given.radius_of_speeds().filter(|_| quantity == BELT_SPEED);
        let per_angle = |name: &str| PER_ANGLE.iter().any(|it| name.contains(it));
        let also = radius.and_then(|radius| match (machine.motion, shown) {
            (Motion::Translation, Some(shown)) if per_angle(&shown.unit) => Some(("m/s", 1.0)),
            (Motion::Translation, _) => Some(("rpm", RPM * radius)),
            (Motion::Rotation, Some(shown)) if !per_angle(&shown.unit) => Some(("rad/s", 1.0)),
            (Motion::Rotation, _) => None,
        });
        match shown {
            Some(Shown { unit, size }) => Self { name: unit, size: *size, also },
            None => Self { also, ..machine.unit(quantity).into() },
        }
    }

    /// The same unit where its name is written later.
    pub(super) fn unnamed(self) -> Self {
        Self { name: "", also: None, ..self }
    }

    /// A number in SI units, to `digits` digits: "60 rpm".
    pub(super) fn number(self, value: f64, digits: usize) -> Rich {
        let text = Rich::number(value / self.size, digits).with_unit(self.name);
        self.with_other(text, value, digits)
    }

    /// The text of a number with the same in the other unit.
    fn with_other(self, text: Rich, value: f64, digits: usize) -> Rich {
        match self.also {
            Some((name, size)) => {
                let other = Rich::number(value / size, digits).with_unit(name);
                text.then(" (").then(other).then(")")
            }
            None => text,
        }
    }
}

/// A number in SI units and its error, where that reaches the digits: "171 ± 20 N s/m".
pub(super) fn with_error<'a>(value: f64, error: f64, digits: usize, unit: impl Into<Unit<'a>>) -> Rich {
    let unit = unit.into();
    let text = Rich::with_error(value / unit.size, error / unit.size, digits).with_unit(unit.name);
    unit.with_other(text, value, digits)
}
