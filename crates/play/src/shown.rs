//! States of a play as shown: after every frame a message of a few bytes a node. Little-endian:
//!
//! | bytes | content |
//! |---|---|
//! | 0 | 1, the kind of message |
//! | 1 | flags: 1 paused, 2 recording, 4 replaying, 8 planning or on its way to a goal |
//! | 2, 3 | number of grippers G and of colliders C |
//! | 4..8 | number of the state: counts from 1 |
//! | 8..12 | number of the last input that it has |
//! | 12..16 | number of nodes N |
//! | 16..32 | origin x, y, z [m] and scale [m], float32 |
//! | 32..36 | largest strain of the material, float32 |
//! | G x 44 | of each gripper: pose, x y z and quaternion x y z w; force on the object x y z; 1 if it holds something, else 0: float32 |
//! | C x 28 | of each collider its pose, float32 |
//! | N x 6 | nodes: origin + scale * int16, x y z |

use bytes::{BufMut as _, Bytes, BytesMut};

use super::rows::Pose;

/// The kind of these messages.
const KIND: u8 = 1;

/// State of a play as a message to its page.
#[derive(Clone, Debug)]
pub(super) struct StateMessage<'a> {
    pub(super) flags: u8,
    pub(super) number: u32,
    pub(super) input: u32,
    pub(super) moved: &'a Bodies,
    /// Nodes [m], shape [N, 3].
    pub(super) positions: &'a [[f32; 3]],
}

/// Grippers and colliders of a state.
#[derive(Clone, Debug, Default)]
pub(super) struct Bodies {
    pub(super) grippers: Vec<Pose>,
    /// Forces of the grippers on the object [N], shape [G, 3].
    pub(super) forces: Vec<[f32; 3]>,
    pub(super) holding: Vec<bool>,
    pub(super) colliders: Vec<Pose>,
    pub(super) strain: f32,
}

impl StateMessage<'_> {
    /// The message.
    pub(super) fn encode(&self) -> Bytes {
        let (origin, scale) = frame_of(self.positions);
        let Bodies { grippers, forces, holding, colliders, strain } = self.moved;
        let size = 36 + 44 * grippers.len() + 28 * colliders.len() + 6 * self.positions.len();
        let mut out = BytesMut::with_capacity(size);
        out.put_u8(KIND);
        out.put_u8(self.flags);
        out.put_u8(grippers.len() as u8);
        out.put_u8(colliders.len() as u8);
        out.put_u32_le(self.number);
        out.put_u32_le(self.input);
        out.put_u32_le(self.positions.len() as u32);
        origin.iter().for_each(|x| out.put_f32_le(*x));
        out.put_f32_le(scale);
        out.put_f32_le(*strain);
        for (g, pose) in grippers.iter().enumerate() {
            pose.iter().for_each(|x| out.put_f32_le(*x));
            let force = forces.get(g).copied().unwrap_or_default();
            force.iter().for_each(|x| out.put_f32_le(*x));
            out.put_f32_le(f32::from(u8::from(holding.get(g) == Some(&true))));
        }
        colliders.iter().flatten().for_each(|x| out.put_f32_le(*x));
        for point in self.positions {
            for (x, origin) in point.iter().zip(origin) {
                out.put_i16_le(((x - origin) / scale).round() as i16);
            }
        }
        out.freeze()
    }
}

/// Middle of points [m], and the scale at which all of them are 16-bit integers around it [m].
fn frame_of(points: &[[f32; 3]]) -> ([f32; 3], f32) {
    let finite = |points: &&[f32; 3]| points.iter().all(|x| x.is_finite());
    let bounds =
        points.iter().filter(finite).fold(([f32::MAX; 3], [f32::MIN; 3]), |(low, high), p| {
            (std::array::from_fn(|i| low[i].min(p[i])), std::array::from_fn(|i| high[i].max(p[i])))
        });
    let (low, high) = if bounds.0[0] <= bounds.1[0] { bounds } else { ([0.0; 3], [0.0; 3]) };
    let extent = (0..3).map(|i| high[i] - low[i]).fold(0.0, f32::max);
    let origin = std::array::from_fn(|i| f32::midpoint(low[i], high[i]));
    (origin, (extent / 65_532.0).max(1e-9))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn float(bytes: &[u8], at: usize) -> f32 {
        f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
    }

    #[test]
    fn nodes_come_back_within_the_scale_that_is_stated() {
        let positions: Vec<[f32; 3]> = (0..100u8)
            .map(|i| [f32::from(i) * 0.01, 2.0 - f32::from(i), (f32::from(i)).sin()])
            .collect();
        let pose = [0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let moved = Bodies {
            grippers: vec![pose, pose],
            forces: vec![[1.0, 2.0, 3.0], [0.0; 3]],
            holding: vec![false, true],
            strain: 0.25,
            colliders: vec![pose],
        };
        let (moved, positions) = (&moved, &positions[..]);
        let bytes = StateMessage { flags: 5, number: 7, input: 9, moved, positions }.encode();
        assert_eq!(bytes.len(), 36 + 88 + 28 + 600);
        assert_eq!(
            (bytes[..4].to_vec(), bytes[4], bytes[8], bytes[12]),
            (vec![1, 5, 2, 1], 7, 9, 100)
        );
        assert_eq!(
            (float(&bytes, 32), float(&bytes, 36 + 28), float(&bytes, 36 + 84)),
            (0.25, 1.0, 1.0)
        );
        let scale = float(&bytes, 28);
        let nodes = &bytes[36 + 88 + 28..];
        for (i, x) in positions.as_flattened().iter().enumerate() {
            let code = i16::from_le_bytes([nodes[2 * i], nodes[2 * i + 1]]);
            let back = float(&bytes, 16 + 4 * (i % 3)) + scale * f32::from(code);
            assert!((back - x).abs() <= scale, "{back} {x}");
        }
    }

    #[test]
    fn nothing_and_a_single_point_are_sound() {
        let of = |positions: &[[f32; 3]]| {
            let moved = &Bodies::default();
            StateMessage { flags: 0, number: 0, input: 0, moved, positions }.encode()
        };
        assert_eq!(of(&[]).len(), 36);
        let bytes = of(&[[3.0, f32::NAN, 1.0], [3.0; 3]]);
        assert_eq!((float(&bytes, 16), bytes[12]), (3.0, 2));
    }
}
