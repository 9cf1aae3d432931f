//! The progress bar, on terminals only.

use std::fmt;
use std::io::{self, IsTerminal as _};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressState, ProgressStyle};

use super::output::count;

/// A bar that counts `unit`s up to `total`, if that is known. Hidden unless standard error is a terminal.
pub(super) fn bar(quiet: bool, total: Option<u64>, unit: &str) -> ProgressBar {
    if quiet || !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let (bar, template) = match total {
        Some(total) => (
            ProgressBar::new(total),
            format!("{{bar:30}} {{human_pos}} of {{human_len}} {unit}, {{rate}}, {{eta}} left"),
        ),
        None => (ProgressBar::no_length(), format!("{{spinner}} {{human_pos}} {unit}, {{rate}}")),
    };
    // With an invalid template the bar looks different, but the run goes on.
    let style = ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar());
    bar.set_style(style.with_key("rate", rate));
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// Formats the speed with three significant digits.
fn rate(state: &ProgressState, out: &mut dyn fmt::Write) {
    let rounded = format!("{:.2e}", state.per_sec()).parse::<f64>().unwrap_or(0.0);
    // A bar that cannot be drawn does not stop the run.
    let _ = write!(out, "{}/s", count(rounded as u64));
}
