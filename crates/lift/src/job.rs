//! An ingest from its recording to its observation.

mod assemble;
mod examine;
mod gather;
pub(crate) mod progress;
mod refuse;

use bendtwin_capture::raw::{Recording, Tracks};
use bendtwin_core::{CancelToken, Capture, Observer, settings::ingest::IngestSettings};
use bendtwin_flow::FlowSettings;
use rayon::prelude::*;

use self::{
    assemble::assemble,
    examine::{examine, examine_tracks},
    gather::Assembly,
};
use crate::{
    Error, Evidence, Progress, Step,
    checkpoint::{Checkpoint, Identity, TrackerResult},
    error::check,
    survey::{Unit, survey, units},
};

/// Share of an ingest that is over when the built-in tracker is done, if it has to run.
const TRACKED: f64 = 0.7;
/// Share of an ingest that is over when all frames are read.
const LIFTED: f64 = 0.9;
/// Most checkpoints written: each holds everything done before it, so they grow.
const CHECKPOINTS: usize = 32;

/// Result of lifting.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// The lifted recording. The same recording, settings and build give the same capture,
    /// regardless of interruptions and of the number of threads.
    pub capture: Capture,
    /// Evidence of its quality.
    pub evidence: Evidence,
}

/// Lifts a recording to a capture, from the start or from a checkpoint of the same ingest. Damaged
/// files count as not recorded.
///
/// # Errors
/// If settings, recording or checkpoint are wrong, frames cannot be read, there is nothing to lift,
/// the observer asks to stop, or `cancel` is set (within a second).
pub fn lift(
    recording: &Recording,
    settings: &IngestSettings,
    checkpoint: Option<&[u8]>,
    observer: &mut dyn Observer<Progress>,
    cancel: &CancelToken,
) -> Result<Observation, Error> {
    settings.validate().map_err(Error::Settings)?;
    examine(recording)?;
    let recording = &recording.usable();
    let supplied = supplied_tracks(recording)?;
    let identity = Identity::of(recording, &supplied, settings);
    let cameras = recording.cameras.len();
    let all = units(recording);
    let mut done = match checkpoint {
        Some(bytes) => Checkpoint::from_bytes(bytes, &identity, cameras, all.len())?,
        None => Checkpoint::default(),
    };
    let mut run = Run { recording, settings, identity, observer, cancel };
    let made_here: Vec<bool> = supplied.iter().map(Option::is_none).collect();
    let tracks = run.track(supplied, &mut done)?;
    run.survey(&tracks, &all, &mut done)?;
    run.tell(Step::Assemble, LIFTED);
    let observation = assemble(
        &Assembly {
            recording,
            settings,
            tracks: &tracks,
            made_here: &made_here,
            units: &all,
            done: &done,
        },
        cancel,
    )?;
    run.tell(Step::Complete, 1.0);
    Ok(observation)
}

/// The tracks that a recording brings, by camera.
fn supplied_tracks(recording: &Recording) -> Result<Vec<Option<Tracks>>, Error> {
    let read = |camera| -> Result<Option<Tracks>, Error> {
        let tracks = recording.source.frames(camera)?.tracks()?;
        Ok(tracks.filter(|t| t.count > 0))
    };
    let tracks = (0..recording.cameras.len()).map(read).collect::<Result<Vec<_>, _>>()?;
    examine_tracks(recording, &tracks)?;
    Ok(tracks)
}

struct Run<'a> {
    recording: &'a Recording,
    settings: &'a IngestSettings,
    identity: Identity,
    observer: &'a mut dyn Observer<Progress>,
    cancel: &'a CancelToken,
}

impl Run<'_> {
    fn tell(&mut self, step: Step, fraction: f64) {
        self.observer.progress(Progress { step, fraction });
    }

    fn keep(&mut self, done: &Checkpoint) -> Result<(), Error> {
        self.observer.checkpoint(done.to_bytes(&self.identity)?).map_err(Error::Observer)
    }

    /// Tracks of every camera: those supplied, or else made here.
    fn track(
        &mut self,
        supplied: Vec<Option<Tracks>>,
        done: &mut Checkpoint,
    ) -> Result<Vec<Tracks>, Error> {
        if supplied.iter().any(Option::is_none) && done.tracked.is_empty() {
            let observer = &mut *self.observer;
            let mut tell = |frames: usize, all: usize| {
                let fraction = TRACKED * frames as f64 / all.max(1) as f64;
                observer.progress(Progress { step: Step::Track, fraction });
            };
            let settings = FlowSettings::default();
            let found = bendtwin_flow::track(self.recording, &settings, &mut tell, self.cancel)?;
            done.tracked = found.into_iter().map(TrackerResult::from).collect();
            self.keep(done)?;
        }
        let made = |camera| done.tracked.get(camera).map(TrackerResult::tracks).unwrap_or_default();
        let tracks: Vec<Option<Tracks>> = supplied
            .into_iter()
            .enumerate()
            .map(|(camera, tracks)| tracks.or_else(|| Some(made(camera))))
            .collect();
        examine_tracks(self.recording, &tracks)?;
        Ok(tracks.into_iter().map(Option::unwrap_or_default).collect())
    }

    /// Reads all frames, in parallel batches of one unit per thread.
    fn survey(
        &mut self,
        tracks: &[Tracks],
        all: &[Unit],
        done: &mut Checkpoint,
    ) -> Result<(), Error> {
        let before = if done.tracked.is_empty() { 0.0 } else { TRACKED };
        let started_with = done.units.len();
        let batch = rayon::current_num_threads().max(1);
        let mut kept = started_with;
        for wave in all[started_with..].chunks(batch) {
            check(self.cancel)?;
            let surveyed: Vec<_> = wave
                .par_iter()
                .map(|u| survey(self.recording, *u, &tracks[u.camera], self.settings, self.cancel))
                .collect::<Result<_, _>>()?;
            done.units.extend(surveyed);
            let share = done.units.len() as f64 / all.len().max(1) as f64;
            self.tell(Step::Lift, before + (LIFTED - before) * share);
            if (done.units.len() - kept) * CHECKPOINTS >= all.len() {
                self.keep(done)?;
                kept = done.units.len();
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
