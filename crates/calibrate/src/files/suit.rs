//! Cameras of files for the cameras of a recording: which is which, the unit, and the ground.

use bendtwin_capture::raw::{CalibratedCamera, Calibration, Recording};
use bendtwin_core::{CancelToken, Finding, Severity};

use super::{Cameras, Described, Imported, Unit};
use crate::{Error, upright};

/// A camera farther from the others than this stands in no laboratory: another unit is meant [m].
const FARTHEST_M: f64 = 30.0;

pub(super) fn calibration(
    recording: &Recording,
    files: &[Cameras],
    unit: Unit,
    cancel: &CancelToken,
) -> Result<Imported, Error> {
    let described: Vec<&Described> = files.iter().flat_map(|file| &file.cameras).collect();
    let pairs = pairs(recording, &described)?;
    let source = files.first().map_or("opencv", |file| file.source);
    let mut cameras = Vec::new();
    for (camera, described) in recording.cameras.iter().zip(&pairs) {
        let size = [camera.width, camera.height];
        if let Some(other) = described.size.filter(|other| *other != size) {
            return Err(Error::Unsuited(format!(
                "camera `{}` was calibrated at {} x {} pixels and recorded at {} x {}: calibrate at the resolution that \
                 is recorded",
                camera.name, other[0], other[1], size[0], size[1]
            )));
        }
        let pose = described.pose.map(|mut pose| {
            pose.translation = pose.translation.map(|x| x * unit.metres());
            pose
        });
        if let Some(far) =
            pose.map(|p| p.translation.iter().fold(0.0_f64, |far, x| far.max(x.abs())))
            && far > FARTHEST_M
        {
            return Err(Error::Unsuited(format!(
                "camera `{}` stands {far:.0} m away in this file: give its unit (`--unit mm`)",
                camera.name
            )));
        }
        cameras.push(CalibratedCamera {
            name: camera.name.clone(),
            size,
            intrinsics: described.intrinsics,
            distortion: described.distortion,
            pose,
            reprojection_px: None,
        });
    }
    let calibration = Calibration { cameras, ground: None, source: source.to_owned() };
    // What was written is checked as if it came from a stranger.
    let checked =
        Calibration::read(calibration.to_json().as_bytes(), &bendtwin_capture::Limits::default())?;
    let posed = checked.cameras.iter().filter(|camera| camera.pose.is_some()).count();
    if posed == 0 {
        let message = "the file has lenses without poses; the recording keeps its own poses";
        let finding = Finding::new(Severity::Info, "CALIBRATION_WITHOUT_POSES", message);
        return Ok(Imported { calibration: checked, findings: vec![finding] });
    }
    if posed < checked.cameras.len() {
        return Err(Error::Unsuited(format!(
            "only {posed} of {} cameras have a pose: give R and T (world to camera) for each",
            checked.cameras.len()
        )));
    }
    upright::stand(recording, checked, cancel)
}

/// The description of each camera of the recording, by name or by order.
fn pairs<'a>(
    recording: &Recording,
    described: &[&'a Described],
) -> Result<Vec<&'a Described>, Error> {
    let cameras = &recording.cameras;
    let named: Option<Vec<&Described>> = cameras
        .iter()
        .map(|camera| {
            let mut own = described.iter().filter(|other| is_called(&other.name, &camera.name));
            own.next().copied().filter(|_| own.next().is_none())
        })
        .collect();
    if let Some(named) = named {
        return Ok(named);
    }
    if described.len() == cameras.len() {
        return Ok(described.to_vec());
    }
    let list = |names: Vec<&str>| names.join("`, `");
    Err(Error::Unsuited(format!(
        "it has {} cameras (`{}`), and the recording {} (`{}`): give a file of all of them, or one for each in their order",
        described.len(),
        list(described.iter().take(8).map(|d| d.name.as_str()).collect()),
        cameras.len(),
        list(cameras.iter().take(8).map(|c| c.name.as_str()).collect())
    )))
}

/// `true` if a name or topic is that of a camera: a part of it between slashes is the camera's name.
pub(crate) fn is_called(name: &str, camera: &str) -> bool {
    !camera.is_empty()
        && (name.eq_ignore_ascii_case(camera)
            || name.split('/').any(|part| part.eq_ignore_ascii_case(camera)))
}
