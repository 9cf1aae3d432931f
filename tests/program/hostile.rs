//! Untrusted files: for any map, configuration or table there is one clear message and the exit code for it,
//! within bounded memory and time, and no content is executed.

use std::ffi::OsString;
use std::fs;
use std::os::unix::ffi::OsStringExt as _;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::command::{PROBE, Run, Says, Scratch};
use crate::map_equal::assert_same;
use hdf5::types::VarLenUnicode;
use hdf5::{File, Location};
use sha2::{Digest as _, Sha256};

/// A map of a few hundred cells with every kind of variable.
const JOB: &str = "\
title = \"to be damaged_copy\"
[grid]
epsilon = [0.05, 0.2]
alpha = [0.1, 0.5]
beta = [0.0, 0.2]
gamma = { from = 0.5, to = 8.0, points = 4, spacing = \"log\" }
V = [0.5, 2.0]
c = { from = 0.0, to = 3.0, points = 8 }
[methods]
run = [\"symmetric\", \"simulation\"]
[output]
path = \"map.h5\"
fields = [\"verdict\", \"margin\", \"critical_c\", \"regime\", \"growth\"]
";

/// Address space in kilobytes: too little for a grid of 10^18 cells, or for a tenth of a per cent of it.
const MEMORY_LIMIT: &str = "4000000";

pub fn scratch() -> Scratch {
    let scratch = Scratch::new();
    scratch.file("job.toml", JOB);
    scratch.run("run job.toml").ends_with(0);
    fs::rename(scratch.path().join("map.h5"), scratch.path().join("good.h5")).unwrap();
    scratch
}

/// Runs the program in bounded memory; a run that hangs is ended (exit code 124).
pub fn bounded(scratch: &Scratch, arguments: &[&str]) -> Run {
    let mut command = Command::new("sh");
    command.args([
        "-c",
        "ulimit -v \"$0\"; exec timeout 100 \"$@\"",
        MEMORY_LIMIT,
        env!("CARGO_BIN_EXE_slipmap"),
    ]);
    command.args(arguments).current_dir(scratch.path()).stdin(Stdio::null());
    Run::of(command.output().unwrap())
}

/// The command that draws a map.
pub const PLOT: [&str; 10] =
    ["plot", "map.h5", "--x", "gamma", "--y", "c", "--out", "plot.svg", "--overwrite", "--width=one-column"];

/// A copy of the valid map as `map.h5`, changed by `spoil`.
pub fn damaged_copy(scratch: &Scratch, spoil: impl FnOnce(&File)) {
    let map = scratch.path().join("map.h5");
    let _ = fs::remove_file(&map);
    let work = scratch.path().join("work.h5");
    fs::copy(scratch.path().join("good.h5"), &work).unwrap();
    let file = File::open_rw(&work).unwrap();
    spoil(&file);
    file.close().unwrap();
    moved_away(&work, &map);
}

/// Moves a file that this process has changed to a name on which no process holds a lock: programs that other
/// tests start meanwhile inherit HDF5's locks.
pub fn moved_away(work: &Path, path: &Path) {
    fs::copy(work, path).unwrap();
    fs::remove_file(work).unwrap();
}

/// Seals `map.h5` as it is.
pub fn forge(scratch: &Scratch) {
    let path = scratch.path().join("map.h5");
    let mut bytes = fs::read(&path).unwrap();
    if let Some(body) =
        bytes.len().checked_sub(seal_of(&[]).len()).filter(|&at| bytes[at..].starts_with(LABEL))
    {
        bytes.truncate(body);
    }
    bytes.extend(seal_of(&bytes));
    fs::write(path, bytes).unwrap();
}

/// The text of the seal before its digits.
pub const LABEL: &[u8] = b"\nslipmap seal, sha256 of every byte before this line: ";

/// The seal of a file with these bytes.
fn seal_of(bytes: &[u8]) -> Vec<u8> {
    let digits: String = Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    [LABEL, digits.as_bytes(), b"\n"].concat()
}

/// Asserts that the output has no control characters, which a terminal would execute.
pub fn assert_no_control_characters(run: &Run) {
    for text in [&run.out, &run.err] {
        assert!(!text.contains(|c: char| c.is_control() && c != '\n' && c != '\t'), "{text:?}");
    }
}

/// Asserts that a command refuses `map.h5` with exit code 2 and a message with `part`: one after the other, since
/// all of them read a map through the same verification. `check` may report damage instead.
#[track_caller]
fn assert_refused(scratch: &Scratch, what: &str, part: &str, check: i32) {
    let before = fs::read(scratch.path().join("map.h5")).unwrap();
    let arguments = [&["report", "map.h5"][..], &PLOT, &["run", "job.toml", "--resume"]][what.len() % 3];
    let run = bounded(scratch, arguments);
    assert_no_control_characters(&run);
    assert_eq!(run.code, 2, "{what}: {arguments:?}: {run:?}");
    assert_eq!(run.err.matches("error:").count(), 1, "{what}: {run:?}");
    assert!(run.err.contains("map.h5") && run.err.contains(part), "{what}: no `{part}` in {run:?}");
    let run = bounded(scratch, &["check", "map.h5"]);
    assert_no_control_characters(&run);
    assert_eq!(run.code, check, "{what}: {run:?}");
    assert!((run.out + &run.err).contains(part), "{what}: no `{part}`");
    // A file that is not a map of slipmap is not changed, and no file is written beside it.
    assert!(fs::read(scratch.path().join("map.h5")).unwrap() == before, "{what}");
    assert_eq!(scratch.names(), ["good.h5", "job.toml", "map.h5"], "{what}");
}

fn text(place: &Location, name: &str, text: &str) {
    // Replaced as a whole: another length is another type.
    if place.attr_names().unwrap().contains(&name.to_owned()) {
        place.delete_attr(name).unwrap();
    }
    let text: VarLenUnicode = text.parse().unwrap();
    place.new_attr::<VarLenUnicode>().create(name).unwrap().write_scalar(&text).unwrap();
}

fn integers(place: &Location, name: &str, values: &[i64]) {
    place.delete_attr(name).unwrap();
    place.new_attr_builder().with_data(values).create(name).unwrap();
}

/// Replaces a dataset by one without data.
fn promise<T: hdf5::H5Type>(file: &File, name: &str, shape: &[usize], chunk: &[usize]) {
    file.unlink(name).unwrap();
    let dataset = file.new_dataset::<T>().shape(shape).chunk(chunk).deflate(9).create(name).unwrap();
    for attribute in ["long_name", "equation", "guarantee"] {
        text(&dataset, attribute, "anything");
    }
}

/// A description of the error, a part of the message, the exit code of `check`, and the change that makes it.
type Case<'a> = (&'a str, &'a str, i32, &'a dyn Fn(&File));

#[test]
fn maps_of_other_programs_are_refused() {
    let scratch = scratch();
    let cases: [Case; 15] = [
        ("a newer layout", "its layout has number [5]", 2, &|file| integers(file, "schema", &[5])),
        ("no layout", "no integer attribute schema", 2, &|file| file.delete_attr("schema").unwrap()),
        ("an unknown law", "does not know its friction law", 2, &|file| text(file, "law", "\u{1b}[2Jboo")),
        ("an unknown field", "does not know its field", 2, &|file| text(file, "fields", "verdict <b>")),
        ("a path as a method", "does not know its method", 2, &|file| {
            text(file, "methods", "../../etc/passwd")
        }),
        ("a tag as a method", "does not know its method", 2, &|file| text(file, "methods", "<script>")),
        ("a method twice", "names simulation twice", 2, &|file| {
            text(file, "methods", "symmetric simulation simulation");
        }),
        ("no such variable", "verdict_bendixson", 1, &|file| text(file, "methods", "symmetric bendixson")),
        ("a missing variable", "regime", 1, &|file| file.unlink("regime").unwrap()),
        ("verdicts that are no codes", "verdict_symmetric holds", 1, &|file| {
            promise::<f64>(file, "verdict_symmetric", &[2, 2, 2, 4, 2, 8], &[1, 1, 1, 1, 1, 8]);
        }),
        ("margins that are texts", "margin_symmetric holds", 1, &|file| {
            promise::<VarLenUnicode>(file, "margin_symmetric", &[2, 2, 2, 4, 2, 8], &[1, 1, 1, 1, 1, 8]);
        }),
        ("another shape", "verdict_symmetric has the shape", 1, &|file| {
            promise::<i8>(file, "verdict_symmetric", &[2, 2, 2, 4, 2, 9], &[1, 1, 1, 1, 1, 8]);
        }),
        ("fewer dimensions", "verdict_symmetric has the shape", 1, &|file| {
            promise::<i8>(file, "verdict_symmetric", &[8], &[8]);
        }),
        ("an axis of whole numbers", "its axis c does not hold", 2, &|file| {
            promise::<i32>(file, "c", &[8], &[8]);
        }),
        ("an axis that decreases", "c", 2, &|file| {
            let c = file.dataset("c").unwrap();
            c.write_raw(&[7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0, f64::NAN]).unwrap();
        }),
    ];
    for (what, part, check, spoil) in cases {
        damaged_copy(&scratch, spoil);
        assert_refused(&scratch, what, part, check);
    }
    let [map, work] = ["map.h5", "work.h5"].map(|name| scratch.path().join(name));
    fs::remove_file(&map).unwrap();
    let foreign = File::create(&work).unwrap();
    foreign.new_dataset::<f64>().shape([3]).create("temperature").unwrap();
    foreign.close().unwrap();
    moved_away(&work, &map);
    assert_refused(&scratch, "a file of another program", "is not a map", 2);
    for (what, bytes) in [("text", "epsilon,alpha\n"), ("nothing", ""), ("zeros", "\0\0\0\0\0\0\0\0\0\0")] {
        scratch.file("map.h5", bytes);
        assert_refused(&scratch, what, "it is not an HDF5 file", 2);
    }
}

#[test]
fn cut_maps_are_refused() {
    let scratch = scratch();
    let whole = fs::read(scratch.path().join("good.h5")).unwrap();
    for length in [9, 100, 600, whole.len() / 4, whole.len() / 2, 3 * whole.len() / 4, whole.len() - 200] {
        scratch.file("map.h5", &whole[..length]);
        assert_refused(&scratch, &format!("{length} bytes"), "map.h5", 2);
    }
}

#[test]
fn pipes_and_devices_are_no_maps() {
    let scratch = scratch();
    assert!(Command::new("mkfifo").arg(scratch.path().join("pipe")).status().unwrap().success());
    for name in ["pipe", "/dev/zero"] {
        for command in [&["report"][..], &["check"], &["check", "--proof"]] {
            bounded(&scratch, &[command, &[name]].concat()).refuses(&[name, "a pipe or a device", "help: "]);
        }
    }
}

#[test]
fn names_that_are_no_text_are_refused_with_the_reason() {
    let scratch = scratch();
    let odd = |name: &[u8]| OsString::from_vec(name.to_vec());
    fs::copy(scratch.path().join("good.h5"), scratch.path().join(odd(b"odd\xff.h5"))).unwrap();
    let cases: [(&[&str], &[u8], &str); 3] = [
        (&["check"], b"odd\xff.h5", "rename"),
        (&["report"], b"odd\xff.h5", "rename"),
        (&["plot", "--x", "gamma", "--y", "c", "--out", "a.svg"], b"odd\xff.h5", "rename"),
    ];
    for (arguments, name, remedy) in cases {
        let run = Run::of(scratch.command(arguments).arg(odd(name)).output().unwrap());
        run.refuses(&["odd\u{fffd}", "UTF-8", remedy]);
    }
}

#[test]
fn what_cannot_be_written_is_told_with_a_remedy() {
    let scratch = scratch();
    let draw = |out: &str, more: &[&str]| {
        let plot = ["plot", "good.h5", "--x", "gamma", "--y", "c", "--out", out];
        bounded(&scratch, &[&plot, more].concat())
    };
    // Nobody may create files there.
    draw("/proc/new.svg", &[]).refuses(&[
        "/proc/new.svg",
        "cannot write into the folder /proc",
        "choose a folder",
    ]);
    let report = ["report", "good.h5", "--out", "good.h5/new"];
    bounded(&scratch, &report).refuses(&["good.h5", "a file is where a folder is needed", "help: "]);
    draw("a.svg", &["--variable", "zz"]).refuses(&[
        "good.h5",
        "`zz`",
        "verdict_simulation",
        "choose one of these",
    ]);
    assert_eq!(scratch.names(), ["good.h5", "job.toml"]);
}

/// Runs the program from a shell, after the words of `limit`.
fn limited(scratch: &Scratch, limit: &str, arguments: &[&str], output: &str) -> Run {
    let mut command = Command::new("sh");
    command.args(["-c", &format!("{limit}; exec \"$0\" \"$@\" {output}"), env!("CARGO_BIN_EXE_slipmap")]);
    command.args(arguments).current_dir(scratch.path()).stdin(Stdio::null()).env_remove("RUST_BACKTRACE");
    Run::of(command.output().unwrap())
}

#[cfg(target_os = "linux")]
#[test]
fn a_limit_on_file_sizes_is_an_error_and_costs_nothing() {
    let scratch = scratch();
    let header = "epsilon,alpha,beta,gamma,c,V\n";
    scratch.file("in.csv", header.to_owned() + &"0.1,0.3,0.1,2,0.5,1\n".repeat(20));
    let cases: [&[&str]; 4] = [
        &["run", "job.toml"],
        &["report", "good.h5", "--out", "report"],
        &["plot", "good.h5", "--x", "gamma", "--y", "c", "--out", "plot.svg"],
        &["probe", "--points", "in.csv", "--out", "out.csv"],
    ];
    for arguments in cases {
        let run = limited(&scratch, "ulimit -f 12", arguments, "").ends_with(1);
        assert!(run.err.contains("limit on file sizes"), "{arguments:?}: {}", run.err);
        assert!(run.err.contains("help: ") || run.err.contains("to continue: "), "{}", run.err);
    }
    assert_eq!(scratch.names(), ["good.h5", "in.csv", "job.toml", "map.h5.part"]);
    scratch.run("run job.toml --resume").ends_with(0);
    assert_same(&scratch.path().join("map.h5"), &scratch.path().join("good.h5"));
    // Where not even one tile fits, nothing is left that could be continued, and no word says so.
    fs::remove_file(scratch.path().join("map.h5")).unwrap();
    scratch.file("large.toml", JOB.replace("points = 8 }", "points = 8000 }"));
    for blocks in [4, 12] {
        let run = limited(&scratch, &format!("ulimit -f {blocks}"), &["run", "large.toml"], "").ends_with(1);
        assert!(run.err.contains("limit on file sizes") && !run.err.contains("--resume"), "{}", run.err);
        assert!(!scratch.names().contains(&"map.h5.part".to_owned()));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn output_that_cannot_be_written_is_an_error() {
    let scratch = Scratch::new();
    let json = [&PROBE[..], &["--json"]].concat();
    let cases: [&[&str]; 4] = [&PROBE, &json, &["--help"], &["completions", "bash"]];
    for arguments in &cases {
        let run = limited(&scratch, "true", arguments, ">/dev/full").ends_with(1);
        run.err.says(&["cannot write to standard output", "help: "]);
        // Nobody reads: the exit code tells that data are lost, and no message is needed.
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let mut command = scratch.command(arguments);
        let run = Run::of(command.stdout(writer).stderr(Stdio::piped()).output().unwrap()).ends_with(141);
        assert_eq!(run.err, "");
    }
}

#[test]
fn cells_of_tables_are_no_formulas() {
    let scratch = Scratch::new();
    let name = "-2+3+cmd|' /C calc'!A0";
    scratch.file(
        "in.csv",
        format!("{name},epsilon,alpha,beta,gamma,c,V\n{name},0.1,0.3,0.1,2,+0.5,1\n=1,0.1,0.3,0.1,2,-0,1\n"),
    );
    let run = scratch.run("probe --points in.csv --out -").ends_with(0);
    let lines: Vec<&str> = run.out.lines().collect();
    assert!(lines[0].starts_with(&format!("'{name},epsilon,")), "{}", lines[0]);
    assert!(lines[1].starts_with(&format!("'{name},0.1,0.3,0.1,2,+0.5,1,")), "{}", lines[1]);
    assert!(lines[2].starts_with("'=1,0.1,0.3,0.1,2,-0,1,"), "{}", lines[2]);
}

/// Words that browsers, LaTeX, spreadsheets or terminals would execute.
const COMMANDS: &str = "</title></text><script>alert(1)</script><img src=x onerror=alert(1)> \\input{/etc/passwd} \\write18{rm} \
     $\\alpha$ %|`e` =cmd|' /C calc'!A0 \u{1b}[2J\u{7}\u{8}\u{9b}31m\r\n\
     # heading ]]> <!-- \"q\" 'r' {f} 中 \u{202e}";

#[test]
fn texts_of_maps_are_not_executed() {
    let scratch = scratch();
    damaged_copy(&scratch, |file| {
        for name in "title history source references config machine git crate_version".split(' ') {
            text(file, name, COMMANDS);
        }
        for name in ["verdict_symmetric", "verdict_simulation", "margin_symmetric", "regime"] {
            let variable = file.dataset(name).unwrap();
            for attribute in ["long_name", "equation", "guarantee", "units", "flag_meanings"] {
                text(&variable, attribute, COMMANDS);
            }
        }
    });
    let run = bounded(&scratch, &["check", "map.h5"]).ends_with(1);
    assert_no_control_characters(&run);
    bounded(&scratch, &["report", "map.h5"]).refuses(&["map.h5 is damaged", "file, attribute"]);
    // A forger can seal the map again.
    forge(&scratch);
    bounded(&scratch, &["report", "map.h5"]).ends_with(0);
    bounded(&scratch, &PLOT).ends_with(0);
    let mut checked = 0;
    let mut folders = vec![scratch.path().join("map-report")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if let Ok(text) = fs::read_to_string(&path) {
                assert_harmless(&path, &text);
                checked += 1;
            }
        }
    }
    assert!(checked > 10, "{checked} texts");
    assert_harmless(Path::new("plot.svg"), &scratch.read("plot.svg"));
}

/// Asserts that a written file contains no command of its format.
fn assert_harmless(path: &Path, text: &str) {
    let name = path.display();
    assert!(!text.contains(|c: char| c.is_control() && !['\n', '\t', '\r'].contains(&c)), "{name}");
    match path.extension().unwrap().to_str().unwrap() {
        "html" | "svg" => {
            for tag in ["<script", "<img", "<!--", "onerror=alert(1)>"] {
                assert!(!text.contains(tag), "{tag} in {name}");
            }
            if name.to_string().ends_with("svg") {
                roxmltree::Document::parse(text).unwrap_or_else(|error| panic!("{name}: {error}"));
            }
        }
        "tex" => {
            for command in ["\\input{/", "\\write18", "$\\alpha$ %"] {
                assert!(!text.contains(command), "{command} in {name}");
            }
        }
        "csv" => {
            let cells =
                csv::ReaderBuilder::new().flexible(true).from_reader(text.as_bytes()).into_byte_records();
            for cell in cells.flat_map(|row| row.unwrap().iter().map(<[u8]>::to_vec).collect::<Vec<_>>()) {
                assert!(!cell.starts_with(b"=cmd"), "a formula in {name}");
            }
        }
        other => panic!("{other} files are not looked into"),
    }
}

#[test]
fn a_text_that_is_no_text_is_refused() {
    let scratch = scratch();
    damaged_copy(&scratch, |file| text(file, "title", "QQQQQQQQQQQQQQQQQQQQQQQQQQQQQQQQ"));
    let path = scratch.path().join("map.h5");
    let mut bytes = fs::read(&path).unwrap();
    let at = bytes.windows(32).position(|part| part == [b'Q'; 32]).unwrap();
    bytes[at..at + 32].fill(0xff);
    fs::write(&path, bytes).unwrap();
    assert_refused(&scratch, "bytes that are no UTF-8", "not UTF-8", 2);
}

#[test]
fn configurations_may_be_anything() {
    let scratch = Scratch::new();
    let nested = |open: &str, close: &str| format!("a = {}{}", open.repeat(100_000), close.repeat(100_000));
    let number = "0.25,".repeat(4_000_000);
    let points = |n: u64| format!("[grid]\nepsilon = {{ from = 0.1, to = 0.5, points = {n} }}\n");
    let axes: String = ["epsilon", "alpha", "beta", "gamma", "V", "c"]
        .map(|name| format!("{name} = {{ from = 0.1, to = 0.9, points = 1000000 }}\n"))
        .concat();
    let cases: [(&str, Vec<u8>, &[&str]); 11] = [
        ("binary", (0..=255).cycle().take(5000).collect(), &["bad.toml:2:", "UTF-8"]),
        ("a zero", b"title = \"a\0b\"\n".to_vec(), &["bad.toml:1:", "not valid TOML"]),
        ("a terminal's commands", b"\x1b[2J = 1\n".to_vec(), &["bad.toml:1:"]),
        ("nested lists", nested("[", "]").into(), &["bad.toml:1:", "not valid TOML"]),
        ("nested tables", nested("{ a = ", "}").into(), &["bad.toml:1:", "not valid TOML"]),
        ("nested keys", "a.".repeat(100_000).into_bytes(), &["bad.toml:1:", "not valid TOML"]),
        ("20 MB", format!("a = [{number}]").into(), &["bad.toml: this is longer than 16 MiB"]),
        ("10^9 points", points(1_000_000_000).into(), &["bad.toml:2:", "points = 1000000000", "from 1 to"]),
        ("10^30 points", points(u64::MAX).into(), &["bad.toml:2:"]),
        ("10^36 cells", format!("[grid]\n{axes}").into(), &["bad.toml:2:", "more cells than can be counted"]),
        ("nothing", Vec::new(), &["bad.toml:1:1", "`epsilon` is missing"]),
    ];
    let commands = ["run", "failures", "work-precision"].into_iter().cycle();
    for ((what, contents, parts), command) in cases.into_iter().zip(commands) {
        scratch.file("bad.toml", contents);
        let run = bounded(&scratch, &[command, "bad.toml"]);
        assert_no_control_characters(&run);
        assert!(run.err.len() < 1000, "{what}: a message of {} bytes", run.err.len());
        run.refuses(parts);
    }
    bounded(&scratch, &["run", "/dev/zero"]).refuses(&["/dev/zero", "longer than 16 MiB"]);
    assert_eq!(scratch.names(), ["bad.toml"]);
}

#[test]
fn tables_of_points_may_be_anything() {
    let scratch = Scratch::new();
    let header = "epsilon,alpha,beta,gamma,c,V\n";
    let cases: [(&str, Vec<u8>, &[&str]); 7] = [
        ("binary", (0..=255).cycle().take(5000).collect(), &["in.csv:1:"]),
        ("zeros", vec![0; 1 << 16], &["in.csv:1:"]),
        ("an open quote", format!("{header}\"{}", "1\n".repeat(2 << 20)).into(), &["longer than 1 MiB"]),
        ("a row of 4 MB", format!("{header}{}", "1,".repeat(2 << 20)).into(), &["longer than 1 MiB"]),
        ("a header of 4 MB", "a,".repeat(2 << 20).into(), &["longer than 1 MiB"]),
        ("a terminal's commands", format!("{header}\x1b[2J,0,0,0,0,1\n").into(), &["in.csv:2:", "epsilon"]),
        ("numbers that are none", format!("{header}1e999,0,0,0,nan,1\n").into(), &["in.csv:2:", "epsilon"]),
    ];
    for (what, contents, parts) in cases {
        scratch.file("in.csv", contents);
        let run = bounded(&scratch, &["probe", "--points", "in.csv", "--out", "out.csv"]);
        assert_no_control_characters(&run);
        assert!(run.err.len() < 1000, "{what}: a message of {} bytes", run.err.len());
        run.refuses(parts);
    }
    let run = bounded(&scratch, &["probe", "--points", "/dev/zero", "--out", "out.csv"]);
    run.refuses(&["/dev/zero:1:", "longer than 1 MiB"]);
    assert_eq!(scratch.names(), ["in.csv"]);
}

#[test]
fn replaced_files_are_announced_and_others_are_kept() {
    let scratch = scratch();
    fs::copy(scratch.path().join("good.h5"), scratch.path().join("map.h5")).unwrap();
    let run = scratch.run("run job.toml --overwrite --dry-run").ends_with(0);
    run.out.says(&["replaces", "map.h5 ("]);
    let run = scratch.run("run job.toml --overwrite").ends_with(0);
    run.err.says(&["note: map.h5 (", "will be replaced"]);
    // A link is replaced itself; a folder, a device and the configuration never are.
    std::os::unix::fs::symlink("good.h5", scratch.path().join("link.h5")).unwrap();
    let good = fs::read(scratch.path().join("good.h5")).unwrap();
    let to = |path: &str| {
        scratch.run(&["run", "job.toml", "--overwrite", "--set", &format!("output.path=\"{path}\"")])
    };
    let run = to("link.h5").ends_with(0);
    run.err.says(&["the link link.h5 will be replaced"]);
    assert!(fs::read(scratch.path().join("good.h5")).unwrap() == good);
    fs::create_dir(scratch.path().join("folder.h5")).unwrap();
    to("folder.h5").refuses(&["folder.h5", "this is a folder"]);
    to("/dev/null").refuses(&["/dev/null: only files are replaced"]);
    assert!(Command::new("mkfifo").arg(scratch.path().join("pipe.h5")).status().unwrap().success());
    let pipe = ["run", "job.toml", "--overwrite", "--set", "output.path=\"pipe.h5\""];
    bounded(&scratch, &pipe).refuses(&["pipe.h5: only files are replaced"]);
    fs::remove_file(scratch.path().join("pipe.h5")).unwrap();
    to("job.toml").refuses(&["job.toml: this is what is read"]);
    to("job.toml/map.h5").refuses(&["job.toml/map.h5"]);
    // With the endings of the unfinished map the name is too long.
    to(&"n".repeat(250)).refuses(&["nnn", "choose a shorter name"]);
    assert_eq!(scratch.read("job.toml"), JOB);
    bounded(&scratch, &["check", "--proof", "/dev/zero"]).refuses(&["/dev/zero", "it is not a proof"]);
    assert_eq!(scratch.names(), ["folder.h5", "good.h5", "job.toml", "link.h5", "map.h5"]);
}
