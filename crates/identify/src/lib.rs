//! Identifiability of a twin: which groups of its parameters the recordings leave undetermined, what
//! that means in millimetres, and what to record next.
//!
//! **Method.** The parameters change together in some thirty *directions* ([`directions`]): stiffness,
//! rest length and bending by region of the object, damping, friction, and the grip of each hand. A
//! batch of rollouts, two for each direction, gives by central differences how tracked points of the
//! training frames answer to them (J), and points of the skin in the frames after and in standard
//! motions (Q). Before a recording a direction has a plausible range, a Gaussian of covariance P; after
//! it, to first order, the covariance is
//!
//! C = (JᵀJ / s² + P⁻¹)⁻¹
//!
//! with s² the variance of the residual in training, divided by the share of the observations that are
//! independent (`noise`). A constant offset of all tracked points (a camera's depth) or of a hand is
//! marginalised: what could be explained by it says nothing about the object. Then Q C Qᵀ is the
//! variance of a point, and a recording that would lower it most is the one to make next.
//!
//! **Cost.** About 60 rollouts of the training and future frames of at most two sequences a recording,
//! and of seven motions of a second in the fast variant.
//!
//! **Repeatability.** Nothing is random and every sum has a fixed order: the same twin, capture, build
//! and device give the same report.

mod candidates;
pub mod directions;
mod motions;
mod noise;
mod posterior;
mod recorded;
mod regions;
mod report;
mod response;
#[cfg(test)]
mod strip;
mod words;

pub use regions::Regions;
pub use report::{ByMotion, identify, identify_by_motion};
