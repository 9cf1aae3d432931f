//! The report of a finished run.

use std::io::Write;

use serde_json::json;

use super::Failure;
use super::output::{self, Align, TextTable, bytes, count, duration, exact, number_of, object, short};
use slipmap_column::bifurcation::Bifurcation;
use slipmap_column::{Method, Verdict, left_out};
use slipmap_config::{Job, load_machine};
use slipmap_machine::probe::{command_line, fate_name};
use slipmap_map::{Axis, Field, LISTED, PlaneCurves, Summary};
use slipmap_numbers::text::rounded;
use slipmap_report::proved::{Rounded, proved_percent};

/// Share of the box left undecided above which the summary says what to raise.
const MUCH_UNDECIDED: f64 = 0.01;

pub(super) struct RunReport<'a> {
    pub(super) job: &'a Job,
    /// The result of the run.
    pub(super) summary: &'a Summary,
    /// Processor seconds of the probabilities, for a machine with uncertain quantities.
    pub(super) probability_seconds: f64,
    /// Wall-clock seconds of the whole run, of which the summary's are those of the cells.
    pub(super) seconds: f64,
    /// Number of tiles that earlier runs had finished.
    pub(super) resumed_tiles: usize,
}

impl RunReport<'_> {
    /// Returns whether cells failed, methods contradict each other, or the audit disagrees.
    pub(super) fn is_flawed(&self) -> bool {
        self.failed() > 0
            || self.summary.account.contradictions.cells > 0
            || !self.summary.account.audit.disagreements.is_empty()
    }

    /// Number of failed cells, over all methods.
    fn failed(&self) -> u64 {
        let blank = self.summary.account.blank;
        self.summary.account.methods.iter().map(|method| method.cells_with(Verdict::Failed) - blank).sum()
    }

    /// Processor seconds that belong to no method, by stage.
    fn stages(&self) -> Vec<(&'static str, f64)> {
        let mut stages = self.summary.account.stages.named().to_vec();
        stages.push(("probability", self.probability_seconds));
        stages
    }

    /// The time of the whole run, if it had more to do than cells.
    fn whole_time(&self) -> String {
        let parts = [
            ("curves", !self.summary.curves.is_empty()),
            ("proofs", self.summary.proved.is_some()),
            ("probabilities", self.probability_seconds > 0.0),
        ];
        let parts: Vec<&str> = parts.iter().filter(|(_, had)| *had).map(|(part, _)| *part).collect();
        match parts.is_empty() {
            true => String::new(),
            false => format!("; in all, with {}, {}", parts.join(" and "), duration(self.seconds)),
        }
    }

    /// The command that explains the cell with this index. For a machine it names the configuration, and the
    /// quantities that vary or that the run overrode.
    fn probe(&self, index: &[usize]) -> String {
        let (job, grid, tolerance) = (self.job, &self.job.plan.grid, self.job.plan.tolerance);
        let Some(machine) = grid.machine_at(&grid.values(index)) else {
            return command_line(grid.law(), &grid.point(index), tolerance);
        };
        let written = load_machine::<f64>(&job.config_file, &[])
            .map_or_else(|_| Vec::new(), |of| of.machine.quantities());
        let is_axis = |name: &str| grid.axes().iter().any(|axis| axis.name == name);
        let set = machine.quantities().into_iter();
        let set = set.filter(|quantity| is_axis(quantity.0) || !written.contains(quantity));
        let sets: String = set.map(|(name, value)| format!(" --set {name}={}", exact(value))).collect();
        format!("slipmap probe --machine '{}'{sets}", job.config_file.display())
    }

    fn file_size(&self) -> Option<u64> {
        self.job.output.metadata().ok().map(|metadata| metadata.len())
    }
}

pub(super) fn print(report: &RunReport, out: &mut dyn Write) -> Result<(), Failure> {
    head(report, out)?;
    // How methods did is in the report of a machine's map.
    match answer(report) {
        Some(answer) => writeln!(out, "{answer}")?,
        None => {
            methods(report, out)?;
            decided(report, out)?;
            audit(report, out)?;
        }
    }
    proved(report, out)?;
    unknown(report, out)?;
    contradictions(report, out)
}

