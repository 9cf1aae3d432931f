//! The place of a run's output: whether a map may be written there, what it replaces, and how much room there is.

use std::io::{self, Read as _};
use std::path::{Component, Path, PathBuf};

use super::estimate::peak;
use super::output::{bytes, count};
use super::{Ended, Failure, say};
use crate::config::Job;
use crate::store;

/// What is at the place of the output, and how much room there is.
#[derive(Debug)]
pub(super) struct Room {
    /// The map that will be replaced, if there is one, and its size.
    pub(super) replaces: Option<String>,
    /// What is there although the run may not replace it: it would be refused.
    pub(super) refuses: Option<String>,
    /// Free bytes on its disk, if the system tells.
    pub(super) free: Option<u64>,
}

/// What a run may do with files that are there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Permission {
    /// Nothing: they are in the way.
    None,
    /// Replace them.
    Overwrite,
    /// Go on with them.
    Resume,
}

impl Room {
    /// Refuses an output that cannot be written, before anything is computed or created. What is in the way of a run
    /// that may not replace it is told, not refused.
    pub(super) fn check(job: &Job, permission: Permission) -> Result<Self, Failure> {
        let name = job.output.display();
        let mut refuses = None;
        let mut exists = |path: &Path, key: &str| {
            refuses.get_or_insert(format!(
                "{} exists already\n  help: add --overwrite to replace it, or choose another place with --set {key}=..",
                path.display()
            ));
        };
        let proof = job.proof.as_ref().filter(|proof| proof.symlink_metadata().is_ok());
        if let (Some(proof), Permission::None) = (proof, permission) {
            exists(proof, "validated.proof");
        }
        if let Some(proof) = proof.filter(|proof| !super::proof::may_replace(proof)) {
            return Err(Failure::BadInput(format!(
                "{} is no proof, and only proofs are replaced\n  help: move it away, or choose another place with --set validated.proof=..",
                proof.display()
            )));
        }
        let same =
            |a: &Path, b: &Path| a.canonicalize().is_ok_and(|a| b.canonicalize().is_ok_and(|b| a == b));
        if same(&job.output, &job.config_file) {
            return Err(Failure::BadInput(format!(
                "{name} is the configuration itself\n  help: choose another place with --set output.path=.."
            )));
        }
        // The folders that the path names are created, and then `..` would lead out of them to who knows what.
        let leads_back = |path: &Path| path.components().any(|part| part == Component::ParentDir);
        if let Some(folder) =
            job.output.parent().filter(|folder| leads_back(folder) && folder.metadata().is_err())
        {
            return Err(Failure::BadInput(format!(
                "{name}: the folder {} does not exist, and is not created because of the `..` in its path\n  \
                 help: write the path without `..`, or create the folder",
                folder.display()
            )));
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
        let folder = first_folder(&job.output);
        // The only sure way to know whether one may write somewhere is to try; the file has no name.
        tempfile::tempfile_in(&folder).map_err(|error| {
            Failure::BadInput(format!(
                "{name}: cannot write into the folder {}: {error}\n  help: choose another place with --set output.path=..",
                folder.display()
            ))
        })?;
        let free = fs4::available_space(&folder).ok();
        Ok(Self { replaces, refuses, free })
    }

    /// Refuses a map for which its disk has no room, and warns where the run may fill it. `packed` is the estimated size
    /// of the map.
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
        // The estimate may be too large by a factor, hardly by two.
        if packed <= u128::from(free) {
            say(&format!("warning: the run needs {need}; should the disk fill, it stops and can be resumed"));
            return Ok(Ended::Fine);
        }
        let grid = &job.plan.grid;
        let sizes: Vec<String> =
            grid.axes().iter().map(|axis| format!("{} {}", axis.name, count(axis.values.len()))).collect();
        Err(Failure::BadInput(format!(
            "{}: the grid has {} cells ({}), {} before compression; the run needs {need}\n  \
             help: take fewer points on the longest axes or fewer output.fields, or choose another disk",
            job.config_file.display(),
            count(grid.cells()),
            sizes.join(" x "),
            bytes(job.plan.bytes()),
        )))
    }

    /// Whether the map might not fit, so that it is worth a sample to know.
    pub(super) fn is_scarce(&self, job: &Job) -> bool {
        self.free.is_some_and(|free| peak(job.plan.bytes()) > u128::from(free))
    }
}

/// What `--overwrite` will replace: a map, or nothing at all.
fn replaced(output: &Path, metadata: &std::fs::Metadata) -> Result<String, Failure> {
    let name = output.display();
    if metadata.is_symlink() {
        let target = std::fs::read_link(output).unwrap_or_default();
        return Ok(format!("the link {name} to {}, not what it leads to,", target.display()));
    }
    let mut first = Vec::new();
    let mut is_map = || {
        std::fs::File::open(output)
            .and_then(|file| file.take(store::SIGNATURE.len() as u64).read_to_end(&mut first))
            .is_ok_and(|_| first == store::SIGNATURE || first.is_empty())
    };
    // In this order: opening a pipe would wait for its other end.
    if !(metadata.is_file() && is_map()) {
        return Err(Failure::BadInput(format!(
            "{name} is no map, and only maps are replaced\n  help: move it away, or choose another place with --set output.path=.."
        )));
    }
    Ok(format!("{name} ({})", bytes(metadata.len().into())))
}

/// The folder of `output`, or the nearest above it that exists.
fn first_folder(output: &Path) -> PathBuf {
    let mut folder = output.parent();
    while let Some(path) = folder.filter(|path| !path.as_os_str().is_empty()) {
        // One that is there but does not answer is told so by whoever writes into it.
        if !path.symlink_metadata().is_err_and(|error| error.kind() == io::ErrorKind::NotFound) {
            return path.to_owned();
        }
        folder = path.parent();
    }
    PathBuf::from(".")
}

/// Creates the folders that the path of the output names.
pub(super) fn create_folders(output: &Path) -> Result<(), Failure> {
    match output.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => store::create_folders(folder).map_err(|error| {
            Failure::BadInput(format!(
                "the folder {} cannot be created: {error}\n  help: choose another place with --set output.path=..",
                folder.display()
            ))
        }),
        _ => Ok(()),
    }
}
