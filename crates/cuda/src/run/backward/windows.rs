//! Windows that go backward side by side, from their ends to their starts.

use std::ops::Range;

use bendtwin_engine::Error;

use super::{Backward, Slots};
use crate::{
    device::{
        job::{Address, Job, Topology},
        kernel::{Source, THREADS},
        launch::Arguments,
        memory::Buffer,
        pace::Pace,
    },
    plan::{choice::Purpose, layout::PAIR_SUMS, resident::LAWS},
    run::{
        group::{Group, Jobs, Stretch},
        simulation::Simulation,
    },
};

/// Frames that the host is ahead of the device.
const AHEAD: usize = 4;

/// Frames of an instance between two cuts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub(super) instance: usize,
    /// Index of the instance among those of its graph.
    pub(super) place: usize,
    pub(super) first: usize,
    pub(super) end: usize,
}

impl Window {
    pub(super) fn len(&self) -> usize {
        self.end - self.first
    }

    /// The frame that goes backward after so many others.
    fn frame(&self, depth: usize) -> usize {
        self.end - 1 - depth
    }
}

/// Windows that go backward side by side.
pub(super) struct SideBySide<'a> {
    way_back: &'a Backward<'a>,
    windows: &'a [Window],
    slots: &'a Slots,
    lanes: Vec<Lane>,
}

/// Windows that one kernel takes backward, and what they sum on their way.
struct Lane {
    group: Group,
    sums: Buffer<f32>,
    /// Floats of a window's sums: first of springs, then of triplets, rods and laws.
    stride: usize,
    of_springs: usize,
    _control_sums: Buffer<f32>,
    _pin_sums: Buffer<f32>,
}

/// A lane's jobs for some frames: those of a depth stand together.
struct Rounds {
    jobs: Buffer<Job>,
    /// Where d loss / d positions at each job's frame's end is.
    seeds: Buffer<Address>,
    /// Where d loss / d controls of each job's instance goes.
    outs: Buffer<Address>,
    /// First job of each depth, and the end of the last.
    starts: Vec<usize>,
    /// Whether an instance has several jobs at a depth.
    shared: bool,
}

impl<'a> SideBySide<'a> {
    pub(super) fn new(
        way_back: &'a Backward<'a>,
        windows: &'a [Window],
        slots: &'a Slots,
    ) -> Result<Self, Error> {
        let simulation = way_back.way.simulation;
        let instances: Vec<usize> = windows.iter().map(|w| w.instance).collect();
        let groups = simulation.groups(&instances, Purpose::Backward)?;
        let mut this = Self { way_back, windows, slots, lanes: Vec::with_capacity(groups.len()) };
        for group in groups {
            let lane = this.lane(group)?;
            this.lanes.push(lane);
        }
        Ok(this)
    }

    fn simulation(&self) -> &'a Simulation<'a> {
        self.way_back.way.simulation
    }

    fn lane(&self, mut group: Group) -> Result<Lane, Error> {
        let stream = &self.simulation().queue.stream;
        let count = group.members.len();
        let blocks = group.fitted.team.blocks as usize;
        let layout = group.packed().first().map(|p| &p.cut.layout);
        let of_springs = layout.map_or(0, |l| (l.sum_pairs * PAIR_SUMS) as usize);
        let (controls, pins, hinges) = group.jobs().first().map_or((0, 0, 0), |j| {
            let hinges = j.triplets + j.topology.rods;
            (j.topology.controls as usize, j.pins as usize, hinges as usize)
        });
        let stride = of_springs + 3 * hinges + LAWS * blocks;
        let wanted = usize::from(self.way_back.request.controls && controls > 0);
        let sums = Buffer::zeros(stream, count * stride)?;
        let control_sums = Buffer::zeros(stream, wanted * count * 9 * blocks * controls)?;
        let pin_sums = Buffer::zeros(stream, wanted * count * 9 * pins)?;
        for (k, (w, job)) in group.members_mut().enumerate() {
            job.frames = 1;
            job.bar_x = self.slots.bar_x.at(w * self.slots.nodes);
            job.bar_v = self.slots.bar_v.at(w * self.slots.nodes);
            job.twist_bars = self.slots.twist_bars.at(w * self.slots.rods);
            job.spring_sums = sums.at(k * stride);
            job.bend_sums = sums.at(k * stride + of_springs);
            job.law_sums = sums.at(k * stride + of_springs + 3 * hinges);
            if wanted > 0 {
                job.control_sums = control_sums.at(k * 9 * blocks * controls);
                job.pin_sums = pin_sums.at(k * 9 * pins);
            }
        }
        Ok(Lane {
            group,
            sums,
            stride,
            of_springs,
            _control_sums: control_sums,
            _pin_sums: pin_sums,
        })
    }

