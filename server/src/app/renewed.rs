//! A value that takes a while to make, and that many callers ask for: made in a task beside their
//! requests, by one of them at a time, and shared. A caller gets the newest one within a bounded time,
//! however long the next one takes.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::Duration,
};

use tokio::{
    sync::watch,
    time::{Instant, timeout},
};

/// The newest value. Clones share it.
#[derive(Debug)]
pub(super) struct Renewed<T>(Arc<Inner<T>>);

#[derive(Debug)]
struct Inner<T> {
    latest: watch::Sender<Option<Made<T>>>,
    under_way: AtomicBool,
    /// True if the last attempt failed.
    failed: AtomicBool,
}

/// A value, and when it was made.
#[derive(Clone, Debug)]
pub(super) struct Made<T> {
    pub(super) value: T,
    pub(super) at: Instant,
}

impl<T> Clone for Renewed<T> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<T> Default for Renewed<T> {
    fn default() -> Self {
        let latest = watch::Sender::new(None);
        Self(Arc::new(Inner { latest, under_way: false.into(), failed: false.into() }))
    }
}

impl<T: Clone + Send + Sync + 'static> Renewed<T> {
    /// The newest value, however old it is. If it is older than `fresh` another one is made, which is
    /// waited for up to `patience`; `make` returns none if it fails.
    pub(super) async fn get<F>(
        &self,
        fresh: Duration,
        patience: Duration,
        make: impl FnOnce() -> F,
    ) -> Option<Made<T>>
    where
        F: Future<Output = Option<T>> + Send + 'static,
    {
        let is_fresh =
            |made: &Option<Made<T>>| made.as_ref().is_some_and(|made| made.at.elapsed() < fresh);
        let mut latest = self.0.latest.subscribe();
        if !is_fresh(&latest.borrow()) {
            self.renew(make);
            let _ = timeout(patience, latest.wait_for(is_fresh)).await;
        }
        latest.borrow().clone()
    }

    /// True if the last attempt to make one failed.
    pub(super) fn has_failed(&self) -> bool {
        self.0.failed.load(Ordering::SeqCst)
    }

    /// Makes a value in a separate task, unless one is being made.
    fn renew<F>(&self, make: impl FnOnce() -> F)
    where
        F: Future<Output = Option<T>> + Send + 'static,
    {
        if self.0.under_way.swap(true, Ordering::SeqCst) {
            return;
        }
        let (inner, making) = (Arc::clone(&self.0), make());
        tokio::spawn(async move {
            let _done = Done(&inner.under_way);
            let made = making.await;
            inner.failed.store(made.is_none(), Ordering::SeqCst);
            if let Some(value) = made {
                inner.latest.send_replace(Some(Made { value, at: Instant::now() }));
            }
        });
    }
}

/// Marks a value as made, also if making it panics.
struct Done<'a>(&'a AtomicBool);

impl Drop for Done<'_> {
    fn drop(&mut self) {
        self.0.store(false, Ordering::SeqCst);
    }
}
