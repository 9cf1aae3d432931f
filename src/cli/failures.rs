//! `slipmap failures`: where and why each method fails on a grid.

use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use clap::Args;

use super::configuration::Configuration;
use super::output::{count, exact, short};
use super::replace::Files;
use super::report::{failure, unwritten};
use super::summary::refuse_machine;
use super::threads::not_started;
use super::{Ended, Failure, interrupt, progress};
use slipmap_column::Method;
use slipmap_column::limits::HIGHEST;
use slipmap_config::Job;
use slipmap_files::csv::csv_text;
use slipmap_files::{Existing, create_folders, write_file};
use slipmap_machine::probe::command_line;
use slipmap_numbers::text::{known_part, rounded};
use slipmap_orbits::naive::NaiveKnobs;

use slipmap_study::failures::{
    self, Catalogue, Changed, Class, Comparison, FailureKind, MethodFailures, Widths,
};

/// Largest number of cells: more would take hours.
const MOST_CELLS: usize = 10_000_000;

/// Compare every method with the simulated flow on a grid, and explain each failure.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  slipmap failures configs/failures.toml
  slipmap failures configs/failures.toml --out results/failures

The configuration is that of `slipmap run`; its methods are compared at every cell of its grid, nothing is \
stored as a map. Without --out the tables are printed as Markdown. With it, DIR/failures.md holds them, \
DIR/methods.csv one row per method and DIR/classes.csv one row per class of failure.")]
pub(super) struct Arguments {
    #[command(flatten)]
    configuration: Configuration,
    /// The folder to write
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the files of an earlier catalogue
    #[arg(long, requires = "out")]
    overwrite: bool,
    /// Number of threads; default: one per core
    #[arg(long, value_name = "NUMBER", value_parser = super::threads::parse)]
    threads: Option<usize>,
    /// No progress bar
    #[arg(long)]
    quiet: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<Ended, Failure> {
    let job = arguments.configuration.load()?;
    let grid = &job.plan.grid;
    refuse_machine(&job)?;
    if grid.cells() > MOST_CELLS {
        let (cells, most) = (count(grid.cells()), count(MOST_CELLS));
        let problem = format!("the grid has {cells} cells; a catalogue takes at most {most}");
        return Err(Failure::bad_input(problem, "take fewer points on the axes"));
    }
    if let Some(folder) = &arguments.out {
        let mut files = Files::reading([&arguments.configuration.config]).law(grid.law());
        for name in FILES {
            files = files.writing("--out", Some(&folder.join(name)));
        }
        files.check(arguments.overwrite)?;
    }
    let pool = slipmap_map::pool(arguments.threads).map_err(not_started)?;
    let points = failures::points_of(grid);
    let bar = progress::bar(arguments.quiet, Some(points.len() as u64), "cells");
    let comparison = Comparison {
        law: grid.law(),
        methods: &job.plan.methods,
        tolerance: job.plan.tolerance,
        on_point: &|| bar.inc(1),
        stop: interrupt::flag(),
    };
    let found = pool.install(|| failures::catalogue(&points, &comparison));
    bar.finish_and_clear();
    let catalogue =
        found.map_err(|failures::Interrupted| Failure::Interrupted(super::NOTHING_LEFT.into()))?;
    let report = CataloguePage { command: command(arguments), job: &job, catalogue: &catalogue };
    match &arguments.out {
        None => io::stdout().lock().write_all(report.markdown().as_bytes())?,
        Some(folder) => {
            write_files(folder, &report)?;
            writeln!(io::stdout().lock(), "{}", folder.join(FILES[0]).display())?;
        }
    }
    Ok(if catalogue.truth.open > 0 { Ended::Flawed } else { Ended::Fine })
}

/// The command line that repeats this catalogue.
fn command(arguments: &Arguments) -> String {
    let mut line = format!("slipmap failures {}", arguments.configuration.words());
    if let Some(folder) = &arguments.out {
        line.push_str(&format!(" --out {}", folder.display()));
    }
    line
}

const FILES: [&str; 3] = ["failures.md", "methods.csv", "classes.csv"];

/// Writes every file under a temporary name first, so that no file is ever half written.
fn write_files(folder: &Path, report: &CataloguePage) -> Result<(), Failure> {
    create_folders(folder).map_err(|error| unwritten(folder, &error))?;
    for (name, text) in FILES.iter().zip([report.markdown(), report.methods_csv(), report.classes_csv()]) {
        write_file(text.as_bytes(), &folder.join(name), Existing::Replace).map_err(failure)?;
    }
    Ok(())
}

/// The page of a catalogue: its command line, its job and the catalogue.
struct CataloguePage<'a> {
    command: String,
    job: &'a Job,
    catalogue: &'a Catalogue,
}

