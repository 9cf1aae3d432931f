//! Computes one map with many processes, on one or several machines (feature `mpi`).
//!
//! Rank 0 owns the journal and the map, distributes tiles, and computes as well. Every other rank computes
//! and packs tiles and sends them to rank 0, which answers each with the number of another tile, so that fast
//! ranks get more. Every rank has a few tiles in advance, which hides the latency of messages. Then all ranks
//! share the proofs over the whole box ([`proofs`]). The file is the same as that of a single process, and a
//! run can be resumed by any number of ranks, or without MPI.
//!
//! All messages are sent by the main thread of each process (`MPI_THREAD_FUNNELED`).

mod proofs;

use std::cell::OnceCell;
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use mpi::Threading;
use mpi::environment::Universe;
use mpi::topology::Process;
use mpi::traits::*;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{Ended, Failure};
use crate::config::Job;
use crate::map::{self, Account, ComputeError, Control, Queue, Sink as _};
use crate::store::{ByteSink, PartialMap, StoreError, from_bytes, plan_digest, to_bytes};

/// Message of a rank at its start, a [`Hello`].
const HELLO: i32 = 1;
/// Answer of rank 0, [`Tiles`]: the first ones; `None` if the run does not begin.
const GO: i32 = 2;
/// Message with a finished tile.
const TILE: i32 = 3;
/// Answer of rank 0 to each [`TILE`], [`Tiles`]: further ones, perhaps none yet; `None` if no more will come.
const NEXT: i32 = 4;
/// Message of a rank that has finished all its tiles: whether it was interrupted.
const BYE: i32 = 5;

/// Message of rank 0: the map is finished, and the other ranks may end.
const END: i32 = 6;
/// Message of rank 0 with the boxes in which tiles are to be proved.
const PROVE: i32 = 7;
/// Answer to [`PROVE`]: the proved tiles.
const PROVED: i32 = 8;

/// Interval of polling for messages. MPI's own blocking calls would keep a core busy, and more frequent
/// polling takes time from the threads that compute. Every rank has enough tiles in advance to bridge it.
const PAUSE: Duration = Duration::from_millis(2);

/// Fingerprint of a rank's plan and its number of threads, or the error of its job.
type Hello = Result<(String, usize), String>;

/// Numbers of tiles to compute.
type Tiles = Option<Vec<usize>>;

fn send(process: &Process, tag: i32, value: &impl Serialize) {
    process.send_with_tag(&to_bytes(value)[..], tag);
}

/// Waits for a message; `None` if it was corrupted on its way, or is one of another version.
fn receive<T: DeserializeOwned>(process: &Process, tag: i32) -> Option<T> {
    from_bytes(&process.receive_vec_with_tag::<u8>(tag).0)
}

/// Waits for a message of `process` with this tag.
fn wait_for(process: &Process, tag: i32) {
    while process.immediate_probe_with_tag(tag).is_none() {
        std::thread::sleep(PAUSE);
    }
}

/// The processes of a run.
pub(super) struct Ranks {
    universe: Universe,
    threads: usize,
    /// On rank 0, once the run has begun: the other ranks.
    others: OnceCell<Vec<Other>>,
}

/// Another rank, as rank 0 sees it.
struct Other {
    threads: usize,
    /// Number of tiles that it was given at the start.
    first_tiles: usize,
}

/// Rank 0 always sends [`END`]. The other ranks wait for that message, because the end of MPI waits for every
/// rank in a busy loop.
impl Drop for Ranks {
    fn drop(&mut self) {
        let world = self.universe.world();
        if self.is_writer() {
            (1..world.size()).for_each(|rank| world.process_at_rank(rank).send_with_tag(&[0_u8; 0][..], END));
        } else {
            let writer = world.process_at_rank(0);
            while writer.immediate_probe_with_tag(END).is_none() {
                std::thread::sleep(Duration::from_millis(5));
            }
            let _ = writer.receive_vec_with_tag::<u8>(END);
        }
    }
}

