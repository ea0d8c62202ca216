//! Grippers of a robot: their recorded poses and openings, from `grippers.json` beside a recording or
//! attached to it. They tell where the object is held, without masks.

mod document;
mod lerobot;
mod numbers;

use bendtwin_core::geometry::{cross, dot};

use self::document::{Axes, Document, Entry, JointSource, Poses, WidthElements, Widths};
use super::{Pose, validity::settle_pose};
use crate::{
    Error, Sources,
    files::{Files, at_most, is_plain},
    frame::Frame,
    phystwin::json,
};

/// Name of the document.
pub(super) const DOCUMENT: &str = "grippers.json";
const FORMAT: &str = "bendtwin-grippers";
const VERSION: u32 = 1;

/// Most grippers of a recording.
const MAX_GRIPPERS: usize = 8;
/// Widest opening of a gripper that holds soft objects, and largest finger [m].
const MAX_WIDTH_M: f64 = 1.0;
/// How far below zero a closed gripper may be measured [m].
const WIDTH_NOISE_M: f64 = 0.005;

/// A gripper whose motion was recorded. Its axes: the origin lies between the tips of the fingers, z
/// points out of the gripper, and the fingers open along y.
#[derive(Clone, Debug, PartialEq)]
pub struct Gripper {
    /// A person's name for it.
    pub name: String,
    /// Pose in the world in each frame [T]; `None` where it is unknown.
    pub poses: Vec<Option<Pose>>,
    /// Distance between the fingers in each frame [T] [m], NaN where it is unknown; empty if it was not
    /// recorded.
    pub widths_m: Vec<f64>,
    /// The part of a finger that touches.
    pub pad: Pad,
}

/// The part of a finger that touches what is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pad {
    /// Extent from the tip back along z [m].
    pub length_m: f64,
    /// Extent along x [m].
    pub breadth_m: f64,
}

/// Motion that a recording itself has beside its images, by names; both give an error that says what
/// is wrong with the name.
pub(super) trait Motion {
    /// Pose of a coordinate frame in the world of the cameras in each frame [T]; `None` where it is
    /// unknown.
    fn frame(&self, name: &str) -> Result<Vec<Option<Pose>>, String>;
    /// Sum of the positions of joints in each frame [T], of those of a topic if one is named; NaN where
    /// one is unknown.
    fn joints(&self, names: &[String], topic: Option<&str>) -> Result<Vec<f64>, String>;
}

/// The recording to which grippers belong.
pub(super) struct Setting<'s> {
    /// Time of each frame [T] [s].
    pub(super) times_s: &'s [f64],
    /// Turns the recording's world into this program's.
    pub(super) frame: &'s Frame,
    /// Motion by names, which MCAP has.
    pub(super) motion: Option<&'s dyn Motion>,
}

/// Times of frames at a fixed rate [T] [s].
pub(super) fn times_s(frames: usize, fps: f64) -> Vec<f64> {
    (0..frames).map(|frame| frame as f64 / fps).collect()
}

/// The grippers of a recording; none without their document.
///
/// # Errors
/// If the document contradicts itself or the recording.
pub(super) fn find(
    files: &mut Files<'_>,
    setting: &Setting<'_>,
    sources: &mut Sources,
) -> Result<Vec<Gripper>, Error> {
    match files.find_document(DOCUMENT)? {
        Some(bytes) => read(&bytes, Some(files), setting, sources),
        None => Ok(Vec::new()),
    }
}

/// The grippers of a document, whose files are beside it or missing.
///
/// # Errors
/// If the document contradicts itself or the recording.
pub(super) fn read(
    document: &[u8],
    mut files: Option<&mut Files<'_>>,
    setting: &Setting<'_>,
    sources: &mut Sources,
) -> Result<Vec<Gripper>, Error> {
    let document: Document = json(document, DOCUMENT)?;
    if document.format != FORMAT || document.version != VERSION {
        return Err(wrong(format!(
            "it is `{}` version {}: `{FORMAT}` version {VERSION} is read",
            document.format, document.version
        )));
    }
    at_most("grippers", document.grippers.len(), MAX_GRIPPERS)?;
    let mut grippers = Vec::with_capacity(document.grippers.len());
    for (index, entry) in document.grippers.into_iter().enumerate() {
        let name = if entry.name.is_empty() { index.to_string() } else { entry.name.clone() };
        let form = entry.in_words();
        let mut reader = Reader { name: &name, files: files.as_deref_mut(), setting };
        let gripper = reader.gripper(entry)?;
        sources.take("gripper", Some(&gripper.name), DOCUMENT, form);
        grippers.push(gripper);
    }
    Ok(grippers)
}

/// Reader of one gripper.
struct Reader<'r, 'f> {
    name: &'r str,
    files: Option<&'r mut Files<'f>>,
    setting: &'r Setting<'r>,
}

