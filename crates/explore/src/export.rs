//! Exports of the page: the plane as a configuration, as Python, as a map, as figures and as a table.
//!
//! Maps and figures are computed as by `slipmap run` and `slipmap plot` from the same configuration, in a
//! temporary folder.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use ndarray::Array2;
use serde::Deserialize;
use serde_json::{Value, json};

use super::machine::{dimensionless, is_shared, law_of};
use super::plane::{PlaneRequest, Slice};
use super::refusal::Refusal;
use super::show::Show;
use slipmap_config::{Job, table_of_text};
use slipmap_format::{Existing, MapFile, Outcome, PartialMap, Provenance};
use slipmap_map::machine::{Friction, Machine};
use slipmap_map::map::{self, ComputeError, Control, Field, Grid, Method, Plan, PlaneCurves};
use slipmap_model::friction::Law;
use slipmap_numbers::text::exact;
use slipmap_report::figure::area::{self, Area, Layer};
use slipmap_report::figure::{self, Width, render};
pub use slipmap_report::{Label, ReportError, Rich, View, rich};

/// Largest number of cells along one axis of an exported map: a figure shows no more, and a table would be
/// large.
const MOST_POINTS: usize = 1024;
/// Names of the files in a configuration.
const CONFIG: &str = "plane.toml";
const MAP: &str = "plane.h5";
const TABLE: &str = "friction.csv";

#[derive(Clone, Debug, Deserialize)]
pub(super) struct ExportRequest {
    #[serde(flatten)]
    pub(super) plane: PlaneRequest,
    /// The file: `svg`, `png`, `pdf`, `csv` or `h5`.
    #[serde(default)]
    file: String,
}

fn broken(error: impl std::fmt::Display) -> Refusal {
    Refusal::broken(error.to_string())
}

/// The refusal for a figure that cannot be drawn: a critical damping, for example, does not vary along c.
fn undrawn(error: ReportError) -> Refusal {
    match error {
        ReportError::Choice(choice) => Refusal::bad_input(choice.to_string(), ""),
        error => broken(error),
    }
}

fn failed(error: ComputeError<slipmap_format::StoreError>) -> Refusal {
    match error {
        ComputeError::Interrupted => Refusal::overtaken(),
        error => broken(error),
    }
}

/// A quoted text in TOML, which is also valid Python.
fn quoted(text: &str) -> String {
    toml_edit::Value::from(text).to_string()
}

/// The elements of a list of quoted texts.
fn list<'a>(texts: impl IntoIterator<Item = &'a str>) -> String {
    texts.into_iter().map(quoted).collect::<Vec<_>>().join(", ")
}

/// The range of an axis.
#[derive(Clone, Copy)]
struct Range<'a> {
    name: &'a str,
    from: f64,
    to: f64,
    points: usize,
    log: bool,
}

impl<'a> Range<'a> {
    fn of(name: &'a str, nodes: &[f64], log: bool) -> Self {
        Self { name, from: nodes[0], to: nodes[nodes.len() - 1], points: nodes.len(), log }
    }
}

