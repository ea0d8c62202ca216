//! The backend: checks, cuts batches to what memory holds, and runs them.

use std::{ops::Range, sync::Arc};

use bendtwin_core::{CancelToken, Environment, Graph, Params, Skin};
use bendtwin_engine::{
    Backend, Device as Description, Error, Loaded, Model,
    backend::{Divergence, Gradient, GradientRequest, Instance, Loss, Memory, Outputs, Rollout},
    check,
    model::State,
    optimizer::{Decay, Optimizer, OptimizerInit},
};

use crate::{
    device::{Device, queue::Queue, specialization::WorldParts},
    plan::{
        choice::{Purpose, choose, fits_one_block},
        graph::DeviceGraph,
        resident::{Resident, resident},
        shared::Shared,
        skin::DeviceSkin,
        tape::RolloutTapes,
    },
    run::{
        backward::{self, ForwardPass, Gradients},
        gradient::FetchedGradients,
        objective::Objectives,
        optimizer::DeviceOptimizer,
        outputs::{RecordedOutputs, retained_states},
        scoring::{Scores, loss, refuse_too_long, unless_diverged},
        simulation::{self, RetainedStates, Simulation},
    },
};

/// Share of the budget that a batch's working memory may take.
const WORKING_SHARE: u64 = 2;
/// Most rods of a graph: their twists are among the static variables of a block.
const MAX_RODS: usize = 16;

/// A queue with the objectives that have been sent through it.
type Channel = (Arc<Queue>, Arc<Objectives>);

/// Backend on a queue of a device.
#[derive(Clone)]
pub(crate) struct CudaBackend {
    device: Arc<Device>,
    pub(crate) queue: Arc<Queue>,
    /// Objectives on the device through this queue.
    objectives: Arc<Objectives>,
    normal: Channel,
    urgent: Channel,
    graphs: Arc<Shared<Graph, DeviceGraph>>,
    skins: Arc<Shared<Skin, DeviceSkin>>,
}

/// Instances that have been simulated and scored.
pub(crate) struct SimulatedBatch<'a> {
    simulation: Simulation<'a>,
    scores: Option<Scores>,
    divergences: Vec<Option<Divergence>>,
}

impl CudaBackend {
    pub(crate) fn new(device: &Arc<Device>) -> Self {
        let normal: Channel = (Arc::new(Queue::normal(device)), Arc::default());
        let urgent: Channel = (Arc::new(Queue::urgent(device)), Arc::default());
        let (queue, objectives) = normal.clone();
        let (device, graphs, skins) = (device.clone(), Arc::default(), Arc::default());
        Self { device, queue, objectives, normal, urgent, graphs, skins }
    }

    /// The backend on another queue.
    fn on(&self, (queue, objectives): &Channel) -> Self {
        Self { queue: queue.clone(), objectives: objectives.clone(), ..self.clone() }
    }

    /// Memory that batches may work with [bytes].
    fn room(&self) -> u64 {
        self.device.budget / WORKING_SHARE
    }

    /// Checks that a model is on this device.
    fn own(&self, resident: &Resident) -> Result<(), Error> {
        if Arc::ptr_eq(&resident.device, &self.device) {
            Ok(())
        } else {
            Err(Error::InvalidInput("the model is on another device".into()))
        }
    }

    /// Checks instances against their models, which must have been loaded on this device.
    pub(crate) fn check(&self, batch: &[Instance]) -> Result<(), Error> {
        for (index, instance) in batch.iter().enumerate() {
            self.own(resident(&instance.model)?)?;
            check::instance(index, instance)?;
        }
        Ok(())
    }

    /// Parts of a batch that fit into the room together; at least one instance each.
    fn chunks(
        batch: &[Instance],
        room: u64,
        bytes: impl Fn(&Instance) -> u64,
    ) -> Vec<Range<usize>> {
        let mut chunks = Vec::new();
        let (mut first, mut sum) = (0, 0_u64);
        for (i, instance) in batch.iter().enumerate() {
            let own = bytes(instance);
            if i > first && sum.saturating_add(own) > room {
                chunks.push(first..i);
                (first, sum) = (i, 0);
            }
            sum = sum.saturating_add(own);
        }
        if first < batch.len() {
            chunks.push(first..batch.len());
        }
        chunks
    }

