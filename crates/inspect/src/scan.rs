//! Scan of a recording: every frame of every camera is read once, cameras side by side. Of each
//! image a few numbers are kept, and of a few frames a crop; judging them is left to the judges.

pub(crate) mod crop;
pub(crate) mod mask;
pub(crate) mod outline;
pub(crate) mod tracks;

use bendtwin_capture::raw::{
    Camera, ColorImage, DepthImage, Frames, Mask, Recording, Region, Tracks,
};
use bendtwin_core::{CancelToken, Problem as _};
use rayon::prelude::*;

use self::{crop::Crop, mask::MaskStats, outline::OutlineFit, tracks::TrackCounts};
use crate::{
    Error,
    thresholds::{OutlineThresholds, ScanThresholds, Thresholds},
    vector::Upright,
};

/// Cameras that are compared with each other; the others are measured alone.
pub(crate) const COMPARED_CAMERAS: usize = 16;
/// Frames whose crops are kept.
const CROP_FRAMES: usize = 13;
/// Interval of the crops that are compared with depth and colour at their outlines.
const OUTLINE_EVERY: usize = 3;
/// Frames that a camera reads before progress is reported.
const BATCH_FRAMES: usize = 4;
/// Cameras whose first image is kept.
const MAX_FIRST_IMAGES: usize = 8;
/// Damaged files of a camera that are named.
const MAX_DAMAGED_FILES: usize = 5;
/// Most tracks times frames that are counted.
const MAX_TRACK_POINTS: usize = 200_000_000;

/// Measurements of one camera in one frame.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FrameStats {
    /// Fingerprint of the colour image, if it was recorded.
    pub(crate) color: Option<u64>,
    /// Fingerprint of the depth image, if it was recorded.
    pub(crate) depth: Option<u64>,
    /// Number that stands for no depth instead of 0 [m], if there is one on the object.
    pub(crate) fill_value_m: Option<f32>,
    /// Pixels of the object that carry it.
    pub(crate) filled_px: usize,
    /// Depths that are NaN, infinite or negative.
    pub(crate) bad_depth_px: usize,
    pub(crate) object: Option<MaskStats>,
    pub(crate) manipulator: Option<MaskStats>,
    /// Pixels of both masks.
    pub(crate) overlap_px: usize,
    /// Smallest distance between object and manipulator [m].
    pub(crate) gap_m: Option<f64>,
    pub(crate) tracked: Option<TrackCounts>,
}

/// A file that could not be decoded.
#[derive(Clone, Debug)]
pub(crate) struct DamagedFile {
    pub(crate) frame: usize,
    pub(crate) reason: &'static str,
    pub(crate) message: String,
}

/// Measurements of one camera in all frames.
#[derive(Debug, Default)]
pub(crate) struct CameraScan {
    /// Shape [T].
    pub(crate) frames: Vec<FrameStats>,
    pub(crate) crops: Vec<Crop>,
    /// Depth and colour at the outlines of masks, in some frames.
    pub(crate) outlines: Vec<OutlineFit>,
    /// The first files that could not be decoded.
    pub(crate) damaged_files: Vec<DamagedFile>,
    /// Frames with a file that could not be decoded, ascending.
    pub(crate) damaged_frames: Vec<usize>,
    /// Number of files that could not be decoded.
    pub(crate) damaged_file_count: usize,
    /// The first colour image.
    pub(crate) first_image: Option<(usize, ColorImage)>,
    /// Places of the object that the built-in tracker could follow from frame 0, if no tracker ran.
    pub(crate) seed_count: Option<usize>,
    /// Number of tracks, if a tracker ran.
    pub(crate) track_count: Option<usize>,
    /// Median over visible tracks of their largest distance from their start [px].
    pub(crate) track_reach_px: Option<f64>,
}

impl CameraScan {
    /// True if a file of a frame could not be decoded.
    pub(crate) fn is_damaged(&self, frame: usize) -> bool {
        self.damaged_frames.binary_search(&frame).is_ok()
    }
}

