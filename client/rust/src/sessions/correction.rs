//! Corrections of sessions by what is seen.

use bendtwin_core::ids::SessionId;
pub use bendtwin_proto::v1::Tracking;
use bendtwin_proto::v1::{
    CorrectOptions, CorrectSessionRequest, corrected_session::Correction as Wire,
};

use crate::{
    Observation, Residual, State, WirePose, World, registrations::packed, resources::resource,
};

/// A correction of states by an observation.
#[derive(Clone, Debug)]
pub struct Correction {
    observation: Observation,
    options: CorrectOptions,
}

resource! { Wire =>
/// A slot that was corrected.
#[derive(Clone, Debug, PartialEq)]
pub struct Corrected {
    /// The slot.
    pub slot: u32,
    /// Distances of the points before.
    pub before: Residual,
    /// Distances of the points after.
    pub after: Residual,
    /// Largest displacement of a node [mm].
    pub moved_mm: f64,
    /// The corrected state, unless it is omitted; the rest shape stays in the session.
    pub state: Option<State>,
    /// Record of the slot, with this observation.
    pub tracking: Tracking,
    /// True if the slot was lost and has been registered by this observation.
    pub registered: bool,
}
}

impl Correction {
    /// A correction by what was seen.
    pub fn by(observation: Observation) -> Self {
        Self { observation, options: CorrectOptions::default() }
    }

    /// Deviation of a point from its place [m].
    #[must_use]
    pub fn noise_m(mut self, noise_m: f64) -> Self {
        self.options.noise_m = Some(noise_m);
        self
    }

    /// Deviation of a spring by its length: how far the shape is doubted.
    #[must_use]
    pub fn give(mut self, give: f64) -> Self {
        self.options.give = Some(give);
        self
    }

    /// Median distance of the points beyond which the correction is refused [m].
    #[must_use]
    pub fn max_residual_m(mut self, residual_m: f64) -> Self {
        self.options.max_residual_m = Some(residual_m);
        self
    }

    /// Share of the correction that the rest shape of the slot takes over, 0..=1 (default: 1): what
    /// is simulated from the slot then does not go back to where it was. Correct several times a
    /// second: the rest shape follows by repetition. With 0 the state alone is corrected.
    #[must_use]
    pub fn carry(mut self, share: f64) -> Self {
        self.options.carry = Some(share);
        self
    }

    /// Surroundings now, where they are not those in which the slot was advanced last. Nodes stay outside
    /// of its ground and its colliders.
    #[must_use]
    pub fn world(mut self, world: World) -> Self {
        self.options.world = Some(world.0);
        self
    }

    /// Poses of the first grippers now, where they carry colliders and are not where the last advance
    /// ended.
    #[must_use]
    pub fn grippers(mut self, poses: &[WirePose]) -> Self {
        self.options.grippers = Some(packed(poses));
        self
    }

    /// Registers a slot that is lost by the same observation, near where it is or else anywhere.
    #[must_use]
    pub fn register_if_lost(mut self) -> Self {
        self.options.register_if_lost = true;
        self
    }

    /// Leaves the corrected states out of the reply.
    #[must_use]
    pub fn omit_state(mut self) -> Self {
        self.options.omit_state = true;
        self
    }

    pub(super) fn into_request(self, name: SessionId, slots: &[u32]) -> CorrectSessionRequest {
        CorrectSessionRequest {
            name: name.to_string(),
            slots: slots.to_vec(),
            observation: Some(self.observation.into()),
            options: Some(self.options),
        }
    }
}

#[cfg(test)]
mod tests;
