//! Exports of the page: the plane as a configuration, with the commands and the Python that make a map of it.

use std::fmt::Write as _;

use serde_json::{Value, json};

use super::plane::{PlaneRequest, Slice};
use super::refusal::Refusal;
use super::show::Show;
use slipmap_map::machine::{DAMPING, DAMPING_RATIO, Machine};
use slipmap_map::map::{self, Field, Method};
use slipmap_model::friction::Law;
use slipmap_numbers::text::exact;

/// Names of the files in a configuration.
const CONFIG: &str = "plane.toml";
const MAP: &str = "plane.h5";
const TABLE: &str = "friction.csv";

fn quoted(text: &str) -> String {
    toml_edit::Value::from(text).to_string()
}

/// The elements of a list of quoted texts.
fn list<'a>(texts: impl IntoIterator<Item = &'a str>) -> String {
    texts.into_iter().map(quoted).collect::<Vec<_>>().join(", ")
}

#[derive(Clone, Copy)]
struct AxisRange<'a> {
    name: &'a str,
    from: f64,
    to: f64,
    points: usize,
    log: bool,
}

impl<'a> AxisRange<'a> {
    fn of(name: &'a str, nodes: &[f64], log: bool) -> Self {
        Self { name, from: nodes[0], to: nodes[nodes.len() - 1], points: nodes.len(), log }
    }
}

/// The contents of an exported configuration.
struct Description<'a> {
    law: &'a Law,
    /// Values of the other axes, or quantities.
    held: Vec<(&'a str, f64)>,
    /// Those of the two axes, of a machine in SI units.
    ranges: [AxisRange<'a>; 2],
    methods: Vec<Method>,
    field: Option<Field>,
    /// The machine of which the two axes are quantities.
    machine: Option<Machine>,
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
                let _ = writeln!(text, "phi = {}", quoted(&formula.text()));
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
        let _ = match &self.machine {
            Some(machine) => writeln!(text, "\n[machine]\nmotion = {}", quoted(machine.motion.name())),
            None => writeln!(text, "\n[grid]"),
        };
        for (name, value) in &self.held {
            let _ = writeln!(text, "{name} = {}", float(*value));
        }
        for AxisRange { name, from, to, points, log } in &self.ranges {
            let spacing = if *log { ", spacing = \"log\"" } else { "" };
            let (from, to) = (float(*from), float(*to));
            let _ = writeln!(text, "{name} = {{ from = {from}, to = {to}, points = {points}{spacing} }}");
        }
        let _ = writeln!(text, "\n[methods]\nrun = [{}]", self.quoted_methods());
        let name = |field: Field| field.name_for(self.machine.is_some());
        let fields = list([Field::Verdict].into_iter().chain(self.further_field()).map(name));
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
        self.machine.as_ref().map_or_else(|| self.law.clone(), Machine::law)
    }

    /// The commands that compute the map of the configuration and draw it; a map has no variable of a
    /// comparison of methods, which are drawn by a report.
    fn commands(&self, show: &Show, curves: bool) -> String {
        let Show::Variable(variable) = show else {
            return format!("slipmap run {CONFIG}\nslipmap report {MAP}\n");
        };
        let is_damping = |range: &&AxisRange| matches!(range.name, "c" | DAMPING | DAMPING_RATIO);
        // Critical dampings are drawn over the other axis alone.
        let shown: Vec<&str> = match Field::is_critical(variable) {
            true => self.ranges.iter().filter(|range| !is_damping(range)).map(|range| range.name).collect(),
            false => self.ranges.iter().map(|range| range.name).collect(),
        };
        let axes: String =
            ["--x", "--y"].iter().zip(&shown).map(|(flag, name)| format!(" {flag} {name}")).collect();
        let curves = if curves && shown.len() == 2 { " --curves" } else { "" };
        format!(
            "slipmap run {CONFIG}\nslipmap plot {MAP}{axes} --variable {variable}{curves} --out plane.svg --data cells.csv\n"
        )
    }
}

fn float(value: f64) -> String {
    format!("{value:?}")
}

impl PlaneRequest {
    fn description<'a>(&'a self, slice: &'a Slice) -> Result<(Description<'a>, Show), Refusal> {
        let axes = slice.grid.axes();
        let (show, methods, field) = self.show(&slice.grid)?;
        let range = |axis: usize, log: bool| AxisRange::of(&axes[axis].name, &axes[axis].values, log);
        let [x_log, y_log] = self.logarithmic();
        let machine = self.place.machine()?;
        let ranges = [range(slice.x, x_log), range(slice.y, y_log)];
        let is_held = |name: &str| ranges.iter().all(|range| range.name != name);
        let held: Vec<(&str, f64)> = match &machine {
            Some(machine) => machine.quantities().into_iter().filter(|(name, _)| is_held(name)).collect(),
            None => axes
                .iter()
                .filter(|axis| is_held(&axis.name))
                .map(|axis| (axis.name.as_str(), axis.values[0]))
                .collect(),
        };
        let description = Description { law: slice.grid.law(), held, ranges, methods, field, machine };
        Ok((description, show))
    }

    /// The plane and its point as texts to copy.
    pub(super) fn texts(&self) -> Result<Value, Refusal> {
        let slice = self.cells()?;
        let (description, show) = self.description(&slice)?;
        let (law, point) = self.place.point()?;
        let command = match &description.machine {
            Some(machine) => {
                let sets = [slice.x, slice.y].map(|axis| &slice.grid.axes()[axis].name);
                let value = |name: &str| {
                    let known = machine.quantities().into_iter().find(|(known, _)| *known == name);
                    known.map_or(f64::NAN, |(_, value)| value)
                };
                let sets: String =
                    sets.iter().map(|name| format!(" --set {name}={}", exact(value(name)))).collect();
                format!("slipmap probe --machine {CONFIG}{sets}")
            }
            None => slipmap_map::probe::command_line(&law, &point, map::DEFAULT_TOLERANCE),
        };
        Ok(json!({
            "toml": description.toml(),
            "commands": description.commands(&show, self.curves),
            "python": format!("import slipmap\n\ndata = slipmap.run(\"{CONFIG}\")\nprint(data.squeeze())\n"),
            "command": command,
            "table": table_text(&description.law_as_written()),
        }))
    }
}

/// The rows of a measured law; empty for other laws.
fn table_text(law: &Law) -> Option<String> {
    let object = super::place::law_json(law);
    object.get("table").and_then(Value::as_str).map(str::to_owned)
}
