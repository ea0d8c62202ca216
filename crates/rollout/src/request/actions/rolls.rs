//! Rolls of a cable's clamps: angles by which grippers turn the ends of rods about the rods
//! themselves, which do not follow from positions of nodes.
//!
//! A clamp is a pair of neighbouring pinned nodes at an end of a rod, both held by control points of
//! one gripper, with the direction d from the first to the second along the rod. From one frame to
//! the next the gripper turns by Q = R' R⁻¹, while parallel transport turns what belongs to d by the
//! smallest rotation M from d to d'. The rest, the twist of M⁻¹ Q about d, is the clamp's roll in
//! that frame, between -π and π, positive by the right hand along the rod; an end's is the sum over
//! frames, and 0 in the first row. The near end's less the far end's has the sign of the twist that
//! nodes tell (docs/formats/twin.md): when grippers turn a bent cable as one body, the two undo one
//! another. Rolls of other edges that grasps hold are the engine's.
//!
//! Rolls are multiples of [`QUANTUM`], so that their differences from frame to frame are exact up
//! to two and a half turns, and a rollout that resumes from a state repeats them bit for bit.

use bendtwin_core::{Graph, Point};

use super::poses::GripperPose;
use crate::request::quaternion::{Quaternion, Vector, cross, dot};

/// Smallest step of a roll, 2⁻²⁰ [rad].
const QUANTUM: f64 = 1.0 / 1_048_576.0;

/// An end of a rod in a gripper.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Clamp {
    /// Index among the ends of all rods, two each: the near one first.
    end: usize,
    gripper: usize,
    /// Control points of both nodes, along the rod, and where the nodes are beside them [m].
    held: [(usize, Point); 2],
}

/// The clamps of a twin's rods in grippers.
pub(super) fn clamps(graph: &Graph, gripper_of_control: &[usize]) -> Vec<Clamp> {
    let held = |node: u32| {
        let pin = graph.pins.iter().find(|pin| pin.node == node)?;
        Some((pin.control as usize, pin.offset_m))
    };
    let mut clamps = Vec::new();
    for (rod, nodes) in graph.rods.iter().enumerate() {
        let last = nodes.len();
        for (end, ends) in [(2 * rod, 0..2), (2 * rod + 1, last - 2..last)] {
            let [a, b] = [nodes[ends.start], nodes[ends.start + 1]].map(held);
            let (Some(a), Some(b)) = (a, b) else { continue };
            let gripper = gripper_of_control[a.0];
            if gripper_of_control[b.0] == gripper {
                clamps.push(Clamp { end, gripper, held: [a, b] });
            }
        }
    }
    clamps
}

impl Clamp {
    /// Direction along the rod, of length 1; none where both nodes are in one place.
    fn direction(&self, controls: &[Point]) -> Option<Vector> {
        let [a, b] = self.held.map(|(control, offset)| -> Vector {
            std::array::from_fn(|i| f64::from(controls[control][i]) + f64::from(offset[i]))
        });
        let along: Vector = std::array::from_fn(|i| b[i] - a[i]);
        let length = dot(along, along).sqrt();
        (length > 1e-9).then(|| along.map(|x| x / length))
    }
}

/// Roll of a frame's end against its beginning, with the rotations of the gripper and the
/// directions of the clamp at both [rad].
fn roll(from: &Quaternion, to: &Quaternion, before: Vector, after: Vector) -> f64 {
    let turn = to.times(from.inverse());
    // Opposite directions have no unique smallest rotation between them: no rotation is used.
    let [x, y, z] = cross(before, after);
    let transport = Quaternion::new([x, y, z, 1.0 + dot(before, after)]);
    let rest = transport.map_or(turn, |m| m.inverse().times(turn));
    let [x, y, z, w] = rest.parts();
    let angle = 2.0 * dot([x, y, z], before).atan2(w);
    // q and -q are one rotation.
    angle - std::f64::consts::TAU * (angle / std::f64::consts::TAU).round()
}

/// Rolls of the ends of R rods at frame boundaries [rad], shape [F + 1, R, 2]. `placed` are the G grippers and
/// `controls` the control points there, shapes [F + 1, G] and [F + 1, C, 3].
pub(super) fn rolls(
    clamps: &[Clamp],
    rods: usize,
    placed: &[Vec<GripperPose>],
    controls: &[Point],
) -> Vec<f32> {
    let width = controls.len() / placed.len().max(1);
    let row = |frame: usize| &controls[frame * width..(frame + 1) * width];
    let mut sums = vec![0.0f64; 2 * rods];
    let mut out = vec![0.0f32; 2 * rods];
    for frame in 1..placed.len() {
        for clamp in clamps {
            let [from, to] = [frame - 1, frame].map(|f| &placed[f][clamp.gripper].rotation);
            let ends = [frame - 1, frame].map(|f| clamp.direction(row(f)));
            if let [Some(before), Some(after)] = ends {
                let step = roll(from, to, before, after) / QUANTUM;
                sums[clamp.end] += step.round() * QUANTUM;
            }
        }
        out.extend(sums.iter().map(|x| *x as f32));
    }
    out
}

/// Gradients by rotation vectors of the grippers at frame boundaries, shape [F + 1, G], of a
/// function whose gradient by rolls is `by`, shape [F + 1, R, 2]. The clamps' directions turn with
/// their grippers, as they do where control points stand for the pinned nodes themselves.
///
/// With t = (d + d') / (1 + d · d') the roll of a frame grows by t · ω' - t · ω as the gripper is
/// turned by ω at its beginning and by ω' at its end. Turning the first pose turns, the other way,
/// every later direction with what the gripper has turned by until then.
pub(super) fn gradient(
    clamps: &[Clamp],
    placed: &[Vec<GripperPose>],
    controls: &[Point],
    by: &[f32],
) -> Vec<Vec<Vector>> {
    let frames = placed.len();
    let mut out: Vec<Vec<Vector>> = placed.iter().map(|row| vec![[0.0; 3]; row.len()]).collect();
    let (width, ends) = (controls.len() / frames.max(1), by.len() / frames.max(1));
    let row = |frame: usize| &controls[frame * width..(frame + 1) * width];
    for clamp in clamps {
        let mut later = 0.0;
        for frame in (1..frames).rev() {
            later += f64::from(by[frame * ends + clamp.end]);
            let ends = [frame - 1, frame].map(|f| clamp.direction(row(f)));
            let [Some(before), Some(after)] = ends else { continue };
            let scale = later / (1.0 + dot(before, after)).max(1e-9);
            let t: Vector = std::array::from_fn(|i| scale * (before[i] + after[i]));
            let first = placed[0][clamp.gripper].rotation.inverse();
            for (at, sign) in [(frame, 1.0), (frame - 1, -1.0)] {
                if at == 0 {
                    continue;
                }
                let back = first.inverse().times(placed[at][clamp.gripper].rotation.inverse());
                let back = back.rotate(t);
                for i in 0..3 {
                    out[at][clamp.gripper][i] += sign * t[i];
                    out[0][clamp.gripper][i] -= sign * back[i];
                }
            }
        }
    }
    out
}

#[cfg(test)]
mod tests;
