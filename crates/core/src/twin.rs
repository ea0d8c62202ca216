//! A twin: the fitted result, everything that a rollout needs.

pub mod format;

use serde::{Deserialize, Serialize};

use crate::{
    Environment, Graph, Params, Quality, Timing, environment::ControlVelocity,
    settings::FitSettings,
};

/// A fitted spring-mass model of an object.
#[derive(Clone, Debug, PartialEq)]
pub struct Twin {
    /// Nodes, springs, triplets.
    pub graph: Graph,
    /// Fitted numbers.
    pub params: Params,
    /// Gravity and ground.
    pub environment: Environment,
    /// Frame rate and substeps.
    pub timing: Timing,
    /// Velocity of control points in dashpots.
    pub control_velocity: ControlVelocity,
    /// Origin of the twin.
    pub provenance: Provenance,
    /// Quality of the twin.
    pub quality: Quality,
}

/// The origin of a twin. Nothing here depends on the wall clock: the same capture, settings, build
/// and device give the same twin, byte for byte.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// BLAKE3 digest of the content of the capture that was fitted (a raw recording's observation),
    /// hex; empty if made by hand. The same content has the same digest, whatever file it came in.
    pub capture_digest: String,
    /// The capture's name.
    pub capture_name: String,
    /// The settings of the fit.
    pub settings: Option<FitSettings>,
    /// Version of the software, `bendtwin 0.1.0`.
    pub build: String,
    /// The backend that fitted it, for example `cpu`.
    pub backend: String,
    /// Rotation from the capture's source frame to the twin's, row-major.
    pub source_to_world: [[f32; 3]; 3],
}