/// What the cells of a machine's map say, and what to do next; `None` for other maps and without a simulation.
fn answer(report: &RunReport) -> Option<String> {
    let RunReport { job, summary, .. } = report;
    let grid = &job.plan.grid;
    grid.machine()?;
    let at = job.plan.methods.iter().position(|method| *method == Method::Simulation)?;
    let found = &summary.account.methods[at];
    let cells = summary.account.cells;
    let share = |verdict: Verdict| percent(found.cells_with(verdict), cells);
    let known = [(Verdict::Present, "it may stick-slip in"), (Verdict::Absent, "and cannot in")];
    let known: Vec<String> = known.map(|(verdict, words)| format!("{words} {} %", share(verdict))).to_vec();
    let unknown =
        found.cells_with(Verdict::Undecided) + found.cells_with(Verdict::Failed) - summary.account.blank;
    let unknown = match unknown {
        0 => String::new(),
        cells_unknown => format!("; not known in {} %", percent(cells_unknown, cells)),
    };
    let several: Vec<&Axis> = grid.axes().iter().filter(|axis| axis.values.len() > 1).collect();
    let map = job.output.display();
    let picture = job.output.with_extension("svg");
    let variable = if job.plan.fields.contains(&Field::Regime) { "regime" } else { "verdict_simulation" };
    let draw = match several.as_slice() {
        [] => String::new(),
        [x] => {
            format!("\n  slipmap plot {map} --x {} --variable {variable} --out {}", x.name, picture.display())
        }
        [.., x, y] => {
            let (x, y) = (&x.name, &y.name);
            format!(
                "\n  slipmap plot {map} --x {x} --y {y} --variable {variable} --out {}",
                picture.display()
            )
        }
    };
    Some(format!(
        "{} of the cells{unknown}\n\nnext:{draw}\n  slipmap report {map}   (tables and figures; methods, their times and the audit)",
        known.join(" ")
    ))
}

/// The map, its size and the time it took.
fn head(report: &RunReport, out: &mut dyn Write) -> Result<(), Failure> {
    let RunReport { job, summary, .. } = report;
    let account = &summary.account;
    let size = report.file_size().map_or(String::new(), |size| format!(", {}", bytes(size.into())));
    writeln!(out, "{}: {}{size}", job.title, job.output.display())?;
    writeln!(
        out,
        "{} in {}, {} on {}, {} cells/s{}{}\n",
        number_of(account.cells, "cell"),
        number_of(job.plan.grid.column_count(), "column"),
        duration(summary.seconds),
        number_of(summary.threads, "thread"),
        rounded(rate(account.cells, summary.seconds), 3),
        peak_memory().map_or(String::new(), |peak| format!(", {} of memory", bytes(peak.into()))),
        report.whole_time()
    )?;

    Ok(())
}

/// The verdicts and the time of every method.
fn methods(report: &RunReport, out: &mut dyn Write) -> Result<(), Failure> {
    use Align::{Left, Right};
    let RunReport { job, summary, .. } = report;
    let account = &summary.account;
    let shown = [Verdict::Present, Verdict::Absent, Verdict::Undecided, Verdict::Failed];
    let mut columns = vec![("method", Left)];
    for verdict in shown {
        columns.extend([(verdict.name(), Right), ("%", Right)]);
    }
    columns.extend([("processor s", Right), ("cells/processor s", Right)]);
    let mut table = TextTable::new(&columns);
    for (method, found) in job.plan.methods.iter().zip(&account.methods) {
        let mut row = vec![method.name().to_owned()];
        for verdict in shown {
            let cells = found.cells_with(verdict);
            row.extend([count(cells), percent(cells, account.cells)]);
        }
        row.extend([rounded(found.seconds, 3), rounded(rate(account.cells, found.seconds), 3)]);
        table.row(row);
    }
    // Time that belongs to no method, and the total.
    let methods: f64 = account.methods.iter().map(|method| method.seconds).sum();
    let stages = report.stages();
    let all = methods + stages.iter().map(|(_, seconds)| seconds).sum::<f64>();
    for (stage, seconds) in stages.into_iter().filter(|(_, seconds)| *seconds > 0.0).chain([("all", all)]) {
        let mut row = vec![stage.to_owned()];
        row.resize(1 + 2 * shown.len(), String::new());
        row.extend([rounded(seconds, 3), rounded(rate(account.cells, seconds), 3)]);
        table.row(row);
    }
    table.write(out)?;

    writeln!(out)?;
    if report.resumed_tiles > 0 {
        let grid = &job.plan.grid;
        let tiles = grid.tile_count(&job.plan.tile_shape);
        writeln!(
            out,
            "resumed: {} of {} finished before; seconds are those of all runs",
            count(report.resumed_tiles),
            number_of(tiles, "tile")
        )?;
    }
    Ok(())
}

