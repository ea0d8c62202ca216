//! Instances of several graphs backward: their kernels differ and no single one fills the device,
//! so they run side by side, frame by frame.

use std::slice;

use bendtwin_engine::Error;

use super::{
    Backward,
    arrays::{Sizes, WindowArrays},
    windows::{ConcurrentWindows, Window},
};
use crate::device::{memory::Buffer, queue::Queue, throttle::LaunchThrottle};

/// A graph's windows, the arrays that some of them have at a time, and the sums of its instances.
struct Part<'a> {
    backward: &'a Backward<'a>,
    windows: Vec<Window>,
    arrays: WindowArrays,
    total: Buffer<f32>,
}

/// Takes the instances of graphs backward, with `room` bytes for windows: side by side where the
/// forward pass wrote all tapes and all windows fit together, else graph by graph.
pub(super) fn run(graphs: &[Backward<'_>], room: u64) -> Result<(), Error> {
    let share = room / graphs.len().max(1) as u64;
    let fits =
        |g: &Backward<'_>| g.forward.tapes.is_some() && Sizes::new(g, share).windows >= g.shape().0;
    if graphs.iter().all(fits) {
        side_by_side(graphs, share)
    } else {
        graphs.iter().try_for_each(|graph| side_by_side(slice::from_ref(graph), room))
    }
}

/// Takes graphs backward together, with `room` bytes for the windows of each.
fn side_by_side(graphs: &[Backward<'_>], room: u64) -> Result<(), Error> {
    let part = |backward| Part::new(backward, room);
    let parts = graphs.iter().map(part).collect::<Result<Vec<_>, Error>>()?;
    for turn in 0.. {
        let count: usize = parts.iter().map(|part| part.in_turn(turn).len()).sum();
        let windows = parts.iter().filter_map(|part| part.some_windows(turn, count));
        let mut windows = windows.collect::<Result<Vec<_>, Error>>()?;
        if windows.is_empty() {
            break;
        }
        frames_back(&mut windows)?;
    }
    parts.iter().try_for_each(|part| part.backward.finish_all(&part.total))
}

impl<'a> Part<'a> {
    fn new(backward: &'a Backward<'a>, room: u64) -> Result<Self, Error> {
        let stream = &backward.forward.simulation.queue.stream;
        Ok(Self {
            windows: backward.all_windows().collect(),
            arrays: WindowArrays::new(backward, &Sizes::new(backward, room))?,
            total: Buffer::zeros(stream, backward.stride() * backward.members.len())?,
            backward,
        })
    }

    /// The windows that have the arrays in a turn; none after the last.
    fn in_turn(&self, turn: usize) -> &[Window] {
        self.windows.chunks(self.arrays.windows).nth(turn).unwrap_or_default()
    }

    /// Windows ready to run backward; `count` is their number with those of other graphs.
    fn some_windows(
        &self,
        turn: usize,
        count: usize,
    ) -> Option<Result<ConcurrentWindows<'_>, Error>> {
        let (own, arrays) = (self.in_turn(turn), &self.arrays);
        let others = count - own.len();
        let ready = || ConcurrentWindows::new(self.backward, own, others, arrays, &self.total);
        (!own.is_empty()).then(ready)
    }
}

/// Takes all windows back to their starts, and adds their sums to those of their instances.
fn frames_back(graphs: &mut [ConcurrentWindows<'_>]) -> Result<(), Error> {
    let Some(first) = graphs.first() else { return Ok(()) };
    let (queue, cancel) = (first.queue(), first.cancel());
    let deepest = graphs.iter().map(ConcurrentWindows::deepest).max().unwrap_or(0);
    // Where nothing moves, what is wanted at the start is wanted of the start.
    graphs.iter().try_for_each(|graph| graph.store_initials(0))?;
    let mut throttle = LaunchThrottle::default();
    for depth in 0..deepest {
        if cancel.is_cancelled() {
            queue.synchronize()?;
            return Err(Error::Cancelled);
        }
        let mut reaching: Vec<_> = graphs.iter_mut().filter(|g| depth < g.deepest()).collect();
        reaching.iter_mut().try_for_each(|graph| graph.make_ready(depth))?;
        frame_back(queue, &reaching, depth)?;
        reaching.iter().try_for_each(|graph| graph.store_initials(depth + 1))?;
        throttle.launched(queue, reaching.iter().map(|graph| graph.frame_us()).sum())?;
    }
    graphs.iter().try_for_each(ConcurrentWindows::add_sums)
}

/// A frame of each window that reaches so deep.
fn frame_back(
    queue: &Queue,
    graphs: &[&mut ConcurrentWindows<'_>],
    depth: usize,
) -> Result<(), Error> {
    graphs.iter().try_for_each(|graph| graph.seed(depth))?;
    let segments = graphs.iter().map(|graph| graph.segment_count()).max().unwrap_or(0);
    for nth_last in 0..segments {
        let mut kernels = Vec::new();
        for graph in graphs.iter().filter(|graph| nth_last < graph.segment_count()) {
            let taped = graph.on_tape(depth, nth_last)?;
            kernels.extend(graph.frames(depth).map(|(group, span)| (group, span, taped.clone())));
        }
        queue.launch_concurrently(kernels.len(), |k, streams| {
            let (group, span, taped) = &kernels[k];
            group.back(queue, streams.of(k, &group.plan.team), *span, taped)
        })?;
    }
    graphs.iter().try_for_each(|graph| graph.collect(depth))
}