impl Ranks {
    /// Initialises MPI; this rank computes with `threads` threads, or with one per core.
    pub(super) fn join(threads: Option<usize>) -> Result<Self, Failure> {
        let threads = threads.unwrap_or_else(rayon::current_num_threads).max(1);
        match mpi::initialize_with_threading(Threading::Funneled) {
            Some((universe, threading)) if threading >= Threading::Funneled => {
                Ok(Self { universe, threads, others: OnceCell::new() })
            }
            _ => Err(Failure::Broken("this MPI library cannot be used by programs with threads".into())),
        }
    }

    pub(super) fn count(&self) -> usize {
        usize::try_from(self.universe.world().size()).unwrap_or(1)
    }

    /// The other ranks, once the run has begun.
    fn others(&self) -> &[Other] {
        self.others.get().map_or(&[], Vec::as_slice)
    }

    /// Returns whether this is rank 0, which writes the map.
    pub(super) fn is_writer(&self) -> bool {
        self.universe.world().rank() == 0
    }

    /// On the other ranks: computes the tiles that rank 0 hands out.
    pub(super) fn work(&self, job: Result<Job, Failure>, stop: &AtomicBool) -> Result<Ended, Failure> {
        let hello: Hello = match &job {
            Ok(job) => Ok((plan_digest(&job.plan), self.threads)),
            Err(Failure::BadInput(message) | Failure::Broken(message)) => Err(message.clone()),
            Err(_) => Err("it cannot read its configuration".into()),
        };
        let world = self.universe.world();
        let writer = world.process_at_rank(0);
        send(&writer, HELLO, &hello);
        let first = receive::<Tiles>(&writer, GO).flatten();
        // Rank 0 reports the error, once.
        let (Ok(job), Some(first)) = (job, first) else { return Ok(Ended::Fine) };

        let (more, tiles) = channel();
        // A rank that gets no tile now gets none later.
        let more = (!first.is_empty()).then_some(more);
        more.iter().for_each(|more| hand_on(&first, more));
        let tiles = Mutex::new(tiles);
        // Rank 0 bounds the number of tiles in this channel; the receiver lives as long as any sender.
        let (outbox, finished) = channel();
        let sink = ByteSink::new(&job.plan, move |bytes| drop(outbox.send(bytes)));
        let control = Control { threads: Some(self.threads), stop, ..Control::default() };
        std::thread::scope(|scope| {
            let (job, tiles) = (&job, &tiles);
            scope.spawn(move || {
                let next = || tiles.lock().unwrap_or_else(PoisonError::into_inner).recv().ok();
                // Rank 0 reports an interruption; there are no other errors here.
                let _ = map::compute_tiles(&job.plan, &sink, &control, &next);
            });
            self.send_all(&finished, more, stop);
        });
        send(&writer, BYE, &stop.load(Ordering::Relaxed));
        self.prove_for_writer();
        Ok(Ended::Fine)
    }

    /// Sends finished tiles to rank 0 and passes new ones to the workers.
    ///
    /// `more` is dropped when no more tiles will come, which ends the workers that wait for one.
    fn send_all(&self, finished: &Receiver<Vec<u8>>, mut more: Option<Sender<usize>>, stop: &AtomicBool) {
        let world = self.universe.world();
        let writer = world.process_at_rank(0);
        loop {
            if stop.load(Ordering::Relaxed) {
                more = None;
            }
            let first = match finished.recv_timeout(Duration::from_millis(100)) {
                Ok(bytes) => bytes,
                Err(RecvTimeoutError::Timeout) => continue,
                Err(RecvTimeoutError::Disconnected) => break,
            };
            // Tiles that are finished together go together: every message wakes up both ranks.
            std::thread::sleep(PAUSE);
            let tiles: Vec<Vec<u8>> = std::iter::once(first).chain(finished.try_iter()).collect();
            send_without_busy_loop(&writer, &tiles);
            for _ in &tiles {
                wait_for(&writer, NEXT);
                match (receive::<Tiles>(&writer, NEXT).flatten(), &more) {
                    (Some(tiles), Some(more)) => hand_on(&tiles, more),
                    _ => more = None,
                }
            }
        }
    }

