//! Masks of strokes: made here, or those of an earlier ingest with the same strokes and cameras.

use std::{path::Path, sync::Arc};

use bendtwin_capture::{
    self as capture, Limits,
    raw::{Calibration, MaskSet, Recording},
};
use bendtwin_core::{Fault, Finding, settings::ingest::Stroke};
use bendtwin_segment::{FOLLOWING_FILE, segment};
use serde::{Deserialize, Serialize};

use super::unless_stopped;
use crate::{Work, error_of};

/// Longest document [bytes].
const MAX_DOCUMENT: u64 = 64 << 20;

/// Masks that were made of strokes.
#[derive(Clone, Debug)]
pub struct StrokeMasks {
    /// Masks of all cameras and frames.
    pub set: Arc<MaskSet>,
    /// Share of object and hand in an image whose label is doubtful, 0..=1; `None` for a frame that the
    /// camera lacks. Shape [camera][T].
    pub doubt: Vec<Vec<Option<f32>>>,
    following: Following,
}

/// What masks were made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Following {
    strokes: Vec<Stroke>,
    /// Lenses and poses of the cameras with which they were carried.
    #[serde(default)]
    world: String,
    cameras: Vec<Doubt>,
    /// Remarks about the masks.
    #[serde(default)]
    findings: Vec<Finding>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Doubt {
    doubt: Vec<Option<f32>>,
}

impl StrokeMasks {
    /// Writes the masks as a ZIP archive in the layout of a raw PhysTwin case, with what they were made
    /// of.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), capture::Error> {
        let document = serde_json::to_vec(&self.following).unwrap_or_default();
        self.set.write_zip(path, &[(FOLLOWING_FILE, document)])
    }

    /// The masks in such an archive, if they were made of the same strokes with the same cameras.
    fn read(path: &Path, work: &Work<'_>, recording: &Recording) -> Option<Self> {
        let following: Following = serde_json::from_slice(&document(path, work.limits)?).ok()?;
        let settings = work.settings;
        let is_same = following.strokes == settings.strokes
            && following.world == world(recording)
            && following.cameras.len() == recording.cameras.len()
            && following.cameras.iter().all(|c| c.doubt.len() == recording.frame_count);
        if !is_same {
            return None;
        }
        let read = recording.clone().with_mask_files(path, work.limits).ok()?;
        let set = Arc::new(MaskSet::of(&read).ok()?);
        let doubt = following.cameras.iter().map(|camera| camera.doubt.clone()).collect();
        Some(Self { set, doubt, following })
    }
}

/// The cameras of a recording, as text.
fn world(recording: &Recording) -> String {
    Calibration::of(recording, "strokes").to_json()
}

/// The document in an archive of masks.
fn document(path: &Path, limits: &Limits) -> Option<Vec<u8>> {
    capture::raw::file_in(path, FOLLOWING_FILE, MAX_DOCUMENT, limits).ok().flatten()
}

/// Masks of the strokes in the settings, if there are any and the cameras are calibrated.
pub(super) fn masks(
    work: &Work<'_>,
    recording: &Recording,
    findings: &mut Vec<Finding>,
    tell: &mut dyn FnMut(f64),
) -> Result<Option<StrokeMasks>, Fault> {
    let settings = work.settings;
    if settings.strokes.is_empty() || !recording.is_calibrated() {
        return Ok(None);
    }
    let earlier = work.input.earlier_masks;
    if let Some(masks) = earlier.and_then(|path| StrokeMasks::read(path, work, recording)) {
        findings.extend(masks.following.findings.iter().cloned());
        return Ok(Some(masks));
    }
    match unless_stopped(segment(recording, &settings.strokes, tell, work.cancel))? {
        Ok(made) => {
            findings.extend(made.findings.iter().cloned());
            let cameras = made.doubt.iter().map(|doubt| Doubt { doubt: doubt.clone() });
            let following = Following {
                strokes: settings.strokes.clone(),
                world: world(recording),
                cameras: cameras.collect(),
                findings: made.findings,
            };
            Ok(Some(StrokeMasks { set: Arc::new(made.masks), doubt: made.doubt, following }))
        }
        Err(fault) => {
            findings.push(error_of(&fault).explains("MASKS_MISSING"));
            Ok(None)
        }
    }
}
