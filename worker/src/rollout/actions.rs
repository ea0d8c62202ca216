//! Actions of the robot: control trajectories, or poses of grippers that carry
//! the control points. Both end as control positions at every frame boundary.

mod poses;

use bendtwin_core::Point;
use bendtwin_proto::v1::{ControlTrajectories, roll_out_request::Actions as Wire};

use self::poses::Poses;
use super::{
    error::Error,
    interpolate::{Curve, Place},
};

/// The actions of a batch of B instances with K knots each; every number is finite.
pub(super) enum Actions {
    Trajectories(Trajectories),
    Poses(Poses),
}

/// Positions of every control point.
pub(super) struct Trajectories {
    shape: Shape,
    controls: usize,
    curve: Curve,
    /// [m], shape [B, K, C, 3].
    positions: Vec<Point>,
}

/// Number of instances and of knots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Shape {
    pub(super) instances: usize,
    pub(super) knots: usize,
}

impl Actions {
    /// Reads the actions of a checked request to a twin with `controls` control points.
    pub(super) fn read(wire: Option<Wire>, controls: usize) -> Result<Self, Error> {
        match wire {
            Some(Wire::Trajectories(w)) => Trajectories::read(w).map(Self::Trajectories),
            Some(Wire::Poses(w)) => Poses::read(w, controls).map(Self::Poses),
            None => Err(Error::field("actions", "are missing")),
        }
    }

    /// Number of instances and of knots.
    pub(super) fn shape(&self) -> Shape {
        match self {
            Self::Trajectories(t) => t.shape,
            Self::Poses(p) => p.shape,
        }
    }

    /// Control positions of an instance at every frame boundary [m], shape [F + 1, C, 3].
    /// `start` are the control points in the initial state, shape [C, 3].
    pub(super) fn controls(&self, instance: usize, frames: usize, start: &[Point]) -> Vec<Point> {
        match self {
            Self::Trajectories(t) => t.controls(instance, frames),
            Self::Poses(p) => p.controls(instance, frames, start),
        }
    }
}

impl Trajectories {
    fn read(wire: ControlTrajectories) -> Result<Self, Error> {
        const FIELD: &str = "trajectories.positions";
        let curve = Curve::from(wire.interpolation());
        let (dims, positions) = wire.positions.unwrap_or_default().unpack_points(FIELD)?;
        let [instances, knots, controls] = dims[..] else {
            return Err(Error::field(FIELD, format!("has shape {dims:?} of points")));
        };
        Ok(Self { shape: Shape { instances, knots }, controls, curve, positions })
    }

    fn controls(&self, instance: usize, frames: usize) -> Vec<Point> {
        let (knots, width) = (self.shape.knots, self.controls);
        let rows = &self.positions[instance * knots * width..(instance + 1) * knots * width];
        let mut out = Vec::with_capacity((frames + 1) * width);
        for frame in 0..=frames {
            let place = Place::of(frame, frames, knots);
            out.extend((0..width).map(|c| self.curve.at(place, knots, |k| rows[k * width + c])));
        }
        out
    }
}

#[cfg(test)]
mod tests;
