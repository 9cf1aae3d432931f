//! What the columns of measured data are: by the names and units in the header, else by their order.

use super::super::units::{Match, bracketed, compare, in_words, meant};
use super::{OfMachine, Refused};
use slipmap_machine::{Dimension, Motion};

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    Time,
    Speed,
    /// The way or the angle, of which the speed is the slope over time.
    Position,
    Friction,
    /// The force that presses.
    Normal,
    Error,
    /// Something else that is known.
    Other,
    /// The header does not say.
    Unknown,
}

/// The roles that a column may be given, with the words for them.
const ROLES: [(Role, &str); 6] = [
    (Role::Speed, "speed"),
    (Role::Friction, "friction"),
    (Role::Error, "error"),
    (Role::Time, "time"),
    (Role::Position, "position"),
    (Role::Normal, "normal"),
];

/// The columns that were chosen: by name, with or without the unit, or by number.
pub(super) type Chosen = Vec<(Role, String)>;

/// What `speed=NAME, friction=NAME` chooses.
///
/// # Errors
/// What is wrong, and a remedy.
pub(super) fn chosen(text: &str) -> Result<Chosen, (String, String)> {
    let of = |part: &str| {
        let (word, name) = part.split_once('=').filter(|(_, name)| !name.trim().is_empty())?;
        let role = ROLES.iter().find(|(_, known)| *known == word.trim())?.0;
        Some((role, name.trim().to_owned()))
    };
    let refused = |part: &str| {
        let known: Vec<String> = ROLES.iter().map(|(_, word)| format!("{word}=NAME")).collect();
        (format!("`{}` chooses no column", part.trim()), format!("write {}", known.join(", ")))
    };
    text.split(',').map(|part| of(part).ok_or_else(|| refused(part))).collect()
}

/// The columns that are read, by position.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Columns {
    /// That of the time, and its unit in seconds.
    pub(super) time: Option<(usize, f64)>,
    /// That of the slip speed, or of the position of which it is the slope.
    pub(super) speed: usize,
    /// The name of the position, where it is one.
    pub(super) position: Option<String>,
    pub(super) friction: usize,
    /// That of the normal force, by which the friction is divided.
    pub(super) normal: Option<usize>,
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

/// The columns that hold numbers, with their names.
struct Table<'a> {
    header: Option<&'a Header>,
    numeric: &'a [usize],
    roles: Vec<(usize, Role)>,
}

impl<'a> Table<'a> {
    /// The table, with the roles that its header says, and those that were chosen.
    fn new(header: Option<&'a Header>, numeric: &'a [usize], chosen: &Chosen) -> Result<Self, Refused> {
        let mut table = Self { header, numeric, roles: Vec::new() };
        let by_header = |&column: &usize| (column, role(table.name(column)));
        table.roles = numeric.iter().map(by_header).collect();
        for (role, wanted) in chosen {
            let by_name = numeric.iter().copied().find(|column| is_named(header, *column, wanted));
            let by_number =
                || wanted.parse().ok().filter(|number| numeric.iter().any(|column| column + 1 == *number));
            let Some(column) = by_name.or_else(|| by_number().map(|number: usize| number - 1)) else {
                let problem =
                    format!("no column of numbers has the name `{wanted}`; there are {}", table.names());
                return Err(
                    table.refused(problem, "choose one of these names, or the number of the column".into())
                );
            };
            for (of, known) in &mut table.roles {
                if *of == column {
                    *known = *role;
                } else if *known == *role && !chosen.iter().any(|(_, name)| is_named(header, *of, name)) {
                    *known = Role::Other;
                }
            }
        }
        Ok(table)
    }

