//! Predicted motion of a twin's nodes.

use bendtwin_core::Point;

/// Positions of nodes over the frames of a sequence. N is the number of nodes.
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a> {
    /// Frame of the sequence in which it starts.
    pub start_frame: usize,
    /// Number of nodes N.
    pub node_count: usize,
    /// Positions [m], shape [frames, N, 3]; row 0 belongs to `start_frame`.
    pub positions: &'a [Point],
    /// Frames before this one are for training.
    pub train_frame_count: usize,
}

impl<'a> Motion<'a> {
    /// Positions in a frame, shape [N, 3]; none before the start and after the end.
    pub fn at(&self, frame: usize) -> Option<&'a [Point]> {
        let first = frame.checked_sub(self.start_frame)?.checked_mul(self.node_count)?;
        self.positions.get(first..first.checked_add(self.node_count)?)
    }

    /// The frames that it has.
    pub fn frames(&self) -> std::ops::Range<usize> {
        let rows = self.positions.len().checked_div(self.node_count).unwrap_or_default();
        self.start_frame..self.start_frame + rows
    }

    /// Training frames from the first, at most `most` (0: all).
    pub fn training_frames(&self, most: usize) -> std::ops::Range<usize> {
        let frames = self.frames();
        let most = if most == 0 { usize::MAX } else { frames.start.saturating_add(most) };
        frames.start..frames.end.min(self.train_frame_count).min(most)
    }
}
