//! A rigid body that is followed by its shape alone: depth of all cameras, registered with what was
//! seen of it at first.

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::{Matrix6, Rotation3, Vector3, Vector6};

#[cfg(test)]
mod tests;

/// A point of a surface and the direction that it faces, either way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surfel {
    pub(crate) at: Vector3<f64>,
    pub(crate) normal: Vector3<f64>,
}

/// A hand or gripper.
pub(crate) struct Body {
    model: Vec<Surfel>,
    tree: ImmutableKdTree<f64, 3>,
    center: Vector3<f64>,
    /// The model's point x is now at `rotation · (x - center) + center + translation`.
    rotation: Rotation3<f64>,
    translation: Vector3<f64>,
    /// Translation from the frame before [m].
    velocity: Vector3<f64>,
}

/// Least points of a shape.
const MIN_POINTS: usize = 20;
/// Gauss-Newton steps per frame.
const STEPS: usize = 20;
/// Distance from the model beyond which a point belongs to something else [m].
const MAX_DISTANCE_M: f64 = 0.05;
/// Distances below this are noise of depth and gaps between surfels [m].
const NOISE_M: f64 = 0.004;
/// Turns that change a shape's depth by less than this per radian cannot be observed [m]: of a
/// ball, of a stick about its axis. Such shapes are taken not to turn.
const MIN_LEVER_M: f64 = 0.003;
/// Share of a point's weight with which the translation is held where it was expected.
const PRIOR_WEIGHT: f64 = 1e-3;

impl Body {
    /// A body as first seen; `None` if too little of it was visible.
    pub(crate) fn new(model: Vec<Surfel>) -> Option<Self> {
        if model.len() < MIN_POINTS {
            return None;
        }
        let rows: Vec<[f64; 3]> = model.iter().map(|s| s.at.into()).collect();
        let center = model.iter().map(|s| s.at).sum::<Vector3<f64>>() / model.len() as f64;
        Some(Self {
            tree: ImmutableKdTree::new_from_slice(&rows).ok()?,
            model,
            center,
            rotation: Rotation3::identity(),
            translation: Vector3::zeros(),
            velocity: Vector3::zeros(),
        })
    }

    /// The present place of a point of the model.
    pub(crate) fn to_world(&self, point: Vector3<f64>) -> Vector3<f64> {
        self.rotation * (point - self.center) + self.center + self.translation
    }

    /// The point of the model that is currently at a place.
    pub(crate) fn to_model(&self, place: Vector3<f64>) -> Vector3<f64> {
        self.rotation.inverse() * (place - self.center - self.translation) + self.center
    }

    /// Distance from a place to the model as it lies now [m].
    pub(crate) fn distance(&self, place: Vector3<f64>) -> f64 {
        let at = self.to_model(place);
        self.nearest(at).map_or(f64::INFINITY, |surfel| (at - surfel.at).norm())
    }

    /// Moves the body to where its surface was observed, from where its motion would have taken it:
    /// robust point-to-plane registration. False, and nothing has moved, if too little of it was
    /// seen.
    pub(crate) fn register(&mut self, observed: &[Vector3<f64>]) -> bool {
        let (rotation, translation) = (self.rotation, self.translation);
        self.translation += self.velocity;
        let expected = self.translation;
        let mut turned = Vector3::zeros();
        for _ in 0..STEPS {
            let Some((turn, shift)) = self.step(observed, turned, expected) else {
                (self.rotation, self.translation) = (rotation, translation);
                self.velocity = Vector3::zeros();
                return false;
            };
            turned += turn;
            self.rotation *= Rotation3::new(turn).inverse();
            self.translation -= self.rotation * shift;
            if turn.norm() < 1e-4 && shift.norm() < 1e-5 {
                break;
            }
        }
        self.velocity = self.translation - translation;
        true
    }

    /// The rotation about the model's centre and the translation that bring the observed points,
    /// taken to the model, nearer to it. `turned` is their rotation so far in this frame,
    /// `expected` the translation that was expected.
    fn step(
        &self,
        observed: &[Vector3<f64>],
        turned: Vector3<f64>,
        expected: Vector3<f64>,
    ) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let pairs: Vec<_> = observed
            .iter()
            .filter_map(|&place| {
                let at = self.to_model(place);
                let surfel = self.nearest(at)?;
                let far = (at - surfel.at).norm();
                (far < MAX_DISTANCE_M).then_some((at, surfel, far))
            })
            .collect();
        if pairs.len() < MIN_POINTS {
            return None;
        }
        let mut distances: Vec<f64> = pairs.iter().map(|p| p.2).collect();
        distances.sort_by(f64::total_cmp);
        let width = NOISE_M.max(3.0 * distances[distances.len() / 2]);
        let mut left = Matrix6::zeros();
        let mut right = Vector6::zeros();
        let mut total = 0.0;
        for (at, surfel, far) in &pairs {
            let q = far / width;
            if q >= 1.0 {
                continue;
            }
            let weight = (1.0 - q * q).powi(2);
            let arm = (at - self.center).cross(&surfel.normal);
            let n = surfel.normal;
            let row = Vector6::new(arm.x, arm.y, arm.z, n.x, n.y, n.z);
            left += row * row.transpose() * weight;
            right -= row * (weight * n.dot(&(at - surfel.at)));
            total += weight;
        }
        // Shift s of the observed points moves the body by -rotation · s.
        let offset = self.rotation.inverse() * (self.translation - expected);
        for i in 0..3 {
            let stiff = total * MIN_LEVER_M * MIN_LEVER_M;
            left[(i, i)] += stiff;
            right[i] -= stiff * turned[i];
            left[(3 + i, 3 + i)] += total * PRIOR_WEIGHT;
            right[3 + i] += total * PRIOR_WEIGHT * offset[i];
        }
        let step = left.cholesky()?.solve(&right);
        step.iter()
            .all(|v| v.is_finite())
            .then(|| (step.fixed_rows::<3>(0).into_owned(), step.fixed_rows::<3>(3).into_owned()))
    }

    fn nearest(&self, at: Vector3<f64>) -> Option<&Surfel> {
        let query: [f64; 3] = at.into();
        let found = self.tree.query(&query).nearest_one::<SquaredEuclidean<f64>>().execute();
        self.model.get(found.item as usize)
    }
}

/// Parts of a surface that lie more than `gap` metres apart, largest first; those with less than a
/// tenth of the largest are left out.
pub(crate) fn parts(surfels: &[Surfel], gap: f64) -> Vec<Vec<Surfel>> {
    let mut part = vec![usize::MAX; surfels.len()];
    let mut found: Vec<Vec<Surfel>> = Vec::new();
    for first in 0..surfels.len() {
        if part[first] != usize::MAX {
            continue;
        }
        part[first] = found.len();
        let mut grown = vec![first];
        let mut next = 0;
        while let Some(&i) = grown.get(next) {
            next += 1;
            for j in 0..surfels.len() {
                if part[j] == usize::MAX && (surfels[i].at - surfels[j].at).norm() < gap {
                    part[j] = found.len();
                    grown.push(j);
                }
            }
        }
        found.push(grown.into_iter().map(|i| surfels[i]).collect());
    }
    found.sort_by_key(|p| std::cmp::Reverse(p.len()));
    let least = found.first().map_or(0, |p| p.len() / 10);
    found.retain(|p| p.len() > least);
    found
}
