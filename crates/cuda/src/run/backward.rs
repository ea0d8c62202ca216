//! Gradients: every instance once forward, then its windows backward concurrently, frame by frame,
//! along the tape of each.

mod arrays;
mod motion;
mod together;
mod windows;

use bendtwin_core::{CancelToken, Graph};
use bendtwin_engine::{Error, backend::GradientRequest};

use self::windows::Window;
use crate::{
    device::{
        args::{FinishGradientArgs, Pointer},
        kernels,
        memory::{Buffer, end_of},
        specialization::THREADS,
    },
    plan::{
        resident::{LAWS, resident},
        tape::RolloutTapes,
    },
    run::{
        clearance::ClearanceSize, contact::contact_nodes, scoring::Scores, simulation::Simulation,
    },
};

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
    /// d loss / d initial twists by instance.
    pub(crate) initial_twists: Buffer<f32>,
    pub(crate) initial_twist_starts: Vec<usize>,
    /// d loss / d poses by instance, shape [F + 1, B, 3, 4]; empty if not asked for.
    pub(crate) poses: Buffer<f32>,
    pub(crate) pose_starts: Vec<usize>,
    /// d loss / d rolls by instance, shape [F + 1, R, 2]; empty if not asked for.
    pub(crate) rolls: Buffer<f32>,
    pub(crate) roll_starts: Vec<usize>,
    /// d loss / d places of holds by instance, shape [N], padded to four; empty without grasps.
    pub(crate) places: Buffer<[f32; 4]>,
    pub(crate) place_starts: Vec<usize>,
    /// Norms of d loss / d positions by instance, shape [F + 1]; empty if not asked for.
    pub(crate) norms: Buffer<f64>,
    pub(crate) norm_starts: Vec<usize>,
}

/// Bytes of device memory that an instance's gradient takes beside one window's tape.
pub(crate) fn bytes_of(simulated: &bendtwin_engine::backend::Instance) -> u64 {
    let graph = &simulated.model.model().graph;
    let (n, elements) = (graph.node_count() as u64, (graph.springs.len() + hinges(graph)) as u64);
    // The gradient and its sums, what seeds it, and d loss / d initial state.
    let motion = 48 * simulated.motion.poses.len() + 4 * simulated.motion.rolls.len();
    let seeds = crate::run::scoring::seed_bytes(simulated);
    24 * elements + seeds + 48 * n + motion as u64 + 8 * (simulated.frames as u64 + 1)
}

/// Number of triplets and rods: elements with three parameters each, whose gradients are summed
/// directly.
fn hinges(graph: &Graph) -> usize {
    graph.triplets.len() + graph.rods.len()
}

/// Results of the forward pass that the backward pass reads.
#[derive(Clone, Copy)]
pub(crate) struct ForwardPass<'a> {
    pub(crate) simulation: &'a Simulation<'a>,
    pub(crate) scores: &'a Scores,
    /// Tapes of all frames, if the forward pass wrote them.
    pub(crate) tapes: Option<&'a RolloutTapes>,
}

impl Gradients {
    /// Gradients of instances that have been run and scored, with `room` bytes for windows.
    pub(crate) fn new(
        forward: &ForwardPass<'_>,
        request: &GradientRequest,
        room: u64,
        cancel: &CancelToken,
    ) -> Result<Self, Error> {
        let instances = forward.simulation.instances;
        let this = Self::empty(forward.simulation, request)?;
        // Windows of like shape run together: of one graph, with as many substeps, and with contact
        // or without.
        let mut order: Vec<usize> = (0..instances.len()).collect();
        let key = |i: usize| {
            let loaded = &instances[i].model;
            let resident = resident(loaded)?;
            let substeps = loaded.model().timing.substeps;
            let graph = std::ptr::from_ref(&*resident.graph) as usize;
            let bodies = instances[i].world.bodies;
            let world = forward.simulation.worlds.parts(i);
            let contact = (contact_nodes(loaded.model()), ClearanceSize::of(&instances[i]));
            Ok::<_, Error>((graph, substeps, contact, bodies, world))
        };
        let keys = order.iter().map(|&i| key(i)).collect::<Result<Vec<_>, _>>()?;
        order.sort_by_key(|&i| (keys[i], i));
        let graphs: Vec<Backward<'_>> = order
            .chunk_by(|&a, &b| keys[a] == keys[b])
            .map(|members| Backward { forward: *forward, request, out: &this, cancel, members })
            .collect();
        together::run(&graphs, room)?;
        let params: Vec<_> = (0..instances.len()).map(|i| this.params.at(this.starts[i])).collect();
        forward.scores.add_rest_lengths(forward.simulation, &params)?;
        if request.motion {
            let poses: Vec<_> =
                (0..instances.len()).map(|i| this.poses.at(this.pose_starts[i])).collect();
            forward.scores.add_poses(forward.simulation, &poses)?;
        }
        Ok(this)
    }

