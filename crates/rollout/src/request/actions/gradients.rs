//! Gradients by actions: from control positions and poses at frame boundaries back to knots.
//!
//! With h = R₀⁻¹ (c₀ - p₀) the place of a control point on its gripper, it is at p + R h at each
//! frame boundary after the first, so a gradient g there counts as g by p, as that of g · R h by R,
//! and as R⁻¹ g by h, through which it reaches the first pose. Of a body's pose the columns of the
//! gradient's matrix count as gradients of the columns of R, the last one as that by p. Rolls of clamps
//! give gradients by rotation vectors. Gradients by quaternions are those along the unit sphere.

use bendtwin_core::Point;
use bendtwin_engine::{backend::Gradient, world::Pose};

use super::{
    Shape, Trajectories,
    poses::{GripperPose, Poses, unit},
    rolls,
};
use crate::request::{
    interpolate::{Place, Schedule},
    quaternion::{Quaternion, Vector, dot},
};

impl Trajectories {
    pub(super) fn gradient(&self, shape: Shape, schedule: &Schedule, by: &[Point]) -> Vec<f32> {
        let width = self.controls;
        let mut sums = vec![[0.0f64; 3]; shape.knots * width];
        for (place, row) in schedule.places().iter().zip(by.chunks(width.max(1))) {
            for (knot, weight) in place.weights() {
                for (sum, g) in sums[knot * width..].iter_mut().zip(row) {
                    add(sum, g.map(f64::from), weight);
                }
            }
        }
        sums.as_flattened().iter().map(|x| *x as f32).collect()
    }
}

/// Gradient by a gripper's pose: position and quaternion.
#[derive(Clone, Copy, Debug, Default)]
struct ByPose {
    position: Vector,
    rotation: [f64; 4],
}

impl ByPose {
    /// Counts a gradient by a point `local` of the gripper, which is at `at`.
    fn point(&mut self, at: &GripperPose, local: Vector, g: Vector) {
        add(&mut self.position, g, 1.0);
        add(&mut self.rotation, at.rotation.rotate_gradient(local, g), 1.0);
    }

    /// Counts a gradient by the entries of the pose's matrix.
    fn matrix(&mut self, at: &GripperPose, g: &Pose) {
        add(&mut self.position, g.map(|row| f64::from(row[3])), 1.0);
        for column in 0..3 {
            let along = g.map(|row| f64::from(row[column]));
            add(&mut self.rotation, at.rotation.rotate_gradient(unit(column), along), 1.0);
        }
    }
}

impl Poses {
    pub(super) fn gradient(
        &self,
        instance: usize,
        shape: Shape,
        schedule: &Schedule,
        start: &[Point],
        by: &Gradient,
    ) -> Vec<f32> {
        let (grippers, knots) = (self.grippers(), self.knots(instance, shape));
        let (width, bodies) = (start.len(), by.poses.len() / schedule.places().len().max(1));
        let mut sums = vec![ByPose::default(); shape.knots * grippers];
        let Some(first) = schedule.places().first() else { return Vec::new() };
        let first: Vec<GripperPose> = (0..grippers).map(|g| knots.at(first, g)).collect();
        let held = start.iter().zip(&self.gripper_of_control);
        let held: Vec<Vector> = held.map(|(c, g)| first[*g].local(c.map(f64::from))).collect();
        let mut by_held = vec![[0.0f64; 3]; width];

        let turned = if by.rolls.is_empty() {
            Vec::new()
        } else {
            let placed = self.placed(instance, shape, schedule);
            let controls = self.controls(instance, shape, schedule, start);
            rolls::gradient(&self.clamps, &placed, &controls, &by.rolls)
        };
        for (frame, place) in schedule.places().iter().enumerate() {
            for gripper in 0..grippers {
                let at = knots.at(place, gripper);
                let mut here = ByPose::default();
                // In the first frame a control point is where the initial state has it.
                let row = by.controls.get(frame * width..(frame + 1) * width);
                let row = if frame == 0 { &[] } else { row.unwrap_or_default() };
                for (c, g) in row.iter().enumerate() {
                    if self.gripper_of_control[c] == gripper {
                        let g = g.map(f64::from);
                        here.point(&at, held[c], g);
                        add(&mut by_held[c], at.rotation.inverse().rotate(g), 1.0);
                    }
                }
                if gripper < bodies
                    && let Some(g) = by.poses.get(frame * bodies + gripper)
                {
                    here.matrix(&at, g);
                }
                if let Some(row) = turned.get(frame) {
                    let rotation = at.rotation.turn_gradient(row[gripper]);
                    add(&mut here.rotation, rotation, 1.0);
                }
                spread(&mut sums, &knots, place, gripper, here);
            }
        }
        // h = R₀⁻¹ (c₀ - p₀)
        for (c, (g, gripper)) in by_held.iter().zip(&self.gripper_of_control).enumerate() {
            let at = first[*gripper];
            let mut here = ByPose::default();
            add(&mut here.position, at.rotation.rotate(*g), -1.0);
            let offset = std::array::from_fn(|i| f64::from(start[c][i]) - at.position[i]);
            here.rotation = at.rotation.rotate_gradient(*g, offset);
            spread(&mut sums, &knots, &schedule.places()[0], *gripper, here);
        }
        let finished = sums.iter().zip(knots.rows).flat_map(|(sum, row)| {
            let raw = [row[3], row[4], row[5], row[6]];
            let length = dot(raw.map(f64::from), raw.map(f64::from)).sqrt();
            let rotation = Quaternion::of(raw).tangent(sum.rotation).map(|x| x / length);
            let [px, py, pz] = sum.position;
            let [x, y, z, w] = rotation;
            [px, py, pz, x, y, z, w].map(|x| x as f32)
        });
        finished.collect()
    }
}

/// Spreads the gradient by a gripper's pose at a frame boundary over the knots.
fn spread(
    sums: &mut [ByPose],
    knots: &super::poses::Knots<'_>,
    place: &Place,
    gripper: usize,
    here: ByPose,
) {
    let at = |knot: usize| knot * knots.grippers + gripper;
    for (knot, weight) in place.weights() {
        add(&mut sums[at(knot)].position, here.position, weight);
    }
    if place.share == 0.0 {
        add(&mut sums[at(place.knot)].rotation, here.rotation, 1.0);
        return;
    }
    let [from, to] = [place.knot, place.knot + 1];
    let ends = [knots.rotation(from, gripper), knots.rotation(to, gripper)];
    let gradients = ends[0].slerp_gradient(ends[1], place.share, here.rotation);
    for (knot, gradient) in [from, to].into_iter().zip(gradients) {
        add(&mut sums[at(knot)].rotation, gradient, 1.0);
    }
}

fn add<const N: usize>(sum: &mut [f64; N], x: [f64; N], times: f64) {
    for (sum, x) in sum.iter_mut().zip(x) {
        *sum += times * x;
    }
}
