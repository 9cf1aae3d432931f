//! Checks the output of a run before anything is computed: whether a map may be written there, what it
//! replaces, and how much space is free.

use std::io::{self, Read as _};
use std::path::{Path, PathBuf};

use super::output::{bytes, count};
use super::proof::{self, PathState};
use super::{Ended, Failure, say};
use slipmap_config::Job;
use slipmap_format::files::{self, folder_of};
use slipmap_map::map::Grid;

/// State of the output's path and of its disk.
#[derive(Debug)]
pub(super) struct Preflight {
    /// The map that will be replaced, if there is one, and its size.
    pub(super) replaces: Option<String>,
    /// The certificate that will be replaced, if there is one.
    pub(super) replaces_proof: Option<String>,
    /// An existing file that the run may not replace, if there is one: the run would be refused.
    pub(super) refuses: Option<String>,
    /// Free bytes on the disk, if the system reports them.
    pub(super) free: Option<u64>,
}

/// Largest number of bytes on the disk during a run: packed tiles lie in the journal and in the map.
pub(super) fn peak(packed: u128) -> u128 {
    2 * packed
}

/// Permission of a run to change existing files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Permission {
    /// Nothing: the run is refused.
    None,
    /// Replace them.
    Overwrite,
    /// Continue them.
    Resume,
}

impl Preflight {
    /// Refuses an output that cannot be written, before anything is computed or created. An existing file
    /// that may not be replaced is reported in the result.
    pub(super) fn check(job: &Job, permission: Permission) -> Result<Self, Failure> {
        let name = job.output.display();
        let mut refuses = None;
        let mut exists = |path: &Path, key: &str| {
            refuses.get_or_insert(format!(
                "{} exists already\n  help: add --overwrite to replace it, or choose another place with --set {key}=..",
                path.display()
            ));
        };
        let mut replaces_proof = None;
        if let Some(proof) = &job.proof {
            match check_proof(job, proof, permission)? {
                Place::Free => {}
                Place::Replaces(what) => replaces_proof = Some(what),
                Place::Taken => exists(proof, "validated.proof"),
            }
        }
        let same =
            |a: &Path, b: &Path| a.canonicalize().is_ok_and(|a| b.canonicalize().is_ok_and(|b| a == b));
        if same(&job.output, &job.config_file) {
            let problem = format!("{name} is the configuration itself");
            return Err(Failure::bad_input(problem, "choose another place with --set output.path=.."));
        }
        let replaces = match job.output.symlink_metadata() {
            Err(_) => None,
            Ok(metadata) => match permission {
                Permission::Resume => None,
                Permission::Overwrite => Some(replaced(&job.output, &metadata)?),
                Permission::None => {
                    exists(&job.output, "output.path");
                    None
                }
            },
        };
        check_folder(&job.output, "output.path")?;
        let free = fs4::available_space(first_folder(&job.output)).ok();
        Ok(Self { replaces, replaces_proof, refuses, free })
    }

    /// Refuses a map that does not fit on its disk, and warns if the run may fill it. `packed` is the
    /// estimated size of the map.
    pub(super) fn verdict(&self, job: &Job, packed: u128) -> Result<Ended, Failure> {
        let name = job.output.display();
        let Some(free) = self.free.filter(|&free| peak(packed) > u128::from(free)) else {
            return Ok(Ended::Fine);
        };
        let need = format!(
            "about {} (its journal and the map, from a sample), and {} is free for {name}",
            bytes(peak(packed)),
            bytes(free.into())
        );
        // The estimate may be wrong by a factor, but hardly by two.
        if packed <= u128::from(free) {
            say(&format!("warning: the run needs {need}; should the disk fill, it stops and can be resumed"));
            return Ok(Ended::Fine);
        }
        let grid = &job.plan.grid;
        let problem = format!(
            "{}: the grid has {} cells ({}), {} before compression; the run needs {need}",
            job.config_file.display(),
            count(grid.cells()),
            sizes(grid),
            bytes(job.plan.bytes()),
        );
        let help = "take fewer points on the longest axes or fewer output.fields, or choose another disk";
        Err(Failure::bad_input(problem, help))
    }

    /// Returns whether the map might not fit, so that its size must be sampled.
    pub(super) fn may_not_fit(&self, job: &Job) -> bool {
        self.free.is_some_and(|free| peak(job.plan.bytes()) > u128::from(free))
    }
}

/// The lengths of the axes of a grid: "epsilon 3 x alpha 1 x ..".
pub(super) fn sizes(grid: &Grid) -> String {
    let axes = grid.axes().iter();
    axes.map(|axis| format!("{} {}", axis.name, count(axis.values.len()))).collect::<Vec<_>>().join(" x ")
}

