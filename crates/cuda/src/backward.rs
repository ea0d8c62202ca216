//! Gradients: every instance once forward, then its windows backward side by side, frame by frame: a
//! frame again onto tape, and back along it.

use bendtwin_engine::{
    Error,
    backend::{CancelToken, GradientRequest},
};

use crate::{
    job::Job,
    kernel::{Source, THREADS},
    launch::{Arguments, MOST_BLOCKS},
    memory::{Buffer, end_of},
    resident::{LAWS, resident},
    scoring::Scores,
    simulation::{Contact, Group, Simulation, contact_nodes},
    team::Purpose,
};

/// Bytes of a node's substep on tape.
const TAPE_BYTES: u64 = 36;
/// Largest tape of a window; a longer frame goes backward in segments.
const MAX_TAPE_BYTES: u64 = 256 << 20;

/// Gradients of a simulation's instances, on the device.
pub(crate) struct Gradients {
    /// d loss / d parameters by instance, in the kernels' order; `starts` says where.
    pub(crate) params: Buffer<f32>,
    pub(crate) starts: Vec<usize>,
    /// d loss / d controls by instance, shape [F + 1, C, 3]; empty if not asked for.
    pub(crate) controls: Buffer<[f32; 3]>,
    pub(crate) control_starts: Vec<usize>,
    /// d loss / d initial state by instance: positions [N], then velocities [N], padded to four.
    pub(crate) initial: Buffer<[f32; 4]>,
    pub(crate) initial_starts: Vec<usize>,
}

/// Frames of an instance between two cuts.
#[derive(Clone, Copy, Debug)]
struct Window {
    instance: usize,
    first: usize,
    end: usize,
}

/// Arrays that windows which run side by side need, one part for each.
struct Slots {
    tape_x: Buffer<[f32; 4]>,
    tape_v: Buffer<[f32; 2]>,
    tape_b: Buffer<[f32; 3]>,
    bar_x: Buffer<[f32; 4]>,
    bar_v: Buffer<[f32; 4]>,
    sums: Buffer<f32>,
    control_sums: Buffer<f32>,
    pin_sums: Buffer<f32>,
    contact: Contact,
    has_contact: bool,
    nodes: usize,
    segment: usize,
    sums_stride: usize,
    controls: usize,
    blocks: usize,
    pins: usize,
}

/// Bytes of device memory that an instance's gradient takes beside one window's tape.
pub(crate) fn bytes_of(simulated: &bendtwin_engine::backend::Instance) -> u64 {
    let graph = &simulated.model.model().graph;
    let (n, elements) =
        (graph.node_count() as u64, (graph.springs.len() + graph.triplets.len()) as u64);
    // The gradient and its sums, what seeds it, and d loss / d initial state.
    24 * elements + crate::scoring::seed_bytes(simulated.frames, n as usize) + 32 * n
}

impl Gradients {
    /// Gradients of instances that have been run and scored, with `room` bytes for windows.
    pub(crate) fn new(
        simulation: &Simulation<'_>,
        scores: &Scores,
        request: &GradientRequest,
        room: u64,
        cancel: &CancelToken,
    ) -> Result<Self, Error> {
        let this = Self::empty(simulation, request)?;
        // Windows of like shape go side by side: of one graph, with as many substeps, and with contact or without.
        let mut order: Vec<usize> = (0..simulation.instances.len()).collect();
        let graph = |i: usize| {
            let loaded = &simulation.instances[i].model;
            let resident = resident(loaded)?;
            let substeps = loaded.model().timing.substeps;
            let graph = std::ptr::from_ref(&*resident.graph) as usize;
            Ok::<_, Error>((graph, substeps, contact_nodes(loaded.model())))
        };
        let keys = order.iter().map(|&i| graph(i)).collect::<Result<Vec<_>, _>>()?;
        order.sort_by_key(|&i| (keys[i], i));
        for alike in order.chunk_by(|&a, &b| keys[a] == keys[b]) {
            Backward { simulation, scores, request, out: &this, cancel }.run(alike, room)?;
        }
        Ok(this)
    }

    fn empty(simulation: &Simulation<'_>, request: &GradientRequest) -> Result<Self, Error> {
        let stream = &simulation.queue.stream;
        let (mut starts, mut control_starts, mut initial_starts) = (vec![0], vec![0], vec![0]);
        for instance in simulation.instances {
            let graph = &instance.model.model().graph;
            let length = 3 * (graph.springs.len() + graph.triplets.len()) + LAWS;
            starts.push(end_of(&starts) + length);
            let controls = if request.controls { instance.controls.len() } else { 0 };
            control_starts.push(end_of(&control_starts) + controls);
            initial_starts.push(end_of(&initial_starts) + 2 * graph.node_count());
        }
        Ok(Self {
            params: Buffer::zeros(stream, end_of(&starts))?,
            controls: Buffer::zeros(stream, end_of(&control_starts))?,
            initial: Buffer::zeros(stream, end_of(&initial_starts))?,
            starts,
            control_starts,
            initial_starts,
        })
    }
}

