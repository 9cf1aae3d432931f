//! Machines in SI units: their quantities are the axes of the page in place of a law's parameters.

use serde_json::{Value, json};

use super::refusal::Refusal;
use slipmap_machine::{
    AREA, BELT_SPEED, Coefficients, DAMPING, DAMPING_RATIO, FREQUENCY, Machine, Model, Motion, NORMAL_FORCE,
    Normal, PRESSURE, RADIUS, requirement, unit,
};
use slipmap_model::friction::{Law, Table};

pub(super) fn motion_of(name: &str) -> Result<Motion, Refusal> {
    let found = Motion::ALL.into_iter().find(|motion| motion.name() == name);
    found.ok_or_else(|| Refusal::malformed(format!("there is no motion `{name}`")))
}

/// The names of the quantities of a machine, of which those `given` stand in place of others. Friction that is a force
/// has no normal force.
pub(super) fn names(law: &Law, given: &[String], forces: bool) -> Vec<&'static str> {
    let names = Machine::names(law, is_given(given)).into_iter();
    names.filter(|name| !(forces && *name == NORMAL_FORCE)).collect()
}

/// Whether a quantity is one of those that stand in place of others.
fn is_given(given: &[String]) -> impl Fn(&str) -> bool {
    |name| given.iter().any(|it| it == name)
}

/// The default value of a quantity; the defaults describe a brake pad.
fn usual(name: &str, law: &Law) -> f64 {
    let table = match law.as_written() {
        Law::Table(table) => Some(table),
        _ => None,
    };
    match name {
        "mass" => 2.0,
        "stiffness" => 5.05e5,
        DAMPING => 60.0,
        NORMAL_FORCE => 1000.0,
        FREQUENCY => 80.0,
        DAMPING_RATIO => 0.03,
        PRESSURE => 1e6,
        AREA => 1e-3,
        RADIUS => 0.1,
        Coefficients::EXPONENT => 1.0,
        "static_friction" => 0.4,
        "kinetic_friction" => 0.25,
        "strengthening" => 0.0,
        BELT_SPEED => 0.15_f64.min(table.map_or(f64::INFINITY, |table: &Table| 0.2 * table.fastest())),
        // A velocity, as are the Stribeck velocity and most names in a formula.
        _ => 0.05,
    }
}

/// The axes of a machine under a law in SI units, in the format of the axes of a law.
pub(super) fn axes(law: &Law, motion: Motion, given: &[String], forces: bool) -> Value {
    let fastest = match law.as_written() {
        Law::Table(table) => Some(0.5 * table.fastest()),
        _ => None,
    };
    let normal = Normal::of(forces, is_given(given)(RADIUS));
    let one = |name: &'static str| {
        let words = name.replace('_', " ").replace("stribeck", "Stribeck");
        let value = usual(name, law);
        let is_formula = matches!(law.as_written(), Law::Expression(_));
        let known = !is_formula || law.parameters().iter().all(|parameter| parameter.name != name);
        json!({
            "name": name,
            "symbol": words,
            "words": words,
            "unit": unit(name, motion, law, normal),
            "least": known.then_some(if name == Coefficients::EXPONENT { 1.0 } else { 0.0 }),
            "most": if name == BELT_SPEED { fastest } else { None },
            "open": name != Coefficients::EXPONENT && !requirement(name, 0.0).0,
            "from": 0.0,
            // Not above friction at rest.
            "to": match name {
                "kinetic_friction" => usual("static_friction", law),
                _ if value > 0.0 => 2.0 * value,
                _ => 0.1,
            },
            "value": value,
        })
    };
    names(law, given, forces).into_iter().map(one).collect()
}

/// The dimensionless law of a machine, and the values of its axes.
pub(super) fn dimensionless(machine: &Machine) -> Result<(Law, Vec<f64>), Refusal> {
    let overflow =
        || Refusal::bad_input("the friction leaves the numbers in dimensionless terms", "check the units");
    let Model { law, point, .. } = machine.model().ok_or_else(overflow)?;
    let values = law.coordinates(&point).into_iter().map(|(_, value)| value).collect();
    Ok((law, values))
}