/// The contents of an exported text.
struct Description<'a> {
    law: &'a Law,
    held: Vec<(&'static str, f64)>,
    ranges: [Range<'a>; 2],
    methods: Vec<Method>,
    field: Option<Field>,
    /// The machine whose belt speed and damping the two axes are, and both in SI units.
    machine: Option<(Machine, [Range<'a>; 2])>,
}

impl Description<'_> {
    /// The configuration of the map that has the cells of the picture.
    fn toml(&self) -> String {
        let mut text = String::from("title = \"A plane of slipmap explore\"\n\n[friction]\n");
        // Writing to a text cannot fail.
        let law = self.law_as_written();
        let _ = writeln!(text, "law = {}", quoted(law.name()));
        let level = match law.as_written() {
            Law::Expression(formula) => {
                let _ = writeln!(text, "phi = {}", quoted(formula.text()));
                Some(formula.static_level())
            }
            Law::Table(table) => {
                let _ = writeln!(text, "file = \"{TABLE}\"");
                Some(table.static_level())
            }
            _ => None,
        };
        // The friction of a machine has its own value at rest.
        if let Some(level) = level.filter(|_| self.machine.is_none()) {
            let _ = writeln!(text, "static = {}", float(level));
        }
        if self.law.is_read_as_small() {
            text.push_str("small = \"eps\"\n");
        }
        match &self.machine {
            Some((machine, ranges)) => {
                let _ = writeln!(text, "\n[machine]\nmotion = {}", quoted(machine.motion.name()));
                let held = machine.quantities().into_iter().filter(|(name, _)| !is_shared(name));
                write_axes(&mut text, held, ranges);
            }
            None => {
                text.push_str("\n[grid]\n");
                write_axes(&mut text, self.held.iter().copied(), &self.ranges);
            }
        }
        let _ = writeln!(text, "\n[methods]\nrun = [{}]", self.quoted_methods());
        let fields = list([Field::Verdict].into_iter().chain(self.further_field()).map(Field::name));
        let _ = writeln!(text, "\n[output]\npath = \"{MAP}\"\nfields = [{fields}]");
        text
    }

    fn quoted_methods(&self) -> String {
        list(self.methods.iter().map(Method::name))
    }

    /// The field shown, unless it is the verdict, which every map has.
    fn further_field(&self) -> Option<Field> {
        self.field.filter(|field| *field != Field::Verdict)
    }

    /// The law as written in a configuration: for a machine, in SI units.
    fn law_as_written(&self) -> Law {
        self.machine.as_ref().map_or_else(|| self.law.clone(), |(machine, _)| law_of(&machine.friction))
    }

    /// The plane as a Python script.
    fn python(&self) -> String {
        let mut text = String::from("import numpy as np\nimport slipmap\n\n");
        let law = match self.law.as_written() {
            Law::Expression(formula) => {
                format!(
                    "slipmap.Law.expression({}, static={})",
                    quoted(formula.text()),
                    exact(formula.static_level())
                )
            }
            Law::Table(table) => {
                let _ = writeln!(
                    text,
                    "u, friction = np.loadtxt(\"{TABLE}\", delimiter=\",\", usecols=(0, 1)).T"
                );
                if let Some((machine, _)) = &self.machine {
                    // The grid is dimensionless, the data of a machine are not.
                    let _ = writeln!(text, "u /= {}", exact(machine.units().velocity));
                }
                format!("slipmap.Law.table(u, friction, static={})", exact(table.static_level()))
            }
            law => format!("slipmap.Law.{}()", law.name()),
        };
        let small = if self.law.is_read_as_small() { ".read_as_small()" } else { "" };
        let _ = writeln!(text, "grid = {{");
        for (name, value) in &self.held {
            let _ = writeln!(text, "    \"{name}\": {},", exact(*value));
        }
        for Range { name, from, to, points, log } in self.ranges {
            let call = if log { "geomspace" } else { "linspace" };
            let _ = writeln!(text, "    \"{name}\": np.{call}({}, {}, {points}),", exact(from), exact(to));
        }
        let (methods, fields) = (self.quoted_methods(), list(self.further_field().map(Field::name)));
        let _ = write!(
            text,
            "}}\ndata = slipmap.map(grid, law={law}{small}, methods=[{methods}], fields=[{fields}])\nprint(data.squeeze())\n"
        );
        text
    }
}

/// Writes the axes of a configuration: values, then ranges.
fn write_axes<'a>(text: &mut String, held: impl Iterator<Item = (&'a str, f64)>, ranges: &[Range]) {
    for (name, value) in held {
        let _ = writeln!(text, "{name} = {}", float(value));
    }
    for Range { name, from, to, points, log } in ranges {
        let spacing = if *log { ", spacing = \"log\"" } else { "" };
        let (from, to) = (float(*from), float(*to));
        let _ = writeln!(text, "{name} = {{ from = {from}, to = {to}, points = {points}{spacing} }}");
    }
}

/// A real number in TOML.
fn float(value: f64) -> String {
    format!("{value:?}")
}

