//! The surroundings of a play and what is done in it: grippers, what they hold, colliders, the
//! world. Each hand of the twin is a gripper, which holds as fitted until it is dropped; further
//! grippers are pointers, which take hold of any node.

mod grips;
mod motion;

use std::collections::VecDeque;

use bendtwin_proto::v1::{Fidelity, RollOutRequest, Tensor, Vary, World};

use self::grips::Grips;
use super::{
    message::{Factors, Target},
    rows::{self, Pose, Rows},
};
use crate::{Error, Result};

pub(super) use self::motion::SPEED_LIMIT_M_S;

/// Pointers beside the hands.
pub(super) const POINTERS: usize = 4;
/// Most hands of a twin that can be played with.
const MOST_HANDS: usize = 12;
/// Most colliders in a play.
pub(super) const MOST_COLLIDERS: usize = 8;

const AT_ORIGIN: Pose = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// A gripper or collider.
#[derive(Clone, Copy, Debug)]
struct Body {
    now: Pose,
    target: Pose,
}

/// Facts of a twin and its first state.
pub(super) struct Setting {
    pub(super) frame_s: f64,
    /// Hand of each control point, shape [C].
    pub(super) hands: Vec<u32>,
    /// Control points at first [m], shape [C, 3].
    pub(super) controls: Vec<[f32; 3]>,
    /// Nodes at first [m], shape [N, 3].
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) fidelity: Fidelity,
}

/// World and parameters.
#[derive(Clone, Debug, Default, PartialEq)]
struct Around {
    /// Without what moves its colliders.
    world: World,
    vary: Factors,
}

/// The scene of a play.
pub(super) struct Scene {
    frame_s: f64,
    gripper_of_control: Vec<u32>,
    hand_count: usize,
    fidelity: Fidelity,
    grippers: Vec<Body>,
    colliders: Vec<Body>,
    grips: Grips,
    around: Around,
    /// The last surroundings in which a frame was simulated, and where its colliders were.
    known_good: Option<(Around, Vec<Body>)>,
    /// Incremented by changes of anything that must be constant within a rollout.
    generation: u64,
    /// Nodes [m], shape [N, 3].
    positions: Vec<[f32; 3]>,
    /// Poses of all grippers by frame that are to come.
    path: VecDeque<Vec<Pose>>,
}

impl Scene {
    pub(super) fn new(setting: Setting) -> Result<Self> {
        let Setting { frame_s, hands, controls, positions, fidelity } = setting;
        let hand_count = hands.iter().max().map_or(0, |last| *last as usize + 1);
        if hand_count > MOST_HANDS {
            let fault = format!("has {hand_count} hands: at most {MOST_HANDS} can be played with");
            return Err(Error::invalid("twin", fault));
        }
        let middle = |hand: usize| {
            let own = hands.iter().zip(&controls).filter(|(h, _)| **h as usize == hand);
            let (sum, count) = own.fold(([0.0f64; 3], 0.0f64), |(sum, count), (_, x)| {
                (std::array::from_fn(|i| sum[i] + f64::from(x[i])), count + 1.0)
            });
            let [x, y, z] = sum.map(|sum| (sum / count.max(1.0)) as f32);
            [x, y, z, 0.0, 0.0, 0.0, 1.0]
        };
        let hands_first = (0..hand_count).map(middle);
        let poses = hands_first.chain(std::iter::repeat_n(AT_ORIGIN, POINTERS));
        let grippers: Vec<Body> = poses.map(|now| Body { now, target: now }).collect();
        Ok(Self {
            frame_s,
            gripper_of_control: hands,
            hand_count,
            fidelity,
            grips: Grips::new(hand_count, grippers.len()),
            grippers,
            colliders: Vec::new(),
            around: Around::default(),
            known_good: None,
            generation: 0,
            positions,
            path: VecDeque::new(),
        })
    }

    /// Sets targets of grippers and colliders.
    pub(super) fn aim(&mut self, grippers: &[Target], colliders: &[Target]) -> Result<()> {
        set_targets(&mut self.grippers, grippers, "grippers")?;
        set_targets(&mut self.colliders, colliders, "colliders")
    }

