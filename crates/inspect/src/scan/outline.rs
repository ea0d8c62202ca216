//! Registration of depth and colour onto the masks of one image: depth must step back and colour
//! must change where the outline of a mask is. If they do so elsewhere, one of them lies on another
//! grid.
//!
//! Pairs of spots are taken across the outline of both masks together. Under a [`Warp`], a pair
//! agrees with the depth image if its outer spot is farther away than its inner one; the share of
//! pairs that agree measures how well a warp fits.

use std::ops::RangeInclusive;

use bendtwin_capture::raw::{Camera, ColorImage, DepthImage, Mask};

use crate::{
    statistics::{mean, share},
    thresholds::OutlineThresholds,
};

/// Scales that are tried, and their ratio: fields of view of the two imagers of usual depth cameras
/// differ by less.
const SCALES: RangeInclusive<i32> = -17..=17;
const SCALE_RATIO: f64 = 1.04;
/// Shifts that are tried with them [steps of the width of the image].
const SHIFTS: RangeInclusive<i32> = -4..=4;
const SHIFT_STEP: f64 = 0.015;
/// Pairs with which that is done.
const SCREENED_PAIRS: usize = 60;
/// Pairs of an image that are kept.
const MAX_PAIRS: usize = 360;
/// Half the side of the square in which the direction of an outline is found [px].
const NORMAL_REACH: i64 = 3;

/// The pixel of another image in which a pixel of the mask lies: mirrored, scaled and shifted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Warp {
    /// True for each axis, columns and rows, that is mirrored.
    pub(crate) mirrored: [bool; 2],
    /// Pixels of the other image per pixel of the mask, about the principal point.
    pub(crate) scale: f64,
    /// Columns and rows [px].
    pub(crate) shift_px: [f64; 2],
}

impl Warp {
    /// Both images on one grid.
    pub(crate) const NONE: Self = Self { mirrored: [false; 2], scale: 1.0, shift_px: [0.0; 2] };

    fn apply(&self, camera: &Camera, pixel: [f64; 2]) -> [f64; 2] {
        let size = [camera.width as f64, camera.height as f64];
        let center = [camera.intrinsics.cx, camera.intrinsics.cy];
        std::array::from_fn(|a| {
            let at = if self.mirrored[a] { size[a] - 1.0 - pixel[a] } else { pixel[a] };
            center[a] + self.scale * (at - center[a]) + self.shift_px[a]
        })
    }
}

/// The best warp of an image, and the shares of pairs that agree, 0..=1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fit {
    pub(crate) warp: Warp,
    pub(crate) share: f64,
    /// With both images on one grid.
    pub(crate) declared_share: f64,
    /// Distance by which the warp moves what the mask shows [px].
    pub(crate) moved_px: f64,
}

/// Fits of depth and colour to the masks of one image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OutlineFit {
    pub(crate) depth: Fit,
    /// Share of the pairs whose outer spot is nearer instead of farther away, 0..=1.
    pub(crate) forward_share: f64,
    /// The best way of mirroring colour.
    pub(crate) color: Option<Fit>,
    /// Agreement of colour with the masks under the warp of depth.
    pub(crate) color_with_depth: Option<f64>,
}

/// A spot inside the outline and one outside [px].
type Pair = [[f64; 2]; 2];

