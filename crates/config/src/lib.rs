//! Configuration files: read, validated and converted to a [`Job`].
//!
//! Keys and values are those of docs/configuration.md, which tests compare with this reader.
//!
//! The output path is relative to the current folder; its folders are created when the run starts. Everything
//! is checked before anything is computed or written. The text kept in the job has the overrides applied and
//! keeps its comments.

mod axis;
mod curves;
mod described;
mod fitted;
mod law;
mod machine;
mod measured;
mod points;
mod source;
mod uncertain;
mod units;
mod written;

use std::path::{Path, PathBuf};

pub use axis::range_nodes;
pub use law::point_into;

pub use described::{About, FitText, LawText, Origin, Wrong, with_axes};
pub use machine::{MachineJob, check_names, load_machine, machine_of};
pub use measured::{
    Direction, Fits, Fitted, FittedLaw, How, Level, Measured, MeasuredReading, ONE_AT_REST, OfMachine,
    RowKind, law_of, words_of,
};
pub use points::{PointTable, check_law, point_of};
pub use source::ConfigError;
pub use source::decimal_comma;
use source::{ConfigFile, Node, Section};
pub use uncertain::{share, with_deviation};
pub use units::{conversion, has_unit, head_of, number_in, size, size_on_disc, with_unit};
pub use written::{nodes, quoted};

use slipmap_certify::validated;
use slipmap_column::{DEFAULT_TOLERANCE, Method, TOLERANCES};
use slipmap_machine::risk::Uncertain;
use slipmap_map::{
    DEFAULT_AUDIT_CELLS, DEFAULT_COMPRESSION, DEFAULT_PROOF_BOXES, Field, Grid, GridError, MOST_AUDIT_CELLS,
    Plan, Shown,
};
use slipmap_model::friction::Law;
use slipmap_orbits::naive::NaiveKnobs;

/// A validated configuration: what to compute, and where to write it.
#[derive(Clone, Debug)]
pub struct Job {
    /// The computation.
    pub plan: Plan,
    /// Title of the map.
    pub title: String,
    /// The uncertain quantities.
    pub uncertain: Vec<Uncertain>,
    /// The units of a machine's quantities in the file; `None` is the SI unit.
    pub units: Vec<(&'static str, Option<Shown>)>,
    /// What units in the file are in SI: "1 rpm is 0.10472 rad/s".
    pub conversions: Vec<String>,
    /// The configuration file.
    pub config_file: PathBuf,
    /// The text of the configuration, overrides applied.
    pub config_text: String,
    /// The map file to write.
    pub output: PathBuf,
    /// Path of the certificate of what is proved between the nodes.
    pub proof: Option<PathBuf>,
    /// Settings of a study of speed against accuracy.
    pub work_precision: StudySettings,
}

/// StudySettings of a study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StudySettings {
    /// Number of cells, half of them near the boundary as far as there is one.
    pub cells: usize,
    /// Largest distance in c from the boundary of the cells near it.
    pub near: f64,
    /// Processor time in seconds that slow methods may use at each setting.
    pub seconds: f64,
}

impl Default for StudySettings {
    fn default() -> Self {
        Self { cells: 1024, near: 0.01, seconds: 1.0 }
    }
}

