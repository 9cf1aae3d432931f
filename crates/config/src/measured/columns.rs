//! What the columns of measured data are: by the names and units in the header, else by their order.

use super::super::units::{Match, bracketed, compare, in_words, meant};
use super::{OfMachine, Refused};
use slipmap_machine::{Dimension, Motion};

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    Time,
    Speed,
    Friction,
    Error,
    /// Something else that is known, such as the normal force.
    Other,
    /// The header does not say.
    Unknown,
}

/// The columns that are read, by position.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Columns {
    pub(super) time: Option<usize>,
    pub(super) speed: usize,
    pub(super) friction: usize,
    pub(super) error: Option<usize>,
    /// Factors that convert speeds and friction.
    pub(super) factors: [f64; 2],
    /// Whether the friction is a force; `None` where neither the header nor the caller says.
    pub(super) forces: Option<bool>,
    pub(super) motion: Motion,
    /// What has been understood: "slip speeds in mm/s".
    pub(super) said: Vec<String>,
}

/// The header: the number of its line and its fields.
pub(super) type Header = (usize, Vec<String>);

/// Number of fields named in a message.
const NAMED: usize = 6;

/// Finds the columns among those that hold numbers.
pub(super) fn find(
    header: Option<&Header>,
    numeric: &[usize],
    machine: Option<OfMachine>,
) -> Result<Columns, Refused> {
    let name = |column: usize| header.and_then(|(_, fields)| fields.get(column)).map_or("", String::as_str);
    let line = header.map(|(line, _)| *line);
    let refused = |problem: String, remedy: String| Refused { line, problem, remedy };
    let named = numeric.iter().filter(|column| !name(**column).is_empty()).count();
    match (numeric.len(), named) {
        (0 | 1, _) => {
            return Err(refused(
                "there is only one column of numbers".into(),
                "write slip speed and friction, separated by a comma".into(),
            ));
        }
        (3, 0) => {
            return Err(Refused::whole(
                "there are three columns of numbers without a header: slip speed, friction and its standard error, or \
                 time, slip speed and friction",
                "write the header `speed,friction,se` or `time,speed,friction` above them",
            ));
        }
        (more @ 4.., 0) => {
            return Err(Refused::whole(
                &format!("there are {more} columns of numbers without a header"),
                "name them in the first line: speed, friction, and se if there is a standard error of the friction; if \
                 these are decimal commas, separate the columns by semicolons",
            ));
        }
        _ => {}
    }
    let roles: Vec<(usize, Role)> = numeric.iter().map(|&column| (column, role(name(column)))).collect();
    let of = |wanted: Role| {
        let found = roles.iter().filter(move |(_, role)| *role == wanted).map(|(column, _)| *column);
        found.collect::<Vec<usize>>()
    };
    let two = |what: &str, one: usize, other: usize| {
        refused(
            format!("`{}` and `{}` may both be the {what}", name(one), name(other)),
            "give the one that is not another name, or take it out".into(),
        )
    };
    let mut unknown = of(Role::Unknown).into_iter();
    let missing = |what: &str| {
        let fields: Vec<&str> = numeric.iter().map(|&column| name(column)).take(NAMED).collect();
        refused(
            format!("no column is the {what}; there are {}", fields.join(", ")),
            "name the columns speed and friction".into(),
        )
    };
    let mut find = |role: Role, what: &str| match of(role)[..] {
        [one] => Ok(one),
        [one, other, ..] => Err(two(what, one, other)),
        [] => unknown.next().ok_or_else(|| missing(what)),
    };
    let (speed, friction) = (find(Role::Speed, "slip speed")?, find(Role::Friction, "friction")?);
    let errors = of(Role::Error);
    let error = errors.iter().find(|column| **column > friction).or(errors.first()).copied();
    let time = of(Role::Time).first().copied();
    let read = [Some(speed), Some(friction), error, time];
    let mut said = Vec::new();
    let unused = numeric.iter().filter(|column| !read.contains(&Some(**column)));
    let unused: Vec<String> = unused
        .map(|&column| match name(column) {
            "" => format!("column {}", column + 1),
            name => format!("`{name}`"),
        })
        .collect();
    if let Some(column) = error
        && is_deviation(name(column))
    {
        return Err(refused(
            format!(
                "the header calls column {} `{}`, a standard deviation, but standard errors are read",
                column + 1,
                name(column)
            ),
            "divide it by the square root of the number of readings in each row, and call it `se`; if each row is one \
             reading, call it `se`"
                .into(),
        ));
    }
    if let Some(column) = [speed, friction].into_iter().find(|column| is_logarithm(name(*column))) {
        return Err(refused(
            format!("the header says `{}`, a logarithm", name(column)),
            "write the slip speeds and the friction themselves".into(),
        ));
    }
    if header.is_none() || (speed, friction) != (0, 1) {
        let why = if header.is_none() { "no header: " } else { "" };
        said.push(format!("{why}slip speed in column {}, friction in column {}", speed + 1, friction + 1));
    }
    let mut columns = Columns {
        time,
        speed,
        friction,
        error,
        factors: [1.0; 2],
        forces: machine.and_then(|machine| machine.forces),
        motion: machine.and_then(|machine| machine.motion).unwrap_or(Motion::Translation),
        said,
    };
    if let Some(machine) = machine {
        columns
            .read_units([name(speed), name(friction), error.map_or("", name)], machine)
            .map_err(|(problem, remedy)| refused(problem, remedy))?;
    }
    match unused.as_slice() {
        [] => {}
        [one] => columns.said.push(format!("{one} not used")),
        more => columns.said.push(format!("{} not used", more.join(", "))),
    }
    Ok(columns)
}

