//! Exports of the page: the plane as a configuration, with the commands and the Python that make a map of it.

use std::fmt::Write as _;

use serde_json::{Value, json};

use super::plane::{PlaneRequest, Slice};
use super::refusal::Refusal;
use super::show::Show;
use slipmap_column::Method;
use slipmap_config::{About, LawText, MachineJob, nodes, quoted};
use slipmap_machine::{DAMPING, DAMPING_RATIO};
use slipmap_map::{Axis, Field};
use slipmap_model::friction::{Law, Table};
use slipmap_numbers::text::exact;

/// Names of the files in a configuration.
const CONFIG: &str = "plane.toml";
const MAP: &str = "plane.h5";

/// The elements of a list of quoted texts.
fn list<'a>(texts: impl IntoIterator<Item = &'a str>) -> String {
    texts.into_iter().map(quoted).collect::<Vec<_>>().join(", ")
}

/// The contents of an exported configuration.
struct Description<'a> {
    law: &'a Law,
    title: &'a str,
    /// All axes: of a machine those that are shown.
    axes: &'a [Axis],
    /// The positions of the two that are shown.
    shown: [usize; 2],
    methods: Vec<Method>,
    field: Option<Field>,
    /// The machine of which the axes are quantities.
    job: Option<MachineJob>,
}

impl Description<'_> {
    /// The configuration of the map that has the cells of the picture; `None` where the law cannot be written.
    fn toml(&self) -> Option<String> {
        let mut text = match &self.job {
            Some(job) => job.to_toml()?,
            None => {
                let law = LawText::of(self.law, About::Oscillator)?.to_toml();
                let axes =
                    self.axes.iter().map(|axis| format!("{} = {}\n", axis.name, nodes(&axis.values, None)));
                format!("title = {}\n\n{law}\n[grid]\n{}", quoted(self.title), axes.collect::<String>())
            }
        };
        // Writing to a text cannot fail.
        let _ = writeln!(text, "\n[methods]\nrun = [{}]", list(self.methods.iter().map(Method::name)));
        let name = |field: Field| field.name_for(self.job.is_some());
        // Every map has the verdict.
        let further = self.field.filter(|field| *field != Field::Verdict);
        let fields = list([Field::Verdict].into_iter().chain(further).map(name));
        let _ = writeln!(text, "\n[output]\npath = \"{MAP}\"\nfields = [{fields}]");
        Some(text)
    }

    /// The commands that compute the map of the configuration and draw it; a map has no variable of a
    /// comparison of methods, which are drawn by a report.
    fn commands(&self, show: &Show, curves: bool) -> String {
        let Show::Variable(variable) = show else {
            return format!("slipmap run {CONFIG}\nslipmap report {MAP}\n");
        };
        // Critical dampings are drawn over the other axis alone.
        let is_critical = Field::is_critical(variable);
        let names = self.shown.iter().map(|axis| self.axes[*axis].name.as_str());
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

/// The title of a plane that began with nothing.
const TITLE: &str = "A plane of slipmap explore";

impl PlaneRequest {
    fn description<'a>(&'a self, slice: &'a Slice) -> Result<(Description<'a>, Show), Refusal> {
        let (axes, shown) = (slice.grid.axes(), [slice.x, slice.y]);
        let (show, methods, field) = self.show(&slice.grid)?;
        let title = self.place.title.as_deref().unwrap_or(TITLE);
        let job = self.place.job()?.map(|job| {
            let names = job.machine.quantities().into_iter().map(|(name, _)| name);
            let nodes = |name| {
                Some(shown.map(|axis| &axes[axis]).into_iter().find(|it| it.name == name)?.values.clone())
            };
            let varied = names.filter_map(|name| Some((name, nodes(name)?))).collect();
            MachineJob { varied, title: Some(title.to_owned()), ..job }
        });
        Ok((Description { law: slice.grid.law(), title, axes, shown, methods, field, job }, show))
    }

    /// The plane and its point as texts to copy.
    pub(super) fn texts(&self) -> Result<Value, Refusal> {
        let slice = self.cells()?;
        let (description, show) = self.description(&slice)?;
        let (law, point) = self.place.point()?;
        let command = match &description.job {
            Some(MachineJob { machine, .. }) => {
                let known = machine.quantities().into_iter();
                let known =
                    known.filter(|(name, _)| [&self.x.axis, &self.y.axis].iter().any(|it| it == name));
                let sets: String =
                    known.map(|(name, value)| format!(" --set {name}={}", exact(value))).collect();
                format!("slipmap probe --machine {CONFIG}{sets}")
            }
            None => slipmap_machine::probe::command_line(&law, &point, slipmap_column::DEFAULT_TOLERANCE),
        };
        let toml = description.toml();
        let toml =
            toml.ok_or_else(|| Refusal::bad_input("this law cannot be written", "choose another law"))?;
        // The command for a point of a table reads a file.
        let table = match law.as_written() {
            Law::Table(table) if description.job.is_none() => Some(csv(table)),
            _ => None,
        };
        Ok(json!({
            "toml": toml,
            "commands": description.commands(&show, self.curves),
            "python": format!("import slipmap\n\ndata = slipmap.run(\"{CONFIG}\")\nprint(data.squeeze())\n"),
            "command": command,
            "table": table,
        }))
    }
}

/// The rows of a table.
fn csv(table: &Table) -> String {
    let errors = table.standard_errors();
    let rows = table.data().enumerate().map(|(i, (u, friction))| match errors {
        Some(errors) => format!("{u},{friction},{}\n", errors[i]),
        None => format!("{u},{friction}\n"),
    });
    let head =
        if errors.is_some() { "slip speed,friction,standard error\n" } else { "slip speed,friction\n" };
    std::iter::once(head.to_owned()).chain(rows).collect()
}
