//! Passes the commit to the crate, for the provenance of the maps it writes.

use std::path::Path;
use std::process::Command;

/// Paths on which the binary depends.
const SOURCES: [&str; 5] = ["src", "crates", "Cargo.toml", "Cargo.lock", "build.rs"];

/// Output of a git command run in the crate's folder; `None` without git or outside a repository. Without
/// optional locks, so that the command changes no file that would trigger a new build.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").arg("--no-optional-locks").args(arguments).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// The commit, with "modified" if the sources differ from it; `None` if the crate's folder is not the top of
/// a repository (then the commit would be another project's).
fn state() -> Option<String> {
    let top = git(&["rev-parse", "--show-toplevel"])?;
    let here = std::env::var("CARGO_MANIFEST_DIR").ok()?;
    if Path::new(&top).canonicalize().ok()? != Path::new(&here).canonicalize().ok()? {
        return None;
    }
    let commit = git(&["rev-parse", "HEAD"])?;
    let mut status = vec!["status", "--porcelain", "--"];
    status.extend(SOURCES);
    Some(if git(&status)?.is_empty() { commit } else { format!("{commit}, modified") })
}

fn main() {
    let state = state();
    println!("cargo::rustc-env=SLIPMAP_GIT={}", state.as_deref().unwrap_or("unknown"));
    for source in SOURCES {
        println!("cargo::rerun-if-changed={source}");
    }
    // Files that a commit or a change of branch modifies.
    for trace in ["HEAD", "logs/HEAD"] {
        if let Some(path) = git(&["rev-parse", "--git-path", trace]).filter(|path| Path::new(path).exists()) {
            println!("cargo::rerun-if-changed={path}");
        }
    }
}