    /// On rank 0: waits for the other ranks and starts them, or dismisses them if there is no plan. Returns
    /// the total number of threads of the other ranks.
    pub(super) fn begin(&self, plan: Option<(&map::Plan, &Queue)>) -> Result<usize, Failure> {
        let world = self.universe.world();
        let mut threads = vec![0; self.count()];
        let mut wrong = None;
        let digest = plan.map(|(plan, _)| plan_digest(plan));
        for (rank, threads) in (0..).zip(&mut threads).skip(1) {
            let problem = match receive::<Hello>(&world.process_at_rank(rank), HELLO) {
                Some(Ok((theirs, count))) if digest.as_ref().is_none_or(|digest| *digest == theirs) => {
                    *threads = count;
                    continue;
                }
                Some(Err(message)) => format!("rank {rank}: {message}"),
                Some(Ok(_)) | None => format!(
                    "rank {rank} would compute another map: its configuration or its version of slipmap is not \
                     that of rank 0\n  help: give all ranks the same files"
                ),
            };
            wrong.get_or_insert(problem);
        }
        let plan = plan.filter(|_| wrong.is_none());
        let first = match plan {
            Some((_, queue)) => first_tiles(queue, self.threads, &threads[1..]),
            None => vec![Vec::new(); threads.len() - 1],
        };
        for (rank, tiles) in (1..).zip(&first) {
            send(&world.process_at_rank(rank), GO, &plan.map(|_| tiles));
        }
        match wrong {
            Some(message) => Err(Failure::BadInput(message)),
            None => {
                let other =
                    |(&threads, tiles): (&usize, &Vec<usize>)| Other { threads, first_tiles: tiles.len() };
                let others = self.others.get_or_init(|| threads[1..].iter().zip(&first).map(other).collect());
                Ok(others.iter().map(|other| other.threads).sum())
            }
        }
    }

    /// On rank 0: serves the other ranks while `local` computes here. Returns the sum of all accounts.
    pub(super) fn serve(
        &self,
        map: &PartialMap,
        queue: &Queue,
        stop: &AtomicBool,
        on_cells: &(dyn Fn(usize) + Sync),
        local: impl FnOnce() -> Result<(Account, usize), ComputeError<StoreError>> + Send,
    ) -> Result<(Account, usize), ComputeError<StoreError>> {
        std::thread::scope(|scope| {
            let local = scope.spawn(local);
            let served = self.serve_others(map, queue, stop, on_cells);
            let local = match local.join() {
                Ok(done) => done,
                Err(panic) => std::panic::resume_unwind(panic),
            };
            let (mut account, threads) = local?;
            account.add(served?);
            Ok((account, threads))
        })
    }

