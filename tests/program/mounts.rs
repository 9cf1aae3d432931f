//! Disks that disappear during a run: a file system whose server dies, as that of an NFS or sshfs mount may.
//!
//! The server is `bindfs` (a FUSE program that shows one folder as another). Without it, or without
//! permission to mount, the tests print that and are skipped; with SLIPMAP_NEEDS_FUSE set they fail instead.

use std::fs;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::command::{Run, Says, Scratch, signal, wait_for_journals};
use crate::map_equal::{assert_same, scratch};

/// The folder `disk`, served as `net`.
struct Server {
    net: PathBuf,
    daemon: Child,
}

impl Server {
    /// Mounts `disk` at `net`; `None` where that is not possible.
    fn start(scratch: &Scratch) -> Option<Self> {
        let [disk, net] = ["disk", "net"].map(|name| scratch.path().join(name));
        for folder in [&disk, &net] {
            fs::create_dir_all(folder).unwrap();
        }
        let why = match Command::new("bindfs").arg("-f").args([&disk, &net]).stderr(Stdio::piped()).spawn() {
            Err(error) => format!("bindfs: {error}"),
            Ok(daemon) => {
                let mut server = Self { net, daemon };
                if server.comes_up() {
                    return Some(server);
                }
                let _ = server.daemon.kill();
                let mut said = String::new();
                let _ = std::io::Read::read_to_string(&mut server.daemon.stderr.take().unwrap(), &mut said);
                said
            }
        };
        assert!(std::env::var_os("SLIPMAP_NEEDS_FUSE").is_none(), "{why}");
        eprintln!("skipped, no file system can be mounted here: {}", why.trim());
        None
    }

    fn comes_up(&mut self) -> bool {
        let begun = Instant::now();
        let mounted = |net: &PathBuf| {
            use std::os::unix::fs::MetadataExt;
            fs::metadata(net).is_ok_and(|own| own.dev() != fs::metadata(net.parent().unwrap()).unwrap().dev())
        };
        while !mounted(&self.net) {
            if self.daemon.try_wait().unwrap().is_some() || begun.elapsed() > Duration::from_secs(20) {
                return false;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        true
    }

    fn signal(&self, name: &str) {
        let status = Command::new("kill").args([name, &self.daemon.id().to_string()]).status().unwrap();
        assert!(status.success());
    }

    fn kill(&mut self) {
        self.daemon.kill().unwrap();
        self.daemon.wait().unwrap();
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // Lazily: files that are still open there do not matter any more.
        let unmount = |program: &str, arguments: &[&str]| {
            let status = Command::new(program).args(arguments).arg(&self.net).stderr(Stdio::null()).status();
            status.is_ok_and(|status| status.success())
        };
        let _ = self.daemon.kill();
        let _ = self.daemon.wait();
        let _ =
            unmount("umount", &["-l"]) || unmount("fusermount", &["-uz"]) || unmount("fusermount3", &["-uz"]);
    }
}

/// Every cell is integrated, so that a run lasts longer than a busy machine takes to kill a server.
const THERE: [&str; 4] =
    ["--set", "output.path=\"net/map.h5\"", "--set", "methods.run=[\"simulation\", \"direct\"]"];

/// A run with its output on the mount, whose first tiles are finished.
fn begun(scratch: &Scratch, arguments: &[&str]) -> Child {
    let child = scratch.start(&[&["run", "job.toml", "--threads", "1"], &THERE[..], arguments].concat());
    // Read without the server, which may be dead later.
    wait_for_journals(&scratch.path().join("disk"), 100_000);
    child
}

#[test]
fn a_server_that_dies_during_a_run_costs_no_finished_tile() {
    let scratch = scratch();
    // The same configuration to the last letter, on the disk itself.
    scratch.run(&[&["run", "job.toml"], &THERE[..]].concat()).ends_with(0);
    fs::rename(scratch.path().join("net/map.h5"), scratch.path().join("reference.h5")).unwrap();
    let Some(mut server) = Server::start(&scratch) else { return };
    let child = begun(&scratch, &[]);
    server.kill();
    let run = Run::after(child).ends_with(1);
    run.err.says(&[
        "net/map.h5",
        "the disk or the network that it lies on has failed or is gone",
        "when it is back,\n  to continue: slipmap run job.toml",
        "--resume",
    ]);
    assert_eq!(run.err.matches("error:").count(), 1, "{}", run.err);
    assert!(run.err.lines().count() < 6, "{}", run.err);
    assert!(!scratch.path().join("disk/map.h5").exists());

    // While it is dead, no run starts there, and nothing is written beside or below it.
    for mode in ["--resume", "--overwrite", "--dry-run", "--quiet"] {
        let arguments = [&["run", "job.toml", mode], &THERE[..]].concat();
        scratch.run(&arguments).refuses(&["cannot write into the folder net", "not connected"]);
    }
    scratch.run("check net/map.h5").refuses(&["net/map.h5", "has failed or is gone"]);
    let run = scratch.run("report reference.h5 --out net/report").ends_with(1);
    run.err.says(&["cannot write net", "not connected"]);

    drop(server);
    let server = Server::start(&scratch).expect("a second time");
    let resumed =
        scratch.run(&[&["run", "job.toml", "--resume", "--json"], &THERE[..]].concat()).ends_with(0);
    let summary = resumed.json();
    assert!(summary["resumed_tiles"].as_u64() > Some(0), "{summary}");
    drop(server);
    assert_same(&scratch.path().join("disk/map.h5"), &scratch.path().join("reference.h5"));
    // A server killed at once may not have learnt yet that a file that it was to remove is closed: it renames those.
    let left = fs::read_dir(scratch.path().join("disk")).unwrap().map(|entry| entry.unwrap().file_name());
    let left: Vec<_> = left.filter(|name| !name.to_string_lossy().starts_with(".fuse_hidden")).collect();
    assert_eq!(left, ["map.h5"]);
}

#[test]
fn a_hanging_server_does_not_delay_an_interrupted_run() {
    let scratch = scratch();
    let Some(server) = Server::start(&scratch) else { return };
    let mut child = begun(&scratch, &[]);
    server.signal("-STOP");
    signal(&child, "-TERM");
    // The program abandons its tiles within two seconds and reports it. The kernel may keep its process until
    // the server has answered outstanding requests; no program can change that.
    let (said, message) = std::sync::mpsc::channel();
    let mut stderr = child.stderr.take().unwrap();
    std::thread::spawn(move || {
        let (mut text, mut part) = (String::new(), [0; 4096]);
        while !text.contains("to continue: slipmap run job.toml") {
            match std::io::Read::read(&mut stderr, &mut part).unwrap() {
                0 => break,
                n => text.push_str(&String::from_utf8_lossy(&part[..n])),
            }
        }
        let _ = said.send(text);
    });
    let message = message.recv_timeout(Duration::from_secs(100));
    server.signal("-CONT");
    let code = child.wait().unwrap().code();
    let message = message.expect("it hangs with the server");
    message.says(&["the tiles in work were given up, finished ones are kept"]);
    assert_eq!(code, Some(143));
}

#[test]
fn a_folder_unmounted_during_a_run_is_reported() {
    let scratch = scratch();
    let Some(server) = Server::start(&scratch) else { return };
    let child = begun(&scratch, &[]);
    drop(server);
    Run::after(child).ends_with(1).err.says(&["net/map.h5"]);
    assert!(!scratch.path().join("disk/map.h5").exists() && !scratch.path().join("net/map.h5").exists());
    assert_eq!(fs::read_dir(scratch.path().join("net")).unwrap().count(), 0, "nothing below the mount");
}