impl CataloguePage<'_> {
    fn markdown(&self) -> String {
        let mut text = String::new();
        // Writing to a String cannot fail.
        let _ = self.write_markdown(&mut text);
        text
    }

    fn write_markdown(&self, out: &mut String) -> std::fmt::Result {
        let Catalogue { truth, methods, smoothing } = self.catalogue;
        writeln!(out, "# {}\n", self.job.title)?;
        writeln!(out, "Made by `{}`.\n", self.command)?;
        writeln!(out, "{}\n", self.box_in_words())?;
        writeln!(
            out,
            "Truth is the simulated flow, on which two independent engines agree: {} cells with a stick-slip cycle, {} \
             whose orbit spirals inward, {} whose orbit crosses the belt line for ever. {} cells are too close to a \
             boundary to call and {} without an answer; they are left out.\n",
            count(truth.present),
            count(truth.inward),
            count(truth.crossing),
            count(truth.too_close),
            count(truth.open)
        )?;
        writeln!(
            out,
            "| method | guarantee | right | wrong presence | wrong absence | undecided | failed | farthest wrong in c | its \
             error | farthest wrong in epsilon |"
        )?;
        writeln!(out, "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |")?;
        for method in methods {
            let counts = FailureKind::ALL.map(|kind| count(method.count(kind))).join(" | ");
            let [c, error, epsilon] = method.farthest_wrong();
            let [c, error] = with_error(c, error);
            writeln!(
                out,
                "| {} | {} | {} | {counts} | {c} | {error} | {} |",
                method.method.name(),
                method.method.guarantee().name(),
                count(method.right()),
                short(epsilon)
            )?;
        }
        writeln!(
            out,
            "\nThe last columns are the largest distance from a wrong cell to the nearest damping, or epsilon, at which \
             the simulated verdict changes; cells from which it changes nowhere (in epsilon: nowhere up to {}) are not \
             counted there.\n\n## Classes of failure\n\n\
             A mechanism explains a failure if the same method without it does not fail there.\n",
            short(HIGHEST)
        )?;
        writeln!(
            out,
            "| method | failure | mechanism | cells | farthest in c | its error | farthest in epsilon | because |"
        )?;
        writeln!(out, "| --- | --- | --- | ---: | ---: | ---: | ---: | --- |")?;
        for (method, class) in self.classes() {
            let [c, error] = with_error(class.farthest_c, class.farthest_c_error);
            writeln!(
                out,
                "| {} | {} | {} | {} | {c} | {error} | {} | {} |",
                method.method.name(),
                class.kind.name().replace('_', " "),
                class.mechanism.name().replace('_', " "),
                count(class.cells),
                short(class.farthest_epsilon),
                class.mechanism.explanation().replace('|', "\\|")
            )?;
        }
        if let Some(widths) = smoothing {
            write_widths(out, widths)?;
        }
        writeln!(out, "\n## One cell of each class\n")?;
        if let Some(knobs) = self.knobs() {
            writeln!(
                out,
                "`slipmap probe` asks naive methods with their default choices; here they were {knobs}.\n"
            )?;
        }
        writeln!(out, "```sh")?;
        for (method, class) in self.classes() {
            let words = [method.method.name(), class.kind.name(), class.mechanism.name()].join(": ");
            writeln!(out, "# {}", words.replace('_', " "))?;
            writeln!(out, "{}", self.probe(class))?;
        }
        writeln!(out, "```")
    }

    fn classes(&self) -> impl Iterator<Item = (&MethodFailures, &Class)> {
        self.catalogue
            .methods
            .iter()
            .flat_map(|method| method.classes.iter().map(move |class| (method, class)))
    }

    fn probe(&self, class: &Class) -> String {
        command_line(self.job.plan.grid.law(), &class.example, self.job.plan.tolerance)
    }

    /// The settings of the naive methods, unless they are the default ones.
    fn knobs(&self) -> Option<String> {
        let chosen = self.job.plan.methods.iter().find_map(|method| match method {
            Method::Naive(_, knobs) if *knobs != NaiveKnobs::default() => Some(knobs),
            _ => None,
        })?;
        Some(format!("{chosen:?}"))
    }

    /// Size and ranges of the grid: "1,200 cells: 5 epsilon from 0.001 to 1, ..".
    fn box_in_words(&self) -> String {
        let grid = &self.job.plan.grid;
        let axes = grid.axes().iter().map(|axis| match axis.values.as_slice() {
            [only] => format!("{} = {}", axis.name, exact(*only)),
            [first, .., last] => {
                format!("{} {} from {} to {}", axis.values.len(), axis.name, exact(*first), exact(*last))
            }
            [] => axis.name.to_string(),
        });
        format!("{} cells: {}.", count(grid.cells()), axes.collect::<Vec<_>>().join(", "))
    }

    fn methods_csv(&self) -> String {
        let mut header = vec!["method", "guarantee", "cells", "right"];
        header.extend(FailureKind::ALL.map(FailureKind::name));
        header.extend(["farthest_wrong_c", "farthest_wrong_c_error", "farthest_wrong_epsilon"]);
        let rows = self.catalogue.methods.iter().map(|method| {
            let mut row = vec![method.method.name().to_owned(), method.method.guarantee().name().to_owned()];
            row.extend([method.cells, method.right()].map(|n| n.to_string()));
            row.extend(FailureKind::ALL.map(|kind| method.count(kind).to_string()));
            row.extend(method.farthest_wrong().map(number));
            row
        });
        csv_text(header.into_iter().map(str::to_owned).collect(), rows)
    }

    fn classes_csv(&self) -> String {
        let law = self.job.plan.grid.law();
        let mut header = vec!["method", "failure", "mechanism", "cells"];
        header.extend(["farthest_c", "farthest_c_error", "farthest_epsilon"]);
        header.extend(law.axis_names());
        header.push("probe");
        let rows = self.classes().map(|(method, class)| {
            let words = [method.method.name(), class.kind.name(), class.mechanism.name()];
            let mut row: Vec<String> = words.map(str::to_owned).into();
            row.push(class.cells.to_string());
            row.extend([class.farthest_c, class.farthest_c_error, class.farthest_epsilon].map(number));
            row.extend(law.coordinates(&class.example).into_iter().map(|(_, value)| exact(value)));
            row.push(self.probe(class));
            row
        });
        csv_text(header.into_iter().map(str::to_owned).collect(), rows)
    }
}