/// Reads the whole recording.
pub(crate) fn scan(
    recording: &Recording,
    thresholds: &Thresholds,
    cancel: &CancelToken,
    progress: &mut dyn FnMut(f64),
) -> Result<Vec<CameraScan>, Error> {
    let with_crop = crop_frames(recording.frame_count);
    let upright = Upright::of(&recording.environment);
    let mut scanners = Vec::with_capacity(recording.cameras.len());
    for (index, camera) in recording.cameras.iter().enumerate() {
        scanners.push(CameraScanner::open(recording, index, camera, upright, thresholds));
    }
    let mut frame = 0;
    while frame < recording.frame_count {
        let batch = frame..(frame + BATCH_FRAMES).min(recording.frame_count);
        scanners.par_iter_mut().for_each(|scanner| {
            for f in batch.clone() {
                if !cancel.is_cancelled() {
                    let crop = with_crop.binary_search(&f).ok();
                    let outline = crop.is_some_and(|i| i % OUTLINE_EVERY == 0);
                    scanner.scan_frame(f, crop.is_some(), outline);
                }
            }
        });
        if cancel.is_cancelled() {
            return Err(Error::Cancelled);
        }
        frame = batch.end;
        progress(frame as f64 / recording.frame_count as f64);
    }
    Ok(scanners.into_iter().map(|scanner| scanner.scan).collect())
}

/// Frames spread evenly, the first and the last among them.
fn crop_frames(count: usize) -> Vec<usize> {
    let mut frames: Vec<usize> = match count {
        0 => Vec::new(),
        _ if count <= CROP_FRAMES => (0..count).collect(),
        _ => (0..CROP_FRAMES).map(|i| i * (count - 1) / (CROP_FRAMES - 1)).collect(),
    };
    frames.dedup();
    frames
}

struct CameraScanner<'a> {
    index: usize,
    camera: &'a Camera,
    upright: Upright,
    thresholds: &'a ScanThresholds,
    outline_thresholds: &'a OutlineThresholds,
    frames: Option<Box<dyn Frames + 'a>>,
    tracks: Option<Tracks>,
    scan: CameraScan,
}

impl<'a> CameraScanner<'a> {
    fn open(
        recording: &'a Recording,
        index: usize,
        camera: &'a Camera,
        upright: Upright,
        thresholds: &'a Thresholds,
    ) -> Self {
        let mut scanner = Self {
            index,
            camera,
            upright,
            thresholds: &thresholds.scan,
            outline_thresholds: &thresholds.outline,
            frames: None,
            tracks: None,
            scan: CameraScan::default(),
        };
        match recording.source.frames(index) {
            Ok(frames) => scanner.frames = Some(frames),
            Err(error) => scanner.note_damage(0, &error),
        }
        let tracks = scanner.frames.as_mut().map(|f| f.tracks());
        match tracks {
            Some(Ok(Some(tracks))) if tracks.points.len() <= MAX_TRACK_POINTS => {
                scanner.scan.track_count = Some(tracks.count);
                scanner.scan.track_reach_px = track_reach_px(&tracks);
                scanner.tracks = Some(tracks);
            }
            Some(Err(error)) => scanner.note_damage(0, &error),
            _ => {}
        }
        scanner
    }

    fn note_damage(&mut self, frame: usize, error: &bendtwin_capture::Error) {
        self.scan.damaged_file_count += 1;
        if self.scan.damaged_frames.last() != Some(&frame) {
            self.scan.damaged_frames.push(frame);
        }
        if self.scan.damaged_files.len() < MAX_DAMAGED_FILES {
            let (reason, message) = (error.reason(), error.to_string());
            self.scan.damaged_files.push(DamagedFile { frame, reason, message });
        }
    }

    /// The image that a reader gave; a damaged file is noted and counts as absent.
    fn or_damaged<T>(
        &mut self,
        frame: usize,
        read: Result<Option<T>, bendtwin_capture::Error>,
    ) -> Option<T> {
        read.unwrap_or_else(|error| {
            self.note_damage(frame, &error);
            None
        })
    }

