//! The steps of a pass: mini-batches of sequences, each in windows of frames.

use bendtwin_core::settings::GradientWindow;
use rand::{SeedableRng, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;

use super::windows::Window;
use crate::task::Task;

/// Stream of random numbers for the order of sequences, separate from the search's.
const STREAM: u64 = 1 << 63;

/// A step of Adam.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Step {
    /// Windows whose gradients it follows.
    pub(crate) windows: Vec<Window>,
    /// True if another window of the same sequences follows, from the final states of this one.
    pub(crate) has_next: bool,
}

/// True if a pass is a single step along the gradient of the whole loss.
pub(crate) fn is_single_step(task: &Task<'_>) -> bool {
    steps(task, 0).len() == 1
}

/// The steps of a pass. Sequences are assigned to mini-batches again in every pass, by seed and
/// pass.
pub(crate) fn steps(task: &Task<'_>, pass: u32) -> Vec<Step> {
    let refine = &task.settings.refine;
    let mut order: Vec<usize> = (0..task.training.len()).collect();
    let size = match refine.batch {
        None | Some(0) => order.len(),
        Some(size) => size,
    };
    if size < order.len() {
        let mut rng = ChaCha8Rng::seed_from_u64(task.settings.seed);
        rng.set_stream(STREAM | u64::from(pass));
        order.shuffle(&mut rng);
    }
    let mut steps = Vec::new();
    for group in order.chunks(size.max(1)) {
        let longest = group.iter().map(|&s| task.training[s].frames).max().unwrap_or(0);
        let length = match refine.window {
            GradientWindow::Frame => 1,
            GradientWindow::Frames(n) => (n as usize).max(1),
            GradientWindow::Pass => longest.max(1),
        };
        for first in (0..longest).step_by(length) {
            let window = |&sequence: &usize| {
                let left = task.training[sequence].frames.checked_sub(first).filter(|&n| n > 0)?;
                Some(Window { sequence, first, count: left.min(length) })
            };
            let windows = group.iter().filter_map(window).collect();
            steps.push(Step { windows, has_next: first + length < longest });
        }
    }
    steps
}
