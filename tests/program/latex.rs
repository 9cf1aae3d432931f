//! From a configuration to a paper: run, report, and a LaTeX document that inputs the tables and figures,
//! compiled by pdflatex if that is installed.

use std::process::{Command, Stdio};

use crate::command::{Says, Scratch};

/// The configuration of the paper, on fewer nodes.
const SMALLER: [&str; 5] = [
    "--set=grid.alpha=[0.0, 0.45, 0.9]",
    "--set=grid.beta=[0.0, 0.1]",
    "--set=grid.gamma.points=5",
    "--set=grid.V.points=3",
    "--set=output.path=\"a map_of 50% & more.h5\"",
];

#[test]
fn a_paper_that_inputs_the_report_compiles() {
    // Set where a missing pdflatex is an error.
    let demanded = std::env::var_os("SLIPMAP_NEEDS_PDFLATEX").is_some();
    let there = Command::new("pdflatex").arg("--version").stdout(Stdio::null()).status().is_ok();
    if !there {
        assert!(!demanded, "there is no pdflatex");
        eprintln!("skipped: there is no pdflatex");
        return;
    }
    let scratch = Scratch::new();
    let config = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/paper.toml");
    scratch.run(&[["run", config].as_slice(), &SMALLER].concat()).ends_with(0);
    scratch.run(&["report", "a map_of 50% & more.h5", "--out", "report"]).ends_with(0);

    // A document with every table and every figure.
    let names = |folder: &str, ending: &str| -> Vec<String> {
        let entries = std::fs::read_dir(scratch.path().join("report").join(folder)).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> =
            names.filter_map(|name| Some(name.strip_suffix(ending)?.into())).collect();
        names.sort();
        names
    };
    let mut paper = String::from(
        "\\documentclass[twocolumn]{article}\n\\usepackage{booktabs}\n\\usepackage{siunitx}\n\\usepackage{graphicx}\n\
         \\usepackage[T1]{fontenc}\n\\usepackage{textcomp}\n\\begin{document}\n",
    );
    let (tables, figures) = (names("tables", ".tex"), names("figures", ".pdf"));
    assert!(tables.len() >= 9 && figures.len() >= 10, "{tables:?} {figures:?}");
    for name in &tables {
        paper.push_str(&format!(
            "\\input{{report/tables/{name}}}See Table~\\ref{{tab:slipmap-{name}}}.\\clearpage\n"
        ));
    }
    // On pages of one column, which is narrower than the figures.
    paper.push_str("\\onecolumn\\typeout{the figures}\n");
    for name in &figures {
        paper.push_str(&format!("\\noindent\\includegraphics{{report/figures/{name}.pdf}}\\clearpage\n"));
    }
    paper.push_str("\\end{document}\n");
    scratch.file("paper.tex", paper);

    for (folder, document, pages) in
        [(".", "paper", tables.len() + figures.len()), ("report", "report", figures.len())]
    {
        let mut log = String::new();
        // Twice, for the references; the first time without a file to look at.
        for first in [&["-draftmode"][..], &[]] {
            let run = Command::new("pdflatex")
                .args(first)
                .args(["-interaction=nonstopmode", "-halt-on-error", document])
                .current_dir(scratch.path().join(folder))
                .stdin(Stdio::null())
                .output()
                .unwrap();
            log = String::from_utf8_lossy(&run.stdout).into_owned();
            assert!(run.status.success(), "{log}");
        }
        assert!(!log.contains("undefined"), "references: {log}");
        // In the columns of a two-column article as in one.
        let of_tables = log.split("the figures").next().unwrap();
        assert!(!of_tables.contains("Overfull \\hbox"), "beyond the line: {log}");
        if document == "report" {
            let text = scratch.read("report/report.tex");
            text.says(&["\\section*{Summary}", "\\item decided by proof: "]);
        }
        let shown = log.lines().rev().collect::<Vec<_>>().join(" ");
        let said = shown.split("Output written on").nth(1).unwrap_or_default();
        let count: usize = said
            .split_once('(')
            .and_then(|(_, rest)| rest.split_once(' '))
            .and_then(|(count, _)| count.parse().ok())
            .unwrap_or_else(|| panic!("no number of pages in {said}"));
        assert!(count >= pages, "{document}: {count} pages of at least {pages}");
    }
}
