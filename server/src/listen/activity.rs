//! Requests of one connection, and whose turn it is: the server's, or the client's. A connection
//! that waits for its client may be closed, for its silence or to make place for others.

use std::{
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use tokio::{sync::Notify, time::Instant};

/// The requests of one connection.
#[derive(Debug)]
pub(super) struct Activity {
    counts: Mutex<Counts>,
    became_idle: Notify,
}

#[derive(Debug)]
struct Counts {
    /// Requests under way, by their [`Turn`].
    server: usize,
    body: usize,
    cut: usize,
    /// True once the head of a request has arrived.
    has_asked: bool,
    changed: Instant,
}

impl Counts {
    fn of(&mut self, turn: Turn) -> &mut usize {
        match turn {
            Turn::Server => &mut self.server,
            Turn::Body => &mut self.body,
            Turn::Cut => &mut self.cut,
        }
    }
}

/// The side that a request waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Turn {
    /// The server works on it or sends its response.
    Server,
    /// The client is to send more of the body.
    Body,
    /// The response was cut off, and the client has not noticed yet.
    Cut,
}

/// A request under way, from its head to the end of its response and its body.
#[derive(Debug)]
pub(super) struct Exchange {
    activity: Arc<Activity>,
    turn: Mutex<Turn>,
}

impl Activity {
    pub(super) fn new() -> Arc<Self> {
        let counts =
            Counts { server: 0, body: 0, cut: 0, has_asked: false, changed: Instant::now() };
        Arc::new(Self { counts: Mutex::new(counts), became_idle: Notify::new() })
    }

    /// Begins a request.
    pub(super) fn exchange(self: &Arc<Self>) -> Arc<Exchange> {
        let mut counts = self.counts();
        counts.server += 1;
        counts.has_asked = true;
        counts.changed = Instant::now();
        Arc::new(Exchange { activity: self.clone(), turn: Mutex::new(Turn::Server) })
    }

    /// The time since which the server waits for the client alone; none while it has to work.
    pub(super) fn quiet_since(&self) -> Option<Instant> {
        let counts = self.counts();
        (counts.server == 0).then_some(counts.changed)
    }

    /// Waits until no request has been under way for `first`, or for `later` after a request that
    /// ended well. Bodies of requests have their own time limits.
    pub(super) async fn idle_for(&self, first: Duration, later: Duration) {
        loop {
            let (is_idle, end) = {
                let counts = self.counts();
                let went_well = counts.has_asked && counts.cut == 0;
                let limit = if went_well { later } else { first };
                (counts.server + counts.body == 0, counts.changed + limit)
            };
            match is_idle {
                true if end <= Instant::now() => return,
                true => tokio::time::sleep_until(end).await,
                false => self.became_idle.notified().await,
            }
        }
    }

    fn counts(&self) -> MutexGuard<'_, Counts> {
        self.counts.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, from: Turn, to: Option<Turn>) {
        let mut counts = self.counts();
        let left = counts.of(from);
        *left = left.saturating_sub(1);
        if let Some(to) = to {
            *counts.of(to) += 1;
        }
        counts.changed = Instant::now();
        if counts.server + counts.body == 0 {
            self.became_idle.notify_one();
        }
    }
}

impl Exchange {
    /// Notes whose turn it is. A response that was cut off stays so.
    pub(super) fn set_turn(&self, turn: Turn) {
        let mut current = self.turn.lock().unwrap_or_else(PoisonError::into_inner);
        if *current != turn && *current != Turn::Cut {
            self.activity.change(*current, Some(turn));
            *current = turn;
        }
    }
}

impl Drop for Exchange {
    fn drop(&mut self) {
        let turn = *self.turn.get_mut().unwrap_or_else(PoisonError::into_inner);
        self.activity.change(turn, None);
    }
}