    /// Lets a gripper take hold of a node and of those within a radius.
    pub(super) fn grasp(
        &mut self,
        gripper: u32,
        node: u32,
        radius_m: f32,
        springs: bool,
    ) -> Result<()> {
        let Some(at) = self.positions.get(node as usize).copied() else {
            let fault =
                format!("is {node}: the twin has {} (counted from 0)", self.positions.len());
            return Err(Error::invalid("node", fault));
        };
        self.gripper(gripper)?;
        let within =
            |x: &[f32; 3]| (0..3).map(|i| (x[i] - at[i]).powi(2)).sum::<f32>() <= radius_m.powi(2);
        let near = self.positions.iter().zip(0u32..);
        let nodes = near.filter(|(x, i)| *i == node || within(x)).map(|(_, i)| i).collect();
        self.generation += u64::from(self.grips.take(gripper, node, nodes, springs));
        // A pointer goes to what it takes; a hand takes it from where it is.
        if let Some(body) =
            self.grippers.get_mut(gripper as usize).filter(|_| gripper as usize >= self.hand_count)
        {
            body.target[..3].copy_from_slice(&at);
        }
        Ok(())
    }

    /// Releases everything in a gripper.
    pub(super) fn release(&mut self, gripper: u32) -> Result<()> {
        self.gripper(gripper)?;
        self.grips.release(gripper);
        Ok(())
    }

    /// Changes world and parameters.
    pub(super) fn surround(&mut self, world: World, vary: Factors) -> Result<()> {
        if world.colliders.len() > MOST_COLLIDERS {
            let fault = format!("are more than {MOST_COLLIDERS}: take some out");
            return Err(Error::invalid("colliders", fault));
        }
        let mut bodies = Vec::new();
        let mut world = world;
        for (c, collider) in world.colliders.iter_mut().enumerate() {
            if collider.carrier.take().is_some() {
                let fault = "have a carrier: leave it out, `move` moves them";
                return Err(Error::invalid("colliders", fault));
            }
            let given = std::mem::take(&mut collider.pose);
            let target = match given[..] {
                [] => AT_ORIGIN,
                [x, y, z, a, b, c, d] => [x, y, z, a, b, c, d],
                _ => return Err(Error::invalid("colliders", "have a pose without 7 numbers")),
            };
            // An existing collider continues from its pose.
            let now = self.colliders.get(c).map_or(target, |body| body.now);
            bodies.push(Body { now, target });
        }
        self.colliders = bodies;
        let around = Around { world, vary };
        if around != self.around {
            self.around = around;
            self.generation += 1;
        }
        Ok(())
    }

    /// Goes back to the surroundings in which a frame was last simulated. False if there is nothing
    /// to go back from.
    pub(super) fn revert(&mut self) -> bool {
        let (around, colliders) = self.known_good.clone().unwrap_or_default();
        if around == self.around {
            return false;
        }
        (self.around, self.colliders) = (around, colliders);
        self.generation += 1;
        true
    }

    /// Lets grippers go along a path, frame by frame, shape [F][G].
    pub(super) fn follow(&mut self, path: VecDeque<Vec<Pose>>) {
        self.path = path;
    }

    /// True if grippers are on a path.
    pub(super) fn follows(&self) -> bool {
        !self.path.is_empty()
    }

    /// Grippers stay where they are.
    pub(super) fn stay(&mut self) {
        self.path.clear();
        self.grippers.iter_mut().chain(&mut self.colliders).for_each(|body| body.target = body.now);
    }

    /// The next frame, which is not simulated yet.
    pub(super) fn next(&self) -> Rows {
        let on_path = self.path.front();
        let ends = self.grippers.iter().enumerate().map(|(g, body)| {
            let given = on_path.and_then(|poses| poses.get(g)).copied();
            let reached = self.grips.reaches_for(g as u32).filter(|_| g >= self.hand_count);
            match reached.and_then(|node| self.positions.get(node as usize)) {
                // An empty gripper may move there immediately.
                Some(at) => motion::at(body.now, *at),
                None => motion::toward(body.now, given.unwrap_or(body.target), self.frame_s),
            }
        });
        let nows = self.grippers.iter().map(|body| body.now);
        let paths = self.colliders.iter().map(|body| body.now);
        let path_ends =
            self.colliders.iter().map(|body| motion::toward(body.now, body.target, self.frame_s));
        let closed: Vec<u32> = self.grips.closed().collect();
        Rows {
            widths: [self.grippers.len(), closed.len(), self.colliders.len()],
            poses: nows.chain(ends).collect(),
            closed: [&closed[..], &closed[..]].concat(),
            paths: paths.chain(path_ends).collect(),
        }
    }

