//! A world with z up for calibrations that have another: the ground is taken from depth; without one,
//! the first camera is held upright.

use bendtwin_capture::raw::{Calibration, Pose, Recording};
use bendtwin_core::{CancelToken, Finding, Severity};

use crate::{Error, files::Imported, ground};

/// The calibration in a world whose ground is z = 0.
pub(crate) fn stand(
    recording: &Recording,
    calibration: Calibration,
    cancel: &CancelToken,
) -> Result<Imported, Error> {
    let mut calibrated = recording.clone();
    calibration.apply(&mut calibrated)?;
    if let Some(ground) = ground::detect(&calibrated, cancel)? {
        let level = ground::level(&calibrated, &ground, true);
        let message = format!(
            "the ground is the largest plane that the cameras see, {:.0} % of their depth",
            100.0 * ground.share
        );
        let finding = Finding::new(Severity::Info, "GROUND_DETECTED", message);
        return Ok(Imported {
            calibration: ground::with_poses(calibration, &level),
            findings: vec![finding],
        });
    }
    let mut level = calibration.clone();
    let first = level.cameras.first().and_then(|camera| camera.pose).unwrap_or(Pose::IDENTITY);
    // x to the right, y forward, z up of the first camera.
    let up = Pose {
        rotation: [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]],
        translation: [0.0; 3],
    };
    let moved = up.after(&first.inverse());
    for camera in &mut level.cameras {
        camera.pose = camera.pose.map(|pose| moved.after(&pose));
    }
    let message = "no plane is found in depth, so that up is the first camera's and the ground is not known: record the \
                   table in view, or calibrate with a board on it (docs/use/cameras.md#ground)";
    let finding = Finding::from_sentence(Severity::Warning, "GROUND_NOT_DETECTED", message);
    Ok(Imported { calibration: ground::with_poses(calibration, &level), findings: vec![finding] })
}
