//! Exports of the page: the plane as a configuration, with the commands and the Python that make a map of it.

use std::fmt::Write as _;

use serde_json::{Value, json};

use super::plane::{PlaneRequest, Slice};
use super::refusal::Refusal;
use super::show::Show;
use slipmap_column::Method;
use slipmap_machine::{DAMPING, DAMPING_RATIO, Machine};
use slipmap_map::{Axis, Field};
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

/// The contents of an exported configuration.
struct Description<'a> {
    law: &'a Law,
    /// Values of the other axes, or quantities.
    held: Vec<(&'a str, f64)>,
    /// The two axes, of a machine in SI units, and whether they are logarithmic.
    axes: [(&'a Axis, bool); 2],
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
        for (Axis { name, values, .. }, log) in &self.axes {
            let spacing = if *log { ", spacing = \"log\"" } else { "" };
            let points = values.len();
            let (from, to) = (float(values[0]), float(values[points - 1]));
            let _ = writeln!(text, "{name} = {{ from = {from}, to = {to}, points = {points}{spacing} }}");
        }
        let _ = writeln!(text, "\n[methods]\nrun = [{}]", list(self.methods.iter().map(Method::name)));
        let name = |field: Field| field.name_for(self.machine.is_some());
        // Every map has the verdict.
        let further = self.field.filter(|field| *field != Field::Verdict);
        let fields = list([Field::Verdict].into_iter().chain(further).map(name));
        let _ = writeln!(text, "\n[output]\npath = \"{MAP}\"\nfields = [{fields}]");
        text
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
        // Critical dampings are drawn over the other axis alone.
        let is_critical = Field::is_critical(variable);
        let names = self.axes.iter().map(|(axis, _)| axis.name.as_str());
        let shown: Vec<&str> =
            names.filter(|name| !(is_critical && ["c", DAMPING, DAMPING_RATIO].contains(name))).collect();
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
        let machine = self.place.machine()?;
        let shown = [(&axes[slice.x], self.x.log), (&axes[slice.y], self.y.log)];
        let is_held = |name: &str| shown.iter().all(|(axis, _)| axis.name != name);
        let held: Vec<(&str, f64)> = match &machine {
            Some(machine) => machine.quantities().into_iter().filter(|(name, _)| is_held(name)).collect(),
            None => axes
                .iter()
                .filter(|axis| is_held(&axis.name))
                .map(|axis| (axis.name.as_str(), axis.values[0]))
                .collect(),
        };
        let law = slice.grid.law();
        Ok((Description { law, held, axes: shown, methods, field, machine }, show))
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
            None => slipmap_machine::probe::command_line(&law, &point, slipmap_column::DEFAULT_TOLERANCE),
        };
        Ok(json!({
            "toml": description.toml(),
            "commands": description.commands(&show, self.curves),
            "python": format!("import slipmap\n\ndata = slipmap.run(\"{CONFIG}\")\nprint(data.squeeze())\n"),
            "command": command,
            // The rows of a measured law.
            "table": super::law::law_json(&description.law_as_written())["table"],
        }))
    }
}
