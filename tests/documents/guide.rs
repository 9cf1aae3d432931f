//! Runs every command and every file of the README and of the guide in `docs`: blocks are executed in order,
//! each page in its own folder, and their output is compared with the output shown.
//!
//! - A block `sh` is run by bash; `slipmap` and `scripts/slipmap` are the program of this build.
//! - A block `text` after a block `sh` is its standard output; `...` stands for any text, alone on a line for
//!   any lines.
//! - A block with `file=NAME` after its language is written to that file first.
//! - A block `python` is run by the interpreter that `SLIPMAP_PYTHON` names, which `scripts/test` sets;
//!   without it, such blocks are not run. Those that import slipmap are run by
//!   python/tests/test_readme.py, where the package is.
//!
//! [`NOT_RUN`] lists the commands that are not run. Blocks of Rust are tests of the documentation
//! (`src/lib.rs`).

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

/// Commands that need a network or another compiler run: their beginnings, and where they are
/// tested.
const NOT_RUN: [(&str, &str); 9] = [
    ("scripts/test", "runs this test"),
    ("scripts/dist", "tries its archives itself"),
    ("scripts/wheel", "tries its wheel itself"),
    ("slipmap explore", "runs until Ctrl-C; tests/program/explore.rs"),
    ("scripts/slipmap explore", "runs until Ctrl-C; scripts/checks/explore.py"),
    ("scripts/web", "builds for minutes; scripts/checks/explore_file.py tries such a page"),
    ("cargo ", "builds for minutes; scripts/test and .ci/run use the same commands"),
    ("pip install", "scripts/test"),
    ("tar ", "scripts/dist"),
];

/// A block between fences.
struct Block {
    line: usize,
    language: String,
    file: Option<String>,
    text: String,
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The README and the pages of the guide, relative to the repository.
fn pages() -> Vec<PathBuf> {
    let mut pages: Vec<PathBuf> = fs::read_dir(root().join("docs"))
        .unwrap()
        .map(|entry| Path::new("docs").join(entry.unwrap().file_name()))
        .filter(|path| path.extension().is_some_and(|extension| extension == "md"))
        .collect();
    pages.push("README.md".into());
    pages.sort();
    pages
}

fn blocks(text: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut lines = text.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        let Some(info) = line.strip_prefix("```") else { continue };
        let mut words = info.split_whitespace();
        let language = words.next().unwrap_or_default().to_owned();
        let file = words.find_map(|word| word.strip_prefix("file=")).map(str::to_owned);
        let inner: Vec<&str> =
            lines.by_ref().map(|(_, line)| line).take_while(|line| !line.starts_with("```")).collect();
        blocks.push(Block { line: number + 1, language, file, text: inner.join("\n") });
    }
    blocks
}

/// Returns whether `text` matches `pattern`, where `...` stands for anything.
fn shows(pattern: &str, text: &str) -> bool {
    match pattern.split_once("...") {
        None => pattern == text,
        Some((start, rest)) => text.strip_prefix(start).is_some_and(|tail| {
            (0..=tail.len()).filter(|at| tail.is_char_boundary(*at)).any(|at| shows(rest, &tail[at..]))
        }),
    }
}

/// Returns whether `lines` match `pattern`, where a line `...` stands for any lines.
fn shows_lines(pattern: &[&str], lines: &[&str]) -> bool {
    match pattern {
        [] => lines.is_empty(),
        ["...", rest @ ..] => (0..=lines.len()).any(|at| shows_lines(rest, &lines[at..])),
        [first, rest @ ..] => lines
            .split_first()
            .is_some_and(|(line, tail)| shows(first.trim_end(), line.trim_end()) && shows_lines(rest, tail)),
    }
}

/// A folder like a fresh clone.
fn workplace() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let program = env!("CARGO_BIN_EXE_slipmap");
    for name in ["bin", "scripts"] {
        fs::create_dir(folder.path().join(name)).unwrap();
        std::os::unix::fs::symlink(program, folder.path().join(name).join("slipmap")).unwrap();
    }
    for name in ["configs", "results/validated"] {
        copy(&root().join(name), &folder.path().join(name));
    }
    folder
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy(&path, &target);
        } else {
            fs::copy(&path, &target).unwrap();
        }
    }
}

