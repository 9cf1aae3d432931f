//! The layout of a map file: one description for writing, reading and checking maps.

use crate::dimension::of_variable;
use crate::{Axis, Field, Grid, Plan, Quantity, Runs, TileData};
use slipmap_column::{Method, Regime, Verdict};
use slipmap_machine::Dimension;
use slipmap_model::friction::Law;

use super::auxiliary::{self, rank_of};
use super::value::{Value, si_name};

/// Version of the layout of map files, the only one that is read. Version 2 added curves of codimension one,
/// version 3 the errors of critical dampings, version 4 the axes of machines.
pub const SCHEMA: i64 = 4;

/// Source of a variable's cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Verdicts of the method at this position.
    Verdict(usize),
    /// Margins of the method at this position.
    Margin(usize),
    /// Critical dampings of the method at this position.
    CriticalC(usize),
    /// Errors of the critical dampings of the method at this position.
    CriticalError(usize),
    /// Codes of the field `regime`.
    Regime,
    /// The quantity at this position in the list of the plan's quantities.
    Quantity(usize),
}

/// Cells of a variable in memory.
#[derive(Clone, Debug)]
pub enum Cells<'a> {
    /// Codes.
    Codes(Runs<i8>),
    /// Real numbers.
    Reals(&'a [f64]),
}

/// A variable over the grid.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Name of the dataset.
    pub name: String,
    /// What the numbers are.
    pub content: Content,
    /// Its attributes, without fingerprints and counts, which are known only at the end.
    pub attributes: Vec<(&'static str, Value)>,
}

impl Variable {
    /// The codes that its cells may have, with their meanings; `None` for real numbers.
    #[must_use]
    pub fn codes(&self) -> Option<Vec<(i8, &'static str)>> {
        match self.content {
            Content::Verdict(_) => Some(Verdict::ALL.iter().map(|v| (v.code(), v.name())).collect()),
            Content::Regime => Some(Regime::ALL.iter().map(|r| (r.code(), r.name())).collect()),
            _ => None,
        }
    }

    /// The code of cells that were never written.
    #[must_use]
    pub fn fill_code(&self) -> i8 {
        match self.content {
            Content::Regime => Regime::Failed.code(),
            _ => Verdict::NotComputed.code(),
        }
    }

    /// Whether it has no damping axis: critical dampings and their errors.
    fn is_of_columns(&self) -> bool {
        matches!(self.content, Content::CriticalC(_) | Content::CriticalError(_))
    }

    /// Number of its dimensions on a grid of `axes` axes.
    pub fn rank(&self, axes: usize) -> usize {
        axes - usize::from(self.is_of_columns())
    }

    /// The cells of the variable in a computed tile.
    #[must_use]
    pub fn cells<'a>(&self, data: &'a TileData) -> Cells<'a> {
        match self.content {
            Content::Verdict(method) => Cells::Codes(data.methods[method].verdicts.map(Verdict::code)),
            Content::Margin(method) => Cells::Reals(&data.methods[method].margins),
            Content::CriticalC(method) => Cells::Reals(&data.methods[method].critical),
            Content::CriticalError(method) => Cells::Reals(&data.methods[method].critical_errors),
            Content::Regime => Cells::Codes(data.regime.map(Regime::code)),
            Content::Quantity(position) => Cells::Reals(&data.quantities[position]),
        }
    }
}

/// The layout of one map.
#[derive(Clone, Debug)]
pub struct Schema {
    /// The grid.
    pub grid: Grid,
    /// Shape of tiles and chunks.
    pub tile_shape: Vec<usize>,
    /// The methods, in the order of the map.
    pub methods: Vec<Method>,
    /// The stored fields.
    pub fields: Vec<Field>,
    /// The variables, in the order of the file.
    pub variables: Vec<Variable>,
}

impl Schema {
    /// The layout of the map of `plan`.
    #[must_use]
    pub fn of(plan: &Plan) -> Self {
        Self::new(plan.grid.clone(), plan.tile_shape.clone(), plan.methods.clone(), plan.fields.clone())
    }

