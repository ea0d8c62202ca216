//! The order of the rollouts of one size that wait: deficit round robin. In every round a client
//! may start as much work as every other; an unused share is kept while it waits.

use std::{collections::VecDeque, sync::Arc};

use tokio::sync::oneshot;

/// A rollout that waits.
#[derive(Debug)]
pub(super) struct Waiting {
    pub(super) id: u64,
    pub(super) work: f64,
    /// Signalled at its turn.
    pub(super) wake: oneshot::Sender<()>,
}

/// The rollouts that wait, by client.
#[derive(Debug, Default)]
pub(super) struct Order {
    /// The clients in the order of their turns.
    clients: VecDeque<Client>,
}

#[derive(Debug)]
struct Client {
    name: Arc<str>,
    /// Work that it may start in this round.
    credit: f64,
    /// Oldest first; never empty.
    waiting: VecDeque<Waiting>,
}

impl Order {
    pub(super) fn push(&mut self, client: &Arc<str>, rollout: Waiting) {
        match self.clients.iter_mut().find(|c| c.name == *client) {
            Some(known) => known.waiting.push_back(rollout),
            None => self.clients.push_back(Client {
                name: client.clone(),
                credit: 0.0,
                waiting: [rollout].into(),
            }),
        }
    }

    /// The next rollout.
    pub(super) fn pop(&mut self) -> Option<Waiting> {
        let first_of = |c: &Client| c.waiting.front().map_or(0.0, |w| w.work);
        // With the largest of the next ones as a round's share, a round always starts one.
        let share = self.clients.iter().map(first_of).fold(0.0, f64::max);
        for _ in 0..=self.clients.len() {
            let client = self.clients.front_mut()?;
            let next = client.waiting.pop_front_if(|next| next.work <= client.credit);
            if let Some(next) = next {
                client.credit -= next.work;
                if client.waiting.is_empty() {
                    self.clients.pop_front();
                }
                return Some(next);
            }
            client.credit += share;
            self.clients.rotate_left(1);
        }
        None
    }

    /// Takes a rollout out.
    pub(super) fn remove(&mut self, id: u64) {
        for client in &mut self.clients {
            client.waiting.retain(|w| w.id != id);
        }
        self.clients.retain(|c| !c.waiting.is_empty());
    }

    pub(super) fn len(&self) -> usize {
        self.clients.iter().map(|c| c.waiting.len()).sum()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.clients.is_empty()
    }

    /// Rollouts of a client.
    pub(super) fn of_client(&self, name: &str) -> usize {
        self.clients.iter().find(|c| *c.name == *name).map_or(0, |c| c.waiting.len())
    }

    /// Work of all of them, in element substeps.
    pub(super) fn work(&self) -> f64 {
        self.clients.iter().flat_map(|c| &c.waiting).map(|w| w.work).sum()
    }
}
