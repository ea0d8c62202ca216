//! What operators ask for: readiness, which is whether a request that comes now can be served, and
//! metrics. Changes are made durable as a proof of readiness, which may take long on a bad disk, so
//! the checks run beside requests, and callers get the newest report within a bounded time.

use std::{
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};

use serde::Serialize;
use tokio::{sync::watch, time::Instant};

use super::{App, Result};
use crate::{dispatch::Size, metrics::Gauges};

/// Age up to which a report is reused.
const FRESH: Duration = Duration::from_secs(1);
/// Longest wait for a new report.
const PATIENCE: Duration = Duration::from_secs(2);
/// Age up to which an old report stands in for one that is slow to come.
const STALE: Duration = Duration::from_secs(10);

/// A condition of readiness.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Check {
    /// running, writes, disk or workers
    pub(crate) name: &'static str,
    pub(crate) ok: bool,
    /// The state found, and what to do if it is not ok.
    pub(crate) message: String,
}

/// A report of what needed the disk.
#[derive(Clone, Debug)]
struct Report {
    made: Instant,
    checks: Vec<Check>,
}

/// The newest report.
#[derive(Debug)]
pub(crate) struct Readiness {
    latest: watch::Sender<Option<Report>>,
    under_way: AtomicBool,
}

impl Default for Readiness {
    fn default() -> Self {
        Self { latest: watch::Sender::new(None), under_way: AtomicBool::new(false) }
    }
}

impl App {
    /// Number of workers, and of rollouts in progress.
    pub(crate) fn counts(&self) -> (usize, usize) {
        self.dispatch.counts()
    }

    /// All metrics of the server, in the text format of Prometheus.
    pub(crate) async fn metrics_text(&self) -> Result<String> {
        // Sets the gauges of readiness and of the disk.
        self.readiness().await;
        let depth = self.store.jobs().depth().await?;
        let uploads = self.store.uploads().in_use().await?;
        let (workers, rollouts) = self.counts();
        for (size, waiting) in Size::ALL.into_iter().zip(self.dispatch.waiting()) {
            self.metrics.rollouts_waiting(size.as_str(), waiting);
        }
        let usage = self.recent_usage().await;
        let usage = usage.inspect_err(|error| tracing::warn!(%error, "no metrics by owner")).ok();
        let memory = self.dispatch.memory();
        let gauges = Gauges { workers, rollouts, memory, uploads, usage };
        let (used, total) = self.memory.state();
        self.metrics.memory_budget(used, total);
        self.certificates.measure(&self.metrics);
        Ok(self.metrics.render(&depth, &gauges))
    }

    /// All checks, within two seconds.
    pub(crate) async fn readiness(&self) -> Vec<Check> {
        let younger = |age: Duration| {
            move |report: &Option<Report>| report.as_ref().is_some_and(|r| r.made.elapsed() < age)
        };
        let mut reports = self.readiness.latest.subscribe();
        if !younger(FRESH)(&reports.borrow()) {
            self.renew_readiness();
            let renewed = tokio::time::timeout(PATIENCE, reports.wait_for(younger(FRESH))).await;
            if renewed.is_err() {
                tracing::warn!("the store is slow to prove that it can write");
            }
        }
        let report = reports.borrow().clone().filter(|r| younger(STALE)(&Some(r.clone())));
        let mut checks = vec![self.check_running()];
        checks.extend(report.map_or_else(|| vec![unanswered()], |report| report.checks));
        checks.push(self.check_workers());
        for check in &checks {
            self.metrics.ready(check.name, check.ok);
        }
        checks
    }

    /// Makes a report in a separate task, unless one is being made.
    fn renew_readiness(&self) {
        if self.readiness.under_way.swap(true, Ordering::SeqCst) {
            return;
        }
        let app = self.clone();
        tokio::spawn(async move {
            let _done = Done(&app.readiness.under_way);
            let checks = vec![app.check_writes().await, app.check_disk()];
            app.readiness.latest.send_replace(Some(Report { made: Instant::now(), checks }));
        });
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

/// Marks a report as made, also if making it panics.
struct Done<'a>(&'a AtomicBool);

impl Drop for Done<'_> {
    fn drop(&mut self) {
        self.0.store(false, Ordering::SeqCst);
    }
}

fn unanswered() -> Check {
    let message = format!(
        "the store has not proved for {} s that it can write: see the disk and the log",
        STALE.as_secs()
    );
    Check { name: "writes", ok: false, message }
}