    /// The request of a frame without its actions.
    pub(super) fn template(&self) -> RollOutRequest {
        RollOutRequest {
            grasps: self.grips.wire(),
            vary: vary(self.around.vary),
            fidelity: self.fidelity.into(),
            ..rows::template(&self.gripper_of_control, self.around.world.clone())
        }
    }

    /// Takes over a frame that was simulated.
    pub(super) fn passed(&mut self, frame: &Rows) {
        self.place(frame, 1);
        self.path.pop_front();
        self.grips.passed();
        self.known_good = Some((self.around.clone(), self.colliders.clone()));
    }

    /// Puts all moving bodies where they are at a boundary.
    pub(super) fn place(&mut self, rows: &Rows, row: usize) {
        let grippers = self.grippers.iter_mut().zip(rows.grippers(row));
        let colliders = self.colliders.iter_mut().zip(rows.colliders(row));
        grippers.chain(colliders).for_each(|(body, pose)| body.now = *pose);
    }

    /// Takes over what hands hold at the end of a replay; everything else has been released.
    pub(super) fn hold_as(&mut self, closed: &[u32]) {
        self.grips.hold_as(closed);
        self.generation += 1;
    }

    /// Makes all grippers release nodes, and dropped hands hold as fitted.
    pub(super) fn begin_again(&mut self, poses: &[Pose]) {
        self.grips = Grips::new(self.hand_count, self.grippers.len());
        self.generation += 1;
        self.path.clear();
        for (body, pose) in self.grippers.iter_mut().zip(poses) {
            *body = Body { now: *pose, target: *pose };
        }
    }

    /// Takes over where nodes are [m].
    pub(super) fn see(&mut self, positions: Vec<[f32; 3]>) {
        self.positions = positions;
    }

    /// A new segment of a recording begins: grasps may take any place in its list.
    pub(super) fn begin_segment(&mut self) {
        self.grips.begin_segment();
    }

    pub(super) fn generation(&self) -> u64 {
        self.generation
    }

    pub(super) fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    pub(super) fn hand_count(&self) -> usize {
        self.hand_count
    }

    pub(super) fn gripper_of_control(&self) -> &[u32] {
        &self.gripper_of_control
    }

    /// Poses of the grippers.
    pub(super) fn poses(&self) -> Vec<Pose> {
        self.grippers.iter().map(|body| body.now).collect()
    }

    /// Poses of the colliders.
    pub(super) fn collider_poses(&self) -> Vec<Pose> {
        self.colliders.iter().map(|body| body.now).collect()
    }

    /// True for each gripper that holds something.
    pub(super) fn holding(&self) -> Vec<bool> {
        (0..self.grippers.len() as u32).map(|g| self.grips.holds(g)).collect()
    }

    /// Gripper of each grasp.
    pub(super) fn gripper_of_grasp(&self) -> Vec<u32> {
        self.grips.wire().iter().map(|grasp| grasp.gripper).collect()
    }

    /// World and parameters as requested.
    pub(super) fn around(&self) -> (World, Factors) {
        let mut world = self.around.world.clone();
        for (collider, body) in world.colliders.iter_mut().zip(&self.colliders) {
            collider.pose = body.target.to_vec();
        }
        (world, self.around.vary)
    }

    fn gripper(&self, gripper: u32) -> Result<()> {
        let count = self.grippers.len();
        match (gripper as usize) < count {
            true => Ok(()),
            false => {
                let fault = format!("is {gripper}: there are {count} (counted from 0)");
                Err(Error::invalid("gripper", fault))
            }
        }
    }
}

fn set_targets(bodies: &mut [Body], targets: &[Target], field: &'static str) -> Result<()> {
    let count = bodies.len();
    if let Some(beyond) = targets.iter().find(|target| target.index as usize >= count) {
        let fault = format!("name {}: there are {count} (counted from 0)", beyond.index);
        return Err(Error::invalid(field, fault));
    }
    for target in targets {
        let pose = &mut bodies[target.index as usize].target;
        pose[..3].copy_from_slice(&target.position);
        if let Some(orientation) = target.orientation {
            pose[3..].copy_from_slice(&orientation);
        }
    }
    Ok(())
}

fn vary(factors: Factors) -> Option<Vary> {
    let one = |factor: Option<f32>| factor.map(|factor| Tensor::pack(&[1], &[factor]));
    (factors != Factors::default()).then(|| Vary {
        stiffness: one(factors.stiffness),
        damping: one(factors.damping),
        bending: one(factors.bending),
        friction: one(factors.friction),
        mass: one(factors.mass),
        ..Vary::default()
    })
}

#[cfg(test)]
mod tests;
