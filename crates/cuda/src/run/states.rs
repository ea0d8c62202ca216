//! States of instances that are wanted on the host. They lie far apart among those that a simulation
//! keeps, and a copy of each takes longer than to simulate a frame: a kernel gathers them, and one
//! copy brings many.

use bendtwin_engine::{Error, model::State, world::Grasping};
use bytemuck::Pod;

use crate::{
    device::{
        args::{self, GatherArgs, GatherPiece, Pointer},
        kernels,
        launch::MOST_BLOCKS,
        memory::Buffer,
        queue::Queue,
        specialization::THREADS,
    },
    run::{simulation::Simulation, world::decode_grasping},
};

/// Words of a copy, as far as it can be cut between states: 64 MiB on the device and on the host.
const GATHERED_WORDS: usize = 1 << 24;
/// Most blocks that share a piece.
const PIECE_BLOCKS: u32 = 64;

/// Arrays on the device, in the order in which the host takes them.
#[derive(Default)]
struct Pieces {
    all: Vec<GatherPiece>,
    words: usize,
}

impl Pieces {
    /// Adds `count` values; their size is a multiple of a word.
    fn add<T: Pod>(&mut self, from: Pointer<T>, count: usize) {
        let words = count * size_of::<T>() / size_of::<u32>();
        if words > 0 {
            let from = Pointer::new(from.address());
            self.all.push(GatherPiece { from, at: self.words as u64, count: words as u64 });
        }
        self.words += words;
    }

    /// Their words; waits for the device.
    fn fetch(&self, queue: &Queue) -> Result<Vec<u32>, Error> {
        let gathered: Buffer<u32> = Buffer::empty(&queue.stream, self.words)?;
        let pieces = Buffer::of(&queue.stream, &self.all)?;
        let longest = self.all.iter().map(|p| p.count).max().unwrap_or(0);
        let blocks = longest.div_ceil(u64::from(THREADS)).min(u64::from(PIECE_BLOCKS)) as u32;
        for first in (0..self.all.len()).step_by(MOST_BLOCKS) {
            let count = MOST_BLOCKS.min(self.all.len() - first) as u32;
            let args = GatherArgs { pieces: pieces.at(first), gathered: gathered.address() };
            // SAFETY: pieces are parts of arrays that live, and end where the gathered words do.
            unsafe { kernels::gather(&queue.grid(blocks, count, 1), &args)? };
        }
        queue.fetch(&gathered)
    }
}

impl Simulation<'_> {
    /// States of instances at the ends of frames that are kept, where `ends` has one for an instance;
    /// waits for the device.
    pub(crate) fn states(&self, ends: &[Option<usize>]) -> Result<Vec<Option<State>>, Error> {
        let mut states: Vec<Option<State>> = Vec::with_capacity(ends.len());
        while states.len() < ends.len() {
            let first = states.len();
            let (mut pieces, mut next) = (Pieces::default(), first);
            while next < ends.len() && pieces.words < GATHERED_WORDS {
                if let Some(frame) = ends[next] {
                    self.add_state(next, frame, &mut pieces);
                }
                next += 1;
            }
            let words = pieces.fetch(self.queue)?;
            let mut rest = words.as_slice();
            for (index, end) in ends.iter().enumerate().take(next).skip(first) {
                states.push(end.map(|_| self.take_state(index, &mut rest)));
            }
        }
        Ok(states)
    }

    /// Adds the arrays of a state that [`Self::take_state`] takes.
    fn add_state(&self, index: usize, frame: usize, pieces: &mut Pieces) {
        let graph = &self.instances[index].model.model().graph;
        let (n, r) = (graph.node_count(), graph.rods.len());
        let slot = frame % self.slots_of(index);
        pieces.add(self.states_of(index).add(slot * 6 * n), 6 * n);
        pieces.add(self.twists_of(index).add(slot * r), r);
        if let Some((phases, holds)) = self.worlds.grasping(index, frame) {
            pieces.add(phases, self.instances[index].world.grasps.len());
            pieces.add(holds, n);
        }
    }

    fn take_state(&self, index: usize, words: &mut &[u32]) -> State {
        let instance = &self.instances[index];
        let graph = &instance.model.model().graph;
        let (n, r) = (graph.node_count(), graph.rods.len());
        let planes: &[f32] = take(words, 6 * n);
        let point = |first: usize, i: usize| {
            [planes[first * n + i], planes[(first + 1) * n + i], planes[(first + 2) * n + i]]
        };
        State {
            positions: (0..n).map(|i| point(0, i)).collect(),
            velocities: (0..n).map(|i| point(3, i)).collect(),
            twists: take(words, r).to_vec(),
            grasping: if self.worlds.parts(index).grasps {
                let phases = take(words, instance.world.grasps.len());
                decode_grasping(phases, take::<args::Hold>(words, n))
            } else {
                Grasping::default()
            },
        }
    }
}

/// The first `count` values of words, which then begin behind them.
fn take<'a, T: Pod>(words: &mut &'a [u32], count: usize) -> &'a [T] {
    let (own, rest) = words.split_at(count * size_of::<T>() / size_of::<u32>());
    *words = rest;
    bytemuck::cast_slice(own)
}
