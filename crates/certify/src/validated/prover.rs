//! The workers that prove the tiles of a surface: threads of this process, or other processes.

use rayon::prelude::*;

use super::tile::{GroupBox, Tile};

/// Workers that prove tiles.
pub trait Prover {
    /// Number of tiles that are proved at the same time.
    fn workers(&self) -> usize;

    /// [`Tile::prove`] for each box, in the order of `domains`.
    fn prove(&self, domains: &[GroupBox]) -> Vec<Option<Tile>>;
}

/// The threads of the current pool.
#[derive(Clone, Copy, Debug)]
pub struct Threads;

impl Prover for Threads {
    fn workers(&self) -> usize {
        rayon::current_num_threads()
    }

    fn prove(&self, domains: &[GroupBox]) -> Vec<Option<Tile>> {
        domains.par_iter().map(|domain| Tile::prove(*domain)).collect()
    }
}
