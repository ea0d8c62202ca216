//! Conditions that a recording has to meet before anything may calculate with it. Its quality is
//! judged elsewhere.

use bendtwin_core::{FRAME_RATES, geometry};

use super::{
    Camera, Distortion, Intrinsics, Pose, Recording,
    realign::{DepthCamera, Lens},
};
use crate::{Error, Limits, files::at_most};

/// Largest deviation of rows from orthonormal: calibrations are written with few digits.
const ORTHONORMAL: f64 = 1e-2;

/// Positions beyond this [m] are no calibration of cameras around a table.
const FARTHEST_M: f64 = 1e4;

/// A depth sensor farther than this from the colour sensor [m] is another camera.
const FARTHEST_FROM_COLOR_M: f64 = 2.0;

/// Checks numbers and counts and makes rotations exact.
///
/// # Errors
/// The first contradiction found.
pub(super) fn settle(recording: &mut Recording, limits: &Limits) -> Result<(), Error> {
    let frames = recording.frame_count;
    count(recording.cameras.len(), frames, limits)?;
    if !FRAME_RATES.contains(&recording.fps) {
        return Err(Error::Lengths(format!(
            "the recording has {} frames per second: give its true rate",
            recording.fps
        )));
    }
    if recording.train_frame_count > frames {
        let split = i64::try_from(recording.train_frame_count).unwrap_or(i64::MAX);
        return Err(Error::SplitRange { sequence: recording.name.clone(), split, frames });
    }
    if !recording.truth_tracks.len().is_multiple_of(frames) {
        return Err(Error::Lengths(format!(
            "{} truth positions do not divide into {frames} frames",
            recording.truth_tracks.len()
        )));
    }
    let placed = recording.cameras.iter().filter(|camera| !camera.poses.is_empty()).count();
    if placed > 0
        && let Some(camera) = recording.cameras.iter().find(|camera| camera.poses.is_empty())
    {
        return Err(Error::Camera {
            camera: camera.name.clone(),
            fault: "it has no pose, and other cameras have".to_owned(),
        });
    }
    for camera in &mut recording.cameras {
        settle_camera(camera, frames, limits)?;
    }
    Ok(())
}

/// Refuses more cameras or frames than a recording may have, or none.
pub(super) fn count(cameras: usize, frames: usize, limits: &Limits) -> Result<(), Error> {
    at_most("cameras", cameras, limits.cameras)?;
    at_most("frames of a recording", frames, limits.recording_frames)?;
    if cameras == 0 || frames == 0 {
        return Err(Error::Lengths(format!(
            "the recording has {cameras} cameras and {frames} frames: it needs at least one of each"
        )));
    }
    Ok(())
}

/// The depth camera beside a colour camera, its pose made exact.
///
/// # Errors
/// If its lens or pose is impossible.
pub(super) fn depth_camera(
    color: &Camera,
    depth: Lens,
    to_color: &Pose,
    limits: &Limits,
) -> Result<DepthCamera, Error> {
    let name = format!("{} (depth)", color.name);
    check_size(&name, depth.size, limits)?;
    check_intrinsics(&name, &depth.intrinsics)?;
    check_distortion(&name, &depth.distortion)?;
    let colors = Lens {
        size: [color.width, color.height],
        intrinsics: color.intrinsics,
        distortion: color.distortion,
    };
    check_intrinsics(&color.name, &colors.intrinsics)?;
    check_distortion(&color.name, &colors.distortion)?;
    let [x, y, z] = to_color.translation;
    if x.hypot(y).hypot(z) > FARTHEST_FROM_COLOR_M {
        return Err(Error::Camera {
            camera: name,
            fault: format!(
                "its place is {:?} m from the colour camera: give metres, from the depth camera to the colour camera",
                to_color.translation
            ),
        });
    }
    Ok(DepthCamera::new(depth, colors, settle_pose(&name, to_color)?))
}

