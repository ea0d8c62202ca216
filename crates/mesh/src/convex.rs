//! Fills a surface-only cloud from its nearly convex parts, for objects without a mesh.
//!
//! Cameras see a shell. Behind a convex part of it, the object is most likely full; between parts
//! (limbs, the inside of a loop) it is most likely empty. So the cloud is cut as long as the hulls
//! of the pieces are together clearly smaller than the hull of the whole, and each hull is filled.
//! Cutting a convex shell gains nothing, even one of which only a side was seen.

mod hull;

use bendtwin_core::Point;

use self::hull::Hull;
use crate::{Error, Vec3, cloud::Cloud, interior::Grid, surface::Thinning, vec3};

/// Least share of a hull's volume that a cut has to save.
const MIN_SAVED_SHARE: f64 = 0.05;
/// Shares of a part's points before a cut, along each of its axes.
const CUT_SHARES: [f64; 9] = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];
/// Parts with fewer points are not cut further.
const MIN_POINTS: usize = 30;
/// At most 2 to this many parts.
const MAX_DEPTH: usize = 6;
/// A filled point is at most this share of its part's smallest extent away from an observed one:
/// half of it if the part was seen from all sides, all of it if from one.
const MAX_DISTANCE_SHARE: f64 = 0.8;
/// Observed points are thinned to about as many.
const MAX_OBSERVED: f64 = 2000.0;

/// Points of a grid inside the nearly convex parts of a cloud of surface points, at least half a
/// spacing from the cloud. A guess, to be used only on request.
///
/// # Errors
/// If the spacing is no length, or so fine that memory would not hold the grid.
pub fn convex_interior(points: &[Point], spacing_m: f32) -> Result<Vec<Point>, Error> {
    let finite = || points.iter().filter(|p| p.iter().all(|x| x.is_finite()));
    let Some(first) = finite().next().copied() else { return Ok(Vec::new()) };
    let [low, high] = finite().fold([first; 2], |[low, high], p| {
        [std::array::from_fn(|a| low[a].min(p[a])), std::array::from_fn(|a| high[a].max(p[a]))]
    });
    let grid = Grid::over([low, high], spacing_m)?;
    let extent = (vec3(high) - vec3(low)).norm();
    let mut thinning = Thinning::new((extent / MAX_OBSERVED.sqrt() / 2.0).max(f64::MIN_POSITIVE));
    finite().for_each(|p| thinning.offer(vec3(*p)));

    let directions = hull::directions();
    let mut parts = Vec::new();
    if let Some(whole) = Hull::of(&thinning.kept, &directions) {
        cut(whole, thinning.kept, MAX_DEPTH, &directions, &mut parts);
    }
    let Some(cloud) = Cloud::new(finite().map(|p| vec3(*p)).collect()) else {
        return Ok(Vec::new());
    };
    Ok(grid.select(|p| {
        let p = vec3(p);
        let containing = parts.iter().filter(|hull| hull.contains(p, &directions));
        let Some(thickness) = containing.map(|h| h.extents[2]).reduce(f64::max) else {
            return false;
        };
        let nearest = cloud.nearest(p).1.sqrt();
        nearest >= f64::from(spacing_m) / 2.0 && nearest <= MAX_DISTANCE_SHARE * thickness
    }))
}

/// Points on one side of a cut, and their hull.
type Half = (Hull, Vec<Vec3>);

/// Cuts a part into nearly convex ones.
fn cut(hull: Hull, members: Vec<Vec3>, depth: usize, directions: &[Vec3], parts: &mut Vec<Hull>) {
    let limit = hull.volume * (1.0 - MIN_SAVED_SHARE);
    let mut best: Option<(f64, [Half; 2])> = None;
    if depth > 0 && members.len() >= MIN_POINTS {
        for axis in hull.axes {
            let mut sorted = members.clone();
            sorted.sort_by(|a, b| axis.dot(a).total_cmp(&axis.dot(b)));
            for share in CUT_SHARES {
                let (left, right) = sorted.split_at((sorted.len() as f64 * share) as usize);
                let halves = [left, right].map(|half| Hull::of(half, directions));
                let [Some(a), Some(b)] = halves else { continue };
                let volume = a.volume + b.volume;
                if volume < best.as_ref().map_or(limit, |(least, _)| *least) {
                    best = Some((volume, [(a, left.to_vec()), (b, right.to_vec())]));
                }
            }
        }
    }
    match best {
        Some((_, halves)) => {
            for (hull, half) in halves {
                cut(hull, half, depth - 1, directions, parts);
            }
        }
        None => parts.push(hull),
    }
}

#[cfg(test)]
mod tests;
