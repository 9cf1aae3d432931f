//! The friction law of a configuration.

use std::io::Read as _;
use std::path::Path;

use super::points::SEPARATE;
use super::source::{ConfigError, Node, Section, decimal_comma, is_utf_16};
use super::units::{Match, Wanted, bracketed, compare, conversion, in_words};
use super::{choice, nearest};
use slipmap_map::machine::{Dimension, Friction, Motion};
use slipmap_map::map::{AxisRole, Grid, unravel};
use slipmap_model::friction::readings::means;
use slipmap_model::friction::{Expression, ExpressionError, Law, Table};
use slipmap_model::point::MAX_LAW_PARAMETERS;

pub(super) const KEYS: [&str; 6] = ["law", "phi", "static", "file", "quantity", "small"];

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
    let level = || match (about, section.get("static")) {
        (_, None) => Ok(None),
        (_, Some(node)) => static_level(&node).map(Some),
    };
    let built_in = |name: &str| Law::BUILT_IN.into_iter().find(|law| law.name() == name);
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
            let law = match level()? {
                Some(level) => Expression::with_static(phi.text()?, level),
                None => Expression::new(phi.text()?, 1.0),
            };
            Law::Expression(law.map_err(|error| at_formula(&phi, &error))?)
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
                About::Machine(motion) => Some(OfMachine { motion, forces: holds_forces(section)? }),
            };
            let level = match (level()?, about) {
                (Some(level), _) => Level::Given(level),
                (None, About::Machine(_)) => Level::First,
                (None, About::Oscillator) => Level::One,
            };
            let table = table_of(&path, level, machine);
            Law::Table(table.map_err(|(problem, remedy)| file.error(&problem, remedy))?)
        }
        (_, None) => {
            let names: Vec<_> = Law::names().collect();
            let error = |node: &Node| node.error("unknown law", nearest("law", name, &names));
            return Err(node.as_ref().map_or_else(|| section.missing("law", String::new()), error));
        }
    };
    if let (About::Oscillator, Some(node)) = (about, section.get("quantity")) {
        let problem = "only the table of a machine holds coefficients or forces";
        return Err(node.error(problem, "leave it out: phi is friction in units of that at rest"));
    }
    for (key, of) in [("phi", "expression"), ("file", "table"), ("quantity", "table")] {
        if let (true, Some(node)) = (law.name() != of, section.get(key)) {
            let problem = format!("the law `{}` has no {key}", law.name());
            return Err(node.error(&problem, format!("leave it out, or set law = \"{of}\"")));
        }
    }
    if let (Some(law), Some(node)) = (built_in(law.name()), section.get("static")) {
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

/// The law with the parameter `drop`, if the grid has it.
pub(super) fn with_drop(law: Law, friction: &Section, axes: &Section) -> Result<Law, ConfigError> {
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

/// Whether the table of a machine holds forces instead of coefficients.
pub(super) fn holds_forces(section: &Section) -> Result<bool, ConfigError> {
    let quantities = [("coefficient", false), ("force", true)];
    section.get_or("quantity", false, |node| choice(node, &quantities, "quantity"))
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

/// Largest ratio of two readings at rest that are averaged. While it sticks, the friction is what the spring
/// pulls: a record of that is no friction law.
const WIDEST_AT_REST: f64 = 2.0;

/// Largest size in bytes of the file of a measured law.
const LONGEST_TABLE: u64 = 16 << 20;

/// Reads a measured law: two columns, slip speed and friction, and optionally a third with the standard
/// errors of the friction; with or without a header. Rows of one slip speed without standard errors are
/// averaged.
///
/// # Errors
/// The problem with its line, and a remedy.
pub fn read_table(path: &Path, static_level: Option<f64>) -> Result<Table, (String, String)> {
    table_of(path, static_level.map_or(Level::One, Level::Given), None)
}

/// The friction at rest of a table.
#[derive(Clone, Copy, Debug)]
pub enum Level {
    /// 1, or the larger of two rows at slip speed 0.
    One,
    /// That of the first row, or the larger of two rows at slip speed 0.
    First,
    /// A given one, at least that of the first row.
    Given(f64),
}

/// What the table of a machine holds, in SI units.
#[derive(Clone, Copy, Debug)]
pub struct OfMachine {
    /// Whether the machine moves along a line or turns.
    pub motion: Motion,
    /// Whether it holds forces (of a rotation torques) instead of coefficients.
    pub forces: bool,
}

/// Reads a measured law as [`read_table`] does.
fn table_of(path: &Path, level: Level, machine: Option<OfMachine>) -> Result<Table, (String, String)> {
    let name = path.display();
    let fail = |problem: String, remedy: &str| Err((problem, remedy.to_owned()));
    let mut bytes = Vec::new();
    // The length is limited because some files never end.
    let read =
        std::fs::File::open(path).and_then(|open| open.take(LONGEST_TABLE + 1).read_to_end(&mut bytes));
    if let Err(error) = read {
        return fail(format!("{name} cannot be read: {error}"), "check the path");
    }
    if is_utf_16(&bytes) {
        return fail(format!("{name} is written in UTF-16"), "save it as UTF-8");
    }
    let Ok(text) = String::from_utf8(bytes) else {
        return fail(format!("{name} cannot be read: it is not text in UTF-8"), "name a CSV file");
    };
    if text.len() as u64 > LONGEST_TABLE {
        let problem = format!("{name} is longer than {} MiB, and no measured friction", LONGEST_TABLE >> 20);
        return fail(problem, "name a CSV file with the columns slip speed and friction");
    }
    table_of_text(&name.to_string(), &text, level, machine)
}

/// Reads a measured law as [`read_table`] does, from the text of a file of this `name`. Two rows at slip speed
/// 0, where no other speed is repeated, are the two coefficients: the larger one is the friction at rest, and
/// friction in slip begins at the smaller one. Other repeated rows are readings, and averaged. The header of
/// the table of a machine must name no units but those in which it is read.
pub fn table_of_text(
    name: &str,
    text: &str,
    level: Level,
    machine: Option<OfMachine>,
) -> Result<Table, (String, String)> {
    let fail = |problem: String, remedy: &str| Err((problem, remedy.to_owned()));
    let text = text.trim_start_matches('\u{feff}');
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .flexible(true)
        .from_reader(text.as_bytes());
    let is_skipped = |line: &str| line.trim_matches(['\r', '\n']).is_empty() || line.starts_with('#');
    let (mut data, mut errors) = (Vec::new(), Vec::new());
    let (mut lines, mut headers) = (Vec::new(), Vec::new());
    for record in reader.records() {
        let Ok(record) = record else {
            return fail(format!("{name} is not a CSV file"), "write two columns separated by commas");
        };
        // The reader's position is before the empty lines and comments that precede the record.
        let before =
            text.get(..record.position().map_or(0, |place| place.byte() as usize)).unwrap_or_default();
        let skipped = text[before.len()..].split_inclusive('\n').take_while(|line| is_skipped(line)).count();
        let line = before.matches('\n').count() + skipped + 1;
        let numbers: Vec<Option<f64>> = record.iter().map(|field| field.parse().ok()).collect();
        match numbers.as_slice() {
            // It is ambiguous which column is the friction.
            [Some(_), Some(_), Some(_), more @ ..] if more.iter().any(Option::is_some) => {
                let problem = format!("{name}:{line}: there are more than three columns of numbers");
                return fail(
                    problem,
                    "leave slip speed, friction and, if it is known, the standard error of the friction",
                );
            }
            // Text in a third column is not a standard error.
            [Some(u), Some(phi)] | [Some(u), Some(phi), None, ..] if errors.is_empty() => {
                data.push((*u, *phi));
                lines.push(line);
            }
            [Some(u), Some(phi), Some(error), ..] if errors.len() == data.len() => {
                data.push((*u, *phi));
                errors.push(*error);
                lines.push(line);
            }
            [Some(_), Some(_), ..] => {
                let problem =
                    format!("{name}:{line}: the third column holds standard errors, but not in every row");
                return fail(problem, "give one in every row, in the units of the friction, or none");
            }
            [None, None, ..] if data.is_empty() => headers.push((line, record)),
            _ => {
                let row: Vec<&str> = record.iter().collect();
                let problem = format!("{name}:{line}: `{}` is not a pair of numbers", row.join(","));
                let foreign =
                    row.iter().any(|field| field.contains([';', '\t']) || decimal_comma(field).is_some());
                let remedy =
                    if foreign { SEPARATE } else { "write slip speed and friction, separated by a comma" };
                return fail(problem, remedy);
            }
        }
    }
    if let Some(machine) = machine {
        let columns = if errors.is_empty() { 2 } else { 3 };
        for (line, header) in &headers {
            let checked = header.iter().take(columns).enumerate();
            for (column, field) in checked {
                check_unit(field, column, machine)
                    .map_err(|(problem, remedy)| (format!("{name}:{line}: {problem}"), remedy))?;
            }
        }
    }
    let read = data.len();
    let mut level = level;
    let repeated = data.windows(2).filter(|rows| rows[0].0 == rows[1].0).count();
    if let ([(first, one), (second, other), ..], 1) = (&data[..], repeated)
        && *first == 0.0
        && *second == 0.0
        && one != other
    {
        if let Level::Given(_) = level {
            let problem =
                format!("{name}:{}: friction at rest is written twice: here, and as static", lines[0]);
            return fail(problem, "leave out static, or the larger of the two rows at slip speed 0");
        }
        let held = if one > other { 0 } else { 1 };
        level = Level::Given(data[held].1);
        data.remove(held);
        lines.remove(held);
        if !errors.is_empty() {
            errors.remove(held);
        }
    }
    if errors.is_empty() {
        let at_rest = || data.iter().take_while(|(u, _)| *u == 0.0).map(|(_, friction)| *friction);
        let [least, most] = [f64::min, f64::max].map(|of| at_rest().reduce(of).unwrap_or(0.0));
        if least < most && most > WIDEST_AT_REST * least {
            let line = lines.first().map_or(1, |line| *line);
            let problem = format!("{name}:{line}: the friction at slip speed 0 goes from {least} to {most}");
            return fail(problem, "write the one at which it breaks loose, in one row");
        }
        if let Some(means) = means(&data) {
            lines = means.first.into_iter().map(|row| lines[row]).collect();
            (data, errors) = (means.data, means.standard_errors.unwrap_or_default());
        }
    } else {
        let third = headers.iter().filter_map(|(line, header)| Some((line, header.get(2)?)));
        if let Some((line, field)) = third.into_iter().find(|(_, field)| is_deviation(field)) {
            let problem = format!(
                "{name}:{line}: the header calls the third column `{field}`, a standard deviation, but standard errors \
                 are read"
            );
            return fail(
                problem,
                "divide it by the square root of the number of readings in each row, and call it `se`; if each row is \
                 one reading, call it `se`",
            );
        }
    }
    let first = data.first().map_or(1.0, |(_, friction): &(f64, f64)| *friction);
    if !(first > 0.0) && !matches!(level, Level::One) {
        let line = lines.first().map_or(1, |line| *line);
        let problem = format!("{name}:{line}: the friction at rest is {first}");
        return fail(problem, "begin with the friction at slip speed 0, greater than 0");
    }
    let table = match level {
        Level::One => Table::new(name, &data, 1.0),
        Level::First => Table::new(name, &data, first),
        Level::Given(level) => Table::with_static(name, &data, level),
    };
    let table = table
        .and_then(|table| if errors.is_empty() { Ok(table) } else { table.with_standard_errors(&errors) })
        .map(|table| table.with_rows(&lines, read));
    table.map_err(|error| {
        let line = error.row.and_then(|row| lines.get(row)).map_or(String::new(), |line| format!(":{line}"));
        (format!("{name}{line}: {}", error.problem), error.remedy)
    })
}

/// Whether the header of the third column says that it holds standard deviations, not standard errors.
fn is_deviation(field: &str) -> bool {
    let text = field.to_lowercase();
    let is_word = |of: &[&str]| text.split(|c: char| !c.is_alphanumeric()).any(|word| of.contains(&word));
    let is_error = text.contains("err") || text.contains("mean") || is_word(&["se", "sem"]);
    !is_error && (text.contains("deviation") || is_word(&["sd", "std", "stdev", "stddev"]))
}

/// Refuses a field of the header of a machine's table that names another unit than that of its column.
fn check_unit(field: &str, column: usize, machine: OfMachine) -> Result<(), (String, String)> {
    let OfMachine { motion, forces } = machine;
    let (what, wanted) = match (column, forces) {
        (0, _) => ("slip speeds", Wanted::Si(motion, Dimension::Velocity)),
        (1, true) => ("the friction", Wanted::Si(motion, Dimension::Force)),
        (1, false) => ("the friction", Wanted::Number),
        (_, true) => ("the standard errors", Wanted::Si(motion, Dimension::Force)),
        (_, false) => ("the standard errors", Wanted::Number),
    };
    let said = match bracketed(field) {
        Some((before, inside)) if is_remark(field, before, inside) => in_words(before, wanted),
        Some((_, inside)) => Some(inside.to_owned()),
        None => in_words(field, wanted),
    };
    let Some(unit) = said else { return Ok(()) };
    let read = match wanted {
        Wanted::Si(..) => format!("are read in {}", wanted.name()),
        Wanted::Number => "are read as coefficients, without a unit".to_owned(),
    };
    let read = if what == "the friction" { read.replacen("are", "is", 1) } else { read };
    let is = if what == "the friction" { "is" } else { "are" };
    let remedy = match compare(&unit, wanted) {
        Match::Same => return Ok(()),
        Match::Factor(factor) => {
            let conversion = conversion(&unit, factor, wanted);
            format!("{what} {read}, and {conversion}; multiply them by that, or correct the header")
        }
        Match::Other if column > 0 && forces => {
            format!(
                "{what} {read}; correct the header, or leave out quantity = \"force\" if it is a coefficient"
            )
        }
        Match::Other if column > 0 => {
            let force = motion.unit(Dimension::Force);
            format!("{what} {read}; correct the header, or write quantity = \"force\" if it is in {force}")
        }
        Match::Other => format!("{what} {read}; convert them, or correct the header"),
        Match::Unknown => {
            let remedy = format!("{what} {read}; convert them, or correct the header");
            return Err((
                format!("the header says `{field}`, and `{unit}` is no unit that is known"),
                remedy,
            ));
        }
    };
    Err((format!("the header says that {what} {is} in {unit}"), remedy))
}

/// Whether the text in brackets is not a unit but a remark, as in `speed (relative)`, or the variable of a
/// function, as in `mu(v)`.
fn is_remark(field: &str, before: &str, inside: &str) -> bool {
    let round = field.trim_end().ends_with(')');
    let is_known = !matches!(compare(inside, Wanted::Number), Match::Unknown);
    let words = || inside.split_whitespace();
    let is_prose = inside.chars().all(|c| c.is_alphabetic() || c == ' ')
        && words().any(|word| word.chars().count() > 3)
        && !words().any(|word| word == "per");
    let is_variable =
        inside.chars().count() == 1 && field.trim_end().len() == before.len() + inside.len() + 2;
    round && !is_known && (is_prose || is_variable)
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
                    "if it is a parameter, write {} = 1.0 (or a range) in [grid]; the variables are u and eps",
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
                        Expression::with_static(law.text(), friction.at_rest())
                            .and_then(|law| law.check(1.0, &parameters, fastest))
                    }
                    Some(_) => Ok(()),
                    None => {
                        let point = grid.point(&unravel(column * grid.dampings().len(), &shape));
                        law.check(point.epsilon, &point.law, fastest)
                    }
                };
                checked.map_err(|error| at_formula(&phi, &error))?;
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