    /// Takes all windows back to their starts and adds their sums to those of their instances, by place.
    pub(super) fn run(&self, total: impl Fn(usize) -> Address) -> Result<(), Error> {
        let queue = self.simulation().queue;
        let deepest = self.windows.iter().map(Window::len).max().unwrap_or(0);
        // Where nothing moves, what is wanted at the start is wanted of the start.
        self.store_initials(0)?;
        let mut pace = Pace::default();
        for from in (0..deepest).step_by(self.slots.frames) {
            let depths = from..(from + self.slots.frames).min(deepest);
            let slots = match self.way_back.way.kept {
                Some(_) => Vec::new(),
                None => self.again(depths.clone(), self.slots.last_segment())?,
            };
            let rounds = self.lanes.iter().map(|lane| self.rounds(lane, depths.clone(), &slots));
            let rounds = rounds.collect::<Result<Vec<_>, Error>>()?;
            for depth in depths {
                if self.way_back.cancel.is_cancelled() {
                    queue.synchronize()?;
                    return Err(Error::Cancelled);
                }
                self.frame_back(depth, from, &rounds)?;
                self.store_initials(depth + 1)?;
                if depth % AHEAD == AHEAD - 1 {
                    pace.step(queue)?;
                }
            }
        }
        self.lanes.iter().try_for_each(|lane| self.add_sums(lane, &total))
    }

    /// Jobs of windows that reach so deep. For tapes that have just been written, `slots` says by window where nodes
    /// are on them.
    fn rounds(
        &self,
        lane: &Lane,
        depths: Range<usize>,
        slots: &[Address],
    ) -> Result<Rounds, Error> {
        let (simulation, from) = (self.simulation(), depths.start);
        let (mut jobs, mut seeds, mut outs) = (Vec::new(), Vec::new(), Vec::new());
        let (mut starts, mut shared) = (vec![0], false);
        for depth in depths {
            let mut before = None;
            for (&w, job) in lane.group.members.iter().zip(lane.group.jobs()) {
                let window = &self.windows[w];
                if window.len() <= depth {
                    continue;
                }
                let frame = window.frame(depth);
                let mut job = Job { first: frame as u32, ..*job };
                self.slots.place(w, depth - from, &mut job);
                match self.way_back.way.kept {
                    Some(kept) => {
                        kept.read(simulation.instances, window.instance, frame, &mut job);
                    }
                    None => job.tape_slots = slots[w],
                }
                jobs.push(job);
                seeds.push(self.way_back.way.scores.seed(simulation, window.instance, frame + 1));
                if self.way_back.request.controls {
                    let out = &self.way_back.out;
                    outs.push(out.controls.at(out.control_starts[window.instance]));
                }
                shared |= before.replace(window.instance) == Some(window.instance);
            }
            starts.push(jobs.len());
        }
        let stream = &simulation.queue.stream;
        Ok(Rounds {
            jobs: Buffer::of(stream, &jobs)?,
            seeds: Buffer::of(stream, &seeds)?,
            outs: Buffer::of(stream, &outs)?,
            starts,
            shared,
        })
    }

    fn frame_back(&self, depth: usize, from: usize, rounds: &[Rounds]) -> Result<(), Error> {
        let (simulation, slots) = (self.simulation(), self.slots);
        let queue = simulation.queue;
        let part = |rounds: &Rounds| {
            let start = rounds.starts[depth - from];
            (start, Jobs::part(&rounds.jobs, start, rounds.starts[depth - from + 1] - start))
        };
        for (lane, rounds) in self.lanes.iter().zip(rounds) {
            let (start, jobs) = part(rounds);
            self.add_seeds(jobs, rounds.seeds.at(start), depth == 0)?;
            // Tapes of the way forward have outlived the candidates of their frames.
            if lane.group.fitted.variant.contact && self.way_back.way.kept.is_some() {
                simulation.find_partners(&queue.stream, jobs, 0)?;
            }
        }
        for taped in slots.segments().rev() {
            // The last is there. The others take its place, in its order: they are written by the same jobs.
            if taped != slots.last_segment() {
                self.again(depth..depth + 1, taped.clone())?;
            }
            for (lane, rounds) in self.lanes.iter().zip(rounds) {
                lane.group.back(queue, part(rounds).1, taped.start, taped.end)?;
            }
        }
        if self.way_back.request.controls {
            for (lane, rounds) in self.lanes.iter().zip(rounds) {
                let (start, jobs) = part(rounds);
                // Windows of one instance share frame boundaries: one after the other.
                let at_once = if rounds.shared { 1 } else { jobs.count.max(1) };
                for k in (0..jobs.count).step_by(at_once) {
                    let some = Jobs::part(&rounds.jobs, start + k, at_once);
                    self.collect_controls(lane, some, rounds.outs.at(start + k))?;
                }
            }
        }
        Ok(())
    }