impl<'f> Reader<'_, 'f> {
    fn gripper(&mut self, entry: Entry) -> Result<Gripper, Error> {
        let name = self.name;
        let axes = axes(name, &entry.axes)?;
        let base = match entry.base {
            None => Pose::IDENTITY,
            Some(_) if matches!(entry.poses, Poses::Frame(_)) => {
                return Err(wrong(format!(
                    "gripper `{name}` has a `base` and a `frame`, whose poses are in the cameras' world already: leave out `base`"
                )));
            }
            Some(base) => numbers::base(name, base)?,
        };
        let frame = self.setting.frame;
        let placed = |pose: Pose| base.after(&pose).after(&axes).turned(frame);
        let poses: Vec<Option<Pose>> =
            self.poses(entry.poses)?.into_iter().map(|pose| pose.map(placed)).collect();
        if poses.iter().all(Option::is_none) {
            return Err(wrong(format!("gripper `{name}` has no pose in any frame")));
        }
        let widths_m = match entry.widths {
            None => Vec::new(),
            Some(widths) => self.widths(widths)?,
        };
        let pad = Pad { length_m: entry.pad.length_m, breadth_m: entry.pad.breadth_m };
        if ![pad.length_m, pad.breadth_m].iter().all(|x| *x > 0.0 && *x <= MAX_WIDTH_M) {
            return Err(wrong(format!(
                "the pad of gripper `{name}` is {} x {} m: give its size in metres",
                pad.length_m, pad.breadth_m
            )));
        }
        Ok(Gripper { name: name.to_owned(), poses, widths_m, pad })
    }

    /// Poses as they were recorded [T].
    fn poses(&mut self, poses: Poses) -> Result<Vec<Option<Pose>>, Error> {
        match poses {
            Poses::Numbers(numbers) => numbers::poses(self, numbers),
            Poses::Frame(source) => self.named(|motion| motion.frame(&source.frame)),
            Poses::LeRobot(pose) => lerobot::poses(self, &pose.lerobot, pose.rotation),
        }
    }

    /// Distances between the fingers [T] [m].
    fn widths(&mut self, widths: Widths) -> Result<Vec<f64>, Error> {
        let widths = match widths {
            Widths::Numbers(numbers) => numbers::widths(self, numbers)?,
            Widths::Joints(JointSource { joints, topic, scale, offset_m }) => {
                let sums = self.named(|motion| motion.joints(&joints, topic.as_deref()))?;
                scaled(sums, scale, offset_m)
            }
            Widths::LeRobot(WidthElements { lerobot, scale, offset_m }) => {
                scaled(lerobot::sums(self, &lerobot)?, scale, offset_m)
            }
        };
        let is_wrong = |w: &f64| !w.is_nan() && !(-WIDTH_NOISE_M..=MAX_WIDTH_M).contains(w);
        match widths.iter().copied().find(is_wrong) {
            None => Ok(widths.into_iter().map(|w| if w < 0.0 { 0.0 } else { w }).collect()),
            Some(width) => Err(wrong(format!(
                "gripper `{}` is open by {width}: give the distance between its fingers in metres, or `scale` and `offset_m` \
                 that make it such",
                self.name
            ))),
        }
    }

    /// What the recording has by names.
    fn named<T>(&self, of: impl FnOnce(&dyn Motion) -> Result<T, String>) -> Result<T, Error> {
        let name = self.name;
        let Some(motion) = self.setting.motion else {
            return Err(wrong(format!(
                "gripper `{name}` names frames or joints, which MCAP recordings have: give its poses in a file"
            )));
        };
        of(motion).map_err(|fault| wrong(format!("gripper `{name}`: {fault}")))
    }

    /// The files beside the document, of which one is wanted.
    fn files(&mut self, at: &str) -> Result<&mut Files<'f>, Error> {
        if !is_plain(at) {
            return Err(wrong(format!("`{at}` is no relative path of a file")));
        }
        self.files.as_deref_mut().ok_or_else(|| {
            wrong(format!(
                "gripper `{}` is read from `{at}`: put the recording, {DOCUMENT} and that file into one folder or archive",
                self.name
            ))
        })
    }
}

fn scaled(sums: Vec<f64>, scale: f64, offset_m: f64) -> Vec<f64> {
    sums.into_iter().map(|sum| offset_m + scale * sum).collect()
}

/// The rotation from the axes of this program to those of the poses.
fn axes(name: &str, axes: &Axes) -> Result<Pose, Error> {
    let unit = |axis: &str| -> Option<[f64; 3]> {
        let (sign, letter) = match axis.as_bytes() {
            [b'+', letter] | [letter] => (1.0, letter),
            [b'-', letter] => (-1.0, letter),
            _ => return None,
        };
        let index = [b'x', b'y', b'z'].iter().position(|l| l == letter)?;
        Some(std::array::from_fn(|i| if i == index { sign } else { 0.0 }))
    };
    let (Some(z), Some(y)) = (unit(&axes.approach), unit(&axes.opening)) else {
        return Err(wrong(format!(
            "the axes of gripper `{name}` are `{}` and `{}`: each must be one of +x, -x, +y, -y, +z, -z",
            axes.approach, axes.opening
        )));
    };
    if dot(y, z) != 0.0 {
        return Err(wrong(format!(
            "gripper `{name}` approaches and opens along one axis: name two different axes"
        )));
    }
    let columns = [cross(y, z), y, z];
    let rotation = std::array::from_fn(|i| columns.map(|column| column[i]));
    Ok(Pose { rotation, ..Pose::IDENTITY })
}

fn wrong(fault: String) -> Error {
    Error::Document { at: DOCUMENT.to_owned(), fault }
}

#[cfg(test)]
mod tests;
