//! Checks the output of a run before anything is computed: whether a map may be written there, what it
//! replaces, and how much space is free.

use std::io;
use std::path::{Path, PathBuf};

use super::output::{bytes, count};
use super::replace::Files;
use super::{Ended, Failure, say};
use slipmap_config::Job;
use slipmap_files::folder_of;
use slipmap_map::Grid;

/// State of the output's path and of its disk.
#[derive(Debug)]
pub(super) struct Preflight {
    /// The map and the certificate that will be replaced, each if it is there.
    pub(super) replaces: [Option<String>; 2],
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
        let files = Files::reading([&job.config_file]).law(job.plan.grid.law());
        let files = job.plan.grid.machine().into_iter().fold(files, Files::machine);
        files
            .writing("output.path", Some(&job.output))
            .writing("validated.proof", job.proof.as_deref())
            .check(true)?;
        let free = fs4::available_space(first_folder(&job.output)).ok();
        let mut found = Self { replaces: [None, None], refuses: None, free };
        let outputs = [("output.path", Some(&job.output)), ("validated.proof", job.proof.as_ref())];
        for ((key, path), replaces) in outputs.into_iter().zip(&mut found.replaces) {
            let Some(path) = path else { continue };
            check_folder(path, key)?;
            let (name, Ok(metadata)) = (path.display(), path.symlink_metadata()) else { continue };
            match permission {
                Permission::Resume => {}
                Permission::Overwrite if metadata.is_symlink() => {
                    *replaces = Some(format!("the link {name}"))
                }
                Permission::Overwrite => {
                    *replaces = Some(format!("{name} ({})", bytes(metadata.len().into())))
                }
                Permission::None => {
                    found.refuses.get_or_insert(format!(
                        "{name} exists already\n  help: add --overwrite to replace it, or choose another place with --set {key}=.."
                    ));
                }
            }
        }
        Ok(found)
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

/// Refuses a folder that cannot be written, by creating an unnamed file in it.
fn check_folder(path: &Path, key: &str) -> Result<(), Failure> {
    let folder = first_folder(path);
    tempfile::tempfile_in(&folder).map(drop).map_err(|error| {
        let problem =
            format!("{}: cannot write into the folder {}: {error}", path.display(), folder.display());
        Failure::bad_input(problem, format!("choose another place with --set {key}=.."))
    })
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
    slipmap_files::create_folders(folder).map_err(|error| {
        let problem = format!("the folder {} cannot be created: {error}", folder.display());
        Failure::bad_input(problem, "choose another place with --set output.path=..")
    })
}
