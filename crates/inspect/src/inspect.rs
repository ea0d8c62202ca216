//! From a recording to what is wrong with it.

use bendtwin_capture::raw::Recording;
use bendtwin_core::CancelToken;

use crate::{
    Error, Finding,
    gallery::Gallery,
    inspection::{Inspection, Kind},
    judge,
    watch::watch,
};

/// Most images of all cameras that are looked at: 5 hours of three cameras at 30 frames a second.
const MOST_IMAGES: usize = 1_600_000;

/// Looks at every frame of a recording once and says what is wrong with it. Progress is a share, 0..=1. Memory does not
/// grow with the images: of most, only numbers are kept.
///
/// # Errors
/// If cancelled. Files that cannot be read are findings.
pub fn inspect(
    recording: &Recording,
    cancel: &CancelToken,
    progress: &mut dyn FnMut(f64),
) -> Result<Inspection, Error> {
    let images = recording.frame_count.saturating_mul(recording.cameras.len());
    if images > MOST_IMAGES {
        return Ok(too_long(recording, images));
    }
    // Nothing can be placed in space without a pose; readers give one, and what does not is told.
    if recording.cameras.iter().any(|camera| camera.poses.is_empty()) {
        return Ok(unseen(recording));
    }
    let logs = watch(recording, cancel, progress)?;
    let record = judge::judge(recording, &logs);
    let mut inspection = blank(recording);
    inspection.add(record.findings);
    inspection.scene = record.scene;
    inspection.cameras = record.cameras;
    inspection.pairs = record.pairs;
    inspection.gallery = Gallery::of(recording, logs);
    Ok(inspection)
}

fn too_long(recording: &Recording, images: usize) -> Inspection {
    let mut inspection = unseen(recording);
    let message = format!("the recording has {images} images (limit {MOST_IMAGES})");
    let finding = Finding::error("RECORDING_TOO_LONG", message).number("images", images as f64);
    let mut findings = [finding];
    crate::finding::advise(&mut findings);
    inspection.add(findings);
    inspection
}

/// What can be said of a recording without looking at its frames.
fn unseen(recording: &Recording) -> Inspection {
    let mut inspection = blank(recording);
    inspection.add(judge::judge_unseen(recording));
    inspection
}

fn blank(recording: &Recording) -> Inspection {
    Inspection {
        kind: Kind::Recording,
        fps: Some(recording.fps).filter(|fps| fps.is_finite()),
        frame_count: recording.frame_count,
        train_frame_count: recording.train_frame_count,
        ..Inspection::unread(&recording.name)
    }
}