    fn name(&self, column: usize) -> &'a str {
        self.header.and_then(|(_, fields)| fields.get(column)).map_or("", String::as_str)
    }

    fn names(&self) -> String {
        let told = |&column: &usize| match self.name(column) {
            "" => format!("column {}", column + 1),
            name => name.to_owned(),
        };
        self.numeric.iter().map(told).take(NAMED).collect::<Vec<_>>().join(", ")
    }

    fn refused(&self, problem: String, remedy: String) -> Refused {
        Refused { line: self.header.map(|(line, _)| *line), problem, remedy }
    }

    fn of(&self, wanted: Role) -> Vec<usize> {
        self.roles.iter().filter(|(_, role)| *role == wanted).map(|(column, _)| *column).collect()
    }

    /// The one column of a role, but for set points beside what was measured; `None` where there is none.
    fn one(&self, role: Role, what: &str) -> Result<Option<usize>, Refused> {
        let all = self.of(role);
        let measured: Vec<usize> =
            all.iter().copied().filter(|column| !is_set_point(self.name(*column))).collect();
        match if measured.is_empty() { all } else { measured }[..] {
            [] => Ok(None),
            [one] => Ok(Some(one)),
            [one, other, ..] => {
                let problem =
                    format!("`{}` and `{}` may both be the {what}", self.name(one), self.name(other));
                let remedy = format!("say which it is: column {}=NAME", word_of(role));
                Err(self.refused(problem, remedy))
            }
        }
    }

    /// Why there is no column of the slip speed or the friction.
    fn missing(&self, what: &str) -> Refused {
        let problem = format!("no column is the {what}; there are {}", self.names());
        let is_current = |column: &&usize| {
            unit_of(self.name(**column), "")
                .is_some_and(|unit| ["A", "mA", "Arms", "A rms"].contains(&unit.as_str()))
        };
        let remedy = match self.numeric.iter().find(is_current) {
            Some(current) if what == "friction" => format!(
                "multiply `{}` by the torque constant of the motor, and name it torque [N m]",
                self.name(*current)
            ),
            _ => {
                "name the columns speed and friction, or say which they are: column speed=NAME,friction=NAME"
                    .into()
            }
        };
        self.refused(problem, remedy)
    }
}

/// Whether this column has this name.
fn is_named(header: Option<&Header>, column: usize, wanted: &str) -> bool {
    let name = header.and_then(|(_, fields)| fields.get(column)).map_or("", String::as_str);
    name.eq_ignore_ascii_case(wanted) || bare(name).eq_ignore_ascii_case(wanted)
}

/// A name without its unit.
fn bare(name: &str) -> &str {
    bracketed(name).map_or(name, |(before, _)| before)
}

fn word_of(role: Role) -> &'static str {
    ROLES.iter().find(|(known, _)| *known == role).map_or("", |(_, word)| word)
}

/// What a column of that name holds in place of the slip speed, the friction or its standard error, and a remedy.
fn instead(name: &str, is_error: bool) -> Option<(&'static str, &'static str)> {
    let deviation = (
        "a standard deviation, but standard errors are read",
        "divide it by the square root of the number of readings in each row, and call it `se`; if each row is one reading, \
         call it `se`",
    );
    let logarithm = ("a logarithm", "write the slip speeds and the friction themselves");
    let share = (
        "a share of a rated force or torque, which is not known",
        "multiply it by the rated one, of the data sheet of the drive, and name it torque [N m] or force [N]",
    );
    match is_error {
        true => is_deviation(name).then_some(deviation),
        false if is_logarithm(name) => Some(logarithm),
        false => is_share(name).then_some(share),
    }
}

