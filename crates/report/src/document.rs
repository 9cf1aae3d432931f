//! The documents of a report: tables and figures with their captions, in HTML and LaTeX.

use super::figure::Figure;
use super::table::Table;
use super::view::View;
use slipmap_figure::text::{Rich, capital, html as escaped};
use slipmap_format::MapFile;
use slipmap_page::html::page;

/// The title of the map, or else the name of its file without extension.
fn title(map: &MapFile) -> Rich {
    let name = map.path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    Rich::foreign(map.text("title").or(name.as_deref()).unwrap_or("Map"))
}

/// "Proved volume" of the table proved_volume.
fn heading(table: &Table) -> String {
    capital(&table.name.replace('_', " "))
}

/// Identifier of an element for links: "slice-gamma-c".
fn anchor(kind: &str, name: &str) -> String {
    let name: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    format!("{kind}-{name}")
}

/// The report as one self-contained HTML page: a summary on one screen, then contents, figures, tables and
/// the configuration.
pub(super) fn html(view: &View, summary: &[(Rich, Rich)], tables: &[Table], figures: &[Figure]) -> String {
    let title = title(view.map);
    let mut text = "<dl class=\"summary\">\n".to_owned();
    for (name, value) in summary {
        text.push_str(&format!("<dt>{}</dt><dd>{}</dd>\n", name.html(), value.html()));
    }
    text.push_str("</dl>\n<nav><h2>Contents</h2>\n<ul>\n");
    let mut entry = |id: &str, name: &str| text.push_str(&format!("<li><a href=\"#{id}\">{name}</a></li>\n"));
    for figure in figures {
        let words = format!("Figure: {}", figure.name.replace('-', " "));
        entry(&anchor("figure", &figure.name), &escaped(&words));
    }
    for table in tables {
        entry(&anchor("table", table.name), &heading(table));
    }
    if view.map.text("config").is_some() {
        entry("configuration", "Configuration");
    }
    text.push_str("</ul></nav>\n<h2>Figures</h2>\n");
    for figure in figures {
        text.push_str(&format!(
            "<figure id=\"{}\">\n<div tabindex=\"0\">\n{}</div>\n<figcaption>{}</figcaption>\n</figure>\n",
            anchor("figure", &figure.name),
            figure.scene.svg(&figure.name, &figure.caption),
            figure.caption.html()
        ));
    }
    text.push_str("<h2>Tables</h2>\n");
    for table in tables {
        text.push_str(&format!(
            "<section id=\"{}\"><h3>{}</h3>\n<div class=\"table\" tabindex=\"0\">\n{}</div></section>\n",
            anchor("table", table.name),
            heading(table),
            table.html()
        ));
    }
    if let Some(config) = view.map.text("config") {
        text.push_str(&format!(
            "<h2 id=\"configuration\">Configuration</h2>\n<pre tabindex=\"0\">{}</pre>\n",
            escaped(config)
        ));
    }
    page(&title, &text)
}

/// A LaTeX document with the summary that includes every table and figure, as an example of their use.
pub(super) fn latex(map: &MapFile, summary: &[(Rich, Rich)], tables: &[Table], figures: &[Figure]) -> String {
    let mut text = format!(
        "\\ifdefined\\pdfminorversion\\pdfminorversion=7\\fi\n\
         \\documentclass{{article}}\n\\usepackage[T1]{{fontenc}}\n\\usepackage[utf8]{{inputenc}}\n\\usepackage{{textcomp}}\n\
         \\usepackage[margin=18mm]{{geometry}}\n\\usepackage{{booktabs}}\n\\usepackage{{siunitx}}\n\\usepackage{{graphicx}}\n\
         \\sisetup{{group-minimum-digits=5}}\n\\title{{{}}}\n\\date{{}}\n\\begin{{document}}\n\\maketitle\n",
        title(map).latex()
    );
    text.push_str("\\section*{Summary}\n\\begin{itemize}\n");
    for (name, value) in summary {
        text.push_str(&format!("\\item {}: {}\n", name.latex(), value.latex()));
    }
    text.push_str("\\end{itemize}\n");
    for table in tables {
        text.push_str(&format!("\\input{{tables/{}}}\n", table.name));
    }
    text.push_str("\\clearpage\n");
    for figure in figures {
        text.push_str(&format!(
            "\\begin{{figure}}\n\\centering\n\\includegraphics{{figures/{0}.pdf}}\n\\caption{{{1}}}\n\
             \\label{{fig:slipmap-{0}}}\n\\end{{figure}}\n\\clearpage\n",
            figure.name,
            figure.caption.latex()
        ));
    }
    text.push_str("\\end{document}\n");
    text
}