/// Runs the blocks of a page; returns the problems.
fn follow(page: &Path) -> Vec<String> {
    let text = fs::read_to_string(root().join(page)).unwrap();
    let folder = workplace();
    let python = std::env::var_os("SLIPMAP_PYTHON");
    let path = format!("{}:{}", folder.path().join("bin").display(), std::env::var("PATH").unwrap());
    let mut wrong = Vec::new();
    // Output of the last command; `None` if it was not run.
    let mut printed: Option<String> = None;
    for block in blocks(&text) {
        let place = format!("{}:{}", page.display(), block.line);
        if let Some(name) = &block.file {
            fs::write(folder.path().join(name), format!("{}\n", block.text)).unwrap();
            continue;
        }
        let mut command = match block.language.as_str() {
            "sh" => {
                let runs = |line: &&str| !NOT_RUN.iter().any(|(start, _)| line.starts_with(start));
                let script: Vec<&str> = block.text.lines().filter(runs).collect();
                let mut bash = Command::new("bash");
                bash.args(["-euo", "pipefail", "-c", &script.join("\n")]);
                bash
            }
            "python" => {
                let Some(python) = python.as_ref().filter(|_| !block.text.contains("import slipmap")) else {
                    printed = None;
                    continue;
                };
                let mut interpreter = Command::new(python);
                interpreter.args(["-c", &block.text]).env("MPLBACKEND", "Agg");
                interpreter
            }
            "text" => {
                if let Some(printed) = printed.take() {
                    let pattern: Vec<&str> = block.text.lines().collect();
                    let lines: Vec<&str> = printed.lines().collect();
                    if !shows_lines(&pattern, &lines) {
                        wrong.push(format!("{place}: the output is\n{printed}"));
                    }
                }
                continue;
            }
            "rust" => continue,
            "toml" if block.text.starts_with("slipmap = ") => continue,
            // tests/program/reference_page.rs runs the examples of this page.
            "toml" if page.ends_with("configuration.md") => continue,
            other => {
                wrong.push(format!("{place}: a block of `{other}` is neither run nor written to a file"));
                continue;
            }
        };
        let output = command.current_dir(&folder).env("PATH", &path).output().unwrap();
        if !output.status.success() {
            let errors = String::from_utf8_lossy(&output.stderr);
            wrong.push(format!("{place}: {}\n{errors}", output.status));
            break;
        }
        printed = Some(String::from_utf8(output.stdout).unwrap());
    }
    wrong
}

#[test]
fn every_page_works_as_shown() {
    let pages = pages();
    let next = std::sync::atomic::AtomicUsize::new(0);
    let wrong = std::sync::Mutex::new(Vec::new());
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                while let Some(page) = pages.get(next.fetch_add(1, std::sync::atomic::Ordering::Relaxed)) {
                    wrong.lock().unwrap().extend(follow(page));
                }
            });
        }
    });
    let wrong = wrong.into_inner().unwrap();
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

/// The anchors of a page's headings, as code hosting sites make them.
fn anchors(text: &str) -> Vec<String> {
    let mut code = false;
    let headings = text.lines().filter(|line| {
        code ^= line.starts_with("```");
        !code && line.starts_with('#')
    });
    let anchor = |heading: &str| -> String {
        let title = heading.trim_start_matches('#').trim().to_lowercase().replace(' ', "-");
        title.chars().filter(|c| c.is_alphanumeric() || *c == '-' || *c == '_').collect()
    };
    headings.map(anchor).collect()
}

#[test]
fn every_relative_link_resolves() {
    let mut documents = pages();
    for name in ["CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md", "results/README.md", "fuzz/README.md"] {
        documents.push(name.into());
    }
    let mut wrong = Vec::new();
    for document in documents {
        let text = fs::read_to_string(root().join(&document)).unwrap();
        for (at, _) in text.match_indices("](") {
            let link = text[at + 2..].split(')').next().unwrap();
            if link.starts_with("https://") || link.starts_with("http://") || link.starts_with("mailto:") {
                continue;
            }
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() {
                root().join(&document)
            } else {
                root().join(&document).parent().unwrap().join(file)
            };
            let there = target.exists()
                && (anchor.is_empty()
                    || fs::read_to_string(&target)
                        .is_ok_and(|text| anchors(&text).iter().any(|a| a == anchor)));
            if !there {
                wrong.push(format!("{}: {link} leads nowhere", document.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_index_of_the_guide_lists_every_page() {
    let index = fs::read_to_string(root().join("docs/README.md")).unwrap();
    for page in pages() {
        let name = page.file_name().unwrap().to_string_lossy().into_owned();
        assert!(
            name == "README.md" || index.contains(&format!("]({name})")),
            "docs/README.md does not list {name}"
        );
    }
}
