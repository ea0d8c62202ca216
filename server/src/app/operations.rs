//! What operators ask for: readiness, which is whether a request that comes now can be served, and
//! metrics. Changes are made durable as a proof of readiness, which may take long on a bad disk, and
//! some metrics come from the database, which may be away: both are made beside requests, and callers
//! get the newest ones within a bounded time.

use std::time::Duration;

use bendtwin_store::{QueueDepth, UploadUse};
use serde::Serialize;

use super::{
    App, Error, Result,
    renewed::{Made, Renewed},
};
use crate::{dispatch::Size, metrics::Gauges};

/// Age up to which a report, or numbers of the database, are reused.
const FRESH: Duration = Duration::from_secs(1);
/// Longest wait for a new report.
const PATIENCE: Duration = Duration::from_secs(2);
/// Longest wait for numbers of the database.
const STORE_PATIENCE: Duration = Duration::from_secs(1);
/// Age of the numbers of the database up to which it counts as answering.
const ANSWERING: Duration = Duration::from_secs(3);
/// Age up to which an old report stands in for one that is slow to come.
const STALE: Duration = Duration::from_secs(10);

/// Names of all checks, in the order of the answer.
const CHECKS: [&str; 4] = ["running", "writes", "disk", "workers"];

/// A condition of readiness.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Check {
    /// running, writes, disk or workers
    pub(crate) name: &'static str,
    pub(crate) ok: bool,
    /// The state found, and what to do if it is not ok.
    pub(crate) message: String,
}

/// The newest report of what needed the disk.
pub(super) type Readiness = Renewed<Vec<Check>>;

/// The newest numbers that were read from the database.
pub(super) type StoredNumbers = Renewed<(QueueDepth, UploadUse)>;

impl App {
    /// Number of workers, and of rollouts in progress.
    pub(crate) fn counts(&self) -> (usize, usize) {
        self.dispatch.counts()
    }

    /// All metrics of the server, in the text format of Prometheus, within two seconds. While the
    /// database does not answer, what comes from it stays as it was read last.
    pub(crate) async fn metrics_text(&self) -> String {
        // Readiness sets its gauges and those of the disk.
        let (_, stored, usage) =
            tokio::join!(self.readiness(), self.stored_numbers(), self.recent_usage());
        let age = stored.as_ref().map(|stored| stored.at.elapsed());
        let answers = !self.stored_numbers.has_failed() && age.is_some_and(|age| age < ANSWERING);
        self.metrics.store_up(answers, age);
        if let Some(Made { value: (depth, uploads), .. }) = stored {
            self.metrics.stored(&depth, uploads);
        }
        for (size, waiting) in Size::ALL.into_iter().zip(self.dispatch.waiting()) {
            self.metrics.rollouts_waiting(size.as_str(), waiting);
        }
        let (workers, rollouts) = self.counts();
        let gauges = Gauges {
            workers,
            answering: self.dispatch.answering(),
            rollouts,
            sessions: self.dispatch.session_count(),
            plays: self.plays.count(),
            memory: self.dispatch.memory(),
            usage,
        };
        let (used, total) = self.memory.state();
        self.metrics.memory_budget(used, total);
        self.certificates.measure(&self.metrics);
        self.metrics.render(&gauges)
    }

    async fn stored_numbers(&self) -> Option<Made<(QueueDepth, UploadUse)>> {
        let make = || {
            let store = self.store.clone();
            async move {
                let read =
                    async { Ok((store.jobs().depth().await?, store.uploads().in_use().await?)) };
                let read: bendtwin_store::Result<_> = read.await;
                read.inspect_err(|error| tracing::warn!(%error, "metrics without the database"))
                    .ok()
            }
        };
        self.stored_numbers.get(FRESH, STORE_PATIENCE, make).await
    }

    /// All checks but those with these names, within two seconds.
    ///
    /// # Errors
    /// If there is no check of such a name.
    pub(crate) async fn readiness_without(&self, without: &[&str]) -> Result<Vec<Check>> {
        if let Some(unknown) = without.iter().find(|name| !CHECKS.contains(name)) {
            let unknown: String = unknown.chars().take(40).collect();
            let known = CHECKS.join(", ");
            let fault = format!("has `{unknown}`, which is not one of the checks {known}");
            return Err(Error::invalid("without", fault));
        }
        let mut checks = self.readiness().await;
        checks.retain(|check| !without.contains(&check.name));
        Ok(checks)
    }

    /// All checks, within two seconds.
    pub(crate) async fn readiness(&self) -> Vec<Check> {
        let make = || {
            let app = self.clone();
            async move { Some(vec![app.check_writes().await, app.check_disk()]) }
        };
        let report = self.readiness.get(FRESH, PATIENCE, make).await;
        let report = report.filter(|report| report.at.elapsed() < STALE);
        let mut checks = vec![self.check_running()];
        checks.extend(report.map_or_else(|| vec![unanswered()], |report| report.value));
        checks.push(self.check_workers());
        for check in &checks {
            self.metrics.ready(check.name, check.ok);
        }
        checks
    }

    fn check_running(&self) -> Check {
        let ok = !self.stopping.is_cancelled();
        let message = if ok { "the server runs" } else { "the server is stopping" };
        Check { name: "running", ok, message: message.to_owned() }
    }

    async fn check_writes(&self) -> Check {
        let (ok, message) = match self.store.probe_write().await {
            Ok(()) => (true, "the store writes".to_owned()),
            Err(error) => {
                self.write_failed(&error);
                (false, format!("the store cannot write: {error}"))
            }
        };
        Check { name: "writes", ok, message }
    }

    fn check_disk(&self) -> Check {
        let (ok, message) = match self.store.disk() {
            Err(error) => (false, format!("the free space of the disk is not known: {error}")),
            Ok(disk) => {
                self.metrics.disk(disk.free_bytes, disk.total_bytes);
                let (free, floor) = (disk.free_bytes >> 20, self.options.disk_floor_mib);
                if free >= floor {
                    (true, format!("{free} MiB are free"))
                } else {
                    let what = "new captures, twins and fits are refused";
                    let advice = "free space, or delete captures and twins";
                    (false, format!("{free} MiB are free, less than {floor}: {what}; {advice}"))
                }
            }
        };
        Check { name: "disk", ok, message }
    }

    fn check_workers(&self) -> Check {
        let (answering, known) = (self.dispatch.answering(), self.dispatch.counts().0);
        let message = match (answering, known, self.options.workers.count) {
            (1.., ..) => format!("{answering} of {known} workers answer"),
            (0, 1.., _) => format!("none of {known} workers answers: see their logs"),
            (0, 0, 0) => "there is no worker: start one with `bendtwin worker`, or set \
                          workers.count"
                .to_owned(),
            (0, 0, _) => "no worker has registered yet: if none does, see the log".to_owned(),
        };
        Check { name: "workers", ok: answering > 0, message }
    }
}

fn unanswered() -> Check {
    let message = format!(
        "the store has not proved for {} s that it can write: see the disk and the log",
        STALE.as_secs()
    );
    Check { name: "writes", ok: false, message }
}