/// Registers depth and colour onto the masks of an image; `None` if there is too little of an
/// outline.
pub(crate) fn measure(
    camera: &Camera,
    masks: [Option<&Mask>; 2],
    depth: &DepthImage,
    color: Option<&ColorImage>,
    thresholds: &OutlineThresholds,
) -> Option<OutlineFit> {
    let pairs = pairs(camera, masks, thresholds);
    if pairs.len() < thresholds.min_pairs {
        return None;
    }
    let ratio = 1.0 + thresholds.step_share as f32;
    let steps = |warp: &Warp, pairs: &[Pair]| {
        let at = |pixel| nearest_depth(depth, warp.apply(camera, pixel));
        let depths = pairs.iter().map(|[inner, outer]| Some((at(*inner)?, at(*outer)?)));
        // What has no depth says nothing: a black glove, a hole.
        let known: Vec<Option<(f32, f32)>> =
            depths.filter(|d| d.is_none_or(|(inner, _)| inner > 0.0)).collect();
        if (known.len() as f64) < thresholds.min_known_share * pairs.len() as f64 {
            return [0.0; 2];
        }
        let share_of = |agrees: &dyn Fn(f32, f32) -> bool| {
            let agreeing = known.iter().flatten().filter(|(i, o)| agrees(*i, *o)).count();
            share(agreeing, known.len())
        };
        let back = share_of(&|inner, outer| outer <= 0.0 || outer > inner * ratio);
        [back, share_of(&|inner, outer| outer > 0.0 && inner > outer * ratio)]
    };
    let forward_share = steps(&Warp::NONE, &pairs)[1];
    let depth = fit(camera, &pairs, thresholds, |warp, pairs| steps(warp, pairs)[0]);
    let changes = |warp: &Warp| {
        let color = color?;
        let at = |pixel| mean_color(color, warp.apply(camera, pixel));
        let change = |[inner, outer]: &Pair| {
            let (Some(a), Some(b)) = (at(*inner), at(*outer)) else { return 0.0 };
            let apart: f64 = a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum();
            (apart / thresholds.full_contrast).min(1.0)
        };
        mean(pairs.iter().map(change))
    };
    let mirrored = [[true, false], [false, true], [true, true]]
        .map(|mirrored| Warp { mirrored, ..Warp::NONE })
        .into_iter()
        .filter_map(|warp| Some((warp, changes(&warp)?)))
        .max_by(|a, b| a.1.total_cmp(&b.1));
    let color = mirrored.and_then(|(warp, share)| {
        let declared_share = changes(&Warp::NONE)?;
        Some(Fit { warp, share, declared_share, moved_px: moved_px(camera, &pairs, &warp) })
    });
    Some(OutlineFit { depth, forward_share, color, color_with_depth: changes(&depth.warp) })
}

/// The warp under which most pairs agree.
fn fit(
    camera: &Camera,
    pairs: &[Pair],
    thresholds: &OutlineThresholds,
    agreement: impl Fn(&Warp, &[Pair]) -> f64,
) -> Fit {
    let declared_share = agreement(&Warp::NONE, pairs);
    let width = camera.width as f64;
    if declared_share > thresholds.good_share {
        // So well that only a shift by some pixels can be better.
        let (warp, share) = settle(Warp::NONE, width, pairs, &agreement);
        return Fit { warp, share, declared_share, moved_px: moved_px(camera, pairs, &warp) };
    }
    let few: Vec<Pair> =
        pairs.iter().step_by(pairs.len().div_ceil(SCREENED_PAIRS)).copied().collect();
    let mut best = (Warp::NONE, agreement(&Warp::NONE, &few));
    let consider = |warp: Warp, pairs: &[Pair], best: &mut (Warp, f64)| {
        let found = agreement(&warp, pairs);
        if found > best.1 {
            *best = (warp, found);
        }
    };
    for mirrored in [[false, false], [true, false], [false, true], [true, true]] {
        for step in SCALES {
            for dy in SHIFTS {
                for dx in SHIFTS {
                    let shift_px = [dx, dy].map(|s| f64::from(s) * SHIFT_STEP * width);
                    let scale = SCALE_RATIO.powi(step);
                    consider(Warp { mirrored, scale, shift_px }, &few, &mut best);
                }
            }
        }
    }
    // The declared grid is refined too: nearly everything is right or a little shifted.
    let refined = [Warp::NONE, best.0].map(|start| settle(start, width, pairs, &agreement));
    let [near, far] = refined;
    let (warp, found) = if far.1 > near.1 + 0.05 { far } else { near };
    Fit { warp, share: found, declared_share, moved_px: moved_px(camera, pairs, &warp) }
}

/// The middle of the best warps, found from one step by step.
fn settle(
    start: Warp,
    width: f64,
    pairs: &[Pair],
    agreement: impl Fn(&Warp, &[Pair]) -> f64,
) -> (Warp, f64) {
    let mut found = refine(start, width, pairs, &agreement);
    for _ in 0..2 {
        // A shift near the end of the reach may continue beyond it.
        let [x, y] = [0, 1].map(|a| found.0.shift_px[a] - start.shift_px[a]);
        if x.hypot(y) < 2.0 {
            break;
        }
        let shift_px = found.0.shift_px.map(f64::round);
        found = refine(Warp { shift_px, ..found.0 }, width, pairs, &agreement);
    }
    found
}

