//! Poses of rigid grippers. A control point c that is at c0 while its gripper
//! is at (p0, R0) is at p + R R0⁻¹ (c0 - p0) while the gripper is at (p, R).

use bendtwin_core::{
    Point,
    geometry::{add, sub},
};
use bendtwin_proto::v1::GripperPoses;

use super::Shape;
use crate::rollout::{
    error::Error,
    interpolate::{Curve, Place},
    quaternion::Quaternion,
};

/// Poses of G grippers that carry C control points.
pub(in crate::rollout) struct Poses {
    pub(super) shape: Shape,
    grippers: usize,
    curve: Curve,
    /// [m], shape [B, K, G, 3].
    positions: Vec<Point>,
    /// Shape [B, K, G].
    rotations: Vec<Quaternion>,
    /// Gripper of each control point, shape [C].
    gripper_of_control: Vec<usize>,
}

impl Poses {
    pub(super) fn read(wire: GripperPoses, controls: usize) -> Result<Self, Error> {
        const FIELD: &str = "poses.poses";
        let curve = Curve::from(wire.interpolation());
        let (dims, values) = wire.poses.unwrap_or_default().unpack::<f32>(FIELD)?;
        let [instances, knots, grippers, 7] = dims[..] else {
            return Err(Error::field(FIELD, format!("has shape {dims:?}")));
        };
        let (poses, _) = values.as_chunks::<7>();
        let rotations = poses.iter().map(|p| {
            Quaternion::new([p[3], p[4], p[5], p[6]])
                .ok_or_else(|| Error::field(FIELD, "has a quaternion of length zero"))
        });
        let gripper_of_control = match wire.gripper_of_control.filter(|t| !t.is_absent()) {
            None => vec![0; controls],
            Some(map) => {
                let (_, grippers) = map.unpack::<u32>("poses.gripper_of_control")?;
                grippers.into_iter().map(|g| g as usize).collect()
            }
        };
        Ok(Self {
            shape: Shape { instances, knots },
            grippers,
            curve,
            rotations: rotations.collect::<Result<_, _>>()?,
            positions: poses.iter().map(|p| [p[0], p[1], p[2]]).collect(),
            gripper_of_control,
        })
    }

    pub(super) fn controls(&self, instance: usize, frames: usize, start: &[Point]) -> Vec<Point> {
        let (knots, grippers) = (self.shape.knots, self.grippers);
        let rows = instance * knots * grippers..(instance + 1) * knots * grippers;
        let (positions, rotations) = (&self.positions[rows.clone()], &self.rotations[rows]);
        // Each control point in its gripper's frame.
        let held: Vec<Point> = self
            .gripper_of_control
            .iter()
            .zip(start)
            .map(|(g, c)| rotations[*g].inverse().rotate(sub(*c, positions[*g])))
            .collect();
        let mut out = Vec::with_capacity((frames + 1) * held.len());
        let mut now = Vec::with_capacity(grippers);
        for frame in 0..=frames {
            let place = Place::of(frame, frames, knots);
            let next = (place.knot + 1).min(knots - 1);
            now.clear();
            now.extend((0..grippers).map(|g| {
                let from = rotations[place.knot * grippers + g];
                let rotation = from.slerp(rotations[next * grippers + g], place.share);
                (self.curve.at(place, knots, |k| positions[k * grippers + g]), rotation)
            }));
            out.extend(self.gripper_of_control.iter().zip(&held).map(|(g, h)| {
                let (position, rotation) = now[*g];
                add(position, rotation.rotate(*h))
            }));
        }
        out
    }
}
