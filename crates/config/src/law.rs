//! The friction law of a configuration.

use std::path::Path;

use super::described::{About, FORCE, LawText, Origin, Wrong};
use super::measured::Measured;
use super::source::{ConfigError, Node, Section, Shape};
use super::{choice, fitted};
use slipmap_machine::Friction;
use slipmap_map::{AxisRole, Grid, unravel};
use slipmap_model::friction::{Expression, ExpressionError, Law};

pub(super) const KEYS: [&str; 13] = [
    "law",
    "phi",
    "static",
    "rest",
    "file",
    "rows",
    "source",
    "quantity",
    "kind",
    "direction",
    "column",
    "small",
    fitted::KEY,
];

/// The quantities of a machine besides its friction, for messages.
pub(super) const OF_MACHINE: &str =
    "beside the friction [machine] needs mass, stiffness, damping, normal_force and belt_speed";

/// Largest number of columns of the grid at which a law given as text is checked: all of a small grid, evenly
/// spread over a large one.
const CHECKED_COLUMNS: usize = 256;

/// Reads `[friction]`; file names are relative to the folder of the configuration. `axes` is the table of the values
/// of the law's parameters.
pub(super) fn read(
    section: &Section,
    axes: &Section,
    folder: &Path,
    about: About,
) -> Result<Law, ConfigError> {
    let text = text_of(section, axes, about)?;
    let file = text.file.clone().unwrap_or_default();
    let law = text.law_of(about, |how| Measured::read(&folder.join(file), how));
    let law = law.map_err(|wrong| at(section, axes, wrong))?;
    fitted::check(section, &law)?;
    Ok(law)
}

/// The keys of `[friction]`, each of the kind that it must be.
fn text_of(section: &Section, axes: &Section, about: About) -> Result<LawText, ConfigError> {
    let text = |key: &str| section.get(key).map(|node| node.text().map(str::to_owned)).transpose();
    let small = match section.get("small") {
        None => false,
        Some(node) if node.text()? == "eps" => true,
        Some(node) => {
            let remedy = "write small = \"eps\" to read the law as 1 + eps F(u), or leave it out";
            return Err(node.error("the small parameter of a law can be eps only", remedy));
        }
    };
    // A machine has no drop but by its friction at rest.
    let optional: &[&str] = if about == About::Oscillator { &["exponent", "drop"] } else { &["exponent"] };
    let is_given = |name: &&&str| axes.get(name).is_some();
    quantity(section)?;
    Ok(LawText {
        name: text("law")?.unwrap_or_default(),
        phi: text("phi")?,
        static_level: section.get("static").map(|node| node.number()).transpose()?,
        rest: text("rest")?,
        file: text("file")?,
        table: None,
        rows: section.get("rows").map(|node| rows(&node)).transpose()?,
        source: section.get("source").map(|node| origin(&node)).transpose()?,
        quantity: text("quantity")?,
        kind: text("kind")?,
        direction: text("direction")?,
        column: text("column")?,
        small,
        fit: fitted::values(section),
        axes: optional.iter().filter(is_given).map(|name| (*name).to_owned()).collect(),
    })
}

/// Rows of numbers.
fn rows(node: &Node) -> Result<Vec<Vec<f64>>, ConfigError> {
    let wanted = "rows such as [[0.0, 0.4], [0.1, 0.35], [0.5, 0.3]]";
    let numbers = |row: &Node| row.list(wanted)?.iter().map(Node::number).collect();
    node.list(wanted)?.iter().map(numbers).collect()
}

/// What is known of rows.
fn origin(node: &Node) -> Result<Origin, ConfigError> {
    let Shape::Table(table) = node.shape() else { return Err(node.wrong_kind("a table")) };
    super::refuse_unknown_keys(&table, &["file", "lines", "readings", "told", "no_rest", "named_errors"])?;
    let text = |key: &str| table.get(key).map(|node| node.text().map(str::to_owned)).transpose();
    let count = |node: &Node| node.integer::<usize>(0, i64::from(u32::MAX));
    let lines = |node: &Node| node.list("a list of lines")?.iter().map(count).collect();
    Ok(Origin {
        file: text("file")?.unwrap_or_default(),
        lines: table.get_or("lines", Vec::new(), lines)?,
        readings: table.get("readings").map(|node| count(&node)).transpose()?,
        told: text("told")?,
        no_rest: table.get_or("no_rest", false, Node::truth)?,
        named_errors: table.get_or("named_errors", false, Node::truth)?,
    })
}

/// The error at the key concerned.
pub(super) fn at(section: &Section, axes: &Section, wrong: Wrong) -> ConfigError {
    let home = if KEYS.contains(&wrong.key) { section } else { axes };
    match home.get(wrong.key) {
        Some(node) => node.error(&wrong.words(node.text().unwrap_or_default()), wrong.remedy),
        // Rows stand in place of a file.
        None if wrong.key == "file" && home.get("rows").is_some() => {
            at(section, axes, Wrong { key: "rows", ..wrong })
        }
        None if wrong.problem.is_empty() => home.missing(wrong.key, wrong.remedy),
        None => home.missing(wrong.key, format!("{}; {}", wrong.problem, wrong.remedy)),
    }
}