/// What decided the cells of the simulation, and the curves.
fn decided(report: &RunReport, out: &mut dyn Write) -> Result<(), Failure> {
    let RunReport { job, summary, .. } = report;
    let account = &summary.account;
    let paths = account.paths.named();
    let simulated: u64 = paths.iter().map(|(_, cells)| cells).sum();
    if simulated > 0 {
        let shares = paths.iter().filter(|(_, cells)| *cells > 0).map(|(path, cells)| {
            format!("{} {} ({} %)", path.replace('_', " "), count(*cells), percent(*cells, simulated))
        });
        writeln!(out, "simulation decided by: {}", shares.collect::<Vec<_>>().join(", "))?;
    }
    let axes = job.plan.grid.axes();
    for curves in &summary.curves {
        writeln!(out, "{}", curves_line(axes, curves))?;
    }
    if !summary.curves.is_empty() {
        writeln!(out, "  found by continuation in {}", duration(summary.curves_seconds))?;
    }
    Ok(())
}

/// What is proved between the nodes.
fn proved(report: &RunReport, out: &mut dyn Write) -> Result<(), Failure> {
    let RunReport { job, summary, .. } = report;
    if let Some(proved) = &summary.proved {
        let shares = proved.proof.shares();
        let undecided = shares.undecided();
        writeln!(
            out,
            "proved by validated over the whole box, all points between the nodes included: the cycle present in at least \
             {} %, absent in at least {} %, undecided in at most {} %, from {} boxes of the parameters in {}",
            proved_percent(shares.present, undecided, Rounded::Down),
            proved_percent(shares.absent, undecided, Rounded::Down),
            proved_percent(undecided, undecided, Rounded::Up),
            count(proved.proof.tried),
            duration(proved.seconds)
        )?;
        if let Some(stop) = proved.proof.stop() {
            writeln!(out, "  the largest undecided box: {stop}")?;
        }
        if undecided > MUCH_UNDECIDED {
            let more = 4 * job.plan.proof_boxes;
            writeln!(out, "  more boxes leave less undecided: --set validated.boxes={more}")?;
        }
    }
    Ok(())
}

/// What the second engine said.
fn audit(report: &RunReport, out: &mut dyn Write) -> Result<(), Failure> {
    let account = &report.summary.account;
    let audit = &account.audit;
    if audit.cells > 0 {
        writeln!(
            out,
            "audit: {} decided again by the direct engine, {} checked: {} confirmed, {} within the \
             error of the margin, {} without an answer, {} contradicted",
            number_of(audit.cells, "cell"),
            number_of(audit.checked, "verdict"),
            count(audit.agreed),
            count(audit.within_margin),
            count(audit.unresolved),
            count(audit.disagreements.len())
        )?;
    }
    Ok(())
}

/// What is not known of some cells.
fn unknown(report: &RunReport, out: &mut dyn Write) -> Result<(), Failure> {
    let RunReport { job, summary, .. } = report;
    let account = &summary.account;
    if let Some(why) = job.plan.grid.gap() {
        let cells = number_of(account.cells, "cell");
        writeln!(out, "no machine in {} of {cells}, which are blank: {why}", count(account.blank))?;
    }
    let unknown = account.unknown;
    if unknown.regimes > 0 {
        let cells = number_of(account.cells, "cell");
        writeln!(out, "regime: not determined in {} of {cells}", count(unknown.regimes))?;
    }
    if let Some(from) = account.left_out_from {
        writeln!(out, "regime: {}", left_out(from))?;
    }
    let columns = number_of(job.plan.grid.column_count(), "column");
    for (number, what, why) in [
        (unknown.critical, "not found", "no engine gave an answer next to it"),
        (unknown.inaccurate, "withheld", "its error is more than 1 % of it"),
    ] {
        if number > 0 {
            writeln!(
                out,
                "critical damping of simulation: {what} in {} of {columns}, since {why}",
                count(number)
            )?;
        }
    }
    Ok(())
}

