//! Parameter points on the command line and in tables, for any friction law.

use std::borrow::Cow;
use std::fmt::{self, Debug, Display, Formatter};
use std::path::PathBuf;

use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};

use super::Failure;
use super::output::exact;
use slipmap_config::{About, LawText, Measured, decimal_comma, has_unit, nearest, point_of, with_deviation};
use slipmap_machine::probe::{axis_names, flag};
use slipmap_model::friction::{Law, PointError};
use slipmap_model::point::Point;

/// Arguments of the friction law: `--law` and the options of laws given as text or as data.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Friction law")]
pub(super) struct LawArguments {
    #[arg(long, value_name = "NAME", value_parser = parse_name, help = about_laws())]
    law: Option<String>,
    /// Friction in units of the static one, as a formula in the slip speed u, eps and any names; give their
    /// values with --set
    #[arg(long, value_name = "FORMULA", conflicts_with = "table")]
    phi: Option<String>,
    /// Measured friction: a CSV file with the columns slip speed and friction
    #[arg(long, value_name = "FILE.csv")]
    table: Option<PathBuf>,
    /// Friction at rest in the units of the formula or the table, which is divided by it; above friction in slip
    /// where that begins lower. Leave it out where friction at rest is 1
    #[arg(long = "static", value_name = "NUMBER", value_parser = parse_number)]
    static_level: Option<f64>,
    /// The formula or the table beyond its first peak, with the peak as friction at rest: for smoothed laws, that
    /// rise from 0
    #[arg(long, value_name = "peak", value_parser = ["peak"], conflicts_with = "static_level")]
    rest: Option<String>,
    /// Read the law as 1 + eps F(u), with F = (phi - 1) / eps at the given eps: then the tests to first order
    /// in eps answer for every law
    #[arg(long, value_name = "eps", value_parser = ["eps"])]
    small: Option<String>,
}

fn about_laws() -> String {
    let [usual, others @ ..] = Law::BUILT_IN.map(|law| law.name());
    format!("{usual} (default), {}; expression with --phi; table with --table", others.join(", "))
}

fn parse_name(name: &str) -> Result<String, String> {
    let names: Vec<_> = Law::names().collect();
    match names.contains(&name) {
        true => Ok(name.to_owned()),
        false if name.contains(|c: char| !c.is_alphanumeric() && c != '_') => {
            Err("that is no name of a law; a formula is given with --phi".into())
        }
        false => Err(format!("there is no such law; {}", nearest("law", name, &names))),
    }
}

impl LawArguments {
    /// The law, with the parameters `exponent` and `drop` if the `point` has them.
    pub(super) fn law(&self, point: &PointArguments) -> Result<Law, Failure> {
        if let Some((name, value)) = point.with_units.first() {
            let problem = format!("--set {name}={value}: parameters of a law have no units");
            return Err(Failure::bad_input(problem, "write a number, or name a machine with --machine"));
        }
        let given = match (&self.phi, &self.table) {
            (Some(_), _) => Some("expression"),
            (None, Some(_)) => Some("table"),
            (None, None) => None,
        };
        let name = self.law.as_deref().or(given).unwrap_or(Law::Stribeck.name());
        if let Some(given) = given.filter(|given| *given != name) {
            let flag = if given == "table" { "--table" } else { "--phi" };
            let problem = format!("{flag} is for the law `{given}`, not for `{name}`");
            return Err(Failure::bad_input(problem, "leave one of them out"));
        }
        let text = LawText {
            name: name.to_owned(),
            phi: self.phi.clone(),
            static_level: self.static_level,
            rest: self.rest.clone(),
            file: self.table.as_ref().map(|path| path.display().to_string()),
            small: self.small.is_some(),
            axes: point.given.iter().map(|(name, _)| name.clone()).collect(),
            ..LawText::default()
        };
        let path = self.table.clone().unwrap_or_default();
        text.law_of(About::Oscillator, |how| Measured::read(&path, how)).map_err(|wrong| {
            let flag = if wrong.key == "file" { "table" } else { wrong.key };
            match (wrong.problem.is_empty(), flag) {
                (true, "table") => {
                    Failure::bad_input(format!("the law `{name}` needs --table FILE.csv"), "add it")
                }
                (true, flag) => {
                    Failure::bad_input(format!("the law `{name}` needs --{flag} FORMULA"), "add it")
                }
                (false, flag) => {
                    let problem = wrong.words(self.phi.as_deref().unwrap_or_default());
                    Failure::bad_input(format!("--{flag}: {problem}"), wrong.remedy)
                }
            }
        })
    }
}