struct Backward<'a> {
    simulation: &'a Simulation<'a>,
    scores: &'a Scores,
    request: &'a GradientRequest,
    out: &'a Gradients,
    cancel: &'a CancelToken,
}

impl Backward<'_> {
    /// All windows of instances of one graph.
    fn run(&self, members: &[usize], room: u64) -> Result<(), Error> {
        let Some(&first) = members.first() else { return Ok(()) };
        let windows: Vec<Window> = members.iter().flat_map(|&i| self.windows(i)).collect();
        let (e, t) = self.elements(first);
        let blocks = {
            let sample: Vec<usize> = windows.iter().take(1).map(|w| w.instance).collect();
            let groups = self.simulation.groups(&sample, Purpose::Backward)?;
            groups.iter().map(|g| g.fitted.team.blocks as usize).max().unwrap_or(1)
        };
        // All purposes' teams are bounded by the largest that there is.
        let blocks = blocks.max(self.most_blocks());
        let stride = 3 * (e + t) + LAWS * blocks;
        let slots = self.slots(first, windows.len(), room, blocks, stride)?;
        let count = slots.bar_x.len() / slots.nodes.max(1);
        let total: Buffer<f32> =
            Buffer::zeros(&self.simulation.queue.stream, stride * members.len())?;
        let per_group = if slots.nodes == 0 { windows.len().min(MOST_BLOCKS) } else { count };
        for together in windows.chunks(per_group.max(1)) {
            slots.sums.clear()?;
            slots.control_sums.clear()?;
            slots.pin_sums.clear()?;
            self.side_by_side(together, &slots)?;
            let mut at = 0;
            for own in together.chunk_by(|a, b| a.instance == b.instance) {
                let place = members.iter().position(|&i| i == own[0].instance).unwrap_or(0);
                self.add_sums(&total, place, &slots, at, own.len())?;
                at += own.len();
            }
        }
        for (place, &i) in members.iter().enumerate() {
            self.finish(i, total.at(place * stride), blocks)?;
        }
        Ok(())
    }

    fn most_blocks(&self) -> usize {
        self.simulation.queue.device.ability.processors as usize
    }

    fn windows(&self, instance: usize) -> Vec<Window> {
        let frames = self.simulation.instances[instance].frames;
        let every = match self.request.cut_every {
            0 => frames.max(1),
            every => every,
        };
        let window = |first: usize| Window { instance, first, end: (first + every).min(frames) };
        (0..frames.max(1)).step_by(every).map(window).collect()
    }

    fn elements(&self, instance: usize) -> (usize, usize) {
        let graph = &self.simulation.instances[instance].model.model().graph;
        (graph.springs.len(), graph.triplets.len())
    }

    /// Arrays for as many windows as there is room for.
    fn slots(
        &self,
        instance: usize,
        windows: usize,
        room: u64,
        blocks: usize,
        stride: usize,
    ) -> Result<Slots, Error> {
        let stream = &self.simulation.queue.stream;
        let model = self.simulation.instances[instance].model.model();
        let (n, c) = (model.graph.node_count(), model.graph.control_count());
        let (pins, substeps) = (model.graph.pins.len(), model.timing.substeps as usize);
        let substep = TAPE_BYTES * n.max(1) as u64;
        let wanted = if self.request.controls { 1 } else { 0 };
        let contact = 2_088 * contact_nodes(model);
        let fixed = (32 * n + contact + 4 * stride + 36 * wanted * (blocks * c + pins)) as u64;
        let longest = (MAX_TAPE_BYTES.min(room.saturating_sub(fixed)) / substep).max(1) as usize;
        // Segments of equal length.
        let segment = substeps.div_ceil(substeps.div_ceil(longest));
        let each = substep * segment as u64 + fixed;
        let count = ((room / each.max(1)) as usize).clamp(1, windows.clamp(1, MOST_BLOCKS));
        Ok(Slots {
            tape_x: Buffer::empty(stream, count * n * segment)?,
            tape_v: Buffer::empty(stream, count * n * segment)?,
            tape_b: Buffer::empty(stream, count * n * segment)?,
            bar_x: Buffer::empty(stream, count * n)?,
            bar_v: Buffer::empty(stream, count * n)?,
            sums: Buffer::empty(stream, count * stride)?,
            control_sums: Buffer::empty(stream, wanted * count * 9 * blocks * c)?,
            pin_sums: Buffer::empty(stream, wanted * count * 9 * pins)?,
            contact: Contact::new(
                self.simulation.queue,
                std::iter::repeat_n(contact_nodes(model), count),
            )?,
            has_contact: contact_nodes(model) > 0,
            nodes: n,
            segment,
            sums_stride: stride,
            controls: wanted * c,
            blocks,
            pins: wanted * pins,
        })
    }

    /// Windows that fit side by side, from their ends to their starts.
    fn side_by_side(&self, windows: &[Window], slots: &Slots) -> Result<(), Error> {
        let deepest = windows.iter().map(|w| w.end - w.first).max().unwrap_or(0);
        for depth in 0..=deepest {
            if self.cancel.is_cancelled() {
                self.simulation.queue.synchronize()?;
                return Err(Error::Cancelled);
            }
            let active: Vec<usize> =
                (0..windows.len()).filter(|&w| windows[w].end - windows[w].first > depth).collect();
            if !active.is_empty() {
                self.frame_back(windows, &active, depth, slots)?;
            }
            // What a window that starts the instance brings back is for the initial state.
            for (w, window) in windows.iter().enumerate() {
                if window.first == 0 && window.end - window.first == depth {
                    self.store_initial(window, w, depth, slots)?;
                }
            }
            // Not far ahead of the device.
            if depth % 4 == 3 {
                self.simulation.queue.synchronize()?;
            }
        }
        Ok(())
    }

    fn frame_back(
        &self,
        windows: &[Window],
        active: &[usize],
        depth: usize,
        slots: &Slots,
    ) -> Result<(), Error> {
        let (queue, stream) = (self.simulation.queue, &self.simulation.queue.stream);
        let members: Vec<usize> = active.iter().map(|&w| windows[w].instance).collect();
        let substeps = self.simulation.instances[members[0]].model.model().timing.substeps as usize;
        let mut tape = self.simulation.groups(&members, Purpose::Tape)?;
        let mut back = self.simulation.groups(&members, Purpose::Backward)?;
        let frame = |w: usize| windows[w].end - 1 - depth;
        for group in tape.iter_mut().chain(&mut back) {
            self.place(group, active, windows, &frame, slots)?;
        }
        let upload = |groups: &[Group]| {
            groups.iter().map(|g| Buffer::of(stream, g.jobs())).collect::<Result<Vec<_>, Error>>()
        };
        let (tape_jobs, back_jobs) = (upload(&tape)?, upload(&back)?);
        let seeds = |group: &Group, places: &[usize]| -> Vec<u64> {
            let seed =
                |(&i, &w): (&usize, &usize)| self.scores.seed(self.simulation, i, frame(w) + 1);
            group.members.iter().zip(places).map(seed).collect()
        };
        for (group, jobs) in back.iter().zip(&back_jobs) {
            let places = self.places(group, active, windows);
            let seeds = Buffer::of(stream, &seeds(group, &places))?;
            self.add_seeds(jobs, &seeds, depth == 0, slots.nodes)?;
        }
        for (group, jobs) in tape.iter().zip(&tape_jobs) {
            if group.fitted.variant.contact {
                self.simulation.find_partners(jobs, 0)?;
            }
        }
        let segments = substeps.div_ceil(slots.segment);
        for segment in (0..segments).rev() {
            let from = (segment * slots.segment) as u32;
            let to = ((segment + 1) * slots.segment).min(substeps) as u32;
            for (group, jobs) in tape.iter().zip(&tape_jobs) {
                group.advance(queue, jobs, 0, 1, from, to)?;
            }
            for (group, jobs) in back.iter().zip(&back_jobs) {
                group.back(queue, jobs, from, to)?;
            }
        }
        if self.request.controls && slots.controls > 0 {
            for (group, jobs) in back.iter().zip(&back_jobs) {
                self.collect_controls(group, jobs, slots)?;
            }
        }
        Ok(())
    }

    /// Which window each job of a group is; windows of one instance come in order.
    fn places(&self, group: &Group, active: &[usize], windows: &[Window]) -> Vec<usize> {
        let mut taken = vec![false; windows.len()];
        let place = |&i: &usize| {
            let free = |w: &&usize| windows[**w].instance == i && !taken[**w];
            let found = active.iter().find(free).copied().unwrap_or(active[0]);
            taken[found] = true;
            found
        };
        group.members.iter().map(place).collect()
    }

    /// Gives a group's jobs their windows' frames and arrays.
    fn place(
        &self,
        group: &mut Group,
        active: &[usize],
        windows: &[Window],
        frame: &impl Fn(usize) -> usize,
        slots: &Slots,
    ) -> Result<(), Error> {
        let places = self.places(group, active, windows);
        let (e, t) = self.elements(group.members[0]);
        for (job, w) in group.jobs_mut().iter_mut().zip(places) {
            let n = slots.nodes;
            job.first = frame(w) as u32;
            job.frames = 1;
            job.tape_x = slots.tape_x.at(w * n * slots.segment);
            job.tape_v = slots.tape_v.at(w * n * slots.segment);
            job.tape_b = slots.tape_b.at(w * n * slots.segment);
            job.bar_x = slots.bar_x.at(w * n);
            job.bar_v = slots.bar_v.at(w * n);
            job.spring_sums = slots.sums.at(w * slots.sums_stride);
            job.bend_sums = slots.sums.at(w * slots.sums_stride + 3 * e);
            job.law_sums = slots.sums.at(w * slots.sums_stride + 3 * (e + t));
            if slots.has_contact {
                slots.contact.place(w, job);
            }
            if slots.controls > 0 {
                job.control_sums = slots.control_sums.at(w * 9 * slots.blocks * slots.controls);
                job.pin_sums = slots.pin_sums.at(w * 9 * slots.pins);
            }
        }
        Ok(())
    }

    fn add_seeds(
        &self,
        jobs: &Buffer<Job>,
        seeds: &Buffer<u64>,
        begins: bool,
        nodes: usize,
    ) -> Result<(), Error> {
        let arguments =
            Arguments::default().with(jobs.address()).with(seeds.address()).with(u32::from(begins));
        let grid = ((nodes as u32).div_ceil(THREADS), jobs.len() as u32, 1);
        // SAFETY: every job has its bars and a seed of as many nodes.
        unsafe { self.simulation.queue.launch(Source::Params, "add_seeds", grid, &arguments) }
    }

    fn collect_controls(
        &self,
        group: &Group,
        jobs: &Buffer<Job>,
        slots: &Slots,
    ) -> Result<(), Error> {
        let out = |&i: &usize| self.out.controls.at(self.out.control_starts[i]);
        let outs: Vec<u64> = group.members.iter().map(out).collect();
        let outs = Buffer::of(&self.simulation.queue.stream, &outs)?;
        // Windows of one instance share frame boundaries: one after the other.
        for (k, _) in group.members.iter().enumerate() {
            let arguments = Arguments::default()
                .with(jobs.at(k))
                .with(outs.at(k))
                .with(group.fitted.team.blocks);
            let grid = ((slots.controls as u32).div_ceil(THREADS), 1, 1);
            // SAFETY: the job has its sums, and the output frames `first` and `first` + 1.
            unsafe {
                self.simulation.queue.launch(
                    Source::Params,
                    "collect_controls",
                    grid,
                    &arguments,
                )?;
            }
        }
        Ok(())
    }

    /// What came back to the instance's start, with the seed of frame 0 itself.
    fn store_initial(
        &self,
        window: &Window,
        place: usize,
        depth: usize,
        slots: &Slots,
    ) -> Result<(), Error> {
        let n = slots.nodes;
        let stream = &self.simulation.queue.stream;
        let job = Job {
            topology: crate::job::Topology { node_count: n as u32, ..Default::default() },
            bar_x: slots.bar_x.at(place * n),
            bar_v: slots.bar_v.at(place * n),
            ..Job::default()
        };
        let jobs = Buffer::of(stream, &[job])?;
        let seed = self.scores.seed(self.simulation, window.instance, 0);
        let seeds = Buffer::of(stream, &[seed])?;
        self.add_seeds(&jobs, &seeds, depth == 0, n)?;
        let to = self.out.initial_starts[window.instance];
        self.out.initial.copy_from(to, &slots.bar_x, place * n, n)?;
        self.out.initial.copy_from(to + n, &slots.bar_v, place * n, n)
    }

    fn add_sums(
        &self,
        total: &Buffer<f32>,
        place: usize,
        slots: &Slots,
        first: usize,
        windows: usize,
    ) -> Result<(), Error> {
        let stride = slots.sums_stride;
        let arguments = Arguments::default()
            .with(total.at(place * stride))
            .with(slots.sums.at(first * stride))
            .with(windows as u32)
            .with(stride as u64)
            .with(stride as u32);
        let grid = ((stride as u32).div_ceil(THREADS), 1, 1);
        // SAFETY: both have rows of `stride` numbers, and so many of them.
        unsafe { self.simulation.queue.launch(Source::Params, "gather_sums", grid, &arguments) }
    }

    fn finish(&self, instance: usize, sums: u64, blocks: usize) -> Result<(), Error> {
        let (e, t) = self.elements(instance);
        let resident = resident(&self.simulation.instances[instance].model)?;
        let arguments = Arguments::default()
            .with(self.out.params.at(self.out.starts[instance]))
            .with(sums)
            .with(resident.params.address())
            .with(e as u32)
            .with(t as u32)
            .with(blocks as u32);
        let length = 3 * (e + t) + LAWS;
        let grid = ((length as u32).div_ceil(THREADS), 1, 1);
        // SAFETY: sums and parameters are those of a graph of E springs and T triplets.
        unsafe { self.simulation.queue.launch(Source::Params, "finish_gradient", grid, &arguments) }
    }
}
