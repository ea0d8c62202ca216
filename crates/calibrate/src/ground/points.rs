//! Points that cameras measured outside the masks.

use bendtwin_capture::raw::{Recording, Region};
use bendtwin_core::{CancelToken, geometry::wide};

use super::{Measured, NEAR_M};
use crate::{Error, board::spread, error::check};

/// Frames whose depth is read.
const FRAMES: usize = 4;
/// Points of a camera in a frame.
const POINTS: usize = 8_000;
/// Depth that counts [m].
const RANGE_M: std::ops::Range<f32> = 0.1..6.0;

pub(super) fn measured(
    recording: &Recording,
    cancel: &CancelToken,
) -> Result<Vec<Measured>, Error> {
    let usable = recording.usable();
    let mut points = Vec::new();
    for (index, camera) in recording.cameras.iter().enumerate() {
        let mut frames = usable.source.frames(index)?;
        for frame in spread(recording.frame_count, FRAMES) {
            check(cancel)?;
            let Some(depth) = frames.depth(frame)? else { continue };
            let masks =
                [frames.mask(frame, Region::Object)?, frames.mask(frame, Region::Manipulator)?];
            let step = ((depth.pixels.len() as f64 / POINTS as f64).sqrt().ceil() as usize).max(1);
            for row in (0..depth.height).step_by(step) {
                for column in (0..depth.width).step_by(step) {
                    let Some(metres) = depth.get(column, row) else { continue };
                    let masked = |mask: &Option<bendtwin_capture::raw::Mask>| {
                        mask.as_ref().is_some_and(|mask| mask.get(column, row) == Some(true))
                    };
                    if !RANGE_M.contains(&metres) || masks.iter().any(masked) {
                        continue;
                    }
                    let pixel = [column as f64, row as f64];
                    let at = camera.unproject(pixel, f64::from(metres), frame);
                    // Depth of stereo cameras errs with the square of distance.
                    let near_m = NEAR_M * f64::from(metres * metres).max(0.4);
                    if at.iter().all(|x| x.is_finite()) {
                        points.push(Measured { at: wide(at), near_m });
                    }
                }
            }
        }
    }
    Ok(points)
}
