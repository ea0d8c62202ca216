//! What the robot does: control trajectories, or poses of grippers that carry
//! the control points. Both end as control positions at every frame boundary.

mod poses;

use bendtwin_core::Point;
use bendtwin_proto::v1::{
    ControlTrajectories, Interpolation, Tensor, roll_out_request::Actions as Wire,
};

use self::poses::Poses;
use super::{
    error::Error,
    interpolate::{Curve, Place},
};

/// Most frames of a rollout.
pub(super) const MAX_FRAMES: usize = 100_000;

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

/// How many instances and knots there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Shape {
    pub(super) instances: usize,
    pub(super) knots: usize,
}

impl Actions {
    /// Reads the actions of a request to a twin with `controls` control points.
    pub(super) fn read(
        wire: Option<Wire>,
        controls: usize,
        max_instances: usize,
    ) -> Result<Self, Error> {
        match wire {
            Some(Wire::Trajectories(w)) => {
                Trajectories::read(w, controls, max_instances).map(Self::Trajectories)
            }
            Some(Wire::Poses(w)) => Poses::read(w, controls, max_instances).map(Self::Poses),
            None => Err(Error::field(
                "actions",
                "is missing: give `trajectories` of the control points or gripper `poses`",
            )),
        }
    }

    /// How many instances and knots there are.
    pub(super) fn shape(&self) -> Shape {
        match self {
            Self::Trajectories(t) => t.shape,
            Self::Poses(p) => p.shape,
        }
    }

    /// The horizon in frames: the one asked for, or that of dense actions.
    pub(super) fn horizon(&self, asked: u32) -> Result<usize, Error> {
        let frames = if asked == 0 { self.shape().knots - 1 } else { asked as usize };
        if frames > MAX_FRAMES {
            let fault = format!("is {frames}: it must lie in 1..={MAX_FRAMES}");
            return Err(Error::field("frames", fault));
        }
        Ok(frames)
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
    fn read(
        wire: ControlTrajectories,
        controls: usize,
        max_instances: usize,
    ) -> Result<Self, Error> {
        const FIELD: &str = "trajectories.positions";
        let curve = curve("trajectories.interpolation", wire.interpolation)?;
        let (dims, positions) = given(wire.positions, FIELD)?.unpack_points(FIELD)?;
        let [instances, knots, given] = dims[..] else {
            let fault = format!("has {} dimensions where [B, K, C, 3] has four", dims.len() + 1);
            return Err(Error::field(FIELD, fault));
        };
        if given != controls {
            let fault = format!("moves {given} control points, the twin has {controls}");
            return Err(Error::field(FIELD, fault));
        }
        let shape = Shape::checked(instances, knots, max_instances, FIELD)?;
        finite(FIELD, positions.as_flattened())?;
        Ok(Self { shape, controls, curve, positions })
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

impl Shape {
    fn checked(
        instances: usize,
        knots: usize,
        max_instances: usize,
        field: &'static str,
    ) -> Result<Self, Error> {
        if instances == 0 || knots < 2 {
            let fault = format!(
                "has {instances} instances of {knots} knots: at least 1 instance and 2 knots (start and end) are needed"
            );
            return Err(Error::field(field, fault));
        }
        if instances > max_instances {
            return Err(Error::TooLarge {
                what: "the number of instances",
                asked: instances as u128,
                limit: max_instances as u128,
                advice: "split the batch",
            });
        }
        if knots > MAX_FRAMES + 1 {
            let fault = format!("has {knots} knots: at most {} are taken", MAX_FRAMES + 1);
            return Err(Error::field(field, fault));
        }
        Ok(Self { instances, knots })
    }
}

/// A tensor that must be there.
pub(super) fn given(tensor: Option<Tensor>, field: &'static str) -> Result<Tensor, Error> {
    tensor.filter(|t| !t.is_absent()).ok_or_else(|| Error::field(field, "is missing"))
}

/// Refuses the first value that is not finite.
pub(super) fn finite(field: &'static str, values: &[f32]) -> Result<(), Error> {
    match values.iter().position(|v| !v.is_finite()) {
        Some(i) => {
            let fault = format!("value {i} (row-major) is {}: all must be finite", values[i]);
            Err(Error::field(field, fault))
        }
        None => Ok(()),
    }
}

fn curve(field: &'static str, wire: i32) -> Result<Curve, Error> {
    Interpolation::try_from(wire).map(Curve::from).map_err(|_| {
        Error::field(field, format!("has the unknown value {wire}: use LINEAR or CUBIC"))
    })
}

#[cfg(test)]
mod tests;
