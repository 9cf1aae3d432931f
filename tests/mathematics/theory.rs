//! Checks that the conformance table of `src/theory.md` names functions and tests that exist, and every test
//! of the files that belong to it; and that code, tests, scripts and documents cite the theory by the titles
//! of its sections.

use std::fs;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// A row of the table: statement, functions, tests.
struct Row {
    statement: String,
    functions: Vec<String>,
    tests: Vec<String>,
}

/// The texts between backticks.
fn quoted(cell: &str) -> Vec<String> {
    cell.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

fn rows() -> Vec<Row> {
    let theory = read(&root().join("src/theory.md"));
    let head = "| statement | function | test |";
    let lines =
        theory.lines().skip_while(|line| *line != head).skip(2).take_while(|line| line.starts_with('|'));
    lines
        .map(|line| {
            let cells: Vec<&str> = line.trim_matches('|').split('|').collect();
            let [statement, functions, tests] = cells[..] else { panic!("not three cells: {line}") };
            Row { statement: statement.trim().into(), functions: quoted(functions), tests: quoted(tests) }
        })
        .collect()
}

/// Names of the tests in a source: functions with `#[test]` above them.
fn tests_in(source: &str) -> Vec<String> {
    let mut names = Vec::new();
    let mut is_test = false;
    for line in source.lines().map(str::trim) {
        if line == "#[test]" {
            is_test = true;
        } else if let Some(rest) = line.strip_prefix("fn ") {
            if is_test {
                names.push(rest.split('(').next().unwrap_or(rest).to_owned());
            }
            is_test = false;
        } else if !line.starts_with("#[") && !line.starts_with("///") {
            is_test = false;
        }
    }
    names
}

/// Returns whether `source` has an item called `name`, or a variant at the start of a line.
fn defines(source: &str, name: &str) -> bool {
    let code = source.lines().map(str::trim_start).filter(|line| !line.starts_with("//"));
    code.map(|line| {
        ["pub ", "pub(crate) "].iter().find_map(|visible| line.strip_prefix(visible)).unwrap_or(line)
    })
    .any(|line| {
        let item = ["fn ", "struct ", "enum ", "static ", "const ", "trait "]
            .iter()
            .filter_map(|word| line.strip_prefix(word)?.strip_prefix(name))
            .any(|rest| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_'));
        let variant = line
            .strip_prefix(name)
            .is_some_and(|rest| [",", "(", " {", " = ", " => "].iter().any(|end| rest.starts_with(end)));
        item || variant
    })
}

/// The sources of a module, its submodules' included.
fn sources(path: &Path) -> String {
    let mut text = String::new();
    let file = path.with_extension("rs");
    if file.is_file() {
        text.push_str(&read(&file));
    }
    if path.is_dir() {
        let entries = fs::read_dir(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        paths.sort();
        for path in paths {
            if path.is_dir() {
                text.push_str(&sources(&path));
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                text.push_str(&read(&path));
            }
        }
    }
    text
}

/// Titles of the theory's sections.
fn titles(theory: &str) -> Vec<&str> {
    let mut code = false;
    let prose = theory.lines().filter(move |line| {
        code ^= line.starts_with("```");
        !code
    });
    prose.filter_map(|line| line.strip_prefix("# ").or_else(|| line.strip_prefix("## "))).collect()
}

/// The anchor of a title, as rustdoc and code hosting sites make it.
fn anchor(title: &str) -> String {
    let kept = title.to_lowercase().replace(' ', "-");
    kept.chars().filter(|c| c.is_alphanumeric() || *c == '-' || *c == '_').collect()
}

/// Every text in which the theory may be cited, with its path.
fn citing_texts() -> Vec<(PathBuf, String)> {
    let mut folders: Vec<PathBuf> =
        ["src", "crates", "tests", "scripts", "benches", "fuzz/fuzz_targets", "docs", "python"]
            .map(|folder| root().join(folder))
            .into();
    let mut texts = vec![(root().join("README.md"), read(&root().join("README.md")))];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                let name = entry.file_name();
                if name != "target" && name != "node_modules" && !name.to_string_lossy().starts_with('.') {
                    folders.push(path);
                }
            } else if let Ok(text) = fs::read_to_string(&path) {
                // A comment is one text, independent of its line breaks.
                let lines =
                    text.lines().map(|line| line.trim_start().trim_start_matches(['/', '!', '#']).trim());
                let joined = lines.collect::<Vec<_>>().join(" ");
                texts.push((path, joined));
            }
        }
    }
    texts
}

