//! Assignment of images to cameras and frames: nerfstudio's list does not give it by itself.

use std::collections::BTreeMap;

use super::{
    document::{Document, FrameEntry, Label},
    wrong,
};
use crate::{Error, Limits, files::at_most, raw::clock};

/// The frames of one camera.
pub(super) struct Group<'a> {
    pub(super) name: String,
    /// Shape [T].
    pub(super) frames: Vec<Option<&'a FrameEntry>>,
    /// Shape [T], NaN where missing; empty if the list has no times.
    pub(super) times_s: Vec<f64>,
}

/// All cameras on common frames.
pub(super) struct Groups<'a> {
    pub(super) fps: f64,
    pub(super) frame_count: usize,
    pub(super) cameras: Vec<Group<'a>>,
    /// Form of the frames' times in words.
    pub(super) timed: &'static str,
}

/// Times that run from 0 to 1, as nerfstudio's scenes with motion have them, deviate by this at most.
const NORMALISED: f64 = 1e-6;

/// Relative difference between `fps` and the rate of `time` that rounding explains: 29.97 and 30.
const SAME_RATE: f64 = 0.03;

/// Sorts the list by camera (`camera_label`, else the image's folder) and frame (`frame_index`,
/// else `time`, else the number that ends the image's name).
pub(super) fn group<'a>(document: &'a Document, limits: &Limits) -> Result<Groups<'a>, Error> {
    let entries = &document.frames;
    let mut by_camera: BTreeMap<String, Vec<&FrameEntry>> = BTreeMap::new();
    for entry in entries {
        let name = match &entry.camera_label {
            Some(Label::Text(label)) => label.clone(),
            Some(Label::Number(label)) => label.to_string(),
            None => entry.file_path.rsplit_once('/').map_or("", |(folder, _)| folder).to_owned(),
        };
        by_camera.entry(name).or_default().push(entry);
        at_most("cameras", by_camera.len(), limits.cameras)?;
    }
    let all = |has: fn(&FrameEntry) -> bool| !entries.is_empty() && entries.iter().all(has);
    let labelled = all(|e| e.camera_label.is_some());
    let timed = all(|e| e.time.is_some());
    if all(|e| e.frame_index.is_some()) {
        return by_index(document, by_camera, limits, |e| e.frame_index, timed);
    }
    if timed {
        return by_time(document, by_camera, limits);
    }
    if by_camera.len() < 2 && !labelled {
        return Err(wrong(
            "its images lie in one folder and say neither which camera took them nor when, as photographs of a thing at rest \
             do: give every frame `camera_label` and `frame_index` (or `time` in seconds), or put the images of each camera \
             into a separate folder with the frame's number as their name"
                .into(),
        ));
    }
    by_index(document, by_camera, limits, |e| last_number(&e.file_path), false)
}

fn by_index<'a>(
    document: &Document,
    by_camera: BTreeMap<String, Vec<&'a FrameEntry>>,
    limits: &Limits,
    index: fn(&FrameEntry) -> Option<usize>,
    timed: bool,
) -> Result<Groups<'a>, Error> {
    let fps = document.fps.ok_or_else(|| {
        wrong(
            "it has no `fps`: add the frames per second, or `time` in seconds to every frame"
                .into(),
        )
    })?;
    let (mut first, mut last) = (usize::MAX, 0);
    let mut numbered = Vec::with_capacity(by_camera.len());
    for (name, entries) in by_camera {
        let mut indices = Vec::with_capacity(entries.len());
        for entry in entries {
            let index = index(entry).ok_or_else(|| {
                wrong(format!("`{}` has no number in its name: add `frame_index`", entry.file_path))
            })?;
            first = first.min(index);
            last = last.max(index);
            indices.push((index, entry));
        }
        numbered.push((name, indices));
    }
    let frame_count = if numbered.is_empty() { 0 } else { (last - first).saturating_add(1) };
    at_most("frames of a recording", frame_count, limits.recording_frames)?;
    let mut cameras = Vec::with_capacity(numbered.len());
    for (name, indices) in numbered {
        let mut frames: Vec<Option<&FrameEntry>> = vec![None; frame_count];
        for (index, entry) in indices {
            let Some(place) = frames.get_mut(index - first) else { continue };
            if let Some(other) = place.replace(entry) {
                return Err(wrong(format!(
                    "`{}` and `{}` are both frame {index} of camera `{name}`",
                    other.file_path, entry.file_path
                )));
            }
        }
        let times_s = if timed { times(&frames, 1.0) } else { Vec::new() };
        cameras.push(Group { name, frames, times_s });
    }
    let mut groups = Groups { fps, frame_count, cameras, timed: "by the frames' numbers" };
    if timed && is_normalised(&document.frames) {
        // No seconds, and the numbers say all that they do.
        groups.cameras.iter_mut().for_each(|camera| camera.times_s.clear());
        groups.timed = NORMALISED_TIMES;
    }
    Ok(groups)
}

