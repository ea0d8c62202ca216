//! Actions of the robot: control trajectories, or poses of grippers that carry
//! the control points. Both end as control positions at every frame boundary.

mod gradients;
mod poses;
mod rolls;
mod stops;

use bendtwin_core::{Graph, Point};
use bendtwin_engine::{backend::Gradient, world::Pose};
use bendtwin_proto::v1::{
    ControlTrajectories, KnotTimes, Tensor, roll_out_request::Actions as Wire,
};

pub(crate) use self::poses::pose;
use self::poses::{Knots, Poses};
pub(crate) use self::stops::{Floor, Stopped, Stops};
use crate::{
    error::Error,
    request::interpolate::{Curve, Schedule},
};

/// The actions of a batch of B instances with K knots each; every number is finite.
pub(crate) struct Actions {
    shape: Shape,
    schedule: Schedule,
    kind: Kind,
    /// Rigid body of each control point: a gripper, or a hand; shape [C].
    hands: Vec<usize>,
}

enum Kind {
    Trajectories(Trajectories),
    Poses(Poses),
}

/// Positions of every control point.
struct Trajectories {
    controls: usize,
    /// [m], shape [B, K, C, 3].
    positions: Vec<Point>,
}

/// Number of instances and of knots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shape {
    pub(crate) instances: usize,
    pub(crate) knots: usize,
}

/// The time that actions are spread over.
pub(crate) struct Horizon {
    /// Number of frames F.
    pub(crate) frames: usize,
    /// Frames per second.
    pub(crate) fps: f64,
    /// Times of the knots; none: evenly.
    pub(crate) times: Option<KnotTimes>,
}

impl Actions {
    /// Reads the actions of a checked request to a twin with `controls` control points.
    pub(crate) fn read(
        wire: Option<Wire>,
        controls: usize,
        horizon: Horizon,
    ) -> Result<Self, Error> {
        let (shape, curve, kind) = match wire {
            Some(Wire::Trajectories(w)) => {
                let curve = Curve::from(w.interpolation());
                let (shape, trajectories) = Trajectories::read(w)?;
                (shape, curve, Kind::Trajectories(trajectories))
            }
            Some(Wire::Poses(w)) => {
                let curve = Curve::from(w.interpolation());
                let (shape, poses) = Poses::read(w, controls)?;
                (shape, curve, Kind::Poses(poses))
            }
            None => return Err(Error::field("actions", "are missing")),
        };
        let Horizon { frames, fps, times } = horizon;
        let schedule = Schedule::new(curve, shape.knots, frames, times, fps)?;
        let hands = match &kind {
            Kind::Trajectories(_) => vec![0; controls],
            Kind::Poses(p) => p.gripper_of_control.clone(),
        };
        Ok(Self { shape, schedule, kind, hands })
    }

    /// With the clamps of a twin's rods, which grippers turn.
    pub(crate) fn with_clamps(mut self, graph: &Graph) -> Self {
        if let Kind::Poses(p) = &mut self.kind {
            p.clamps = rolls::clamps(graph, &p.gripper_of_control);
        }
        self
    }

    /// With the hands of a twin's control points, shape [C], which move as one body where no
    /// gripper carries them.
    pub(crate) fn with_hands(mut self, hands: &[u32]) -> Self {
        if let Kind::Trajectories(_) = &self.kind {
            let mut numbers = hands.to_vec();
            numbers.sort_unstable();
            numbers.dedup();
            let index = |hand: &u32| numbers.binary_search(hand).unwrap_or_default();
            self.hands = hands.iter().map(index).collect();
        }
        self
    }

    /// Number of instances and of knots.
    pub(crate) fn shape(&self) -> Shape {
        self.shape
    }

    /// Control positions of an instance at every frame boundary [m], shape [F + 1, C, 3].
    /// `start` are the control points in the initial state, shape [C, 3].
    pub(crate) fn controls(&self, instance: usize, start: &[Point]) -> Vec<Point> {
        match &self.kind {
            Kind::Trajectories(t) => t.controls(instance, self.shape, &self.schedule),
            Kind::Poses(p) => p.controls(instance, self.shape, &self.schedule, start),
        }
    }

