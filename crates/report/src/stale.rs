//! Removes the files of an earlier report that a new one in the same folder does not replace: they belong to
//! another map. Only files that the earlier report itself lists are removed.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// File extensions of a report.
const ENDINGS: [&str; 5] = ["svg", "png", "pdf", "csv", "tex"];

/// The figures and tables that the report in a folder lists, without their extensions; empty where there is
/// no report.
pub(super) fn listed(folder: &Path) -> BTreeSet<String> {
    let text = fs::read_to_string(folder.join("report.tex")).unwrap_or_default();
    let mut names = BTreeSet::new();
    for kind in ["figures/", "tables/"] {
        for (at, _) in text.match_indices(kind) {
            let rest = &text[at + kind.len()..];
            let end =
                rest.find(|c: char| !(c.is_ascii_alphanumeric() || "-_.".contains(c))).unwrap_or(rest.len());
            let name = rest[..end].trim_end_matches(".pdf");
            if !name.is_empty() {
                names.insert(format!("{kind}{name}"));
            }
        }
    }
    names
}

/// Removes the files that the report in a folder listed `before` and does not list now.
pub(super) fn remove(folder: &Path, before: &BTreeSet<String>) {
    for name in before.difference(&listed(folder)) {
        for ending in ENDINGS {
            // A file that cannot be removed does not make the new report wrong.
            let _ = fs::remove_file(folder.join(format!("{name}.{ending}")));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_that_are_no_longer_listed_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        };
        let gone = ["figures/slice-a-c.png", "figures/slice-a-c.svg", "tables/b_d.csv", "tables/b_d.tex"];
        let kept = ["figures/mine.png", "tables/t.csv"];
        for name in gone.iter().chain(&kept) {
            write(name, "");
        }
        let rest = "\\input{tables/t}";
        let listing = "\\includegraphics{figures/slice-a-c.pdf} \\input{tables/b_d} ../figures/../mine";
        write("report.tex", &format!("{rest} {listing}"));
        let before = listed(folder.path());
        write("report.tex", rest);
        remove(folder.path(), &before);
        let left = |name: &str| folder.path().join(name).exists();
        assert!(!gone.into_iter().any(left) && kept.into_iter().all(left));
    }
}
