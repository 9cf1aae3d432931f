//! Checks that imports between the crate's modules go one way, in the order of `src/architecture.md`, and
//! without cycles inside a module, and that the files named on that page exist.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Known imports against the order: module, and what it imports. To be emptied.
const KNOWN_AGAINST_THE_ORDER: [(&str, &str); 0] = [];

/// Known cycles of imports inside a module: module, importing part, imported part. To be emptied.
const KNOWN_CIRCLES: [(&str, &str, &str); 0] = [];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn page() -> String {
    fs::read_to_string(root().join("src/architecture.md")).unwrap()
}

/// The modules in the order in which they may import: each line of the page's list.
fn order() -> Vec<Vec<String>> {
    let page = page();
    let list = page.split("```text\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    list.lines().map(|line| line.split(" | ").map(str::to_owned).collect()).collect()
}

/// Every source below `folder`, with its code: comments and unit tests are left out.
fn sources(folder: &Path) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path).unwrap();
            let text = text.split("\n#[cfg(test)]\nmod ").next().unwrap();
            let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
            found.push((path, code.collect::<Vec<_>>().join("\n")));
        }
    }
    found
}

/// The path of a source as the names of its modules: `src/map/engine.rs` is map, engine.
fn module(path: &Path) -> Vec<String> {
    let inner = path.strip_prefix(root().join("src")).unwrap().with_extension("");
    let mut names: Vec<String> = inner.iter().map(|name| name.to_string_lossy().into_owned()).collect();
    if names.last().is_some_and(|name| name == "mod") {
        names.pop();
    }
    names
}

fn is_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// The names after `prefix` in the code: one, or all in the braces that follow.
fn names_after(code: &str, prefix: &str) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for (at, _) in code.match_indices(prefix) {
        if code[..at].ends_with(|c: char| is_name(c) || c == ':') {
            continue;
        }
        let rest = &code[at + prefix.len()..];
        let Some(list) = rest.strip_prefix('{') else {
            names.insert(rest.chars().take_while(|c| is_name(*c)).collect());
            continue;
        };
        let mut depth = 0;
        let mut start = true;
        for (at, c) in list.char_indices() {
            match c {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                ',' if depth == 0 => start = true,
                c if is_name(c) && start => {
                    names.insert(list[at..].chars().take_while(|c| is_name(*c)).collect());
                    start = false;
                }
                _ => {}
            }
        }
    }
    names.remove("");
    names
}

#[test]
fn imports_go_down_the_list() {
    let order = order();
    let place = |name: &str| order.iter().position(|line| line.iter().any(|known| known == name));
    let mut against = BTreeSet::new();
    for (path, code) in sources(&root().join("src")) {
        let names = module(&path);
        let importer = names[0].as_str();
        if ["lib", "main"].contains(&importer) {
            continue;
        }
        let here = place(importer).unwrap_or_else(|| panic!("src/architecture.md does not list {importer}"));
        for imported in names_after(&code, "crate::") {
            if imported != importer && place(&imported).is_some_and(|there| there >= here) {
                against.insert((importer.to_owned(), imported, path.clone()));
            }
        }
    }
    for (importer, imported, path) in &against {
        let known = KNOWN_AGAINST_THE_ORDER.contains(&(importer.as_str(), imported.as_str()));
        assert!(known, "{}: `{importer}` must not import `{imported}`", path.display());
    }
}

/// The imports between the parts of a module: its submodules, by their own names or by names that the module
/// re-exports.
fn edges_inside(top: &str, files: &[(PathBuf, String)]) -> BTreeSet<(String, String)> {
    let parts: BTreeSet<String> = files.iter().filter_map(|(path, _)| module(path).get(1).cloned()).collect();
    let head = files.iter().find(|(path, _)| module(path).len() == 1).map_or("", |(_, code)| code.as_str());
    let mut home: BTreeMap<String, String> = BTreeMap::new();
    for part in &parts {
        for name in names_after(head, &format!("use {part}::")) {
            home.insert(name, part.clone());
        }
        home.insert(part.clone(), part.clone());
    }
    let mut edges = BTreeSet::new();
    for (path, code) in files {
        let names = module(path);
        let Some(from) = names.get(1) else { continue };
        let mut used = names_after(code, &format!("crate::{top}::"));
        // In the part itself `super` is the module; in its submodules the module is one level higher.
        used.extend(names_after(code, &"super::".repeat(names.len() - 1)));
        edges.extend(
            used.iter()
                .filter_map(|name| home.get(name))
                .filter(|to| *to != from)
                .map(|to| (from.clone(), to.clone())),
        );
    }
    edges
}

/// The rest of a graph after removing all edges that belong to no cycle.
fn circles(mut edges: BTreeSet<(String, String)>) -> BTreeSet<(String, String)> {
    loop {
        let starts: BTreeSet<String> = edges.iter().map(|(from, _)| from.clone()).collect();
        let ends: BTreeSet<String> = edges.iter().map(|(_, to)| to.clone()).collect();
        let before = edges.len();
        edges.retain(|(from, to)| starts.contains(to) && ends.contains(from));
        if edges.len() == before {
            return edges;
        }
    }
}

#[test]
fn no_circles_inside_a_module() {
    let mut rooms: BTreeMap<String, Vec<(PathBuf, String)>> = BTreeMap::new();
    for (path, code) in sources(&root().join("src")) {
        rooms.entry(module(&path)[0].clone()).or_default().push((path, code));
    }
    for (top, files) in &rooms {
        let mut edges = edges_inside(top, files);
        for (module, from, to) in KNOWN_CIRCLES {
            if module == top {
                edges.remove(&(from.into(), to.into()));
            }
        }
        let left = circles(edges);
        assert!(left.is_empty(), "`{top}`: a circle of imports among {left:?}");
    }
}

#[test]
fn the_files_of_the_page_exist() {
    for name in
        page().split('`').skip(1).step_by(2).filter(|text| {
            text.starts_with("src/") || text.starts_with("crates/") || text.starts_with("tests/")
        })
    {
        assert!(root().join(name).exists(), "src/architecture.md: there is no {name}");
    }
}

#[test]
fn names_are_found_in_every_form_of_import() {
    let code = "use crate::map::{Grid, plan::{Plan, Field}, engine};\nlet x = crate::store::open();\nuse mycrate::cli;";
    assert_eq!(names_after(code, "crate::"), ["map", "store"].map(String::from).into());
    assert_eq!(names_after(code, "crate::map::"), ["Grid", "plan", "engine"].map(String::from).into());
    let edge = |from: &str, to: &str| (from.to_owned(), to.to_owned());
    let graph = [edge("a", "b"), edge("b", "c"), edge("c", "b"), edge("c", "d")].into();
    assert_eq!(circles(graph), [edge("b", "c"), edge("c", "b")].into());
}