/// `--epsilon`, the parameters of every law, `--V` and `--c`, as far as they are given; parameters also as
/// `--set NAME=NUMBER`.
#[derive(Clone, Debug)]
pub(super) struct PointArguments {
    /// The given parameters, by name.
    pub(super) given: Vec<(String, f64)>,
    /// Those that are given with a unit.
    with_units: Vec<(String, String)>,
}

fn parse_number(text: &str) -> Result<f64, String> {
    number(text, "write for example 0.5 or 1e-3, without a unit")
}

fn number(text: &str, usual: &str) -> Result<f64, String> {
    text.parse().map_err(|_| {
        let remedy = decimal_comma(text).unwrap_or_else(|| usual.into());
        format!("this is not a number; {remedy}")
    })
}

/// A value of `--set`: a number, in SI units for a quantity of a machine, or such a quantity with another unit.
#[derive(Clone, PartialEq)]
pub(super) enum Setting {
    Number(f64),
    WithUnit(String),
}

/// As in TOML.
impl Debug for Setting {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            // NaN is a bare word, hence a text, in TOML.
            Setting::Number(number) => write!(f, "{}", format!("{number:?}").to_lowercase()),
            Setting::WithUnit(text) => write!(f, "{text:?}"),
        }
    }
}

/// As on the command line.
impl Display for Setting {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Setting::Number(number) => write!(f, "{number}"),
            Setting::WithUnit(text) => write!(f, "'{text}'"),
        }
    }
}

pub(super) fn parse_setting(text: &str) -> Result<(String, Setting), String> {
    let (name, value) = text.split_once('=').ok_or("there is no `=` in it; write for example mu=0.3")?;
    if value.trim_start().starts_with('{') {
        return Err("write a quantity with a spread into the configuration; --set changes its value".into());
    }
    if value.contains('=') {
        return Err("write each quantity with a --set of its own: --set mu=0.3 --set vs=0.1".into());
    }
    // Also as `slipmap run` takes the quantities of a machine: machine.mass=1.
    let name = name.trim();
    let name = name.strip_prefix("machine.").unwrap_or(name).to_owned();
    let value = value.trim();
    // Also with the quotes of TOML.
    let text = value.trim_matches(['"', '\'']);
    if has_unit(text) || with_deviation(text).is_some() {
        return Ok((name, Setting::WithUnit(text.into())));
    }
    let usual = "write for example 0.5 or 1e-3; a quantity of a machine may have its unit: 2 kg";
    Ok((name, Setting::Number(number(value, usual)?)))
}

impl PointArguments {
    /// What is given, for a machine.
    pub(super) fn settings(&self) -> Vec<(String, Setting)> {
        let numbers = self.given.iter().map(|(name, value)| (name.clone(), Setting::Number(*value)));
        let others =
            self.with_units.iter().map(|(name, value)| (name.clone(), Setting::WithUnit(value.clone())));
        numbers.chain(others).collect()
    }

    /// The point of `law`; every axis of the law must have been given, and no other.
    pub(super) fn point(&self, law: &Law) -> Result<Point, Failure> {
        let axes = law.axis_names();
        let value = |name: &str| self.given.iter().find(|(given, _)| *given == name).map(|(_, value)| *value);
        let missing: Vec<_> = axes
            .iter()
            .filter(|name| value(name).is_none())
            .map(|name| flag(name).trim_end().to_owned())
            .collect();
        if !missing.is_empty() {
            // In a formula every other name is a parameter, but a common name of the slip speed is probably a
            // mistake.
            let slip = ["x", "s", "w"].iter().any(|name| axes.contains(name) && value(name).is_none());
            let slip = if slip { "the slip speed is called u or v; " } else { "" };
            let example: String = axes
                .iter()
                .filter(|name| value(name).is_none())
                .map(|name| format!(" {}1", flag(name)))
                .collect();
            let help = format!(
                "{slip}give a table with --points IN.csv --out OUT.csv, or every parameter, for example{example}"
            );
            let problem = format!("the law `{}` also needs {}", law.name(), missing.join(", "));
            return Err(Failure::bad_input(problem, help));
        }
        self.refuse_foreign(law)?;
        let values: Vec<f64> = axes.iter().filter_map(|name| value(name)).collect();
        let point = point_of(law, &values).map_err(|error| {
            let PointError::OutOfDomain { name, value, domain: wanted } = error else {
                unreachable!("{error}")
            };
            let problem = format!("{}{}: not a legal value", flag(name), exact(value));
            Failure::bad_input(problem, format!("{name} must be {wanted}"))
        })?;
        check_law(law, &point).map_err(Failure::BadInput)?;
        Ok(point)
    }

