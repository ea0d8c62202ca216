//! Poses of rigid grippers. A control point that is at c while its gripper is at (p, R) is at
//! p' + R' R⁻¹ (c - p) when the gripper is at (p', R').
//!
//! Poses are applied from frame to frame, so that a rollout that resumes from the state of any
//! frame moves the control points by the same bits as one that never stopped. Rounding makes them
//! stray from their gripper by about the root of the number of frames times 3e-8 m.

use bendtwin_core::Point;
use bendtwin_engine::world::Pose;
use bendtwin_proto::v1::GripperPoses;

use super::{Shape, rolls::Clamp};
use crate::{
    error::Error,
    request::{
        interpolate::{Place, Schedule},
        quaternion::{Quaternion, Vector},
    },
};

/// Poses of G grippers that carry C control points.
pub(crate) struct Poses {
    grippers: usize,
    /// Positions [m] and quaternions as the request has them, shape [B, K, G, 7].
    pub(super) poses: Vec<[f32; 7]>,
    /// Gripper of each control point, shape [C].
    pub(super) gripper_of_control: Vec<usize>,
    /// Ends of rods in grippers.
    pub(super) clamps: Vec<Clamp>,
}

/// A gripper at some time.
#[derive(Clone, Copy, Debug)]
pub(super) struct GripperPose {
    /// [m].
    pub(super) position: Vector,
    pub(super) rotation: Quaternion,
}

impl GripperPose {
    /// A point of the world in the gripper's coordinates.
    pub(super) fn local(&self, x: Vector) -> Vector {
        self.rotation.inverse().rotate(std::array::from_fn(|i| x[i] - self.position[i]))
    }

    fn world(&self, x: Vector) -> Vector {
        let turned = self.rotation.rotate(x);
        std::array::from_fn(|i| self.position[i] + turned[i])
    }

    pub(super) fn matrix(&self) -> Pose {
        let columns: [Vector; 3] = std::array::from_fn(|j| self.rotation.rotate(unit(j)));
        std::array::from_fn(|i| {
            let row = [columns[0][i], columns[1][i], columns[2][i], self.position[i]];
            row.map(|x| x as f32)
        })
    }
}

/// The engine's form of a pose: position [m] and quaternion.
pub(crate) fn pose([x, y, z, qx, qy, qz, qw]: [f32; 7]) -> Pose {
    let rotation = Quaternion::of([qx, qy, qz, qw]);
    GripperPose { position: [x, y, z].map(f64::from), rotation }.matrix()
}

/// Knots of all grippers of an instance.
#[derive(Clone, Copy)]
pub(super) struct Knots<'a> {
    pub(super) grippers: usize,
    /// Shape [K, G, 7].
    pub(super) rows: &'a [[f32; 7]],
}

impl Knots<'_> {
    /// The rotation of a gripper in a knot.
    pub(super) fn rotation(&self, knot: usize, gripper: usize) -> Quaternion {
        let [_, _, _, x, y, z, w] = self.rows[knot * self.grippers + gripper];
        Quaternion::of([x, y, z, w])
    }

    /// A gripper at a frame boundary. Its position lies on the curve through the knots, its rotation
    /// on the arc between two of them.
    pub(super) fn at(&self, place: &Place, gripper: usize) -> GripperPose {
        let position = place.at(|k| {
            let [x, y, z, ..] = self.rows[k * self.grippers + gripper];
            [x, y, z]
        });
        let from = self.rotation(place.knot, gripper);
        let rotation = if place.share == 0.0 {
            from
        } else {
            from.slerp(self.rotation(place.knot + 1, gripper), place.share)
        };
        GripperPose { position: position.map(f64::from), rotation }
    }
}

impl Poses {
    pub(super) fn read(wire: GripperPoses, controls: usize) -> Result<(Shape, Self), Error> {
        const FIELD: &str = "poses.poses";
        let (dims, values) = wire.poses.unwrap_or_default().unpack::<f32>(FIELD)?;
        let [instances, knots, grippers, 7] = dims[..] else {
            return Err(Error::field(FIELD, format!("has shape {dims:?}")));
        };
        let gripper_of_control = match wire.gripper_of_control.filter(|t| !t.is_absent()) {
            None => vec![0; controls],
            Some(map) => {
                let (_, grippers) = map.unpack::<u32>("poses.gripper_of_control")?;
                grippers.into_iter().map(|g| g as usize).collect()
            }
        };
        let poses = values.as_chunks::<7>().0.to_vec();
        let poses = Self { grippers, poses, gripper_of_control, clamps: Vec::new() };
        Ok((Shape { instances, knots }, poses))
    }

    /// Number of grippers G.
    pub(super) fn grippers(&self) -> usize {
        self.grippers
    }

    /// The knots of an instance.
    pub(super) fn knots(&self, instance: usize, shape: Shape) -> Knots<'_> {
        let each = shape.knots * self.grippers;
        let rows = &self.poses[instance * each..(instance + 1) * each];
        Knots { grippers: self.grippers, rows }
    }

    /// The grippers at frame boundaries, shape [F + 1, G].
    pub(super) fn placed(
        &self,
        instance: usize,
        shape: Shape,
        schedule: &Schedule,
    ) -> Vec<Vec<GripperPose>> {
        let knots = self.knots(instance, shape);
        let at = |place| (0..self.grippers).map(|g| knots.at(place, g)).collect();
        schedule.places().iter().map(at).collect()
    }

    pub(super) fn controls(
        &self,
        instance: usize,
        shape: Shape,
        schedule: &Schedule,
        start: &[Point],
    ) -> Vec<Point> {
        let knots = self.knots(instance, shape);
        let mut out = Vec::with_capacity(schedule.places().len() * start.len());
        let mut before: Vec<GripperPose> = Vec::new();
        for place in schedule.places() {
            let now: Vec<GripperPose> = (0..self.grippers).map(|g| knots.at(place, g)).collect();
            if before.is_empty() {
                out.extend_from_slice(start);
            } else {
                let last = out.len() - start.len();
                for (c, g) in self.gripper_of_control.iter().enumerate() {
                    let local = before[*g].local(out[last + c].map(f64::from));
                    out.push(now[*g].world(local).map(|x| x as f32));
                }
            }
            before = now;
        }
        out
    }

    pub(super) fn matrices(&self, instance: usize, shape: Shape, schedule: &Schedule) -> Vec<Pose> {
        let knots = self.knots(instance, shape);
        let at = |place| (0..self.grippers).map(move |g| knots.at(place, g).matrix());
        schedule.places().iter().flat_map(at).collect()
    }
}

/// The unit vector along an axis.
pub(super) fn unit(axis: usize) -> Vector {
    let mut unit = [0.0; 3];
    unit[axis] = 1.0;
    unit
}
