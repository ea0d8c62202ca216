//! The scale of a model: measured depth over the depth of its points, in the median over the points
//! of a camera, and over cameras.

use bendtwin_capture::raw::{DepthImage, Recording};
use bendtwin_core::CancelToken;
use nalgebra::Vector3;

use super::model::{Model, ModelImage};
use crate::{Error, error::check, lens::Lens, statistics::median};

/// Least points with depth by which a camera gives a scale.
const MIN_POINTS: usize = 12;
/// Most points of a camera that are measured.
const MAX_POINTS: usize = 50_000;
/// Depths of neighbouring pixels differ by less on one surface, as a share.
const ONE_SURFACE: f32 = 0.03;

/// The scale of a model.
pub(super) struct Scale {
    /// Metres in a unit of the model.
    pub(super) metres: f64,
    /// The same by each camera, where it has enough points.
    pub(super) cameras: Vec<Option<f64>>,
    /// Points with depth of all cameras.
    pub(super) points: usize,
}

pub(super) fn measure(
    model: &Model,
    recording: &Recording,
    images: &[&ModelImage],
    cancel: &CancelToken,
) -> Result<Scale, Error> {
    let usable = recording.usable();
    let mut cameras = Vec::new();
    let mut points = 0;
    for (index, (camera, image)) in recording.cameras.iter().zip(images).enumerate() {
        check(cancel)?;
        let mut frames = usable.source.frames(index)?;
        let frame = image.frame(recording.frame_count);
        // A frame without depth is replaced by the first that has some.
        let order = [frame].into_iter().chain((0..recording.frame_count).take(10));
        let mut depth = None;
        for frame in order {
            depth = frames.depth(frame)?;
            if depth.is_some() {
                break;
            }
        }
        let Some(depth) = depth else {
            cameras.push(None);
            continue;
        };
        let ratios = ratios(model, image, &Lens::of(camera), &depth);
        points += ratios.len();
        cameras.push((ratios.len() >= MIN_POINTS).then(|| median(ratios.into_iter())).flatten());
    }
    match median(cameras.iter().flatten().copied()) {
        Some(metres) if metres.is_finite() && metres > 0.0 => Ok(Scale { metres, cameras, points }),
        _ => Err(Error::Unsuited(format!(
            "depth was measured at {points} of the model's points, and a scale needs {MIN_POINTS} in a camera: record \
             depth, and check that the model's images are those of the recording"
        ))),
    }
}

fn ratios(model: &Model, image: &ModelImage, lens: &Lens, depth: &DepthImage) -> Vec<f64> {
    let pose = image.pose();
    let ratio = |at: [f64; 3]| {
        let place = Vector3::from(pose.moved(at));
        let measured = interpolated(depth, lens.pixel(place)?)?;
        let ratio = measured / place.z;
        (ratio.is_finite() && ratio > 0.0).then_some(ratio)
    };
    let seen: Vec<f64> =
        image.points.iter().take(MAX_POINTS).filter_map(|id| ratio(model.point(*id)?.at)).collect();
    if seen.len() >= MIN_POINTS {
        return seen;
    }
    // Some exporters do not say which image saw which point.
    let step = model.points.len().div_ceil(MAX_POINTS).max(1);
    model.points.iter().step_by(step).filter_map(|point| ratio(point.at)).collect()
}

/// Depth between pixels on one surface [m].
fn interpolated(depth: &DepthImage, [x, y]: [f64; 2]) -> Option<f64> {
    if !(x >= 0.0 && y >= 0.0) {
        return None;
    }
    let (column, row) = (x as usize, y as usize);
    let corner = |dc: usize, dr: usize| {
        depth.get(column + dc, row + dr).filter(|d| d.is_finite() && *d > 0.0)
    };
    let all = [corner(0, 0)?, corner(1, 0)?, corner(0, 1)?, corner(1, 1)?];
    let (low, high) =
        (all.iter().copied().fold(f32::MAX, f32::min), all.iter().copied().fold(0.0, f32::max));
    if high - low > ONE_SURFACE * high {
        return None;
    }
    let [a, b, c, d] = all.map(f64::from);
    let (fx, fy) = (x - column as f64, y - row as f64);
    Some((a * (1.0 - fx) + b * fx) * (1.0 - fy) + (c * (1.0 - fx) + d * fx) * fy)
}
