//! Messages of a browser in a play. They are small, and wait in a bounded line in which the newest
//! motion takes the place of the one before.

use std::{
    collections::VecDeque,
    sync::{Mutex, PoisonError},
};

use bendtwin_proto::{
    json::Read,
    v1::{self, InitialState},
};
use serde::{Deserialize, Serialize};
use tokio::sync::Notify;

use crate::{Error, Result};

/// Most messages that wait.
const MOST_WAITING: usize = 256;
/// Farthest that anything is from the origin [m].
const FARTHEST_M: f32 = 100.0;
/// Most grippers or colliders that one message moves.
const MOST_MOVED: usize = 32;
/// Most points of a goal.
const MOST_TARGETS: usize = 64;

/// The first message: where and how the play begins.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Begin {
    /// Always `begin`.
    #[serde(rename = "type")]
    pub kind: BeginType,
    /// Initial state, like that of a rollout; default: the rest shape.
    pub initial: Option<Read<InitialState>>,
    /// World; default: the twin's.
    pub world: Option<Read<v1::World>>,
    /// Factors of the twin's parameters.
    pub vary: Factors,
    /// True for the twin's fast variant.
    pub fast: bool,
    /// Hands that hold the object no more.
    pub dropped: Vec<u32>,
}

/// The type of the first message.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BeginType {
    /// The only one.
    #[default]
    Begin,
}

/// A message of the browser that plays.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum Message {
    /// New targets of grippers and colliders.
    Move {
        /// Number of the input, which states repeat once they follow it.
        #[serde(default)]
        input: u32,
        /// Targets of grippers.
        #[serde(default)]
        grippers: Vec<Target>,
        /// Targets of colliders.
        #[serde(default)]
        colliders: Vec<Target>,
    },
    /// A gripper takes hold of a node and of those around it.
    Grasp {
        /// Number of the input.
        #[serde(default)]
        input: u32,
        /// Number of the gripper.
        gripper: u32,
        /// The node.
        node: u32,
        /// Distance up to which other nodes are held, too [m].
        #[serde(default)]
        radius_m: f32,
        /// Hold by springs instead of exactly.
        #[serde(default)]
        springs: bool,
    },
    /// Releases everything in a gripper.
    Release {
        /// Number of the input.
        #[serde(default)]
        input: u32,
        /// Number of the gripper.
        gripper: u32,
    },
    /// Another world, and other parameters.
    World {
        /// Number of the input.
        #[serde(default)]
        input: u32,
        /// The world.
        #[serde(default)]
        world: Read<v1::World>,
        /// Factors of the twin's parameters.
        #[serde(default)]
        vary: Factors,
    },
    /// Stops and continues the simulation.
    Pause {
        /// True to stop.
        paused: bool,
    },
    /// Frames to simulate while it is paused.
    Step {
        /// Number of frames; 0 means one.
        #[serde(default)]
        frames: u32,
    },
    /// Another speed.
    Speed {
        /// Simulated over real time.
        factor: f64,
    },
    /// Back to the first state.
    Reset {},
    /// Begins or ends a recording.
    Record {
        /// True to begin.
        on: bool,
    },
    /// Shows the last recording again.
    Replay {},
    /// Points that grippers are to bring to places.
    Goal(Goal),
    /// Ends a replay or the way to a goal.
    Stop {},
    /// States up to this one were drawn.
    Seen {
        /// Number of the state.
        frame: u32,
    },
}

/// A place to go to.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Target {
    /// Number of the gripper or collider.
    pub index: u32,
    /// The place [m].
    pub position: [f32; 3],
    /// Quaternion x, y, z, w; default: unchanged.
    #[serde(default)]
    pub orientation: Option<[f32; 4]>,
}

/// Factors of a twin's own parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Factors {
    /// Factor of stiffness.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<f32>,
    /// Factor of damping.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<f32>,
    /// Factor of bending.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bending: Option<f32>,
    /// Factor of friction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<f32>,
    /// Factor of the mass.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<f32>,
}

/// Points and the places that they are to come to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Goal {
    /// The points, 1 to 64.
    pub targets: Vec<GoalTarget>,
    /// Mean distance that is near enough [m]; default 0.01.
    #[serde(default)]
    pub tolerance_m: Option<f64>,
    /// Frames of a plan, 5..=120; default 30.
    #[serde(default)]
    pub frames: Option<u32>,
}

