//! A case before PhysTwin's alignment: `recording` of its description has the time of every image, and
//! cameras number their images by clocks of their own. They are brought onto common frames by time.

use std::collections::BTreeMap;

use bendtwin_core::Finding;

use super::MARKER;
use crate::{
    Error, Limits,
    raw::{Camera, clock, numbering::Images},
};

/// Times [s] of images by their number, by camera.
pub(super) type Times = BTreeMap<String, BTreeMap<String, f64>>;

/// Frames of a camera's images by their number.
pub(super) type Frames = BTreeMap<u64, u64>;

/// Numbers the images by common frames, sets the times of the cameras, and returns the frames of each
/// camera with a remark.
///
/// # Errors
/// If a camera has no times, or they do not ascend.
pub(super) fn align(
    times: &Times,
    images: &mut [[Images; 2]],
    cameras: &mut [Camera],
    limits: &Limits,
) -> Result<(Vec<Frames>, Finding), Error> {
    let fault = |fault: String| Error::Document { at: MARKER.to_owned(), fault };
    let mut numbers: Vec<Vec<u64>> = Vec::with_capacity(cameras.len());
    let mut instants: Vec<Vec<f64>> = Vec::with_capacity(cameras.len());
    for (index, (camera, [color, depth])) in cameras.iter().zip(images.iter()).enumerate() {
        let own = times.get(&index.to_string()).or_else(|| times.get(&camera.name));
        let own = own.ok_or_else(|| {
            fault(format!("`recording` has no times of camera {index} (`{}`)", camera.name))
        })?;
        let timed = own.iter().filter_map(|(number, time)| Some((number.parse().ok()?, *time)));
        let mut timed: Vec<(u64, f64)> =
            timed.filter(|(number, _)| color.has(*number) || depth.has(*number)).collect();
        timed.sort_by_key(|(number, _)| *number);
        if let Some(pair) = timed.windows(2).find(|pair| !(pair[0].1 < pair[1].1)) {
            return Err(fault(format!(
                "`recording` of camera {index}: image {} is not later than image {}",
                pair[1].0, pair[0].0
            )));
        }
        numbers.push(timed.iter().map(|(number, _)| *number).collect());
        instants.push(timed.iter().map(|(_, time)| *time).collect());
    }
    let aligned = clock::align(&instants, limits.recording_frames)?;
    let start = instants.iter().filter_map(|t| t.first()).copied().fold(f64::INFINITY, f64::min);
    let mut all = Vec::with_capacity(cameras.len());
    for (index, found) in aligned.images.iter().enumerate() {
        let mut frames = Frames::new();
        let mut times_s = vec![f64::NAN; aligned.frame_count];
        for (frame, image) in found.iter().enumerate() {
            let Some(image) = *image else { continue };
            frames.insert(numbers[index][image], frame as u64);
            times_s[frame] = instants[index][image] - start;
        }
        images[index].iter_mut().for_each(|images| images.renumber(&frames));
        cameras[index].times_s = times_s;
        all.push(frames);
    }
    let message = format!(
        "cameras number their images differently, and their times in `recording` of {MARKER} give {} common frames",
        aligned.frame_count
    );
    Ok((all, Finding::info("FRAMES_NUMBERED", message)))
}
