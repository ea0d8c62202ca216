//! Which steps a pass makes: mini-batches of sequences, each in windows of frames.

use bendtwin_core::settings::GradientWindow;
use rand::{SeedableRng, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;

use super::windows::Window;
use crate::task::Task;

/// Keeps the order of sequences apart from the search's random numbers.
const STREAM: u64 = 1 << 63;

/// One step of Adam.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Step {
    /// What it sees.
    pub(crate) windows: Vec<Window>,
    /// Whether another window of the same sequences follows, from the state that this one ends in.
    pub(crate) goes_on: bool,
}

/// The steps of a pass. Sequences are dealt out to mini-batches anew in every pass, by seed and pass.
pub(crate) fn steps(task: &Task<'_>, pass: u32) -> Vec<Step> {
    let refine = &task.settings.refine;
    let mut order: Vec<usize> = (0..task.training.len()).collect();
    let size = if refine.batch == 0 { order.len() } else { refine.batch };
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
            steps.push(Step { windows, goes_on: first + length < longest });
        }
    }
    steps
}
