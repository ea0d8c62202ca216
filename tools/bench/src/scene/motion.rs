//! Motion of the control points of a scene: gently out and back, each instance in a
//! different direction.

use std::f32::consts::TAU;

use bendtwin_core::Point;

/// Farthest displacement [m].
const AMPLITUDE_M: f32 = 0.01;
/// Frames of one way out and back.
const PERIOD_FRAMES: f32 = 60.0;
/// Share of a turn between the directions of two instances: no two are alike.
const GOLDEN: f32 = 0.618_034;
/// Control points farther from their middle than this hold two ends [m].
const TWO_ENDS_M: f32 = 0.08;

/// Positions of control points over frames [m], shape [F + 1, C, 3].
pub type Path = Vec<Point>;

/// Control points at rest, and where they go.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    rest: Vec<Point>,
}

impl Motion {
    pub(super) fn new(rest: Vec<Point>) -> Self {
        Self { rest }
    }

    /// Control positions at the boundaries of `frames` frames. Instance numbers give directions, up
    /// at times but never down; the ends of a rope move towards and away from each other.
    pub fn path(&self, instance: usize, frames: usize) -> Path {
        let turn = TAU * (GOLDEN * instance as f32).fract();
        let direction = [turn.cos(), 0.5 * turn.sin(), 0.5 + 0.5 * turn.sin()];
        let middle = 0.5
            * (self.rest.iter().map(|p| p[0]).fold(f32::INFINITY, f32::min)
                + self.rest.iter().map(|p| p[0]).fold(f32::NEG_INFINITY, f32::max));
        let has_two_ends = self.rest.iter().any(|p| (p[0] - middle).abs() > TWO_ENDS_M);
        let mut path = Vec::with_capacity(self.rest.len() * (frames + 1));
        for frame in 0..=frames {
            let way = AMPLITUDE_M * 0.5 * (1.0 - (TAU * frame as f32 / PERIOD_FRAMES).cos());
            path.extend(self.rest.iter().map(|p| {
                let side = if has_two_ends && p[0] < middle { -1.0 } else { 1.0 };
                [
                    p[0] + side * way * direction[0],
                    p[1] + way * direction[1],
                    p[2] + way * direction[2],
                ]
            }));
        }
        path
    }
}