/// The wrong citations of the theory in `text`.
fn wrong_citations(text: &str, titles: &[&str]) -> Vec<String> {
    let mut wrong = Vec::new();
    for (at, mark) in text.match_indices("theory, \"") {
        let title = text[at + mark.len()..].split('"').next().unwrap_or_default();
        if !titles.contains(&title) {
            wrong.push(format!("the theory has no section \"{title}\""));
        }
    }
    for mark in ["theory.md#", "theory#", "theory/index.html#"] {
        for (at, _) in text.match_indices(mark) {
            let rest = &text[at + mark.len()..];
            let link: String =
                rest.chars().take_while(|c| c.is_alphanumeric() || *c == '-' || *c == '_').collect();
            if !titles.iter().any(|title| anchor(title) == link) {
                wrong.push(format!("the theory has no section with the anchor {link}"));
            }
        }
    }
    // Numbers of sections mean the paper's or a standard's, and say so. Seventy characters reach back to the
    // start of a sentence.
    for word in ["section ", "sections ", "Section ", "Sections "] {
        for (at, _) in text.match_indices(word) {
            let before: String =
                text[..at].chars().rev().take(70).collect::<Vec<_>>().into_iter().rev().collect();
            let rest = &text[at + word.len()..];
            if rest.starts_with(|c: char| c.is_ascii_digit())
                && !before.to_lowercase().contains("paper")
                && !before.contains("RFC")
            {
                let number: String = rest.chars().take(20).collect();
                wrong.push(format!(
                    "{word}{number}..: cite the theory by title, or say that the paper is meant"
                ));
            }
        }
    }
    wrong
}

#[test]
fn the_theory_is_cited_by_the_titles_of_its_sections() {
    let theory = read(&root().join("src/theory.md"));
    let titles = titles(&theory);
    let mut wrong = Vec::new();
    for (path, text) in citing_texts() {
        // These cite the paper's sections, and examples of wrong citations.
        let of_the_paper = ["src/theory.md", "docs/corrections.md", "tests/mathematics/theory.rs"];
        if of_the_paper.iter().any(|file| path.ends_with(file)) {
            continue;
        }
        wrong.extend(
            wrong_citations(&text, &titles).into_iter().map(|what| format!("{}: {what}", path.display())),
        );
    }
    for (at, mark) in theory.match_indices("](#") {
        let link = theory[at + mark.len()..].split(')').next().unwrap_or_default();
        if !titles.iter().any(|title| anchor(title) == link) {
            wrong.push(format!("src/theory.md links to #{link}, which is no section"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_row_of_the_table_begins_with_the_title_of_its_section() {
    let theory = read(&root().join("src/theory.md"));
    let titles = titles(&theory);
    for Row { statement, .. } in rows() {
        let head = statement.split(':').next().unwrap_or_default();
        let known = |head: &str| {
            titles.iter().any(|title| {
                head.strip_prefix(title).is_some_and(|rest| rest.is_empty() || rest.starts_with(", "))
            })
        };
        assert!(head.split("; ").all(known), "\"{statement}\" must begin with titles of sections");
    }
}

/// Where a module of the library's face is: a crate, or a module of one.
fn home(name: &str) -> PathBuf {
    let exists = |path: &PathBuf| path.is_dir() || path.with_extension("rs").is_file();
    let inside = |room: &str| root().join("crates").join(room).join("src").join(name);
    std::iter::once(root().join("crates").join(name).join("src"))
        .chain(["model", "machine", "map"].map(inside))
        .find(exists)
        .unwrap_or_else(|| panic!("there is no module {name}"))
}

#[test]
fn every_function_of_the_table_exists() {
    for Row { statement, functions, .. } in rows() {
        assert!(!functions.is_empty(), "no function: {statement}");
        for function in functions {
            let path = function.strip_prefix("crate::").unwrap_or_else(|| panic!("{function} is no path"));
            let mut items = path.split("::").peekable();
            let first = items.next().unwrap_or_default();
            let mut module = home(first);
            while let Some(name) = items.peek() {
                let below = module.join(name);
                if !below.is_dir() && !below.with_extension("rs").is_file() {
                    break;
                }
                module = below;
                items.next();
            }
            // What an engine answers is defined in `model`.
            let source = sources(&module) + &read(&root().join("crates/model/src/flow.rs"));
            assert!(!source.is_empty(), "{function}: no such module");
            for item in items {
                assert!(defines(&source, item), "{function}: {} defines no {item}", module.display());
            }
        }
    }
}

#[test]
fn every_test_of_the_table_exists() {
    for Row { statement, tests, .. } in rows() {
        assert!(!tests.is_empty(), "no test: {statement}");
        for test in tests {
            let (file, name) = test.split_once("::").unwrap_or_else(|| panic!("{test} is no test"));
            let names = tests_in(&read(&root().join(file)));
            assert!(names.iter().any(|known| known == name), "{file} has no test {name}");
        }
    }
}

#[test]
fn no_test_of_the_theory_is_left_out() {
    let named: Vec<String> = rows().into_iter().flat_map(|row| row.tests).collect();
    for file in [
        "tests/mathematics/identities.rs",
        "tests/mathematics/forms.rs",
        "tests/mathematics/claims.rs",
        "tests/mathematics/agreement.rs",
    ] {
        for name in tests_in(&read(&root().join(file))) {
            let test = format!("{file}::{name}");
            assert!(named.contains(&test), "the table has no row for {test}");
        }
    }
}
