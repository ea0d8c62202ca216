//! Calibrations of other programs: Kalibr's `camchain.yaml`, OpenCV's file storage in YAML, XML and
//! JSON, ROS's `camera_info`.

mod kalibr;
mod matrix;
mod opencv;
mod suit;
mod value;
mod xml;
mod yaml;

use std::path::Path;

use bendtwin_capture::raw::{Calibration, Distortion, Intrinsics, Pose, Recording};
use bendtwin_core::{CancelToken, Finding};

pub use self::value::Value;
use crate::Error;

/// Most bytes of a file.
const MAX_BYTES: u64 = 4 << 20;

/// Length of a translation's unit [m].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Unit {
    /// Metres.
    #[default]
    Metres,
    /// Centimetres.
    Centimetres,
    /// Millimetres.
    Millimetres,
}

impl Unit {
    fn metres(self) -> f64 {
        match self {
            Self::Metres => 1.0,
            Self::Centimetres => 0.01,
            Self::Millimetres => 0.001,
        }
    }
}

/// A camera as a file describes it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Described {
    /// Name, topic or key of the camera, if it has one.
    pub name: String,
    /// Columns and rows of its images.
    pub size: Option<[usize; 2]>,
    /// The pinhole.
    pub intrinsics: Option<Intrinsics>,
    /// Distortion by the lens.
    pub distortion: Option<Distortion>,
    /// From the camera to the file's world, in the file's unit.
    pub pose: Option<Pose>,
}

/// Cameras of a file, and the program that writes such files.
#[derive(Clone, Debug, PartialEq)]
pub struct Cameras {
    /// `kalibr`, `opencv` or `ros`.
    pub source: &'static str,
    /// The cameras in the file's order; at least one.
    pub cameras: Vec<Described>,
}

/// A calibration for a recording, and what was found on the way.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The calibration, in a world with z up.
    pub calibration: Calibration,
    /// Remarks and warnings.
    pub findings: Vec<Finding>,
}

/// Reads the cameras of a file.
///
/// # Errors
/// If its format is unknown, or it is damaged, too large, or of a camera model that is not supported.
pub fn read(path: &Path) -> Result<Cameras, Error> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let at = path.display().to_string();
    let io = |source| bendtwin_capture::Error::Io { at: at.clone(), source };
    let size = std::fs::metadata(path).map_err(io)?.len();
    if size > MAX_BYTES {
        let fault = format!("it has {size} bytes (limit {MAX_BYTES}): is it a calibration?");
        return Err(Error::File { at, fault });
    }
    parse(&name, &std::fs::read(path).map_err(io)?)
}

/// Reads the cameras of a file's content; `name` is its name.
///
/// # Errors
/// Those of [`read`].
pub fn parse(name: &str, bytes: &[u8]) -> Result<Cameras, Error> {
    let fail = |fault: String| Error::File { at: name.to_owned(), fault };
    let text = std::str::from_utf8(bytes).map_err(|_| fail("it is no text".to_owned()))?;
    let is_xml = text.trim_start_matches('\u{feff}').trim_start().starts_with('<');
    let value = if is_xml { xml::parse(text) } else { yaml::parse(text) }.map_err(fail)?;
    let found = match kalibr::cameras(&value).map_err(fail)? {
        Some(cameras) => Cameras { source: "kalibr", cameras },
        None => opencv::cameras(&value).map_err(fail)?,
    };
    if found.cameras.is_empty() {
        return Err(fail(
            "it has no camera matrix: Kalibr's camchain.yaml, OpenCV's file storage (camera_matrix, \
             distortion_coefficients, R, T) and ROS's camera_info are read"
                .to_owned(),
        ));
    }
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    let mut cameras = found.cameras;
    if let [only] = cameras.as_mut_slice()
        && only.name.is_empty()
    {
        stem.clone_into(&mut only.name);
    }
    Ok(Cameras { cameras, ..found })
}

/// The calibration of a recording's cameras from those of one or several files.
///
/// # Errors
/// If the cameras are not those of the recording, or a frame cannot be read.
pub fn calibration(
    recording: &Recording,
    files: &[Cameras],
    unit: Unit,
    cancel: &CancelToken,
) -> Result<Imported, Error> {
    suit::calibration(recording, files, unit, cancel)
}

#[cfg(test)]
mod tests;
