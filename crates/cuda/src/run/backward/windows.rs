//! Windows that go backward together, from their ends to their starts.

use std::ops::Range;

use bendtwin_core::CancelToken;
use bendtwin_engine::Error;

use super::{
    Backward,
    arrays::WindowArrays,
    motion::{MotionOuts, WorldBars},
};
use crate::{
    device::{
        args::{
            AddSeedsArgs, AdjointArgs, CollectControlsArgs, GatherSumsArgs, InstanceArgs,
            NormBarsArgs, Pointer, TopologyArgs,
        },
        kernels,
        memory::Buffer,
        queue::Queue,
        specialization::THREADS,
    },
    plan::{
        choice::Purpose,
        layout::PAIR_SUMS,
        resident::{LAWS, resident},
    },
    run::{
        clearance::{clearance_adjoint, find_clearances},
        group::{FrameRange, Group, InstanceSpan},
        simulation::Simulation,
    },
};

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

    /// The frame at a depth, counted backward.
    fn frame(&self, depth: usize) -> usize {
        self.end - 1 - depth
    }
}

/// Windows of one graph that go backward together.
pub(super) struct ConcurrentWindows<'a> {
    backward: &'a Backward<'a>,
    windows: &'a [Window],
    arrays: &'a WindowArrays,
    /// Sums of the instances, by place.
    total: &'a Buffer<f32>,
    batches: Vec<WindowBatch>,
    /// Arguments of each batch from depth `ready_from` on.
    ready: Vec<BatchArgs>,
    ready_from: usize,
}

/// Windows that one kernel takes backward, and their sums.
struct WindowBatch {
    group: Group,
    sums: Buffer<f32>,
    /// Floats of a window's sums: first of springs, then of triplets, rods and laws.
    stride: usize,
    of_springs: usize,
    _control_sums: Buffer<f32>,
    _pin_sums: Buffer<f32>,
    world_bars: Option<WorldBars>,
}

/// Arguments of a batch's windows for some frames, ordered by depth.
struct BatchArgs {
    instances: Buffer<InstanceArgs>,
    /// d loss / d positions at the end of each instance's frame.
    seeds: Buffer<Pointer<f32>>,
    /// Output for d loss / d controls of each instance.
    outs: Buffer<Pointer<[f32; 3]>>,
    /// Outputs for d loss / d poses and rolls, of instances with bodies or turning clamps.
    motion: Option<MotionOuts>,
    /// Output for the norm at the end of each instance's frame; empty if not asked for.
    norms: Buffer<Pointer<f64>>,
    /// First instance of each depth, and the end of the last.
    starts: Vec<usize>,
    /// True if an instance has several windows at a depth.
    shared: bool,
}

impl<'a> ConcurrentWindows<'a> {
    /// Windows that run backward beside `others`.
    pub(super) fn new(
        backward: &'a Backward<'a>,
        windows: &'a [Window],
        others: usize,
        arrays: &'a WindowArrays,
        total: &'a Buffer<f32>,
    ) -> Result<Self, Error> {
        let simulation = backward.forward.simulation;
        let instances: Vec<usize> = windows.iter().map(|w| w.instance).collect();
        let groups = simulation.groups(&instances, others, Purpose::Backward)?;
        let batches = Vec::with_capacity(groups.len());
        let (ready, ready_from) = (Vec::new(), 0);
        let mut this = Self { backward, windows, arrays, total, batches, ready, ready_from };
        for group in groups {
            let batch = this.batch(group)?;
            this.batches.push(batch);
        }
        Ok(this)
    }

    fn simulation(&self) -> &'a Simulation<'a> {
        self.backward.forward.simulation
    }

