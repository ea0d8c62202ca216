//! Tracks of all cameras in space, over all frames.

use bendtwin_core::Point;

/// N tracks over T frames. Every track is seen in the first frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Tracks {
    /// Number of tracks N.
    pub(crate) count: usize,
    /// Number of frames T.
    pub(crate) frames: usize,
    /// Positions [m], shape [T, N]; any value where not seen.
    pub(crate) points: Vec<Point>,
    /// Shape [T, N].
    pub(crate) seen: Vec<bool>,
    /// Colours in the first frame, 0..=1, shape [N].
    pub(crate) colors: Vec<Point>,
}

impl Tracks {
    pub(crate) fn at(&self, frame: usize, track: usize) -> Point {
        self.points[frame * self.count + track]
    }

    pub(crate) fn is_seen(&self, frame: usize, track: usize) -> bool {
        self.seen[frame * self.count + track]
    }

    pub(crate) fn points_at(&self, frame: usize) -> &[Point] {
        &self.points[frame * self.count..(frame + 1) * self.count]
    }

    pub(crate) fn seen_at(&self, frame: usize) -> &[bool] {
        &self.seen[frame * self.count..(frame + 1) * self.count]
    }

    /// Number of frames in which each track is seen, shape [N].
    pub(crate) fn survival(&self) -> Vec<usize> {
        let mut counts = vec![0; self.count];
        for frame in 0..self.frames {
            counts.iter_mut().zip(self.seen_at(frame)).for_each(|(c, s)| *c += usize::from(*s));
        }
        counts
    }

    /// The tracks with these numbers, in this order.
    pub(crate) fn select(&self, which: &[usize]) -> Self {
        let frames = 0..self.frames;
        Self {
            count: which.len(),
            frames: self.frames,
            points: frames
                .clone()
                .flat_map(|f| which.iter().map(move |w| self.at(f, *w)))
                .collect(),
            seen: frames.flat_map(|f| which.iter().map(move |w| self.is_seen(f, *w))).collect(),
            colors: which.iter().filter_map(|w| self.colors.get(*w).copied()).collect(),
        }
    }

    /// Fills in positions where a track was not seen: on the line between the sightings around, or
    /// where it was seen last.
    pub(crate) fn fill_unseen(&mut self) {
        for track in 0..self.count {
            let mut last = 0;
            for frame in 1..self.frames {
                if !self.is_seen(frame, track) {
                    continue;
                }
                let (a, b) = (self.at(last, track), self.at(frame, track));
                for between in last + 1..frame {
                    let share = (between - last) as f32 / (frame - last) as f32;
                    self.points[between * self.count + track] =
                        std::array::from_fn(|i| a[i] + share * (b[i] - a[i]));
                }
                last = frame;
            }
            let end = self.at(last, track);
            for frame in last + 1..self.frames {
                self.points[frame * self.count + track] = end;
            }
        }
    }
}
