//! Checks the package's metadata: versions that agree, a minimum Rust version that its dependencies allow,
//! licences.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

fn read(name: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(name)).unwrap()
}

/// The packages that this crate is built from, itself included, as reported by cargo.
fn packages() -> Vec<Value> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--locked", "--offline", "--format-version", "1"])
        .args(["--filter-platform", "x86_64-unknown-linux-gnu"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    metadata["packages"].as_array().unwrap().clone()
}

fn version(text: &str) -> Vec<u64> {
    text.split('.').map(|part| part.parse().unwrap()).collect()
}

#[test]
fn the_minimum_rust_version_is_one_and_enough() {
    let packages = packages();
    let ours = packages.iter().find(|package| package["name"] == "slipmap").unwrap();
    let claimed = ours["rust_version"].as_str().unwrap();
    for package in &packages {
        if let Some(needed) = package["rust_version"].as_str() {
            assert!(version(needed) <= version(claimed), "{} needs Rust {needed}", package["name"]);
        }
    }
    for name in ["scripts/setup.sh", "docs/install.md"] {
        assert!(read(name).contains(&format!("Rust {claimed}")), "{name} does not name Rust {claimed}");
    }
}

/// The licences that `deny.toml` allows: one list for `cargo deny`, which not everyone has, and for this
/// test.
fn allowed_licences() -> Vec<String> {
    let settings: toml_edit::DocumentMut = read("deny.toml").parse().unwrap();
    let allowed = settings["licenses"]["allow"].as_array().unwrap();
    allowed.iter().map(|name| name.as_str().unwrap().to_owned()).collect()
}

#[test]
fn licences_of_dependencies_allow_releases() {
    let licences = allowed_licences();
    let is_allowed = |name: &str| licences.iter().any(|licence| licence == name);
    for package in packages() {
        let licence = package["license"].as_str().unwrap_or_default().replace('/', " OR ");
        // One of several alternatives suffices; of licences joined by AND all are needed.
        let allowed = |names: &str| {
            names.split(" AND ").all(|name| {
                let name = name.trim_matches(['(', ')', ' ']);
                is_allowed(name) || name.split(" OR ").any(|one| is_allowed(one.trim()))
            })
        };
        assert!(allowed(&licence), "{}: {licence}", package["name"]);
    }
}

#[test]
fn versions_agree() {
    let own = env!("CARGO_PKG_VERSION");
    assert!(read("CITATION.cff").contains(&format!("version: {own}\n")));
    assert!(read("CHANGELOG.md").contains(&format!("## [{own}]")));
    assert!(read("docs/install.md").contains(&format!("slipmap-{own}-")));
    let (major_minor, _) = own.rsplit_once('.').unwrap();
    assert!(read("docs/install.md").contains(&format!("slipmap = {{ version = \"{major_minor}\"")));
}

/// The texts of all Rust files below a folder, by their paths from the root.
fn rust_files(folder: &str) -> Vec<(String, String)> {
    let entries = fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)).unwrap().flatten();
    let names = entries.map(|entry| (format!("{folder}/{}", entry.file_name().to_string_lossy()), entry));
    names
        .flat_map(|(name, entry)| match entry.file_type().unwrap().is_dir() {
            true => rust_files(&name),
            false if name.ends_with(".rs") => vec![(name.clone(), read(&name))],
            false => Vec::new(),
        })
        .collect()
}

/// `scripts/test --quick` skips tests by the names in its list: a name that no test has would skip nothing.
#[test]
fn slow_tests_exist() {
    let files: Vec<(String, String)> = ["src", "crates", "tests"].into_iter().flat_map(rust_files).collect();
    for name in read("scripts/slow_tests.txt").lines().filter(|line| !line.starts_with('#')) {
        let (modules, function) = name.rsplit_once("::").unwrap();
        let modules = modules.trim_end_matches("::tests").replace("::", "/");
        let declared = format!("fn {function}(");
        let exists = files.iter().any(|(path, text)| path.contains(&modules) && text.contains(&declared));
        assert!(exists, "no test `{name}`");
    }
}

/// Maps keep the commit of the program that made them, and tiles of other programs are refused: it must tell of every
/// change of what the program is built from, in whichever crate.
#[test]
fn the_commit_tells_of_changes_in_every_crate() {
    let manifest: toml_edit::DocumentMut = read("Cargo.toml").parse().unwrap();
    let of_crates = manifest["workspace"]["members"][0].as_str().unwrap();
    let git = |arguments: &[&str]| {
        let run =
            Command::new("git").args(arguments).current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap();
        String::from_utf8(run.stdout).unwrap().trim().to_owned()
    };
    let sources = ["src", of_crates, "Cargo.toml", "Cargo.lock", "build.rs"];
    let changed = git(&[&["--no-optional-locks", "status", "--porcelain", "--"], &sources[..]].concat());
    let commit = git(&["rev-parse", "HEAD"]);
    if commit.is_empty() {
        return;
    }
    let expected = if changed.is_empty() { commit } else { format!("{commit}, modified") };
    assert_eq!(slipmap::GIT, expected);
}

/// What draws, and what the explorer answers with, runs where there is no HDF5: in the browser, and in Python beside other
/// builds of it.
#[test]
fn nothing_that_draws_links_hdf5() {
    for name in ["slipmap-figure", "slipmap-page", "slipmap-explore"] {
        let tree = Command::new(env!("CARGO"))
            .args([
                "tree",
                "--locked",
                "--offline",
                "--edges",
                "normal,build",
                "--prefix",
                "none",
                "-p",
                name,
            ])
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .unwrap();
        let tree = String::from_utf8(tree.stdout).unwrap();
        assert!(tree.starts_with(name) && !tree.contains("hdf5"), "{tree}");
    }
}
