//! The way to a goal: the server's planner is asked from where the session is, its plan is followed,
//! and it is asked again until the points are near enough or nothing is gained.

use std::collections::VecDeque;

use bendtwin_proto::v1::{
    ActionSpace, Cost, InitialState, PlanBounds, PlanMethod, PlanRequest, PlanUpdate,
    RollOutRequest, Tensor,
    action_space::Coordinates,
    cost::{Keypoints, Kind, When},
    initial_state::{SessionSlots, State},
    plan_method::{Method, Mppi},
};
use serde::Serialize;

use super::{
    message::{Goal, GoalTarget},
    rows::{Pose, Rows},
    scene::Scene,
};
use crate::{Error, Result};

/// Frames of a plan, and distance that is near enough [m], where a goal does not say.
const FRAMES: u32 = 30;
const TOLERANCE_M: f64 = 0.01;
/// Times that the planner is asked.
const ROUNDS: u32 = 6;
/// Share of the distance that a round has to gain for another one.
const GAIN: f64 = 0.05;
const KNOTS: usize = 5;
const SAMPLES: u32 = 48;
const ITERATIONS: u32 = 8;
const DEADLINE_S: f64 = 4.0;
const SIGMA_M: f32 = 0.08;
const SPEED_M_S: f32 = 1.0;

/// Progress towards a goal, as shown to the user.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Progress {
    pub(super) state: Stage,
    pub(super) round: u32,
    pub(super) iterations: u32,
    pub(super) simulated: u32,
    /// Mean distance of the points that the plan ends at [m].
    pub(super) planned_m: Option<f64>,
    /// Mean distance of the points now [m].
    pub(super) distance_m: f64,
    pub(super) targets: Vec<GoalTarget>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Stage {
    Planning,
    Moving,
    Reached,
    NotReached,
    Stopped,
}

/// A goal that is pursued.
pub(super) struct Pursuit {
    goal: Goal,
    movable: Vec<bool>,
    pub(super) progress: Progress,
    begun_m: f64,
}

impl Pursuit {
    /// # Errors
    /// If nothing could reach it.
    pub(super) fn new(goal: Goal, scene: &Scene) -> Result<Self> {
        let count = scene.positions().len();
        if let Some(beyond) = goal.targets.iter().find(|t| t.node as usize >= count) {
            let fault = format!("name node {}: the twin has {count} (counted from 0)", beyond.node);
            return Err(Error::invalid("targets", fault));
        }
        let movable = scene.holding();
        if !movable.contains(&true) {
            let fault = "cannot be reached: no gripper holds the object, let one grasp it first";
            return Err(Error::invalid("targets", fault));
        }
        let mut nodes: Vec<u32> = goal.targets.iter().map(|t| t.node).collect();
        nodes.sort_unstable();
        nodes.dedup();
        if nodes.len() < goal.targets.len() {
            return Err(Error::invalid("targets", "name a node twice"));
        }
        let progress = Progress {
            state: Stage::Planning,
            round: 0,
            iterations: 0,
            simulated: 0,
            planned_m: None,
            distance_m: distance(&goal.targets, scene.positions()),
            targets: goal.targets.clone(),
        };
        Ok(Self { goal, movable, begun_m: progress.distance_m, progress })
    }

    /// The plan to ask for from where a session is.
    pub(super) fn request(&mut self, session: &str, scene: &Scene, seed: u64) -> PlanRequest {
        self.progress.state = Stage::Planning;
        self.progress.round += 1;
        self.progress.iterations = 0;
        self.begun_m = self.progress.distance_m;
        let frames = self.goal.frames.unwrap_or(FRAMES);
        let still = still(scene);
        let nodes: Vec<u32> = self.goal.targets.iter().map(|t| t.node).collect();
        let targets: Vec<[f32; 3]> = self.goal.targets.iter().map(|t| t.position).collect();
        let keypoints = Keypoints {
            nodes: Some(Tensor::pack(&[nodes.len()], &nodes)),
            targets: Some(Tensor::pack_points(&[targets.len()], &targets)),
            ..Keypoints::default()
        };
        let cost = Cost {
            name: "distance".to_owned(),
            when: When::LastFrame.into(),
            kind: Some(Kind::Keypoints(keypoints)),
            ..Cost::default()
        };
        let slots = SessionSlots { session: session.to_owned(), slots: vec![0] };
        let rollout = RollOutRequest {
            initial: Some(InitialState { state: Some(State::Session(slots)) }),
            costs: vec![cost],
            returns: None,
            frames,
            ..still.request(&scene.template(), 0..KNOTS)
        };
        // Grippers that hold nothing stay.
        let by_coordinate = |moves: f32, stays: f32| {
            let each = self.movable.iter().flat_map(|m| [if *m { moves } else { stays }; 3]);
            let values: Vec<f32> = each.collect();
            Some(Tensor::pack(&[values.len()], &values))
        };
        PlanRequest {
            rollout: Some(rollout),
            space: Some(ActionSpace {
                coordinates: Coordinates::Translation.into(),
                ..ActionSpace::default()
            }),
            method: Some(PlanMethod { method: Some(Method::Mppi(Mppi::default())) }),
            samples: SAMPLES,
            iterations: ITERATIONS,
            sigma: by_coordinate(SIGMA_M, 0.0),
            correlation: 0.6,
            bounds: Some(PlanBounds {
                speed: Some(Tensor::pack(&[1], &[SPEED_M_S])),
                ..PlanBounds::default()
            }),
            seed,
            deadline_s: DEADLINE_S,
            ..PlanRequest::default()
        }
    }

