//! Replaces lenses, poses and ground of a recording.

use bendtwin_core::{Environment, geometry};

use super::{CalibratedCamera, Calibration};
use crate::{
    Error,
    raw::{Camera, Pose, Recording},
};

/// Motion of the world that is rounding, by the distance of [`apart`] [m].
const SAME_WORLD_M: f64 = 1e-3;

pub(super) fn apply(calibration: &Calibration, recording: &mut Recording) -> Result<(), Error> {
    let pairs = calibration.of_cameras(recording.cameras.iter().map(|c| c.name.as_str()))?;
    for (camera, new) in recording.cameras.iter().zip(&pairs) {
        let Some(new) = new else { continue };
        if new.size != [camera.width, camera.height] {
            return Err(Error::Camera {
                camera: camera.name.clone(),
                fault: format!(
                    "its images are {} x {} pixels, and it was calibrated for {} x {}",
                    camera.width, camera.height, new.size[0], new.size[1]
                ),
            });
        }
    }
    let missing = |(camera, new): &(&Camera, &Option<&CalibratedCamera>)| {
        camera.poses.is_empty() && new.is_none_or(|new| new.pose.is_none())
    };
    let has_poses = pairs.iter().flatten().any(|new| new.pose.is_some());
    if let Some((camera, _)) = recording.cameras.iter().zip(&pairs).find(missing)
        && has_poses
    {
        return Err(Error::Camera {
            camera: camera.name.clone(),
            fault: "the calibration gives it no pose, and the recording has none".to_owned(),
        });
    }
    let moved = motion(&recording.cameras, &pairs);
    // A correction of single cameras, or of lenses alone, leaves the world where it is.
    let stays =
        !has_poses || moved.is_some_and(|moved| apart(&moved, &Pose::IDENTITY) < SAME_WORLD_M);
    for (camera, new) in recording.cameras.iter_mut().zip(&pairs) {
        let Some(new) = new else { continue };
        camera.intrinsics = new.intrinsics.unwrap_or(camera.intrinsics);
        camera.distortion = new.distortion.unwrap_or(camera.distortion);
        if let Some(pose) = new.pose {
            // A camera that moves keeps its motion.
            let motion = camera.poses.first().map(|first| pose.after(&first.inverse()));
            match motion.filter(|_| camera.poses.len() > 1) {
                Some(motion) => camera.poses.iter_mut().for_each(|pose| *pose = motion.after(pose)),
                None => camera.poses = vec![pose],
            }
        }
    }
    if let Some(moved) = moved.filter(|_| !stays) {
        carry(recording, &moved);
    }
    if !stays {
        recording.environment = Environment::Z_UP;
    }
    if let Some(ground) = calibration.ground {
        recording.environment.ground = Some(ground);
    }
    Ok(())
}

/// The calibration of each camera, in the order of their names.
pub(super) fn pairs<'a>(
    calibration: &'a Calibration,
    names: &[&str],
) -> Result<Vec<Option<&'a CalibratedCamera>>, Error> {
    let of = |name: &&str| calibration.cameras.iter().find(|new| new.name == **name);
    let named: Vec<_> = names.iter().map(of).collect();
    if named.iter().any(Option::is_some) {
        return Ok(named);
    }
    if calibration.cameras.len() == names.len() {
        return Ok(calibration.cameras.iter().map(Some).collect());
    }
    let list = |names: &mut dyn Iterator<Item = &str>| {
        names.take(8).map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
    };
    Err(Error::Lengths(format!(
        "the calibration is for {} cameras ({}), and the recording has {} ({}): use the same names",
        calibration.cameras.len(),
        list(&mut calibration.cameras.iter().map(|c| c.name.as_str())),
        names.len(),
        list(&mut names.iter().copied())
    )))
}

/// The motion of the world that most cameras made: that of one of them to which those of the others
/// are nearest. `None` if no camera had a pose before.
fn motion(cameras: &[Camera], pairs: &[Option<&CalibratedCamera>]) -> Option<Pose> {
    let motions: Vec<Pose> = cameras
        .iter()
        .zip(pairs)
        .filter_map(|(camera, new)| {
            let before = camera.poses.first()?;
            let after = (*new)?.pose?;
            Some(after.after(&before.inverse()))
        })
        .collect();
    // The median distance: one camera that was corrected does not count.
    let median = |pose: &Pose| {
        let mut all: Vec<f64> = motions.iter().map(|other| apart(pose, other)).collect();
        // It has the distance of the pose from itself at least.
        geometry::median(&mut all).unwrap_or(f64::INFINITY)
    };
    motions.iter().min_by(|a, b| median(a).total_cmp(&median(b))).copied()
}

/// Distance between where two motions take the corners of a metre [m].
fn apart(a: &Pose, b: &Pose) -> f64 {
    [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        .map(|p| geometry::distance(a.moved(p), b.moved(p)))
        .iter()
        .sum::<f64>()
}

fn carry(recording: &mut Recording, moved: &Pose) {
    for point in &mut recording.truth_tracks {
        *point = moved.to_world(point.map(f64::from));
    }
    for pose in recording.grippers.iter_mut().flat_map(|g| g.poses.iter_mut().flatten()) {
        *pose = moved.after(pose);
    }
    let turn = moved.rotation.map(|row| row.map(|x| x as f32));
    if let Some(alignment) = recording.mesh.as_mut().and_then(|mesh| mesh.to_world.as_mut()) {
        alignment.rotation = crate::frame::compose(&turn, &alignment.rotation);
        alignment.translation = moved.to_world(alignment.translation.map(f64::from));
    }
    recording.source_to_world = crate::frame::compose(&turn, &recording.source_to_world);
}
