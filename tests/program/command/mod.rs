//! Runs the real binary in a scratch folder.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A probe of the point used in the README.
pub const PROBE: [&str; 13] = [
    "probe",
    "--epsilon",
    "0.1",
    "--alpha",
    "0.3",
    "--beta",
    "0.1",
    "--gamma",
    "2",
    "--V",
    "1",
    "--c",
    "0.5",
];

/// A scratch folder in which the program runs.
pub struct Scratch {
    folder: tempfile::TempDir,
}

impl Scratch {
    pub fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    pub fn file(&self, name: &str, contents: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path().join(name);
        std::fs::write(&path, contents).unwrap();
        path
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path().join(name)).unwrap()
    }

    /// The names in the folder, hidden ones too, sorted; those of journals without their random letters.
    pub fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.path()).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        for name in &mut names {
            let letters = name.find(".part.").map_or(name.len(), |at| at + ".part".len());
            name.truncate(letters);
        }
        names.sort();
        names
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_slipmap"));
        command.args(arguments).current_dir(self.path()).stdin(Stdio::null());
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Run {
        Run::of(self.command(arguments).output().unwrap())
    }
}

/// The journals in a folder.
pub fn journals(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten();
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    paths.filter(|path| path.to_string_lossy().contains(".part.")).collect()
}

/// The sum of the lengths of the journals in a folder.
pub fn journal_bytes(folder: &Path) -> u64 {
    journals(folder).iter().map(|path| path.metadata().map_or(0, |metadata| metadata.len())).sum()
}

/// Exit code and output of a run.
#[derive(Debug)]
pub struct Run {
    pub code: i32,
    pub out: String,
    pub err: String,
}

impl Run {
    pub fn of(output: Output) -> Self {
        Self {
            code: output.status.code().unwrap_or(-1),
            out: String::from_utf8(output.stdout).unwrap(),
            err: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Asserts that the run ended with `code`, and shows its output otherwise.
    #[track_caller]
    pub fn ends_with(self, code: i32) -> Self {
        assert_eq!(self.code, code, "\nstdout:\n{}\nstderr:\n{}", self.out, self.err);
        self
    }

    /// Asserts bad input: exit code 2, nothing on standard output, one message that contains every one of
    /// `parts`.
    #[track_caller]
    pub fn refuses(self, parts: &[&str]) -> Self {
        let run = self.ends_with(2);
        assert_eq!(run.out, "", "a refusal prints no data");
        assert_eq!(run.err.matches("error:").count(), 1, "one message:\n{}", run.err);
        for part in parts {
            assert!(run.err.contains(part), "no `{part}` in\n{}", run.err);
        }
        run
    }
}

/// The next number in [0, 1) of a generator in this state.
pub fn random(state: &mut u64) -> f64 {
    let mut random = slipmap_numbers::random::Random(*state);
    let number = random.unit();
    *state = random.0;
    number
}