    /// The layout of a map with these dimensions, methods and fields.
    pub fn new(grid: Grid, tile_shape: Vec<usize>, methods: Vec<Method>, fields: Vec<Field>) -> Self {
        let mut variables = Vec::new();
        let mut quantities = 0;
        for field in Field::ALL {
            if field != Field::Verdict && !fields.contains(&field) {
                continue;
            }
            match field {
                Field::Verdict => {
                    per_method(&mut variables, grid.law(), &methods, "verdict", Content::Verdict)
                }
                Field::Margin => per_method(&mut variables, grid.law(), &methods, "margin", Content::Margin),
                Field::CriticalC => {
                    let [name, errors] = Field::critical_of(&grid);
                    per_method(
                        &mut variables,
                        grid.law(),
                        &methods,
                        name.trim_end_matches('_'),
                        Content::CriticalC,
                    );
                    add_errors(&mut variables, &methods, errors);
                }
                Field::Regime => {
                    let words = "long-run behaviour according to the simulated flow";
                    variables.push(plain("regime", words, Content::Regime));
                }
                field => {
                    for quantity in Quantity::of(field, methods.len(), grid.axes().len() - 1) {
                        let content = Content::Quantity(quantities);
                        variables.push(of_quantity(quantity, &methods, &grid, content));
                        quantities += 1;
                    }
                }
            }
        }
        variables.iter_mut().for_each(|variable| describe_in_si(variable, &grid));
        Self { grid, tile_shape, methods, fields, variables }
    }

    /// Names of the dimensions, slowest first.
    pub fn dimensions(&self) -> Vec<&str> {
        self.grid.axes().iter().map(|axis| axis.name.as_str()).collect()
    }

    /// The variables over the grid and the given auxiliary ones, each with the number of its axes, the first of the grid.
    pub fn ranks(
        &self,
        auxiliary: impl Iterator<Item = &'static str>,
    ) -> impl Iterator<Item = (&str, usize)> {
        let axes = self.grid.axes().len();
        let own = self.variables.iter().map(move |v| (v.name.as_str(), v.rank(axes)));
        own.chain(auxiliary.map(|name| (name, rank_of(name, &self.grid))))
    }

    /// Number of tiles.
    pub fn tiles(&self) -> usize {
        self.grid.tile_count(&self.tile_shape)
    }

    /// Number of consecutive tiles along the damping axis. A variable without that axis takes its cells from
    /// the first of these tiles.
    fn tiles_per_column(&self) -> usize {
        match self.tile_shape.last() {
            Some(&tile) => self.grid.dampings().len().div_ceil(tile),
            None => 1,
        }
    }

    /// Shape of a variable.
    #[must_use]
    pub fn shape(&self, variable: &Variable) -> Vec<usize> {
        let mut shape = self.grid.shape();
        shape.truncate(variable.rank(shape.len()));
        shape
    }

    /// Shape of a variable's chunks.
    pub fn chunk(&self, variable: &Variable) -> Vec<usize> {
        self.tile_shape[..variable.rank(self.tile_shape.len())].to_vec()
    }

    /// Number of a variable's chunks.
    pub fn chunks(&self, variable: &Variable) -> usize {
        match variable.is_of_columns() {
            true => self.tiles() / self.tiles_per_column(),
            false => self.tiles(),
        }
    }

    /// The variables of which the tile fills a chunk, with their positions.
    pub fn filled_by(&self, tile: usize) -> impl Iterator<Item = (usize, &Variable)> {
        let all = self.variables.iter().enumerate();
        all.filter(move |(_, variable)| self.fills(variable, tile))
    }

    /// Index of the first cell of the chunk of a variable that a tile fills.
    pub fn offset(&self, variable: &Variable, tile: usize) -> Vec<usize> {
        let ranges = self.grid.tile(&self.tile_shape, tile).ranges;
        ranges[..variable.rank(ranges.len())].iter().map(|range| range.start).collect()
    }

    /// Whether a tile fills a chunk of a variable.
    pub fn fills(&self, variable: &Variable, tile: usize) -> bool {
        !variable.is_of_columns() || tile.is_multiple_of(self.tiles_per_column())
    }

    /// Size of the cells in bytes before compression.
    pub(crate) fn bytes(&self) -> u128 {
        let of = |variable: &Variable| {
            let cells: u128 = self.shape(variable).into_iter().map(|length| length as u128).product();
            if variable.codes().is_some() { cells } else { 8 * cells }
        };
        self.variables.iter().map(of).sum()
    }
}

fn per_method(
    variables: &mut Vec<Variable>,
    law: &Law,
    methods: &[Method],
    field: &str,
    content: fn(usize) -> Content,
) {
    for (position, method) in methods.iter().enumerate() {
        let content = content(position);
        let what = match content {
            Content::Margin(_) => "margin of the verdict: ",
            Content::CriticalC(_) => "critical damping: ",
            _ => "does a stick-slip limit cycle exist: ",
        };
        let mut variable =
            plain(&format!("{field}_{}", method.name()), &format!("{what}{}", method.long_name()), content);
        variable.attributes.push(("guarantee", method.guarantee().name().into()));
        variable.attributes.push(("equation", method.equation_for(law).into_owned().into()));
        variables.push(variable);
    }
}

