//! Brings a mesh of unknown pose and size onto observed points of the object's surface.
//!
//! Iterative closest points with scale, from many starts: rotations that bring principal axes
//! together and rotations spread over all others, each at a few sizes, tried on few points; the
//! best continue with all points and with the distance along the surface's normal. Observation is
//! partial, so every observed point should lie on the mesh, but only the nearest half of the mesh
//! has to have been observed: without that half, a mesh much too large would explain a flat patch.

mod coarse;
mod fine;
mod starts;

use bendtwin_core::Point;
use rayon::prelude::*;

use crate::{Bvh, Error, Mesh, Similarity, Vec3, cloud::Cloud, surface::Thinning, vec3};

/// The pose and size of a mesh, and how well it fits there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aligned {
    /// From the mesh's axes and unit to those of the observed points.
    pub similarity: Similarity,
    /// Root mean square distance of the inliers from the surface [m].
    pub rms_m: f64,
    /// Share of the observed points within [`Aligned::within_m`] of the surface.
    pub inlier_share: f64,
    /// Distance within which a point counts as on the mesh [m]: 2 % of the object's extent.
    pub within_m: f64,
}

/// Least observed points.
const MIN_POINTS: usize = 30;
/// Largest distance of an inlier, over the observed extent.
const INLIER_DISTANCE: f64 = 0.02;
/// Least share of inliers of an alignment.
const MIN_INLIER_SHARE: f64 = 0.75;
/// Observed points are thinned to about as many: more do not make a pose better.
const MAX_OBSERVED: f64 = 1000.0;
/// Samples of the mesh's surface.
const SURFACE_SAMPLES: f64 = 1200.0;
/// Starts that reach the fine stage.
const FINALISTS: usize = 8;

/// Finds rotation, uniform scale and translation that bring `mesh` onto `observed` [m], points of
/// the object's surface that may cover only a part of it and may have some outliers. Deterministic.
///
/// # Errors
/// If there are too few points, or if even the best pose leaves a quarter of them off the surface.
pub fn align(mesh: &Mesh, observed: &[Point]) -> Result<Aligned, Error> {
    let mut finite: Vec<Vec3> = observed.iter().map(|p| vec3(*p)).collect();
    finite.retain(|p| p.iter().all(|x| x.is_finite()));
    let few = Error::TooFewPoints { needed: MIN_POINTS, found: finite.len() };
    if finite.len() < MIN_POINTS {
        return Err(few);
    }
    let extent = extent(&finite);
    let thinned = thin(finite, extent);
    let surface = surface_samples(mesh)?;
    let bvh = Bvh::new(mesh);
    let (Some(cloud), Some(surface)) = (Cloud::new(thinned), Cloud::new(surface)) else {
        return Err(few);
    };

    let starts = starts::starts(&surface.points, &cloud.points);
    let finalists = coarse::search(starts, &surface, &cloud, FINALISTS);
    let within_m = INLIER_DISTANCE * extent;
    let refined: Vec<fine::Refined> = finalists
        .into_par_iter()
        .map(|s| fine::refine(s, &bvh, &surface, &cloud, within_m))
        .collect();
    let best = refined.into_iter().min_by(|a, b| a.score.total_cmp(&b.score));
    let failed = Error::NotAligned { inlier_share: 0.0, within_m };
    let Some(best) = best else { return Err(failed) };
    let aligned = measure(best.similarity, &bvh, &cloud.points, within_m);
    if aligned.inlier_share.is_nan() || aligned.inlier_share < MIN_INLIER_SHARE {
        return Err(Error::NotAligned { inlier_share: aligned.inlier_share, within_m });
    }
    Ok(aligned)
}

/// Diagonal of the box around the middle 98 % of the points along each axis.
fn extent(points: &[Vec3]) -> f64 {
    let along = |axis: usize| {
        let mut values: Vec<f64> = points.iter().map(|p| p[axis]).collect();
        values.sort_by(f64::total_cmp);
        let cut = values.len() / 100;
        values[values.len() - 1 - cut] - values[cut]
    };
    Vec3::new(along(0), along(1), along(2)).norm()
}

/// Evens out the density, which depends on how near the cameras were.
fn thin(points: Vec<Vec3>, extent: f64) -> Vec<Vec3> {
    let mut spacing = extent / MAX_OBSERVED.sqrt() / 2.0;
    loop {
        let mut thinning = Thinning::new(spacing.max(f64::MIN_POSITIVE));
        points.iter().for_each(|p| thinning.offer(*p));
        if thinning.kept.len() as f64 <= MAX_OBSERVED || spacing <= 0.0 {
            return thinning.kept;
        }
        spacing *= 1.3;
    }
}

fn surface_samples(mesh: &Mesh) -> Result<Vec<Vec3>, Error> {
    // A Poisson disc pattern holds about 0.7 points per squared spacing.
    let spacing = (0.7 * mesh.area() / SURFACE_SAMPLES).sqrt();
    Ok(mesh.sample_surface(spacing as f32, 0)?.into_iter().map(vec3).collect())
}

fn measure(similarity: Similarity, bvh: &Bvh, observed: &[Vec3], within_m: f64) -> Aligned {
    let distances = observed.iter().filter_map(|o| {
        let (_, square, _) = bvh.nearest(similarity.apply_inverse(*o))?;
        Some(square.sqrt() * similarity.scale)
    });
    let (mut inliers, mut squares) = (0_usize, 0.0);
    for d in distances.filter(|d| *d <= within_m) {
        inliers += 1;
        squares += d * d;
    }
    Aligned {
        similarity,
        rms_m: (squares / inliers.max(1) as f64).sqrt(),
        inlier_share: inliers as f64 / observed.len().max(1) as f64,
        within_m,
    }
}

#[cfg(test)]
mod tests;
