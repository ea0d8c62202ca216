//! The coarse stage of alignment: iterative closest points on few points, to separate promising
//! starts from hopeless ones.

use nalgebra::Matrix3;
use rayon::prelude::*;

use crate::{Similarity, Vec3, cloud::Cloud};

/// Steps of evenly_taken start.
const FIRST_STEPS: usize = 4;
/// Further steps of the promising starts.
const FURTHER_STEPS: usize = 10;
/// Share of the starts that are promising.
const PROMISING_SHARE: f64 = 0.25;
/// Observed points, and samples of the mesh, that are used.
const MAX_POINTS: usize = 120;
/// Share of the observed points, the nearest to the mesh, that are inliers.
const INLIER_SHARE: f64 = 0.85;
/// Share of the mesh, the nearest to the observed points, that is taken to have been observed.
const OBSERVED_SHARE: f64 = 0.5;

/// A start after some steps.
struct Candidate {
    similarity: Similarity,
    score: f64,
}

/// A point of the mesh, in its own frame, and the observed point that it should be moved to.
#[derive(Clone, Copy)]
pub(super) struct Pair {
    pub(super) mesh: Vec3,
    pub(super) observed: Vec3,
    /// Squared distance [m²].
    pub(super) square: f64,
}

/// The best `count` results of all starts, the best first.
pub(super) fn search(
    starts: Vec<Similarity>,
    surface: &Cloud,
    cloud: &Cloud,
    count: usize,
) -> Vec<Similarity> {
    let improve_all = |starts: Vec<Similarity>, steps| -> Vec<Candidate> {
        let mut candidates: Vec<Candidate> =
            starts.into_par_iter().map(|s| improve(s, surface, cloud, steps)).collect();
        candidates.retain(|t| t.score.is_finite());
        candidates.sort_by(|a, b| a.score.total_cmp(&b.score));
        candidates
    };
    let mut candidates = improve_all(starts, FIRST_STEPS);
    candidates.truncate((candidates.len() as f64 * PROMISING_SHARE).ceil() as usize);
    let promising = candidates.into_iter().map(|t| t.similarity).collect();
    distinct(improve_all(promising, FURTHER_STEPS), count)
}

fn improve(start: Similarity, surface: &Cloud, cloud: &Cloud, steps: usize) -> Candidate {
    let points = evenly_taken(&cloud.points, MAX_POINTS);
    let samples = evenly_taken(&surface.points, MAX_POINTS);
    let mut candidate = Candidate { similarity: start, score: f64::INFINITY };
    for step in 0..=steps {
        let at = candidate.similarity;
        let forward = points.iter().map(|o| {
            let (mesh, square) = surface.nearest(at.apply_inverse(*o));
            Pair { mesh, observed: *o, square: square * at.scale * at.scale }
        });
        let forward = nearest_share(forward.collect(), INLIER_SHARE);
        let backward = observed_half(at, &samples, cloud);
        candidate.score = mean_square(&forward) + mean_square(&backward);
        if step == steps {
            break;
        }
        match fit(&[forward, backward].concat()) {
            Some(next) => candidate.similarity = next,
            None => break,
        }
    }
    candidate
}

/// The first ones, without those that ended where a better one did.
fn distinct(candidates: Vec<Candidate>, count: usize) -> Vec<Similarity> {
    let mut out: Vec<Similarity> = Vec::new();
    for t in candidates {
        let is_same = |o: &Similarity| {
            let cosine = ((o.matrix().transpose() * t.similarity.matrix()).trace() - 1.0) / 2.0;
            cosine > 0.99 && (o.scale / t.similarity.scale - 1.0).abs() < 0.03
        };
        if !out.iter().any(is_same) {
            out.push(t.similarity);
        }
        if out.len() == count {
            break;
        }
    }
    out
}

/// Pairs of the half of the mesh that is nearest to the observed points.
pub(super) fn observed_half(at: Similarity, samples: &[Vec3], cloud: &Cloud) -> Vec<Pair> {
    let pairs = samples.iter().map(|m| {
        let (observed, square) = cloud.nearest(at.map(*m));
        Pair { mesh: *m, observed, square }
    });
    nearest_share(pairs.collect(), OBSERVED_SHARE)
}

pub(super) fn mean_square(pairs: &[Pair]) -> f64 {
    pairs.iter().map(|p| p.square).sum::<f64>() / pairs.len().max(1) as f64
}

pub(super) fn nearest_share(mut pairs: Vec<Pair>, share: f64) -> Vec<Pair> {
    pairs.sort_by(|a, b| a.square.total_cmp(&b.square));
    pairs.truncate((pairs.len() as f64 * share).ceil() as usize);
    pairs
}

/// About `count` of the points, evenly.
pub(super) fn evenly_taken(points: &[Vec3], count: usize) -> Vec<Vec3> {
    points.iter().step_by(points.len().div_ceil(count).max(1)).copied().collect()
}

/// The similarity of least squares between paired points (Umeyama 1991).
fn fit(pairs: &[Pair]) -> Option<Similarity> {
    let n = pairs.len() as f64;
    let from = pairs.iter().map(|p| p.mesh).sum::<Vec3>() / n;
    let to = pairs.iter().map(|p| p.observed).sum::<Vec3>() / n;
    let mut covariance = Matrix3::zeros();
    let mut variance = 0.0;
    for p in pairs {
        let (x, y) = (p.mesh - from, p.observed - to);
        covariance += y * x.transpose();
        variance += x.norm_squared();
    }
    let svd = covariance.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let mut signs = Vec3::repeat(1.0);
    if (u * v_t).determinant() < 0.0 {
        signs.z = -1.0;
    }
    let rotation = u * Matrix3::from_diagonal(&signs) * v_t;
    let scale = svd.singular_values.dot(&signs) / variance;
    let is_usable = scale.is_finite() && scale > 0.0;
    is_usable.then(|| Similarity::new(rotation, scale, to - rotation * from * scale))
}
