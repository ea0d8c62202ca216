//! The choice of the worker that answers: one that has the twin loaded if it has room, else the
//! first with room in the twin's own order of workers (rendezvous hashing), so
//! that a twin is loaded in few places and a lost worker moves only its own.
//! The work ahead is bounded by the average of all workers, so that one popular twin spreads.

use bendtwin_core::ids::{TwinId, WorkerId};

/// A worker as the choice sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) worker: WorkerId,
    /// Alive, as far as known, and not tried before.
    pub(super) usable: bool,
    pub(super) warm: bool,
    /// True if its line takes the rollout.
    pub(super) has_room: bool,
    /// Time that it needs for what is under way or waits [s].
    pub(super) ahead_s: f64,
}

/// Work ahead that is no reason to load a twin elsewhere [s].
const NEAR_S: f64 = 1.0;
/// Work ahead, in averages of all workers, up to which a rollout stays with its worker.
const FAIR: f64 = 1.25;

/// The outcome.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Choice {
    /// The candidate of this index.
    Worker(usize),
    /// All lines are full.
    AllFull,
    /// No worker is usable.
    NoneThere,
}

/// Chooses among candidates; the same inputs give the same choice.
pub(super) fn choose(twin: TwinId, candidates: &[Candidate]) -> Choice {
    let mut usable: Vec<(usize, &Candidate)> =
        candidates.iter().enumerate().filter(|(_, c)| c.usable).collect();
    if usable.is_empty() {
        return Choice::NoneThere;
    }
    usable.sort_by_key(|(_, c)| (!c.warm, std::cmp::Reverse(score(twin, c.worker))));
    let total: f64 = usable.iter().map(|(_, c)| c.ahead_s).sum();
    let fair = (FAIR * total / usable.len() as f64).max(NEAR_S);
    let free = || usable.iter().filter(|(_, c)| c.has_room);
    let first = free().find(|(_, c)| c.ahead_s <= fair);
    let least = || free().min_by(|(_, a), (_, b)| a.ahead_s.total_cmp(&b.ahead_s));
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
