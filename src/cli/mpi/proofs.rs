//! Proofs of tiles of the universal surface by all ranks.
//!
//! Rank 0 selects the next boxes, and deals them to the ranks in proportion to their threads.

use mpi::traits::*;

use super::{END, PAUSE, PROVE, PROVED, Ranks, wait_for};
use crate::certify::validated::prover::{Prover, Threads};
use crate::certify::validated::tile::{GroupBox, Tile};

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
            let (numbers, _) = writer.receive_vec_with_tag::<f64>(PROVE);
            let domains = boxes_of(&numbers);
            let pool = crate::map::pool(Some(self.threads));
            // If no pool can be created, the global pool is used.
            let proofs = pool
                .map_or_else(|_| Threads.prove(&domains), |pool| pool.install(|| Threads.prove(&domains)));
            writer.send_with_tag(&numbers_of(&proofs)[..], PROVED);
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
            let numbers: Vec<f64> = part.iter().flat_map(|domain| domain.ranges()).flatten().collect();
            world.process_at_rank(rank).send_with_tag(&numbers[..], PROVE);
        }
        let mut proofs = Vec::with_capacity(domains.len());
        for (rank, part) in (1..).zip(&parts).filter(|(_, part)| !part.is_empty()) {
            let process = world.process_at_rank(rank);
            wait_for(&process, PROVED);
            let (numbers, _) = process.receive_vec_with_tag::<f64>(PROVED);
            proofs.extend(tiles_of(part, &numbers));
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

fn boxes_of(numbers: &[f64]) -> Vec<GroupBox> {
    let of = |[a0, a1, k0, k1, b0, b1]: [f64; 6]| GroupBox { a: [a0, a1], k: [k0, k1], b: [b0, b1] };
    numbers.as_chunks().0.iter().copied().map(of).collect()
}

/// Each proof as the count of its numbers, followed by the numbers; the count 0 where there is no proof.
fn numbers_of(proofs: &[Option<Tile>]) -> Vec<f64> {
    let of = |proof: &Option<Tile>| proof.as_ref().map_or(Vec::new(), Tile::numbers);
    proofs.iter().map(of).flat_map(|numbers| std::iter::once(numbers.len() as f64).chain(numbers)).collect()
}

/// The inverse of [`numbers_of`].
fn tiles_of(domains: &[GroupBox], mut numbers: &[f64]) -> Vec<Option<Tile>> {
    let mut next = |domain: &GroupBox| {
        let (&count, rest) = numbers.split_first()?;
        let (tile, rest) = rest.split_at_checked(count as usize)?;
        numbers = rest;
        Tile::of_numbers(*domain, tile)
    };
    domains.iter().map(&mut next).collect()
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

    #[test]
    fn messages_hold_every_tile_and_every_failure() {
        let domain = GroupBox { a: [0.1, 0.2], k: [0.2, 0.3], b: [0.0, 0.0] };
        let other = GroupBox { a: [0.2, 0.3], ..domain };
        assert_eq!(boxes_of(&[0.1, 0.2, 0.2, 0.3, 0.0, 0.0, 0.2, 0.3, 0.2, 0.3, 0.0, 0.0]), [domain, other]);
        let proofs = [Tile::prove(domain), None, Tile::prove(other)];
        assert!(proofs[0].is_some() && proofs[2].is_some());
        assert_eq!(tiles_of(&[domain, other, other], &numbers_of(&proofs)), proofs);
    }
}
