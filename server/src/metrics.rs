//! Prometheus metrics of one server. They belong to the server, not to the process, so that several
//! servers in one test do not add up.

mod catalog;
mod gauges;
mod owners;
mod process;

use std::{fmt, sync::Arc, time::Duration};

use ::metrics::{Key, Label, Level, Metadata, Recorder as _};
use bendtwin_store::{Call, Kind, Observer, OwnerUsage, Part};
use metrics_exporter_prometheus::{
    BuildError, Matcher, PrometheusBuilder, PrometheusHandle, PrometheusRecorder,
};

use crate::dispatch::Memory;

const SECONDS: [f64; 14] =
    [0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 1.0, 5.0, 30.0, 300.0, 3600.0];

/// Revision of the source, which a build may name.
const REVISION: Option<&str> = option_env!("BENDTWIN_REVISION");

static METADATA: Metadata<'static> = Metadata::new("bendtwin_server", Level::INFO, None);

/// Values of the gauges at the moment of a rendering.
pub(crate) struct Gauges {
    pub(crate) workers: usize,
    /// Workers that lately gave a sign of life.
    pub(crate) answering: usize,
    /// Rollouts under way or waiting.
    pub(crate) rollouts: usize,
    pub(crate) sessions: usize,
    pub(crate) plays: usize,
    /// Sum over the devices of all workers: workers come and go under ever new names.
    pub(crate) memory: Memory,
    /// Usage of all owners; none if it is not known.
    pub(crate) usage: Option<Arc<[OwnerUsage]>>,
}

/// The metrics. Clones share them.
#[derive(Clone)]
pub(crate) struct Metrics {
    recorder: Arc<PrometheusRecorder>,
    handle: PrometheusHandle,
}

impl fmt::Debug for Metrics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Metrics").finish_non_exhaustive()
    }
}

impl Metrics {
    pub(crate) fn new() -> Self {
        let builder = with_buckets().unwrap_or_else(|error| {
            tracing::error!(%error, "histograms have no buckets");
            PrometheusBuilder::new()
        });
        let recorder = builder.build_recorder();
        for (name, help) in catalog::CATALOG {
            recorder.describe_gauge(name.into(), None, help.into());
        }
        let metrics = Self { handle: recorder.handle(), recorder: Arc::new(recorder) };
        metrics.build(env!("CARGO_PKG_VERSION"), REVISION.unwrap_or("unknown"));
        metrics.begin_at_zero();
        metrics
    }

