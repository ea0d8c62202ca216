//! A twin: the fitted result, everything that a rollout needs.

pub mod appearance;
pub mod fidelity;
pub mod format;
pub mod identifiability;
mod mean;
mod member;
pub mod planner;
pub mod quality;
pub mod skin;
pub mod surface;

use serde::{Deserialize, Serialize};

use crate::{
    Appearance, Environment, Graph, Params, PlannersTwin, Quality, Skin, Surface, Timing,
    environment::ControlVelocity,
    geometry::{length, sub},
    settings::FitSettings,
};

pub use mean::Mean;
pub use member::{Member, spread};

/// A fitted spring-mass model of an object.
#[derive(Clone, Debug, PartialEq)]
pub struct Twin {
    /// Nodes, springs, triplets.
    pub graph: Graph,
    /// Surface points that the nodes carry.
    pub skin: Skin,
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
    /// Mass of the object, if it is known [kg].
    pub mass_kg: Option<f64>,
    /// The hand or gripper of the capture that each control point belongs to, shape [C]; empty if the
    /// capture does not say: [`Twin::hands`].
    pub control_hands: Vec<u32>,
    /// Other fits of the same object, whose predictions differ as far as the capture leaves open;
    /// at most [`MOST_MEMBERS`](crate::settings::MOST_MEMBERS).
    pub members: Vec<Member>,
    /// Colours and Gaussians; none if no camera saw the object.
    pub appearance: Option<Appearance>,
    /// What people see of it; none in files of earlier builds.
    pub surface: Option<Surface>,
    /// A small twin that plans are made with; none if it was not asked for.
    pub planner: Option<PlannersTwin>,
}

impl Twin {
    /// A twin of a graph with these numbers, of unknown origin and quality, in
    /// [`Environment::Z_UP`]; its nodes are its skin.
    pub fn new(graph: Graph, params: Params, timing: Timing) -> Self {
        Self {
            skin: Skin::of_nodes(&graph),
            graph,
            params,
            environment: Environment::Z_UP,
            timing,
            control_velocity: ControlVelocity::default(),
            provenance: Provenance::default(),
            quality: Quality::default(),
            mass_kg: None,
            control_hands: Vec::new(),
            members: Vec::new(),
            appearance: None,
            surface: None,
            planner: None,
        }
    }

    /// Newtons per unit of force: fitted forces are those on nodes of about unit mass. 1 if the mass is
    /// not known.
    pub fn newtons_per_unit(&self) -> f64 {
        let units: f64 = self.graph.masses.iter().map(|m| f64::from(*m)).sum();
        self.mass_kg.map_or(1.0, |mass| mass / units)
    }

    /// The hand of each control point, shape [C], counted from 0. If the capture does not say,
    /// control points linked by steps of at most [`HAND_LINK_M`] at rest are one hand, in the order
    /// of their first.
    pub fn hands(&self) -> Vec<u32> {
        let points = &self.graph.control_rest;
        if self.control_hands.len() == points.len() {
            return self.control_hands.clone();
        }
        let mut hands = vec![None; points.len()];
        let mut count = 0;
        for first in 0..points.len() {
            if hands[first].is_some() {
                continue;
            }
            hands[first] = Some(count);
            let mut linked = vec![first];
            while let Some(from) = linked.pop() {
                for (to, point) in points.iter().enumerate() {
                    if hands[to].is_none() && length(sub(points[from], *point)) <= HAND_LINK_M {
                        hands[to] = Some(count);
                        linked.push(to);
                    }
                }
            }
            count += 1;
        }
        hands.into_iter().map(Option::unwrap_or_default).collect()
    }
}

/// Largest distance between neighbouring control points of one hand [m].
pub const HAND_LINK_M: f32 = 0.08;

/// The origin of a twin. Nothing here depends on the wall clock: the same capture, settings, build
/// and device give the same twin, byte for byte.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// BLAKE3 digest of the content of the capture that was fitted (a raw recording's observation),
    /// hex; empty if made by hand. Equal content has the same digest in any file.
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
    /// BLAKE3 digest of the file of the twin that this one was refined from, hex; none if it was
    /// searched.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refined_from: Option<String>,
    /// Loss that the fit ended with, by which its start was chosen among others; kept beside those of
    /// the twin's members ([`Twin::fit_weights`]).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub loss: Option<f64>,
}

#[cfg(test)]
mod tests;