/// Finds the columns among those that hold numbers.
pub(super) fn find(
    header: Option<&Header>,
    numeric: &[usize],
    machine: Option<OfMachine>,
    chosen: &Chosen,
) -> Result<Columns, Refused> {
    let table = Table::new(header, numeric, chosen)?;
    let name = |column: usize| table.name(column);
    let refused = |problem: String, remedy: String| table.refused(problem, remedy);
    let named = numeric.iter().filter(|column| !name(**column).is_empty()).count() + chosen.len();
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
                "write the header `speed,friction,se` or `time,speed,friction` above them, or say column \
                 speed=2,friction=3",
            ));
        }
        (more @ 4.., 0) => {
            return Err(Refused::whole(
                &format!("there are {more} columns of numbers without a header"),
                "name them in the first line: speed, friction, and se if there is a standard error of the friction, or \
                 say column speed=2,friction=3; if these are decimal commas, separate the columns by semicolons",
            ));
        }
        _ => {}
    }
    let mut unknown = table.of(Role::Unknown).into_iter();
    let time = table.one(Role::Time, "time")?;
    let mut speed = table.one(Role::Speed, "slip speed")?;
    let mut position = None;
    if speed.is_none()
        && let Some(column) = table.one(Role::Position, "position")?
    {
        if time.is_none() {
            let problem = format!("`{}` is a position, and no column is the time", name(column));
            return Err(refused(
                problem,
                "give the times of the rows, or slip speeds in place of positions".into(),
            ));
        }
        (speed, position) = (Some(column), Some(name(column).to_owned()));
    }
    let speed = speed.or_else(|| unknown.next()).ok_or_else(|| table.missing("slip speed"))?;
    // A rig that divides by the normal force itself writes the forces, too.
    let forces = machine.and_then(|machine| machine.forces);
    let all = table.of(Role::Friction);
    let coefficients: Vec<usize> =
        all.iter().copied().filter(|column| is_coefficient(name(*column))).collect();
    let friction = match coefficients[..] {
        [one] if all.len() > 1 && forces != Some(true) => Some(one),
        _ => table.one(Role::Friction, "friction")?,
    };
    let friction = friction.or_else(|| unknown.next()).ok_or_else(|| table.missing("friction"))?;
    let errors = table.of(Role::Error);
    let error = errors.iter().find(|column| **column > friction).or(errors.first()).copied();
    for (column, is_error) in [(Some(speed), false), (Some(friction), false), (error, true)] {
        let name = column.map_or("", name);
        if let Some((what, remedy)) = instead(name, is_error) {
            return Err(refused(format!("`{name}` is {what}"), remedy.into()));
        }
    }
    let mut said = Vec::new();
    if header.is_none() || (speed, friction) != (0, 1) {
        let why = if header.is_none() { "no header: " } else { "" };
        let what = if position.is_some() { "position" } else { "slip speed" };
        said.push(format!("{why}{what} in column {}, friction in column {}", speed + 1, friction + 1));
    }
    let mut columns = Columns {
        time: time.map(|column| (column, 1.0)),
        speed,
        position,
        friction,
        normal: None,
        error,
        factors: [1.0; 2],
        forces,
        motion: machine.and_then(|machine| machine.motion).unwrap_or(Motion::Translation),
        said,
    };
    if let Some(machine) = machine {
        columns.read_units(&table, machine).map_err(|(problem, remedy)| refused(problem, remedy))?;
    }
    let read = [Some(speed), Some(friction), columns.error, time, columns.normal];
    let unused: Vec<String> = numeric
        .iter()
        .filter(|column| !read.contains(&Some(**column)))
        .map(|&column| match name(column) {
            "" => format!("column {}", column + 1),
            name => format!("`{name}`"),
        })
        .collect();
    if !unused.is_empty() {
        columns.said.push(format!("{} not used", unused.join(", ")));
    }
    Ok(columns)
}

