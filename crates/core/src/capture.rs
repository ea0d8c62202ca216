//! A capture: a recorded manipulation of a soft object, already lifted to points in space. RGB-D
//! captures have one sequence that is split in time; motion capture may have many sequences of one
//! object.

use serde::{Deserialize, Serialize};

use crate::{Environment, Point};

/// A recorded manipulation, ready to be fitted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Capture {
    /// Name for people.
    pub name: String,
    /// Frames per second.
    pub fps: f64,
    /// Gravity and ground in the capture's frame. Readers convert to z up.
    pub environment: Environment,
    /// Rotation from the source's frame to this one, row-major; identity if they are one.
    pub source_to_world: [[f32; 3]; 3],
    /// The object that moves.
    pub object: Object,
    /// Recorded sequences; at least one.
    pub sequences: Vec<Sequence>,
    /// Further recordings of the same object, each with points, control points and environment of
    /// its own, and none beyond itself. This capture is the reference: its surface gives the nodes.
    #[serde(default)]
    pub others: Vec<Self>,
}

impl Capture {
    /// Most recordings of one object, the reference included.
    pub const MOST_RECORDINGS: usize = 16;

    /// All recordings of the object: the reference, then the others.
    pub fn recordings(&self) -> impl Iterator<Item = &Self> {
        std::iter::once(self).chain(&self.others)
    }
}

/// The captured object, apart from its motion.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Object {
    /// Number of tracked points P, the same in every sequence.
    pub point_count: usize,
    /// Colours of the tracked points, 0..=1, shape [P, 3]; empty if unknown.
    pub colors: Vec<Point>,
    /// Surface points from a shape prior at the first frame [m], shape [S, 3].
    pub completed_surface: Vec<Point>,
    /// Interior points at the first frame [m], shape [I, 3].
    pub interior: Vec<Point>,
    /// Known topology as pairs of tracked points (a cable's edges); empty means
    /// that springs are found by radius.
    pub edges: Vec<[u32; 2]>,
    /// Undeformed shape of the tracked points [m], shape [P, 3]; empty means
    /// that the first frame counts as undeformed.
    pub rest_points: Vec<Point>,
    /// Tracked points that a control point holds exactly.
    pub pins: Vec<HeldPoint>,
    /// Mass, if it was weighed [kg].
    pub mass_kg: Option<f64>,
    /// The hand or gripper of each control point, shape [C]; empty if unknown.
    pub control_hands: Vec<u32>,
}

/// The kind of an object, by what is known of its topology.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// A cable: its edges are known, as in motion capture.
    Cable,
    /// Any other body: its springs are found by radius.
    Body,
}

impl Object {
    /// The kind of this object.
    pub fn subject(&self) -> Subject {
        if self.edges.is_empty() { Subject::Body } else { Subject::Cable }
    }
}

/// A tracked point held by a control point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct HeldPoint {
    /// Tracked point index.
    pub point: u32,
    /// Control point index.
    pub control: u32,
}

/// A recording: T frames of P tracked points and C control points.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sequence {
    /// Name for people.
    pub name: String,
    /// Number of frames T.
    pub frame_count: usize,
    /// Frames `0..train_frame_count` are for fitting, the rest is the future
    /// that is only predicted. 0 holds the whole sequence out.
    pub train_frame_count: usize,
    /// Tracked points [m], shape [T, P, 3].
    pub points: Vec<Point>,
    /// Visibility of each point in each frame, shape [T, P].
    pub visible: Vec<bool>,
    /// Validity of each point's motion since the previous frame, shape [T, P].
    pub motion_valid: Vec<bool>,
    /// Control points [m], shape [T, C, 3].
    pub controls: Vec<Point>,
    /// Clean tracks for metrics only [m], shape [T, K, 3]; NaN where unknown; empty if none.
    pub truth_tracks: Vec<Point>,
    /// Number of leading frames that give the initial state: 1 starts at rest in frame 0, 2 starts
    /// in frame 1 with the velocity between frames 0 and 1.
    pub start_frames: usize,
}

impl Sequence {
    /// Number of control points C.
    pub fn control_count(&self) -> usize {
        self.controls.len().checked_div(self.frame_count).unwrap_or(0)
    }

    /// Number of clean tracks K.
    pub fn truth_count(&self) -> usize {
        self.truth_tracks.len().checked_div(self.frame_count).unwrap_or(0)
    }

    /// Tracked points of a frame, shape [P, 3].
    pub fn points_at(&self, frame: usize) -> &[Point] {
        row(&self.points, self.frame_count, frame)
    }

    /// Visibility of a frame, shape [P].
    pub fn visible_at(&self, frame: usize) -> &[bool] {
        row(&self.visible, self.frame_count, frame)
    }

    /// Motion validity of a frame, shape [P].
    pub fn motion_valid_at(&self, frame: usize) -> &[bool] {
        row(&self.motion_valid, self.frame_count, frame)
    }

    /// Control points of a frame, shape [C, 3].
    pub fn controls_at(&self, frame: usize) -> &[Point] {
        row(&self.controls, self.frame_count, frame)
    }

    /// Clean tracks of a frame, shape [K, 3].
    pub fn truth_at(&self, frame: usize) -> &[Point] {
        row(&self.truth_tracks, self.frame_count, frame)
    }

    /// The frame in which a rollout of this sequence starts.
    pub fn start_frame(&self) -> usize {
        self.start_frames.saturating_sub(1)
    }

    /// True if the whole sequence is held out of fitting.
    pub fn is_held_out(&self) -> bool {
        self.train_frame_count == 0
    }
}

fn row<T>(flat: &[T], rows: usize, index: usize) -> &[T] {
    let width = flat.len().checked_div(rows).unwrap_or(0);
    &flat[index * width..(index + 1) * width]
}
