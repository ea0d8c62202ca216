//! Colours of a twin's skin from the cameras that see it.
//!
//! In some training frames each point is looked up in each view that shows it: inside the object's
//! mask, not behind what the camera measured or what else of the skin lies before it. A camera that
//! looks along the surface counts little. The colour is the weighted median, so that a few wrong
//! pixels do not show; a point that no camera saw takes that of the nearest that one did.

use bendtwin_core::{
    Point, Twin, View, ViewCamera, Views,
    geometry::{Vector, dot, length, scaled, sub, wide},
    views::Label,
};
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use rayon::prelude::*;

use crate::{Error, Motion, dressed::spacings};

/// Most frames that are used.
const FRAMES: usize = 12;
/// Distance along the optical axis up to which a point is what the camera sees [m].
const DEPTH_TOLERANCE_M: f64 = 0.008;
/// Weight of the first frame, in which the twin is where the object is, over that of others.
const FIRST: f32 = 3.0;
/// Least weight of a camera that looks along the surface.
const GRAZING: f64 = 0.02;
/// Neighbours whose plane is a point's surface.
const PLANE: usize = 10;
/// Distance around a skin point in which it hides what lies behind it, over its distance from its
/// neighbours, and in pixels at least and at most.
const HIDES: f64 = 0.75;
const HIDES_PIXELS: [f64; 2] = [2.0, 16.0];

/// Colours of the skin (sRGB), shape [M, 3], from all cameras but those held out.
///
/// # Errors
/// [`Error::NoViews`] if no camera sees any point.
pub fn skin_colors(
    twin: &Twin,
    motion: &Motion<'_>,
    views: &Views,
    held_out: &[u32],
) -> Result<Vec<[u8; 3]>, Error> {
    let rest = twin.skin.positions(&twin.graph.rest_positions);
    let (neighbours, spacings) = (neighbours(&rest), spacings(&rest));
    let frames: Vec<usize> = motion.training_frames(0).collect();
    let every = frames.len().div_ceil(FRAMES).max(1);
    let mut samples: Vec<Vec<Sample>> = vec![Vec::new(); rest.len()];
    for &frame in frames.iter().step_by(every) {
        let Some(nodes) = motion.at(frame) else { continue };
        let points = twin.skin.positions(nodes);
        let normals: Vec<Vector> =
            neighbours.par_iter().map(|around| normal(around, &points)).collect();
        let first = if frame == frames[0] { FIRST } else { 1.0 };
        for (index, camera) in views.cameras.iter().enumerate() {
            let frame = u32::try_from(frame).unwrap_or(u32::MAX);
            let Some(view) = camera.view(frame) else { continue };
            if held_out.iter().any(|h| *h as usize == index) {
                continue;
            }
            let seen = SkinView::new(camera, view, &points, &spacings);
            for (p, own) in samples.iter_mut().enumerate() {
                own.extend(seen.sample(points[p], normals[p]).map(|s| s.weighed(first)));
            }
        }
    }
    let colors: Vec<Option<[u8; 3]>> = samples.into_iter().map(median).collect();
    spread(&rest, &colors).ok_or(Error::NoViews)
}

/// A colour that a camera saw, with its weight.
#[derive(Clone, Copy)]
struct Sample {
    color: [u8; 3],
    weight: f32,
}

impl Sample {
    fn weighed(self, by: f32) -> Self {
        Self { weight: by * self.weight, ..self }
    }
}

/// The skin in one view.
struct SkinView<'a> {
    camera: &'a ViewCamera,
    view: &'a View,
    /// Least depth of a skin point around each pixel [m].
    nearest: Vec<f64>,
}

impl<'a> SkinView<'a> {
    fn new(camera: &'a ViewCamera, view: &'a View, points: &[Point], spacings: &[f32]) -> Self {
        let mut nearest = vec![f64::INFINITY; view.labels.len()];
        let [least, most] = HIDES_PIXELS;
        for (point, spacing) in points.iter().zip(spacings) {
            let Some((place, depth)) = camera.project(*point, view.frame) else { continue };
            let [x, y] = place.map(|c| c.round() as i64);
            let reach = HIDES * f64::from(*spacing) * camera.focal[0] / depth;
            let reach = reach.ceil().clamp(least, most) as i64;
            for row in y - reach..=y + reach {
                for column in x - reach..=x + reach {
                    if let Some(index) = pixel(view, column, row) {
                        nearest[index] = nearest[index].min(depth);
                    }
                }
            }
        }
        Self { camera, view, nearest }
    }

