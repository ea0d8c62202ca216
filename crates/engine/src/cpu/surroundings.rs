//! Surroundings of an object, in the simulation's scalar: the constant part of an instance
//! ([`Surroundings`]) and the part that changes from frame to frame ([`Around`]).

pub(crate) mod body;
pub(crate) mod clamp;
pub(crate) mod force;
pub(crate) mod grasp;

use std::sync::Arc;

use self::{
    body::{BodyFrame, Pose, into_body, pose_of},
    clamp::HeldRod,
    force::FrameForces,
    grasp::{Hand, Hands},
};
use super::{
    arithmetic::{Node, Quad, Real, add, dot, scale, sub},
    collision::{collider::Collider, meet::Obstacle},
    elements::Span,
    system::System,
};
use crate::world::{Motion, World};

/// Path [m] in one frame, beyond what speeds at its start explain, within which no collider is
/// missed.
const REACH_M: f64 = 0.25;

/// Surroundings of an object during a rollout.
#[derive(Clone, Debug)]
pub(crate) struct Surroundings<T> {
    /// Bodies B.
    pub(crate) bodies: usize,
    pub(crate) colliders: Vec<Collider<T>>,
    pub(crate) hands: Vec<Hand<T>>,
    /// Width of smooth contact [m]; 0 for impacts.
    pub(crate) smoothing: T,
    /// Shape [F + 1, B].
    pub(crate) poses: Vec<Pose<T>>,
    /// Shape [F, G].
    pub(crate) closed: Vec<bool>,
    /// Shape [F + 1, R, 2], or empty.
    pub(crate) rolls: Vec<T>,
    /// Holds of the hands at the start.
    pub(crate) start: Hands<T>,
    /// Someone asks for forces.
    pub(crate) measured: bool,
    /// Grasp of each control point that is in one, by control point.
    hand_of: Vec<(usize, usize)>,
}

impl<T: Real> Surroundings<T> {
    /// Surroundings of a checked instance.
    pub(crate) fn new(world: &World, motion: &Motion, start: Hands<T>, measured: bool) -> Self {
        let hands: Vec<Hand<T>> = world.grasps.iter().map(Hand::new).collect();
        let mut hand_of: Vec<(usize, usize)> = hands
            .iter()
            .enumerate()
            .flat_map(|(g, hand)| hand.controls().iter().map(move |&c| (c as usize, g)))
            .collect();
        hand_of.sort_unstable();
        Self {
            hand_of,
            bodies: world.bodies,
            colliders: world.colliders.iter().map(Collider::new).collect(),
            smoothing: T::from_f32(world.smoothing_m),
            poses: motion.poses.iter().map(pose_of).collect(),
            closed: motion.closed.clone(),
            rolls: motion.rolls.iter().map(|&x| T::from_f32(x)).collect(),
            start,
            measured: measured || hands.iter().any(|h| h.max_force.is_finite()),
            hands,
        }
    }

    /// The grasp that a control point belongs to.
    #[inline(always)]
    pub(crate) fn hand_of(&self, control: usize) -> Option<usize> {
        let at = self.hand_of.binary_search_by_key(&control, |h| h.0).ok()?;
        Some(self.hand_of[at].1)
    }

    /// The grasps that are closed during a frame, 0-based; empty after the last.
    pub(crate) fn closed_in(&self, frame: usize) -> &[bool] {
        let g = self.hands.len();
        self.closed.get(frame * g..(frame + 1) * g).unwrap_or_default()
    }

    /// The bodies during a frame, 0-based; standing still after the last.
    pub(crate) fn bodies_of(&self, frame: usize, frames: usize, frame_s: f64) -> Vec<BodyFrame<T>> {
        let rate = T::from_f64(1.0 / frame_s);
        let row = |f: usize| f.min(frames) * self.bodies;
        (0..self.bodies)
            .map(|b| BodyFrame {
                from: self.poses[row(frame) + b],
                to: self.poses[row(frame + 1) + b],
                rate,
            })
            .collect()
    }
}

