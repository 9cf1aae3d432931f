//! Machines in SI units: their quantities are the axes of the page in place of a law's parameters.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::refusal::Refusal;
use slipmap_map::machine::{Coefficients, Dimension, Friction, Machine, Motion, requirement};
use slipmap_map::map::Grid;
use slipmap_model::friction::{Expression, Law, Strengthening, Table};
use slipmap_model::point::LawParameters;

/// The quantities that are axes of a map.
pub(super) const BELT_SPEED: &str = "belt_speed";
pub(super) const DAMPING: &str = "damping";

/// Whether machines that differ in this quantity share their units and their dimensionless law.
pub(super) fn is_shared(name: &str) -> bool {
    [BELT_SPEED, DAMPING].contains(&name)
}

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
    let value = |name: &str| {
        let missing =
            || Refusal::malformed(format!("a machine of the law `{}` also needs {name}", law.name()));
        at.get(name).copied().ok_or_else(missing)
    };
    let friction = match law.as_written() {
        Law::Expression(formula) => {
            let values = formula.parameters().iter().map(|parameter| value(parameter.name));
            Friction::Formula(formula.clone(), LawParameters::new(&values.collect::<Result<Vec<f64>, _>>()?))
        }
        Law::Table(table) => Friction::Measured(table.clone()),
        _ => {
            let known: Vec<&str> = Coefficients::names(law).collect();
            let number = |name| if known.contains(&name) { value(name) } else { Ok(1.0) };
            let [rest, kinetic, velocity, rise] = Coefficients::NAMES.map(number);
            let numbers = [rest?, kinetic?, velocity?, rise?];
            Friction::Coefficients(law.as_written().clone(), Coefficients::from_array(numbers))
        }
    };
    let machine = Machine {
        motion,
        mass: value("mass")?,
        stiffness: value("stiffness")?,
        damping: value(DAMPING)?,
        normal_force: value("normal_force")?,
        normal_force_is_known: true,
        friction,
        belt_speed: value(BELT_SPEED)?,
    };
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

/// The law of a machine's friction in SI units.
pub(super) fn law_of(friction: &Friction) -> Law {
    match friction {
        Friction::Coefficients(law, _) => law.clone(),
        Friction::Formula(formula, _) => Law::Expression(formula.clone()),
        Friction::Measured(table) => Law::Table(table.clone()),
    }
}

/// The unit of a quantity; the units of the names in a formula are not known.
fn unit(name: &str, motion: Motion, law: &Law) -> &'static str {
    match name {
        "strengthening" => match (law.built_in().map(|law| law.strengthening), motion) {
            (Some(Strengthening::Quadratic), Motion::Translation) => "s²/m²",
            (Some(Strengthening::Quadratic), Motion::Rotation) => "s²/rad²",
            (Some(Strengthening::Linear) | None, Motion::Translation) => "s/m",
            (Some(Strengthening::Linear) | None, Motion::Rotation) => "s/rad",
        },
        _ => Dimension::of_quantity(name).map_or("", |dimension| motion.unit(dimension)),
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
            "to": if value > 0.0 { 2.0 * value } else { 0.1 },
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
pub(super) fn dimensionless(machine: &Machine, small: bool) -> Result<(Law, Vec<f64>), Refusal> {
    let overflow =
        || Refusal::bad_input("the friction leaves the numbers in dimensionless terms", "check the units");
    let model = machine.model().ok_or_else(overflow)?;
    let law = if small { model.law.read_as_small() } else { model.law };
    let values = Grid::coordinates(&law, &model.point).into_iter().map(|(_, value)| value).collect();
    Ok((law, values))
}
