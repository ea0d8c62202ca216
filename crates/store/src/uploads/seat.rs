//! A single writer per upload, and a way to take an upload over. A broken connection may look alive
//! here for minutes, while its client has already returned and wants to resume. So the writer of an
//! upload learns that another waits for it, saves the bytes that have arrived and releases the
//! upload.

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, PoisonError, Weak},
    time::Duration,
};

use bendtwin_core::ids::UploadId;
use tokio::sync::{Mutex as AsyncMutex, OwnedMutexGuard, watch};

/// The uploads that have a writer or a waiting one.
#[derive(Debug, Default)]
pub(crate) struct Seats {
    seats: Mutex<HashMap<UploadId, Weak<Seat>>>,
}

#[derive(Debug)]
struct Seat {
    taken: Arc<AsyncMutex<()>>,
    /// Number of waiting writers.
    waiting: watch::Sender<usize>,
}

/// The right to write to an upload among the requests of this server; dropping it admits the next
/// writer.
#[derive(Debug)]
pub(crate) struct SeatGuard {
    _guard: OwnedMutexGuard<()>,
    seat: Arc<Seat>,
}

/// Counts as waiting while it lives.
struct WaitGuard<'a>(&'a Seat);

impl Seats {
    /// Asks the writer to release the upload, and waits up to that long for it.
    pub(crate) async fn take(&self, id: UploadId, patience: Duration) -> Option<SeatGuard> {
        let seat = self.seat(id);
        let guard = {
            let _waiting = WaitGuard::at(&seat);
            tokio::time::timeout(patience, seat.taken.clone().lock_owned()).await.ok()?
        };
        Some(SeatGuard { _guard: guard, seat })
    }

    /// Takes the upload if it has no writer.
    pub(crate) fn take_idle(&self, id: UploadId) -> Option<SeatGuard> {
        let seat = self.seat(id);
        let guard = seat.taken.clone().try_lock_owned().ok()?;
        Some(SeatGuard { _guard: guard, seat })
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

impl SeatGuard {
    /// Waits until another writer waits for the upload.
    pub(crate) fn wanted(&self) -> impl Future<Output = ()> + Send + use<> {
        let mut waiting = self.seat.waiting.subscribe();
        async move {
            // The sender lives as long as the seat: an error means that no writer can wait any
            // more.
            if waiting.wait_for(|n| *n > 0).await.is_err() {
                std::future::pending::<()>().await;
            }
        }
    }
}

impl<'a> WaitGuard<'a> {
    fn at(seat: &'a Seat) -> Self {
        seat.waiting.send_modify(|n| *n += 1);
        Self(seat)
    }
}

impl Drop for WaitGuard<'_> {
    fn drop(&mut self) {
        self.0.waiting.send_modify(|n| *n = n.saturating_sub(1));
    }
}
