//! The JSON form of a calibration.

use bendtwin_core::Plane;
use serde::{Deserialize, Serialize};

use super::{CALIBRATION_FILE, CalibratedCamera, Calibration};
use crate::{
    Error, Limits,
    files::at_most,
    phystwin::json,
    raw::{
        Distortion, Intrinsics, Pose,
        bundle::{DistortionEntry, IntrinsicsEntry, PoseEntry},
        validity,
    },
};

const FORMAT: &str = bendtwin_core::capture_files::CALIBRATION_FORMAT;
const VERSION: u64 = 1;
/// Longest name and origin [bytes].
const MAX_TEXT: usize = 256;

#[derive(Deserialize)]
struct Head {
    format: String,
    version: u64,
}

/// What tells a calibration from other programs' files.
#[derive(Deserialize)]
struct Origin {
    #[serde(default)]
    format: Option<String>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    format: String,
    version: u64,
    cameras: Vec<CameraEntry>,
    #[serde(default)]
    ground: Option<GroundEntry>,
    #[serde(default)]
    source: String,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraEntry {
    name: String,
    size: [usize; 2],
    #[serde(default)]
    intrinsics: Option<IntrinsicsEntry>,
    #[serde(default)]
    distortion: Option<DistortionEntry>,
    #[serde(default)]
    pose: Option<PoseEntry>,
    #[serde(default)]
    reprojection_px: Option<f64>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct GroundEntry {
    normal: [f32; 3],
    offset: f32,
}

/// `true` if the document is a calibration, or was one before it was broken.
pub(super) fn is_one(bytes: &[u8]) -> bool {
    match json::<Origin>(bytes, CALIBRATION_FILE) {
        Ok(origin) => origin.format.as_deref() == Some(FORMAT),
        Err(_) => bytes.windows(FORMAT.len()).any(|part| part == FORMAT.as_bytes()),
    }
}

pub(super) fn read(bytes: &[u8], limits: &Limits) -> Result<Calibration, Error> {
    let head: Head = json(bytes, CALIBRATION_FILE)?;
    if head.format != FORMAT {
        let format: String = head.format.chars().take(40).collect();
        return fail(format!("its format is `{format}`, not `{FORMAT}`"));
    }
    if head.version != VERSION {
        return fail(format!("it has version {}, this build reads {VERSION}", head.version));
    }
    let document: Document = json(bytes, CALIBRATION_FILE)?;
    at_most("cameras", document.cameras.len(), limits.cameras)?;
    if document.cameras.is_empty() {
        return fail("it has no cameras".to_owned());
    }
    if document.source.len() > MAX_TEXT {
        return fail(format!("its `source` is longer than {MAX_TEXT} bytes"));
    }
    let mut cameras: Vec<CalibratedCamera> = Vec::with_capacity(document.cameras.len());
    for entry in document.cameras {
        if entry.name.len() > MAX_TEXT {
            return fail(format!("a camera's name is longer than {MAX_TEXT} bytes"));
        }
        if cameras.iter().any(|other| other.name == entry.name) {
            return fail(format!("two of its cameras are called `{}`", entry.name));
        }
        cameras.push(camera(entry, limits)?);
    }
    let ground = document.ground.map(ground).transpose()?;
    Ok(Calibration { cameras, ground, source: document.source })
}

fn camera(entry: CameraEntry, limits: &Limits) -> Result<CalibratedCamera, Error> {
    let name = entry.name;
    let of = |fault: &str| Error::Camera { camera: name.clone(), fault: fault.to_owned() };
    validity::check_size(&name, entry.size, limits)?;
    let intrinsics = entry.intrinsics.as_ref().map(Intrinsics::from);
    if let Some(intrinsics) = &intrinsics {
        validity::check_intrinsics(&name, intrinsics)?;
    }
    let distortion = match &entry.distortion {
        None => None,
        Some(entry) => {
            Some(entry.read().ok_or_else(|| of("its distortion has not 4, 5 or 8 coefficients"))?)
        }
    };
    validity::check_distortion(&name, &distortion.unwrap_or(Distortion::None))?;
    let pose = entry.pose.as_ref().map(Pose::from);
    let pose = pose.map(|pose| validity::settle_pose(&name, &pose)).transpose()?;
    let reprojection_px = entry.reprojection_px.filter(|px| px.is_finite() && *px >= 0.0);
    Ok(CalibratedCamera { size: entry.size, intrinsics, distortion, pose, reprojection_px, name })
}

fn ground(entry: GroundEntry) -> Result<Plane, Error> {
    let GroundEntry { normal, offset } = entry;
    let length = normal.iter().map(|x| x * x).sum::<f32>().sqrt();
    if !(0.99..=1.01).contains(&length) || !offset.is_finite() {
        return fail(format!(
            "its ground has normal {normal:?} and offset {offset}: a unit vector and metres are needed"
        ));
    }
    Ok(Plane { normal: normal.map(|x| x / length), offset_m: offset })
}

fn fail<T>(fault: String) -> Result<T, Error> {
    Err(Error::Document { at: CALIBRATION_FILE.to_owned(), fault })
}

pub(super) fn write(calibration: &Calibration) -> String {
    let cameras = calibration.cameras.iter().map(|camera| CameraEntry {
        name: camera.name.clone(),
        size: camera.size,
        intrinsics: camera.intrinsics.map(IntrinsicsEntry::from),
        distortion: camera.distortion.map(DistortionEntry::from),
        pose: camera.pose.as_ref().map(PoseEntry::from),
        reprojection_px: camera.reprojection_px,
    });
    let document = Document {
        format: FORMAT.to_owned(),
        version: VERSION,
        cameras: cameras.collect(),
        ground: calibration
            .ground
            .map(|plane| GroundEntry { normal: plane.normal, offset: plane.offset_m }),
        source: calibration.source.clone(),
    };
    // Nothing in it can fail: its keys are texts, and JSON writes numbers that are not finite as null.
    let mut text = serde_json::to_string_pretty(&document).unwrap_or_default();
    text.push('\n');
    text
}