    /// Parts of a batch whose gradients fit; half of the room is for tapes.
    pub(crate) fn gradient_chunks(&self, batch: &[Instance]) -> Vec<Range<usize>> {
        let bytes = |i: &Instance| {
            simulation::bytes_of(i, RetainedStates::All, false)
                .saturating_add(backward::bytes_of(i))
        };
        Self::chunks(batch, self.room() / 2, bytes)
    }

    fn refuse_too_large(&self, bytes: u64) -> Result<(), Error> {
        let available = self.room();
        if bytes > available {
            return Err(Error::OutOfMemory { needed: bytes, available });
        }
        Ok(())
    }

    /// Runs checked instances forward and backward.
    pub(crate) fn measure<'a>(
        &'a self,
        batch: &'a [Instance],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<(SimulatedBatch<'a>, Gradients), Error> {
        refuse_too_long(batch)?;
        let needed =
            batch.iter().map(|i| simulation::bytes_of(i, RetainedStates::All, false)).sum::<u64>();
        self.refuse_too_large(needed)?;
        let simulation = Simulation::new(&self.queue, batch, RetainedStates::All, false)?;
        let gradients = batch.iter().map(backward::bytes_of).sum::<u64>();
        let mut room = self.room().saturating_sub(needed).saturating_sub(gradients);
        // Tapes that fit are written by the forward pass; others when they are needed.
        let bytes = RolloutTapes::bytes_of(batch);
        let mut tape = if bytes <= room / 4 * 3 {
            room -= bytes;
            Some(RolloutTapes::new(&self.queue.stream, batch)?)
        } else {
            None
        };
        simulation.run(tape.as_mut(), cancel)?;
        let scores = Scores::new(&simulation, &self.objectives, Some(request.cut_every))?;
        let forward =
            ForwardPass { simulation: &simulation, scores: &scores, tapes: tape.as_ref() };
        let gradients = Gradients::new(&forward, request, room, cancel)?;
        let divergences = simulation.divergences()?;
        Ok((SimulatedBatch { simulation, scores: Some(scores), divergences }, gradients))
    }

    /// Runs checked instances forward and scores them.
    fn score<'a>(
        &'a self,
        batch: &'a [Instance],
        retained: RetainedStates,
        measured: bool,
        cancel: &CancelToken,
    ) -> Result<SimulatedBatch<'a>, Error> {
        let bytes = |i| simulation::bytes_of(i, retained, measured);
        self.refuse_too_large(batch.iter().map(bytes).sum())?;
        let simulation = Simulation::new(&self.queue, batch, retained, measured)?;
        simulation.run(None, cancel)?;
        let scored = batch.iter().any(|i| !i.objective.terms.is_empty());
        let scores =
            if scored { Some(Scores::new(&simulation, &self.objectives, None)?) } else { None };
        let divergences = simulation.divergences()?;
        Ok(SimulatedBatch { simulation, scores, divergences })
    }

    /// Waits for what a failed call has left on the queue: its models may be gone next.
    fn settled<T>(&self, result: Result<T, Error>) -> Result<T, Error> {
        if result.is_err() {
            let _ = self.queue.synchronize();
        }
        result
    }

    fn roll_out_chunk(
        &self,
        batch: &[Instance],
        outputs: &Outputs,
        cancel: &CancelToken,
    ) -> Result<Vec<Rollout>, Error> {
        let retained = retained_states(batch, outputs);
        let simulated = self.score(batch, retained, outputs.forces, cancel)?;
        let losses = simulated.losses()?;
        let frame_costs =
            if outputs.frame_costs { simulated.frame_costs()? } else { vec![vec![]; batch.len()] };
        let losses = losses.into_iter().zip(frame_costs).collect();
        let recorded = RecordedOutputs::new(&simulated.simulation, outputs)?;
        recorded.rollouts(&simulated.simulation, outputs, losses)
    }

    fn gradient_chunk(
        &self,
        batch: &[Instance],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<Gradient>, Error> {
        let (simulated, gradients) = self.measure(batch, request, cancel)?;
        let fetched = FetchedGradients::new(&self.queue, &gradients, request)?;
        let final_states = simulated.final_states(request.final_state)?;
        let each = batch.iter().zip(simulated.losses()?).zip(final_states).enumerate();
        Ok(each
            .map(|(i, ((instance, loss), end))| fetched.gradient(i, instance, loss, end))
            .collect())
    }
}

