//! Depth cameras around the scene: the nearest surface in a pixel hides those behind it.

use std::collections::HashMap;

use bendtwin_core::Point;

use super::pose::{dot, sub, unit};

/// A pinhole camera.
#[derive(Clone, Debug)]
pub(super) struct Camera {
    pub(super) position: Point,
    right: Point,
    down: Point,
    forward: Point,
}

/// Focal length over pixel pitch; a pixel is 5 mm wide at 0.9 m.
const FOCAL_PIXELS: f32 = 180.0;
/// A point farther behind the nearest of its pixel is hidden [m].
const TOLERANCE_M: f32 = 0.012;
/// Cosine beyond which a surface is seen too flatly for depth.
const MIN_FACING: f32 = 0.15;

impl Camera {
    /// A camera at `position`, directed at `target`, z up.
    pub(super) fn looking_at(position: Point, target: Point) -> Self {
        let forward = unit(sub(target, position));
        let right = unit([forward[1], -forward[0], 0.0]);
        let down = [
            forward[1] * right[2] - forward[2] * right[1],
            forward[2] * right[0] - forward[0] * right[2],
            forward[0] * right[1] - forward[1] * right[0],
        ];
        Self { position, right, down, forward }
    }

    /// Pose in the world, by OpenCV's convention: x right, y down, z into the scene.
    pub(super) fn pose(&self) -> bendtwin_capture::raw::Pose {
        let [right, down, forward] =
            [self.right, self.down, self.forward].map(|v| v.map(f64::from));
        bendtwin_capture::raw::Pose {
            rotation: std::array::from_fn(|i| [right[i], down[i], forward[i]]),
            translation: self.position.map(f64::from),
        }
    }

    fn project(&self, p: Point) -> ([i32; 2], f32) {
        let local = sub(p, self.position);
        let depth = dot(local, self.forward).max(1e-3);
        let pixel =
            [self.right, self.down].map(|axis| (dot(local, axis) / depth * FOCAL_PIXELS).round());
        (pixel.map(|x| x as i32), depth)
    }

    /// `true` for surface nodes that face the camera with nothing in front, shape as `surface`.
    pub(super) fn sees(
        &self,
        surface: &[u32],
        positions: &[Point],
        normals: &[Point],
    ) -> Vec<bool> {
        let mut nearest: HashMap<[i32; 2], f32> = HashMap::new();
        let projected: Vec<_> =
            surface.iter().map(|n| self.project(positions[*n as usize])).collect();
        for &([x, y], depth) in &projected {
            // A node covers its neighbourhood: the surface between nodes is closed.
            for dx in -1..=1 {
                for dy in -1..=1 {
                    let pixel = nearest.entry([x + dx, y + dy]).or_insert(f32::INFINITY);
                    *pixel = pixel.min(depth);
                }
            }
        }
        let nodes = surface.iter().zip(&projected);
        nodes
            .map(|(node, (pixel, depth))| {
                let node = *node as usize;
                let to_camera = unit(sub(self.position, positions[node]));
                let front = nearest.get(pixel).copied().unwrap_or(f32::INFINITY);
                dot(normals[node], to_camera) > MIN_FACING && *depth <= front + TOLERANCE_M
            })
            .collect()
    }
}
