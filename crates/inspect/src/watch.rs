//! Watching a recording: every frame of every camera once, cameras side by side. Of an image only a few numbers are
//! kept, and of a few frames a sketch; what they mean is judged later.

pub(crate) mod patch;
pub(crate) mod sketch;
pub(crate) mod tracked;

use bendtwin_capture::raw::{Camera, ColorImage, Frames, Recording, Region, Tracks};
use bendtwin_core::{CancelToken, Problem as _};
use rayon::prelude::*;

use self::{patch::Patch, sketch::Sketch, tracked::Tracked};
use crate::{Error, vector::Upright};

/// Cameras that are compared with each other; the others are measured alone.
pub(crate) const COMPARED_CAMERAS: usize = 16;
/// Frames of which sketches are kept.
const SKETCHES: usize = 13;
/// Frames that a camera reads before progress is told.
const BATCH: usize = 4;
/// Cameras of which the first image is kept.
const STILLS: usize = 8;
/// Damaged files of a camera that are named.
const DAMAGES: usize = 5;
/// Most tracks times frames that are looked at.
const MOST_TRACKED: usize = 200_000_000;

/// One camera in one frame.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Glance {
    /// Fingerprint of the colour image, if it was recorded.
    pub(crate) color: Option<u64>,
    /// Fingerprint of the depth image, if it was recorded.
    pub(crate) depth: Option<u64>,
    /// Depths that are NaN, infinite or negative.
    pub(crate) bad_depth_px: usize,
    pub(crate) object: Option<Patch>,
    pub(crate) manipulator: Option<Patch>,
    /// Pixels of both masks.
    pub(crate) overlap_px: usize,
    /// Smallest distance between object and manipulator [m].
    pub(crate) gap_m: Option<f64>,
    pub(crate) tracked: Option<Tracked>,
}

/// A file that could not be decoded.
#[derive(Clone, Debug)]
pub(crate) struct Damage {
    pub(crate) frame: usize,
    pub(crate) reason: &'static str,
    pub(crate) message: String,
}

/// Everything that was kept of one camera.
#[derive(Debug, Default)]
pub(crate) struct Log {
    /// Shape [T].
    pub(crate) glances: Vec<Glance>,
    pub(crate) sketches: Vec<Sketch>,
    /// The first files that could not be decoded.
    pub(crate) damages: Vec<Damage>,
    /// How many could not.
    pub(crate) damage_count: usize,
    /// The first colour image.
    pub(crate) still: Option<(usize, ColorImage)>,
    /// Number of tracks, if a tracker ran.
    pub(crate) track_count: Option<usize>,
    /// Median over visible tracks of how far they get from where they start [px].
    pub(crate) track_reach_px: Option<f64>,
}

/// Reads the whole recording.
pub(crate) fn watch(
    recording: &Recording,
    cancel: &CancelToken,
    progress: &mut dyn FnMut(f64),
) -> Result<Vec<Log>, Error> {
    let sketched = sketched_frames(recording.frame_count);
    let upright = Upright::of(&recording.environment);
    let mut eyes = Vec::with_capacity(recording.cameras.len());
    for (index, camera) in recording.cameras.iter().enumerate() {
        eyes.push(Eye::open(recording, index, camera, upright));
    }
    let mut frame = 0;
    while frame < recording.frame_count {
        let batch = frame..(frame + BATCH).min(recording.frame_count);
        eyes.par_iter_mut().for_each(|eye| {
            for f in batch.clone() {
                if !cancel.is_cancelled() {
                    eye.see(f, sketched.binary_search(&f).is_ok());
                }
            }
        });
        if cancel.is_cancelled() {
            return Err(Error::Cancelled);
        }
        frame = batch.end;
        progress(frame as f64 / recording.frame_count as f64);
    }
    Ok(eyes.into_iter().map(|eye| eye.log).collect())
}

/// Frames spread evenly, the first and the last among them.
fn sketched_frames(count: usize) -> Vec<usize> {
    let mut frames: Vec<usize> = match count {
        0 => Vec::new(),
        _ if count <= SKETCHES => (0..count).collect(),
        _ => (0..SKETCHES).map(|i| i * (count - 1) / (SKETCHES - 1)).collect(),
    };
    frames.dedup();
    frames
}

struct Eye<'a> {
    index: usize,
    camera: &'a Camera,
    upright: Upright,
    frames: Option<Box<dyn Frames + 'a>>,
    tracks: Option<Tracks>,
    log: Log,
}

