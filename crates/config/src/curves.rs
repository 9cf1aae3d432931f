//! The planes of a configuration in which a run stores curves of codimension one.

use super::machine::in_si;
use super::source::{ConfigError, Node, Section, Shape};
use super::{choice, nearest, refuse_unknown_keys};
use slipmap_map::{Axis, CURVE_COLUMNS, Grid, Plane};

pub(super) const KEYS: [&str; 1] = ["planes"];

const PLANE_KEYS: [&str; 3] = ["x", "y", "at"];

const EXAMPLE: &str = "{ x = \"V\", y = \"c\" }";

/// Reads the planes; `machine` is the section of the grid's machine, if it is one's.
pub(super) fn read(section: &Section, machine: &Section, grid: &Grid) -> Result<Vec<Plane>, ConfigError> {
    let Some(node) = section.get("planes") else {
        return match section.is_present() {
            true => {
                Err(section.missing("planes", format!("write planes = [{EXAMPLE}], or leave [curves] out")))
            }
            false => Ok(Vec::new()),
        };
    };
    let taken = grid.axes().iter().find(|axis| CURVE_COLUMNS.contains(&axis.name.as_str()));
    if let Some(axis) = taken {
        let problem = format!("curves cannot be stored beside a parameter called `{}`", axis.name);
        return Err(node.error(&problem, "rename the parameter, or leave [curves] out"));
    }
    let mut planes: Vec<Plane> = Vec::new();
    for element in node.list(&format!("a list of planes such as [{EXAMPLE}]"))? {
        let Shape::Table(table) = element.shape() else {
            return Err(element.wrong_kind(&format!("a plane such as {EXAMPLE}")));
        };
        let plane = plane(&table, machine, grid)?;
        if planes.iter().any(|other| *other == plane || *other == plane.turned()) {
            return Err(element.error("this plane is named twice", "take out the repetition"));
        }
        planes.push(plane);
    }
    Ok(planes)
}

fn plane(table: &Section, machine: &Section, grid: &Grid) -> Result<Plane, ConfigError> {
    refuse_unknown_keys(table, &PLANE_KEYS)?;
    let axes = grid.axes();
    let known = match grid.machine() {
        Some(machine) => machine.quantities().into_iter().map(|(name, _)| name).collect(),
        None => grid.law().axis_names(),
    };
    let place = |name: &'static str| Some((name, axes.iter().position(|axis| axis.name == name)?));
    let names: Vec<(&'static str, usize)> = known.into_iter().filter_map(place).collect();
    let shown = |key: &str| {
        let node =
            table.get(key).ok_or_else(|| table.missing(key, format!("a plane is written {EXAMPLE}")))?;
        let axis: usize = choice(&node, &names, "axis")?;
        if axes[axis].values.len() < 2 {
            let problem = format!("the axis {} has one node, and no plane extends along it", axes[axis].name);
            return Err(node.error(&problem, "choose another axis, or give this one a range in the grid"));
        }
        Ok((axis, node))
    };
    let ((x, _), (y, node)) = (shown("x")?, shown("y")?);
    if x == y {
        return Err(node.error("both axes of the plane are the same", "choose two different axes"));
    }
    let mut held: Vec<usize> = axes.iter().map(Axis::middle).collect();
    let at = table.section("at")?;
    for key in at.keys() {
        let known: Vec<&str> = names.iter().map(|(name, _)| *name).collect();
        let Some(&(name, axis)) = names.iter().find(|(name, _)| *name == key) else {
            return Err(at.unknown(&key, nearest("axis", &key, &known)));
        };
        if axis == x || axis == y {
            let remedy = "leave it out, or choose another plane";
            return Err(
                at.unknown(&key, format!("the plane extends along `{key}`, which is not held: {remedy}"))
            );
        }
        if let Some(node) = at.get(&key) {
            let value = match grid.machine() {
                Some(_) => in_si(machine, grid.law(), &node, name)?,
                None => node.number()?,
            };
            held[axis] = node_of(&node, value, &axes[axis])?;
        }
    }
    Ok(Plane::new(x, y, held))
}

/// The node nearest to a value within its axis.
fn node_of(node: &Node, value: f64, axis: &Axis) -> Result<usize, ConfigError> {
    let (first, last) = (axis.values[0], axis.values[axis.values.len() - 1]);
    if !(first..=last).contains(&value) {
        let remedy = "hold it at one of its nodes; the nearest is taken";
        let (unit, bare) = match axis.unit {
            "" => (String::new(), String::new()),
            unit => (format!(" {unit}"), format!(", and a number without a unit is in {unit}")),
        };
        let problem = format!("the axis {} goes from {first}{unit} to {last}{unit}", axis.name);
        return Err(node.error(&problem, format!("{remedy}{bare}")));
    }
    Ok(axis.nearest(value))
}
