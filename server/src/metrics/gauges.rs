//! Gauges and counters that the rooms of the server set themselves, when their values change or
//! right before a rendering: connections, queues, memory, disk, readiness, and worker processes.

use std::time::Duration;

use ::metrics::{Key, Label, Recorder as _};
use bendtwin_store::{Kind, QueueDepth, UploadUse};
use jiff::Timestamp;

use super::{METADATA, Metrics};

impl Metrics {
    /// Open connections of a listener: `public` for clients, `workers` for workers.
    pub(crate) fn connections(&self, listener: &'static str, open: usize) {
        let label = Label::new("listener", listener);
        self.gauge("bendtwin_connections", vec![label], open as f64);
    }

    /// Counts a connection that was refused or ended by the server, with a word that says why.
    pub(crate) fn connection_ended(&self, listener: &'static str, why: &'static str) {
        let labels = vec![Label::new("listener", listener), Label::new("why", why)];
        self.count("bendtwin_connections_ended_total", labels);
    }

    /// End of the certificate of a listener [Unix time, s].
    pub(crate) fn certificate_end(&self, listener: &'static str, end: Timestamp) {
        let label = Label::new("listener", listener);
        let end = end.as_second() as f64;
        self.gauge("bendtwin_certificate_end_timestamp_seconds", vec![label], end);
    }

    /// Rollouts of a class of sizes that wait for a worker.
    pub(crate) fn rollouts_waiting(&self, class: &'static str, waiting: usize) {
        let label = Label::new("class", class);
        self.gauge("bendtwin_rollouts_waiting", vec![label], waiting as f64);
    }

    /// Memory that requests under way hold of the server's budget, and the whole budget [bytes].
    pub(crate) fn memory_budget(&self, used: u64, total: u64) {
        for (state, bytes) in [("used", used), ("total", total)] {
            let label = Label::new("state", state);
            self.gauge("bendtwin_memory_budget_bytes", vec![label], bytes as f64);
        }
    }

    /// Free and total space of the disk that holds the data folder [bytes].
    pub(crate) fn disk(&self, free: u64, total: u64) {
        for (state, bytes) in [("free", free), ("total", total)] {
            let label = Label::new("state", state);
            self.gauge("bendtwin_disk_bytes", vec![label], bytes as f64);
        }
    }

    /// Result of one check of readiness.
    pub(crate) fn ready(&self, check: &'static str, ok: bool) {
        let label = Label::new("check", check);
        self.gauge("bendtwin_ready", vec![label], f64::from(u8::from(ok)));
    }

    /// Program of the server.
    pub(crate) fn build(&self, version: &'static str, revision: &'static str) {
        let labels = vec![Label::new("version", version), Label::new("revision", revision)];
        self.gauge("bendtwin_build_info", labels, 1.0);
    }

    /// Numbers that were read from the database.
    pub(crate) fn stored(&self, depth: &QueueDepth, uploads: UploadUse) {
        use bendtwin_store::State::{Cancelled, Failed, Queued, Running, Succeeded};
        for (kind, jobs, oldest) in [
            (Kind::Ingest, "bendtwin_ingests", "bendtwin_oldest_queued_ingest_seconds"),
            (Kind::Fit, "bendtwin_fits", "bendtwin_oldest_queued_fit_seconds"),
        ] {
            for state in [Queued, Running, Succeeded, Failed, Cancelled] {
                let label = Label::new("state", state.as_str());
                self.gauge(jobs, vec![label], depth.count(kind, state) as f64);
            }
            self.gauge(oldest, Vec::new(), depth.oldest(kind).as_secs_f64());
        }
        self.gauge("bendtwin_uploads", Vec::new(), uploads.count as f64);
        self.gauge("bendtwin_uploads_bytes", Vec::new(), uploads.bytes as f64);
    }

    /// Whether the database answers, and the age of what was read from it.
    pub(crate) fn store_up(&self, is_up: bool, age: Option<Duration>) {
        self.gauge("bendtwin_store_up", Vec::new(), f64::from(u8::from(is_up)));
        if let Some(age) = age {
            self.gauge("bendtwin_store_age_seconds", Vec::new(), age.as_secs_f64());
        }
    }

    /// Counts a write to the store that failed because of the disk or the database; `reason` is
    /// the stable word of the error.
    pub(crate) fn write_failed(&self, reason: &'static str) {
        self.count("bendtwin_write_failures_total", vec![Label::new("reason", reason)]);
    }

    /// Counts a start of a worker process of the server's after one before it had ended.
    pub(crate) fn worker_restarted(&self, slot: u32) {
        let label = Label::new("slot", slot.to_string());
        self.count("bendtwin_worker_restarts_total", vec![label]);
    }

    pub(super) fn gauge(&self, name: &'static str, labels: Vec<Label>, value: f64) {
        debug_assert!(super::is_listed(name), "{name} is not in the catalog");
        self.recorder.register_gauge(&Key::from_parts(name, labels), &METADATA).set(value);
    }
}