impl<'a> Eye<'a> {
    fn open(recording: &'a Recording, index: usize, camera: &'a Camera, upright: Upright) -> Self {
        let mut eye =
            Self { index, camera, upright, frames: None, tracks: None, log: Log::default() };
        match recording.source.frames(index) {
            Ok(frames) => eye.frames = Some(frames),
            Err(error) => eye.damage(0, &error),
        }
        let tracks = eye.frames.as_mut().map(|f| f.tracks());
        match tracks {
            Some(Ok(Some(tracks))) if tracks.points.len() <= MOST_TRACKED => {
                eye.log.track_count = Some(tracks.count);
                eye.log.track_reach_px = reach(&tracks);
                eye.tracks = Some(tracks);
            }
            Some(Err(error)) => eye.damage(0, &error),
            _ => {}
        }
        eye
    }

    fn damage(&mut self, frame: usize, error: &bendtwin_capture::Error) {
        self.log.damage_count += 1;
        if self.log.damages.len() < DAMAGES {
            let (reason, message) = (error.reason(), error.to_string());
            self.log.damages.push(Damage { frame, reason, message });
        }
    }

    /// What a reader gave; damage counts as absence.
    fn kept<T>(
        &mut self,
        frame: usize,
        read: Result<Option<T>, bendtwin_capture::Error>,
    ) -> Option<T> {
        read.unwrap_or_else(|error| {
            self.damage(frame, &error);
            None
        })
    }

    fn see(&mut self, frame: usize, is_sketched: bool) {
        let Some(mut frames) = self.frames.take() else {
            self.log.glances.push(Glance::default());
            return;
        };
        let color = frames.color(frame);
        let depth = frames.depth(frame);
        let object = frames.mask(frame, Region::Object);
        let manipulator = frames.mask(frame, Region::Manipulator);
        self.frames = Some(frames);
        let color = self.kept(frame, color);
        let depth = self.kept(frame, depth);
        let object = self.kept(frame, object);
        let manipulator = self.kept(frame, manipulator);

        let look = |mask| patch::look(self.camera, frame, &self.upright, mask, depth.as_ref());
        let (object_patch, object_points) = object.as_ref().map(look).unzip();
        let (hand_patch, hand_points) = manipulator.as_ref().map(look).unzip();
        let gap_m = match (&object_points, &hand_points) {
            (Some(o), Some(m)) => patch::gap(o, m),
            _ => None,
        };
        let tracked = self.tracks.as_ref().map(|tracks| {
            let masks = [object.as_ref(), manipulator.as_ref()];
            tracked::look(tracks, frame, masks, depth.as_ref())
        });
        let overlap_px = match (&object, &manipulator) {
            (Some(o), Some(m)) => {
                o.pixels.iter().zip(&m.pixels).filter(|(o, m)| **o && **m).count()
            }
            _ => 0,
        };
        let bad = |d: &&f32| !d.is_finite() || **d < 0.0;
        self.log.glances.push(Glance {
            color: color.as_ref().map(|c| fingerprint(c.pixels.as_flattened())),
            depth: depth.as_ref().map(|d| fingerprint(bytemuck::cast_slice(&d.pixels))),
            bad_depth_px: depth.as_ref().map_or(0, |d| d.pixels.iter().filter(bad).count()),
            object: object_patch,
            manipulator: hand_patch,
            overlap_px,
            gap_m,
            tracked,
        });
        if is_sketched
            && self.index < COMPARED_CAMERAS
            && let (Some(object), Some(depth)) = (&object, &depth)
        {
            let sketch = Sketch::of(frame, object, manipulator.as_ref(), depth, color.as_ref());
            self.log.sketches.extend(sketch);
        }
        if self.log.still.is_none() && self.index < STILLS {
            self.log.still = color.map(|c| (frame, c));
        }
    }
}

fn fingerprint(bytes: &[u8]) -> u64 {
    let digest = blake3::hash(bytes);
    digest.as_bytes().iter().take(8).fold(0, |sum, b| (sum << 8) | u64::from(*b))
}

/// Median over tracks of the farthest that one gets from where it was first seen [px].
fn reach(tracks: &Tracks) -> Option<f64> {
    let rows = |n: usize| tracks.points.chunks_exact(n).zip(tracks.visible.chunks_exact(n));
    let count = Some(tracks.count).filter(|n| *n > 0)?;
    let mut first: Vec<Option<[f32; 2]>> = vec![None; count];
    let mut farthest = vec![0.0_f64; count];
    for (points, visible) in rows(count) {
        for (i, (p, _)) in points.iter().zip(visible).enumerate().filter(|(_, (_, v))| **v) {
            let (Some(first), Some(far)) = (first.get_mut(i), farthest.get_mut(i)) else {
                continue;
            };
            let from = first.get_or_insert(*p);
            *far = far.max(f64::from((p[0] - from[0]).hypot(p[1] - from[1])));
        }
    }
    let seen = first.iter().zip(&farthest).filter(|(f, _)| f.is_some()).map(|(_, far)| *far);
    crate::statistics::median(seen)
}
