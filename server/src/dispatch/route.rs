//! The choice of the worker that answers: one that has the twin loaded if it has room, else the
//! first with room in the twin's own order of workers (rendezvous hashing), so
//! that a twin is loaded in few places and a lost worker moves only its own.
//! Room is bounded by the average load, so that one popular twin spreads.

use bendtwin_core::ids::{TwinId, WorkerId};

/// A worker as the choice sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) worker: WorkerId,
    /// Alive, as far as known, and not tried before.
    pub(super) usable: bool,
    pub(super) warm: bool,
    /// Rollouts under way or waiting.
    pub(super) load: usize,
}

/// Number of rollouts that a worker takes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub(super) running: usize,
    pub(super) waiting: usize,
}

/// The outcome.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Choice {
    /// The candidate of this index.
    Worker(usize),
    /// All queues are full.
    AllFull,
    /// No worker is usable.
    NoneThere,
}

/// Chooses among candidates; the same inputs give the same choice.
pub(super) fn choose(twin: TwinId, candidates: &[Candidate], bounds: Bounds) -> Choice {
    let mut usable: Vec<(usize, &Candidate)> =
        candidates.iter().enumerate().filter(|(_, c)| c.usable).collect();
    if usable.is_empty() {
        return Choice::NoneThere;
    }
    usable.sort_by_key(|(_, c)| (!c.warm, std::cmp::Reverse(score(twin, c.worker))));
    let total: usize = usable.iter().map(|(_, c)| c.load).sum();
    // A quarter above the average, but never so little that a worker idles.
    let fair = ((total + 1) * 5).div_ceil(usable.len() * 4).max(bounds.running);
    let full = bounds.running + bounds.waiting;
    let first = usable.iter().find(|(_, c)| c.load < fair.min(full));
    let least = || usable.iter().filter(|(_, c)| c.load < full).min_by_key(|(_, c)| c.load);
    first.or_else(least).map_or(Choice::AllFull, |(i, _)| Choice::Worker(*i))
}

fn score(twin: TwinId, worker: WorkerId) -> [u8; 8] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(twin.uuid().as_bytes()).update(worker.uuid().as_bytes());
    let mut score = [0; 8];
    hasher.finalize_xof().fill(&mut score);
    score
}

#[cfg(test)]
mod tests;