impl ExportRequest {
    fn description<'a>(&'a self, slice: &'a Slice) -> Result<(Description<'a>, Show), Refusal> {
        let axes = slice.grid.axes();
        let (show, methods, field) = self.plane.show()?;
        let held = axes.iter().enumerate().filter(|(axis, _)| *axis != slice.x && *axis != slice.y);
        let range = |axis: usize, log: bool| Range::of(&axes[axis].name, &axes[axis].values, log);
        let [x_log, y_log] = self.plane.logarithmic();
        let names = Grid::axis_names(slice.grid.law());
        let machine = self.plane.place.machine()?;
        let in_si = || -> Result<[Range<'a>; 2], Refusal> {
            let [(x, across), (y, up)] = self.plane.sides_of_cells()?;
            Ok([Range::of(x, &across, x_log), Range::of(y, &up, y_log)])
        };
        let description = Description {
            law: slice.grid.law(),
            held: held.map(|(position, axis)| (names[position], axis.values[0])).collect(),
            ranges: [range(slice.x, x_log), range(slice.y, y_log)],
            methods,
            field,
            machine: machine.map(|machine| Ok::<_, Refusal>((machine, in_si()?))).transpose()?,
        };
        Ok((description, show))
    }

    /// The plane and its point as texts to copy.
    pub(super) fn texts(&self) -> Result<Value, Refusal> {
        let slice = self.plane.cells()?;
        let (description, _) = self.description(&slice)?;
        let (law, point) = self.plane.place.point()?;
        let command = match &description.machine {
            Some((machine, _)) => {
                let (speed, damping) = (exact(machine.belt_speed), exact(machine.damping));
                format!("slipmap probe --machine {CONFIG} --set belt_speed={speed} --set damping={damping}")
            }
            None => slipmap_map::probe::command_line(&law, &point, map::DEFAULT_TOLERANCE),
        };
        Ok(json!({
            "toml": description.toml(),
            "python": description.python(),
            "command": command,
            "table": table_text(&description.law_as_written()),
        }))
    }

    pub(super) fn file(&self, git: &str, stop: &AtomicBool) -> Result<(&'static str, Vec<u8>), Refusal> {
        let slice = self.plane.cells()?;
        if slice.grid.axes().iter().any(|axis| axis.values.len() > MOST_POINTS) {
            let problem = format!("a map of more than {MOST_POINTS} nodes along an axis");
            return Err(Refusal::bad_input(problem, "copy the configuration, and run it"));
        }
        let (description, show) = self.description(&slice)?;
        let folder = tempfile::tempdir().map_err(broken)?;
        let map = run(&description, folder.path(), git, stop)?;
        if self.file == "h5" {
            return Ok(("application/x-hdf5", std::fs::read(map).map_err(broken)?));
        }
        let map = MapFile::open(&map).map_err(broken)?;
        let view = View::new(&map);
        let (scene, caption, data) = self.drawn(&view, &show, &description, stop)?;
        let svg = || scene.svg("plane", &caption);
        match self.file.as_str() {
            "svg" => Ok(("image/svg+xml", svg().into_bytes())),
            "png" => Ok(("image/png", render::png("plane", &svg()).map_err(broken)?)),
            "pdf" => Ok(("application/pdf", render::pdf("plane", &svg()).map_err(broken)?)),
            "csv" => Ok(("text/csv", data.csv().into_bytes())),
            other => Err(Refusal::malformed(format!("there is no file `{other}`"))),
        }
    }

    /// The figure of the plane, as `slipmap plot` draws it.
    fn drawn(
        &self,
        view: &View,
        show: &Show,
        description: &Description,
        stop: &AtomicBool,
    ) -> Result<(figure::Scene, Rich, figure::Data), Refusal> {
        let [x, y] = description.ranges.map(|range| range.name);
        let (slice, _) = figure::Slice::choose(view, x, y, &[]).map_err(broken)?;
        let label = match show {
            Show::Variable(name) => view.units.variable(name),
            Show::Difference(_) | Show::Decider => Label {
                name: rich(if matches!(show, Show::Decider) { "which method decides" } else { "comparison" }),
                key: "code".into(),
                unit: "",
                factor: 1.0,
            },
        };
        let codes = |method: &Method| slice.codes(&format!("verdict_{}", method.name())).map_err(broken);
        let layer = match (show, show.kinds(&description.methods)) {
            (Show::Variable(name), Some(kinds)) => Layer::Codes(slice.codes(name).map_err(undrawn)?, kinds),
            (Show::Variable(name), None) => Layer::Reals(slice.reals(name).map_err(undrawn)?),
            (_, kinds) => {
                let verdicts =
                    description.methods.iter().map(codes).collect::<Result<Vec<Array2<i8>>, _>>()?;
                let cells = Array2::from_shape_fn(verdicts[0].dim(), |at| {
                    let codes: Vec<i8> = verdicts.iter().map(|of_method| of_method[at]).collect();
                    show.derived(&description.methods, &codes)
                });
                Layer::Codes(cells, kinds.unwrap_or_default())
            }
        };
        let errors = match show {
            Show::Variable(name) => slice.errors(name).map_err(undrawn)?,
            Show::Difference(_) | Show::Decider => None,
        };
        let curves = self.plane.curves.then(|| PlaneCurves::of(view.map.grid(), slice.plane(), stop));
        let heading =
            slipmap_report::join([label.name.clone(), view.held(&slice.index, &[slice.x, slice.y])]);
        let caption = heading.clone();
        let areas = [Area { slice, layer, errors, curves, exact: false, title: Rich::default() }];
        let signed = matches!(show, Show::Variable(name) if name.starts_with("margin_"));
        let scene = area::draw(&areas, &heading, &label, signed, Width::OneColumn);
        Ok((scene, caption, area::data(&areas, &label, None)))
    }
}