/// Says of each critical damping what its error is, and adds the variable with the errors of the simulation,
/// the only method whose critical damping is approximate.
fn add_errors(variables: &mut Vec<Variable>, methods: &[Method], prefix: &str) {
    let mut errors = None;
    for variable in variables.iter_mut() {
        let Content::CriticalC(position) = variable.content else { continue };
        let method = methods[position];
        if !matches!(method, Method::Simulation) {
            let exact =
                "the edge of what the method claims, exact to rounding; NaN where it claims no presence";
            variable.attributes.push(("comment", exact.into()));
            continue;
        }
        let of = format!("{prefix}{}", method.name());
        let comment = "NaN where no damping >= 0 is critical or none was found (no error), and where the error \
                       is more than 1 % of it and 1e-9";
        variable.attributes.push(("comment", comment.into()));
        variable.attributes.push(("ancillary_variables", of.as_str().into()));
        let what = format!("estimate of the absolute error of the critical damping: {}", method.long_name());
        let mut of_errors = plain(&of, &what, Content::CriticalError(position));
        let comment = "numerical error, for the friction as given: the uncertainty of measured or fitted friction is not in it, \
                       and is told by slipmap machine and slipmap probe";
        of_errors.attributes.push(("comment", comment.into()));
        errors = Some(of_errors);
    }
    variables.extend(errors);
}

/// The variable of a quantity; its name ends with that of the method or the axis, if the quantity has one.
fn of_quantity(quantity: Quantity, methods: &[Method], grid: &Grid, content: Content) -> Variable {
    match quantity {
        Quantity::EpsilonLimit(method) => {
            let method = methods[method];
            let name = format!("{}_{}", quantity.name(), method.name());
            plain(&name, &format!("{}: {}", quantity.long_name(), method.long_name()), content)
        }
        Quantity::CriticalDerivative(axis) => {
            let axis = &grid.axes()[axis].name;
            let name = format!("{}{axis}", quantity.name());
            plain(&name, &format!("{} {axis}", quantity.long_name()), content)
        }
        _ => plain(quantity.name(), quantity.long_name(), content),
    }
}

/// Gives a variable of a machine's map its SI unit, and names the quantities that do not vary as its coordinates.
fn describe_in_si(variable: &mut Variable, grid: &Grid) {
    let Some(machine) = grid.machine() else { return };
    let unit = match (variable.content, of_variable(&variable.name)) {
        (_, Some(Dimension::Damping)) => si_name(machine.unit(machine.damping_name())),
        (_, Some(dimension)) => si_name(machine.motion.unit(dimension)),
        (Content::Quantity(_), None) => {
            // The derivative by an axis has the unit of the damping over that of the axis.
            let by = variable.name.strip_prefix(Quantity::CriticalDerivative(0).name());
            let axis = by.and_then(|name| grid.axes().iter().find(|axis| axis.name == name));
            let damping = si_name(machine.unit(machine.damping_name()));
            match axis {
                Some(Axis { unit: "", .. }) => damping,
                Some(axis) => format!("({damping})/({})", si_name(axis.unit)),
                None => si_name(""),
            }
        }
        _ => si_name(""),
    };
    for (name, value) in &mut variable.attributes {
        if *name == "units" {
            *value = unit.as_str().into();
        }
    }
    let fixed = auxiliary::names(grid).into_iter().filter(|name| !auxiliary::PROBABILITIES.contains(name));
    variable.attributes.push(("coordinates", fixed.collect::<Vec<_>>().join(" ").into()));
}

/// A variable with the attributes that all variables have.
fn plain(name: &str, long_name: &str, content: Content) -> Variable {
    let mut variable = Variable {
        name: name.into(),
        content,
        attributes: vec![("long_name", long_name.into()), ("units", "1".into())],
    };
    if let Some(codes) = variable.codes() {
        let meanings: Vec<&str> = codes.iter().map(|&(_, meaning)| meaning).collect();
        variable
            .attributes
            .push(("flag_values", Value::Codes(codes.iter().map(|&(code, _)| code).collect())));
        variable.attributes.push(("flag_meanings", meanings.join(" ").into()));
    }
    variable
}

impl Plan {
    /// Size of the map in bytes before compression.
    pub fn bytes(&self) -> u128 {
        Schema::of(self).bytes()
    }
}
