//! The documents of a report: tables and figures with their captions, in Markdown, HTML and LaTeX.

use super::figure::{Figure, Width};
use super::table::Table;
use super::text::{Rich, latex as latex_words};
use crate::store::MapFile;

/// The title, for people.
fn title(map: &MapFile) -> Rich {
    let name = map.path().file_stem().map(|stem| stem.to_string_lossy().into_owned());
    Rich::foreign(map.text("title").or(name.as_deref()).unwrap_or("Map"))
}

/// The headings of the tables.
fn heading(table: &Table) -> &'static str {
    match table.name {
        "volume" => "Certified volume",
        "agreement" => "Agreement with the simulation",
        "boundary" => "Error of the boundary",
        "order" => "Order of the error",
        "cost" => "Cost",
        "failures" => "Failures and audit",
        "methods" => "Methods",
        "machine" => "The machine in SI units",
        "axes" => "Grid",
        _ => "Provenance",
    }
}

/// The report as Markdown.
pub(super) fn markdown(map: &MapFile, tables: &[Table], figures: &[Figure]) -> String {
    let mut text = format!("# {}\n", title(map).markdown());
    for table in tables {
        text.push_str(&format!("\n## {}\n\n{}", heading(table), table.markdown()));
        text.push_str(&format!("\n[CSV](tables/{0}.csv), [LaTeX](tables/{0}.tex)\n", table.name));
    }
    text.push_str("\n## Figures\n");
    for figure in figures {
        let wide = format!("figures/{}-{}", figure.name, Width::TwoColumns.name());
        let narrow = format!("figures/{}-{}", figure.name, Width::OneColumn.name());
        text.push_str(&format!(
            "\n![{}]({wide}.png)\n\n{} Files: two columns wide as [SVG]({wide}.svg), [PDF]({wide}.pdf), one column wide as \
             [SVG]({narrow}.svg), [PDF]({narrow}.pdf), [PNG]({narrow}.png).\n",
            figure.name,
            figure.caption.markdown()
        ));
    }
    if let Some(config) = map.text("config") {
        let config: String = config.chars().filter(|c| !c.is_control() || matches!(c, '\n' | '\t')).collect();
        // A fence longer than any run of backticks in what is shown.
        let longest = config.split(|c| c != '`').map(str::len).max().unwrap_or(0);
        let fence = "`".repeat(longest.max(2) + 1);
        text.push_str(&format!("\n## Configuration\n\n{fence}toml\n{}\n{fence}\n", config.trim_end()));
    }
    text
}

const STYLE: &str = "\
body{font:16px/1.5 'Noto Sans',Helvetica,Arial,sans-serif;max-width:64rem;margin:2rem auto;padding:0 1rem;color:#111;background:#fff}
table{border-collapse:collapse;margin:1rem 0;font-size:.85rem;font-variant-numeric:tabular-nums}
caption{text-align:left;padding-bottom:.4rem}
thead{border-top:2px solid;border-bottom:1px solid}tbody{border-bottom:2px solid}
th,td{padding:.15rem .6rem;text-align:left;vertical-align:top;overflow-wrap:anywhere}
.number{text-align:right;white-space:nowrap}.note,figcaption{font-size:.85rem;color:#333}
figure{margin:1.5rem 0}svg{max-width:100%;height:auto}pre{overflow-x:auto;background:#f5f5f5;padding:1rem;font-size:.8rem}
.table{overflow-x:auto}";

/// The report as one HTML page that needs nothing else.
pub(super) fn html(map: &MapFile, tables: &[Table], figures: &[Figure]) -> String {
    let title = title(map);
    let mut text = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\">\n\
         <title>{0}</title>\n<style>\n{STYLE}\n</style>\n</head>\n<body>\n<h1>{0}</h1>\n",
        title.html()
    );
    for table in tables {
        text.push_str(&format!(
            "<h2>{}</h2>\n<div class=\"table\">\n{}</div>\n",
            heading(table),
            table.html()
        ));
    }
    text.push_str("<h2>Figures</h2>\n");
    for figure in figures {
        if let Some((width, scene)) = figure.scenes.last() {
            let name = format!("{}-{}", figure.name, width.name());
            text.push_str(&format!(
                "<figure>\n{}<figcaption>{}</figcaption>\n</figure>\n",
                scene.svg(&name, &figure.caption),
                figure.caption.html()
            ));
        }
    }
    if let Some(config) = map.text("config") {
        text.push_str(&format!("<h2>Configuration</h2>\n<pre>{}</pre>\n", super::text::html(config)));
    }
    text.push_str("</body>\n</html>\n");
    text
}

/// A LaTeX document that shows every table and figure, as an example of their use.
pub(super) fn latex(map: &MapFile, tables: &[Table], figures: &[Figure]) -> String {
    let mut text = format!(
        "\\documentclass{{article}}\n\\usepackage[T1]{{fontenc}}\n\\usepackage[utf8]{{inputenc}}\n\\usepackage{{textcomp}}\n\
         \\usepackage[margin=18mm]{{geometry}}\n\\usepackage{{booktabs}}\n\\usepackage{{siunitx}}\n\\usepackage{{graphicx}}\n\
         \\sisetup{{group-minimum-digits=5}}\n\\title{{{}}}\n\\date{{}}\n\\begin{{document}}\n\\maketitle\n",
        title(map).latex()
    );
    for table in tables {
        text.push_str(&format!("\\input{{tables/{}}}\n", latex_words(table.name)));
    }
    text.push_str("\\clearpage\n");
    for figure in figures {
        text.push_str(&format!(
            "\\begin{{figure}}\n\\centering\n\\includegraphics{{figures/{0}-{1}}}\n\\caption{{{2}}}\n\
             \\label{{fig:slipmap-{0}}}\n\\end{{figure}}\n\\clearpage\n",
            figure.name,
            Width::TwoColumns.name(),
            figure.caption.latex()
        ));
    }
    text.push_str("\\end{document}\n");
    text
}
