//! `slipmap machine`: the engineer's page of a machine.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use clap::Args;
use serde_json::Value;

use super::chances::notes_on_draws;
use super::output::{Align, TextTable, print_json};
use super::point::{Setting, parse_setting};
use super::probe_machine;
use super::replace::Files;
use super::report::{existing, failure};
use super::{Ended, Failure};
use slipmap_config::MachineJob;
use slipmap_figure::write_figure;
use slipmap_files::write_file;
use slipmap_machine::BELT_SPEED;
use slipmap_machine::assessment::{Assessment, assess_fitted};
use slipmap_machine::risk::{MOST_DRAWS, NoRisk, Risk, is_uncertain, risk};
use slipmap_page::{MachinePage, Subject, to_json};

/// Assess a machine at its working point, on one page.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  slipmap machine configs/brake_pad.toml --set belt_speed=0.1 --set damping=50
  slipmap machine configs/brake_pad.toml --set belt_speed=0.1 --set damping=50 --out brake.pdf
  slipmap machine configs/brake_pad.toml --set belt_speed=0.1 --set damping=50 --json
  slipmap machine before.toml after.toml --out both.pdf

The speeds and dampings below which the machine stick-slips or may do so, the motion, the kick that starts it, what it \
depends on, and what is proved. Quantities of [machine] that are written \"2 kg +- 5 %\" or { min = 1.8, \
max = 2.2 } are uncertain, and so is a table of friction with standard errors: then also the probability that it may \
stick-slip, and the dampings that make it rare.")]
pub(super) struct Arguments {
    /// The configuration, with a table [machine]; of two, both machines are on the page
    #[arg(value_name = "CONFIG.toml", required = true, num_args = 1..=2)]
    configs: Vec<PathBuf>,
    /// Choose a quantity of the machine, in SI units or with its unit; may be repeated. A quantity with an sd keeps it
    #[arg(long, value_name = "NAME=NUMBER", value_parser = parse_setting)]
    set: Vec<(String, Setting)>,
    /// Write the page; .pdf, .svg, .png or .html
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Draws of the uncertain quantities, at most ten million; default: 100000, or as many as take some seconds
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(100..=MOST_DRAWS as i64))]
    draws: Option<u32>,
    /// Probabilities for which the damping is sought
    #[arg(long, value_name = "P", value_delimiter = ',', default_values_t = [0.1, 0.01, 0.001],
          value_parser = parse_probability)]
    rare: Vec<f64>,
    /// Print JSON instead of text
    #[arg(long)]
    json: bool,
    /// Replace the page if it exists
    #[arg(long)]
    overwrite: bool,
}

/// Why there are fewer draws than usual.
const FEWER: &str = "the search for the critical damping of a draw takes long here, so there are fewer draws than usual; \
                     --draws takes more, and the time for them";

fn parse_probability(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| *value > 0.0 && *value < 1.0);
    value.ok_or_else(|| "write a number between 0 and 1".into())
}

pub(super) fn run(arguments: &Arguments) -> Result<Ended, Failure> {
    let jobs = arguments.configs.iter().map(|config| probe_machine::load_over_speeds(config, &arguments.set));
    let jobs = jobs.collect::<Result<Vec<MachineJob>, Failure>>()?;
    let files =
        jobs.iter().fold(Files::reading(&arguments.configs), |files, job| files.machine(&job.machine));
    files.writing("--out", arguments.out.as_deref()).check(arguments.overwrite)?;
    let machines =
        arguments.configs.iter().zip(jobs).map(|(config, job)| Machine::of(config, job, arguments));
    let machines = machines.collect::<Result<Vec<Machine>, Failure>>()?;
    let pages: Vec<MachinePage> = machines.iter().map(Machine::page).collect();
    if let Some(path) = &arguments.out {
        let existing = existing(arguments.overwrite);
        let html = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("html"));
        if html {
            write_file(MachinePage::html(&pages).as_bytes(), path, existing).map_err(failure)?;
        } else {
            let (scene, caption) = (MachinePage::scene(&pages), MachinePage::caption(&pages));
            write_figure(&scene, &caption, path, existing).map_err(failure)?;
        }
    }
    if arguments.json {
        let all: Vec<Value> = machines.iter().map(|it| to_json(&it.all, it.risk.as_ref())).collect();
        match all.as_slice() {
            [one] => print_json(one)?,
            several => print_json(&several)?,
        }
        return Ok(Ended::Fine);
    }
    write(&mut io::stdout().lock(), &machines, &pages)?;
    Ok(Ended::Fine)
}

