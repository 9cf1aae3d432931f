//! The friction law of a configuration.

use std::path::Path;

use super::measured::{Direction, How, Kind, Level, Measured, OfMachine};
use super::source::{ConfigError, Node, Section};
use super::{choice, fitted, nearest};
use slipmap_machine::{Friction, Motion};
use slipmap_map::{AxisRole, Grid, unravel};
use slipmap_model::friction::{Expression, ExpressionError, Law};
use slipmap_model::point::MAX_LAW_PARAMETERS;

pub(super) const KEYS: [&str; 10] =
    ["law", "phi", "static", "rest", "file", "quantity", "kind", "direction", "small", fitted::KEY];

/// The units of a law's numbers.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum About {
    /// The dimensionless oscillator: phi(0) = 1.
    Oscillator,
    /// A machine with this motion, in SI units: a coefficient of friction or a force, with any value at rest.
    Machine(Motion),
}

/// The quantities of a machine besides its friction, for messages.
const OF_MACHINE: &str =
    "beside the friction [machine] needs mass, stiffness, damping, normal_force and belt_speed";

/// Largest number of columns of the grid at which a law given as text is checked: all of a small grid, evenly
/// spread over a large one.
const CHECKED_COLUMNS: usize = 256;

/// Reads `[friction]`; file names are relative to the folder of the configuration.
pub(super) fn read(section: &Section, folder: &Path, about: About) -> Result<Law, ConfigError> {
    let also = if matches!(about, About::Machine(_)) { format!("; {OF_MACHINE}") } else { String::new() };
    let built_in = |name: &str| Law::BUILT_IN.into_iter().find(|law| law.name() == name);
    let at_peak = rests_at_peak(section, about)?;
    let level = || match (section.get("static"), about) {
        (Some(node), _) => static_level(&node).map(Level::Given),
        (None, _) if at_peak => Ok(Level::Peak),
        (None, About::Machine(_)) => Ok(Level::First),
        (None, About::Oscillator) => Ok(Level::One),
    };
    let node = section.get("law");
    let name = node.as_ref().map_or(Ok(Law::Stribeck.name()), Node::text)?;
    let law = match (name, built_in(name)) {
        (_, Some(law)) => law,
        ("expression", None) => {
            let remedy = match about {
                About::Oscillator => "write for example phi = \"mu + (1 - mu)*exp(-u/vs)\"".to_owned(),
                About::Machine(_) => format!(
                    "write the coefficient of friction against the slip speed u in m/s, for example phi = \"0.3 + \
                     0.1*exp(-u/vs)\"; each name in it, as vs here, is a key of [machine]{also}"
                ),
            };
            let phi = section.get("phi").ok_or_else(|| section.missing("phi", remedy))?;
            level()?.formula(phi.text()?).map_err(|error| at_formula(&phi, &error))?
        }
        ("table", None) => {
            let remedy = match about {
                About::Oscillator => "name a CSV file with the columns slip speed and friction".to_owned(),
                About::Machine(_) => format!(
                    "name a CSV file with the columns slip speed in m/s, coefficient of friction, and perhaps its \
                     standard error; quantity = \"force\" if it holds forces in N{also}"
                ),
            };
            let file = section.get("file").ok_or_else(|| section.missing("file", remedy))?;
            let path = folder.join(file.text()?);
            let machine = match about {
                About::Oscillator => None,
                About::Machine(motion) => {
                    Some(OfMachine { motion: Some(motion), forces: quantity(section)? })
                }
            };
            let level = level()?;
            let [kind, direction] = ["kind", "direction"].map(|key| section.get(key));
            let kind = kind.map(|node| choice(&node, &Kind::NAMES, "kind")).transpose()?;
            let direction =
                direction.map(|node| choice(&node, &Direction::NAMES, "direction")).transpose()?;
            let how = How { machine, kind, direction: direction.unwrap_or_default() };
            let table = Measured::read(&path, how).and_then(|measured| measured.table(level));
            Law::Table(table.map_err(|(problem, remedy)| file.error(&problem, remedy))?)
        }
        (_, None) => {
            let names: Vec<_> = Law::names().collect();
            let error = |node: &Node| node.error("unknown law", nearest("law", name, &names));
            return Err(node.as_ref().map_or_else(|| section.missing("law", String::new()), error));
        }
    };
    if let (About::Oscillator, Some(node)) = (about, section.get("quantity")) {
        let problem = "only the friction of a machine is a coefficient or a force";
        return Err(node.error(problem, "leave it out: phi is friction in units of that at rest"));
    }
    fitted::check(section, &law)?;
    let of_formula = law.name() == "expression";
    let keys = [
        ("phi", "expression"),
        ("file", "table"),
        ("quantity", "table"),
        ("kind", "table"),
        ("direction", "table"),
    ];
    for (key, of) in keys {
        let belongs = name == of || key == "quantity" && of_formula;
        if let (false, Some(node)) = (belongs, section.get(key)) {
            let problem = format!("the law `{}` has no {key}", law.name());
            return Err(node.error(&problem, format!("leave it out, or set law = \"{of}\"")));
        }
    }
    let rest = section.get("static").or_else(|| section.get("rest"));
    if let (Some(law), Some(node)) = (built_in(law.name()), rest) {
        let problem = format!("friction at rest is 1 already in the law `{}`", law.name());
        return Err(
            node.error(&problem, "leave it out; where friction drops as slip begins, write [grid] drop")
        );
    }
    match section.get("small") {
        None => Ok(law),
        Some(node) if node.text()? == "eps" => Ok(law.read_as_small()),
        Some(node) => {
            let remedy = "write small = \"eps\" to read the law as 1 + eps F(u), or leave it out";
            Err(node.error("the small parameter of a law can be eps only", remedy))
        }
    }
}