    /// Refuses a parameter that does not belong to the law.
    pub(super) fn refuse_foreign(&self, law: &Law) -> Result<(), Failure> {
        let axes = law.axis_names();
        match self.given.iter().find(|(name, _)| !axes.contains(&name.as_str())) {
            None => Ok(()),
            Some((foreign, _)) => {
                let problem = format!("--{foreign} is not a parameter of the law `{}`", law.name());
                Err(Failure::bad_input(problem, format!("its parameters are {}", axes.join(", "))))
            }
        }
    }
}

/// Checks that the law is legal at the slip speeds of a point.
pub(super) fn check_law(law: &Law, point: &Point) -> Result<(), String> {
    slipmap_config::check_law(law, point).map_err(|wrong| {
        let (flag, text) = match law.as_written() {
            Law::Expression(law) => ("--phi: ", law.text()),
            _ => ("", Cow::default()),
        };
        format!("{flag}{}\n  help: {}", wrong.words(&text), wrong.remedy)
    })
}

impl Args for PointArguments {
    fn augment_args(command: Command) -> Command {
        let command = command.arg(
            Arg::new("set")
                .long("set")
                .value_name("NAME=NUMBER")
                .help("A parameter of a law given as a formula, or a quantity of a machine, perhaps with its unit; may be repeated")
                .help_heading("Point")
                .action(ArgAction::Append)
                .value_parser(parse_setting),
        );
        axis_names().into_iter().fold(command, |command, name| {
            // A small v means the belt speed, not a parameter of another law.
            let aliases: &[&'static str] = if name == "V" { &["v"] } else { &[] };
            command.arg(
                Arg::new(name)
                    .long(name)
                    .aliases(aliases)
                    .value_name("NUMBER")
                    .help(description(name))
                    .help_heading("Point")
                    .value_parser(parse_number)
                    .allow_negative_numbers(true),
            )
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for PointArguments {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let flags = axis_names()
            .into_iter()
            .filter_map(|name| matches.get_one::<f64>(name).map(|value| (name.to_owned(), *value)));
        let mut found = Self { given: flags.collect(), with_units: Vec::new() };
        for (name, setting) in matches.get_many::<(String, Setting)>("set").into_iter().flatten().cloned() {
            let mut names = found.given.iter().map(|(name, _)| name);
            if names.any(|it| *it == name) || found.with_units.iter().any(|(it, _)| *it == name) {
                let problem =
                    format!("--set {name}={setting}: {name} is given twice; leave one of them out\n");
                return Err(clap::Error::raw(ErrorKind::ArgumentConflict, problem));
            }
            match setting {
                Setting::Number(number) => found.given.push((name, number)),
                Setting::WithUnit(text) => found.with_units.push((name, text)),
            }
        }
        Ok(found)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// Description of an axis, in one phrase.
fn description(name: &str) -> String {
    let known = Law::BUILT_IN.map(Law::with_exponent);
    let of_law = |law| Law::parameters(law).iter().find(|parameter| parameter.name == name);
    let phrase = match (name, known.iter().find_map(of_law)) {
        (_, Some(parameter)) => parameter.long_name,
        ("epsilon", None) => "size of the small terms, greater than 0",
        ("V", None) => "belt speed, greater than 0",
        (_, None) => "viscous damping, at least 0",
    };
    let mut letters = phrase.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::*;
    use slipmap_machine::probe::command_line;

    #[derive(clap::Parser)]
    struct Line {
        #[command(flatten)]
        point: PointArguments,
        #[arg(long)]
        tolerance: Option<f64>,
    }

    #[test]
    fn a_probe_line_is_the_point() {
        let values = [1e-3, 1.0 / 3.0, 0.0, 1e17, 2.0, 5e-324];
        let point = point_of(&Law::Stribeck, &values).unwrap();
        assert_eq!(
            Law::Stribeck.coordinates(&point).iter().map(|(_, value)| *value).collect::<Vec<_>>(),
            values
        );
        for tolerance in [slipmap_column::DEFAULT_TOLERANCE, 1e-12] {
            let line = command_line(&Law::Stribeck, &point, tolerance);
            let read = Line::try_parse_from(line.strip_prefix("slipmap ").unwrap().split(' ')).unwrap();
            assert_eq!(read.point.point(&Law::Stribeck).unwrap(), point);
            assert_eq!(read.tolerance.unwrap_or(slipmap_column::DEFAULT_TOLERANCE), tolerance);
        }
    }
}
