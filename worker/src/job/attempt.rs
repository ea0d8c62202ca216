//! An attempt at a leased job, with the tasks that run beside its work.

use std::time::Duration;

use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;

use super::{
    LeasedJob,
    checkpoints::{self, Checkpoints, Saver},
    report::{self, LatestProgress},
    stop::Stop,
};

/// An attempt under way. The lease is renewed until it is dropped, which is to be after its end was
/// delivered.
pub(crate) struct Attempt<'a> {
    pub(crate) job: LeasedJob,
    pub(crate) stop: Stop,
    pub(crate) progress: LatestProgress,
    pub(crate) checkpoints: Checkpoints,
    /// Writes checkpoints; `None` once the last one was flushed.
    saver: Option<Saver>,
    /// Cancelled when the worker hands its jobs back.
    pub(super) drain: &'a CancellationToken,
    /// Time for which its end is delivered while no server can be reached.
    pub(super) delivery_timeout: Duration,
    /// The tasks that renew the lease and wait for the drain.
    tasks: [JoinHandle<()>; 2],
}

impl<'a> Attempt<'a> {
    pub(crate) fn begin(
        job: LeasedJob,
        drain: &'a CancellationToken,
        delivery_timeout: Duration,
    ) -> Self {
        let stop = Stop::default();
        let (progress, reporter) = report::start(job.clone(), stop.clone());
        let (checkpoints, saver) = checkpoints::start(job.clone(), stop.clone());
        let tasks = [reporter, stop.on_drain(drain)];
        let saver = Some(saver);
        Self { job, stop, progress, checkpoints, saver, drain, delivery_timeout, tasks }
    }

    /// Saves no more checkpoints: none is needed.
    pub(crate) fn drop_checkpoint(&self) {
        if let Some(saver) = &self.saver {
            saver.abort();
        }
    }

    /// Saves the checkpoint that waits, so that the next worker loses nothing, unless that takes too
    /// long.
    pub(crate) async fn save_last_checkpoint(&mut self) {
        if let Some(saver) = self.saver.take() {
            saver.flush().await;
        }
    }
}

impl Drop for Attempt<'_> {
    fn drop(&mut self) {
        self.drop_checkpoint();
        self.tasks.iter().for_each(JoinHandle::abort);
    }
}
