//! Reading frames: a unit of work is a block of frames of one camera, whose masks are cleaned and
//! whose tracks are lifted.

pub(crate) mod clean;
pub(crate) mod lift;

use bendtwin_capture::raw::{
    self, Camera, ColorImage, DepthImage, Frames, Mask, Recording, Region,
};
use bendtwin_core::{CancelToken, Point, settings::ingest::IngestSettings};
use serde::{Deserialize, Serialize};

use self::{
    clean::{Label, clean},
    lift::{LabelledDepth, Miss},
};
use crate::{
    Error,
    error::check,
    evidence::{LiftCounts, MaskCounts},
};

/// Frames of a unit: enough that opening a camera costs little, few enough that little is lost with
/// a process.
const UNIT_FRAMES: usize = 16;
/// Most points that a camera gives of the observed surface.
const MAX_SURFACE_POINTS: usize = 40_000;
/// Most points that a camera gives of the manipulator in a frame.
const MAX_HAND_POINTS: usize = 400;

/// A block of frames of one camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Unit {
    pub(crate) camera: usize,
    pub(crate) first: usize,
    pub(crate) end: usize,
}

/// The region that a track lies on in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum TrackLabel {
    Missed,
    Object,
    Manipulator,
}

/// The result of a unit. F frames, N tracks of the camera.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct UnitSurvey {
    /// Shape [F, N]; zero where missed.
    pub(crate) points: Vec<Point>,
    /// Shape [F, N].
    pub(crate) labels: Vec<TrackLabel>,
    pub(crate) missing_frames: usize,
    pub(crate) object: MaskCounts,
    pub(crate) manipulator: MaskCounts,
    pub(crate) lifts: LiftCounts,
    /// The object's surface in the recording's first frame, if that is part of the unit [m].
    pub(crate) surface: Vec<Point>,
    /// Points of the manipulator's surface in each frame [m], shape [F] of lists.
    pub(crate) hands: Vec<Vec<Point>>,
    /// Pixels of the object with depth in each frame, shape [F].
    pub(crate) object_px: Vec<u32>,
    /// Pixels of the manipulator with depth in each frame, shape [F].
    pub(crate) hand_px: Vec<u32>,
    /// Colours of the tracks there, 0..=1, shape [N] or empty.
    pub(crate) colors: Vec<Point>,
}

/// All units of a recording, by camera and frame.
pub(crate) fn units(recording: &Recording) -> Vec<Unit> {
    let blocks = |camera| {
        (0..recording.frame_count).step_by(UNIT_FRAMES).map(move |first| Unit {
            camera,
            first,
            end: (first + UNIT_FRAMES).min(recording.frame_count),
        })
    };
    (0..recording.cameras.len()).flat_map(blocks).collect()
}

/// Reads a unit's frames. `tracks` are those of its camera.
pub(crate) fn survey(
    recording: &Recording,
    unit: Unit,
    tracks: &raw::Tracks,
    settings: &IngestSettings,
    cancel: &CancelToken,
) -> Result<UnitSurvey, Error> {
    let camera = recording
        .cameras
        .get(unit.camera)
        .ok_or_else(|| Error::Inconsistent(format!("there is no camera {}", unit.camera)))?;
    let mut frames = recording.source.frames(unit.camera)?;
    let mut result = UnitSurvey::default();
    for frame in unit.first..unit.end {
        check(cancel)?;
        let mut reader = FrameReader { camera, frame, tracks, settings, result: &mut result };
        reader.read(&mut *frames)?;
    }
    Ok(result)
}

/// Pixels of a mask with depth.
fn with_depth(mask: Option<&Mask>, depth: &DepthImage) -> u32 {
    let Some(mask) = mask else { return 0 };
    let pairs = mask.pixels.iter().zip(&depth.pixels);
    pairs.filter(|(shown, metres)| **shown && metres.is_finite() && **metres > 0.0).count() as u32
}

struct FrameReader<'a> {
    camera: &'a Camera,
    frame: usize,
    tracks: &'a raw::Tracks,
    settings: &'a IngestSettings,
    result: &'a mut UnitSurvey,
}