/// State of a certificate's path.
enum Place {
    Free,
    Replaces(String),
    Taken,
}

/// Refuses a folder that cannot be written, by creating an unnamed file in it.
fn check_folder(path: &Path, key: &str) -> Result<(), Failure> {
    let folder = first_folder(path);
    tempfile::tempfile_in(&folder).map(drop).map_err(|error| {
        let problem =
            format!("{}: cannot write into the folder {}: {error}", path.display(), folder.display());
        Failure::bad_input(problem, format!("choose another place with --set {key}=.."))
    })
}

/// Refuses a certificate's path that equals the path of another file of the run, cannot be written, or holds
/// something else.
fn check_proof(job: &Job, proof: &Path, permission: Permission) -> Result<Place, Failure> {
    let name = proof.display();
    let refuse = |problem: String| {
        let help = "choose another place with --set validated.proof=..";
        Err(Failure::bad_input(format!("validated.proof: {problem}"), help))
    };
    let (here, output) = (resolved(proof), resolved(&job.output));
    if here.starts_with(&output) || output.starts_with(&here) {
        return refuse(format!("{name} is the place of the map itself"));
    }
    check_folder(proof, "validated.proof")?;
    match proof::state(proof) {
        PathState::Nothing => Ok(Place::Free),
        PathState::OutOfReach(error) => refuse(format!("{name} cannot be written: {error}")),
        PathState::Other => Err(Failure::bad_input(
            format!("{name} is not a proof, and only proofs are replaced"),
            "move it away, or choose another place with --set validated.proof=..",
        )),
        PathState::Proof(_) if permission == Permission::Overwrite => {
            Ok(Place::Replaces(format!("the proof {name}")))
        }
        PathState::Proof(Some(run))
            if permission == Permission::Resume && run == job.identity(super::GIT) =>
        {
            Ok(Place::Free)
        }
        PathState::Proof(_) if permission == Permission::Resume => {
            refuse(format!("{name} is the proof of another run, and to resume this one replaces nothing"))
        }
        PathState::Proof(_) => Ok(Place::Taken),
    }
}

/// The path with links, dots and relative parts resolved, as far as it exists.
fn resolved(path: &Path) -> PathBuf {
    if let Ok(whole) = path.canonicalize() {
        return whole;
    }
    match (path.parent(), path.file_name()) {
        (Some(folder), Some(name)) if folder.as_os_str().is_empty() => resolved(Path::new(".")).join(name),
        (Some(folder), Some(name)) => resolved(folder).join(name),
        _ => path.to_owned(),
    }
}

/// Describes what `--overwrite` will replace; refuses anything but a map.
fn replaced(output: &Path, metadata: &std::fs::Metadata) -> Result<String, Failure> {
    let name = output.display();
    if metadata.is_symlink() {
        let target = std::fs::read_link(output).unwrap_or_default();
        return Ok(format!("the link {name} to {}, not what it leads to,", target.display()));
    }
    let mut first = Vec::new();
    let mut is_map = || {
        std::fs::File::open(output)
            .and_then(|file| file.take(slipmap_format::SIGNATURE.len() as u64).read_to_end(&mut first))
            .is_ok_and(|_| first == slipmap_format::SIGNATURE || first.is_empty())
    };
    // In this order: opening a pipe would wait for its other end.
    if !(metadata.is_file() && is_map()) {
        return Err(Failure::bad_input(
            format!("{name} is not a map, and only maps are replaced"),
            "move it away, or choose another place with --set output.path=..",
        ));
    }
    Ok(format!("{name} ({})", bytes(metadata.len().into())))
}

/// The folder of `output`, or its nearest parent that exists.
fn first_folder(output: &Path) -> PathBuf {
    let mut folder = output.parent();
    while let Some(path) = folder.filter(|path| !path.as_os_str().is_empty()) {
        // A folder that exists but does not answer is reported when it is written to.
        if !path.symlink_metadata().is_err_and(|error| error.kind() == io::ErrorKind::NotFound) {
            return path.to_owned();
        }
        folder = path.parent();
    }
    PathBuf::from(".")
}

pub(super) fn create_folders(output: &Path) -> Result<(), Failure> {
    let folder = folder_of(output);
    files::create_folders(folder).map_err(|error| {
        let problem = format!("the folder {} cannot be created: {error}", folder.display());
        Failure::bad_input(problem, "choose another place with --set output.path=..")
    })
}