impl Job {
    /// Reads and validates `file` under the overrides `sets`, each `key.path=value` with a TOML value.
    ///
    /// # Errors
    /// The first error, with its place, its value and a remedy.
    pub fn load(file: &Path, sets: &[String]) -> Result<Job, ConfigError> {
        let source = ConfigFile::load(file, sets)?;
        let root = source.root();
        // Before the friction, which is read otherwise for a machine.
        refuse_unknown_sections(&root)?;
        let friction = root.section("friction")?;
        let folder = file.parent().unwrap_or(Path::new(""));
        let (axes, machine) = (root.section("grid")?, root.section("machine")?);
        if axes.is_present() && machine.is_present() {
            let remedy = "give the axes in [grid] or the machine in [machine], and leave the other out";
            return Err(root.unknown("machine", remedy.into()));
        }
        let alone = machine.is_present();
        let about = match alone {
            true => About::Machine(machine::motion_of(&machine)?),
            false => About::Oscillator,
        };
        let law = law::read(&friction, if alone { &machine } else { &axes }, folder, about)?;
        if !alone {
            law::check_symbols(&law, &friction, &axes)?;
        }
        check_keys(&root, &law)?;

        let stem = file.file_stem().map_or_else(|| "map".into(), |stem| stem.to_string_lossy().into_owned());
        let title = root.get_or("title", stem.clone(), |node| Ok(line(node)?.to_owned()))?;

        let (grid, uncertain, units, conversions) = if alone {
            let job = machine::read(&machine, &friction, &law)?;
            let grid = machine::grid(&machine, &job)?;
            law::check_range(&friction, &grid)?;
            (grid, job.uncertain, job.units, job.conversions)
        } else {
            let grid = grid(&axes, &law)?;
            law::check_range(&friction, &grid)?;
            (grid, Vec::new(), Vec::new(), Vec::new())
        };

        let methods = root.section("methods")?.get_or("run", Method::usual().collect(), |node| {
            let all: Vec<_> = Method::all().map(|method| (method.name(), method)).collect();
            choices(node, &all, "method")
        })?;
        let knobs = knobs(&root.section("naive")?)?;
        let methods = methods.into_iter().map(|method| method.with_knobs(knobs)).collect::<Vec<_>>();

        let simulation = root.section("simulation")?;
        let tolerance = simulation.get_or("tolerance", DEFAULT_TOLERANCE, tolerance)?;

        // A grid with fewer cells is audited completely.
        let audit = root.section("audit")?;
        let audit_cells =
            audit.get_or("cells", DEFAULT_AUDIT_CELLS, |node| node.integer(0, MOST_AUDIT_CELLS as i64))?;

        let section = root.section("validated")?;
        let proof_boxes = section.get_or("boxes", DEFAULT_PROOF_BOXES, |node| node.integer(0, 1_000_000))?;
        let proves = methods.contains(&Method::Test(&validated::TEST));
        let proof_boxes = if proves { proof_boxes } else { 0 };
        let proof = match section.get("proof") {
            None => None,
            Some(node) if !proves => {
                return Err(node.error(
                    "this run proves nothing that could be stored",
                    "run the method validated, or leave the proof out",
                ));
            }
            Some(node) => Some(output_path(&node)?),
        };

        let output = root.section("output")?;
        let path = output.get_or("path", Path::new("results").join(format!("{stem}.h5")), output_path)?;
        let simulated = methods.contains(&Method::Simulation);
        // A machine's map shows what it does.
        let usual = if alone && simulated { vec![Field::CriticalC, Field::Regime] } else { Vec::new() };
        let fields = output.get_or("fields", usual, |node| fields(node, simulated, alone))?;
        let compression = output.get_or("compression", DEFAULT_COMPRESSION, |node| node.integer(0, 9))?;

        let planes = curves::read(&root.section("curves")?, &root.section("machine")?, &grid)?;
        let work_precision = work_precision(&root.section("work_precision")?)?;

        let plan = Plan::builder(grid)
            .methods(methods)
            .fields(fields)
            .tolerance(tolerance)
            .audit_cells(audit_cells)
            .proof_boxes(proof_boxes)
            .planes(planes)
            .compression(compression)
            .build()
            // The checks above have reported all errors with their places.
            .map_err(|error| root.missing("grid", error.to_string()))?;
        if let Some(node) = section.get("proof").filter(|_| plan.proof_boxes == 0)
            && plan.grid.column_count() > MOST_PROVED_COLUMNS
        {
            let problem = format!("a proof has at most {MOST_PROVED_COLUMNS} columns");
            return Err(node.error(&problem, "prove boxes of parameters, or fewer columns"));
        }
        Ok(Job {
            plan,
            title,
            uncertain,
            units,
            conversions,
            config_file: source.file.clone(),
            config_text: source.text(),
            output: path,
            proof,
            work_precision,
        })
    }
}

/// Largest number of columns whose curves are stored: ten thousand have a hundred megabytes.
const MOST_PROVED_COLUMNS: usize = 10_000;

