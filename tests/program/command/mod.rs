//! Runs the real binary in a scratch folder.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

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

/// The arguments of a command, as a list, or as the line that one types where none of them contains a space.
pub trait Words {
    fn words(&self) -> Vec<&str>;
}

impl Words for str {
    fn words(&self) -> Vec<&str> {
        self.split_whitespace().collect()
    }
}

impl Words for String {
    fn words(&self) -> Vec<&str> {
        self.as_str().words()
    }
}

impl Words for [&str] {
    fn words(&self) -> Vec<&str> {
        self.to_vec()
    }
}

impl<const N: usize> Words for [&str; N] {
    fn words(&self) -> Vec<&str> {
        self.to_vec()
    }
}

impl Words for Vec<&str> {
    fn words(&self) -> Vec<&str> {
        self.clone()
    }
}

impl<T: Words + ?Sized> Words for &T {
    fn words(&self) -> Vec<&str> {
        (**self).words()
    }
}

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

    pub fn command(&self, arguments: &(impl Words + ?Sized)) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_slipmap"));
        command.args(arguments.words()).current_dir(self.path()).stdin(Stdio::null());
        command
    }

    pub fn run(&self, arguments: &(impl Words + ?Sized)) -> Run {
        Run::of(self.command(arguments).output().unwrap())
    }

    /// Starts a command, whose output [`Run::after`] has.
    pub fn start(&self, arguments: &(impl Words + ?Sized)) -> Child {
        self.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    }

    /// What a command with `--json` prints.
    #[track_caller]
    pub fn json(&self, arguments: &(impl Words + ?Sized)) -> Value {
        let mut words = arguments.words();
        words.push("--json");
        self.run(&words).ends_with(0).json()
    }
}

/// A text of which parts are known.
pub trait Says {
    /// Asserts that it has every one of `parts`, and shows it otherwise.
    fn says(&self, parts: &[impl AsRef<str>]);
}

impl Says for str {
    #[track_caller]
    fn says(&self, parts: &[impl AsRef<str>]) {
        for part in parts.iter().map(AsRef::as_ref) {
            assert!(self.contains(part), "no `{part}` in\n{self}");
        }
    }
}

/// Sends a process a signal, such as `-INT`, that of Ctrl-C.
pub fn signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
}

/// Waits until the journals in a folder have grown to more bytes than these.
pub fn wait_for_journals(folder: &Path, bytes: u64) {
    let start = Instant::now();
    while journal_bytes(folder) < bytes {
        assert!(start.elapsed() < Duration::from_secs(100), "no tiles were ever finished");
        std::thread::sleep(Duration::from_millis(2));
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

    /// What a command that was started printed until its end.
    pub fn after(child: Child) -> Self {
        Self::of(child.wait_with_output().unwrap())
    }

    /// Asserts that the run ended with `code`, and shows its output otherwise.
    #[track_caller]
    pub fn ends_with(self, code: i32) -> Self {
        assert_eq!(self.code, code, "\nstdout:\n{}\nstderr:\n{}", self.out, self.err);
        self
    }

    /// The JSON on standard output.
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|error| panic!("{error} in\n{}", self.out))
    }

    /// Asserts bad input: exit code 2, nothing on standard output, one message that contains every one of
    /// `parts`.
    #[track_caller]
    pub fn refuses(self, parts: &[&str]) -> Self {
        let run = self.ends_with(2);
        assert_eq!(run.out, "", "a refusal prints no data");
        assert_eq!(run.err.matches("error:").count(), 1, "one message:\n{}", run.err);
        run.err.says(parts);
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
