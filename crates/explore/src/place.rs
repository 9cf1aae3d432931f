//! The parameter point of a request: the friction law, and a value for each of its axes; or a machine in SI
//! units, whose quantities are the axes.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::{Value, json};

use super::law::law_of;
use super::quantities;
use super::refusal::Refusal;
use slipmap_config::{About, FitText, LawText, MachineJob, check_law, machine_of, point_of, with_axes};
use slipmap_machine::risk::Spread;
use slipmap_machine::{BELT_SPEED, DAMPING, Dimension, Machine};
use slipmap_map::Shown;
use slipmap_model::friction::Law;
use slipmap_model::point::Point;
use slipmap_page::units::UnitSystem;

/// A law and a value for each of its axes, by name; with a motion, a machine in SI units. Other names are
/// ignored: they belong to the law that was shown before.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct Place {
    pub(super) law: LawText,
    pub(super) at: BTreeMap<String, f64>,
    /// The motion of a machine: then the law and the values are in SI units.
    #[serde(default)]
    pub(super) motion: Option<String>,
    /// The units of its figures, by quantity, where they are not those of SI: name and size.
    #[serde(default)]
    units: BTreeMap<String, (String, f64)>,
    /// The spreads of its uncertain quantities: a standard deviation, or both ends of a range.
    #[serde(default)]
    spread: BTreeMap<String, Vec<f64>>,
    /// The title of what it began with.
    #[serde(default)]
    pub(super) title: Option<String>,
}

impl Place {
    /// The machine, if the place has a motion.
    pub(super) fn machine(&self) -> Result<Option<Machine>, Refusal> {
        let Some(motion) = &self.motion else { return Ok(None) };
        let motion = quantities::motion_of(motion)?;
        let law = law_of(&self.law, About::Machine(motion))?;
        let names = quantities::names(&law, &self.law.axes, self.law.holds_forces(&law));
        let value = |name: &str| self.at.get(name).copied().filter(|_| names.contains(&name));
        if let Some(name) = names.iter().find(|name| value(name).is_none()) {
            let problem = format!("a machine of the law `{}` also needs {name}", law.name());
            return Err(Refusal::malformed(problem));
        }
        Ok(Some(machine_of(motion, &law, value, value)?))
    }

    /// The machine with its units, its title, and the spreads of what is uncertain. A fitted quantity that was moved
    /// has no error of the fit.
    pub(super) fn job(&self) -> Result<Option<MachineJob>, Refusal> {
        let Some(machine) = self.machine()? else { return Ok(None) };
        let fitted = self.law.fit.as_ref().and_then(FitText::spreads).unwrap_or_default();
        let of_fit = |name: &str, value: f64| {
            let found = fitted.iter().find(|(known, fitted, _)| *known == name && *fitted == value)?;
            Some(found.2)
        };
        let own = |name: &str| match self.spread.get(name)?[..] {
            [sd] => Some(Spread::Normal { sd }),
            [min, max] => Some(Spread::Uniform { min, max }),
            _ => None,
        };
        let quantities = machine.quantities();
        let uncertain = quantities
            .iter()
            .filter_map(|(name, value)| Some((*name, of_fit(name, *value).or_else(|| own(name))?)));
        let units = quantities.iter().filter_map(|(name, _)| {
            let (unit, size) = self.units.get(*name)?.clone();
            Some((*name, Some(Shown { unit, size })))
        });
        let (uncertain, units, title) = (uncertain.collect(), units.collect(), self.title.clone());
        Ok(Some(MachineJob { machine, varied: Vec::new(), uncertain, units, conversions: Vec::new(), title }))
    }

    /// The units of the numbers of its figures.
    pub(super) fn units(&self) -> Result<UnitSystem, Refusal> {
        let Some(machine) = self.machine()? else { return Ok(UnitSystem::default()) };
        let shown = [(Dimension::Velocity, BELT_SPEED), (Dimension::Damping, DAMPING)].into_iter();
        let shown = shown.filter_map(|(dimension, name)| {
            let (unit, size) = self.units.get(name)?.clone();
            Some((dimension, Shown { unit, size }))
        });
        Ok(UnitSystem::of_machine(machine.units()).shown_in(shown.collect()))
    }

    /// The dimensionless law and the values of its axes in their order, each legal. It has the parameters
    /// `exponent` and `drop` if they are `wanted` as axes, or are not what a law without them has.
    pub(super) fn read(&self, wanted: &[&str]) -> Result<(Law, Vec<f64>), Refusal> {
        if let Some(machine) = self.machine()? {
            let (law, values) = quantities::dimensionless(&machine)?;
            // Units that are far too large or small give numbers that are illegal for every law.
            point_of(&law, &values)?;
            return Ok((law, values));
        }
        let differs = |name: &str, from: f64| self.at.get(name).is_some_and(|value| *value != from);
        let law = with_all(law_of(&self.law, About::Oscillator)?, |name| {
            wanted.contains(&name) || differs(name, if name == "drop" { 0.0 } else { 1.0 })
        });
        let value = |name: &&str| {
            let missing = || Refusal::malformed(format!("the law `{}` also needs {name}", law.name()));
            self.at.get(*name).copied().ok_or_else(missing)
        };
        let values = law.axis_names().iter().map(value).collect::<Result<Vec<f64>, Refusal>>()?;
        point_of(&law, &values)?;
        Ok((law, values))
    }

    /// The law and the point, at which the law is legal.
    pub(super) fn point(&self) -> Result<(Law, Point), Refusal> {
        let (law, values) = self.read(&[])?;
        let point = point_of(&law, &values)?;
        // The law of a machine has been checked in SI units.
        if self.motion.is_none() {
            check_law(&law, &point)?;
        }
        Ok((law, point))
    }
}

/// The law with the parameters `exponent` and `drop`, each if it is `wanted` and the law may have it.
pub(super) fn with_all(law: Law, wanted: impl Fn(&str) -> bool) -> Law {
    let law = if wanted("exponent") { law.with_exponent() } else { law };
    with_axes(law.clone(), wanted).unwrap_or(law)
}

/// The values of a point by the names of the law's axes.
pub(super) fn at_json(law: &Law, point: &Point) -> Value {
    law.coordinates(point).into_iter().map(|(name, value)| (name.to_owned(), json!(value))).collect()
}