/// Whether the friction of a machine is said to be a force or a coefficient.
fn quantity(section: &Section) -> Result<Option<bool>, ConfigError> {
    let quantities = [("coefficient", false), (FORCE, true)];
    section.get("quantity").map(|node| choice(&node, &quantities, "quantity")).transpose()
}

/// Whether the law of a machine holds forces instead of coefficients.
pub(super) fn holds_forces(section: &Section, law: &Law) -> Result<bool, ConfigError> {
    match law.as_written() {
        Law::Table(table) => Ok(table.source().forces),
        _ => Ok(quantity(section)? == Some(true)),
    }
}

/// The error of a formula, with marks under the part concerned.
pub(super) fn at_formula(node: &Node, error: &ExpressionError) -> ConfigError {
    let text = node.text().unwrap_or_default();
    node.error(&point_into(text, error), error.remedy.clone())
}

/// Number of characters of a formula that are quoted before and after the place of an error.
const QUOTED: usize = 40;

/// The problem, the formula below it, and marks under the part concerned. Of a long formula the characters
/// around that part are quoted.
#[must_use]
pub fn point_into(text: &str, error: &ExpressionError) -> String {
    let letters: Vec<char> = text.chars().collect();
    // Up to 20 more are quoted where that completes the formula.
    let first = if error.from <= QUOTED + 20 { 0 } else { (error.from - QUOTED).min(letters.len()) };
    let to = error.to.clamp(error.from + 1, error.from + 2 * QUOTED);
    let last = if letters.len() <= to + QUOTED + 20 { letters.len() } else { to + QUOTED };
    let quoted: String = letters[first..last.max(first)].iter().collect();
    let before = if first > 0 { ".. " } else { "" };
    let after = if last < letters.len() { " .." } else { "" };
    let indent = " ".repeat(before.len() + error.from - first);
    format!("{}\n    {before}{quoted}{after}\n    {indent}{}", error.problem, "^".repeat(to - error.from))
}

/// Refuses symbols in a formula for which no axis gives a value.
pub(super) fn check_symbols(law: &Law, friction: &Section, grid: &Section) -> Result<(), ConfigError> {
    let (Law::Expression(law), Some(phi)) = (law.as_written(), friction.get("phi")) else { return Ok(()) };
    for parameter in law.parameters() {
        if grid.get(parameter.name).is_none() {
            let (from, to) = law.place_of(parameter.name).unwrap_or_default();
            let error = ExpressionError {
                from,
                to,
                problem: format!("unknown symbol `{}`: no axis gives it a value", parameter.name),
                remedy: format!(
                    "if it is a parameter, write {} = 1.0 (or a range) in [grid]; the variables are u (or v) and eps",
                    parameter.name
                ),
            };
            return Err(at_formula(&phi, &error));
        }
    }
    Ok(())
}

/// Checks that the law is legal for the slip speeds [0, 2 V] of the grid, which every orbit and every test
/// uses.
pub(super) fn check_range(friction: &Section, grid: &Grid) -> Result<(), ConfigError> {
    let speeds = grid.axes().iter().find(|axis| axis.role == AxisRole::BeltSpeed);
    let fastest = 2.0 * speeds.and_then(|axis| axis.values.last()).copied().unwrap_or(0.0);
    match (grid.law().as_written(), friction.get("phi"), friction.get("file")) {
        (Law::Expression(law), Some(phi), _) => {
            let shape = grid.shape();
            let columns = grid.column_count();
            let checked = columns.min(CHECKED_COLUMNS);
            for i in 0..checked {
                // Evenly from the first column to the last.
                let column = if checked > 1 { i * (columns - 1) / (checked - 1) } else { 0 };
                let values = grid.values(&unravel(column * grid.dampings().len(), &shape));
                let checked = match grid.machine_at(&values).map(|machine| machine.friction) {
                    // Divided by its value at rest.
                    Some(friction @ Friction::Formula(_, parameters)) => {
                        Expression::with_static(&law.text(), friction.at_rest())
                            .and_then(|law| law.check(1.0, &parameters, fastest))
                    }
                    Some(_) => Ok(()),
                    None => {
                        let point = grid.point(&unravel(column * grid.dampings().len(), &shape));
                        law.check(point.epsilon, &point.law, fastest)
                    }
                };
                // With its rest at the peak the formula is another text.
                checked.map_err(|error| phi.error(&point_into(&law.text(), &error), error.remedy.clone()))?;
            }
            Ok(())
        }
        (Law::Table(table), _, Some(file)) if table.fastest() < fastest => {
            let problem = format!(
                "the data end at slip speed {}, and belt speeds up to {} need it up to {fastest}",
                table.fastest(),
                0.5 * fastest
            );
            Err(file.error(&problem, "measure farther, or choose lower belt speeds in grid.V"))
        }
        _ => Ok(()),
    }
}
