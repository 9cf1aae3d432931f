//! What a command tells before it computes: units in SI, how data were read, and numbers that suggest other units.

use super::say;
use slipmap_machine::{Friction, Machine, negative};
use slipmap_model::friction::{Law, Table};

/// Prints what units in the configuration are in SI.
pub(super) fn tell_units(conversions: &[String]) {
    if !conversions.is_empty() {
        say(&format!("note: {}", conversions.join(", ")));
    }
}

/// Tells how its measured friction was read, and warns of each number of a machine that suggests other units.
pub(super) fn warn(machine: &Machine) {
    if let Friction::Measured(table) = &machine.friction {
        tell(table);
    }
    for doubt in machine.doubts() {
        say(&format!("warning: {doubt}"));
    }
}

/// Tells how a table was read, and warns of negative friction in it.
pub(super) fn warn_of_law(law: &Law) {
    if let Law::Table(table) = law.as_written() {
        tell(table);
        if let Some(doubt) = negative(table) {
            say(&format!("warning: {doubt}"));
        }
    }
}

/// Tells how a table was read, if it is not as the documentation has it.
fn tell(table: &Table) {
    if let Some(told) = &table.source().told {
        say(&format!("read: {told}"));
    }
}
