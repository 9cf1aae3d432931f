//! The report of a finished run.

use std::io::{self, Write as _};

use serde_json::{Map, Value, json};

use super::Failure;
use super::answer::{fate_name, verdict};
use super::output::{self, Align, Table, bytes, count, duration, short};
use super::point::probe_line;
use super::run::{FailedCell, LISTED};
use crate::config::Job;
use crate::map::{MethodSummary, Summary, Verdict};

/// What there is to report.
pub(super) struct Report<'a> {
    /// The job.
    pub(super) job: &'a Job,
    /// How it went.
    pub(super) summary: &'a Summary,
    /// The first failed cells.
    pub(super) failed_cells: &'a [FailedCell],
}

impl Report<'_> {
    /// Whether cells failed or the audit disagrees.
    pub(super) fn is_flawed(&self) -> bool {
        self.failed() > 0 || !self.summary.audit.disagreements.is_empty()
    }

    /// Number of failed cells, over all methods.
    fn failed(&self) -> u64 {
        self.summary.methods.iter().map(|method| cells_with(method, Verdict::Failed)).sum()
    }

    fn columns(&self) -> usize {
        let grid = &self.job.plan.grid;
        grid.cells() / grid.dampings().len().max(1)
    }

    fn file_size(&self) -> Option<u64> {
        self.job.output.metadata().ok().map(|metadata| metadata.len())
    }
}

/// Number of cells of one verdict.
fn cells_with(method: &MethodSummary, verdict: Verdict) -> u64 {
    Verdict::ALL.iter().position(|v| *v == verdict).map_or(0, |i| method.counts[i])
}

/// Prints it for a person.
pub(super) fn print(report: &Report) -> Result<(), Failure> {
    use Align::{Left, Right};
    let Report { job, summary, .. } = report;
    let mut out = io::stdout().lock();
    let size = report.file_size().map_or(String::new(), |size| format!(", {}", bytes(size.into())));
    writeln!(out, "{}: {}{size}", job.title, job.output.display())?;
    writeln!(
        out,
        "{} cells in {} columns, {} on {} thread{}, {} cells/s\n",
        count(summary.cells),
        count(report.columns()),
        duration(summary.seconds),
        summary.threads,
        if summary.threads == 1 { "" } else { "s" },
        short(rate(summary.cells, summary.seconds))
    )?;

    let shown = [Verdict::Present, Verdict::Absent, Verdict::Undecided, Verdict::Failed];
    let mut columns = vec![("method", Left)];
    for verdict in shown {
        columns.extend([(verdict.name(), Right), ("%", Right)]);
    }
    columns.extend([("CPU s", Right), ("cells/CPU s", Right)]);
    let mut table = Table::new(&columns);
    for method in &summary.methods {
        let mut row = vec![method.method.name().to_owned()];
        for verdict in shown {
            let cells = cells_with(method, verdict);
            row.extend([count(cells), percent(cells, method.cells)]);
        }
        row.extend([short3(method.seconds), short3(rate(method.cells, method.seconds))]);
        table.row(row);
    }
    table.write(&mut out)?;

    writeln!(out)?;
    let paths = summary.paths.named();
    let simulated: u64 = paths.iter().map(|(_, cells)| cells).sum();
    if simulated > 0 {
        let shares = paths.iter().filter(|(_, cells)| *cells > 0).map(|(path, cells)| {
            format!("{} {} ({} %)", path.replace('_', " "), count(*cells), percent(*cells, simulated))
        });
        writeln!(out, "simulation decided by: {}", shares.collect::<Vec<_>>().join(", "))?;
    }
    let audit = &summary.audit;
    if audit.cells > 0 {
        writeln!(
            out,
            "audit: {} cells decided again by the direct engine, {} verdicts checked: {} confirmed, {} within the \
             error of the margin, {} without an answer, {} contradicted",
            count(audit.cells),
            count(audit.checked),
            count(audit.agreed),
            count(audit.within_margin),
            count(audit.unresolved),
            count(audit.disagreements.len())
        )?;
    }
    let (law, tolerance) = (job.plan.grid.law(), job.plan.tolerance);
    for disagreement in audit.disagreements.iter().take(LISTED) {
        writeln!(
            out,
            "  {} says {}, the direct engine {}: {}",
            disagreement.method,
            disagreement.stored.name(),
            fate_name(&disagreement.direct.fate).replace('_', " "),
            probe_line(law, &disagreement.point, tolerance)
        )?;
    }
    if report.failed() > 0 {
        let listed = report.failed_cells.len();
        writeln!(out, "{} verdicts failed; the first {listed}:", count(report.failed()))?;
        for cell in report.failed_cells {
            writeln!(out, "  {}: {}", cell.method.name(), probe_line(law, &cell.point, tolerance))?;
        }
    }
    Ok(())
}

