//! Looks for the board in frames of all cameras, and finds the times in which it rests.

use bendtwin_capture::raw::{Frames, Recording};
use bendtwin_core::CancelToken;
use rayon::prelude::*;

use super::{
    corners::Gray,
    label::{Parts, Seen, Sighting},
    layout::Board,
};
use crate::{Error, error::check, statistics::median};

/// Frames that are looked at, evenly over the recording.
const FRAMES: usize = 48;
/// The same where that shows a camera no board: it may be in view for a moment.
const MORE_FRAMES: usize = 192;
/// Corners of a board that rests move by less than this from frame to frame, in the median [px].
const REST_PX: f64 = 0.7;

/// What all cameras saw of the board.
#[derive(Clone, Debug, Default)]
pub(crate) struct Views {
    /// Frames that were looked at, ascending.
    pub(crate) frames: Vec<usize>,
    /// The board in each, shape [frames][camera]; empty where it was not seen.
    pub(crate) sightings: Vec<Vec<Sighting>>,
}

/// A time during which the board stays where it is.
#[derive(Clone, Debug)]
pub(crate) struct Rest {
    /// Number of frames in it.
    pub(crate) frames: usize,
    /// The first of these frames.
    pub(crate) first: usize,
    /// Mean place of each corner and the number of images, by camera.
    pub(crate) seen: Vec<Vec<(Seen, f64)>>,
}

impl Views {
    /// Looks for the board. Progress is a share, 0..=1.
    pub(crate) fn look(
        recording: &Recording,
        board: &Board,
        observer: &mut dyn FnMut(f64),
        cancel: &CancelToken,
    ) -> Result<Self, Error> {
        let usable = recording.usable();
        let cameras = recording.cameras.len();
        let mut readers = Vec::with_capacity(cameras);
        for camera in 0..cameras {
            readers.push(usable.source.frames(camera)?);
        }
        let mut views = Self::default();
        for (most, from, to) in [(FRAMES, 0.0, 0.25), (MORE_FRAMES, 0.25, 1.0)] {
            let frames = spread(recording.frame_count, most);
            let new: Vec<usize> =
                frames.into_iter().filter(|frame| !views.frames.contains(frame)).collect();
            for (done, frame) in new.iter().enumerate() {
                check(cancel)?;
                observer(from + (to - from) * done as f64 / new.len() as f64);
                let sightings: Result<Vec<Sighting>, Error> = readers
                    .par_iter_mut()
                    .map(|reader| sighting(reader.as_mut(), *frame, board))
                    .collect();
                let at = views.frames.partition_point(|known| known < frame);
                views.frames.insert(at, *frame);
                views.sightings.insert(at, sightings?);
            }
            if (0..cameras).all(|camera| views.count(camera) > 1) {
                break;
            }
        }
        observer(1.0);
        Ok(views)
    }

    /// Number of frames in which a camera sees the board.
    pub(crate) fn count(&self, camera: usize) -> usize {
        self.sightings.iter().filter(|row| !row[camera].seen.is_empty()).count()
    }

    /// The times in which the board rests, each a run of frames without motion in any camera.
    pub(crate) fn rests(&self) -> Vec<Rest> {
        let cameras = self.sightings.first().map_or(0, Vec::len);
        let mut rests: Vec<Vec<usize>> = Vec::new();
        // The first sighting of each camera since the board rests.
        let mut reference: Vec<Option<usize>> = vec![None; cameras];
        for (row, sightings) in self.sightings.iter().enumerate() {
            if sightings.iter().all(|sighting| sighting.seen.is_empty()) {
                continue;
            }
            let motions = (0..cameras).filter_map(|camera| {
                let before = &self.sightings[reference[camera]?][camera];
                moved(&before.seen, &sightings[camera].seen)
            });
            let largest = motions.reduce(f64::max);
            if largest.is_none_or(|px| px > REST_PX) {
                reference = vec![None; cameras];
                rests.push(Vec::new());
            }
            for (camera, first) in reference.iter_mut().enumerate() {
                if first.is_none() && !sightings[camera].seen.is_empty() {
                    *first = Some(row);
                }
            }
            if let Some(rest) = rests.last_mut() {
                rest.push(row);
            }
        }
        rests.into_iter().map(|rows| self.rest(&rows, cameras)).collect()
    }

    fn rest(&self, rows: &[usize], cameras: usize) -> Rest {
        let seen = (0..cameras).map(|camera| {
            let mut sums: std::collections::BTreeMap<usize, ([f64; 2], f64)> = Default::default();
            for seen in rows.iter().flat_map(|row| &self.sightings[*row][camera].seen) {
                let (sum, count) = sums.entry(seen.corner).or_default();
                *sum = [sum[0] + seen.at[0], sum[1] + seen.at[1]];
                *count += 1.0;
            }
            let mean = |(corner, (sum, count)): (usize, ([f64; 2], f64))| {
                (Seen { corner, at: sum.map(|x| x / count) }, count)
            };
            sums.into_iter().map(mean).collect()
        });
        let first = rows.first().map_or(0, |row| self.frames[*row]);
        Rest { frames: rows.len(), first, seen: seen.collect() }
    }
}

/// At most `most` frames, evenly, with the first and the last.
pub(crate) fn spread(count: usize, most: usize) -> Vec<usize> {
    if count <= most {
        return (0..count).collect();
    }
    (0..most).map(|k| k * (count - 1) / (most - 1)).collect()
}

fn sighting(reader: &mut dyn Frames, frame: usize, board: &Board) -> Result<Sighting, Error> {
    let Some(color) = reader.color(frame)? else { return Ok(Sighting::default()) };
    Parts::of(Gray::of(&color)).map(|parts| parts.find(board))
}

/// Median distance between where two frames show the same corners [px]; `None` if they share none.
fn moved(before: &[Seen], after: &[Seen]) -> Option<f64> {
    let distances = after.iter().filter_map(|seen| {
        let index = before.binary_search_by_key(&seen.corner, |b| b.corner).ok()?;
        let other = before[index].at;
        Some((seen.at[0] - other[0]).hypot(seen.at[1] - other[1]))
    });
    median(distances)
}
