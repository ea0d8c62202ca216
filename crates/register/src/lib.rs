//! States of a twin from observed points: [`register`] finds the state of an object that stands
//! somewhere, [`correct`] brings the state of a running simulation closer to what is seen.
//!
//! Both move the nodes by the same elastic deformation ([`elastic`]): as rigid as possible, held by
//! the observed points, in place where control points are given. It knows nothing of materials, so
//! that it cannot explode; force balance is the engine's part, in frames of the twin's own physics
//! that [`register`] simulates.
//!
//! Neither leaves a node in an obstacle: the deformation stays outside of the ground and of what is
//! [`Around`] the object. [`Tracking`] says whether a state that is corrected again and again still
//! follows its object.
//!
//! [`place`] is the geometry of a registration alone: the shape of a graph that explains a cloud.
//!
//! Captures, cameras and networks are left to others: points arrive in the twin's frame.

mod around;
mod barrier;
mod carry;
mod correct;
mod elastic;
mod error;
mod observation;
mod place;
mod register;
mod residual;
mod rigid;
mod seen;
mod surface;
mod tracking;
mod tracks;
mod visible;

pub use around::{Around, Obstacle, PlacedBody};
pub use barrier::leave_obstacles;
pub use carry::carried;
pub use correct::{CorrectOptions, Corrected, correct, residual};
pub use error::Error;
pub use observation::{MAX_CAMERAS, MAX_POINTS, Observation};
pub use place::{Placement, place};
pub use register::{RegisterOptions, Registered, register};
pub use residual::{Explained, Residual};
pub use tracking::Tracking;
pub use tracks::bind_tracks;

#[cfg(test)]
mod scene;
