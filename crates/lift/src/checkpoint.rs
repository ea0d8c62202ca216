//! Checkpoint of lifting, to continue it in another process: postcard in the envelope that all
//! checkpoints share.

use bendtwin_capture::raw::{self, Recording};
use bendtwin_core::{checkpoint::Kind, settings::ingest::IngestSettings};
use bendtwin_flow::{CameraTracks, TrackerQuality};
use serde::{Deserialize, Serialize};

use crate::{Error, survey::UnitSurvey};

/// Checkpoints of lifting. The version rises with every change of [`Checkpoint`] or of what a unit
/// computes.
const KIND: Kind = Kind { name: "ingest", magic: *b"BTIC", version: 3 };

/// All that takes long.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Checkpoint {
    /// Tracks of the built-in tracker, by camera; empty before, or if it is not needed.
    pub(crate) tracked: Vec<TrackerResult>,
    /// Units that are done, in the order of [`crate::survey::units`].
    pub(crate) units: Vec<UnitSurvey>,
}

/// The work that a checkpoint belongs to: a digest of recording and settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Identity([u8; 32]);

/// Tracks of a camera that the built-in tracker made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct TrackerResult {
    count: usize,
    points: Vec<[f32; 2]>,
    visible: Vec<bool>,
    pub(crate) quality: TrackerQuality,
}

impl Identity {
    /// `supplied` are the tracks that the recording brought, by camera.
    pub(crate) fn of(
        recording: &Recording,
        supplied: &[Option<raw::Tracks>],
        settings: &IngestSettings,
    ) -> Self {
        let mut digest = blake3::Hasher::new();
        // `Debug` writes every digit of a number, and also lengths and names.
        let text = format!(
            "{:?}",
            (
                (&recording.name, recording.fps, recording.frame_count),
                (recording.train_frame_count, recording.environment, recording.source_to_world),
                &recording.cameras,
                recording.mesh.as_ref().map(|m| (&m.name, m.bytes.len(), m.to_world)),
            )
        );
        digest.update(text.as_bytes());
        if let Some(mesh) = &recording.mesh {
            digest.update(&mesh.bytes);
        }
        for p in &recording.truth_tracks {
            p.iter().for_each(|x| _ = digest.update(&x.to_le_bytes()));
        }
        for tracks in supplied {
            let Some(tracks) = tracks else {
                digest.update(b"none");
                continue;
            };
            digest.update(&(tracks.count as u64).to_le_bytes());
            for p in &tracks.points {
                p.iter().for_each(|x| _ = digest.update(&x.to_le_bytes()));
            }
            let visible: Vec<u8> = tracks.visible.iter().map(|v| u8::from(*v)).collect();
            digest.update(&visible);
        }
        digest.update(format!("{settings:?}").as_bytes());
        Self(*digest.finalize().as_bytes())
    }
}

impl Checkpoint {
    /// The checkpoint of the work `identity` as bytes.
    pub(crate) fn to_bytes(&self, identity: &Identity) -> Result<Vec<u8>, Error> {
        let content = postcard::to_stdvec(self).map_err(|e| Error::Checkpoint(e.to_string()))?;
        Ok(KIND.seal(&identity.0, &content))
    }

    /// Reads a checkpoint of the work `identity`, given the recording's numbers of cameras and
    /// units.
    pub(crate) fn from_bytes(
        bytes: &[u8],
        identity: &Identity,
        cameras: usize,
        units: usize,
    ) -> Result<Self, Error> {
        let content = KIND.open(bytes, &identity.0)?;
        let checkpoint: Self =
            postcard::from_bytes(content).map_err(|e| Error::Checkpoint(e.to_string()))?;
        if ![0, cameras].contains(&checkpoint.tracked.len()) || checkpoint.units.len() > units {
            return Err(Error::Checkpoint("its parts do not fit together".to_owned()));
        }
        Ok(checkpoint)
    }
}

impl From<CameraTracks> for TrackerResult {
    fn from(found: CameraTracks) -> Self {
        let raw::Tracks { count, points, visible } = found.tracks;
        Self { count, points, visible, quality: found.quality }
    }
}

impl TrackerResult {
    pub(crate) fn tracks(&self) -> raw::Tracks {
        raw::Tracks {
            count: self.count,
            points: self.points.clone(),
            visible: self.visible.clone(),
        }
    }
}

#[cfg(test)]
mod tests;
