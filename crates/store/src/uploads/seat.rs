//! One writer per upload, and the way to take an upload over. A connection that
//! broke may look alive here for minutes, while its client is back already and
//! wants to go on: so whoever holds an upload learns that another waits for it,
//! saves what has arrived and makes room.

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, PoisonError, Weak},
    time::Duration,
};

use bendtwin_core::ids::UploadId;
use tokio::sync::{Mutex as AsyncMutex, OwnedMutexGuard, watch};

/// The seats of all uploads that somebody holds or waits for.
#[derive(Debug, Default)]
pub(crate) struct Seats {
    seats: Mutex<HashMap<UploadId, Weak<Seat>>>,
}

#[derive(Debug)]
struct Seat {
    taken: Arc<AsyncMutex<()>>,
    /// How many wait for it.
    waiting: watch::Sender<usize>,
}

/// An upload held; dropping it lets the next one in.
#[derive(Debug)]
pub(crate) struct Held {
    _guard: OwnedMutexGuard<()>,
    seat: Arc<Seat>,
}

/// Counts as waiting while it lives.
struct Waiting<'a>(&'a Seat);

impl Seats {
    /// Asks whoever holds the upload to make room, and waits that long for it.
    pub(crate) async fn take(&self, id: UploadId, patience: Duration) -> Option<Held> {
        let seat = self.seat(id);
        let guard = {
            let _waiting = Waiting::at(&seat);
            tokio::time::timeout(patience, seat.taken.clone().lock_owned()).await.ok()?
        };
        Some(Held { _guard: guard, seat })
    }

    /// Takes the upload if nobody holds it.
    pub(crate) fn take_idle(&self, id: UploadId) -> Option<Held> {
        let seat = self.seat(id);
        let guard = seat.taken.clone().try_lock_owned().ok()?;
        Some(Held { _guard: guard, seat })
    }

    fn seat(&self, id: UploadId) -> Arc<Seat> {
        let mut seats = self.seats.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(seat) = seats.get(&id).and_then(Weak::upgrade) {
            return seat;
        }
        seats.retain(|_, seat| seat.strong_count() > 0);
        let seat = Arc::new(Seat { taken: Arc::default(), waiting: watch::Sender::new(0) });
        seats.insert(id, Arc::downgrade(&seat));
        seat
    }
}

impl Held {
    /// Waits until another waits for the upload.
    pub(crate) fn wanted(&self) -> impl Future<Output = ()> + Send + use<> {
        let mut waiting = self.seat.waiting.subscribe();
        async move {
            // The sender lives as long as the seat: an error means that nobody can want it any more.
            if waiting.wait_for(|n| *n > 0).await.is_err() {
                std::future::pending::<()>().await;
            }
        }
    }
}

impl<'a> Waiting<'a> {
    fn at(seat: &'a Seat) -> Self {
        seat.waiting.send_modify(|n| *n += 1);
        Self(seat)
    }
}

impl Drop for Waiting<'_> {
    fn drop(&mut self) {
        self.0.waiting.send_modify(|n| *n = n.saturating_sub(1));
    }
}