/// The widths at which smoothed friction is a per cent off.
fn write_widths(out: &mut String, widths: &[Widths; 3]) -> std::fmt::Result {
    writeln!(
        out,
        "\n## How narrow smoothed friction must be\n\n\
         Friction with tanh(s/d) for its sign does not hold: under the share f of the friction at rest the mass creeps \
         along the belt at d artanh f, 0.55 d at one half, until friction has fallen. The widths d, in belt speeds, at \
         which it is 1 % off, at some of the cells with a stick-slip cycle; where none is told a cell is right or wrong at \
         all widths that can be followed.\n"
    )?;
    writeln!(
        out,
        "| 1 % off | cells | least d/V | median | greatest |\n| --- | ---: | ---: | ---: | ---: |"
    )?;
    for Widths { of, found } in widths {
        let what = match of {
            Changed::Verdict => "verdict: the critical damping",
            Changed::Period => "period",
            Changed::Creep => "creep at half of the friction at rest, over V",
        };
        let at = |place: usize| found.get(place).map_or("-".into(), |width| rounded(*width, 2));
        let last = found.len().saturating_sub(1);
        writeln!(out, "| {what} | {} | {} | {} | {} |", found.len(), at(0), at(last / 2), at(last))?;
    }
    Ok(())
}

/// A number without the digits beyond its error, at most six, and that error, for the page.
fn with_error(value: f64, error: f64) -> [String; 2] {
    [short(known_part(value, error)[0]), rounded(error, 2)]
}

/// A number for a table; empty if there is none.
fn number(x: f64) -> String {
    if x.is_nan() { String::new() } else { exact(x) }
}
