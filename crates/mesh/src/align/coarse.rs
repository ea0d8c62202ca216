//! Closest points to closest points, on few points, to tell hopeless starts from others.

use nalgebra::Matrix3;
use rayon::prelude::*;

use crate::{Similarity, Vec3, cloud::Cloud};

/// Steps of every start, and of those that are not hopeless after them.
const FIRST_STEPS: usize = 4;
const MORE_STEPS: usize = 10;
/// Share of the starts that go on.
const PROMISING: f64 = 0.25;
/// Observed points and samples of the mesh that are asked.
const ASKED: usize = 120;
/// The farthest observed points are taken for outliers.
const TRUSTED: f64 = 0.85;
/// Share of the mesh that is taken to have been seen.
const SEEN: f64 = 0.5;

/// A start after some steps.
struct Tried {
    similarity: Similarity,
    score: f64,
}

/// A point of the mesh, in its own frame, and the observed point where it shall be.
#[derive(Clone, Copy)]
pub(super) struct Pair {
    pub(super) mesh: Vec3,
    pub(super) observed: Vec3,
    /// Squared distance [m²].
    pub(super) square: f64,
}

/// The best `count` ends of all starts, the best first.
pub(super) fn search(
    starts: Vec<Similarity>,
    surface: &Cloud,
    cloud: &Cloud,
    count: usize,
) -> Vec<Similarity> {
    let improve_all = |starts: Vec<Similarity>, steps| -> Vec<Tried> {
        let mut tried: Vec<Tried> =
            starts.into_par_iter().map(|s| improve(s, surface, cloud, steps)).collect();
        tried.retain(|t| t.score.is_finite());
        tried.sort_by(|a, b| a.score.total_cmp(&b.score));
        tried
    };
    let mut tried = improve_all(starts, FIRST_STEPS);
    tried.truncate((tried.len() as f64 * PROMISING).ceil() as usize);
    let promising = tried.into_iter().map(|t| t.similarity).collect();
    different(improve_all(promising, MORE_STEPS), count)
}

fn improve(start: Similarity, surface: &Cloud, cloud: &Cloud, steps: usize) -> Tried {
    let asked = every(&cloud.points, ASKED);
    let samples = every(&surface.points, ASKED);
    let mut tried = Tried { similarity: start, score: f64::INFINITY };
    for step in 0..=steps {
        let at = tried.similarity;
        let forward = asked.iter().map(|o| {
            let (mesh, square) = surface.nearest(at.pull(*o));
            Pair { mesh, observed: *o, square: square * at.scale * at.scale }
        });
        let forward = nearest_share(forward.collect(), TRUSTED);
        let backward = seen(at, &samples, cloud);
        tried.score = mean_square(&forward) + mean_square(&backward);
        if step == steps {
            break;
        }
        match fit(&[forward, backward].concat()) {
            Some(next) => tried.similarity = next,
            None => break,
        }
    }
    tried
}

/// The first ones, without those that ended where a better one did.
fn different(tried: Vec<Tried>, count: usize) -> Vec<Similarity> {
    let mut out: Vec<Similarity> = Vec::new();
    for t in tried {
        let turned = |o: &Similarity| {
            let cosine = ((o.matrix().transpose() * t.similarity.matrix()).trace() - 1.0) / 2.0;
            cosine > 0.99 && (o.scale / t.similarity.scale - 1.0).abs() < 0.03
        };
        if !out.iter().any(turned) {
            out.push(t.similarity);
        }
        if out.len() == count {
            break;
        }
    }
    out
}

/// The half of the mesh that is nearest to what was observed.
pub(super) fn seen(at: Similarity, samples: &[Vec3], cloud: &Cloud) -> Vec<Pair> {
    let pairs = samples.iter().map(|m| {
        let (observed, square) = cloud.nearest(at.map(*m));
        Pair { mesh: *m, observed, square }
    });
    nearest_share(pairs.collect(), SEEN)
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
pub(super) fn every(points: &[Vec3], count: usize) -> Vec<Vec3> {
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
