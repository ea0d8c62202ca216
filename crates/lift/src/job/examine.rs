//! Checks of a recording before its frames are read.

use bendtwin_capture::raw::{Camera, Recording, Tracks};

use crate::Error;

/// Most tracks times frames; an ingest holds a few dozen bytes for each.
const MAX_TRACK_POINTS: usize = 12_000_000;
/// Most tracks.
const MAX_TRACKS: usize = 100_000;
/// Most pixels of an image.
const MAX_PIXELS: usize = 1 << 26;
/// Most cameras.
const MAX_CAMERAS: usize = 64;
/// Most frames.
const MAX_FRAMES: usize = 1_000_000;

/// Checks sizes and numbers of a recording.
pub(super) fn examine(recording: &Recording) -> Result<(), Error> {
    let wrong = |why: String| Err(Error::Inconsistent(why));
    let frames = recording.frame_count;
    if recording.cameras.is_empty() || recording.cameras.len() > MAX_CAMERAS {
        return wrong(format!(
            "it has {} cameras: it needs 1 to {MAX_CAMERAS}",
            recording.cameras.len()
        ));
    }
    if frames == 0 || frames > MAX_FRAMES {
        return wrong(format!("it has {frames} frames: it needs 1 to {MAX_FRAMES}"));
    }
    if recording.train_frame_count > frames {
        return wrong(format!(
            "{} frames are for fitting, but there are {frames}",
            recording.train_frame_count
        ));
    }
    if !(recording.fps.is_finite() && recording.fps > 0.0) {
        return wrong(format!("it has {} frames per second", recording.fps));
    }
    if !recording.truth_tracks.len().is_multiple_of(frames) {
        return wrong(format!(
            "{} positions of clean tracks do not divide into {frames} frames",
            recording.truth_tracks.len()
        ));
    }
    recording.cameras.iter().try_for_each(|camera| examine_camera(camera, frames))
}

fn examine_camera(camera: &Camera, frames: usize) -> Result<(), Error> {
    let wrong = |why: String| Err(Error::Inconsistent(format!("camera {}: {why}", camera.name)));
    let pixels = camera.width.saturating_mul(camera.height);
    if pixels == 0 || pixels > MAX_PIXELS {
        return wrong(format!("its images have {} x {} pixels", camera.width, camera.height));
    }
    let i = &camera.intrinsics;
    if ![i.fx, i.fy, i.cx, i.cy].iter().all(|x| x.is_finite()) || i.fx <= 0.0 || i.fy <= 0.0 {
        return wrong(format!("its focal lengths are {} and {} pixels", i.fx, i.fy));
    }
    if camera.poses.len() != 1 && camera.poses.len() != frames {
        return wrong(format!(
            "it has {} poses: give one, or one for each of {frames} frames",
            camera.poses.len()
        ));
    }
    let numbers =
        camera.poses.iter().flat_map(|p| p.rotation.as_flattened().iter().chain(&p.translation));
    if !numbers.into_iter().all(|x| x.is_finite()) {
        return wrong("a pose is not finite".to_owned());
    }
    Ok(())
}

/// Checks the sizes of tracks, by camera.
pub(super) fn examine_tracks(
    recording: &Recording,
    tracks: &[Option<Tracks>],
) -> Result<(), Error> {
    let frames = recording.frame_count;
    let mut total = 0usize;
    for (camera, tracks) in recording.cameras.iter().zip(tracks) {
        let Some(tracks) = tracks else { continue };
        total = total.saturating_add(tracks.count);
        let needed = tracks.count.saturating_mul(frames);
        if tracks.points.len() != needed || tracks.visible.len() != needed {
            return Err(Error::Inconsistent(format!(
                "camera {} has {} tracks with {} pixels and {} flags over {frames} frames",
                camera.name,
                tracks.count,
                tracks.points.len(),
                tracks.visible.len()
            )));
        }
    }
    if total > MAX_TRACKS || total.saturating_mul(frames) > MAX_TRACK_POINTS {
        return Err(Error::TooManyTracks { tracks: total, frames });
    }
    Ok(())
}