    /// Begins the counters that alerts watch: Prometheus does not see the first increase of a counter that
    /// appears with it.
    fn begin_at_zero(&self) {
        let begin = |name: &'static str, labels: Vec<Label>| {
            debug_assert!(is_listed(name), "{name} is not in the catalog");
            self.recorder.register_counter(&Key::from_parts(name, labels), &METADATA).absolute(0);
        };
        for kind in [Kind::Ingest, Kind::Fit] {
            begin("bendtwin_lease_losses_total", vec![Label::new("kind", kind.as_str())]);
        }
        for reason in ["DATABASE_FAILED", "DISK_FULL", "FILES_FAILED"] {
            begin("bendtwin_write_failures_total", vec![Label::new("reason", reason)]);
        }
        for part in [Part::Database, Part::Content] {
            for operation in part.operations() {
                let labels =
                    vec![Label::new("store", part.as_str()), Label::new("operation", *operation)];
                begin("bendtwin_store_errors_total", labels);
            }
        }
    }

    /// Counts an answered request. `route` is the pattern, never the path: it has few values.
    pub(crate) fn request(&self, transport: &'static str, route: &str, code: &str, took: Duration) {
        let labels =
            || vec![Label::new("transport", transport), Label::new("route", route.to_owned())];
        let mut with_code = labels();
        with_code.push(Label::new("code", code.to_owned()));
        self.count("bendtwin_requests_total", with_code);
        self.seconds("bendtwin_request_seconds", labels(), took.as_secs_f64());
    }

    /// Counts a job leased after `queued_s` in the queue.
    pub(crate) fn job_leased(&self, kind: Kind, queued_s: f64) {
        let name = match kind {
            Kind::Ingest => "bendtwin_ingest_queue_seconds",
            Kind::Fit => "bendtwin_fit_queue_seconds",
        };
        self.seconds(name, Vec::new(), queued_s.max(0.0));
    }

    /// Counts an attempt that ended and left its job in this state.
    pub(crate) fn job_ended(&self, kind: Kind, state: &'static str) {
        let name = match kind {
            Kind::Ingest => "bendtwin_ingest_attempts_total",
            Kind::Fit => "bendtwin_fit_attempts_total",
        };
        self.count(name, vec![Label::new("state", state)]);
    }

    /// Counts bytes of resumable uploads that were made durable.
    pub(crate) fn upload_bytes(&self, bytes: u64) {
        let key = Key::from_name("bendtwin_upload_bytes_total");
        self.recorder.register_counter(&key, &METADATA).increment(bytes);
    }

    /// Counts a rollout that ended.
    pub(crate) fn rollout(&self, outcome: &'static str, queued: Duration, took: Duration) {
        self.count("bendtwin_rollouts_total", vec![Label::new("outcome", outcome)]);
        self.seconds("bendtwin_rollout_queue_seconds", Vec::new(), queued.as_secs_f64());
        self.seconds("bendtwin_rollout_seconds", Vec::new(), took.as_secs_f64());
    }

    /// Counts a job that was taken from its worker because the lease had run out.
    pub(crate) fn lease_lost(&self, kind: Kind) {
        self.count("bendtwin_lease_losses_total", vec![Label::new("kind", kind.as_str())]);
    }

    /// All metrics as text, with the gauges set to these values.
    pub(crate) fn render(&self, gauges: &Gauges) -> String {
        for (name, count) in [
            ("bendtwin_workers", gauges.workers),
            ("bendtwin_workers_answering", gauges.answering),
            ("bendtwin_rollouts_in_flight", gauges.rollouts),
            ("bendtwin_sessions", gauges.sessions),
            ("bendtwin_plays", gauges.plays),
        ] {
            self.gauge(name, Vec::new(), count as f64);
        }
        let memory = [("used", gauges.memory.used), ("total", gauges.memory.total)];
        for (state, bytes) in memory {
            let label = Label::new("state", state);
            self.gauge("bendtwin_device_memory_bytes", vec![label], bytes as f64);
        }
        process::measure(&self.recorder);
        self.handle.run_upkeep();
        let mut text = self.handle.render();
        if let Some(usage) = &gauges.usage {
            text.push_str(&owners::render(usage));
        }
        text
    }

    fn count(&self, name: &'static str, labels: Vec<Label>) {
        debug_assert!(is_listed(name), "{name} is not in the catalog");
        self.recorder.register_counter(&Key::from_parts(name, labels), &METADATA).increment(1);
    }

    fn seconds(&self, name: &'static str, labels: Vec<Label>, value: f64) {
        debug_assert!(is_listed(name), "{name} is not in the catalog");
        self.recorder.register_histogram(&Key::from_parts(name, labels), &METADATA).record(value);
    }
}

/// Calls of the store to its database and its content.
impl Observer for Metrics {
    fn called(&self, call: Call) {
        let labels = || {
            vec![Label::new("store", call.part.as_str()), Label::new("operation", call.operation)]
        };
        self.seconds("bendtwin_store_seconds", labels(), call.took.as_secs_f64());
        if call.failed {
            self.count("bendtwin_store_errors_total", labels());
        }
    }
}

/// True for a name of the catalog.
fn is_listed(name: &str) -> bool {
    catalog::CATALOG.iter().any(|(listed, _)| *listed == name)
}

fn with_buckets() -> Result<PrometheusBuilder, BuildError> {
    PrometheusBuilder::new()
        .set_buckets_for_metric(Matcher::Suffix("_seconds".to_owned()), &SECONDS)
}

#[cfg(test)]
mod tests;