/// The changing part of the surroundings; empty where nothing surrounds the object.
#[derive(Debug)]
pub(crate) struct Around<T> {
    /// Holds of the hands.
    pub(crate) hands: Hands<T>,
    /// Nodes that they took at the beginning of this frame, with where these were.
    pub(crate) taken: Vec<(usize, Quad<T>)>,
    pub(crate) bodies: Vec<BodyFrame<T>>,
    /// Holds of rods, shape [R]; empty without hands.
    pub(crate) rods: Vec<HeldRod<T>>,
    /// Rate of each rod's twist that its clamps impose [rad/s], shape [R], or empty.
    pub(crate) roll_rates: Vec<T>,
    /// Colliders that a node may reach in this frame.
    pub(crate) near: Vec<usize>,
    /// Obstacles among them in a substep.
    pub(crate) obstacles: Vec<Obstacle<T>>,
    /// Velocities with which nodes arrive at a frame's beginning, shape [N]; empty where they are
    /// those of the nodes.
    pub(crate) arrive: Vec<Quad<T>>,
    /// The system while hands hold what they do; `None` if that changes nothing.
    pub(crate) system: Option<Arc<System<T>>>,
    /// Key of `system`: hands, nodes and spans of rods.
    pub(crate) system_of: (Vec<bool>, Vec<usize>, Vec<Span>),
    /// Forces of the last frame.
    pub(crate) forces: FrameForces<T>,
}

impl<T: Real> Default for Around<T> {
    fn default() -> Self {
        Self {
            hands: Hands::default(),
            taken: Vec::new(),
            bodies: Vec::new(),
            rods: Vec::new(),
            roll_rates: Vec::new(),
            near: Vec::new(),
            obstacles: Vec::new(),
            arrive: Vec::new(),
            system: None,
            system_of: Default::default(),
            forces: FrameForces::default(),
        }
    }
}

impl<T: Real> Around<T> {
    /// The body during this frame; the world itself for `None`.
    #[inline(always)]
    pub(crate) fn body(&self, body: Option<usize>) -> BodyFrame<T> {
        body.map_or_else(BodyFrame::world, |b| self.bodies[b])
    }

    /// Finds the colliders that nodes may reach in this frame. Distances are at most as steep as
    /// lengths, so the distance of a ball's centre bounds that of all nodes in it.
    pub(crate) fn find_near(&mut self, of: &Surroundings<T>, frame_s: f64, nodes: &[Node<T>]) {
        self.near.clear();
        if of.colliders.is_empty() {
            return;
        }
        let (center, radius) = ball(nodes);
        let fastest = nodes.iter().map(|n| dot(n.v, n.v).to_f64()).fold(0.0, f64::max).sqrt();
        let reach = radius + REACH_M + of.smoothing.to_f64() + 2.0 * fastest * frame_s;
        for (k, collider) in of.colliders.iter().enumerate() {
            let body = self.body(collider.body);
            let [from, to] = [body.from, body.to].map(|pose| into_body(&pose, center));
            let turned: f64 = (0..3)
                .map(|i| sub(body.to[i], body.from[i]))
                .map(|row| dot(row, row).to_f64())
                .sum::<f64>()
                .sqrt();
            let moved = dot(sub(to, from), sub(to, from)).to_f64().sqrt() + radius * turned;
            let gap = collider.distance(from).0.to_f64() - reach - moved;
            // Also where it is no number: then the frame ends as diverged.
            let is_far = gap > 0.0;
            if !is_far {
                self.near.push(k);
            }
        }
    }
}

/// A ball that contains all nodes.
fn ball<T: Real>(nodes: &[Node<T>]) -> (Quad<T>, f64) {
    let Some(first) = nodes.first() else { return ([T::ZERO; 4], 0.0) };
    let (mut low, mut high) = (first.x, first.x);
    for n in nodes {
        for c in 0..3 {
            low[c] = low[c].at_most(n.x[c]);
            high[c] = high[c].at_least(n.x[c]);
        }
    }
    let diagonal = sub(high, low);
    (scale(add(low, high), T::from_f64(0.5)), 0.5 * dot(diagonal, diagonal).to_f64().sqrt())
}