    fn batch(&self, mut group: Group) -> Result<WindowBatch, Error> {
        let stream = &self.simulation().queue.stream;
        let count = group.members.len();
        let blocks = group.plan.team.blocks as usize;
        let layout = group.packed().first().map(|p| &p.cut.layout);
        let of_springs = layout.map_or(0, |l| (l.sum_pairs * PAIR_SUMS) as usize);
        let (controls, pins, hinges) = group.instances().first().map_or((0, 0, 0), |args| {
            let t = &args.topology;
            let hinges = t.triplet_count + t.rod_count;
            (t.control_count as usize, t.pin_count as usize, hinges as usize)
        });
        let stride = of_springs + 3 * hinges + LAWS * blocks;
        let wanted = usize::from(self.backward.request.controls && controls > 0);
        let sums = Buffer::zeros(stream, count * stride)?;
        let control_sums = Buffer::zeros(stream, wanted * count * 9 * blocks * controls)?;
        let pin_sums = Buffer::zeros(stream, wanted * count * 9 * pins)?;
        for (k, (w, args)) in group.members_mut().enumerate() {
            args.state.frame_count = 1;
            args.adjoint.bar_x = self.arrays.bar_x.at(w * self.arrays.nodes);
            args.adjoint.bar_v = self.arrays.bar_v.at(w * self.arrays.nodes);
            args.adjoint.bar_twists = self.arrays.twist_bars.at(w * self.arrays.rods);
            args.adjoint.spring_sums = sums.at(k * stride);
            args.adjoint.bend_sums = sums.at(k * stride + of_springs);
            args.adjoint.law_sums = sums.at(k * stride + of_springs + 3 * hinges);
            if wanted > 0 {
                args.adjoint.control_sums = control_sums.at(k * 9 * blocks * controls);
                args.adjoint.pin_sums = pin_sums.at(k * 9 * pins);
            }
        }
        let world_bars = WorldBars::new(stream, &mut group)?;
        Ok(WindowBatch {
            group,
            sums,
            stride,
            of_springs,
            _control_sums: control_sums,
            _pin_sums: pin_sums,
            world_bars,
        })
    }