    fn scan_frame(&mut self, frame: usize, has_crop: bool, has_outline: bool) {
        let Some(mut frames) = self.frames.take() else {
            self.scan.frames.push(FrameStats::default());
            return;
        };
        let color = frames.color(frame);
        let depth = frames.depth(frame);
        let object = frames.mask(frame, Region::Object);
        let manipulator = frames.mask(frame, Region::Manipulator);
        self.frames = Some(frames);
        let color = self.or_damaged(frame, color);
        let mut depth = self.or_damaged(frame, depth);
        let object = self.or_damaged(frame, object);
        let manipulator = self.or_damaged(frame, manipulator);

        let fingerprints = [
            color.as_ref().map(|c| fingerprint(c.pixels.as_flattened())),
            depth.as_ref().map(|d| fingerprint(bytemuck::cast_slice(&d.pixels))),
        ];
        let (fill_value_m, filled_px) = empty_filled(depth.as_mut(), object.as_ref());
        let measure = |mask| {
            let depth = depth.as_ref();
            mask::measure(self.camera, frame, &self.upright, mask, depth, self.thresholds)
        };
        let (object_stats, object_points) = object.as_ref().map(measure).unzip();
        let (hand_stats, hand_points) = manipulator.as_ref().map(measure).unzip();
        let gap_m = match (&object_points, &hand_points) {
            (Some(o), Some(m)) => mask::gap(o, m, self.thresholds),
            _ => None,
        };
        let tracked = self.tracks.as_ref().map(|tracks| {
            let masks = [object.as_ref(), manipulator.as_ref()];
            tracks::count(tracks, frame, masks, depth.as_ref(), self.thresholds.track_margin_px)
        });
        let overlap_px = match (&object, &manipulator) {
            (Some(o), Some(m)) => {
                o.pixels.iter().zip(&m.pixels).filter(|(o, m)| **o && **m).count()
            }
            _ => 0,
        };
        let bad = |d: &&f32| !d.is_finite() || **d < 0.0;
        self.scan.frames.push(FrameStats {
            color: fingerprints[0],
            depth: fingerprints[1],
            fill_value_m,
            filled_px,
            bad_depth_px: depth.as_ref().map_or(0, |d| d.pixels.iter().filter(bad).count()),
            object: object_stats,
            manipulator: hand_stats,
            overlap_px,
            gap_m,
            tracked,
        });
        if frame == 0 && self.tracks.as_ref().is_none_or(|t| t.count == 0) {
            let masks = [object.as_ref(), manipulator.as_ref()];
            self.scan.seed_count = Some(seeds(color.as_ref(), depth.as_ref(), masks));
        }
        if has_crop
            && self.index < COMPARED_CAMERAS
            && let (Some(object), Some(depth)) = (&object, &depth)
        {
            let crop = Crop::of(frame, object, manipulator.as_ref(), depth, color.as_ref());
            self.scan.crops.extend(crop);
        }
        if has_outline
            && let (Some(object), Some(depth)) = (&object, &depth)
            && object_stats.is_some_and(|o| o.area_px > 0)
        {
            let masks = [Some(object), manipulator.as_ref()];
            let limits = self.outline_thresholds;
            let fit = outline::measure(self.camera, masks, depth, color.as_ref(), limits);
            self.scan.outlines.extend(fit);
        }
        if self.scan.first_image.is_none() && self.index < MAX_FIRST_IMAGES {
            self.scan.first_image = color.map(|c| (frame, c));
        }
    }
}

/// Empties pixels whose number stands for no depth; returns it and how many of them the object's mask
/// shows.
fn empty_filled(depth: Option<&mut DepthImage>, object: Option<&Mask>) -> (Option<f32>, usize) {
    let Some(depth) = depth else { return (None, 0) };
    let Some(value) = depth.fill_value() else { return (None, 0) };
    let shown = object.map_or(0, |mask| {
        depth.pixels.iter().zip(&mask.pixels).filter(|(d, shown)| **shown && **d == value).count()
    });
    depth.pixels.iter_mut().filter(|d| **d == value).for_each(|d| *d = 0.0);
    (Some(value), shown)
}

/// Places of the object that the built-in tracker could follow.
fn seeds(
    color: Option<&ColorImage>,
    depth: Option<&DepthImage>,
    masks: [Option<&Mask>; 2],
) -> usize {
    match (color, depth, masks) {
        (Some(color), Some(depth), [Some(object), hand]) => {
            bendtwin_flow::seed_count(color, depth, object, hand)
        }
        _ => 0,
    }
}

fn fingerprint(bytes: &[u8]) -> u64 {
    let digest = blake3::hash(bytes);
    digest.as_bytes().iter().take(8).fold(0, |sum, b| (sum << 8) | u64::from(*b))
}

/// Median over tracks of the largest distance from where each was first seen [px].
fn track_reach_px(tracks: &Tracks) -> Option<f64> {
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
