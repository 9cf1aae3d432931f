//! A parameter point on the command line and in tables, for any friction law.

use clap::{Arg, ArgMatches, Args, Command, FromArgMatches, Id};

use super::Failure;
use super::output::exact;
use crate::friction::Law;
use crate::map::{Grid, GridError};
use crate::point::Point;

/// The law of an argument `--law`.
pub(super) fn parse_law(name: &str) -> Result<Law, String> {
    let names: Vec<_> = Law::ALL.iter().map(|law| law.name()).collect();
    let law = Law::ALL.into_iter().find(|law| law.name() == name);
    law.ok_or_else(|| format!("there is no such law; choose from: {}", names.join(", ")))
}

/// `--epsilon`, the parameters of every law, `--V` and `--c`, as far as they were given.
#[derive(Clone, Debug)]
pub(super) struct PointArguments {
    given: Vec<(&'static str, f64)>,
}

/// The names of all axes of all laws, without repetition.
fn names() -> Vec<&'static str> {
    let mut names = Vec::new();
    for name in Law::ALL.into_iter().flat_map(Grid::axis_names) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

fn parse_number(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| "this is not a number; write for example 0.5 or 1e-3".into())
}

impl PointArguments {
    /// Whether any parameter was given.
    pub(super) fn is_empty(&self) -> bool {
        self.given.is_empty()
    }

    /// The point of `law`; every axis of the law must have been given, and no other.
    pub(super) fn point(&self, law: Law) -> Result<Point, Failure> {
        let axes = Grid::axis_names(law);
        let value = |name: &str| self.given.iter().find(|(given, _)| *given == name).map(|(_, value)| *value);
        let missing: Vec<_> =
            axes.iter().filter(|name| value(name).is_none()).map(|name| format!("--{name}")).collect();
        if !missing.is_empty() {
            return Err(Failure::BadInput(format!(
                "the law `{}` also needs {}\n  help: give every parameter, or a table with --points IN.csv --out OUT.csv",
                law.name(),
                missing.join(", ")
            )));
        }
        if let Some((foreign, _)) = self.given.iter().find(|(name, _)| !axes.contains(name)) {
            return Err(Failure::BadInput(format!(
                "--{foreign} is no parameter of the law `{}`\n  help: its parameters are {}",
                law.name(),
                axes.join(", ")
            )));
        }
        let values: Vec<f64> = axes.iter().filter_map(|name| value(name)).collect();
        from_values(law, &values).map_err(|error| {
            let (name, value, wanted) = complaint(&error);
            Failure::BadInput(format!(
                "--{name} {value}: {name} must be {wanted}\n  help: choose a value that is"
            ))
        })
    }
}

impl Args for PointArguments {
    fn augment_args(command: Command) -> Command {
        names().into_iter().fold(command, |command, name| {
            command.arg(
                Arg::new(name)
                    .long(name)
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

    fn group_id() -> Option<Id> {
        None
    }
}

impl FromArgMatches for PointArguments {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given = names()
            .into_iter()
            .filter_map(|name| matches.get_one::<f64>(name).map(|value| (name, *value)))
            .collect();
        Ok(Self { given })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// What an axis is, in one phrase.
fn description(name: &str) -> String {
    let of_law = |law: Law| law.parameters().iter().find(|parameter| parameter.name == name);
    let phrase = match (name, Law::ALL.into_iter().find_map(of_law)) {
        (_, Some(parameter)) => parameter.long_name,
        ("epsilon", None) => "size of the small terms, greater than 0",
        ("V", None) => "belt speed, greater than 0",
        (_, None) => "viscous damping, at least 0",
    };
    let mut letters = phrase.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// The point with the given value on each axis, in the order of [`Grid::axis_names`].
pub(super) fn from_values(law: Law, values: &[f64]) -> Result<Point, GridError> {
    // A point is legal exactly when the grid of this one cell is.
    let grid = Grid::new(law, values.iter().map(|&value| vec![value]).collect())?;
    Ok(grid.point(&vec![0; values.len()]))
}

/// The coordinates of a point, in the order of [`Grid::axis_names`].
pub(super) fn coordinates(law: Law, point: &Point) -> Vec<(&'static str, f64)> {
    let values = std::iter::once(point.epsilon)
        .chain(point.law.as_slice().iter().copied())
        .chain([point.belt_speed, point.damping]);
    Grid::axis_names(law).into_iter().zip(values).collect()
}

/// Which coordinate of a point is illegal, its value, and what it must be.
pub(super) fn complaint(error: &GridError) -> (String, String, String) {
    match error {
        GridError::OutOfDomain { axis, value, domain } => (axis.clone(), exact(*value), domain.clone()),
        GridError::NotFinite { axis, value } => (axis.clone(), exact(*value), "finite".into()),
        // A grid of one cell has no other faults.
        other => (String::new(), String::new(), other.to_string()),
    }
}

/// The command that explains a point, ready to paste.
pub(super) fn probe_line(law: Law, point: &Point, tolerance: f64) -> String {
    let mut line = String::from("slipmap probe");
    if law != Law::ALL[0] {
        line.push_str(&format!(" --law {}", law.name()));
    }
    for (name, value) in coordinates(law, point) {
        line.push_str(&format!(" --{name} {}", exact(value)));
    }
    if tolerance != crate::config::DEFAULT_TOLERANCE {
        line.push_str(&format!(" --tolerance {}", exact(tolerance)));
    }
    line
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::*;

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
        let point = from_values(Law::Stribeck, &values).unwrap();
        assert_eq!(
            coordinates(Law::Stribeck, &point).iter().map(|(_, value)| *value).collect::<Vec<_>>(),
            values
        );
        for tolerance in [crate::config::DEFAULT_TOLERANCE, 1e-12] {
            let line = probe_line(Law::Stribeck, &point, tolerance);
            let read = Line::try_parse_from(line.strip_prefix("slipmap ").unwrap().split(' ')).unwrap();
            assert_eq!(read.point.point(Law::Stribeck).unwrap(), point);
            assert_eq!(read.tolerance.unwrap_or(crate::config::DEFAULT_TOLERANCE), tolerance);
        }
    }
}