/// Prints it as JSON.
pub(super) fn json(report: &Report) -> Result<(), Failure> {
    let Report { job, summary, failed_cells } = report;
    let (law, tolerance) = (job.plan.grid.law(), job.plan.tolerance);
    let methods: Map<String, Value> = summary
        .methods
        .iter()
        .map(|method| {
            let mut entry = Map::new();
            entry.insert("cells".into(), json!(method.cells));
            entry.insert("seconds".into(), json!(method.seconds));
            for verdict in Verdict::ALL {
                entry.insert(verdict.name().into(), json!(cells_with(method, verdict)));
            }
            (method.method.name().to_owned(), Value::Object(entry))
        })
        .collect();
    let paths: Map<String, Value> =
        summary.paths.named().into_iter().map(|(path, cells)| (path.to_owned(), json!(cells))).collect();
    let disagreements: Vec<Value> = summary
        .audit
        .disagreements
        .iter()
        .map(|disagreement| {
            json!({
                "method": disagreement.method,
                "stored": disagreement.stored.name(),
                "direct": verdict(&disagreement.direct.fate).name(),
                "probe": probe_line(law, &disagreement.point, tolerance),
            })
        })
        .collect();
    let failed: Vec<Value> = failed_cells
        .iter()
        .map(|cell| json!({ "method": cell.method.name(), "probe": probe_line(law, &cell.point, tolerance) }))
        .collect();
    output::json(&json!({
        "title": job.title,
        "output": job.output.to_string_lossy(),
        "bytes": report.file_size(),
        "cells": summary.cells,
        "columns": report.columns(),
        "seconds": summary.seconds,
        "threads": summary.threads,
        "methods": methods,
        "paths": paths,
        "audit": {
            "cells": summary.audit.cells,
            "checked": summary.audit.checked,
            "agreed": summary.audit.agreed,
            "within_margin": summary.audit.within_margin,
            "unresolved": summary.audit.unresolved,
            "disagreements": disagreements,
            "cpu_seconds": summary.audit_seconds,
        },
        "rhs": summary.rhs,
        "pack_cpu_seconds": summary.pack_seconds,
        "failed": report.failed(),
        "failed_cells": failed,
    }))
}

#[allow(clippy::cast_precision_loss)] // shown with three digits
fn rate(cells: u64, seconds: f64) -> f64 {
    cells as f64 / seconds
}

/// A share in per cent; a share that is not all or nothing never reads 100.0 or 0.0.
#[allow(clippy::cast_precision_loss)] // shown with three digits
fn percent(part: u64, whole: u64) -> String {
    let share = 100.0 * part as f64 / whole as f64;
    match part {
        0 => "0".into(),
        _ if part == whole => "100".into(),
        _ => format!("{:.1}", share.clamp(0.1, 99.9)),
    }
}

/// A number with three significant digits.
fn short3(x: f64) -> String {
    short(format!("{x:.2e}").parse().unwrap_or(x))
}
