//! Inspection of a recording: scan, judgement, pictures.

use bendtwin_capture::raw::Recording;
use bendtwin_core::{CancelToken, settings::ingest::IngestSettings};

use crate::{
    Code, Error, Finding,
    inspection::{CameraReport, Inspection, Kind},
    judge,
    picture_inputs::PictureInputs,
    scan::scan,
    thresholds::Thresholds,
};

/// Most images of all cameras that are read: 5 hours of three cameras at 30 frames a second.
const MAX_IMAGES: usize = 1_600_000;

/// Inspects a recording that is to be ingested with these settings: reads every frame once, measures,
/// judges. Progress is a share, 0..=1.
/// Memory does not grow with the number of images: of most, only numbers are kept.
///
/// # Errors
/// If cancelled. Files that cannot be read are findings.
pub fn inspect(
    recording: &Recording,
    settings: &IngestSettings,
    cancel: &CancelToken,
    progress: &mut dyn FnMut(f64),
) -> Result<Inspection, Error> {
    inspect_with(recording, settings, &Thresholds::default(), cancel, progress)
}

/// [`inspect`] with other thresholds.
pub(crate) fn inspect_with(
    recording: &Recording,
    settings: &IngestSettings,
    thresholds: &Thresholds,
    cancel: &CancelToken,
    progress: &mut dyn FnMut(f64),
) -> Result<Inspection, Error> {
    let images = recording.frame_count.saturating_mul(recording.cameras.len());
    if images > MAX_IMAGES {
        return Ok(too_long(recording, images, settings, thresholds));
    }
    // Nothing can be placed in space without a pose.
    if !recording.is_calibrated() {
        return Ok(unread(recording, settings, thresholds));
    }
    let scans = scan(recording, thresholds, cancel, progress)?;
    let assessment = judge::judge(recording, &scans, settings, thresholds);
    let mut inspection = blank(recording);
    inspection.scene = assessment.scene;
    inspection.cameras = assessment.cameras;
    inspection.add(assessment.findings);
    inspection.pairs = assessment.pairs;
    inspection.corrections = assessment.corrections;
    inspection.picture_inputs = PictureInputs::of(recording, scans);
    Ok(inspection)
}

fn too_long(
    recording: &Recording,
    images: usize,
    settings: &IngestSettings,
    thresholds: &Thresholds,
) -> Inspection {
    let mut inspection = unread(recording, settings, thresholds);
    let message = format!("the recording has {images} images (limit {MAX_IMAGES})");
    let finding = Finding::error(Code::RecordingTooLong, message).number("images", images as f64);
    inspection.add([finding]);
    inspection
}

/// The inspection of a recording whose frames are not read.
fn unread(recording: &Recording, settings: &IngestSettings, thresholds: &Thresholds) -> Inspection {
    let mut inspection = blank(recording);
    inspection.add(judge::judge_unread(recording, settings, thresholds));
    inspection
}

fn blank(recording: &Recording) -> Inspection {
    let mut inspection = Inspection {
        kind: Kind::Recording,
        fps: Some(recording.fps).filter(|fps| fps.is_finite()),
        frame_count: recording.frame_count,
        train_frame_count: recording.train_frame_count,
        sources: recording.sources.clone(),
        cameras: recording.cameras.iter().map(CameraReport::of).collect(),
        ..Inspection::unread(&recording.name)
    };
    inspection.add(recording.notes.iter().cloned());
    inspection
}
