//! Frames that a part of a reply covers.

use std::ops::Range;

/// The frames after `from` up to `to`; the start belongs to the first span.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Span {
    pub(crate) from: usize,
    pub(crate) to: usize,
}

impl Span {
    /// All frames of a rollout.
    pub(crate) fn whole(frames: usize) -> Self {
        Self { from: 0, to: frames }
    }

    /// The spans of at most `length` frames that a rollout is divided into.
    pub(crate) fn of(frames: usize, length: usize) -> impl Iterator<Item = Self> {
        let length = length.max(1);
        let starts = (0..frames).step_by(length);
        starts.map(move |from| Self { from, to: from.saturating_add(length).min(frames) })
    }

    /// True if this frame, 1-based, is in it.
    pub(crate) fn has(self, frame: usize) -> bool {
        frame > self.from && frame <= self.to
    }

    /// Number of its frames.
    pub(crate) fn frames(self) -> usize {
        self.to - self.from
    }

    /// The frame boundaries that its arrays have rows for.
    pub(crate) fn rows(self) -> Range<usize> {
        let first = if self.from == 0 { 0 } else { self.from + 1 };
        first..self.to + 1
    }
}
