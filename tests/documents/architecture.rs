//! Checks that the files named in `ARCHITECTURE.md` exist, and that its table has every crate with what it knows.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn page() -> String {
    fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap()
}

#[test]
fn the_files_of_the_page_exist() {
    let page = page();
    let names = page.split('`').skip(1).step_by(2);
    for name in names.filter(|name| ["src/", "crates/", "docs/"].iter().any(|top| name.starts_with(top))) {
        assert!(root().join(name).exists(), "ARCHITECTURE.md: there is no {name}");
    }
}

/// The inner crates that a manifest's dependencies name; those of its tests are left out.
fn dependencies(name: &str) -> BTreeSet<String> {
    let path = root().join("crates").join(name).join("Cargo.toml");
    let manifest: toml_edit::DocumentMut = fs::read_to_string(path).unwrap().parse().unwrap();
    let known = manifest["dependencies"].as_table().unwrap().iter();
    known.filter_map(|(name, _)| Some(name.strip_prefix("slipmap-")?.to_owned())).collect()
}

#[test]
fn the_page_tells_what_each_crate_knows() {
    let page = page();
    let mut told = BTreeSet::new();
    for row in page.lines().filter(|row| row.starts_with("| `")) {
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let [name, _, knows] = cells[..] else { continue };
        let name = name.trim_matches('`');
        let knows: BTreeSet<String> = match knows {
            "nothing" => BTreeSet::new(),
            list => list.split(", ").map(str::to_owned).collect(),
        };
        assert_eq!(dependencies(name), knows, "{name}");
        told.insert(name.to_owned());
    }
    let crates = fs::read_dir(root().join("crates")).unwrap().flatten();
    assert_eq!(told, crates.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect());
}
