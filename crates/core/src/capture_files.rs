//! Names in the files of a capture's ingest that programs without a reader of captures compare.

/// Name of the first entry of an observation, which is a capture bundle.
pub const OBSERVATION_MARKER: &str = "capture.json";
/// First bytes of a playback.
pub const PLAYBACK_MAGIC: &[u8; 8] = b"BENDPLAY";
/// Most bytes of a playback. Its maker keeps to less.
pub const MAX_PLAYBACK_BYTES: u64 = 64 << 20;
/// Name of the format of a capture report.
pub const REPORT_FORMAT: &str = "bendtwin-capture-report";
/// Name of the format of a calibration.
pub const CALIBRATION_FORMAT: &str = "bendtwin-calibration";