    pub(super) fn queue(&self) -> &'a Queue {
        self.simulation().queue
    }

    pub(super) fn cancel(&self) -> &'a CancelToken {
        self.backward.cancel
    }

    /// Number of frames of the longest window.
    pub(super) fn deepest(&self) -> usize {
        self.windows.iter().map(Window::len).max().unwrap_or(0)
    }

    /// Estimated time of a frame [us].
    pub(super) fn frame_us(&self) -> f64 {
        let substeps = self.arrays.substeps as u32;
        self.batches.iter().map(|b| b.group.frame_us(substeps)).sum()
    }

    /// Makes the arguments of a depth and of those that follow ready, if they are not yet; tapes too
    /// where the forward pass wrote none.
    pub(super) fn make_ready(&mut self, depth: usize) -> Result<(), Error> {
        if !depth.is_multiple_of(self.arrays.frames) {
            return Ok(());
        }
        let depths = depth..(depth + self.arrays.frames).min(self.deepest());
        let slots = match self.backward.forward.tapes {
            Some(_) => Vec::new(),
            None => self.again(depths.clone(), self.arrays.last_segment())?,
        };
        let args = self.batches.iter().map(|batch| self.batch_args(batch, depths.clone(), &slots));
        self.ready = args.collect::<Result<_, Error>>()?;
        self.ready_from = depth;
        Ok(())
    }

    /// Arguments of windows that reach so deep. For tapes that have just been written, `slots` has
    /// each window's entries of nodes on them.
    fn batch_args(
        &self,
        batch: &WindowBatch,
        depths: Range<usize>,
        slots: &[Pointer<u32>],
    ) -> Result<BatchArgs, Error> {
        let (simulation, from) = (self.simulation(), depths.start);
        let (mut all, mut seeds, mut outs) = (Vec::new(), Vec::new(), Vec::new());
        let mut norms = Vec::new();
        let (mut starts, mut shared) = (vec![0], false);
        let mut motion = Vec::new();
        for depth in depths {
            let mut before = None;
            for (&w, args) in batch.group.members.iter().zip(batch.group.instances()) {
                let window = &self.windows[w];
                if window.len() <= depth {
                    continue;
                }
                let frame = window.frame(depth);
                let mut args = *args;
                args.state.first_frame = frame as u32;
                let scores = self.backward.forward.scores;
                args.world.force_bars = scores.force_bars(simulation, window.instance, frame);
                self.arrays.place(w, depth - from, &mut args);
                match self.backward.forward.tapes {
                    Some(tapes) => {
                        tapes.read(simulation.instances, window.instance, frame, &mut args);
                    }
                    None => args.tape.slot_of = slots[w],
                }
                all.push(args);
                seeds.push(self.backward.forward.scores.seed(
                    simulation,
                    window.instance,
                    frame + 1,
                ));
                if self.backward.request.norms {
                    norms.push(self.norm(window.instance, frame + 1));
                }
                if self.backward.request.controls {
                    let out = &self.backward.out;
                    outs.push(out.controls.at(out.control_starts[window.instance]));
                }
                motion.push(window.instance);
                shared |= before.replace(window.instance) == Some(window.instance);
            }
            starts.push(all.len());
        }
        let stream = &simulation.queue.stream;
        Ok(BatchArgs {
            instances: Buffer::of(stream, &all)?,
            seeds: Buffer::of(stream, &seeds)?,
            outs: Buffer::of(stream, &outs)?,
            motion: match batch.world_bars {
                Some(_) => Some(MotionOuts::new(self.backward, &motion)?),
                None => None,
            },
            norms: Buffer::of(stream, &norms)?,
            starts,
            shared,
        })
    }

    /// First instance of a batch at a depth that is ready, and all of them.
    fn part(&self, args: &BatchArgs, depth: usize) -> (usize, InstanceSpan) {
        let at = depth - self.ready_from;
        let (start, end) = (args.starts[at], args.starts[at + 1]);
        (start, InstanceSpan::part(&args.instances, start, end - start))
    }

    /// Groups and their instances that one kernel each takes a frame backward.
    pub(super) fn frames(&self, depth: usize) -> impl Iterator<Item = (&Group, InstanceSpan)> {
        let ready = self.batches.iter().zip(&self.ready);
        ready.map(move |(batch, args)| (&batch.group, self.part(args, depth).1))
    }

    /// Adds what the objective wants of the ends of frames.
    pub(super) fn seed(&self, depth: usize) -> Result<(), Error> {
        let simulation = self.simulation();
        for (batch, args) in self.batches.iter().zip(&self.ready) {
            let (start, span) = self.part(args, depth);
            self.add_seeds(span, args.seeds.at(start), depth == 0)?;
            if self.backward.request.norms {
                self.norm_bars(span, args.norms.at(start))?;
            }
            // Tapes of the forward pass have outlived the contact candidates of their frames.
            if batch.group.plan.specialization.contact && self.backward.forward.tapes.is_some() {
                simulation.find_partners(&simulation.queue.stream, span, 0)?;
            }
            let has_clearances = batch.group.plan.specialization.skin_contact;
            if has_clearances && self.backward.forward.tapes.is_some() {
                find_clearances(simulation.queue, &simulation.queue.stream, span, 0)?;
            }
        }
        Ok(())
    }

    pub(super) fn segment_count(&self) -> usize {
        self.arrays.segments().count()
    }

    /// The substeps of a frame's n-th last segment, which are on tape then.
    pub(super) fn on_tape(&self, depth: usize, nth_last: usize) -> Result<Range<u32>, Error> {
        let taped = self.arrays.segments().nth_back(nth_last).unwrap_or(0..0);
        // The last is present. The others take its place, in its order: the same span writes them.
        if nth_last > 0 {
            self.again(depth..depth + 1, taped.clone())?;
        }
        Ok(taped)
    }

    /// Collects derivatives by controls and motion from the sums of a frame.
    pub(super) fn collect(&self, depth: usize) -> Result<(), Error> {
        let queue = self.queue();
        for (batch, args) in self.batches.iter().zip(&self.ready) {
            if batch.group.plan.specialization.skin_contact {
                clearance_adjoint(queue, &queue.stream, self.part(args, depth).1)?;
            }
        }
        for args in &self.ready {
            let (start, span) = self.part(args, depth);
            let Some(motion) = &args.motion else { continue };
            let step = if args.shared { 1 } else { span.count.max(1) };
            for k in (0..span.count).step_by(step) {
                let some = InstanceSpan::part(&args.instances, start + k, step);
                motion.collect(queue, some, start + k, false)?;
            }
        }
        if self.backward.request.controls {
            for (batch, args) in self.batches.iter().zip(&self.ready) {
                let (start, span) = self.part(args, depth);
                // Windows of one instance share frame boundaries: one after another.
                let step = if args.shared { 1 } else { span.count.max(1) };
                for k in (0..span.count).step_by(step) {
                    let some = InstanceSpan::part(&args.instances, start + k, step);
                    self.collect_controls(batch, some, args.outs.at(start + k))?;
                }
            }
        }
        Ok(())
    }

    /// Runs frames again, all concurrently, with these substeps on tape; returns where nodes are on
    /// it, by window.
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
        for mut group in simulation.groups(&instances, 0, Purpose::Tape)? {
            for (f, args) in group.members_mut() {
                let (w, depth) = frames[f];
                args.state.first_frame = self.windows[w].frame(depth) as u32;
                args.state.frame_count = 1;
                self.arrays.place(w, depth - from, args);
                slots[w] = args.tape.slot_of;
            }
            let uploaded = Buffer::of(&queue.stream, group.instances())?;
            if group.plan.specialization.contact {
                simulation.find_partners(&queue.stream, InstanceSpan::all(&uploaded), 0)?;
            }
            if group.plan.specialization.skin_contact {
                find_clearances(queue, &queue.stream, InstanceSpan::all(&uploaded), 0)?;
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
        let args = AddSeedsArgs { instances: of.address, seeds, begins, pad: 0 };
        let blocks = (self.arrays.nodes as u32).div_ceil(THREADS);
        let launch = self.simulation().queue.grid(blocks, of.count as u32, 1);
        // SAFETY: every instance has its derivatives and a seed of as many nodes.
        unsafe { kernels::add_seeds(&launch, &args) }
    }

    /// Address of the norm at a frame boundary of an instance.
    fn norm(&self, instance: usize, boundary: usize) -> Pointer<f64> {
        let out = self.backward.out;
        out.norms.at(out.norm_starts[instance] + boundary)
    }

    fn norm_bars(&self, of: InstanceSpan, outs: Pointer<Pointer<f64>>) -> Result<(), Error> {
        let args = NormBarsArgs { instances: of.address, outs };
        let launch = self.simulation().queue.grid(of.count as u32, 1, 1);
        // SAFETY: every instance has its derivatives and pins, and a place for its norm.
        unsafe { kernels::norm_bars(&launch, &args) }
    }

    fn collect_controls(
        &self,
        batch: &WindowBatch,
        of: InstanceSpan,
        outs: Pointer<Pointer<[f32; 3]>>,
    ) -> Result<(), Error> {
        let controls =
            batch.group.instances().first().map_or(0, |args| args.topology.control_count);
        let block_count = batch.group.plan.team.blocks;
        let args = CollectControlsArgs { instances: of.address, outs, block_count, pad: 0 };
        let queue = self.simulation().queue;
        let launch = queue.grid(controls.div_ceil(THREADS), of.count as u32, 1);
        // SAFETY: an instance has its sums, and the output the frames `first_frame` and the next.
        unsafe { kernels::collect_controls(&launch, &args) }
    }

    /// Stores the adjoints of instances' initial states, with the seeds of the starts themselves,
    /// for windows of `frames`.
    pub(super) fn store_initials(&self, frames: usize) -> Result<(), Error> {
        let request = self.backward.request;
        if !(request.initial || request.controls || request.motion || request.norms) {
            return Ok(());
        }
        let (simulation, arrays) = (self.simulation(), self.arrays);
        let (n, stream) = (arrays.nodes, &simulation.queue.stream);
        for (w, window) in self.windows.iter().enumerate() {
            if window.first > 0 || window.len() != frames {
                continue;
            }
            let (pin_of, _) = resident(&simulation.instances[window.instance].model)?.graph.pins();
            let args = InstanceArgs {
                topology: TopologyArgs {
                    pin_of,
                    node_count: n as u32,
                    rod_count: arrays.rods as u32,
                    ..TopologyArgs::default()
                },
                adjoint: AdjointArgs {
                    bar_x: arrays.bar_x.at(w * n),
                    bar_v: arrays.bar_v.at(w * n),
                    bar_twists: arrays.twist_bars.at(w * arrays.rods),
                    ..AdjointArgs::default()
                },
                ..InstanceArgs::default()
            };
            let uploaded = Buffer::of(stream, &[args])?;
            let seeds = Buffer::of(
                stream,
                &[self.backward.forward.scores.seed(simulation, window.instance, 0)],
            )?;
            self.add_seeds(InstanceSpan::all(&uploaded), seeds.address(), frames == 0)?;
            if request.norms {
                let outs = Buffer::of(stream, &[self.norm(window.instance, 0)])?;
                self.norm_bars(InstanceSpan::all(&uploaded), outs.address())?;
            }
            let out = self.backward.out;
            self.start_motion(w)?;
            let to = out.initial_starts[window.instance];
            out.initial.copy_from(to, &arrays.bar_x, w * n, n)?;
            out.initial.copy_from(to + n, &arrays.bar_v, w * n, n)?;
            if arrays.rods > 0 {
                let (to, r) = (out.initial_twist_starts[window.instance], arrays.rods);
                out.initial_twists.copy_from(to, &arrays.twist_bars, w * r, r)?;
            }
        }
        Ok(())
    }

    /// Takes a window back through how its instance's rollout starts: with what grasps hold.
    fn start_motion(&self, w: usize) -> Result<(), Error> {
        let (simulation, window) = (self.simulation(), &self.windows[w]);
        let batch = self.batches.iter().find(|b| b.group.members.contains(&w));
        let Some(WindowBatch { group, world_bars: Some(_), .. }) = batch else { return Ok(()) };
        let at = group.members.iter().position(|&m| m == w).unwrap_or(0);
        let mut args = group.instances()[at];
        args.state.first_frame = 0;
        args.state.frame_count = simulation.instances[window.instance].frames.min(1) as u32;
        let uploaded = Buffer::of(&simulation.queue.stream, &[args])?;
        let motion = MotionOuts::new(self.backward, &[window.instance])?;
        motion.collect(simulation.queue, InstanceSpan::all(&uploaded), 0, true)?;
        let out = self.backward.out;
        let count = out.place_starts[window.instance + 1] - out.place_starts[window.instance];
        if let Some(WorldBars { places, place_starts, .. }) =
            batch.and_then(|b| b.world_bars.as_ref())
        {
            out.places.copy_from(
                out.place_starts[window.instance],
                places,
                place_starts[at],
                count,
            )?;
        }
        Ok(())
    }

    /// Adds the sums of each instance's windows to its total.
    pub(super) fn add_sums(&self) -> Result<(), Error> {
        self.batches.iter().try_for_each(|batch| self.add_batch_sums(batch))
    }

    fn add_batch_sums(&self, batch: &WindowBatch) -> Result<(), Error> {
        let stride = self.backward.stride();
        let Some(cut) = batch.group.packed().first().map(|p| &p.cut) else { return Ok(()) };
        let e = cut.sum_of.len() as u32;
        let others = (batch.stride - batch.of_springs) as u32;
        let place = |w: &usize| self.windows[*w].place;
        let mut at = 0;
        for own in batch.group.members.chunk_by(|a, b| place(a) == place(b)) {
            let args = GatherSumsArgs {
                total: self.total.at(place(&own[0]) * stride),
                sums: batch.sums.at(at * batch.stride),
                sum_of: cut.sum_of.address(),
                stride: batch.stride as u64,
                window_count: own.len() as u32,
                spring_count: e,
                other_count: others,
                first_other: batch.of_springs as u32,
            };
            at += own.len();
            let launch = self.simulation().queue.grid((e + others).div_ceil(THREADS), 1, 1);
            // SAFETY: sums are the launched number of rows of `stride` numbers, and the total has a
            // place for each kind.
            unsafe { kernels::gather_sums(&launch, &args)? };
        }
        Ok(())
    }
}