    /// Takes in an update of the plan.
    pub(super) fn learn(&mut self, update: &PlanUpdate) {
        self.progress.iterations = update.iterations;
        self.progress.simulated = update.simulated;
        self.progress.planned_m = Some(update.cost).filter(|cost| cost.is_finite());
    }

    /// Poses of all grippers along the plan, frame by frame.
    ///
    /// # Errors
    /// If the plan has another shape.
    pub(super) fn path(&mut self, update: &PlanUpdate) -> Result<VecDeque<Vec<Pose>>> {
        let internal = |fault: String| Error::Unreadable(format!("a plan of a play: {fault}"));
        let knots = update.knots.as_ref().ok_or_else(|| internal("no knots".to_owned()))?;
        let (shape, values) = knots.unpack::<f32>("knots").map_err(|e| internal(e.to_string()))?;
        let (count, grippers) = match shape[..] {
            [1, count, grippers, 7] if count >= 2 => (count, grippers),
            _ => return Err(internal(format!("shape {shape:?}"))),
        };
        self.progress.state = Stage::Moving;
        let poses = values.as_chunks::<7>().0;
        let frames = self.goal.frames.unwrap_or(FRAMES);
        let path = (1..=frames).map(|frame| {
            let at = f64::from(frame) / f64::from(frames) * (count - 1) as f64;
            let knot = (at as usize).min(count - 2);
            let share = (at - knot as f64) as f32;
            let pose = |g: usize| {
                let (a, b) = (poses[knot * grippers + g], poses[(knot + 1) * grippers + g]);
                // A plan translates.
                std::array::from_fn(|i| if i < 3 { a[i] + share * (b[i] - a[i]) } else { a[i] })
            };
            (0..grippers).map(pose).collect()
        });
        Ok(path.collect())
    }

    /// After the plan was followed: true if it is worth another one.
    pub(super) fn continues(&mut self, scene: &Scene) -> bool {
        self.see(scene);
        let tolerance = self.goal.tolerance_m.unwrap_or(TOLERANCE_M);
        if self.progress.distance_m <= tolerance {
            self.progress.state = Stage::Reached;
            return false;
        }
        let gained = self.progress.distance_m < (1.0 - GAIN) * self.begun_m;
        if self.progress.round >= ROUNDS || !gained {
            self.progress.state = Stage::NotReached;
            return false;
        }
        true
    }

    /// Takes in where the points are.
    pub(super) fn see(&mut self, scene: &Scene) {
        self.progress.distance_m = distance(&self.goal.targets, scene.positions());
    }
}

/// Everything stays where it is.
fn still(scene: &Scene) -> Rows {
    let now = scene.next();
    let repeat = |row: &[Pose]| row.iter().copied().cycle().take(KNOTS * row.len()).collect();
    Rows {
        widths: now.widths,
        poses: repeat(now.grippers(0)),
        closed: now.closed(0).iter().copied().cycle().take(KNOTS * now.widths[1]).collect(),
        paths: repeat(now.colliders(0)),
    }
}

/// Mean distance of points to their places [m].
fn distance(targets: &[GoalTarget], positions: &[[f32; 3]]) -> f64 {
    let each = targets.iter().filter_map(|target| {
        let at = positions.get(target.node as usize)?;
        let way = (0..3).map(|i| f64::from(at[i] - target.position[i]).powi(2));
        Some(way.sum::<f64>().sqrt())
    });
    let (sum, count) = each.fold((0.0, 0.0f64), |(sum, count), d| (sum + d, count + 1.0));
    sum / count.max(1.0)
}