    fn empty(simulation: &Simulation<'_>, request: &GradientRequest) -> Result<Self, Error> {
        let stream = &simulation.queue.stream;
        let (mut starts, mut control_starts, mut initial_starts) = (vec![0], vec![0], vec![0]);
        let (mut initial_twist_starts, mut norm_starts) = (vec![0], vec![0]);
        let (mut pose_starts, mut roll_starts, mut place_starts) = (vec![0], vec![0], vec![0]);
        for instance in simulation.instances {
            let graph = &instance.model.model().graph;
            let length = 3 * (graph.springs.len() + hinges(graph)) + LAWS;
            starts.push(end_of(&starts) + length);
            let controls = if request.controls { instance.controls.len() } else { 0 };
            control_starts.push(end_of(&control_starts) + controls);
            initial_starts.push(end_of(&initial_starts) + 2 * graph.node_count());
            initial_twist_starts.push(end_of(&initial_twist_starts) + graph.rods.len());
            let (poses, rolls) = match request.motion {
                true => (12 * instance.motion.poses.len(), instance.motion.rolls.len()),
                false => (0, 0),
            };
            pose_starts.push(end_of(&pose_starts) + poses);
            roll_starts.push(end_of(&roll_starts) + rolls);
            let places = if instance.world.grasps.is_empty() { 0 } else { graph.node_count() };
            place_starts.push(end_of(&place_starts) + places);
            let norms = if request.norms { instance.frames + 1 } else { 0 };
            norm_starts.push(end_of(&norm_starts) + norms);
        }
        Ok(Self {
            params: Buffer::zeros(stream, end_of(&starts))?,
            controls: Buffer::zeros(stream, end_of(&control_starts))?,
            initial: Buffer::zeros(stream, end_of(&initial_starts))?,
            initial_twists: Buffer::zeros(stream, end_of(&initial_twist_starts))?,
            poses: Buffer::zeros(stream, end_of(&pose_starts))?,
            rolls: Buffer::zeros(stream, end_of(&roll_starts))?,
            places: Buffer::zeros(stream, end_of(&place_starts))?,
            norms: Buffer::zeros(stream, end_of(&norm_starts))?,
            starts,
            control_starts,
            initial_starts,
            initial_twist_starts,
            pose_starts,
            roll_starts,
            place_starts,
            norm_starts,
        })
    }
}

/// Backward pass of instances of one graph.
struct Backward<'a> {
    forward: ForwardPass<'a>,
    request: &'a GradientRequest,
    out: &'a Gradients,
    cancel: &'a CancelToken,
    /// Indices of the instances; one at least.
    members: &'a [usize],
}

impl Backward<'_> {
    /// Windows of all instances. There may be as many as frames.
    fn all_windows(&self) -> impl Iterator<Item = Window> {
        self.members.iter().enumerate().flat_map(|(place, &i)| self.windows(place, i))
    }

    /// Number of windows, and of frames of the longest.
    fn shape(&self) -> (usize, usize) {
        self.all_windows().fold((0, 0), |(count, most), w| (count + 1, most.max(w.len())))
    }

    /// Floats of an instance's sums.
    fn stride(&self) -> usize {
        let (e, t) = self.elements(self.members[0]);
        3 * (e + t) + LAWS * self.most_blocks()
    }

    /// Blocks of the largest team.
    fn most_blocks(&self) -> usize {
        self.forward.simulation.queue.device.capabilities.processors as usize
    }

    /// Writes the gradients of its instances from their sums, one after another.
    fn finish_all(&self, total: &Buffer<f32>) -> Result<(), Error> {
        let (stride, blocks) = (self.stride(), self.most_blocks());
        let mut members = self.members.iter().enumerate();
        members.try_for_each(|(place, &i)| self.finish(i, total.at(place * stride), blocks))
    }

    fn windows(&self, place: usize, instance: usize) -> impl Iterator<Item = Window> + use<> {
        let frames = self.forward.simulation.instances[instance].frames;
        let every = match self.request.cut_every {
            0 => frames.max(1),
            every => every,
        };
        let window =
            move |first: usize| Window { instance, place, first, end: (first + every).min(frames) };
        (0..frames.max(1)).step_by(every).map(window)
    }

    /// Springs, and triplets and rods.
    fn elements(&self, instance: usize) -> (usize, usize) {
        let graph = &self.forward.simulation.instances[instance].model.model().graph;
        (graph.springs.len(), hinges(graph))
    }

    fn finish(&self, instance: usize, sums: Pointer<f32>, blocks: usize) -> Result<(), Error> {
        let (e, t) = self.elements(instance);
        let simulation = self.forward.simulation;
        let resident = resident(&simulation.instances[instance].model)?;
        let args = FinishGradientArgs {
            out: self.out.params.at(self.out.starts[instance]),
            sums,
            params: resident.params.address(),
            spring_count: e as u32,
            hinge_count: t as u32,
            block_count: blocks as u32,
            pad: 0,
        };
        let length = 3 * (e + t) + LAWS;
        let launch = simulation.queue.grid((length as u32).div_ceil(THREADS), 1, 1);
        // SAFETY: sums and parameters are those of a graph of E springs and T triplets and rods.
        unsafe { kernels::finish_gradient(&launch, &args) }
    }
}
