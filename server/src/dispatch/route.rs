//! The choice of the worker that answers: a calm one if possible, first those that have the twin
//! loaded, then in the order of workers that the twin's hash gives (rendezvous hashing), so that a
//! twin is loaded in few places and a lost worker moves only its own twins. A worker is calm if it
//! runs no fit and few enough rollouts that one more need not wait. Without a calm worker, the one
//! with the fewest rollouts is asked; a fit counts as several. The work ahead is bounded by the
//! average of all workers, so that one popular twin spreads.

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
    /// Time that it needs for rollouts under way or waiting [s].
    pub(super) ahead_s: f64,
    /// Rollouts that are under way or wait.
    pub(super) calls: usize,
    pub(super) has_fit: bool,
}

impl Candidate {
    /// Rollouts, and a fit as the number of them that makes a worker busy.
    fn weight(&self) -> usize {
        self.calls + if self.has_fit { BUSY } else { 0 }
    }
}

/// Rollouts at a worker beyond which the next one goes elsewhere, even if the twin has to be loaded
/// there: one computes while another one's request or reply is on its way.
const BUSY: usize = 2;
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
    let near = || free().filter(|(_, c)| c.ahead_s <= fair);
    let calm = near().find(|(_, c)| c.weight() < BUSY);
    // The first of equals, which is in the order of above.
    let lightest = || near().min_by_key(|(_, c)| c.weight());
    let least = || free().min_by(|(_, a), (_, b)| a.ahead_s.total_cmp(&b.ahead_s));
    let chosen = calm.or_else(lightest).or_else(least);
    chosen.map_or(Choice::AllFull, |(i, _)| Choice::Worker(*i))
}

/// Workers that have nothing to do, in the order of [`choose`].
pub(super) fn idle(twin: TwinId, candidates: &[Candidate]) -> Vec<usize> {
    let idle = candidates.iter().enumerate();
    let mut idle: Vec<(usize, &Candidate)> =
        idle.filter(|(_, c)| c.usable && c.has_room && c.weight() == 0).collect();
    idle.sort_by_key(|(_, c)| (!c.warm, std::cmp::Reverse(score(twin, c.worker))));
    idle.into_iter().map(|(i, _)| i).collect()
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
