//! Checkpoint of a fit, to continue it in another process: a magic word, a version, then postcard.

use bendtwin_core::FitSettings;
use serde::{Deserialize, Serialize};

use crate::{Error, cmaes::CmaEs, refine::RunState};

/// The first bytes of every checkpoint.
const MAGIC: &[u8; 4] = b"BTFC";
/// Format version; raised by every change of [`Checkpoint`] or of what a stage computes from it.
const VERSION: u32 = 5;

/// The state of a fit that changes while it runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Checkpoint {
    /// The fit that it belongs to.
    pub(crate) identity: Identity,
    /// The state of each model's fit, in the order of the fit.
    pub(crate) models: Vec<ModelFitState>,
}

/// Identity of the fit that a checkpoint belongs to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Identity {
    pub(crate) capture_digest: String,
    pub(crate) settings: FitSettings,
    pub(crate) build: String,
    pub(crate) backend: String,
}

/// The state of one model's fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum ModelFitState {
    /// In the search, after a generation.
    Search(CmaEs),
    /// In the refinement, after a pass.
    Refine {
        /// Best point of the search, in the unit cube.
        point: Vec<f64>,
        /// The optimizer run from there.
        run: RunState,
    },
}

impl Checkpoint {
    pub(crate) fn to_bytes(&self) -> Result<Vec<u8>, Error> {
        let mut bytes = [MAGIC.as_slice(), &VERSION.to_le_bytes()].concat();
        let content = postcard::to_stdvec(self).map_err(|e| Error::Checkpoint(e.to_string()))?;
        bytes.extend(content);
        Ok(bytes)
    }

    /// Reads a checkpoint of the fit `identity`.
    pub(crate) fn from_bytes(bytes: &[u8], identity: &Identity) -> Result<Self, Error> {
        let damaged = |why: &str| Error::Checkpoint(why.to_owned());
        let rest = bytes.strip_prefix(MAGIC).ok_or_else(|| damaged("it is no fit checkpoint"))?;
        let (version, content) =
            rest.split_first_chunk().ok_or_else(|| damaged("it is cut short"))?;
        let version = u32::from_le_bytes(*version);
        if version != VERSION {
            return Err(Error::Checkpoint(format!(
                "it has version {version}, this build reads {VERSION}"
            )));
        }
        let checkpoint: Self =
            postcard::from_bytes(content).map_err(|e| Error::Checkpoint(e.to_string()))?;
        if checkpoint.identity == *identity { Ok(checkpoint) } else { Err(Error::OtherCheckpoint) }
    }
}

#[cfg(test)]
mod tests;