/// One of the machines of a page.
struct Machine {
    job: MachineJob,
    all: Assessment,
    risk: Option<Risk>,
    title: String,
    source: String,
}

impl Machine {
    fn of(config: &Path, job: MachineJob, arguments: &Arguments) -> Result<Self, Failure> {
        let leaves = || Failure::bad_input("the friction leaves the numbers", "check the units");
        let all = assess_fitted(&job.machine, &job.uncertain).ok_or_else(leaves)?;
        let risk = match is_uncertain(&job.machine, &job.uncertain) {
            false => None,
            true => {
                let draws = arguments.draws.map(|draws| draws as usize);
                match risk(&job.machine, &job.uncertain, draws, &arguments.rare, None) {
                    Ok(found) => Some(found),
                    // The page reports it; the rest of the page does not depend on it.
                    Err(NoRisk::NoneFound | NoRisk::NoneFollowed) => None,
                    Err(why) => return Err(Failure::bad_input(why, "choose smaller spreads")),
                }
            }
        };
        let stem =
            || config.file_stem().map_or_else(|| "machine".into(), |stem| stem.to_string_lossy().into());
        let title = job.title.clone().unwrap_or_else(stem);
        Ok(Self { job, all, risk, title, source: source(config, arguments) })
    }

    /// The least and the largest belt speed of the configuration, if there are several.
    fn speeds(&self) -> Option<[f64; 2]> {
        let (_, speeds) = self.job.varied.iter().find(|(name, _)| *name == BELT_SPEED)?;
        Some([*speeds.first()?, *speeds.last()?])
    }

    fn page(&self) -> MachinePage<'_> {
        let subject = Subject {
            title: &self.title,
            uncertain: &self.job.uncertain,
            units: &self.job.units,
            speeds: self.speeds(),
            risk: self.risk.as_ref(),
            source: &self.source,
        };
        MachinePage::new(&self.all, &subject)
    }
}

/// Prints the pages as text; questions that several answer once, with the answers beside each other.
fn write(out: &mut dyn Write, machines: &[Machine], pages: &[MachinePage]) -> io::Result<()> {
    for (machine, page) in machines.iter().zip(pages) {
        writeln!(out, "{}", machine.title)?;
        for line in page.answers.iter().chain(&page.warnings) {
            writeln!(out, "{}", line.plain())?;
        }
    }
    let mut headings: Vec<&str> = Vec::new();
    for (heading, _) in pages.iter().flat_map(|page| &page.sections) {
        if !headings.contains(heading) {
            headings.push(heading);
        }
    }
    for heading in headings {
        writeln!(out, "\n{heading}")?;
        let mut rows: Vec<(String, Vec<String>)> = Vec::new();
        for (position, page) in pages.iter().enumerate() {
            let sections = page.sections.iter().filter(|(known, _)| *known == heading);
            for (name, value) in sections.flat_map(|(_, lines)| lines) {
                let name = name.plain();
                // A question may be asked twice of one machine.
                let row = rows.iter().position(|(known, values)| *known == name && values.len() <= position);
                let row = row.unwrap_or_else(|| {
                    rows.push((name, Vec::new()));
                    rows.len() - 1
                });
                rows[row].1.resize(position, String::new());
                rows[row].1.push(value.plain());
            }
        }
        let mut table = TextTable::new(&vec![("", Align::Left); 1 + pages.len()]);
        for (name, values) in rows {
            table.row([name].into_iter().chain(values));
        }
        table.write(out)?;
    }
    for risk in machines.iter().filter_map(|machine| machine.risk.as_ref()) {
        for note in notes_on_draws(risk.draws + risk.failed, risk.failed, risk.redrawn) {
            writeln!(out, "\n{note}")?;
        }
        if risk.fewer {
            writeln!(out, "\n{FEWER}")?;
        }
    }
    Ok(())
}

/// Program, day and configuration: "slipmap 0.2.0, 2026-11-24: pad.toml --set damping=50".
fn source(config: &Path, arguments: &Arguments) -> String {
    let date = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    let day = date.split('T').next().unwrap_or_default();
    let file = config.file_name().unwrap_or_default().to_string_lossy();
    let sets: String = arguments.set.iter().map(|(name, value)| format!(" --set {name}={value}")).collect();
    format!("slipmap {}, {day}: {file}{sets}", env!("CARGO_PKG_VERSION"))
}