/// The cells that disagree, contradict each other or failed.
fn contradictions(report: &RunReport, out: &mut dyn Write) -> Result<(), Failure> {
    let RunReport { job, summary, .. } = report;
    let account = &summary.account;
    let audit = &account.audit;
    for disagreement in audit.disagreements.iter().take(LISTED) {
        writeln!(
            out,
            "  {} says {}, the direct engine {}: {}",
            job.plan.methods[disagreement.method].name(),
            disagreement.stored.name(),
            fate_name(&disagreement.direct).replace('_', " "),
            report.probe(&disagreement.index)
        )?;
    }
    let contradictions = &account.contradictions;
    if contradictions.cells > 0 {
        writeln!(
            out,
            "{} in which methods with a guarantee contradict each other: at most one of them is right, \
             please report this; the first {}:",
            number_of(contradictions.cells, "cell"),
            contradictions.first.len()
        )?;
        for cell in &contradictions.first {
            let methods_with = |wanted: Verdict| {
                let methods = job.plan.methods.iter().zip(&cell.verdicts);
                let named =
                    methods.filter(|(_, verdict)| **verdict == wanted).map(|(method, _)| method.name());
                named.collect::<Vec<_>>().join(", ")
            };
            let (present, absent) = (methods_with(Verdict::Present), methods_with(Verdict::Absent));
            let probe = report.probe(&cell.index);
            writeln!(out, "  present by {present}; absent by {absent}: {probe}")?;
        }
    }
    if report.failed() > 0 {
        let listed = account.failed.len();
        writeln!(out, "{} failed; the first {listed}:", number_of(report.failed(), "verdict"))?;
        for cell in &account.failed {
            writeln!(out, "  {}: {}", job.plan.methods[cell.method].name(), report.probe(&cell.index))?;
        }
    }
    Ok(())
}

/// Refuses a machine where a study compares methods on dimensionless points.
pub(super) fn refuse_machine(job: &Job) -> Result<(), Failure> {
    match job.plan.grid.machine() {
        Some(_) => Err(Failure::bad_input(
            format!("{}: this is a study of methods, on dimensionless numbers", job.config_file.display()),
            "write a configuration with [grid] in place of [machine]",
        )),
        None => Ok(()),
    }
}

/// "curves over V and c at gamma = 2: hopf 1, grazing sliding 2, 310 points".
fn curves_line(axes: &[Axis], curves: &PlaneCurves) -> String {
    let plane = &curves.plane;
    let held = axes.iter().zip(&plane.held).enumerate();
    let held: Vec<String> = held
        .filter(|(axis, (shown, _))| *axis != plane.x && *axis != plane.y && shown.values.len() > 1)
        .map(|(_, (axis, &node))| format!("{} = {}", axis.name, short(axis.values[node])))
        .collect();
    let at = if held.is_empty() { String::new() } else { format!(" at {}", held.join(", ")) };
    let mut found: Vec<String> = Bifurcation::ALL
        .iter()
        .map(|kind| (kind, curves.curves.iter().filter(|curve| curve.bifurcation == *kind).count()))
        .filter(|(_, count)| *count > 0)
        .map(|(kind, count)| format!("{} {count}", kind.name().replace('_', " ")))
        .collect();
    found.push(if found.is_empty() { "none".into() } else { number_of(curves.points(), "point") });
    found.extend(curves.cut_in_words());
    format!("curves over {} and {}{at}: {}", axes[plane.x].name, axes[plane.y].name, found.join(", "))
}

/// Largest memory of this process in bytes, where the system reports it (Linux).
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok().map(|kilobytes| 1024 * kilobytes)
}

