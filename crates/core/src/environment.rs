//! The object's environment (gravity and ground) and the division of time.

use serde::{Deserialize, Serialize};

use crate::Point;

/// Standard gravity [m/s²].
pub const STANDARD_GRAVITY: f32 = 9.81;

/// The half space that the object cannot leave: points with
/// `normal · x >= offset_m` are above the ground.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plane {
    /// Unit normal, pointing away from the ground.
    pub normal: Point,
    /// Distance of the plane from the origin along the normal [m].
    pub offset_m: f32,
}

/// Constant surroundings of a rollout.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Environment {
    /// Gravity [m/s²].
    pub gravity: Point,
    /// The ground, if there is one.
    pub ground: Option<Plane>,
}

impl Environment {
    /// z up, standard gravity, ground at z = 0.
    pub const Z_UP: Self = Self {
        gravity: [0.0, 0.0, -STANDARD_GRAVITY],
        ground: Some(Plane { normal: [0.0, 0.0, 1.0], offset_m: 0.0 }),
    };
}

/// Frame rates that captures and twins may have [1/s]. Beyond them are no cameras, but lengths of
/// frames that ruin every calculation with them.
pub const FRAME_RATES: std::ops::RangeInclusive<f64> = 0.01..=100_000.0;

/// Masses that an object may have [kg].
pub const MASSES: std::ops::RangeInclusive<f64> = 1e-6..=1e6;

/// The division of time: frames of a capture, substeps of the integrator.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// Frames per second.
    pub fps: f64,
    /// Substeps per frame.
    pub substeps: u32,
}

impl Timing {
    /// Length of a frame [s].
    pub fn frame_s(&self) -> f64 {
        1.0 / self.fps
    }

    /// Length of a substep [s].
    pub fn dt_s(&self) -> f64 {
        1.0 / (self.fps * f64::from(self.substeps))
    }
}

/// The velocity of a control point in the dashpots of control springs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ControlVelocity {
    /// The velocity with which it moves over the frame.
    #[default]
    True,
    /// Zero, as in PhysTwin.
    Ignored,
}
