//! The command line of `slipmap probe` for a point.

use slipmap_model::friction::Law;
use slipmap_model::point::Point;
use slipmap_numbers::text::exact;

/// The names of all axes of all laws, without repetition.
pub fn axis_names() -> Vec<&'static str> {
    let mut names = Vec::new();
    for name in Law::BUILT_IN.map(Law::with_exponent).iter().flat_map(Law::axis_names) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// The option that sets an axis: `--alpha `, or `--set name=`.
pub fn flag(name: &str) -> String {
    if axis_names().contains(&name) { format!("--{name} ") } else { format!("--set {name}=") }
}

/// The command that explains a point, to be pasted into a shell.
pub fn command_line(law: &Law, point: &Point, tolerance: f64) -> String {
    let mut line = String::from("slipmap probe");
    match law.as_written() {
        Law::Stribeck => {}
        Law::Expression(law) => line.push_str(&format!(" --phi '{}'", law.text())),
        Law::Table(table) => line.push_str(&format!(" --table '{}'", table.origin())),
        // A function of another program has no option on the command line.
        Law::Function(law) => line.push_str(&format!(" --law '{}'", law.origin())),
        other => line.push_str(&format!(" --law {}", other.name())),
    }
    let (level, may_drop) = match law.as_written() {
        Law::Expression(law) => (law.static_level(), law.may_drop()),
        Law::Table(table) => (table.static_level(), table.may_drop()),
        _ => (1.0, false),
    };
    if level != 1.0 || may_drop {
        line.push_str(&format!(" --static {}", exact(level)));
    }
    if law.is_read_as_small() {
        line.push_str(" --small eps");
    }
    for (name, value) in law.coordinates(point) {
        line.push_str(&format!(" {}{}", flag(name), exact(value)));
    }
    if tolerance != slipmap_column::DEFAULT_TOLERANCE {
        line.push_str(&format!(" --tolerance {}", exact(tolerance)));
    }
    line
}