pub(super) fn json(report: &RunReport) -> Result<(), Failure> {
    let RunReport { job, summary, resumed_tiles, .. } = report;
    let account = &summary.account;
    let methods = object(job.plan.methods.iter().zip(&account.methods).map(|(method, found)| {
        let verdicts = Verdict::ALL.map(|verdict| (verdict.name(), json!(found.cells_with(verdict))));
        let cost = [("cells", json!(account.cells)), ("seconds", json!(found.seconds))];
        (method.name(), object(cost.into_iter().chain(verdicts)))
    }));
    output::print_json(&json!({
        "title": job.title,
        "output": job.output.to_string_lossy(),
        "bytes": report.file_size(),
        "cells": account.cells,
        "columns": job.plan.grid.column_count(),
        "seconds": summary.seconds,
        "run_seconds": report.seconds,
        "resumed_tiles": resumed_tiles,
        "threads": summary.threads,
        "methods": methods,
        "paths": object(account.paths.named()),
        "audit": {
            "cells": account.audit.cells,
            "checked": account.audit.checked,
            "agreed": account.audit.agreed,
            "within_margin": account.audit.within_margin,
            "unresolved": account.audit.unresolved,
            "disagreements": account.audit.disagreements.iter().map(|found| json!({
                "method": job.plan.methods[found.method].name(),
                "stored": found.stored.name(),
                "direct": Verdict::from(&found.direct).name(),
                "probe": report.probe(&found.index),
            })).collect::<Vec<_>>(),
            "thread_seconds": account.stages.audit,
        },
        "contradictions": {
            "cells": account.contradictions.cells,
            "first": account.contradictions.first.iter().map(|cell| json!({
                "verdicts": object(
                    job.plan.methods.iter().zip(&cell.verdicts).map(|(method, verdict)| (method.name(), verdict.name())),
                ),
                "probe": report.probe(&cell.index),
            })).collect::<Vec<_>>(),
        },
        "unknown": { "regimes": account.unknown.regimes, "critical_c": account.unknown.critical,
            "critical_c_inaccurate": account.unknown.inaccurate },
        "curves": summary.curves.iter().map(|curves| json!({
            "x": job.plan.grid.axes()[curves.plane.x].name,
            "y": job.plan.grid.axes()[curves.plane.y].name,
            "curves": curves.curves.len(),
            "points": curves.points(),
            "codimension_two": curves.curves.iter().filter(|curve| curve.bifurcation.along().is_some())
                .flat_map(|curve| curve.points.iter().map(|point| json!({
                    "kind": curve.bifurcation.name(), "x": point.x, "y": point.y, "error": point.error,
                }))).collect::<Vec<_>>(),
        })).collect::<Vec<_>>(),
        "curves_seconds": summary.curves_seconds,
        "proved": summary.proved.as_ref().map(|proved| json!({
            "present": proved.proof.shares().present,
            "absent": proved.proof.shares().absent,
            "undecided_at_most": proved.proof.shares().undecided(),
            "boxes": proved.proof.tried,
            "stop": proved.proof.stop().map(|stop| stop.to_string()),
            "seconds": proved.seconds,
        })),
        "rhs": account.rhs,
        "peak_bytes": peak_memory(),
        "pack_thread_seconds": account.stages.pack,
        "stages": object(report.stages()),
        "failed": report.failed(),
        "failed_cells": account.failed.iter().map(|cell| json!({
            "method": job.plan.methods[cell.method].name(),
            "probe": report.probe(&cell.index),
        })).collect::<Vec<_>>(),
    }))
}

fn rate(cells: u64, seconds: f64) -> f64 {
    cells as f64 / seconds
}