/// Whether `rest = "peak"` is there: the law beyond its first peak, with the peak as friction at rest.
fn rests_at_peak(section: &Section, about: About) -> Result<bool, ConfigError> {
    let Some(node) = section.get("rest") else { return Ok(false) };
    if node.text()? != "peak" {
        return Err(node.error("rest can be peak only", "write the friction at rest as static"));
    }
    if section.get("static").is_some() {
        return Err(
            node.error("friction at rest is written twice: here, and as static", "leave one of them out")
        );
    }
    match about {
        About::Oscillator => Ok(true),
        About::Machine(_) => {
            let remedy = "write the peak as the friction at rest: static, with the law of slip beyond it";
            Err(node.error("the friction of a machine has no rest at a peak", remedy))
        }
    }
}

/// The law with the parameters `exponent` and `drop`, if the grid has them.
pub(super) fn with_axes(law: Law, friction: &Section, axes: &Section) -> Result<Law, ConfigError> {
    let law = if axes.get("exponent").is_some() { law.with_exponent() } else { law };
    let Some(node) = axes.get("drop") else { return Ok(law) };
    if friction.get("static").is_some() && law.may_drop() {
        let remedy = "leave out one of them: static above the law at u -> 0 is a drop, too";
        return Err(node.error("the drop is written twice: here, and by static in [friction]", remedy));
    }
    if law.may_drop() || law.parameters().len() < MAX_LAW_PARAMETERS {
        return Ok(law.with_drop());
    }
    let problem = format!("the law has {MAX_LAW_PARAMETERS} parameters, and no room for a drop");
    Err(node.error(&problem, "write some of them as numbers, or the drop as static in [friction]"))
}

/// Whether the friction of a machine is said to be a force or a coefficient.
fn quantity(section: &Section) -> Result<Option<bool>, ConfigError> {
    let quantities = [("coefficient", false), ("force", true)];
    section.get("quantity").map(|node| choice(&node, &quantities, "quantity")).transpose()
}

/// Whether the law of a machine holds forces instead of coefficients.
pub(super) fn holds_forces(section: &Section, law: &Law) -> Result<bool, ConfigError> {
    match law.as_written() {
        Law::Table(table) => Ok(table.source().forces),
        _ => Ok(quantity(section)? == Some(true)),
    }
}

fn static_level(node: &Node) -> Result<f64, ConfigError> {
    let level = node.number()?;
    if level > 0.0 && level.is_finite() {
        Ok(level)
    } else {
        Err(node.error("the friction at rest must be greater than 0", "write it in the units of the law"))
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
