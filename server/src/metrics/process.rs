//! Metrics of the server's process, under the names that Prometheus's own libraries give them.

use metrics_exporter_prometheus::PrometheusRecorder;
use metrics_process::Collector;

/// Sets them.
pub(super) fn measure(recorder: &PrometheusRecorder) {
    ::metrics::with_local_recorder(recorder, || Collector::default().collect());
}