/// A point of a goal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GoalTarget {
    /// The point: a node.
    pub node: u32,
    /// The place [m].
    pub position: [f32; 3],
}

/// Reads a message.
///
/// # Errors
/// If the text is no message, or has numbers beyond their bounds.
pub fn read(text: &str) -> Result<Message> {
    let fault = |e: serde_json::Error| Error::invalid("message", format!("is not understood: {e}"));
    let message: Message = serde_json::from_str(text).map_err(fault)?;
    match &message {
        Message::Move { grippers, colliders, .. } => {
            if grippers.len() + colliders.len() > MOST_MOVED {
                let fault = format!("are more than {MOST_MOVED}: name each once");
                return Err(Error::invalid("grippers", fault));
            }
            for target in grippers.iter().chain(colliders) {
                near(target.position)?;
                if let Some(q) = target.orientation {
                    rotation(q)?;
                }
            }
        }
        Message::Grasp { radius_m, .. } if !(0.0..=1.0).contains(radius_m) => {
            return Err(Error::invalid("radius_m", "must lie in 0..=1"));
        }
        Message::Speed { factor } if !super::clock::SPEEDS.contains(factor) => {
            return Err(Error::invalid("factor", "must lie in 0.05..=4"));
        }
        Message::Goal(goal) => {
            if goal.targets.is_empty() || goal.targets.len() > MOST_TARGETS {
                return Err(Error::invalid("targets", format!("must be 1 to {MOST_TARGETS}")));
            }
            goal.targets.iter().try_for_each(|target| near(target.position))?;
            if goal.frames.is_some_and(|frames| !(5..=120).contains(&frames)) {
                return Err(Error::invalid("frames", "must lie in 5..=120"));
            }
            if goal.tolerance_m.is_some_and(|t| !(1e-4..=1.0).contains(&t)) {
                return Err(Error::invalid("tolerance_m", "must lie in 0.0001..=1"));
            }
        }
        _ => {}
    }
    Ok(message)
}

fn near(position: [f32; 3]) -> Result<()> {
    match position.iter().all(|x| x.abs() <= FARTHEST_M) {
        true => Ok(()),
        false => Err(Error::invalid("position", format!("must lie within {FARTHEST_M} m"))),
    }
}

fn rotation(q: [f32; 4]) -> Result<()> {
    let square: f32 = q.iter().map(|x| x * x).sum();
    match (0.5..=2.0).contains(&square) {
        true => Ok(()),
        false => Err(Error::invalid("orientation", "must be a quaternion of length 1")),
    }
}

/// Messages that wait for the next frame.
#[derive(Debug, Default)]
pub struct Inbox {
    waiting: Mutex<VecDeque<Message>>,
    came: Notify,
}

impl Inbox {
    /// Adds a message.
    ///
    /// # Errors
    /// If too many wait.
    pub fn push(&self, message: Message) -> Result<()> {
        let mut waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        match (waiting.back_mut(), message) {
            (
                Some(Message::Move { input, grippers, colliders }),
                Message::Move { input: newer, grippers: new, colliders: others },
            ) => {
                *input = newer;
                replace(grippers, new);
                replace(colliders, others);
            }
            // Of worlds, too, the newest one counts.
            (Some(last @ Message::World { .. }), newer @ Message::World { .. }) => *last = newer,
            (_, message) => {
                if waiting.len() >= MOST_WAITING {
                    return Err(Error::TooFast);
                }
                waiting.push_back(message);
            }
        }
        drop(waiting);
        self.came.notify_one();
        Ok(())
    }

    /// All that wait, in their order.
    pub(super) fn take(&self) -> VecDeque<Message> {
        std::mem::take(&mut *self.waiting.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Waits for a message.
    pub(super) async fn came(&self) {
        self.came.notified().await;
    }
}

/// Replaces older targets by newer ones; bounded, since only limited indices count.
fn replace(targets: &mut Vec<Target>, newer: Vec<Target>) {
    for target in newer {
        if let Some(old) = targets.iter_mut().find(|old| old.index == target.index) {
            let orientation = target.orientation.or(old.orientation);
            *old = Target { orientation, ..target };
        } else if targets.len() < MOST_MOVED {
            targets.push(target);
        }
    }
}

#[cfg(test)]
mod tests;