impl Columns {
    /// Reads the units of the slip speeds, the friction and its errors.
    fn read_units(
        &mut self,
        [speed, friction, error]: [&str; 3],
        machine: OfMachine,
    ) -> Result<(), (String, String)> {
        let turns = || is_of(speed, Motion::Rotation.unit(Dimension::Velocity));
        self.motion = match machine.motion {
            Some(motion) => motion,
            None if turns() => Motion::Rotation,
            None => Motion::Translation,
        };
        let force = self.motion.unit(Dimension::Force);
        if self.forces.is_none() {
            // The unit says which of the two it is.
            self.forces = match [force, ""].map(|wanted| is_of(friction, wanted)) {
                [true, false] => Some(true),
                [false, true] => Some(false),
                _ => None,
            };
        }
        let forces = self.forces == Some(true);
        let of_friction = if forces { force } else { "" };
        let velocity = self.motion.unit(Dimension::Velocity);
        let mut read = |field: &str, what: &str, wanted: &str| -> Result<f64, (String, String)> {
            let (factor, unit) = factor(field, what, wanted)?;
            if factor != 1.0 {
                self.said.push(format!("{what} in {unit}"));
            }
            Ok(factor)
        };
        let speeds = read(speed, "slip speeds", velocity)?;
        let no_unit = unit_of(speed, velocity).is_none() && unit_of(friction, of_friction).is_some();
        let levels = read(friction, "friction", of_friction)?;
        if !error.is_empty() && factor(error, "standard errors", of_friction)?.0 != levels {
            // An error without a unit is in that of the friction.
            if unit_of(error, of_friction).is_some() {
                let problem = "the standard errors are in another unit than the friction";
                return Err((problem.into(), "convert them, or correct the header".into()));
            }
        }
        if no_unit {
            self.said.push(format!("slip speeds have no unit and are read in {velocity}"));
        }
        self.factors = [speeds, levels];
        Ok(())
    }
}

/// The unit that a field of a header names, in brackets or in words.
fn unit_of(field: &str, wanted: &str) -> Option<String> {
    match bracketed(field) {
        Some((before, inside)) if is_remark(field, before, inside) => in_words(before, wanted),
        Some((_, inside)) => Some(inside.to_owned()),
        None => in_words(field, wanted),
    }
}

/// Whether a field names a unit of this quantity.
fn is_of(field: &str, wanted: &str) -> bool {
    unit_of(field, wanted)
        .is_some_and(|unit| matches!(compare(&unit, wanted), Match::Same | Match::Factor(_)))
}

/// The factor from the unit that a field names to the one in which the column is read, and that unit.
fn factor(field: &str, what: &str, wanted: &str) -> Result<(f64, String), (String, String)> {
    let Some(unit) = unit_of(field, wanted) else { return Ok((1.0, String::new())) };
    let read = match wanted {
        "" => "as coefficients, without a unit".to_owned(),
        unit => format!("in {unit}"),
    };
    let is = if what == "friction" { "is" } else { "are" };
    match compare(&unit, wanted) {
        Match::Same => Ok((1.0, unit)),
        Match::Factor(factor) => Ok((factor, unit)),
        of => {
            let also = match wanted {
                "" => ", or write quantity = \"force\" if it is a force",
                _ if Motion::ALL.iter().any(|motion| motion.unit(Dimension::Force) == wanted) => {
                    ", or leave out quantity = \"force\" if it is a coefficient"
                }
                _ => "",
            };
            let problem = match of {
                Match::Unknown => {
                    let meant =
                        meant(&unit, wanted).map_or(String::new(), |meant| format!(", as {meant} is"));
                    format!("the header says `{field}`, and `{unit}` is no unit that is known{meant}")
                }
                _ => format!("the header says that {what} {is} in {unit}"),
            };
            Err((problem, format!("{what} {is} read {read}; convert, or correct the header{also}")))
        }
    }
}

