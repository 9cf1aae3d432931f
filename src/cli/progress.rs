//! The progress bar: on a terminal only.

use std::io::{self, IsTerminal as _};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// A bar that counts `unit`s up to `total`, if that is known. Hidden unless standard error is a terminal.
pub(super) fn bar(quiet: bool, total: Option<u64>, unit: &str) -> ProgressBar {
    if quiet || !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let (bar, template) = match total {
        Some(total) => (
            ProgressBar::new(total),
            format!("{{bar:30}} {{human_pos}} of {{human_len}} {unit}, {{per_sec}}, {{eta}} left"),
        ),
        None => (ProgressBar::no_length(), format!("{{spinner}} {{human_pos}} {unit}, {{per_sec}}")),
    };
    // A template that indicatif does not understand costs the looks, not the run.
    let style = ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar());
    bar.set_style(style);
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}