impl Columns {
    /// Reads the units of the slip speeds, the friction and its errors.
    fn read_units(&mut self, table: &Table, machine: OfMachine) -> Result<(), (String, String)> {
        let error = self.error.map_or("", |column| table.name(column));
        let [speed, friction] = [self.speed, self.friction].map(|column| table.name(column));
        let is_position = self.position.is_some();
        let of_speed = if is_position { Dimension::Length } else { Dimension::Velocity };
        let turns = || is_of(speed, Motion::Rotation.unit(of_speed));
        self.motion = match machine.motion {
            Some(motion) => motion,
            None if turns() => Motion::Rotation,
            None => Motion::Translation,
        };
        let force = self.motion.unit(Dimension::Force);
        // A force beside the one that presses is a coefficient, row by row, unless the force itself is wanted.
        let normal = match table.of(Role::Normal)[..] {
            [one] if machine.forces != Some(true) => Some(one),
            _ => None,
        };
        let is_force = |name: &str| is_of(name, force);
        let is_divided = |normal: &usize| match [friction, table.name(*normal)] {
            both if both.iter().all(|name| unit_of(name, force).is_none()) => !is_coefficient(friction),
            both => both.into_iter().all(is_force),
        };
        let normal = normal.filter(is_divided);
        if normal.is_some() {
            self.forces = Some(true);
        } else if self.forces.is_none() {
            // The unit says which of the two it is.
            self.forces = match [force, ""].map(|wanted| is_of(friction, wanted)) {
                [true, false] => Some(true),
                [false, true] => Some(false),
                _ => None,
            };
        }
        let forces = self.forces == Some(true);
        let of_friction = if forces { force } else { "" };
        let velocity = self.motion.unit(of_speed);
        let what = if is_position { "positions" } else { "slip speeds" };
        let mut read = |field: &str, what: &str, wanted: &str| -> Result<f64, (String, String)> {
            let (factor, unit) = factor(field, what, wanted)?;
            if factor != 1.0 {
                self.said.push(format!("{what} in {unit}"));
            }
            Ok(factor)
        };
        let speeds = read(speed, what, velocity)?;
        let levels = read(friction, "friction", of_friction)?;
        if let (Some((column, factor)), true) = (&mut self.time, is_position) {
            *factor = read(table.name(*column), "times", self.motion.unit(Dimension::Time))?;
        }
        if !error.is_empty() && factor(error, "standard errors", of_friction)?.0 != levels {
            // An error without a unit is in that of the friction.
            if unit_of(error, of_friction).is_some() {
                let problem = "the standard errors are in another unit than the friction";
                return Err((problem.into(), "convert them, or correct the header".into()));
            }
        }
        let normal_factor = normal.map(|column| read(table.name(column), "normal force", of_friction));
        if unit_of(speed, velocity).is_none() {
            self.said.push(format!("{what} have no unit and are read in {velocity}"));
        }
        self.factors = [speeds, levels];
        if let (Some(column), Some(factor)) = (normal, normal_factor) {
            let name = table.name(column);
            self.factors[1] /= factor?;
            self.said.push(format!("coefficients: `{friction}` over `{name}`, row by row"));
            (self.normal, self.forces) = (normal, Some(false));
        }
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

/// Whether a header calls its column what was demanded, not what was measured.
fn is_set_point(field: &str) -> bool {
    let demanded = ["setpoint", "demand", "command", "target", "soll", "desired", "reference"];
    let text = field.to_lowercase();
    demanded.iter().any(|word| text.contains(word))
        || words(field).iter().any(|word| ["set", "cmd", "ref", "sp"].contains(&word.as_str()))
}

/// Whether a header says that its column is a coefficient of friction.
fn is_coefficient(field: &str) -> bool {
    let known = ["mu", "µ", "μ", "cof", "coefficient", "reibwert"];
    words(field).iter().any(|word| known.contains(&word.as_str()))
}

/// Parts of the names of forces and torques.
const FORCES: [&str; 6] = ["force", "torque", "kraft", "moment", "couple", "trq"];

/// Whether a header says that its column is a force in per cent, or in other parts of one that is not known.
fn is_share(field: &str) -> bool {
    let text = field.to_lowercase();
    FORCES.iter().any(|part| text.contains(part))
        && ["%", "‰", "percent", "per cent", "per mil", "per thousand"].iter().any(|part| text.contains(part))
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
    let [line, turn] = [Motion::Translation, Motion::Rotation];
    let kinds = [
        (Role::Speed, line.unit(Dimension::Velocity)),
        (Role::Speed, turn.unit(Dimension::Velocity)),
        (Role::Friction, line.unit(Dimension::Force)),
        (Role::Friction, turn.unit(Dimension::Force)),
        (Role::Time, line.unit(Dimension::Time)),
        (Role::Position, line.unit(Dimension::Length)),
        (Role::Position, turn.unit(Dimension::Length)),
    ];
    let by_unit = kinds.into_iter().find(|(_, unit)| is_of(field, unit)).map(|(role, _)| role);
    let other_unit = bracketed(field).is_some_and(|(before, inside)| !is_remark(field, before, inside));
    let is_normal = has(&["normal", "load", "pressure", "druck"])
        && by_unit.is_none_or(|role| role == Role::Friction)
        || ["fn", "n", "fz"].contains(&words.concat().as_str()) && by_unit == Some(Role::Friction);
    if is_normal {
        return if other_unit && by_unit != Some(Role::Friction) { Role::Other } else { Role::Normal };
    }
    if let Some(role) = by_unit {
        return role;
    }
    let lengths = ["position", "distance", "displacement", "travel", "angle", "winkel"];
    if has(&lengths) || any(&["pos", "weg", "x"]) {
        return if other_unit { Role::Other } else { Role::Position };
    }
    if has(&["speed", "velo", "geschw", "slip", "rpm", "drehzahl", "vitesse"])
        || any(&["v", "u", "vrel", "omega", "ω", "w"])
    {
        return Role::Speed;
    }
    let coefficient = ["phi", "φ", "f", "ff", "fr", "ft", "fx", "muk"];
    if has(&["friction", "reib", "frott"]) || has(&FORCES) || is_coefficient(field) || any(&coefficient) {
        return Role::Friction;
    }
    match has(&["time", "zeit", "temps"]) || any(&["t"]) {
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
