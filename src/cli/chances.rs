//! What is said of the draws of uncertain quantities.

use super::output::{count, number_of};

/// Notes on draws that were illegal and on draws without an answer.
pub(super) fn notes_on_draws(draws: usize, failed: usize, redrawn: usize) -> Vec<String> {
    let mut notes = Vec::new();
    if redrawn > 0 {
        notes.push(format!(
            "{} of illegal values, such as a negative damping or an exponent below 1, do not count; {} do",
            number_of(redrawn, "draw"),
            count(draws)
        ));
    }
    if failed > 0 {
        notes.push(format!(
            "{} of {} without an answer, since the critical damping was not found",
            count(failed),
            number_of(draws, "draw")
        ));
    }
    notes
}