/// The rows of a measured law; empty for other laws.
fn table_text(law: &Law) -> Option<String> {
    let object = super::place::law_json(law);
    object.get("table").and_then(Value::as_str).map(str::to_owned)
}

/// Runs the configuration in a folder, as `slipmap run` does; returns the map.
fn run(
    description: &Description,
    folder: &Path,
    git: &str,
    stop: &AtomicBool,
) -> Result<std::path::PathBuf, Refusal> {
    let config = folder.join(CONFIG);
    std::fs::write(&config, description.toml()).map_err(broken)?;
    let written = description.law_as_written();
    if let Some(table) = table_text(&written) {
        std::fs::write(folder.join(TABLE), table).map_err(broken)?;
    }
    let mut job = Job::load(&config, &[]).map_err(|error| Refusal::bad_input(error.problem, error.remedy))?;
    if let Law::Table(table) = written.as_written() {
        // The map names the table without this temporary folder, as after a run in that folder.
        let text = table_text(&written).unwrap_or_default();
        let named = table_of_text(TABLE, &text, Some(table.static_level()), None);
        let named = named.map_err(|(problem, remedy)| Refusal::bad_input(problem, remedy))?;
        let small = description.law.is_read_as_small();
        let law = match &description.machine {
            None if small => Law::Table(named).read_as_small(),
            None => Law::Table(named),
            Some((machine, _)) => {
                dimensionless(&Machine { friction: Friction::Measured(named), ..machine.clone() }, small)?.0
            }
        };
        let nodes = job.plan.grid.axes().iter().map(|axis| axis.values.clone()).collect();
        job.plan.grid = Grid::new(law, nodes)?;
    }
    let map = folder.join(MAP);
    let provenance = Provenance {
        title: job.title.clone(),
        config_path: CONFIG.into(),
        config_text: job.config_text.clone(),
        command_line: format!("slipmap run {CONFIG}"),
        git: git.into(),
    };
    let plan: &Plan = &job.plan;
    let partial = PartialMap::begin(&map, plan, &provenance, Existing::Refuse).map_err(broken)?;
    let summary = map::run(plan, &partial, &Control { stop, ..Control::default() }).map_err(failed)?;
    partial.finish(&Outcome::of(plan, &summary, job.machine.as_ref())).map_err(broken)?;
    Ok(map)
}
