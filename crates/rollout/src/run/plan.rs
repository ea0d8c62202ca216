//! Plan of a request: the instances to be simulated, and the arrays to
//! return.

use std::sync::Arc;

use bendtwin_budget::Share;
use bendtwin_contract::rollout::{PlannerShape, TwinShape};
use bendtwin_core::{CancelToken, Point, Twin};
use bendtwin_engine::{
    Backend, Motion,
    backend::{Instance, Rollout},
    model::State,
};

use crate::{
    error::Error,
    request::{
        actions::{Actions, Floor, Horizon, Stopped, Stops},
        checked::Checked,
        costs::{Context, Costs},
        ensemble::Ensemble,
        initial::{Starts, Wanted},
        plausible::{self, Extremes, Plausibility, Prescribed},
        returns::Returns,
        vary::{Base, Variant, Variants},
    },
    twin::serve::Served,
    world::{Ended, Surroundings, gripper_of_control},
};

/// Distance between where a control point is and where nodes say that it may be, at most [m].
const UNKNOWN_SLACK_M: f32 = 0.02;

/// A checked request as instances for the engine.
pub struct Plan {
    pub(crate) served: Served,
    pub(crate) actions: Actions,
    pub(crate) frames: usize,
    pub(crate) costs: Costs,
    pub(crate) returns: Returns,
    /// Number of grasps.
    pub(crate) grasps: usize,
    pub(crate) surroundings: Surroundings,
    pub(crate) variants: Variants,
    pub(crate) ensemble: Ensemble,
    pub(crate) plausibility: Plausibility,
    /// Frames back that a gradient reaches; 0 for all of them.
    pub(crate) reach: usize,
    /// Instances of one part of the reply.
    pub(crate) part: usize,
    /// Instances prepared together.
    pub(crate) prepared: usize,
    /// Memory of the surroundings, if a session keeps them.
    pub(crate) kept: Option<Arc<Share>>,
}

impl Plan {
    /// Reads a request, whose memory has been taken, and loads the models that it needs on a
    /// backend; also returns the initial state that it asks for.
    ///
    /// # Errors
    /// If a part of it cannot be read or does not go with another, or the backend fails.
    pub fn new(
        checked: Checked,
        backend: &dyn Backend,
        cancel: &CancelToken,
    ) -> Result<(Self, Wanted), Error> {
        let Checked { mut request, batch, mut served, part_instances, prepared, .. } = checked;
        if let Some(planner) = &served.planner {
            served.loaded = planner.own.rewrite(&mut request)?;
        }
        let twin = &served.warm.twin;
        let graph = &twin.graph;
        let (instances, frames) = (batch.instances as usize, batch.frames as usize);
        let fps = twin.timing.fps;
        let horizon = Horizon { frames, fps, times: request.knot_times.take() };
        let map = gripper_of_control(request.actions.as_ref(), graph.control_count())?;
        let actions = Actions::read(request.actions.take(), graph.control_count(), horizon)?
            .with_clamps(graph)
            .with_hands(&twin.hands());
        let grasps = request.grasps.len();
        let surroundings =
            Surroundings::read(&mut request, &actions, map, twin, served.loaded.model())?;
        let on_fits = request.vary.as_ref().is_some_and(|vary| vary.fits);
        let ensemble = Ensemble::read(request.ensemble, on_fits.then(|| twin.fit_weights()));
        let members = ensemble.members;
        let fits = match on_fits {
            true => served.fits(members, backend)?,
            false => Vec::new(),
        };
        let base = Base { loaded: &served.loaded, fits: &fits, rests: &served.rests, members };
        let variants = Variants::load(request.vary, &base, &surroundings, backend, cancel)?;
        let newtons = twin.newtons_per_unit();
        let context = Context { frames, fps, newtons, surroundings: &surroundings };
        let costs = Costs::read(request.costs, &context)?;
        let returns = Returns::read(request.returns, twin, instances)?;
        let wanted = Wanted::read(request.initial, graph, instances)?;

        let part = if part_instances == 0 { instances } else { part_instances as usize };
        let part = part.min(instances);
        let plan = Self {
            actions,
            frames,
            costs,
            returns,
            grasps,
            surroundings,
            variants,
            ensemble,
            plausibility: Plausibility::read(request.plausibility),
            reach: request.gradient.map_or(0, |gradient| gradient.reach_frames as usize),
            part,
            prepared,
            kept: None,
            served,
        };
        Ok((plan, wanted))
    }

