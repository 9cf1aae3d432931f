//! The friction of a machine: its coefficient of friction as a function of the slip speed, in SI units.

use super::Units;
use slipmap_model::friction::{Expression, Fall, Law, Table};
use slipmap_model::point::LawParameters;

/// Coefficients of a built-in law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    /// mu_s > 0.
    pub static_friction: f64,
    /// mu_k in [0, mu_s].
    pub kinetic_friction: f64,
    /// v_s > 0, m/s; of no use in the law `coulomb`.
    pub stribeck_velocity: f64,
    /// Strengthening of the coefficient of friction at high speed, >= 0: per m/s or per (m/s)^2, by the law's
    /// [`Strengthening`](slipmap_model::friction::Strengthening).
    pub strengthening: f64,
    /// Exponent of the fall, from 1 to 100; of use in the exponential law that has it.
    pub exponent: f64,
}

impl Coefficients {
    /// Their names, in the order of the fields.
    pub const NAMES: [&str; 5] =
        ["static_friction", "kinetic_friction", "stribeck_velocity", "strengthening", Self::EXPONENT];
    /// The name of the exponent, here and as a parameter of the law.
    pub const EXPONENT: &str = "exponent";

    /// The names of those that a law has.
    pub fn names(law: &Law) -> impl Iterator<Item = &'static str> {
        let is_coulomb = *law.as_written() == Law::Coulomb;
        let has_exponent = law.parameters().iter().any(|parameter| parameter.name == Self::EXPONENT);
        Self::NAMES.into_iter().filter(move |name| match *name {
            "stribeck_velocity" => !is_coulomb,
            Self::EXPONENT => has_exponent,
            _ => true,
        })
    }

    /// The numbers in the order of the fields.
    pub(crate) fn to_array(self) -> [f64; 5] {
        [
            self.static_friction,
            self.kinetic_friction,
            self.stribeck_velocity,
            self.strengthening,
            self.exponent,
        ]
    }

    /// The coefficients of an array as of `Coefficients::to_array`.
    pub fn from_array(
        [static_friction, kinetic_friction, stribeck_velocity, strengthening, exponent]: [f64; 5],
    ) -> Self {
        Self { static_friction, kinetic_friction, stribeck_velocity, strengthening, exponent }
    }

    /// What the kinetic friction must be.
    pub const KINETIC: &str = "from 0 to static_friction";
}

/// The coefficient of friction as a function of the slip speed (m/s; for a rotation rad/s).
#[derive(Clone, Debug, PartialEq)]
pub enum Friction {
    /// A built-in law and its coefficients.
    Coefficients(Law, Coefficients),
    /// A formula in the slip speed u, and the values of the names in it.
    Formula(Expression, LawParameters),
    /// Measured coefficients.
    Measured(Table),
}

impl Friction {
    /// The friction of a law in SI units with these values of its quantities; `None` where one is absent.
    pub(super) fn new(law: &Law, value: impl Fn(&str) -> Option<f64>) -> Option<Self> {
        Some(match law.as_written() {
            Law::Expression(formula) => {
                let values = formula.parameters().iter().map(|parameter| value(parameter.name));
                let values = values.collect::<Option<Vec<f64>>>()?;
                Friction::Formula(formula.clone(), LawParameters::new(&values))
            }
            Law::Table(table) => Friction::Measured(table.clone()),
            law => {
                let known: Vec<&str> = Coefficients::names(law).collect();
                let number = |name| if known.contains(&name) { value(name) } else { Some(1.0) };
                let [rest, kinetic, velocity, rise, exponent] = Coefficients::NAMES.map(number);
                let numbers = [rest?, kinetic?, velocity?, rise?, exponent?];
                Friction::Coefficients(law.clone(), Coefficients::from_array(numbers))
            }
        })
    }

    /// Name of the law in configurations.
    pub fn law_name(&self) -> &'static str {
        match self {
            Friction::Coefficients(law, _) => law.name(),
            Friction::Formula(..) => "expression",
            Friction::Measured(_) => "table",
        }
    }

    /// The coefficient of friction at rest.
    pub fn at_rest(&self) -> f64 {
        match self {
            Friction::Coefficients(_, coefficients) => coefficients.static_friction,
            Friction::Formula(formula, _) if formula.may_drop() => formula.static_level(),
            Friction::Formula(formula, parameters) => formula.at_onset(parameters),
            Friction::Measured(table) => table.static_level(),
        }
    }

    /// The dimensionless law and the values of its parameters; `None` if a formula or data overflow in these
    /// units.
    pub(crate) fn dimensionless(&self, units: &Units) -> Option<(Law, LawParameters)> {
        let velocity = units.velocity;
        match self {
            Friction::Coefficients(law, coefficients) => {
                let of = Fall {
                    kinetic: coefficients.kinetic_friction / coefficients.static_friction,
                    width: coefficients.stribeck_velocity,
                    strengthening: coefficients.strengthening / coefficients.static_friction,
                    exponent: coefficients.exponent,
                };
                let parameters = (law.built_in()?.parameters_of)(&of, velocity);
                Some((law.clone(), parameters))
            }
            Friction::Formula(formula, parameters) => {
                Some((Law::Expression(formula.in_units(velocity, self.at_rest())), *parameters))
            }
            Friction::Measured(table) => {
                Some((Law::Table(table.in_units(velocity, 1.0).ok()?), LawParameters::new(&[])))
            }
        }
    }

    /// The numbers of the friction, with their names.
    pub(crate) fn quantities(&self) -> Vec<(&'static str, f64)> {
        match self {
            Friction::Coefficients(law, coefficients) => {
                let known: Vec<&str> = Coefficients::names(law).collect();
                let all = Coefficients::NAMES.into_iter().zip(coefficients.to_array());
                all.filter(|(name, _)| known.contains(name)).collect()
            }
            Friction::Formula(formula, parameters) => {
                let names = formula.parameters().iter().map(|parameter| parameter.name);
                names.zip(parameters.as_slice().iter().copied()).collect()
            }
            Friction::Measured(_) => Vec::new(),
        }
    }

    /// Sets the number at this position among [`Friction::quantities`].
    pub(super) fn set(&mut self, position: usize, value: f64) {
        match self {
            Friction::Coefficients(law, coefficients) => {
                let mut numbers = coefficients.to_array();
                let name = Coefficients::names(law).nth(position);
                let place = Coefficients::NAMES.iter().position(|known| Some(*known) == name);
                numbers[place.unwrap_or(position)] = value;
                *coefficients = Coefficients::from_array(numbers);
            }
            Friction::Formula(_, parameters) => parameters.set(position, value),
            Friction::Measured(_) => {}
        }
    }

    /// Whether the static friction is one of a machine.
    pub fn is_legal_at_rest(&self) -> bool {
        let level = self.at_rest();
        level > 0.0 && level.is_finite()
    }

    /// Whether friction has a finite slope as slip begins, as an exponent below 1 has not.
    pub(super) fn has_slope_at_rest(&self) -> bool {
        match self {
            Friction::Formula(formula, parameters) => {
                Law::Expression(formula.clone()).curve(1.0, parameters).weakening(0.0).is_finite()
            }
            _ => true,
        }
    }
}