    fn sample(&self, at: Point, normal: Vector) -> Option<Sample> {
        let (place, depth) = self.camera.project(at, self.view.frame)?;
        let [x, y] = place.map(|c| c.round() as i64);
        let index = pixel(self.view, x, y)?;
        // The rim of a mask shows what lies behind, too.
        let inside = [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)].into_iter().all(|(dx, dy)| {
            pixel(self.view, x + dx, y + dy).is_some_and(|i| self.view.labels[i] == Label::Object)
        });
        let measured = 1e-3 * f64::from(self.view.depths_mm[index]);
        let is_measured = measured == 0.0 || (depth - measured).abs() < DEPTH_TOLERANCE_M;
        let is_first = depth < self.nearest[index] + DEPTH_TOLERANCE_M;
        if !(inside && is_measured && is_first) {
            return None;
        }
        let pose = self.camera.pose(self.view.frame);
        // The camera's place is -Rᵀ t.
        let eye: Vector =
            std::array::from_fn(|i| -(0..3).map(|k| pose[k][i] * pose[k][3]).sum::<f64>());
        let along = sub(eye, wide(at));
        let cosine = dot(scaled(along, 1.0 / length(along).max(1e-9)), normal).abs();
        let weight = (cosine * cosine).max(GRAZING) as f32;
        Some(Sample { color: self.view.colors[index], weight })
    }
}

/// Index of a pixel of the whole image in a view.
fn pixel(view: &View, column: i64, row: i64) -> Option<usize> {
    view.index(u32::try_from(column).ok()?, u32::try_from(row).ok()?)
}

/// The nearest points to each point at rest, itself among them.
fn neighbours(points: &[Point]) -> Vec<Vec<u32>> {
    let Ok(tree) = ImmutableKdTree::<f32, 3>::new_from_slice(points) else {
        return vec![Vec::new(); points.len()];
    };
    let count = std::num::NonZero::new(PLANE).unwrap_or(std::num::NonZero::<usize>::MIN);
    let around = |p: &Point| {
        let found = tree.query(p).nearest_n::<SquaredEuclidean<f32>>(count).execute();
        found.iter().map(|n| n.item).collect()
    };
    points.par_iter().map(around).collect()
}

/// The direction in which points extend least.
fn normal(around: &[u32], points: &[Point]) -> Vector {
    let at = |i: &u32| Vector3::from(wide(points[*i as usize]));
    let mean = around.iter().map(at).sum::<Vector3<f64>>() / around.len().max(1) as f64;
    let spread = |i| {
        let off = at(i) - mean;
        off * off.transpose()
    };
    let eigen = SymmetricEigen::new(around.iter().map(spread).sum::<Matrix3<f64>>());
    eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned().into()
}

/// The weighted median of each channel.
fn median(mut samples: Vec<Sample>) -> Option<[u8; 3]> {
    let half = 0.5 * samples.iter().map(|s| s.weight).sum::<f32>();
    if samples.is_empty() {
        return None;
    }
    Some(std::array::from_fn(|channel| {
        samples.sort_by_key(|s| s.color[channel]);
        let mut sum = 0.0;
        let reached = samples.iter().find(|s| {
            sum += s.weight;
            sum >= half
        });
        reached.map_or(0, |s| s.color[channel])
    }))
}

/// Colours of all points: of those without one, the nearest one's; none if no point has any.
fn spread(points: &[Point], colors: &[Option<[u8; 3]>]) -> Option<Vec<[u8; 3]>> {
    let (known, of): (Vec<Point>, Vec<[u8; 3]>) =
        points.iter().zip(colors).filter_map(|(p, c)| Some((*p, (*c)?))).unzip();
    let tree =
        ImmutableKdTree::<f32, 3>::new_from_slice(&known).ok().filter(|_| !known.is_empty())?;
    let one = std::num::NonZero::<usize>::MIN;
    let nearest = |p: &Point| {
        let found = tree.query(p).nearest_n::<SquaredEuclidean<f32>>(one).execute();
        found.first().map_or([0; 3], |n| of[n.item as usize])
    };
    Some(points.iter().zip(colors).map(|(p, c)| c.unwrap_or_else(|| nearest(p))).collect())
}

#[cfg(test)]
mod tests;
