//! Poses of rigid grippers. A control point c that is at c0 while its gripper
//! is at (p0, R0) is at p + R R0⁻¹ (c0 - p0) while the gripper is at (p, R).

use bendtwin_core::{
    Point,
    geometry::{add, sub},
};
use bendtwin_proto::v1::GripperPoses;

use super::{Shape, curve, finite, given};
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
    pub(super) fn read(
        wire: GripperPoses,
        controls: usize,
        max_instances: usize,
    ) -> Result<Self, Error> {
        const FIELD: &str = "poses.poses";
        let curve = curve("poses.interpolation", wire.interpolation)?;
        let (dims, values) = given(wire.poses, FIELD)?.unpack::<f32>(FIELD)?;
        let [instances, knots, grippers, 7] = dims[..] else {
            let fault = format!(
                "has shape {dims:?}, not [B, K, G, 7] (x, y, z, then the quaternion x, y, z, w)"
            );
            return Err(Error::field(FIELD, fault));
        };
        let shape = Shape::checked(instances, knots, max_instances, FIELD)?;
        if grippers == 0 {
            return Err(Error::field(FIELD, "has no grippers: at least 1 is needed"));
        }
        finite(FIELD, &values)?;
        let (poses, _) = values.as_chunks::<7>();
        let rotations = poses.iter().enumerate().map(|(i, p)| {
            Quaternion::new([p[3], p[4], p[5], p[6]]).ok_or_else(|| {
                let (b, k, g) = (i / (knots * grippers), i / grippers % knots, i % grippers);
                let fault = format!(
                    "the quaternion of instance {b}, knot {k}, gripper {g} has length zero; no rotation is [0, 0, 0, 1]"
                );
                Error::field(FIELD, fault)
            })
        });
        Ok(Self {
            shape,
            grippers,
            curve,
            rotations: rotations.collect::<Result<_, _>>()?,
            positions: poses.iter().map(|p| [p[0], p[1], p[2]]).collect(),
            gripper_of_control: attachments(wire.gripper_of_control, controls, grippers)?,
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

fn attachments(
    wire: Option<bendtwin_proto::v1::Tensor>,
    controls: usize,
    grippers: usize,
) -> Result<Vec<usize>, Error> {
    const FIELD: &str = "poses.gripper_of_control";
    let Some(tensor) = wire.filter(|t| !t.is_absent()) else { return Ok(vec![0; controls]) };
    let (dims, indices) = tensor.unpack::<u32>(FIELD)?;
    if dims != [controls] {
        let fault = format!("has shape {dims:?}: the twin has {controls} control points");
        return Err(Error::field(FIELD, fault));
    }
    match indices.iter().position(|g| *g as usize >= grippers) {
        Some(c) => {
            let fault = format!(
                "control point {c} is given to gripper {}, there are {grippers} (counted from 0)",
                indices[c]
            );
            Err(Error::field(FIELD, fault))
        }
        None => Ok(indices.into_iter().map(|g| g as usize).collect()),
    }
}
