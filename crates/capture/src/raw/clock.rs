//! Cameras that took their images when they liked, brought onto common frames.

pub(super) mod retimed;
pub(super) mod samples;

use crate::{Error, files::at_most};

/// Assignment of images to frames.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Aligned {
    /// Frames per second.
    pub(super) fps: f64,
    /// Time of each frame [T] [s], by the clock of the camera with the most images.
    pub(super) times_s: Vec<f64>,
    /// Index into a camera's times, shape [camera, T]; `None` where it has no image.
    pub(super) images: Vec<Vec<Option<usize>>>,
}

/// Share of a frame by which an image at either end may lie outside.
const REACH: f64 = 0.6;

/// Frames follow the clock of the camera with the most images, its gaps filled up; each image of
/// another camera goes to the frame nearest in time, at most one to each. `times` [s] must ascend;
/// shape [camera, images].
///
/// # Errors
/// If there are too many frames, or too few to determine their rate.
pub(super) fn align(times: &[Vec<f64>], limit: usize) -> Result<Aligned, Error> {
    let reference = times.iter().max_by_key(|t| t.len()).map_or(&[][..], Vec::as_slice);
    // The first among equals, not the last.
    let reference = times.iter().find(|t| t.len() == reference.len()).map_or(reference, |t| t);
    let mut steps: Vec<f64> =
        reference.windows(2).map(|w| w[1] - w[0]).filter(|step| *step > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    let Some(period) = steps.get(steps.len() / 2).copied().filter(|p| p.is_finite()) else {
        return Err(Error::Lengths(
            "no camera has two images at different times: record a video, and keep the cameras' clocks".to_owned(),
        ));
    };
    let mut ticks: Vec<f64> = Vec::with_capacity(reference.len());
    for &time in reference {
        if let Some(&last) = ticks.last() {
            let gap = time - last;
            // Two images of one instant are one frame.
            if gap < 0.01 * period {
                continue;
            }
            let missing = ((gap / period).round() - 1.0).max(0.0);
            let count = ticks.len().saturating_add(missing as usize);
            at_most("frames of a recording", count, limit)?;
            let parts = missing + 1.0;
            ticks.extend((1..=missing as usize).map(|i| last + gap * i as f64 / parts));
        }
        ticks.push(time);
    }
    at_most("frames of a recording", ticks.len(), limit)?;
    let images = times.iter().map(|times| assign(times, &ticks, REACH * period)).collect();
    Ok(Aligned { fps: 1.0 / period, times_s: ticks, images })
}

fn assign(times: &[f64], ticks: &[f64], reach: f64) -> Vec<Option<usize>> {
    let mut images: Vec<Option<usize>> = vec![None; ticks.len()];
    for (image, &time) in times.iter().enumerate() {
        let after = ticks.partition_point(|tick| *tick < time);
        let off = |tick: usize| ticks.get(tick).map_or(f64::INFINITY, |t| (t - time).abs());
        let tick = if after > 0 && off(after - 1) <= off(after) { after - 1 } else { after };
        let Some(place) = images.get_mut(tick) else { continue };
        let nearer = place.is_none_or(|other| off(tick) < (ticks[tick] - times[other]).abs());
        let inside = tick > 0 && tick + 1 < ticks.len();
        if nearer && (inside || off(tick) <= reach) {
            *place = Some(image);
        }
    }
    images
}

#[cfg(test)]
mod tests;