    fn serve_others(
        &self,
        map: &PartialMap,
        queue: &Queue,
        stop: &AtomicBool,
        on_cells: &(dyn Fn(usize) + Sync),
    ) -> Result<Account, ComputeError<StoreError>> {
        let world = self.universe.world();
        let mut sum = Account::none(map.plan());
        let mut outcome = Ok(());
        let others = self.others();
        // Number of tiles that each rank has.
        let mut theirs: Vec<usize> = others.iter().map(|other| other.first_tiles).collect();
        let all_threads = self.threads + others.iter().map(|other| other.threads).sum::<usize>();
        let mut at_work = others.len();
        while at_work > 0 {
            let Some(message) = world.any_process().immediate_matched_probe() else {
                std::thread::sleep(PAUSE);
                continue;
            };
            let (bytes, status) = message.matched_receive_vec::<u8>();
            if status.tag() == BYE {
                at_work -= 1;
                if from_bytes(&bytes) != Some(false) && outcome.is_ok() {
                    outcome = Err(ComputeError::Interrupted);
                }
                continue;
            }
            // Send the next tiles first: the other rank waits for them.
            let rank = status.source_rank() as usize - 1;
            theirs[rank] -= 1;
            let mut next: Tiles = None;
            if outcome.is_ok() && !stop.load(Ordering::Relaxed) && queue.left() > 0 {
                let wanted =
                    ahead(queue.left(), all_threads, others[rank].threads).saturating_sub(theirs[rank]);
                let tiles: Vec<usize> = std::iter::from_fn(|| queue.take()).take(wanted).collect();
                theirs[rank] += tiles.len();
                next = Some(tiles);
            }
            send(&world.process_at_rank(status.source_rank()), NEXT, &next);
            if outcome.is_err() {
                continue;
            }
            match map.packer().from_bytes(&bytes) {
                Some((packed, account)) => match map.write(packed, &account) {
                    Ok(()) => {
                        on_cells(usize::try_from(account.cells).unwrap_or(0));
                        sum.add(account);
                    }
                    Err(error) => outcome = Err(ComputeError::Sink(error)),
                },
                // The plans have equal fingerprints, so the message was corrupted on its way.
                None => outcome = Err(ComputeError::Interrupted),
            }
        }
        outcome.map(|()| sum)
    }
}

/// Passes the numbers of tiles to the workers of this rank, which wait as long as there is a sender.
fn hand_on(tiles: &[usize], more: &Sender<usize>) {
    for &tile in tiles {
        let _ = more.send(tile);
    }
}

/// Sends tiles to rank 0. MPI's own sending keeps a core busy until the receiver has taken a long message.
fn send_without_busy_loop(writer: &Process, tiles: &[Vec<u8>]) {
    mpi::request::scope(|scope| {
        let mut under_way: Vec<_> =
            tiles.iter().map(|tile| writer.immediate_send_with_tag(scope, &tile[..], TILE)).collect();
        loop {
            under_way = under_way.into_iter().filter_map(|request| request.test().err()).collect();
            if under_way.is_empty() {
                break;
            }
            std::thread::sleep(PAUSE);
        }
    });
}

/// Number of tiles that a rank with `threads` threads has in advance: many of the short tiles of a large
/// grid, which saves messages; few towards the end, so that all ranks finish together.
fn ahead(left: usize, all_threads: usize, threads: usize) -> usize {
    threads * (left / (8 * all_threads)).clamp(2, 32) + 2
}

/// The first tiles of the other ranks. They are dealt one by one in turn, so that few tiles are shared
/// fairly, until every rank has two for each thread and two more, or until only the tiles that rank 0
/// computes itself are left.
fn first_tiles(queue: &Queue, own_threads: usize, threads: &[usize]) -> Vec<Vec<usize>> {
    let mut dealt = vec![Vec::new(); threads.len()];
    let first = |threads: usize| ahead(0, 1, threads);
    let most = threads.iter().max().map_or(0, |&threads| first(threads));
    for round in 0..most {
        for (tiles, &threads) in dealt.iter_mut().zip(threads) {
            // Rank 0 gets a tile in every round as well.
            let reserved = (round + 1).min(first(own_threads));
            if round < first(threads)
                && queue.left() > reserved
                && let Some(tile) = queue.take()
            {
                tiles.push(tile);
            }
        }
    }
    dealt
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_tiles_are_dealt_fairly() {
        let dealt_of = |tiles: usize| {
            let queue = Queue::new(vec![false; tiles]);
            let others = first_tiles(&queue, 1, &[1, 1, 1]);
            let mut shares = vec![std::iter::from_fn(|| queue.take()).count()];
            shares.extend(others.iter().map(Vec::len));
            shares
        };
        assert_eq!(dealt_of(4), [1, 1, 1, 1]);
        assert_eq!(dealt_of(8), [2, 2, 2, 2]);
        assert_eq!(dealt_of(1), [1, 0, 0, 0]);
        assert_eq!(dealt_of(100), [88, 4, 4, 4]);
    }
}