const NORMALISED_TIMES: &str = "`time` from 0 to 1 is no seconds, `fps` counts";

/// `true` if times are shares of the recording, and no seconds.
fn is_normalised(entries: &[FrameEntry]) -> bool {
    let times = || entries.iter().filter_map(|entry| entry.time);
    let low = times().fold(f64::INFINITY, f64::min);
    let high = times().fold(f64::NEG_INFINITY, f64::max);
    low.abs() <= NORMALISED && (high - 1.0).abs() <= NORMALISED
}

fn by_time<'a>(
    document: &Document,
    by_camera: BTreeMap<String, Vec<&'a FrameEntry>>,
    limits: &Limits,
) -> Result<Groups<'a>, Error> {
    let time = |entry: &FrameEntry| entry.time.unwrap_or(f64::NAN);
    let mut sorted: Vec<(String, Vec<&FrameEntry>)> = by_camera.into_iter().collect();
    for (_, entries) in &mut sorted {
        if let Some(entry) = entries.iter().find(|entry| !time(entry).is_finite()) {
            return Err(wrong(format!("the time of `{}` is not finite", entry.file_path)));
        }
        entries.sort_by(|a, b| time(a).total_cmp(&time(b)));
    }
    let clocks: Vec<Vec<f64>> =
        sorted.iter().map(|(_, entries)| entries.iter().map(|e| time(e)).collect()).collect();
    let aligned = clock::align(&clocks, limits.recording_frames)?;
    let (seconds, timed) = seconds_of_time(document, aligned.fps)?;
    let cameras = sorted.into_iter().zip(&aligned.images).map(|((name, entries), images)| {
        let frames: Vec<_> =
            images.iter().map(|image| image.and_then(|i| entries.get(i).copied())).collect();
        Group { name, times_s: times(&frames, seconds), frames }
    });
    Ok(Groups {
        fps: aligned.fps / seconds,
        frame_count: aligned.times_s.len(),
        cameras: cameras.collect(),
        timed,
    })
}

/// Seconds of each 1 of `time`, and the times' form in words; `rate` are the frames in each 1.
///
/// # Errors
/// If `time` and `fps` contradict each other, or shares of the recording have no `fps`.
fn seconds_of_time(document: &Document, rate: f64) -> Result<(f64, &'static str), Error> {
    let is_normalised = is_normalised(&document.frames);
    match document.fps {
        Some(fps) if (rate / fps - 1.0).abs() <= SAME_RATE => Ok((1.0, "by `time` in seconds")),
        Some(fps) if is_normalised && fps.is_finite() && fps > 0.0 => Ok((rate / fps, NORMALISED_TIMES)),
        Some(fps) => Err(wrong(format!(
            "`fps` is {fps}, but by the `time` of its frames there are {rate:.2} in a second: correct one of them \
             (docs/use/cameras.md#time)"
        ))),
        None if is_normalised => Err(wrong(
            "`time` runs from 0 to 1, as shares of a recording do and seconds hardly: add `fps`, the frames per second \
             (docs/use/cameras.md#time)"
                .into(),
        )),
        None => Ok((1.0, "by `time` in seconds")),
    }
}

fn times(frames: &[Option<&FrameEntry>], seconds: f64) -> Vec<f64> {
    let time = |frame: &Option<&FrameEntry>| Some((*frame)?.time? * seconds);
    frames.iter().map(|frame| time(frame).unwrap_or(f64::NAN)).collect()
}

/// The number at the end of a file's name: 12 of `left/frame_00012.png`.
fn last_number(path: &str) -> Option<usize> {
    let name = path.rsplit('/').next()?;
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    let digits = stem.bytes().rev().take_while(u8::is_ascii_digit).count();
    stem.get(stem.len() - digits..)?.parse().ok()
}
