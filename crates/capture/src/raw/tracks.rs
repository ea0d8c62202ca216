//! 2D tracks from the arrays of a tracker. Trackers agree neither on the order of a position's numbers
//! nor on that of the axes: PhysTwin keeps row, column, CoTracker and TAPIR give x, y, and TAP-Vid
//! scales both to 0..1.

use std::ops::Range;

use super::{Mask, Tracks, decode::Size};
use crate::{
    Error, Limits,
    array::Array,
    files::{Files, at_most},
    limits::Budget,
    npy,
};

/// Names of the array of positions in an .npz file.
const POINTS: &[&str] = &["tracks", "pred_tracks", "points", "trajectories"];
/// Names of the array that says where a point is visible.
const VISIBLE: &[&str] = &["visibility", "pred_visibility", "visible", "visibles", "visibilities"];
/// Names of the array that says where it is hidden.
const HIDDEN: &[&str] = &["occluded", "pred_occluded", "occlusion", "occlusions"];

/// Positions that are all below this are shares of the image's size.
const MAX_SCALED: f32 = 1.0 + 1e-3;

/// Probability from which a point counts as visible, where flags are numbers.
const PROBABLE: f32 = 0.5;

/// Bytes of a track in a frame.
pub(super) const BYTES: u64 = 9;

/// Order of a position's two numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    /// Column, row, in pixels.
    Xy,
    /// The one by which more points lie inside the masks in frame 0; row, column if both do.
    Detected,
}

/// What tracks belong to.
pub(super) struct Subject<'a> {
    /// Number of frames T.
    pub(super) frame_count: usize,
    /// Frames of the camera's own images: tracks may have a row for each of these alone.
    pub(super) span: Range<usize>,
    /// Size of the images.
    pub(super) size: Size,
    /// Object and manipulator in frame 0.
    pub(super) mask: Option<&'a Mask>,
    pub(super) order: Order,
}

/// Arrays of tracks.
struct Arrays<'a> {
    points: Array<'a>,
    /// Visible, or hidden, points.
    flags: Option<(Array<'a>, bool)>,
}

/// Axes of the arrays, without leading and trailing axes of length 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Layout {
    rows: usize,
    count: usize,
    /// The tracks come first and the frames second.
    by_track: bool,
}

/// Tracks of an .npz file, and their form in words.
pub(super) fn read_npz(
    at: &str,
    bytes: &[u8],
    subject: &Subject<'_>,
    limits: &Limits,
    budget: &mut Budget,
) -> Result<(Tracks, String), Error> {
    let mut inner = Files::from_bytes(at, bytes, limits)?;
    let mut first = |names: &[&'static str]| -> Result<Option<(&'static str, Vec<u8>)>, Error> {
        for name in names {
            if let Some(bytes) = inner.find(&format!("{name}.npy"))? {
                return Ok(Some((name, bytes)));
            }
        }
        Ok(None)
    };
    let missing = |array: &str| Error::MissingArray { at: at.to_owned(), array: array.to_owned() };
    let (points_name, points) = first(POINTS)?.ok_or_else(|| missing(POINTS[0]))?;
    let visible = first(VISIBLE)?.map(|(name, bytes)| (name, bytes, false));
    let hidden = first(HIDDEN)?.map(|(name, bytes)| (name, bytes, true));
    let Some((flags_name, flags, is_hidden)) = visible.or(hidden) else {
        return Err(missing(&format!("{} (or {})", VISIBLE[0], HIDDEN[0])));
    };
    let arrays = Arrays {
        points: npy::read(&format!("{at}: {points_name}"), &points)?,
        flags: Some((npy::read(&format!("{at}: {flags_name}"), &flags)?, is_hidden)),
    };
    let (tracks, form) = arrays.join(subject, limits.points, budget)?;
    Ok((tracks, format!("`{points_name}` {form}, `{flags_name}`")))
}

/// Tracks of two .npy arrays, and their form in words.
pub(super) fn join(
    points: Array<'_>,
    visible: Option<Array<'_>>,
    subject: &Subject<'_>,
    limit: usize,
    budget: &mut Budget,
) -> Result<(Tracks, String), Error> {
    Arrays { points, flags: visible.map(|v| (v, false)) }.join(subject, limit, budget)
}

