//! Action spaces: what the coordinates of a plan move. Coordinates are differences from where the
//! space starts. A nominal plan may have motion that no coordinate has, of single points where all
//! move together say: every plan of the space has it too.

use crate::{
    Knots,
    rotation::{exponential, exponential_jacobian, inverse, logarithm_near, product, unit},
};

/// Numbers of a pose: x, y, z, quaternion x, y, z, w.
const POSE: usize = 7;
/// Displacements of a gripper: along x, y, z [m], and a rotation vector along the world's axes [rad].
const TWIST: usize = 6;

/// Coordinates of an action space.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Movement {
    /// x, y, z for each group of control points, which moves as a whole; the group of each, shape
    /// [C].
    Points(Vec<usize>),
    /// x, y, z for each gripper.
    Translation,
    /// x, y, z and a rotation vector for each gripper.
    Rigid,
}

/// An action space around a nominal plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Space {
    /// Control points, shape [C, 3], or poses, shape [G, 7].
    start: Vec<f64>,
    has_poses: bool,
    /// The coordinate that moves each displacement; `None` for displacements that nothing moves.
    owners: Vec<Option<usize>>,
    dims: usize,
    /// Displacements of the nominal plan beyond its coordinates, shape [K, W].
    rest: Knots,
}

impl Space {
    /// A space that starts at control points, shape [C, 3], or poses of unit quaternions, shape
    /// [G, 7].
    pub fn new(start: Vec<f64>, movement: &Movement) -> Self {
        let has_poses = !matches!(movement, Movement::Points(_));
        let grippers = start.len() / POSE;
        let owners: Vec<Option<usize>> = match movement {
            Movement::Points(groups) => {
                groups.iter().flat_map(|g| (0..3).map(move |axis| Some(3 * g + axis))).collect()
            }
            Movement::Translation => (0..grippers)
                .flat_map(|g| (0..TWIST).map(move |i| (i < 3).then_some(3 * g + i)))
                .collect(),
            Movement::Rigid => (0..TWIST * grippers).map(Some).collect(),
        };
        let dims = owners.iter().flatten().max().map_or(0, |last| last + 1);
        let mut space = Self { start, has_poses, owners, dims, rest: Knots::new() };
        if has_poses {
            space.start.chunks_exact_mut(POSE).for_each(straighten);
        }
        space
    }

    /// Number of coordinates D.
    pub fn dims(&self) -> usize {
        self.dims
    }

    /// Number of displacements W: 3 for each control point, 6 for each gripper.
    pub fn width(&self) -> usize {
        self.owners.len()
    }

    /// Displacements from the start, shape [K, W], of actions, shape [K, C, 3] or [K, G, 7].
    /// Rotations continue from knot to knot, so that they may exceed half a turn.
    pub fn displacements(&self, actions: &[f64]) -> Knots {
        if !self.has_poses {
            return actions.iter().zip(self.start.iter().cycle()).map(|(x, s)| x - s).collect();
        }
        let grippers = self.start.len() / POSE;
        let mut moved: Knots = Vec::with_capacity(actions.len() / POSE * TWIST);
        for (i, pose) in actions.chunks_exact(POSE).enumerate() {
            let start = &self.start[i % grippers * POSE..][..POSE];
            let before = match i.checked_sub(grippers) {
                Some(before) => vector(&moved[before * TWIST + 3..]),
                None => [0.0; 3],
            };
            let turned = product(unit(rotation(pose)), inverse(rotation(start)));
            moved.extend((0..3).map(|axis| pose[axis] - start[axis]));
            moved.extend(logarithm_near(turned, before));
        }
        moved
    }

    /// Actions, shape [K, C, 3] or [K, G, 7], of displacements, shape [K, W].
    pub fn displaced(&self, displacements: &[f64]) -> Vec<f64> {
        if !self.has_poses {
            return displacements
                .iter()
                .zip(self.start.iter().cycle())
                .map(|(x, s)| s + x)
                .collect();
        }
        let starts = self.start.chunks_exact(POSE).cycle();
        let poses = displacements.chunks_exact(TWIST).zip(starts).flat_map(|(moved, start)| {
            let turned = unit(product(exponential(vector(&moved[3..])), rotation(start)));
            (0..3).map(|axis| start[axis] + moved[axis]).chain(turned).collect::<Vec<_>>()
        });
        poses.collect()
    }

