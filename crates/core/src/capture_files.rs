//! Names in the files of a capture's ingest that programs without a reader of captures compare.

/// Name of the first entry of an observation, which is a capture bundle.
pub const OBSERVATION_MARKER: &str = "capture.json";
/// Name of the format of a capture report.
pub const REPORT_FORMAT: &str = "bendtwin-capture-report";