    /// The states that instances begin in: those of a session or of a simulation that came before, if
    /// there was one, and otherwise what the request gives.
    ///
    /// # Errors
    /// If there is neither, or the planner's twin answers and cannot begin in them.
    pub fn starts(&self, wanted: Wanted, before: Option<Starts>) -> Result<Starts, Error> {
        match (before, wanted) {
            // They are the exact twin's.
            (Some(starts), _) => match &self.served.planner {
                None => Ok(starts),
                Some(planner) => planner.own.thinned(starts),
            },
            (None, Wanted::Ready(starts)) => Ok(starts),
            (None, Wanted::Simulation) => Err(Error::field("initial", "has no state")),
        }
    }

    /// Memory of the surroundings, which a session keeps with a final state [bytes].
    pub fn surroundings_bytes(&self) -> u64 {
        self.surroundings.bytes()
    }

    /// Lets final states hold the memory that was taken for their surroundings.
    pub fn keep_surroundings(&mut self, share: Share) {
        self.kept = Some(Arc::new(share));
    }

    /// Horizon F [frames].
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// The twin that is simulated.
    pub(crate) fn twin(&self) -> &Twin {
        &self.served.warm.twin
    }

    /// Number of nodes of the twin that the request is about.
    pub(crate) fn nodes(&self) -> usize {
        self.served.twin().graph.node_count()
    }

    /// The number of a simulated node in that twin.
    pub(crate) fn node(&self, simulated: usize) -> usize {
        let planner = self.served.planner.as_ref();
        planner.map_or(simulated, |planner| planner.own.node(simulated))
    }

    /// A state of that twin, of a simulated one.
    pub(crate) fn carried(&self, state: &State) -> State {
        match &self.served.planner {
            None => state.clone(),
            Some(planner) => planner.own.carried(state),
        }
    }

    /// Values of the nodes of that twin, of those of simulated ones: zero where nothing is simulated.
    pub(crate) fn spread(&self, simulated: &[Point]) -> Vec<Point> {
        match &self.served.planner {
            None => simulated.to_vec(),
            Some(planner) => planner.own.spread(simulated),
        }
    }

    /// Number of actions B.
    pub(crate) fn actions(&self) -> usize {
        self.actions.shape().instances
    }

    /// The action of an instance.
    pub(crate) fn action(&self, instance: usize) -> usize {
        instance / self.ensemble.members
    }

    /// The instances of actions: all members of each.
    pub(crate) fn instances(&self, actions: impl Iterator<Item = usize>) -> Vec<usize> {
        let members = self.ensemble.members;
        actions.flat_map(|action| action * members..(action + 1) * members).collect()
    }

    /// An instance whose objective has the gradient of the costs.
    pub(crate) fn instance(&self, index: usize, starts: &Starts) -> Instance {
        let objective = self.costs.objective(self.action(index));
        let objective = self.variant(index).objective(&objective);
        Instance { objective, ..self.stopped_instance(index, starts).0 }
    }

    /// An instance whose objective measures costs and conditions, and how far its hands are held back at
    /// the ground.
    pub(crate) fn stopped_instance(&self, index: usize, starts: &Starts) -> (Instance, Stops) {
        let variant = self.variant(index);
        let action = self.action(index);
        let start = starts.of(action);
        let mut controls: Vec<Point> = self.actions.controls(action, start.commanded());
        let rods = self.twin().graph.rods.len();
        let kept = self.returns.action_gradients;
        let rolls = self.actions.rolls(action, &controls, rods, kept);
        let mut motion = Motion { rolls, ..self.surroundings.motion(action, &self.actions) };
        let stops = match variant.loaded.model().environment.ground {
            None => Stops::default(),
            Some(plane) => {
                let floor = Floor {
                    plane,
                    allowed_m: self.plausibility.allowed_depth_m(),
                    graph: &self.twin().graph,
                    own: self.twin().environment.ground,
                    start,
                    middles: self.surroundings.places(),
                };
                self.actions.stop(&mut controls, &mut motion.poses, &floor)
            }
        };
        let instance = Instance {
            model: variant.loaded.clone(),
            initial: Arc::clone(&start.state),
            controls: Arc::new(controls),
            frames: self.frames,
            objective: variant.objective(&self.costs.scored(action)),
            world: Arc::clone(&variant.world),
            motion: Arc::new(motion),
        };
        (instance, stops)
    }

