//! Frames of a raw PhysTwin case: by the numbers of its images, by the rates and offsets of its cameras, or
//! by the times of images that PhysTwin's alignment has not been run on.

use std::{collections::BTreeMap, ops::Range, sync::Arc};

use bendtwin_core::{Finding, Point};

use super::{MARKER, metadata::Metadata};
use crate::{
    Error, Limits,
    raw::{
        Camera, Recording, Source,
        clock::{
            self,
            retimed::{self, Clock, Retimed},
        },
        numbering::{self, Images, Numbering},
        validity,
    },
};

/// Images and frames of a case.
pub(super) struct Timing {
    pub(super) fps: f64,
    /// Numbers of all images, as if they were frames.
    pub(super) numbering: Numbering,
    /// Remarks about numbers and times.
    pub(super) notes: Vec<Finding>,
    /// Images by frames, if these are not the same.
    order: Option<Order>,
}

struct Order {
    /// Indices of images by the frames of the recording, shape [camera][T].
    images: retimed::Images,
    /// Frames that images are counted in, in which clean tracks and the split are given.
    frames: Range<usize>,
    /// Rates of the cameras.
    rates: Vec<f64>,
    /// Times of images by their indices [s], shape [camera]; empty without times.
    times: Vec<BTreeMap<usize, f64>>,
}

impl Timing {
    pub(super) fn of(
        metadata: &Metadata,
        images: &[[Images; 2]],
        limits: &Limits,
    ) -> Result<Self, Error> {
        let all: Vec<&Images> = images.iter().flatten().collect();
        if let Some(times) = metadata.times() {
            return Self::by_times(metadata, &all, &times, limits);
        }
        let rates = metadata.rates()?;
        let at = format!("`frame_num` of {MARKER}");
        if let Some(count) = metadata.frame_num {
            numbering::expect_all(&all, &at, count)?;
        }
        let declared = metadata.frame_num.map(|count| (at.as_str(), count));
        let clocks = metadata.clocks()?;
        // Cameras of different rates have different numbers.
        let numbering = if clocks.is_some() {
            numbering::span(&all, limits)?
        } else {
            numbering::align(&all, declared, limits)?
        };
        validity::count(1, numbering.frame_count, limits)?;
        let mut notes: Vec<Finding> = numbering.note().into_iter().collect();
        let Some((fps, clocks)) = clocks else {
            let fps = rates.first().copied().unwrap_or(f64::NAN);
            return Ok(Self { fps, numbering, notes, order: None });
        };
        let order = Order::by_clocks(&clocks, rates, images, numbering, limits)?;
        notes.extend(order.note(numbering.frame_count));
        Ok(Self { fps, numbering, notes, order: Some(order) })
    }

    /// Images of cameras with a clock, each with its own numbers.
    fn by_times(
        metadata: &Metadata,
        all: &[&Images],
        times: &[BTreeMap<u64, f64>],
        limits: &Limits,
    ) -> Result<Self, Error> {
        let numbering = numbering::span(all, limits)?;
        let first =
            times.iter().flat_map(|times| times.values()).copied().fold(f64::INFINITY, f64::min);
        let mut clocks = Vec::with_capacity(times.len());
        for (times, images) in times.iter().zip(all.chunks(2)) {
            let there = times.iter().filter(|(number, _)| images.iter().any(|i| i.has(**number)));
            let index = |number: u64| usize::try_from(number - numbering.first).ok();
            let known = there.filter_map(|(number, time)| Some((time - first, index(*number)?)));
            let mut known: Vec<(f64, usize)> = known.collect();
            known.sort_by(|a, b| a.0.total_cmp(&b.0));
            clocks.push(known);
        }
        let seconds: Vec<Vec<f64>> =
            clocks.iter().map(|clock| clock.iter().map(|(time, _)| *time).collect()).collect();
        let aligned = clock::align(&seconds, limits.recording_frames)?;
        let by_frame = aligned.images.iter().zip(&clocks);
        let by_frame = by_frame.map(|(images, clock)| {
            images.iter().map(|image| Some(clock.get((*image)?)?.1)).collect()
        });
        let images: retimed::Images = by_frame.collect();
        let frames = retimed::shared(&images)?;
        let rates = metadata.rates()?;
        let fps = rates.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let message = format!(
            "images were assigned to frames by the times in `recording` of {MARKER}, as PhysTwin's record_data_align.py \
             does; {} frames are those of all cameras",
            frames.len()
        );
        let times =
            clocks.into_iter().map(|clock| clock.into_iter().map(|(t, i)| (i, t)).collect());
        let order = Order { images: cut(images, &frames), frames, rates, times: times.collect() };
        let notes = vec![Finding::info("FRAMES_BY_TIME", message)];
        Ok(Self { fps, numbering, notes, order: Some(order) })
    }