impl SimulatedBatch<'_> {
    /// The losses; waits for the device.
    pub(crate) fn losses(&self) -> Result<Vec<Loss>, Error> {
        match &self.scores {
            Some(scores) => scores.losses(&self.simulation, &self.divergences),
            None => {
                let each = self.simulation.instances.iter().zip(&self.divergences);
                let zeros = |i: &Instance| vec![0.0; i.objective.groups.len()];
                Ok(each.map(|(i, d)| loss(*d, zeros(i))).collect())
            }
        }
    }

    /// Costs by frame and group of each instance; waits for the device.
    pub(crate) fn frame_costs(&self) -> Result<Vec<Vec<f64>>, Error> {
        match &self.scores {
            Some(scores) => scores.frame_costs(&self.simulation, &self.divergences),
            None => {
                let each = self.simulation.instances.iter().zip(&self.divergences);
                Ok(each
                    .map(|(i, d)| {
                        let groups = i.objective.groups.len();
                        unless_diverged(*d, vec![0.0; (i.frames + 1) * groups], groups)
                    })
                    .collect())
            }
        }
    }

    /// States after the last frames of instances that did not diverge, if they are `asked` for; waits
    /// for the device.
    pub(crate) fn final_states(&self, asked: bool) -> Result<Vec<Option<State>>, Error> {
        let each = self.simulation.instances.iter().zip(&self.divergences);
        let end = |(i, diverged): (&Instance, &Option<Divergence>)| {
            (asked && diverged.is_none()).then_some(i.frames)
        };
        self.simulation.states(&each.map(end).collect::<Vec<_>>())
    }
}

impl Backend for CudaBackend {
    fn device(&self) -> Description {
        Description {
            kind: "cuda".into(),
            name: self.device.name.clone(),
            lanes: self.device.capabilities.processors as usize,
        }
    }

    fn load(&self, model: Arc<Model>) -> Result<Loaded, Error> {
        check::loadable(&model)?;
        let rods = model.graph.rods.len();
        if rods > MAX_RODS {
            return Err(Error::InvalidModel(format!(
                "{rods} rods: on this device {MAX_RODS} are the most, use the CPU or fit with graph.twist off"
            )));
        }
        self.refuse_too_large(resident_bytes(&model))?;
        let new_graph = || DeviceGraph::new(&self.device, &model.graph);
        let graph = self.graphs.get_or_make(&model.graph, new_graph)?;
        let new_skin = || DeviceSkin::new(&self.device, &model.skin);
        let skin = self.skins.get_or_make(&model.skin, new_skin)?;
        let resident = Resident::new(&self.device, graph, skin, &model.params)?;
        // Models that cannot run are refused here. Where that needs no cut of the graph, a cut is
        // made only for rollouts, which begin with few instances: a batch of candidates uses
        // another.
        let (device, world) = (&self.device.capabilities, WorldParts::default());
        let shapes = resident.shapes();
        if self.queue.is_urgent || !fits_one_block(device, &shapes, &model) {
            choose(device, &shapes, &model, Purpose::Forward, world, 1, 1)?;
        }
        crate::device::synchronize(&self.device.normal)?;
        Ok(Loaded::new(model, Arc::new(resident)))
    }