    /// Poses of the G grippers of an instance at every frame boundary, shape [F + 1, G]; none if
    /// control points are moved without grippers.
    pub(crate) fn bodies(&self, instance: usize) -> Vec<Pose> {
        match &self.kind {
            Kind::Trajectories(_) => Vec::new(),
            Kind::Poses(p) => p.matrices(instance, self.shape, &self.schedule),
        }
    }

    /// Number of grippers G.
    pub(crate) fn grippers(&self) -> usize {
        match &self.kind {
            Kind::Trajectories(_) => 0,
            Kind::Poses(p) => p.grippers(),
        }
    }

    /// Knot at or before each frame boundary, shape [F + 1].
    pub(crate) fn knots(&self) -> Vec<usize> {
        self.schedule.places().iter().map(|place| place.knot).collect()
    }

    /// Poses at every frame boundary along a path with knots like those of the actions: positions [m]
    /// and quaternions, shape [K, 7].
    pub(crate) fn along(&self, path: &[[f32; 7]]) -> Vec<Pose> {
        let knots = Knots { grippers: 1, rows: path };
        self.schedule.places().iter().map(|place| knots.at(place, 0).matrix()).collect()
    }

    /// Rolls of both ends of a twin's R rods at frame boundaries, shape [F + 1, R, 2], where control points are at
    /// `controls`, shape [F + 1, C, 3]. Empty if no gripper holds a clamp or, unless they are
    /// `kept`, if none rolls.
    pub(crate) fn rolls(
        &self,
        instance: usize,
        controls: &[Point],
        rods: usize,
        kept: bool,
    ) -> Vec<f32> {
        let Kind::Poses(p) = &self.kind else { return Vec::new() };
        if p.clamps.is_empty() {
            return Vec::new();
        }
        let placed = p.placed(instance, self.shape, &self.schedule);
        let rolls = rolls::rolls(&p.clamps, rods, &placed, controls);
        if kept || rolls.iter().any(|x| *x != 0.0) { rolls } else { Vec::new() }
    }

    /// Gradient of an instance's cost by its actions as the request gave them, [K, C, 3] or
    /// [K, G, 7], from that by control positions, by poses of bodies, those of
    /// [`bodies`](Self::bodies) first, and by rolls. Empty gradients count as zero.
    pub(crate) fn gradient(&self, instance: usize, start: &[Point], by: &Gradient) -> Vec<f32> {
        match &self.kind {
            Kind::Trajectories(t) => t.gradient(self.shape, &self.schedule, &by.controls),
            Kind::Poses(p) => p.gradient(instance, self.shape, &self.schedule, start, by),
        }
    }

    /// Packs gradients of `instances` instances, each as [`gradient`](Self::gradient) returns it.
    pub(crate) fn pack_gradients(&self, instances: usize, values: &[f32]) -> Tensor {
        let knots = self.shape.knots;
        match &self.kind {
            Kind::Trajectories(t) => Tensor::pack(&[instances, knots, t.controls, 3], values),
            Kind::Poses(p) => Tensor::pack(&[instances, knots, p.grippers(), 7], values),
        }
    }
}

impl Trajectories {
    fn read(wire: ControlTrajectories) -> Result<(Shape, Self), Error> {
        const FIELD: &str = "trajectories.positions";
        let (dims, positions) = wire.positions.unwrap_or_default().unpack_points(FIELD)?;
        let [instances, knots, controls] = dims[..] else {
            return Err(Error::field(FIELD, format!("has shape {dims:?} of points")));
        };
        Ok((Shape { instances, knots }, Self { controls, positions }))
    }

    fn controls(&self, instance: usize, shape: Shape, schedule: &Schedule) -> Vec<Point> {
        let (knots, width) = (shape.knots, self.controls);
        let rows = &self.positions[instance * knots * width..(instance + 1) * knots * width];
        let mut out = Vec::with_capacity(schedule.places().len() * width);
        for place in schedule.places() {
            place.add_row(|k| &rows[k * width..(k + 1) * width], &mut out);
        }
        out
    }
}

#[cfg(test)]
mod tests;