/// Whether the text in brackets is not a unit but a remark, as in `speed (relative)`, or the variable of a
/// function, as in `mu(v)`.
fn is_remark(field: &str, before: &str, inside: &str) -> bool {
    let round = field.trim_end().ends_with(')');
    let is_known = !matches!(compare(inside, ""), Match::Unknown);
    let words = || inside.split_whitespace();
    let is_prose = inside.chars().all(|c| c.is_alphabetic() || c == ' ')
        && words().any(|word| word.chars().count() > 3)
        && !words().any(|word| word == "per");
    let is_variable =
        inside.chars().count() == 1 && field.trim_end().len() == before.len() + inside.len() + 2;
    round && !is_known && (is_prose || is_variable)
}

/// The words of a name, in lower case, without its unit.
fn words(field: &str) -> Vec<String> {
    let name = bracketed(field).map_or(field, |(before, _)| before).to_lowercase();
    let parts = name.split(|c: char| !c.is_alphanumeric()).filter(|part| !part.is_empty());
    parts.map(str::to_owned).collect()
}

/// Whether a header says that its column holds standard deviations, not standard errors.
fn is_deviation(field: &str) -> bool {
    let (text, words) = (field.to_lowercase(), words(field));
    let any = |of: &[&str]| words.iter().any(|word| of.contains(&word.as_str()));
    let is_error = text.contains("err") || text.contains("mean") || any(&["se", "sem"]);
    !is_error && (text.contains("deviation") || any(&["sd", "std", "stdev", "stddev"]))
}

/// Whether a header says that its column holds logarithms.
fn is_logarithm(field: &str) -> bool {
    words(field).iter().any(|word| word.starts_with("log") || ["lg", "ln"].contains(&word.as_str()))
}

/// Whether a line names the slip speed and the friction.
pub(super) fn are_names(fields: &[String]) -> bool {
    let has = |wanted: Role| fields.iter().any(|field| role(field) == wanted);
    has(Role::Speed) && has(Role::Friction)
}

fn role(field: &str) -> Role {
    let (text, words) = (field.to_lowercase(), words(field));
    let any = |of: &[&str]| words.iter().any(|word| of.contains(&word.as_str()));
    let has = |of: &[&str]| of.iter().any(|part| text.contains(part));
    if text.is_empty() {
        return Role::Unknown;
    }
    if is_deviation(field)
        || has(&["err", "±", "+-", "+/-", "sem", "sigma", "uncertainty"])
        || any(&["se", "σ"])
    {
        return Role::Error;
    }
    let kinds = [
        (Role::Speed, Motion::Translation.unit(Dimension::Velocity)),
        (Role::Speed, Motion::Rotation.unit(Dimension::Velocity)),
        (Role::Friction, Motion::Translation.unit(Dimension::Force)),
        (Role::Friction, Motion::Rotation.unit(Dimension::Force)),
        (Role::Time, Motion::Translation.unit(Dimension::Time)),
    ];
    let by_unit = kinds.into_iter().find(|(_, unit)| is_of(field, unit)).map(|(role, _)| role);
    let is_normal = has(&["normal", "load", "pressure"])
        || ["fn", "n"].contains(&words.concat().as_str()) && by_unit == Some(Role::Friction);
    if is_normal {
        return Role::Other;
    }
    if let Some(role) = by_unit {
        return role;
    }
    if has(&["speed", "veloc", "geschw", "slip", "rpm"]) || any(&["v", "u", "vrel", "omega", "ω", "w"]) {
        return Role::Speed;
    }
    let coefficient = ["mu", "µ", "μ", "phi", "φ", "cof", "f", "ff", "fr", "ft", "force", "torque", "muk"];
    if has(&["friction", "reib", "torque", "force"]) || any(&coefficient) {
        return Role::Friction;
    }
    let other_unit = bracketed(field).is_some_and(|(before, inside)| !is_remark(field, before, inside));
    match has(&["time", "zeit"]) || any(&["t"]) {
        true if !other_unit => Role::Time,
        _ if other_unit
            || has(&["temp", "count", "note", "remark", "number"])
            || any(&["no", "nr", "id", "i"]) =>
        {
            Role::Other
        }
        _ => Role::Unknown,
    }
}