/// The sections of a configuration.
const SECTIONS: [&str; 11] = [
    "friction",
    "grid",
    "machine",
    "methods",
    "simulation",
    "naive",
    "validated",
    "curves",
    "audit",
    "output",
    "work_precision",
];

/// The keys of each section of a configuration for `law`; `None` is the top level.
fn schema(law: &Law) -> Vec<(Option<&'static str>, Vec<&'static str>)> {
    let keys_of = |section: &'static str| match section {
        "friction" => law::KEYS.to_vec(),
        // What may be left out is known, too.
        "grid" => {
            let mut names = law.clone().with_exponent().axis_names();
            names.extend((!names.contains(&"drop")).then_some("drop"));
            names
        }
        "machine" => machine::known_keys(law),
        "methods" => vec!["run"],
        "simulation" => vec!["tolerance"],
        "naive" => NAIVE_KEYS.to_vec(),
        "validated" => vec!["boxes", "proof"],
        "curves" => curves::KEYS.to_vec(),
        "audit" => vec!["cells"],
        "output" => vec!["path", "fields", "compression"],
        _ => vec!["cells", "near", "seconds"],
    };
    let top = std::iter::once("title").chain(SECTIONS).collect();
    let mut schema = vec![(None, top)];
    schema.extend(SECTIONS.map(|name| (Some(name), keys_of(name))));
    schema
}

/// Refuses a section whose name is unknown, such as `[maschine]`.
fn refuse_unknown_sections(root: &Section) -> Result<(), ConfigError> {
    for key in root.keys().iter().filter(|key| !SECTIONS.contains(&key.as_str())) {
        if root.section(key).is_ok() {
            return Err(root.unknown(key, nearest("key", key, &SECTIONS)));
        }
    }
    Ok(())
}

/// Refuses unknown keys; the error names the section or the key that was probably meant.
fn check_keys(root: &Section, law: &Law) -> Result<(), ConfigError> {
    let schema = schema(law);
    for (name, known) in &schema {
        let section = match name {
            None => root,
            Some(name) => &root.section(name)?,
        };
        if let Some(key) = section.keys().iter().find(|key| !known.contains(&key.as_str())) {
            let home = schema.iter().find(|(_, keys)| keys.contains(&key.as_str()));
            let remedy = match home {
                Some((Some(home), _)) => format!("`{key}` belongs in [{home}]"),
                None if *name == Some("machine") => machine::remedy(key, law),
                Some((None, _)) => format!("`{key}` belongs at the top of the file, before any [section]"),
                None => nearest("key", key, known),
            };
            return Err(section.unknown(key, remedy));
        }
    }
    Ok(())
}