/// Formats a share in per cent. Only an empty share is shown as 0 and only a full one as 100.
fn percent(part: u64, whole: u64) -> String {
    match 100.0 * part as f64 / whole as f64 {
        _ if part == 0 => "0".into(),
        _ if part == whole => "100".into(),
        share if share < 0.05 => "<0.1".into(),
        share if share >= 99.95 => ">99.9".into(),
        share => format!("{share:.1}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_map::{
        Account, Audit, Contradiction, Contradictions, Disagreement, FailedCell, MethodAccount, Unknown,
    };
    use slipmap_model::flow::{Failure as Breakdown, Fate};
    use slipmap_model::friction::Law;

    fn job() -> Job {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("job.toml");
        let axes = ["epsilon = 0.1", "alpha = 0.5", "beta = 0.0", "gamma = 1.0", "V = 1.0", "c = [0.0, 1.0]"];
        std::fs::write(&file, format!("[grid]\n{}\n", axes.join("\n"))).unwrap();
        Job::load(&file, &[]).unwrap()
    }

    fn summary(failed: u64, disagreements: Vec<Disagreement>) -> Summary {
        let counts = Verdict::ALL.map(|verdict| if verdict == Verdict::Failed { failed } else { 0 });
        let methods = vec![MethodAccount { seconds: 1.0, counts }];
        let audit = Audit { cells: 2, checked: 2, agreed: 1, disagreements, ..Audit::default() };
        Summary {
            seconds: 1.0,
            threads: 1,
            account: Account { cells: 2, methods, audit, ..Account::default() },
            proved: None,
            curves: Vec::new(),
            curves_seconds: 0.0,
        }
    }

    fn of<'a>(job: &'a Job, summary: &'a Summary) -> RunReport<'a> {
        RunReport { job, summary, probability_seconds: 0.0, seconds: 3.0, resumed_tiles: 0 }
    }

    fn text(report: &RunReport) -> String {
        let mut out = Vec::new();
        print(report, &mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn the_time_of_the_whole_run_is_told() {
        let (job, summary) = (job(), summary(0, Vec::new()));
        let printed =
            |probability_seconds: f64| text(&RunReport { probability_seconds, ..of(&job, &summary) });
        assert!(!printed(0.0).contains("in all"), "{}", printed(0.0));
        assert!(printed(1.5).contains("; in all, with probabilities, 3"), "{}", printed(1.5));
    }

    #[test]
    fn fields_without_an_answer_are_counted() {
        let job = job();
        let mut summary = summary(0, Vec::new());
        let printed = |summary: &Summary| text(&of(&job, summary));
        assert!(!printed(&summary).contains("not determined") && !printed(&summary).contains("not found"));
        summary.account.unknown = Unknown { regimes: 2, critical: 1, inaccurate: 1 };
        let printed = printed(&summary);
        assert!(printed.contains("regime: not determined in 2 of 2 cells"), "{printed}");
        assert!(printed.contains("critical damping of simulation: not found in 1 of 1 column,"), "{printed}");
        assert!(printed.contains("critical damping of simulation: withheld in 1 of 1 column,"), "{printed}");
    }

    #[test]
    fn failures_and_contradictions_are_listed_with_their_points() {
        let job = job();
        let index = vec![0, 0, 0, 0, 0, 1];
        let point = job.plan.grid.point(&index);
        let position = |name: &str| job.plan.methods.iter().position(|method| method.name() == name).unwrap();
        let line = "slipmap probe --epsilon 0.1 --alpha 0.5 --beta 0 --gamma 1 --V 1 --c 1";
        assert_eq!(command_line(&Law::Stribeck, &point, job.plan.tolerance), line);

        let fine = summary(0, Vec::new());
        let report = of(&job, &fine);
        assert!(!report.is_flawed() && !text(&report).contains("slipmap probe"));
        let says = |summary: &Summary, words: &str| {
            let report = of(&job, summary);
            assert!(report.is_flawed() && text(&report).contains(words), "{}", text(&report));
        };

        let mut failed = summary(1, Vec::new());
        failed.account.failed =
            vec![FailedCell { tile: 0, index: index.clone(), method: position("simulation") }];
        says(&failed, &format!("simulation: {line}\n"));

        let mut contradictory = summary(0, Vec::new());
        let methods = job.plan.methods.iter();
        let verdicts = methods.map(|method| match method.name() {
            "symmetric" => Verdict::Present,
            "simulation" => Verdict::Absent,
            _ => Verdict::Undecided,
        });
        let cell = Contradiction { tile: 0, index: index.clone(), verdicts: verdicts.collect() };
        contradictory.account.contradictions = Contradictions { cells: 1, first: vec![cell] };
        says(&contradictory, "1 cell in which methods with a guarantee contradict");
        says(&contradictory, &format!("present by symmetric; absent by simulation: {line}\n"));

        let (method, direct) = (position("symmetric"), Fate::Failed(Breakdown::StepBudget));
        let disagreement = Disagreement { index, method, stored: Verdict::Present, direct };
        let contradicted = summary(0, vec![disagreement]);
        says(&contradicted, &format!("symmetric says present, the direct engine failed: {line}\n"));
    }

    #[test]
    fn shares_never_round_to_nothing_or_all() {
        let cases = [
            ((0, 9), "0"),
            ((9, 9), "100"),
            ((1, 3), "33.3"),
            ((1, 10_000), "<0.1"),
            ((9_999, 10_000), ">99.9"),
        ];
        for ((part, whole), text) in cases {
            assert_eq!(percent(part, whole), text);
        }
    }
}
