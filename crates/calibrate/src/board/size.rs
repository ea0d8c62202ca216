//! The size of a board by depth: a printer scales pages, and a square of 30 mm may have 29.

use bendtwin_capture::raw::{DepthImage, Recording};
use bendtwin_core::{CancelToken, Finding};

use super::{GUIDE, Observation, join::Joined, layout::Board};
use crate::{Error, error::check as unless_cancelled, statistics::median};

/// Frames whose depth is read.
const FRAMES: usize = 6;
/// Least corners with depth.
const MIN_CORNERS: usize = 24;
/// Deviations of the size that depth cameras do not have themselves.
const OFF: f64 = 0.02;
/// Deviation that makes a calibration useless.
const FAR_OFF: f64 = 0.1;

/// Compares the distances of corners with their depth; `None` if they agree or there is no depth.
pub(crate) fn check(
    recording: &Recording,
    board: &Board,
    joined: &Joined,
    cancel: &CancelToken,
) -> Result<Option<Finding>, Error> {
    let usable = recording.usable();
    let mut ratios = Vec::new();
    for camera in 0..recording.cameras.len() {
        let mut frames = usable.source.frames(camera)?;
        for (place, frame) in joined.frames.iter().enumerate().take(FRAMES) {
            unless_cancelled(cancel)?;
            let seen = joined.seen.iter().filter(|o| o.camera == camera && o.board == place);
            let seen: Vec<&Observation> = seen.collect();
            if seen.is_empty() {
                continue;
            }
            let Some(depth) = frames.depth(*frame)? else { continue };
            ratios.extend(seen.iter().filter_map(|o| {
                let ratio = around(&depth, o.at)? / joined.poses.place(o).z;
                ratio.is_finite().then_some(ratio)
            }));
        }
    }
    if ratios.len() < MIN_CORNERS {
        return Ok(None);
    }
    let Some(ratio) = median(ratios.into_iter()) else { return Ok(None) };
    let off = (ratio - 1.0).abs();
    if off < OFF {
        return Ok(None);
    }
    let s = &board.settings;
    let measured = 1e3 * s.square_m * ratio;
    let message = format!(
        "the board measures {} of the stated size by depth, a square {measured:.1} mm instead of {:.1} mm: measure it with \
         a ruler, print at 100 %, or check the unit of depth ({GUIDE})",
        share(ratio),
        1e3 * s.square_m
    );
    let severity = if off > FAR_OFF {
        bendtwin_core::Severity::Error
    } else {
        bendtwin_core::Severity::Warning
    };
    Ok(Some(Finding::from_sentence(severity, "BOARD_SIZE", message).number("ratio", ratio)))
}

/// A ratio to three digits.
fn share(ratio: f64) -> String {
    if (0.01..100.0).contains(&ratio) { format!("{ratio:.3}") } else { format!("{ratio:.2e}") }
}

/// Median depth around a pixel [m].
fn around(depth: &DepthImage, at: [f64; 2]) -> Option<f64> {
    let near = (-2..=2_i64).flat_map(|dy| (-2..=2_i64).map(move |dx| (dx, dy)));
    let depths = near.filter_map(|(dx, dy)| {
        let column = usize::try_from(at[0].round() as i64 + dx).ok()?;
        let row = usize::try_from(at[1].round() as i64 + dy).ok()?;
        let metres = depth.get(column, row).filter(|d| d.is_finite() && *d > 0.0)?;
        Some(f64::from(metres))
    });
    let depths: Vec<f64> = depths.collect();
    (depths.len() >= 9).then(|| median(depths.into_iter()))?
}
