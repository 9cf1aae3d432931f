//! Proofs of tiles of the universal surface by all ranks.
//!
//! Rank 0 selects the next boxes, and deals them to the ranks in proportion to their threads.

use mpi::traits::*;

use super::{END, PAUSE, PROVE, PROVED, Ranks, receive, send, wait_for};
use slipmap_certify::validated::prover::{Prover, Threads};
use slipmap_certify::validated::tile::{GroupBox, Tile};

impl Ranks {
    /// On the other ranks, when their tiles of the map are done: proves tiles in the boxes that rank 0 sends,
    /// until the run ends.
    pub(super) fn prove_for_writer(&self) {
        let world = self.universe.world();
        let writer = world.process_at_rank(0);
        // The message [`END`] is received when MPI is left.
        while writer.immediate_probe_with_tag(END).is_none() {
            if writer.immediate_probe_with_tag(PROVE).is_none() {
                std::thread::sleep(PAUSE);
                continue;
            }
            let domains: Vec<GroupBox> = receive(&writer, PROVE).unwrap_or_default();
            let pool = crate::map::pool(Some(self.threads));
            // If no pool can be created, the global pool is used.
            let proofs = pool
                .map_or_else(|_| Threads.prove(&domains), |pool| pool.install(|| Threads.prove(&domains)));
            send(&writer, PROVED, &proofs);
        }
    }
}

/// The other ranks.
impl Prover for Ranks {
    fn workers(&self) -> usize {
        self.others().iter().map(|other| other.threads).sum()
    }

    fn prove(&self, domains: &[GroupBox]) -> Vec<Option<Tile>> {
        let world = self.universe.world();
        let threads: Vec<usize> = self.others().iter().map(|other| other.threads).collect();
        let parts = dealt(domains, &threads);
        for (rank, part) in (1..).zip(&parts).filter(|(_, part)| !part.is_empty()) {
            send(&world.process_at_rank(rank), PROVE, part);
        }
        let mut proofs = Vec::with_capacity(domains.len());
        for (rank, part) in (1..).zip(&parts).filter(|(_, part)| !part.is_empty()) {
            let process = world.process_at_rank(rank);
            wait_for(&process, PROVED);
            let proved = receive(&process, PROVED).unwrap_or_else(|| vec![None; part.len()]);
            proofs.extend(proved);
        }
        proofs
    }
}

/// Consecutive parts of `all`, in proportion to the numbers of threads.
fn dealt<'a, T>(all: &'a [T], threads: &[usize]) -> Vec<&'a [T]> {
    let sum: usize = threads.iter().sum();
    let mut ends = threads.iter().scan(0, |before, threads| {
        *before += threads;
        Some(all.len() * *before / sum.max(1))
    });
    let mut from = 0;
    ends.by_ref()
        .map(|to| {
            let part = &all[from..to];
            from = to;
            part
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_dealt_by_threads_and_come_back_in_order() {
        let all: Vec<usize> = (0..10).collect();
        let parts = dealt(&all, &[1, 3, 1]);
        assert_eq!(parts, [&[0, 1][..], &[2, 3, 4, 5, 6, 7], &[8, 9]]);
        assert_eq!(parts.concat(), all);
        assert_eq!(dealt(&all[..1], &[1, 1]).concat(), [0]);
    }
}