    /// The coordinates, shape [K, D], of a nominal plan with these displacements: means over what
    /// each moves. The rest of them is kept, for all plans of the space.
    pub fn around(&mut self, displacements: Knots) -> Knots {
        let (width, dims) = (self.width().max(1), self.dims);
        let mut counts = vec![0.0; dims];
        self.owners.iter().flatten().for_each(|d| counts[*d] += 1.0);
        let mut knots = vec![0.0; displacements.len() / width * dims];
        for (i, x) in displacements.iter().enumerate() {
            if let Some(d) = self.owners[i % width] {
                knots[i / width * dims + d] += x / counts[d];
            }
        }
        self.rest = displacements;
        for (i, x) in self.rest.iter_mut().enumerate() {
            if let Some(d) = self.owners[i % width] {
                *x -= knots[i / width * dims + d];
            }
        }
        knots
    }

    /// Actions of a plan of the space, shape [K, C, 3] or [K, G, 7].
    pub fn actions(&self, knots: &[f64]) -> Vec<f64> {
        self.displaced(&self.moves(knots))
    }

    /// d cost / d coordinates of a plan, shape [K, D], from d cost / d actions in their shape.
    pub fn gradient(&self, knots: &[f64], by_actions: &[f64]) -> Knots {
        let by_moves = match self.has_poses {
            true => self.by_twists(&self.moves(knots), by_actions),
            false => by_actions.to_vec(),
        };
        let mut gradient = vec![0.0; knots.len()];
        for (i, g) in by_moves.iter().enumerate() {
            if let Some(d) = self.owners[i % self.width()] {
                gradient[i / self.width() * self.dims + d] += g;
            }
        }
        gradient
    }

    /// Displacements of a plan of the space, shape [K, W].
    fn moves(&self, knots: &[f64]) -> Knots {
        let width = self.width().max(1);
        let by_coordinates = |i: usize| {
            self.owners[i % width]
                .and_then(|d| knots.get(i / width * self.dims + d))
                .unwrap_or(&0.0)
        };
        self.rest.iter().enumerate().map(|(i, rest)| rest + by_coordinates(i)).collect()
    }

    /// d cost / d displacements, shape [K, 6 G], from d cost / d poses, shape [K, G, 7]. A quaternion
    /// exp(r) q0 is linear in exp(r).
    fn by_twists(&self, moves: &[f64], by_poses: &[f64]) -> Knots {
        let starts = self.start.chunks_exact(POSE).cycle();
        let rows = moves.chunks_exact(TWIST).zip(by_poses.chunks_exact(POSE)).zip(starts);
        rows.flat_map(|((moved, by), start)| {
            let jacobian = exponential_jacobian(vector(&moved[3..]));
            let by_exponential: [f64; 4] = std::array::from_fn(|u| {
                let unit: [f64; 4] = std::array::from_fn(|i| if i == u { 1.0 } else { 0.0 });
                let along = product(unit, rotation(start));
                along.iter().zip(&by[3..]).map(|(a, b)| a * b).sum()
            });
            let by_axis = |v: usize| (0..4).map(|u| by_exponential[u] * jacobian[u][v]).sum();
            let by_vector: [f64; 3] = std::array::from_fn(by_axis);
            [by[0], by[1], by[2], by_vector[0], by_vector[1], by_vector[2]]
        })
        .collect()
    }
}

/// Gives the quaternion of a pose unit length.
fn straighten(pose: &mut [f64]) {
    let straight = unit(rotation(pose));
    pose[3..].copy_from_slice(&straight);
}

fn rotation(pose: &[f64]) -> [f64; 4] {
    std::array::from_fn(|i| pose[3 + i])
}

fn vector(values: &[f64]) -> [f64; 3] {
    std::array::from_fn(|i| values[i])
}

#[cfg(test)]
mod tests;