    /// Brings a recording, whose frames are the numbers of images, onto its frames. With a split its frame
    /// stays where it is; otherwise the share of frames for fitting does.
    pub(super) fn apply(
        self,
        recording: &mut Recording,
        cameras: &mut [Camera],
        has_split: bool,
        limits: &Limits,
    ) -> Result<(), Error> {
        let Some(Order { images, frames, rates, times }) = self.order else { return Ok(()) };
        let points = recording.truth_tracks.len() / recording.frame_count.max(1);
        if points > 0 {
            let bytes = (frames.len() as u64).saturating_mul(points as u64);
            let bytes = bytes.saturating_mul(size_of::<Point>() as u64);
            let limit = limits.total_bytes;
            if bytes > limit {
                return Err(Error::TooLarge { what: "clean tracks".to_owned(), bytes, limit });
            }
            let tracks = &recording.truth_tracks;
            recording.truth_tracks = rows(tracks, points, &frames, [f32::NAN; 3]);
        }
        for gripper in &mut recording.grippers {
            gripper.poses = rows(&gripper.poses, 1, &frames, None);
            if !gripper.widths_m.is_empty() {
                gripper.widths_m = rows(&gripper.widths_m, 1, &frames, f64::NAN);
            }
        }
        recording.train_frame_count = if has_split {
            recording.train_frame_count.saturating_sub(frames.start).min(frames.len())
        } else {
            let share = recording.train_frame_count as f64 / recording.frame_count.max(1) as f64;
            (share * frames.len() as f64).round() as usize
        };
        recording.frame_count = frames.len();
        for (index, camera) in cameras.iter_mut().enumerate() {
            camera.fps = rates.get(index).copied().filter(|rate| *rate != recording.fps);
            if let (Some(times), Some(images)) = (times.get(index), images.get(index)) {
                let time =
                    |image: &Option<usize>| image.and_then(|image| times.get(&image).copied());
                camera.times_s =
                    images.iter().map(|image| time(image).unwrap_or(f64::NAN)).collect();
            }
        }
        let source: Arc<dyn Source> = recording.source.clone();
        recording.source = Arc::new(Retimed::new(source, images, limits)?);
        Ok(())
    }
}

impl Order {
    fn by_clocks(
        clocks: &[Clock],
        rates: Vec<f64>,
        images: &[[Images; 2]],
        numbering: Numbering,
        limits: &Limits,
    ) -> Result<Self, Error> {
        let spans: Vec<Range<usize>> = images
            .iter()
            .map(|[color, _]| color.span(numbering).unwrap_or(0..numbering.frame_count))
            .collect();
        let ends = clocks.iter().zip(&spans);
        let ends = ends.map(|(clock, span)| end(*clock, span, limits.recording_frames));
        let frame_count = ends.max().unwrap_or(0);
        let mut by_frame: retimed::Images = Vec::with_capacity(clocks.len());
        for (clock, span) in clocks.iter().zip(&spans) {
            let mut of = clock.by_frame(numbering.frame_count, frame_count);
            // An image that is missing is a gap, but numbers beyond the last are none.
            of.iter_mut().for_each(|image| *image = image.filter(|image| span.contains(image)));
            by_frame.push(of);
        }
        let frames = retimed::shared(&by_frame)?;
        Ok(Self { images: cut(by_frame, &frames), frames, rates, times: Vec::new() })
    }

    fn note(&self, all: usize) -> Option<Finding> {
        let Range { start, end } = self.frames;
        if self.frames == (0..all) {
            return None;
        }
        let message = format!(
            "by the cameras' rates and offsets the frames that all of them have are {start} to {}; the first of these is \
             frame 0 of the recording",
            end.saturating_sub(1)
        );
        Some(Finding::info("FRAMES_SHARED", message))
    }
}

/// The frame after that of a camera's last image, at most `most`.
fn end(clock: Clock, images: &Range<usize>, most: usize) -> usize {
    let after = clock.frame(images.end.saturating_sub(1)).saturating_add(1);
    usize::try_from(after).unwrap_or(0).min(most)
}

/// The values of some frames, `width` for each; `unknown` where there are none.
fn rows<T: Clone>(all: &[T], width: usize, frames: &Range<usize>, unknown: T) -> Vec<T> {
    let end = frames.end.saturating_mul(width).min(all.len());
    let start = frames.start.saturating_mul(width).min(end);
    let mut rows = all.get(start..end).unwrap_or_default().to_vec();
    rows.resize(frames.len().saturating_mul(width), unknown);
    rows
}

/// The images of some frames.
fn cut(images: retimed::Images, frames: &Range<usize>) -> retimed::Images {
    let of = |of: Vec<Option<usize>>| of.get(frames.clone()).unwrap_or_default().to_vec();
    images.into_iter().map(of).collect()
}
