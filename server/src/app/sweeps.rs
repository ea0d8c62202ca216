//! The work that a server repeats by itself: leases end, uploads expire, unused content goes, the trash
//! is emptied, rules delete, uses of keys are recorded, sizes are filled in, and certificates are read
//! again.

use std::time::Duration;

use bendtwin_store::LeaseTerms;
use tokio::{
    task::JoinHandle,
    time::{Instant, Interval, MissedTickBehavior},
};

use super::App;
use crate::options::Options;

/// Longest interval between checks of leases.
const LEASE_INTERVAL: Duration = Duration::from_secs(1);
/// Longest interval at which expired uploads, and those that a crash left complete, are searched
/// for.
const UPLOAD_INTERVAL: Duration = Duration::from_secs(60);
/// Longest interval at which the trash is searched for what is due.
const TRASH_INTERVAL: Duration = Duration::from_secs(60);
/// Longest time from the start to the first application of rules of retention.
const FIRST_RETENTION: Duration = Duration::from_secs(60);
/// Interval at which the last uses of keys are recorded.
const KEY_USE_INTERVAL: Duration = Duration::from_secs(30);
/// Interval at which unused content is searched for, which the store also does when it opens, and rows
/// that lack sizes.
const GARBAGE_COLLECTION_INTERVAL: Duration = Duration::from_secs(3600);

/// The tasks.
#[derive(Debug)]
pub(crate) struct Sweeps([JoinHandle<()>; 7]);

impl Sweeps {
    pub(crate) fn start(app: &App) -> Self {
        app.certificates.watch(&app.stopping);
        Self([
            tokio::spawn(leases(app.clone())),
            tokio::spawn(uploads(app.clone())),
            tokio::spawn(key_uses(app.clone())),
            tokio::spawn(members(app.clone())),
            tokio::spawn(sizes(app.clone())),
            tokio::spawn(trash(app.clone())),
            tokio::spawn(retention(app.clone())),
        ])
    }

    pub(crate) fn stop(self) {
        self.0.iter().for_each(JoinHandle::abort);
    }
}

/// Ends leases that have run out, and forgets workers that fell silent. A tick that comes late
/// (the process stood still, or the store did) counts for little: workers could not report
/// meanwhile.
async fn leases(app: App) {
    let lease = app.options.lease();
    let every = (lease / 10).clamp(Duration::from_millis(20), LEASE_INTERVAL);
    let terms = LeaseTerms { lease, step: 2 * every };
    let mut tick = ticks(every);
    let mut collected = Instant::now();
    loop {
        tick.tick().await;
        if let Err(error) = app.sweep(terms).await {
            tracing::error!(%error, "sweeping failed; trying again");
        }
        if collected.elapsed() >= GARBAGE_COLLECTION_INTERVAL {
            collected = Instant::now();
            // Beside: a bucket takes its time, and leases do not wait.
            tokio::spawn(garbage(app.clone()));
        }
    }
}

/// Removes unused content, and sign-ins and shares that ended long ago.
async fn garbage(app: App) {
    if let Err(error) = app.forget_ended_keys().await {
        tracing::warn!(%error, "cannot remove sign-ins and shares that have ended; trying again");
    }
    if let Err(error) = app.store.collect_garbage().await {
        tracing::error!(%error, "cannot remove unused content; trying again");
    }
}

/// Finishes uploads that a crash left complete, and ends expired ones, immediately and then at
/// intervals.
async fn uploads(app: App) {
    let mut tick = ticks(upload_interval(&app.options));
    loop {
        tick.tick().await;
        if let Err(error) = app.sweep_uploads().await {
            tracing::error!(%error, "sweeping uploads failed; trying again");
        }
    }
}

/// Records when keys were used last.
async fn key_uses(app: App) {
    let mut tick = ticks(KEY_USE_INTERVAL);
    loop {
        tick.tick().await;
        if let Err(error) = app.keys.record_uses().await {
            tracing::warn!(%error, "cannot record the last uses of keys; trying again");
        }
    }
}

/// Takes over which workers are in the fleet, whenever that changes at any server. The sweep of leases
/// does so besides.
async fn members(app: App) {
    loop {
        app.store.members_changed().await;
        if let Err(error) = app.learn().await {
            tracing::error!(%error, "cannot read the workers of the fleet; trying again");
        }
    }
}

/// Fills in sizes that rows of older versions lack, immediately and then at intervals: servers of the
/// version before may run beside this one.
async fn sizes(app: App) {
    let mut tick = ticks(GARBAGE_COLLECTION_INTERVAL);
    loop {
        tick.tick().await;
        match app.store.settle_sizes().await {
            Ok(0) => {}
            Ok(rows) => tracing::info!(rows, "sizes of what is stored filled in"),
            Err(error) => tracing::error!(%error, "cannot fill in sizes; trying again"),
        }
    }
}

/// Purges what is due in the trash, at intervals and when the disk is short of space.
async fn trash(app: App) {
    // One where everything goes for good may have something from before.
    let kept = app.options.trash();
    let every = if kept.is_zero() { TRASH_INTERVAL } else { TRASH_INTERVAL.min(kept) };
    let mut tick = ticks(every.max(Duration::from_millis(100)));
    loop {
        tokio::select! {
            _ = tick.tick() => {}
            () = app.room_wanted() => {}
        }
        if let Err(error) = app.sweep_trash().await {
            tracing::error!(%error, "cannot purge the trash; trying again");
        }
    }
}

/// Applies the rules of retention.
async fn retention(app: App) {
    let every = app.options.retention_interval();
    // Not immediately: an administrator who made a mistake in a rule has a moment to notice.
    let mut tick = tokio::time::interval_at(Instant::now() + every.min(FIRST_RETENTION), every);
    tick.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        tick.tick().await;
        if let Err(error) = app.sweep_retention().await {
            tracing::error!(%error, "cannot apply the rules of retention; trying again");
        }
    }
}

fn upload_interval(options: &Options) -> Duration {
    UPLOAD_INTERVAL.min(options.upload_expiry()).min(options.upload_start())
}

/// Ticks immediately and then at this interval.
fn ticks(every: Duration) -> Interval {
    let mut ticks = tokio::time::interval(every);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    ticks
}
