//! The results of all units, put together by camera, track and frame.

use bendtwin_capture::raw::{self, Recording};
use bendtwin_core::{
    Point,
    settings::ingest::{ControlSettings, IngestSettings},
};

use crate::{
    checkpoint::Checkpoint,
    evidence::CameraEvidence,
    survey::{TrackLabel, Unit, UnitSurvey},
    tracks::Tracks,
};

/// All that an observation is made of.
pub(super) struct Assembly<'a> {
    pub(super) recording: &'a Recording,
    pub(super) settings: &'a IngestSettings,
    /// Tracks of every camera.
    pub(super) tracks: &'a [raw::Tracks],
    /// True if the built-in tracker made them, by camera.
    pub(super) made_here: &'a [bool],
    pub(super) units: &'a [Unit],
    pub(super) done: &'a Checkpoint,
}

impl Assembly<'_> {
    fn surveyed(&self) -> impl Iterator<Item = (&Unit, &UnitSurvey)> {
        self.units.iter().zip(&self.done.units)
    }

    /// All cameras' tracks that show `what` in the first frame.
    pub(super) fn gather(&self, what: TrackLabel) -> Tracks {
        let Self { recording, tracks, .. } = *self;
        let mut columns: Vec<Vec<usize>> = vec![Vec::new(); tracks.len()];
        let mut colors = Vec::new();
        for (unit, surveyed) in self.surveyed().filter(|(u, _)| u.first == 0) {
            let first = surveyed.labels.iter().take(tracks[unit.camera].count);
            for (track, _) in first.enumerate().filter(|(_, s)| **s == what) {
                columns[unit.camera].push(track);
                colors.push(surveyed.colors.get(track).copied().unwrap_or([0.5; 3]));
            }
        }
        let count = columns.iter().map(Vec::len).sum();
        let frames = recording.frame_count;
        let mut points = vec![[0.0; 3]; frames * count];
        let mut seen = vec![false; frames * count];
        let offsets = columns.iter().scan(0, |next, c| {
            let offset = *next;
            *next += c.len();
            Some(offset)
        });
        let offsets: Vec<usize> = offsets.collect();
        for (unit, surveyed) in self.surveyed() {
            let width = tracks[unit.camera].count;
            for frame in unit.first..unit.end {
                for (i, track) in columns[unit.camera].iter().enumerate() {
                    let from = (frame - unit.first) * width + track;
                    let to = frame * count + offsets[unit.camera] + i;
                    if surveyed.labels.get(from) == Some(&what) {
                        points[to] = surveyed.points[from];
                        seen[to] = true;
                    }
                }
            }
        }
        Tracks { count, frames, points, seen, colors }
    }

    /// The counts by camera.
    pub(super) fn cameras(&self) -> Vec<CameraEvidence> {
        let start = self.recording.cameras.iter().zip(self.tracks).zip(self.made_here);
        let mut cameras: Vec<CameraEvidence> = start
            .enumerate()
            .map(|(c, ((camera, tracks), made))| CameraEvidence {
                name: camera.name.clone(),
                tracks: tracks.count,
                tracker: self.done.tracked.get(c).filter(|_| *made).map(|t| t.quality.clone()),
                ..CameraEvidence::default()
            })
            .collect();
        for (unit, surveyed) in self.surveyed() {
            let camera = &mut cameras[unit.camera];
            camera.missing_frames += surveyed.missing_frames;
            camera.object.add(&surveyed.object);
            camera.manipulator.add(&surveyed.manipulator);
            camera.lifts.add(&surveyed.lifts);
        }
        cameras
    }

    /// The object's surface in the first frame, as all cameras see it [m].
    pub(super) fn surface(&self) -> Vec<Point> {
        let first = self.surveyed().filter(|(u, _)| u.first == 0);
        first.flat_map(|(_, s)| s.surface.iter().copied()).collect()
    }

    /// True for each frame in which masks show the object.
    pub(super) fn object_seen(&self) -> Vec<bool> {
        self.pixels(|s| &s.object_px).into_iter().map(|px| px > 0).collect()
    }

    /// True for each frame in which masks show a hand.
    pub(super) fn hand_seen(&self) -> Vec<bool> {
        let least = ControlSettings::MIN_PIXELS as u64;
        self.pixels(|s| &s.hand_px).into_iter().map(|px| px >= least).collect()
    }

    /// Sums over all cameras, by frame.
    fn pixels(&self, of: fn(&UnitSurvey) -> &[u32]) -> Vec<u64> {
        let mut sums = vec![0; self.recording.frame_count];
        for (unit, surveyed) in self.surveyed() {
            for (sum, px) in sums[unit.first..unit.end].iter_mut().zip(of(surveyed)) {
                *sum += u64::from(*px);
            }
        }
        sums
    }

    /// Points of the hands that all cameras see, by frame [m].
    pub(super) fn hands(&self) -> Vec<Vec<Point>> {
        let mut clouds = vec![Vec::new(); self.recording.frame_count];
        for (unit, surveyed) in self.surveyed() {
            for (frame, cloud) in (unit.first..unit.end).zip(&surveyed.hands) {
                clouds[frame].extend_from_slice(cloud);
            }
        }
        clouds
    }
}
