//! Prometheus metrics of one server. They belong to the server, not to the process, so that several
//! servers in one test do not add up.

mod gauges;
mod owners;

use std::{fmt, sync::Arc, time::Duration};

use ::metrics::{Key, Label, Level, Metadata, Recorder as _};
use bendtwin_store::{Kind, OwnerUsage, QueueDepth, UploadUse};
use metrics_exporter_prometheus::{
    BuildError, Matcher, PrometheusBuilder, PrometheusHandle, PrometheusRecorder,
};

use crate::dispatch::Memory;

const SECONDS: [f64; 14] =
    [0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 1.0, 5.0, 30.0, 300.0, 3600.0];

static METADATA: Metadata<'static> = Metadata::new("bendtwin_server", Level::INFO, None);

/// Values of the gauges at the moment of a rendering.
pub(crate) struct Gauges {
    pub(crate) workers: usize,
    /// Rollouts under way or waiting.
    pub(crate) rollouts: usize,
    /// Sum over the devices of all workers: workers come and go under ever new names.
    pub(crate) memory: Memory,
    pub(crate) uploads: UploadUse,
    /// Usage of all owners; none if it is not known at the moment.
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
        Self { handle: recorder.handle(), recorder: Arc::new(recorder) }
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

    /// All metrics as text, with the gauges set to these values.
    pub(crate) fn render(&self, depth: &QueueDepth, gauges: &Gauges) -> String {
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
        self.gauge("bendtwin_workers", Vec::new(), gauges.workers as f64);
        self.gauge("bendtwin_rollouts_in_flight", Vec::new(), gauges.rollouts as f64);
        self.gauge("bendtwin_uploads", Vec::new(), gauges.uploads.count as f64);
        self.gauge("bendtwin_uploads_bytes", Vec::new(), gauges.uploads.bytes as f64);
        let memory = [("used", gauges.memory.used), ("total", gauges.memory.total)];
        for (state, bytes) in memory {
            let label = Label::new("state", state);
            self.gauge("bendtwin_device_memory_bytes", vec![label], bytes as f64);
        }
        self.handle.run_upkeep();
        let mut text = self.handle.render();
        if let Some(usage) = &gauges.usage {
            text.push_str(&owners::render(usage));
        }
        text
    }

    fn count(&self, name: &'static str, labels: Vec<Label>) {
        self.recorder.register_counter(&Key::from_parts(name, labels), &METADATA).increment(1);
    }

    fn seconds(&self, name: &'static str, labels: Vec<Label>, value: f64) {
        self.recorder.register_histogram(&Key::from_parts(name, labels), &METADATA).record(value);
    }
}

fn with_buckets() -> Result<PrometheusBuilder, BuildError> {
    PrometheusBuilder::new()
        .set_buckets_for_metric(Matcher::Suffix("_seconds".to_owned()), &SECONDS)
}