    /// An instance whose objective has the gradient of the costs at its rollout, soft minima included.
    pub(crate) fn tangent(&self, index: usize, starts: &Starts, at: &Rollout) -> Instance {
        let objective = self.costs.tangent(self.action(index), at);
        let objective = self.variant(index).objective(&objective);
        Instance { objective, ..self.stopped_instance(index, starts).0 }
    }

    /// Model and world of an instance.
    pub(crate) fn variant(&self, index: usize) -> &Variant {
        self.variants.of(index)
    }

    /// Places where grippers would have the control points at the end of an instance, did the
    /// ground not hold them back [m], shape [C]; `None` without grippers.
    pub(crate) fn commanded(&self, index: usize, starts: &Starts) -> Option<Vec<Point>> {
        if self.actions.grippers() == 0 {
            return None;
        }
        let action = self.action(index);
        let start = starts.of(action).commanded();
        let path = self.actions.controls(action, start);
        Some(path[self.frames * start.len()..].to_vec())
    }

    /// Surroundings in which an instance ends.
    pub(crate) fn ended(&self, index: usize, starts: &Starts) -> Ended {
        let variant = self.variant(index);
        let model = variant.loaded.model();
        let motion = self.instance(index, starts).motion;
        Ended::new(
            Arc::clone(&variant.world),
            model.environment,
            (&motion, model.timing.frame_s()),
            self.surroundings.grippers(),
            self.kept.clone(),
        )
    }

    /// Newtons per unit of the engine's forces, and joules per unit of its energies, in an instance.
    pub(crate) fn force_unit(&self, index: usize) -> f32 {
        self.twin().newtons_per_unit() as f32 * self.variant(index).mass
    }

    /// True if forces of grasps are measured because there is a limit.
    pub(crate) fn limits_grasp_force(&self) -> bool {
        self.grasps > 0 && self.plausibility.limits_grasp_force()
    }

    /// Takes the forces of the grasps of an instance, over the frames after the first `from`, into its
    /// extremes, if there is a limit.
    pub(crate) fn see_forces(
        &self,
        index: usize,
        rollout: &Rollout,
        from: usize,
        extremes: &mut Extremes,
    ) {
        if let Some(forces) = rollout.forces.as_ref().filter(|_| self.limits_grasp_force()) {
            extremes.see_forces(&forces.grasps, self.grasps, from, self.force_unit(index));
        }
    }

    /// Extremes of what is prescribed to an instance, whose hands were `stopped`; `end` is its last
    /// state, if that is known.
    pub(crate) fn extremes(
        &self,
        index: usize,
        (instance, stopped): (&Instance, Stopped),
        starts: &Starts,
        end: Option<&State>,
    ) -> Extremes {
        let start = starts.of(self.action(index));
        let controls = &instance.controls;
        let first = &controls[..controls.len() / (self.frames + 1)];
        let model = instance.model.model();
        let obstacles = self.surroundings.obstacles(&model.environment);
        let middles = self.surroundings.middles(&instance.motion);
        let held = self.surroundings.held_paths(instance, end);
        let of = Prescribed { start: start.here(), controls, middles: &middles, held: &held };
        // Where control points are not known, what nodes say of them is not exact.
        let slack = if start.likely.is_some() { UNKNOWN_SLACK_M } else { 0.0 };
        let gap = (start.gap_m(first) - slack).max(0.0);
        plausible::extremes(gap, of, self.frames, model.timing.fps, &obstacles)
            .with(stopped, self.plausibility.allowed_depth_m())
    }
}

/// Facts of a twin that requests are checked against.
pub fn shape(twin: &Twin, has_capture: bool) -> TwinShape {
    let graph = &twin.graph;
    TwinShape {
        nodes: graph.node_count() as u64,
        springs: graph.springs.len() as u64,
        triplets: graph.triplets.len() as u64,
        controls: graph.control_count() as u64,
        skin_points: Some(twin.skin.len() as u64),
        rods: Some(graph.rods.len() as u64),
        substeps: twin.timing.substeps,
        fast_substeps: twin.quality.fast.map(|fast| fast.substeps),
        planner: twin.quality.planner.map(|planner| PlannerShape {
            nodes: planner.nodes.into(),
            springs: planner.springs.into(),
            triplets: planner.triplets.into(),
            substeps: planner.substeps,
        }),
        has_capture,
    }
}