fn refuse_unknown_keys(section: &Section, known: &[&'static str]) -> Result<(), ConfigError> {
    match section.keys().iter().find(|key| !known.contains(&key.as_str())) {
        Some(key) => Err(section.unknown(key, nearest("key", key, known))),
        None => Ok(()),
    }
}

/// Reads every axis of `law`.
fn grid(section: &Section, law: &Law) -> Result<Grid, ConfigError> {
    let names = law.axis_names();
    if !section.is_present() {
        let remedy = "a grid to start from is written by: slipmap init grid";
        return Err(section.missing(names[0], remedy.into()));
    }
    // Every missing axis as a line to paste.
    let how = || {
        let missing = names.iter().filter(|name| section.get(name).is_none());
        let lines: String = missing.map(|name| format!("\n    {name} = 1.0")).collect();
        format!("every axis of the law `{}` needs a number, a list or a range:{lines}", law.name())
    };
    let mut nodes = Vec::with_capacity(names.len());
    for name in &names {
        let node = section.get(name).ok_or_else(|| section.missing(name, how()))?;
        nodes.push((axis::nodes(&node)?, node));
    }
    let values = nodes.iter().map(|(values, _)| values.clone()).collect();
    Grid::new(law.clone(), values).map_err(|error| grid_error(&error, &names, &nodes))
}

/// Converts a [`GridError`] to an error at the value concerned.
fn grid_error(error: &GridError, names: &[&str], nodes: &[(Vec<f64>, Node)]) -> ConfigError {
    let same = |a: f64, b: f64| a == b || (a.is_nan() && b.is_nan());
    let find = |axis: &str, wanted: &dyn Fn(&[f64], usize) -> bool| {
        let which = names.iter().position(|name| *name == axis).unwrap_or(0);
        let (values, node) = &nodes[which];
        let at = (0..values.len()).find(|&i| wanted(values, i)).unwrap_or(0);
        (node, at)
    };
    let report = |(node, at): (&Node, usize), problem: &str, remedy: &str| match node.shape() {
        source::Shape::List(elements) => elements[at].error(problem, remedy),
        _ => node.error(problem, remedy),
    };
    match error {
        GridError::OutOfDomain { axis, value, domain } => {
            let at = find(axis, &|values, i| same(values[i], *value));
            let remedy = format!("choose values of {axis} that are {domain}");
            report(at, &format!("{axis} must be {domain}"), &remedy)
        }
        GridError::NotIncreasing { axis, previous, next } => {
            let at =
                find(axis, &|values, i| i > 0 && same(values[i - 1], *previous) && same(values[i], *next));
            match previous == next {
                true => report(at, &format!("{next} appears twice"), "take out the repetition"),
                false => report(at, &format!("{next} follows {previous}"), "sort the list: axes increase"),
            }
        }
        // One list that is not empty was read per axis of the law, which is none of a machine.
        GridError::AxisCount { .. }
        | GridError::Empty { .. }
        | GridError::NoQuantity(_)
        | GridError::Machine { .. } => unreachable!("{error}"),
        GridError::TooLarge => {
            let sizes: Vec<String> =
                names.iter().zip(nodes).map(|(name, (v, _))| format!("{name} {}", v.len())).collect();
            nodes[0].1.error(
                &format!("the grid has more cells than can be counted: {}", sizes.join(" x ")),
                "take fewer points on the longest axes",
            )
        }
    }
}

const NAIVE_KEYS: [&str; 7] =
    ["smoothing_width", "stick_band_width", "step", "tolerance", "longest_step", "turns", "start_pause"];

/// Reads a finite number of at least `least`; messages describe that condition by `bound`.
fn number_or(
    section: &Section,
    key: &str,
    default: f64,
    least: f64,
    bound: &str,
) -> Result<f64, ConfigError> {
    section.get_or(key, default, |node| match node.number()? {
        value if value.is_finite() && value >= least => Ok(value),
        _ => Err(node.error(&format!("{key} must be {bound}"), "choose another value")),
    })
}

/// Reads a finite number greater than 0.
fn positive_or(section: &Section, key: &str, default: f64) -> Result<f64, ConfigError> {
    number_or(section, key, default, f64::MIN_POSITIVE, "greater than 0")
}

/// Reads the settings of the naive methods.
fn knobs(section: &Section) -> Result<NaiveKnobs, ConfigError> {
    let default = NaiveKnobs::default();
    let (least, most) = (*TOLERANCES.start(), i64::from(u32::MAX));
    Ok(NaiveKnobs {
        smoothing_width: positive_or(section, "smoothing_width", default.smoothing_width)?,
        stick_band_width: positive_or(section, "stick_band_width", default.stick_band_width)?,
        step: positive_or(section, "step", default.step)?,
        tolerance: number_or(section, "tolerance", default.tolerance, least, "at least 1e-14")?,
        longest_step: positive_or(section, "longest_step", default.longest_step)?,
        turns: section.get_or("turns", default.turns, |node| node.integer(1, most))?,
        start_pause: number_or(section, "start_pause", default.start_pause, 0.0, "at least 0")?,
    })
}

/// Reads the settings of a study of speed against accuracy.
fn work_precision(section: &Section) -> Result<StudySettings, ConfigError> {
    let default = StudySettings::default();
    Ok(StudySettings {
        cells: section.get_or("cells", default.cells, |node| node.integer(2, 1_000_000))?,
        near: positive_or(section, "near", default.near)?,
        seconds: positive_or(section, "seconds", default.seconds)?,
    })
}

fn tolerance(node: &Node) -> Result<f64, ConfigError> {
    let value = node.number()?;
    check_tolerance(value).map(|()| value).map_err(|problem| {
        node.error(&problem, "choose a bound on the error of the scaled grazing margin; 1e-9 suits most maps")
    })
}

/// Checks a bound on the error of the scaled grazing margin.
///
/// # Errors
/// The condition that the value violates, in words.
pub fn check_tolerance(value: f64) -> Result<(), String> {
    if TOLERANCES.contains(&value) {
        Ok(())
    } else {
        Err(format!("the tolerance must be from {:e} to {:e}", TOLERANCES.start(), TOLERANCES.end()))
    }
}

fn line<'a>(node: &Node<'a>) -> Result<&'a str, ConfigError> {
    let text = node.text()?;
    if text.trim().is_empty() {
        return Err(node.error("the text is empty", "write something, or leave the key out"));
    }
    if text.chars().any(char::is_control) {
        return Err(node.error("the text has line breaks or control characters", "write it on one line"));
    }
    Ok(text)
}