/// The middle of the best warps around one, shifted by a few pixels, and their share.
fn refine(
    start: Warp,
    width: f64,
    pairs: &[Pair],
    agreement: impl Fn(&Warp, &[Pair]) -> f64,
) -> (Warp, f64) {
    let reach = (SHIFT_STEP * width).ceil().clamp(4.0, 10.0) as i32;
    let scales: &[f64] = if start.scale == 1.0 { &[1.0] } else { &[0.96, 0.98, 1.0, 1.02, 1.04] };
    let mut tried = Vec::new();
    for scale in scales {
        for dy in -reach..=reach {
            for dx in -reach..=reach {
                let shift_px =
                    [start.shift_px[0] + f64::from(dx), start.shift_px[1] + f64::from(dy)];
                let warp = Warp { scale: start.scale * scale, shift_px, ..start };
                tried.push((warp, agreement(&warp, pairs)));
            }
        }
    }
    let best = tried.iter().map(|t| t.1).fold(0.0, f64::max);
    // Spots lie a few pixels beside the outline, so that many warps agree equally well.
    let good: Vec<Warp> = tried.into_iter().filter(|t| t.1 > best - 0.02).map(|t| t.0).collect();
    let middle = |of: &dyn Fn(&Warp) -> f64| mean(good.iter().map(of)).unwrap_or(0.0);
    let shift_px = [middle(&|w| w.shift_px[0]), middle(&|w| w.shift_px[1])];
    (Warp { scale: middle(&|w| w.scale), shift_px, ..start }, best)
}

fn moved_px(camera: &Camera, pairs: &[Pair], warp: &Warp) -> f64 {
    let moved = pairs.iter().map(|[inner, _]| {
        let to = warp.apply(camera, *inner);
        (to[0] - inner[0]).hypot(to[1] - inner[1])
    });
    mean(moved).unwrap_or(0.0)
}

/// Pairs of spots across the outline of both masks together.
fn pairs(camera: &Camera, masks: [Option<&Mask>; 2], thresholds: &OutlineThresholds) -> Vec<Pair> {
    let (width, height) = (camera.width as i64, camera.height as i64);
    let shown = |x: i64, y: i64| {
        let (Ok(column), Ok(row)) = (usize::try_from(x), usize::try_from(y)) else { return false };
        masks.into_iter().flatten().any(|m| m.get(column, row) == Some(true))
    };
    let beside = (thresholds.beside_widths * width as f64).clamp(2.0, 4.0);
    let mut found = Vec::new();
    for y in NORMAL_REACH..height - NORMAL_REACH {
        for x in NORMAL_REACH..width - NORMAL_REACH {
            let is_rim = shown(x, y)
                && [(1, 0), (-1, 0), (0, 1), (0, -1)].iter().any(|(i, j)| !shown(x + i, y + j));
            if !is_rim {
                continue;
            }
            let mut outward = [0.0; 2];
            for j in -NORMAL_REACH..=NORMAL_REACH {
                for i in -NORMAL_REACH..=NORMAL_REACH {
                    if !shown(x + i, y + j) {
                        outward = [outward[0] + i as f64, outward[1] + j as f64];
                    }
                }
            }
            let length = outward[0].hypot(outward[1]);
            // Without a clear direction it is a thread or a speck.
            if length < thresholds.min_direction {
                continue;
            }
            let spot = |at: f64| {
                let [i, j] = outward.map(|o| o / length * at);
                [x as f64 + i, y as f64 + j]
            };
            found.push([spot(-beside), spot(beside + 1.0)]);
        }
    }
    let step = found.len().div_ceil(MAX_PAIRS).max(1);
    found.into_iter().step_by(step).collect()
}

/// The nearest depth in the three by three pixels around a place [m], 0 if no pixel has depth;
/// `None` outside the image.
fn nearest_depth(depth: &DepthImage, [x, y]: [f64; 2]) -> Option<f32> {
    let (x, y) = (x.round(), y.round());
    let inside = x >= 1.0 && y >= 1.0;
    let (x, y) = (x as usize, y as usize);
    if !inside || x + 1 >= depth.width || y + 1 >= depth.height {
        return None;
    }
    let here = depth.pixels[y * depth.width + x];
    if here > 0.0 {
        return Some(here);
    }
    let around = (y - 1..=y + 1).flat_map(|r| depth.row(r)[x - 1..=x + 1].iter().copied());
    Some(
        around
            .filter(|d| *d > 0.0)
            .fold(0.0, |least, d| if least > 0.0 { d.min(least) } else { d }),
    )
}

/// The mean colour of the three by three pixels around a place; `None` outside the image.
fn mean_color(color: &ColorImage, [x, y]: [f64; 2]) -> Option<[f64; 3]> {
    let (x, y) = (x.round(), y.round());
    let inside = x >= 1.0 && y >= 1.0;
    let (x, y) = (x as usize, y as usize);
    if !inside || x + 1 >= color.width || y + 1 >= color.height {
        return None;
    }
    let mut sum = [0.0; 3];
    for pixel in (y - 1..=y + 1).flat_map(|r| color.row(r)[x - 1..=x + 1].iter()) {
        sum.iter_mut().zip(pixel).for_each(|(s, p)| *s += f64::from(*p) / 9.0);
    }
    Some(sum)
}

#[cfg(test)]
mod tests;
