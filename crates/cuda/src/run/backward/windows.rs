//! Windows that go backward side by side, from their ends to their starts.

use std::ops::Range;

use bendtwin_engine::Error;

use super::{Backward, Slots};
use crate::{
    device::{
        args::{
            AddSeedsArgs, AdjointArgs, CollectControlsArgs, GatherSumsArgs, InstanceArgs, Pointer,
            TopologyArgs,
        },
        kernels,
        memory::Buffer,
        pace::Pace,
        specialization::THREADS,
    },
    plan::{choice::Purpose, layout::PAIR_SUMS, resident::LAWS},
    run::{
        group::{FrameRange, Group, InstanceSpan},
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

/// Arguments of a lane's windows for some frames: those of a depth stand together.
struct Rounds {
    instances: Buffer<InstanceArgs>,
    /// d loss / d positions at the end of each instance's frame.
    seeds: Buffer<Pointer<f32>>,
    /// Output for d loss / d controls of each instance.
    outs: Buffer<Pointer<[f32; 3]>>,
    /// First instance of each depth, and the end of the last.
    starts: Vec<usize>,
    /// True if an instance has several windows at a depth.
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
        let (controls, pins, hinges) = group.instances().first().map_or((0, 0, 0), |args| {
            let t = &args.topology;
            let hinges = t.triplet_count + t.rod_count;
            (t.control_count as usize, t.pin_count as usize, hinges as usize)
        });
        let stride = of_springs + 3 * hinges + LAWS * blocks;
        let wanted = usize::from(self.way_back.request.controls && controls > 0);
        let sums = Buffer::zeros(stream, count * stride)?;
        let control_sums = Buffer::zeros(stream, wanted * count * 9 * blocks * controls)?;
        let pin_sums = Buffer::zeros(stream, wanted * count * 9 * pins)?;
        for (k, (w, args)) in group.members_mut().enumerate() {
            args.state.frame_count = 1;
            args.adjoint.bar_x = self.slots.bar_x.at(w * self.slots.nodes);
            args.adjoint.bar_v = self.slots.bar_v.at(w * self.slots.nodes);
            args.adjoint.bar_twists = self.slots.twist_bars.at(w * self.slots.rods);
            args.adjoint.spring_sums = sums.at(k * stride);
            args.adjoint.bend_sums = sums.at(k * stride + of_springs);
            args.adjoint.law_sums = sums.at(k * stride + of_springs + 3 * hinges);
            if wanted > 0 {
                args.adjoint.control_sums = control_sums.at(k * 9 * blocks * controls);
                args.adjoint.pin_sums = pin_sums.at(k * 9 * pins);
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
    pub(super) fn run(&self, total: impl Fn(usize) -> Pointer<f32>) -> Result<(), Error> {
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

    /// Arguments of windows that reach so deep. For tapes that have just been written, `slots` says by window where nodes
    /// are on them.
    fn rounds(
        &self,
        lane: &Lane,
        depths: Range<usize>,
        slots: &[Pointer<u32>],
    ) -> Result<Rounds, Error> {
        let (simulation, from) = (self.simulation(), depths.start);
        let (mut all, mut seeds, mut outs) = (Vec::new(), Vec::new(), Vec::new());
        let (mut starts, mut shared) = (vec![0], false);
        for depth in depths {
            let mut before = None;
            for (&w, args) in lane.group.members.iter().zip(lane.group.instances()) {
                let window = &self.windows[w];
                if window.len() <= depth {
                    continue;
                }
                let frame = window.frame(depth);
                let mut args = *args;
                args.state.first_frame = frame as u32;
                self.slots.place(w, depth - from, &mut args);
                match self.way_back.way.kept {
                    Some(kept) => {
                        kept.read(simulation.instances, window.instance, frame, &mut args);
                    }
                    None => args.tape.slot_of = slots[w],
                }
                all.push(args);
                seeds.push(self.way_back.way.scores.seed(simulation, window.instance, frame + 1));
                if self.way_back.request.controls {
                    let out = &self.way_back.out;
                    outs.push(out.controls.at(out.control_starts[window.instance]));
                }
                shared |= before.replace(window.instance) == Some(window.instance);
            }
            starts.push(all.len());
        }
        let stream = &simulation.queue.stream;
        Ok(Rounds {
            instances: Buffer::of(stream, &all)?,
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
            (
                start,
                InstanceSpan::part(
                    &rounds.instances,
                    start,
                    rounds.starts[depth - from + 1] - start,
                ),
            )
        };
        for (lane, rounds) in self.lanes.iter().zip(rounds) {
            let (start, span) = part(rounds);
            self.add_seeds(span, rounds.seeds.at(start), depth == 0)?;
            // Tapes of the way forward have outlived the candidates of their frames.
            if lane.group.fitted.specialization.contact && self.way_back.way.kept.is_some() {
                simulation.find_partners(&queue.stream, span, 0)?;
            }
        }
        for taped in slots.segments().rev() {
            // The last is there. The others take its place, in its order: they are written by the same span.
            if taped != slots.last_segment() {
                self.again(depth..depth + 1, taped.clone())?;
            }
            for (lane, rounds) in self.lanes.iter().zip(rounds) {
                lane.group.back(queue, part(rounds).1, taped.start, taped.end)?;
            }
        }
        if self.way_back.request.controls {
            for (lane, rounds) in self.lanes.iter().zip(rounds) {
                let (start, span) = part(rounds);
                // Windows of one instance share frame boundaries: one after the other.
                let at_once = if rounds.shared { 1 } else { span.count.max(1) };
                for k in (0..span.count).step_by(at_once) {
                    let some = InstanceSpan::part(&rounds.instances, start + k, at_once);
                    self.collect_controls(lane, some, rounds.outs.at(start + k))?;
                }
            }
        }
        Ok(())
    }

    /// Runs frames again, all at once, with these substeps on tape; says where nodes are on it, by window.
    fn again(&self, depths: Range<usize>, taped: Range<u32>) -> Result<Vec<Pointer<u32>>, Error> {
        let (simulation, from) = (self.simulation(), depths.start);
        let queue = simulation.queue;
        let windows = self.windows.iter().enumerate();
        let frames: Vec<(usize, usize)> = windows
            .flat_map(|(w, window)| {
                depths.clone().take_while(|&d| d < window.len()).map(move |d| (w, d))
            })
            .collect();
        let instances: Vec<usize> = frames.iter().map(|&(w, _)| self.windows[w].instance).collect();
        let mut slots = vec![Pointer::default(); self.windows.len()];
        for mut group in simulation.groups(&instances, Purpose::Tape)? {
            for (f, args) in group.members_mut() {
                let (w, depth) = frames[f];
                args.state.first_frame = self.windows[w].frame(depth) as u32;
                args.state.frame_count = 1;
                self.slots.place(w, depth - from, args);
                slots[w] = args.tape.slot_of;
            }
            let uploaded = Buffer::of(&queue.stream, group.instances())?;
            if group.fitted.specialization.contact {
                simulation.find_partners(&queue.stream, InstanceSpan::all(&uploaded), 0)?;
            }
            let range = FrameRange::again(taped.clone());
            group.advance(queue, &queue.stream, InstanceSpan::all(&uploaded), &range)?;
        }
        Ok(slots)
    }

    fn add_seeds(
        &self,
        of: InstanceSpan,
        seeds: Pointer<Pointer<f32>>,
        begins: bool,
    ) -> Result<(), Error> {
        let begins = u32::from(begins);
        let args = AddSeedsArgs { instances: of.address, seeds, begins, unused: 0 };
        let blocks = (self.slots.nodes as u32).div_ceil(THREADS);
        let launch = self.simulation().queue.grid(blocks, of.count as u32, 1);
        // SAFETY: every instance has its derivatives and a seed of as many nodes.
        unsafe { kernels::add_seeds(&launch, &args) }
    }

    fn collect_controls(
        &self,
        lane: &Lane,
        of: InstanceSpan,
        outs: Pointer<Pointer<[f32; 3]>>,
    ) -> Result<(), Error> {
        let controls = lane.group.instances().first().map_or(0, |args| args.topology.control_count);
        let block_count = lane.group.fitted.team.blocks;
        let args = CollectControlsArgs { instances: of.address, outs, block_count, unused: 0 };
        let queue = self.simulation().queue;
        let launch = queue.grid(controls.div_ceil(THREADS), of.count as u32, 1);
        // SAFETY: an instance has its sums, and the output the frames `first_frame` and the next.
        unsafe { kernels::collect_controls(&launch, &args) }
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
            let args = InstanceArgs {
                topology: TopologyArgs {
                    node_count: n as u32,
                    rod_count: slots.rods as u32,
                    ..TopologyArgs::default()
                },
                adjoint: AdjointArgs {
                    bar_x: slots.bar_x.at(w * n),
                    bar_v: slots.bar_v.at(w * n),
                    bar_twists: slots.twist_bars.at(w * slots.rods),
                    ..AdjointArgs::default()
                },
                ..InstanceArgs::default()
            };
            let uploaded = Buffer::of(stream, &[args])?;
            let seeds = Buffer::of(
                stream,
                &[self.way_back.way.scores.seed(simulation, window.instance, 0)],
            )?;
            self.add_seeds(InstanceSpan::all(&uploaded), seeds.address(), frames == 0)?;
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
    fn add_sums(&self, lane: &Lane, total: &impl Fn(usize) -> Pointer<f32>) -> Result<(), Error> {
        let Some(cut) = lane.group.packed().first().map(|p| &p.cut) else { return Ok(()) };
        let e = cut.sum_of.len() as u32;
        let others = (lane.stride - lane.of_springs) as u32;
        let place = |w: &usize| self.windows[*w].place;
        let mut at = 0;
        for own in lane.group.members.chunk_by(|a, b| place(a) == place(b)) {
            let args = GatherSumsArgs {
                total: total(place(&own[0])),
                sums: lane.sums.at(at * lane.stride),
                sum_of: cut.sum_of.address(),
                stride: lane.stride as u64,
                window_count: own.len() as u32,
                spring_count: e,
                other_count: others,
                first_other: lane.of_springs as u32,
            };
            at += own.len();
            let launch = self.simulation().queue.grid((e + others).div_ceil(THREADS), 1, 1);
            // SAFETY: sums are rows of `stride` numbers, so many of them, and the total has a place for each kind.
            unsafe { kernels::gather_sums(&launch, &args)? };
        }
        Ok(())
    }
}