    fn with_params(&self, loaded: &Loaded, params: Params) -> Result<Loaded, Error> {
        let before = resident(loaded)?;
        self.own(before)?;
        let model = Model { params, ..Model::clone(loaded.model()) };
        model.params.check(&model.graph).map_err(Error::InvalidModel)?;
        let resident = before.with_params(&model.params)?;
        crate::device::synchronize(&self.device.normal)?;
        Ok(Loaded::new(Arc::new(model), Arc::new(resident)))
    }

    fn with_environment(&self, loaded: &Loaded, environment: Environment) -> Result<Loaded, Error> {
        let resident = resident(loaded)?;
        self.own(resident)?;
        check::environment(&environment)?;
        let model = Model { environment, ..Model::clone(loaded.model()) };
        Ok(Loaded::new(Arc::new(model), loaded.shared()))
    }

    fn roll_out(
        &self,
        batch: &[Instance],
        outputs: &Outputs,
        cancel: &CancelToken,
    ) -> Result<Vec<Rollout>, Error> {
        self.check(batch)?;
        for (index, instance) in batch.iter().enumerate() {
            check::outputs(index, instance, outputs)?;
        }
        let retained = retained_states(batch, outputs);
        let bytes =
            |i: &Instance| simulation::bytes_of(i, retained, outputs.forces).saturating_mul(2);
        let mut rollouts = Vec::with_capacity(batch.len());
        for chunk in Self::chunks(batch, self.room(), bytes) {
            let done = self.roll_out_chunk(&batch[chunk], outputs, cancel);
            rollouts.extend(self.settled(done)?);
        }
        Ok(rollouts)
    }

    fn losses(&self, batch: &[Instance], cancel: &CancelToken) -> Result<Vec<Loss>, Error> {
        self.check(batch)?;
        let scored = batch.iter().any(|i| !i.objective.terms.is_empty());
        let retained = if scored { RetainedStates::All } else { RetainedStates::Last };
        let bytes = |i: &Instance| simulation::bytes_of(i, retained, false);
        let mut losses = Vec::with_capacity(batch.len());
        for chunk in Self::chunks(batch, self.room(), bytes) {
            let done = self.score(&batch[chunk], retained, false, cancel).and_then(|m| m.losses());
            losses.extend(self.settled(done)?);
        }
        Ok(losses)
    }

    fn gradients(
        &self,
        batch: &[Instance],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<Gradient>, Error> {
        self.check(batch)?;
        let mut gradients = Vec::with_capacity(batch.len());
        for chunk in self.gradient_chunks(batch) {
            let done = self.gradient_chunk(&batch[chunk], request, cancel);
            gradients.extend(self.settled(done)?);
        }
        Ok(gradients)
    }

    fn optimizer(
        &self,
        inits: Vec<OptimizerInit>,
        decay: Decay,
    ) -> Result<Box<dyn Optimizer>, Error> {
        let normal = self.on(&self.normal);
        Ok(Box::new(DeviceOptimizer::new(normal, inits, decay)?))
    }

    fn memory(&self) -> Option<Memory> {
        self.device.memory()
    }

    fn urgent(&self) -> Option<Arc<dyn Backend>> {
        Some(Arc::new(self.on(&self.urgent)))
    }

    fn plan(&self, model: &Loaded, batch: usize) -> Option<String> {
        let resident = resident(model).ok()?;
        let (capabilities, purpose) = (&self.device.capabilities, Purpose::Forward);
        let (model, world) = (model.model(), WorldParts::default());
        let plan =
            choose(capabilities, &resident.shapes(), model, purpose, world, batch, batch).ok()?;
        Some(plan.team.to_string())
    }
}

/// Bytes that a model takes on the device: its graph for two shapes of launch, its skin, its
/// parameters.
fn resident_bytes(model: &Model) -> u64 {
    let graph = &model.graph;
    let (n, e, t) =
        (graph.node_count() as u64, graph.springs.len() as u64, graph.triplets.len() as u64);
    64 * n + 2 * (2 * e * 28 + 3 * t * 32) + DeviceSkin::bytes_of(&model.skin) + 20 * (e + t)
}
