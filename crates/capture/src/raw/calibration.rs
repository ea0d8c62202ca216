//! A calibration as a separate document, `calibration.json`: poses of cameras, their lenses and
//! the ground, measured or converted apart from the recording. World in metres with z up, OpenCV's
//! camera axes, camera to world.

mod apply;
mod document;

use bendtwin_core::Plane;

use super::{Distortion, Intrinsics, Pose, Recording};
use crate::{Error, Limits, Sources, sources::Taken};

/// Name of the document beside the files of a recording, whose own calibration it replaces.
pub const CALIBRATION_FILE: &str = "calibration.json";

/// Calibration of the cameras of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// The cameras; at least one.
    pub cameras: Vec<CalibratedCamera>,
    /// The ground in the calibration's world, if it is known.
    pub ground: Option<Plane>,
    /// Origin of the calibration in one word: `board`, `correction`, `ground`, `colmap`, `kalibr`,
    /// `opencv`, `ros`.
    pub source: String,
}

/// Calibration of one camera.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibratedCamera {
    /// Name of the camera in the recording.
    pub name: String,
    /// Columns and rows of the images for which it was calibrated.
    pub size: [usize; 2],
    /// The pinhole; absent: that of the recording.
    pub intrinsics: Option<Intrinsics>,
    /// Distortion by the lens; absent: that of the recording.
    pub distortion: Option<Distortion>,
    /// From the camera to the world; absent: that of the recording.
    pub pose: Option<Pose>,
    /// Root mean square distance between where the camera saw what it was calibrated with and where
    /// the calibration puts it [px], if it was measured.
    pub reprojection_px: Option<f64>,
}

impl Calibration {
    /// Reads the document.
    ///
    /// # Errors
    /// If it is not as specified, impossible, or has more cameras than the limits allow.
    pub fn read(bytes: &[u8], limits: &Limits) -> Result<Self, Error> {
        document::read(bytes, limits)
    }

    /// `true` if a file of its name is one, and not another program's. One that is broken counts, so
    /// that its fault is reported.
    pub(super) fn is_one(bytes: &[u8]) -> bool {
        document::is_one(bytes)
    }

    /// The document.
    pub fn to_json(&self) -> String {
        document::write(self)
    }

    /// Lenses and poses of a recording, in frame 0 if cameras move.
    pub fn of(recording: &Recording, source: &str) -> Self {
        let cameras = recording.cameras.iter().map(|camera| CalibratedCamera {
            name: camera.name.clone(),
            size: [camera.width, camera.height],
            intrinsics: Some(camera.intrinsics),
            distortion: Some(camera.distortion),
            pose: camera.poses.first().copied(),
            reprojection_px: None,
        });
        Self {
            cameras: cameras.collect(),
            ground: recording.environment.ground,
            source: source.to_owned(),
        }
    }

    /// The calibration of each camera of a recording, by name, or by order if no name matches and the
    /// count agrees.
    pub(super) fn of_cameras<'a>(
        &self,
        names: impl Iterator<Item = &'a str>,
    ) -> Result<Vec<Option<&CalibratedCamera>>, Error> {
        apply::pairs(self, &names.collect::<Vec<_>>())
    }

    /// Replaces lenses, poses and ground of a recording by these. Cameras are matched by name, or by
    /// order if no name matches and the count agrees. What lies in the recording's world, mesh and
    /// true tracks, moves with the cameras.
    ///
    /// # Errors
    /// If cameras do not match, or were calibrated for images of another size.
    pub fn apply(&self, recording: &mut Recording) -> Result<(), Error> {
        apply::apply(self, recording)
    }

    /// Lists as taken `from` somewhere the lenses and poses that it has, in place of those that it
    /// replaces.
    pub fn tell(&self, sources: &mut Sources, from: &str) {
        type Has = fn(&CalibratedCamera) -> bool;
        let has_pose: Has = |camera| camera.pose.is_some();
        let has_pinhole: Has = |camera| camera.intrinsics.is_some();
        let has_lens: Has = |camera| camera.intrinsics.is_some() || camera.distortion.is_some();
        for (part, has, replaces) in [("lens", has_lens, has_pinhole), ("pose", has_pose, has_pose)]
        {
            if self.cameras.iter().all(replaces) {
                sources.taken.retain(|taken| taken.part != part);
                sources.take(part, None, from, &self.source);
                continue;
            }
            for camera in self.cameras.iter().filter(|camera| has(camera)) {
                let name = Some(camera.name.as_str());
                if replaces(camera) {
                    let is_other = |of: &Taken| of.part != part || of.camera.as_deref() != name;
                    sources.taken.retain(is_other);
                }
                sources.take(part, name, from, &self.source);
            }
        }
    }
}

#[cfg(test)]
mod tests;
