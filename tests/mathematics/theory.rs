//! The conformance table of `src/theory.md` names functions and tests that exist, and leaves out no test of the
//! files that exist for it.

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

/// Whether `source` has an item called `name`, or a variant at the start of a line.
fn defines(source: &str, name: &str) -> bool {
    let code = source.lines().map(str::trim_start).filter(|line| !line.starts_with("//"));
    code.map(|line| line.strip_prefix("pub ").unwrap_or(line)).any(|line| {
        let item = ["fn ", "struct ", "enum ", "static ", "const ", "trait "]
            .iter()
            .filter_map(|word| line.strip_prefix(word)?.strip_prefix(name))
            .any(|rest| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_'));
        let variant = line
            .strip_prefix(name)
            .is_some_and(|rest| [",", "(", " {", " = "].iter().any(|end| rest.starts_with(end)));
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

#[test]
fn every_function_of_the_table_exists() {
    for Row { statement, functions, .. } in rows() {
        assert!(!functions.is_empty(), "no function: {statement}");
        for function in functions {
            let path = function.strip_prefix("crate::").unwrap_or_else(|| panic!("{function} is no path"));
            let mut module = root().join("src");
            let mut items = path.split("::").peekable();
            while let Some(name) = items.peek() {
                let below = module.join(name);
                if !below.is_dir() && !below.with_extension("rs").is_file() {
                    break;
                }
                module = below;
                items.next();
            }
            let source = sources(&module);
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

#[test]
fn the_reader_of_the_table_sees_what_is_not_there() {
    let source = "pub struct Known;\n// fn hidden() {}\n    Variant(u8),\n\n#[test]\n#[ignore]\nfn tried() {}\nfn helper() {}\n";
    assert!(defines(source, "Known") && defines(source, "Variant"));
    assert!(!defines(source, "hidden") && !defines(source, "Know") && !defines(source, "variant"));
    assert_eq!(tests_in(source), ["tried"]);
    assert!(rows().len() > 25);
}