fn settle_camera(camera: &mut Camera, frames: usize, limits: &Limits) -> Result<(), Error> {
    let name = camera.name.clone();
    let fail = |fault: String| Err(Error::Camera { camera: name.clone(), fault });
    check_size(&camera.name, [camera.width, camera.height], limits)?;
    check_intrinsics(&camera.name, &camera.intrinsics)?;
    check_distortion(&camera.name, &camera.distortion)?;
    if camera.poses.len() > 1 && camera.poses.len() != frames {
        return fail(format!(
            "it has {} poses for {frames} frames: one, or one each",
            camera.poses.len()
        ));
    }
    for pose in &mut camera.poses {
        *pose = settle_pose(&camera.name, pose)?;
    }
    if !camera.times_s.is_empty() && camera.times_s.len() != frames {
        return fail(format!(
            "it has {} times for {frames} frames: one each, or none",
            camera.times_s.len()
        ));
    }
    if let Some(t) = camera.times_s.iter().find(|t| t.is_infinite()) {
        return fail(format!("one of its times is {t}"));
    }
    Ok(())
}

/// Refuses a pinhole that no camera has.
pub(super) fn check_intrinsics(camera: &str, i: &Intrinsics) -> Result<(), Error> {
    let fail = |fault: String| Err(Error::Camera { camera: camera.to_owned(), fault });
    if ![i.fx, i.fy].iter().all(|f| f.is_finite() && *f > 1e-3 && *f < 1e7) {
        return fail(format!("its focal lengths are {} and {} pixels", i.fx, i.fy));
    }
    if ![i.cx, i.cy].iter().all(|c| c.is_finite() && c.abs() < 1e7) {
        return fail(format!("its principal point is ({}, {})", i.cx, i.cy));
    }
    Ok(())
}

/// Refuses coefficients that are no numbers.
pub(super) fn check_distortion(camera: &str, distortion: &Distortion) -> Result<(), Error> {
    let coefficients: &[f64] = match distortion {
        Distortion::None => &[],
        Distortion::BrownConrady(k) => k,
        Distortion::KannalaBrandt(k) => k,
    };
    if coefficients.iter().all(|k| k.is_finite() && k.abs() < 1e6) {
        return Ok(());
    }
    let fault = format!("its distortion is {coefficients:?}");
    Err(Error::Camera { camera: camera.to_owned(), fault })
}

/// Refuses sizes that no camera has.
pub(super) fn check_size(
    camera: &str,
    [width, height]: [usize; 2],
    limits: &Limits,
) -> Result<(), Error> {
    let pixels = width.checked_mul(height).filter(|n| *n <= limits.image_pixels);
    match pixels {
        Some(0) => Err(Error::Camera {
            camera: camera.to_owned(),
            fault: format!("its images are {width} x {height} pixels"),
        }),
        Some(_) => Ok(()),
        None => Err(Error::TooMany {
            what: "pixels of an image",
            count: (width as u64).saturating_mul(height as u64),
            limit: limits.image_pixels as u64,
        }),
    }
}

/// The pose with the rotation nearest to what was written.
pub(super) fn settle_pose(camera: &str, pose: &Pose) -> Result<Pose, Error> {
    let fail = |fault: String| Err(Error::Camera { camera: camera.to_owned(), fault });
    let Pose { rotation: r, translation } = pose;
    if !pose.is_finite() {
        return fail("its pose has numbers that are not finite".to_owned());
    }
    if translation.iter().any(|x| x.abs() > FARTHEST_M) {
        return fail(format!("it stands at {translation:?} m: are these the right units?"));
    }
    let dot = |a: &[f64; 3], b: &[f64; 3]| geometry::dot(*a, *b);
    let off = |i: usize, j: usize| (dot(&r[i], &r[j]) - f64::from(u8::from(i == j))).abs();
    let worst = (0..9).map(|n| off(n / 3, n % 3)).fold(0.0, f64::max);
    if worst > ORTHONORMAL {
        return fail(format!(
            "its pose is no rotation: rows are off orthonormal by {worst:.3} (limit {ORTHONORMAL})"
        ));
    }
    if dot(&r[0], &geometry::cross(r[1], r[2])) < 0.0 {
        return Err(Error::MirroredPose(camera.to_owned()));
    }
    // Newton's iteration to the nearest rotation; it doubles the digits each time.
    let mut rotation = *r;
    for _ in 0..3 {
        let m = rotation;
        let columns: [[f64; 3]; 3] = std::array::from_fn(|j| m.map(|row| row[j]));
        let gram: [[f64; 3]; 3] =
            std::array::from_fn(|i| std::array::from_fn(|j| dot(&columns[i], &columns[j])));
        rotation = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                1.5 * m[i][j] - 0.5 * (0..3).map(|k| m[i][k] * gram[k][j]).sum::<f64>()
            })
        });
    }
    Ok(Pose { rotation, translation: *translation })
}
