//! Machines in SI units: their quantities are the axes of the page in place of a law's parameters.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::refusal::Refusal;
use slipmap_map::machine::{Friction, Machine, Model, Motion, requirement, unit};
use slipmap_map::map::Grid;
use slipmap_model::friction::{Expression, Law, Table};

const BELT_SPEED: &str = "belt_speed";
const DAMPING: &str = "damping";

pub(super) fn motion_of(name: &str) -> Result<Motion, Refusal> {
    let found = Motion::ALL.into_iter().find(|motion| motion.name() == name);
    found.ok_or_else(|| Refusal::malformed(format!("there is no motion `{name}`")))
}

/// Refuses a formula that uses the name of a quantity of the machine.
pub(super) fn check_names(law: &Law) -> Result<(), Refusal> {
    match law.as_written() {
        Law::Expression(formula) => Ok(slipmap_config::check_names(formula)?),
        _ => Ok(()),
    }
}

/// The machine with these values of its quantities. Its law is in SI units; its friction must be legal up to
/// twice the belt speed.
pub(super) fn machine(law: &Law, motion: Motion, at: &BTreeMap<String, f64>) -> Result<Machine, Refusal> {
    check_names(law)?;
    let value = |name: &str| at.get(name).copied();
    let lacks = || {
        let name = Machine::names(law).into_iter().find(|name| value(name).is_none()).unwrap_or_default();
        Refusal::malformed(format!("a machine of the law `{}` also needs {name}", law.name()))
    };
    let machine = Machine::new(motion, law, value).filter(|it| it.normal_force_is_known).ok_or_else(lacks)?;
    check(&machine)?;
    Ok(machine)
}

fn check(machine: &Machine) -> Result<(), Refusal> {
    if let Some((name, value, wanted)) = machine.illegal() {
        let problem = format!("{name} is {value}; it must be {wanted}");
        return Err(Refusal::bad_input(problem, "choose another value"));
    }
    let rest = machine.friction.at_rest();
    if !machine.friction.is_legal_at_rest() {
        let problem = format!("the coefficient of friction at rest is {rest}");
        return Err(Refusal::bad_input(problem, "it must be greater than 0"));
    }
    let fastest = 2.0 * machine.belt_speed;
    match &machine.friction {
        Friction::Formula(formula, parameters) => {
            // In the units in which it was typed, so that an error has its place there.
            Ok(Expression::new(formula.text(), rest)?.check(1.0, parameters, fastest)?)
        }
        Friction::Measured(table) if table.fastest() < fastest => {
            let problem = format!("the data of {} end at slip speed {}", table.origin(), table.fastest());
            Err(Refusal::bad_input(problem, "choose a lower belt speed, or measure farther"))
        }
        Friction::Coefficients(..) | Friction::Measured(_) => Ok(()),
    }
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
        "normal_force" => 1000.0,
        "static_friction" => 0.4,
        "kinetic_friction" => 0.25,
        "strengthening" => 0.0,
        BELT_SPEED => 0.15_f64.min(table.map_or(f64::INFINITY, |table: &Table| 0.2 * table.fastest())),
        // A velocity, as are the Stribeck velocity and most names in a formula.
        _ => 0.05,
    }
}

/// The axes of a machine under a law in SI units, in the format of the axes of a law.
pub(super) fn axes(law: &Law, motion: Motion) -> Value {
    let fastest = match law.as_written() {
        Law::Table(table) => Some(0.5 * table.fastest()),
        _ => None,
    };
    let one = |name: &'static str| {
        let words = name.replace('_', " ").replace("stribeck", "Stribeck");
        let value = usual(name, law);
        let known = law.parameters().iter().all(|parameter| parameter.name != name);
        json!({
            "name": name,
            "symbol": words,
            "words": words,
            "unit": unit(name, motion, law),
            "least": known.then_some(0.0),
            "most": if name == BELT_SPEED { fastest } else { None },
            "open": !requirement(name, 0.0).0,
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
    slipmap_config::machine_keys(law).into_iter().filter(|key| *key != "motion").map(one).collect()
}

/// The quantities of a machine by name.
pub(super) fn at_json(machine: &Machine) -> Value {
    machine.quantities().into_iter().map(|(name, value)| (name.to_owned(), json!(value))).collect()
}

/// The dimensionless law of a machine, and the values of its axes.
pub(super) fn dimensionless(machine: &Machine) -> Result<(Law, Vec<f64>), Refusal> {
    let overflow =
        || Refusal::bad_input("the friction leaves the numbers in dimensionless terms", "check the units");
    let Model { law, point, .. } = machine.model().ok_or_else(overflow)?;
    let values = Grid::coordinates(&law, &point).into_iter().map(|(_, value)| value).collect();
    Ok((law, values))
}