    /// Runs frames again, all at once, with these substeps on tape; says where nodes are on it, by window.
    fn again(&self, depths: Range<usize>, taped: Range<u32>) -> Result<Vec<Address>, Error> {
        let (simulation, from) = (self.simulation(), depths.start);
        let queue = simulation.queue;
        let windows = self.windows.iter().enumerate();
        let frames: Vec<(usize, usize)> = windows
            .flat_map(|(w, window)| {
                depths.clone().take_while(|&d| d < window.len()).map(move |d| (w, d))
            })
            .collect();
        let instances: Vec<usize> = frames.iter().map(|&(w, _)| self.windows[w].instance).collect();
        let mut slots = vec![0; self.windows.len()];
        for mut group in simulation.groups(&instances, Purpose::Tape)? {
            for (f, job) in group.members_mut() {
                let (w, depth) = frames[f];
                job.first = self.windows[w].frame(depth) as u32;
                job.frames = 1;
                self.slots.place(w, depth - from, job);
                slots[w] = job.tape_slots;
            }
            let jobs = Buffer::of(&queue.stream, group.jobs())?;
            if group.fitted.variant.contact {
                simulation.find_partners(&queue.stream, Jobs::all(&jobs), 0)?;
            }
            let stretch = Stretch::again(taped.clone());
            group.advance(queue, &queue.stream, Jobs::all(&jobs), &stretch)?;
        }
        Ok(slots)
    }

    fn add_seeds(&self, jobs: Jobs, seeds: Address, begins: bool) -> Result<(), Error> {
        let arguments = Arguments::default().with(jobs.address).with(seeds).with(u32::from(begins));
        let grid = ((self.slots.nodes as u32).div_ceil(THREADS), jobs.count as u32, 1);
        // SAFETY: every job has its bars and a seed of as many nodes.
        unsafe { self.simulation().queue.launch(Source::Params, "add_seeds", grid, &arguments) }
    }

    fn collect_controls(&self, lane: &Lane, jobs: Jobs, outs: Address) -> Result<(), Error> {
        let controls = lane.group.jobs().first().map_or(0, |j| j.topology.controls);
        let blocks = lane.group.fitted.team.blocks;
        let arguments = Arguments::default().with(jobs.address).with(outs).with(blocks);
        let grid = (controls.div_ceil(THREADS), jobs.count as u32, 1);
        // SAFETY: a job has its sums, and the output frames `first` and `first` + 1.
        unsafe {
            self.simulation().queue.launch(Source::Params, "collect_controls", grid, &arguments)
        }
    }

    /// Keeps what came back to the starts of instances, with the seeds of the starts themselves, of windows
    /// with so many frames.
    fn store_initials(&self, frames: usize) -> Result<(), Error> {
        let request = self.way_back.request;
        if !(request.initial || request.controls) {
            return Ok(());
        }
        let (simulation, slots) = (self.simulation(), self.slots);
        let (n, stream) = (slots.nodes, &simulation.queue.stream);
        for (w, window) in self.windows.iter().enumerate() {
            if window.first > 0 || window.len() != frames {
                continue;
            }
            let job = Job {
                topology: Topology {
                    node_count: n as u32,
                    rods: slots.rods as u32,
                    ..Default::default()
                },
                twist_bars: slots.twist_bars.at(w * slots.rods),
                bar_x: slots.bar_x.at(w * n),
                bar_v: slots.bar_v.at(w * n),
                ..Job::default()
            };
            let jobs = Buffer::of(stream, &[job])?;
            let seeds = Buffer::of(
                stream,
                &[self.way_back.way.scores.seed(simulation, window.instance, 0)],
            )?;
            self.add_seeds(Jobs::all(&jobs), seeds.address(), frames == 0)?;
            let out = self.way_back.out;
            let to = out.initial_starts[window.instance];
            out.initial.copy_from(to, &slots.bar_x, w * n, n)?;
            out.initial.copy_from(to + n, &slots.bar_v, w * n, n)?;
            if slots.rods > 0 {
                let (to, r) = (out.initial_twist_starts[window.instance], slots.rods);
                out.initial_twists.copy_from(to, &slots.twist_bars, w * r, r)?;
            }
        }
        Ok(())
    }

    /// Adds the sums of each instance's windows to its total.
    fn add_sums(&self, lane: &Lane, total: &impl Fn(usize) -> Address) -> Result<(), Error> {
        let Some(cut) = lane.group.packed().first().map(|p| &p.cut) else { return Ok(()) };
        let e = cut.sum_of.len() as u32;
        let others = (lane.stride - lane.of_springs) as u32;
        let place = |w: &usize| self.windows[*w].place;
        let mut at = 0;
        for own in lane.group.members.chunk_by(|a, b| place(a) == place(b)) {
            let arguments = Arguments::default()
                .with(total(place(&own[0])))
                .with(lane.sums.at(at * lane.stride))
                .with(cut.sum_of.address())
                .with(own.len() as u32)
                .with(lane.stride as u64)
                .with(e)
                .with(others)
                .with(lane.of_springs as u32);
            at += own.len();
            let grid = ((e + others).div_ceil(THREADS), 1, 1);
            // SAFETY: sums are rows of `stride` numbers, so many of them, and the total has a place for each kind.
            unsafe {
                self.simulation().queue.launch(Source::Params, "gather_sums", grid, &arguments)?;
            }
        }
        Ok(())
    }
}