impl Arrays<'_> {
    fn join(
        self,
        subject: &Subject<'_>,
        limit: usize,
        budget: &mut Budget,
    ) -> Result<(Tracks, String), Error> {
        let layout = Layout::of(&self.points, subject)?;
        at_most("tracks of a camera", layout.count, limit)?;
        let flat = self.points.floats(budget)?;
        budget.take(2 * flat.len() as u64 * 4, &self.points.at)?;
        // A row for each frame takes more where the file has only those of some.
        let all = (subject.frame_count as u64).saturating_mul(layout.count as u64);
        budget.take(all.saturating_mul(BYTES), &self.points.at)?;
        let pairs = layout.by_frame(flat.as_chunks::<2>().0);
        let mut visible = match self.flags {
            None => vec![true; pairs.len()],
            Some((flags, is_hidden)) => {
                let flags = layout.flags(&flags, budget)?;
                flags.into_iter().map(|flag| flag != is_hidden).collect()
            }
        };
        for (seen, p) in visible.iter_mut().zip(&pairs) {
            *seen &= p.iter().all(|x| x.is_finite());
        }
        let shown = pairs.iter().zip(&visible).filter(|(_, seen)| **seen);
        let is_scaled = subject.order == Order::Detected
            && shown.clone().count() > 0
            && shown.clone().all(|(p, _)| p.iter().all(|x| (0.0..=MAX_SCALED).contains(x)));
        let place = Place { size: subject.size, is_scaled };
        let first = pairs.iter().zip(&visible).take(layout.count).filter(|(_, seen)| **seen);
        let first: Vec<[f32; 2]> = first.map(|(p, _)| *p).collect();
        let is_xy = subject.order == Order::Xy
            || place.score(&first, true, subject.mask) > place.score(&first, false, subject.mask);
        let points = pairs.iter().map(|p| place.pixel(*p, is_xy)).collect();
        let form = format!(
            "{} as {}{}",
            if layout.by_track { "[N, T, 2]" } else { "[T, N, 2]" },
            if is_xy { "x, y" } else { "row, column" },
            if is_scaled { ", shares of the image's size" } else { "" },
        );
        let tracks = Tracks { count: layout.count, points, visible };
        Ok((spread(tracks, layout.rows, subject), form))
    }
}

impl Layout {
    fn of(points: &Array<'_>, subject: &Subject<'_>) -> Result<Self, Error> {
        let is_row = |n: usize| n == subject.frame_count || n == subject.span.len();
        let shape = points.shape.strip_prefix(&[1]).filter(|rest| rest.len() == 3);
        match *shape.unwrap_or(&points.shape) {
            [rows, count, 2] if is_row(rows) => Ok(Self { rows, count, by_track: false }),
            [count, rows, 2] if is_row(rows) && subject.order == Order::Detected => {
                Ok(Self { rows, count, by_track: true })
            }
            _ => Err(points.wrong_shape(&format!("[{}, N, 2]", subject.frame_count))),
        }
    }

    /// Elements frame by frame.
    fn by_frame<T: Copy>(self, elements: &[T]) -> Vec<T> {
        if !self.by_track {
            return elements.to_vec();
        }
        let at = |frame: usize| elements.iter().skip(frame).step_by(self.rows).copied();
        (0..self.rows).flat_map(at).collect()
    }

    fn flags(self, flags: &Array<'_>, budget: &mut Budget) -> Result<Vec<bool>, Error> {
        let wanted = if self.by_track { [self.count, self.rows] } else { [self.rows, self.count] };
        let mut shape = flags.shape.as_slice();
        while let [1, rest @ ..] | [rest @ .., 1] = shape
            && rest.len() >= 2
        {
            shape = rest;
        }
        if shape != wanted {
            let [a, b] = wanted;
            return Err(flags.wrong_shape(&format!("[{a}, {b}] as the positions")));
        }
        let truths = if flags.is_float() {
            flags.floats(budget)?.into_iter().map(|p| p > PROBABLE).collect()
        } else {
            flags.bools(budget)?
        };
        Ok(self.by_frame(&truths))
    }
}

/// From stored positions to pixels.
#[derive(Clone, Copy)]
struct Place {
    size: Size,
    is_scaled: bool,
}

impl Place {
    fn pixel(self, [a, b]: [f32; 2], is_xy: bool) -> [f32; 2] {
        let p = if is_xy { [a, b] } else { [b, a] };
        if !self.is_scaled {
            return p;
        }
        // Shares of the image count from its corner, pixels from the centre of the first.
        let [width, height] = self.size.map(|n| n as f32);
        [p[0] * width - 0.5, p[1] * height - 0.5]
    }

    /// Number of points inside the mask, less those outside the image.
    fn score(self, points: &[[f32; 2]], is_xy: bool, mask: Option<&Mask>) -> i64 {
        let [width, height] = self.size.map(|n| n as f32);
        let of = |p: &[f32; 2]| {
            let [x, y] = self.pixel(*p, is_xy).map(f32::round);
            if !(0.0..width).contains(&x) || !(0.0..height).contains(&y) {
                return -1;
            }
            i64::from(mask.and_then(|mask| mask.get(x as usize, y as usize)) == Some(true))
        };
        points.iter().map(of).sum()
    }
}

/// Tracks with a row for every frame, of tracks with a row for each of the camera's own images.
fn spread(tracks: Tracks, rows: usize, subject: &Subject<'_>) -> Tracks {
    let Tracks { count, mut points, mut visible } = tracks;
    if rows != subject.frame_count {
        let (before, all) = (subject.span.start * count, subject.frame_count * count);
        points.splice(0..0, std::iter::repeat_n([f32::NAN; 2], before));
        visible.splice(0..0, std::iter::repeat_n(false, before));
        points.resize(all, [f32::NAN; 2]);
        visible.resize(all, false);
    }
    Tracks { count, points, visible }
}
