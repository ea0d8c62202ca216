//! Checkpoint of a fit, to continue it in another process: postcard in the envelope that all
//! checkpoints share.

use bendtwin_core::{FitSettings, checkpoint::Kind};
use serde::{Deserialize, Serialize};

use crate::{Error, refine::RunState, search::cmaes::CmaEs};

/// Checkpoints of fits. The version rises with every change of [`Checkpoint`] or of what a stage
/// computes from it.
const KIND: Kind = Kind { name: "fit", magic: *b"BTFC", version: 10 };

/// The state of a fit that changes while it runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Checkpoint {
    /// The state of each model's fit, in the order of the fit.
    pub(crate) models: Vec<ModelFitState>,
    /// The starts that were chosen by frames held back; empty before that.
    pub(crate) chosen: Vec<ChosenStart>,
    /// Generations of the search, if a time limit has decided them.
    pub(crate) generations: Option<u32>,
    /// Time spent [s]; 0 without a time limit.
    pub(crate) spent_s: f64,
    /// Checkpoints of the trainings of Gaussians, one for each twin whose training was begun.
    pub(crate) trainings: Vec<Vec<u8>>,
}

/// The start of one kind of model that predicted the frames held back best.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ChosenStart {
    /// Index of the model in the fit.
    pub(crate) model: usize,
    /// Loss of each start over these frames; infinite for starts without one.
    pub(crate) losses: Vec<f64>,
}

/// Identity of the fit that a checkpoint belongs to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Identity {
    pub(crate) capture_digest: String,
    pub(crate) settings: FitSettings,
    pub(crate) backend: String,
}

/// The state of one model's fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum ModelFitState {
    /// In the search, after a generation.
    Search(CmaEs),
    /// Chosen among several starts, before its refinement on all training frames.
    Chosen {
        /// Best point of the search, in the unit cube.
        point: Vec<f64>,
    },
    /// In the refinement, after a pass.
    Refine {
        /// Best point of the search, in the unit cube.
        point: Vec<f64>,
        /// The optimizer run from there.
        run: RunState,
    },
}

impl Identity {
    /// Digest of all of it.
    fn digest(&self) -> Result<[u8; 32], Error> {
        let bytes = postcard::to_stdvec(self).map_err(|e| Error::Checkpoint(e.to_string()))?;
        Ok(*blake3::hash(&bytes).as_bytes())
    }
}

impl Checkpoint {
    /// The checkpoint of the fit `identity` as bytes.
    pub(crate) fn to_bytes(&self, identity: &Identity) -> Result<Vec<u8>, Error> {
        let content = postcard::to_stdvec(self).map_err(|e| Error::Checkpoint(e.to_string()))?;
        Ok(KIND.seal(&identity.digest()?, &content))
    }

    /// Reads a checkpoint of the fit `identity`.
    pub(crate) fn from_bytes(bytes: &[u8], identity: &Identity) -> Result<Self, Error> {
        let content = KIND.open(bytes, &identity.digest()?)?;
        postcard::from_bytes(content).map_err(|e| Error::Checkpoint(e.to_string()))
    }
}

#[cfg(test)]
mod tests;
