//! The planes of a configuration in which a run stores curves of codimension one.

use super::source::{ConfigError, Node, Section, Shape};
use super::{choice, nearest, refuse_unknown_keys};
use slipmap_map::map::{Axis, CURVE_COLUMNS, Grid, Plane};

pub(super) const KEYS: [&str; 1] = ["planes"];

const PLANE_KEYS: [&str; 3] = ["x", "y", "at"];

const EXAMPLE: &str = "{ x = \"V\", y = \"c\" }";

/// Reads the planes.
pub(super) fn read(section: &Section, grid: &Grid) -> Result<Vec<Plane>, ConfigError> {
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
        let plane = plane(&table, grid)?;
        if planes.iter().any(|other| *other == plane || *other == plane.turned()) {
            return Err(element.error("this plane is named twice", "take out the repetition"));
        }
        planes.push(plane);
    }
    Ok(planes)
}

fn plane(table: &Section, grid: &Grid) -> Result<Plane, ConfigError> {
    refuse_unknown_keys(table, &PLANE_KEYS)?;
    let axes = grid.axes();
    let known = match grid.machine() {
        Some(machine) => machine.quantities().into_iter().map(|(name, _)| name).collect(),
        None => Grid::axis_names(grid.law()),
    };
    let place = |name: &'static str| Some((name, axes.iter().position(|axis| axis.name == name)?));
    let names: Vec<(&str, usize)> = known.into_iter().filter_map(place).collect();
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
        let Some(&(_, axis)) = names.iter().find(|(name, _)| *name == key) else {
            return Err(at.unknown(&key, nearest("axis", &key, &known)));
        };
        if axis == x || axis == y {
            let remedy = "leave it out, or choose another plane";
            return Err(
                at.unknown(&key, format!("the plane extends along `{key}`, which is not held: {remedy}"))
            );
        }
        if let Some(node) = at.get(&key) {
            held[axis] = node_of(&node, &axes[axis])?;
        }
    }
    Ok(Plane::new(x, y, held))
}

/// The node nearest to a value within its axis.
fn node_of(node: &Node, axis: &Axis) -> Result<usize, ConfigError> {
    let value = node.number()?;
    let (first, last) = (axis.values[0], axis.values[axis.values.len() - 1]);
    if !(first..=last).contains(&value) {
        let problem = format!("the axis {} goes from {first} to {last}", axis.name);
        return Err(node.error(&problem, "hold it at one of its nodes; the nearest is taken"));
    }
    Ok(axis.nearest(value))
}