impl FrameReader<'_> {
    fn read(&mut self, frames: &mut dyn Frames) -> Result<(), Error> {
        let count = self.tracks.count;
        let start = self.result.points.len();
        self.result.points.resize(start + count, [0.0; 3]);
        self.result.labels.resize(start + count, TrackLabel::Missed);
        if self.frame == 0 {
            self.result.colors = vec![[0.5; 3]; count];
        }
        let Some(depth) = frames.depth(self.frame)? else {
            self.result.missing_frames += 1;
            self.result.lifts.no_frame += count as u64;
            self.result.hands.push(Vec::new());
            self.result.object_px.push(0);
            self.result.hand_px.push(0);
            return Ok(());
        };
        self.check_size("depth", depth.width, depth.height, depth.pixels.len())?;
        let object = frames.mask(self.frame, Region::Object)?;
        let manipulator = frames.mask(self.frame, Region::Manipulator)?;
        for mask in [&object, &manipulator].into_iter().flatten() {
            self.check_size("mask", mask.width, mask.height, mask.pixels.len())?;
        }
        self.result.object_px.push(with_depth(object.as_ref(), &depth));
        self.result.hand_px.push(with_depth(manipulator.as_ref(), &depth));
        let intrinsics = &self.camera.intrinsics;
        let cleaned =
            clean(&depth, object.as_ref(), manipulator.as_ref(), intrinsics, &self.settings.masks);
        self.result.object.add(&cleaned.object);
        self.result.manipulator.add(&cleaned.manipulator);
        let labelled = LabelledDepth {
            depth: &depth,
            labels: &cleaned.labels,
            intrinsics,
            masks: &self.settings.masks,
            lift: &self.settings.lift,
        };
        self.lift(&labelled, start);
        let hand = self.surface(&labelled, Label::Manipulator, MAX_HAND_POINTS);
        self.result.hands.push(hand);
        if self.frame == 0 {
            self.result.surface = self.surface(&labelled, Label::Object, MAX_SURFACE_POINTS);
            if let Some(color) = frames.color(self.frame)? {
                self.check_size("colour", color.width, color.height, color.pixels.len())?;
                self.colors(&color);
            }
        }
        Ok(())
    }

    fn lift(&mut self, labelled: &LabelledDepth<'_>, start: usize) {
        let row = self.frame * self.tracks.count;
        let pixels = self.tracks.points[row..row + self.tracks.count].iter();
        let visible = &self.tracks.visible[row..row + self.tracks.count];
        for (track, (pixel, visible)) in pixels.zip(visible).enumerate() {
            let lifts = &mut self.result.lifts;
            if !visible {
                lifts.hidden += 1;
                continue;
            }
            let (label, depth_m) = match labelled.at(*pixel) {
                Ok(found) => found,
                Err(miss) => {
                    match miss {
                        Miss::Outside => lifts.outside += 1,
                        Miss::OffMask => lifts.off_mask += 1,
                        Miss::Unsupported => lifts.unsupported += 1,
                    }
                    continue;
                }
            };
            let point = self.camera.unproject(pixel.map(f64::from), depth_m, self.frame);
            if !point.iter().all(|x| x.is_finite()) {
                lifts.unsupported += 1;
                continue;
            }
            self.result.points[start + track] = point;
            self.result.labels[start + track] = match label {
                Label::Manipulator => TrackLabel::Manipulator,
                _ => TrackLabel::Object,
            };
            match label {
                Label::Manipulator => lifts.manipulator += 1,
                _ => lifts.object += 1,
            }
        }
    }

    /// A label's pixels in space [m]; evenly taken ones if there are more than `most`.
    fn surface(&self, labelled: &LabelledDepth<'_>, label: Label, most: usize) -> Vec<Point> {
        let inside = || labelled.labels.pixels.iter().enumerate().filter(|(_, l)| **l == label);
        let stride = inside().count().div_ceil(most).max(1);
        let width = labelled.labels.width;
        let point = |at: usize| {
            let pixel = [(at % width) as f64, (at / width) as f64];
            self.camera.unproject(pixel, f64::from(labelled.depth.pixels[at]), self.frame)
        };
        let points = inside().step_by(stride).map(|(at, _)| point(at));
        points.filter(|p| p.iter().all(|x| x.is_finite())).collect()
    }

    fn colors(&mut self, image: &ColorImage) {
        for (color, pixel) in self.result.colors.iter_mut().zip(&self.tracks.points) {
            if pixel.iter().all(|x| *x >= 0.0) {
                let (column, row) = (pixel[0].round() as usize, pixel[1].round() as usize);
                if let Some(rgb) = image.get(column, row) {
                    *color = rgb.map(|c| f32::from(c) / 255.0);
                }
            }
        }
    }

    fn check_size(&self, what: &str, w: usize, h: usize, pixels: usize) -> Result<(), Error> {
        let camera = self.camera;
        if (w, h) == (camera.width, camera.height) && pixels == w.saturating_mul(h) {
            return Ok(());
        }
        Err(Error::Inconsistent(format!(
            "camera {} has images of {} x {} pixels, but its {what} of frame {} has {w} x {h}: write them in one size",
            camera.name, camera.width, camera.height, self.frame
        )))
    }
}