/// Reads the path of the map file.
fn output_path(node: &Node) -> Result<PathBuf, ConfigError> {
    let text = line(node)?;
    let path = Path::new(text);
    if text.ends_with(['/', std::path::MAIN_SEPARATOR]) || path.file_name().is_none() {
        return Err(node.error("this names no file", "write a file name such as \"results/map.h5\""));
    }
    if path.is_dir() {
        return Err(node.error("this is a folder", "write a file name such as \"results/map.h5\""));
    }
    Ok(path.to_owned())
}

fn fields(node: &Node, simulated: bool, of_machine: bool) -> Result<Vec<Field>, ConfigError> {
    let chosen = choices(node, &Field::ALL.map(|field| (field.name_for(of_machine), field)), "field")?;
    let needs_flow = chosen.iter().find(|field| field.needs_flow());
    if let (false, Some(field)) = (simulated, needs_flow) {
        return Err(node.error(
            &format!("the field `{}` comes from the method `simulation`, which is not run", field.name()),
            format!("add \"simulation\" to methods.run, or leave \"{}\" out", field.name()),
        ));
    }
    Ok(chosen)
}

/// Reads one of several words.
fn choice<T: Clone>(node: &Node, table: &[(&'static str, T)], noun: &str) -> Result<T, ConfigError> {
    let word = node.text()?;
    match table.iter().find(|(name, _)| *name == word) {
        Some((_, value)) => Ok(value.clone()),
        None => {
            let names: Vec<_> = table.iter().map(|(name, _)| *name).collect();
            Err(node.error(&format!("unknown {noun}"), nearest(noun, word, &names)))
        }
    }
}

/// Reads a list of several words, at least one, none twice.
fn choices<T: Clone>(node: &Node, table: &[(&'static str, T)], noun: &str) -> Result<Vec<T>, ConfigError> {
    let elements = node.list(&format!("a list of {noun}s such as [\"{}\"]", table[0].0))?;
    if elements.is_empty() {
        return Err(node.error(
            &format!("no {noun} is named"),
            format!("name at least one {noun}, or leave the key out"),
        ));
    }
    let mut seen = Vec::new();
    let mut chosen = Vec::new();
    for element in &elements {
        chosen.push(choice(element, table, noun)?);
        let word = element.text()?;
        if seen.contains(&word) {
            return Err(element.error("named twice", "take out the repetition"));
        }
        seen.push(word);
    }
    Ok(chosen)
}

/// The nearest valid word: "the nearest valid key is `alpha`; valid are: ..".
pub fn nearest(noun: &str, word: &str, valid: &[&'static str]) -> String {
    let word = word.to_lowercase();
    // An abbreviation, or a part of a name, counts as nearer than a word with other letters: `eps` means
    // epsilon, not beta, and `speed` belt_speed.
    let distance = |name: &&&str| {
        let name = name.to_lowercase();
        let abbreviated =
            word.chars().count() > 1 && (name.starts_with(&word) || name.split('_').any(|part| part == word));
        if abbreviated { 0 } else { strsim::damerau_levenshtein(&word, &name) }
    };
    match valid.iter().min_by_key(distance) {
        Some(best) if valid.len() > 1 => {
            format!("the nearest valid {noun} is `{best}`; valid are: {}", valid.join(", "))
        }
        Some(only) => format!("the only valid {noun} here is `{only}`"),
        None => String::new(),
    }
}
