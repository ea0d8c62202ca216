//! What an ingest needs to go on in another process: a magic word, a version, then postcard.

use bendtwin_capture::raw::{self, Recording};
use bendtwin_core::{BUILD, settings::ingest::IngestSettings};
use bendtwin_flow::{CameraTracks, TrackerQuality};
use serde::{Deserialize, Serialize};

use crate::{Error, survey::Surveyed};

/// The first bytes of every checkpoint.
const MAGIC: &[u8; 4] = b"BTIC";
/// Raised by every change of [`Checkpoint`] or of what a unit computes.
const VERSION: u32 = 1;

/// All that takes long.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Checkpoint {
    identity: Identity,
    /// What the built-in tracker found, by camera; empty before, or if it is not needed.
    pub(crate) tracked: Vec<Tracked>,
    /// Units that are done, in the order of [`crate::survey::units`].
    pub(crate) units: Vec<Surveyed>,
}

/// Which ingest a checkpoint belongs to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Identity {
    recording: [u8; 32],
    settings: IngestSettings,
    build: String,
}

/// Tracks of a camera that the built-in tracker made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Tracked {
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
        // `Debug` writes every digit of a number, and lengths and names as well.
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
        Self {
            recording: *digest.finalize().as_bytes(),
            settings: settings.clone(),
            build: BUILD.to_owned(),
        }
    }
}

impl Checkpoint {
    pub(crate) fn new(identity: Identity) -> Self {
        Self { identity, tracked: Vec::new(), units: Vec::new() }
    }

    pub(crate) fn to_bytes(&self) -> Result<Vec<u8>, Error> {
        let head = [MAGIC.as_slice(), &VERSION.to_le_bytes()].concat();
        postcard::to_extend(self, head).map_err(|e| Error::Checkpoint(e.to_string()))
    }

    /// Reads a checkpoint of the ingest `identity`, of a recording with so many cameras and units.
    pub(crate) fn from_bytes(
        bytes: &[u8],
        identity: &Identity,
        cameras: usize,
        units: usize,
    ) -> Result<Self, Error> {
        let damaged = |why: &str| Error::Checkpoint(why.to_owned());
        let rest =
            bytes.strip_prefix(MAGIC).ok_or_else(|| damaged("it is no ingest checkpoint"))?;
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
        if checkpoint.identity != *identity {
            return Err(Error::OtherCheckpoint);
        }
        if ![0, cameras].contains(&checkpoint.tracked.len()) || checkpoint.units.len() > units {
            return Err(damaged("its parts do not fit together"));
        }
        Ok(checkpoint)
    }
}

impl From<CameraTracks> for Tracked {
    fn from(found: CameraTracks) -> Self {
        let raw::Tracks { count, points, visible } = found.tracks;
        Self { count, points, visible, quality: found.quality }
    }
}

impl Tracked {
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
