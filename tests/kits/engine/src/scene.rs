//! A small scene, written by hand: a model, how it starts, what drives it.

use std::sync::Arc;

use bendtwin_core::{
    CancelToken, Contact, Environment, Graph, NodeKind, Params, Pin, Plane, Point, Skin, Timing,
    environment::ControlVelocity,
};
use bendtwin_engine::{
    Backend, Error, Loaded, Model, Objective, PointLoss, PointSet, Term,
    backend::{Diagnose, Forces, Gradient, GradientRequest, Instance, Loss, Outputs, Rollout},
    model::State,
    objective::WeightedTerm,
    world::{Face, Grasp, Motion, Pose, Shape, World},
};
use bendtwin_graph::{NodeSample, rest_geometry};

/// Nodes of mass 1 in empty space: no gravity, ground, drag or contact until asked for.
#[derive(Clone, Debug)]
pub(crate) struct Scene {
    pub(crate) graph: Graph,
    pub(crate) skin: Skin,
    pub(crate) params: Params,
    pub(crate) environment: Environment,
    pub(crate) timing: Timing,
    pub(crate) control_velocity: ControlVelocity,
    pub(crate) initial: State,
    /// Control points, shape [F + 1, C, 3].
    pub(crate) controls: Vec<Point>,
    pub(crate) frames: usize,
    pub(crate) objective: Objective,
    pub(crate) world: World,
    pub(crate) motion: Motion,
}

impl Scene {
    /// Nodes at rest at these positions; 100 frames a second, 20 substeps each.
    pub(crate) fn of(positions: &[Point]) -> Self {
        let n = positions.len();
        let graph = Graph {
            rest_positions: positions.to_vec(),
            kinds: vec![NodeKind::Observed; n],
            masses: vec![1.0; n],
            object_ids: vec![0; n],
            observed_points: (0..n as u32).collect(),
            ..Graph::default()
        };
        let contact =
            Contact { between_objects: false, within_object: false, ..Contact::default() };
        Self {
            initial: State::rest(&graph),
            skin: Skin::default(),
            graph,
            params: Params { contact, ..Params::default() },
            environment: Environment { gravity: [0.0; 3], ground: None },
            timing: Timing { fps: 100.0, substeps: 20 },
            control_velocity: ControlVelocity::True,
            controls: Vec::new(),
            frames: 1,
            objective: Objective::default(),
            world: World::default(),
            motion: Motion::default(),
        }
    }

    /// A scene around a finished model.
    pub(crate) fn around(
        model: Model,
        initial: State,
        controls: Vec<Point>,
        frames: usize,
    ) -> Self {
        Self {
            graph: (*model.graph).clone(),
            skin: (*model.skin).clone(),
            params: model.params,
            environment: model.environment,
            timing: model.timing,
            control_velocity: model.control_velocity,
            initial,
            controls,
            frames,
            objective: Objective::default(),
            world: World::default(),
            motion: Motion::default(),
        }
    }

    /// Adds a spring whose rest length is the rest positions' distance.
    pub(crate) fn spring(&mut self, ends: [u32; 2], stiffness: f32, dashpot: f32) {
        let (a, b) = (self.graph.rest_endpoint(ends[0]), self.graph.rest_endpoint(ends[1]));
        let squared: f32 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
        self.graph.springs.push(ends);
        self.params.rest_lengths_m.push(squared.sqrt());
        self.params.spring_stiffness.push(stiffness);
        self.params.spring_dashpot.push(dashpot);
    }

    /// Adds a triplet with the given rest angle.
    pub(crate) fn triplet(
        &mut self,
        ends: [u32; 3],
        rest_angle: f32,
        stiffness: f32,
        damping: f32,
    ) {
        self.graph.triplets.push(ends);
        self.params.rest_angles_rad.push(rest_angle);
        self.params.bend_stiffness.push(stiffness);
        self.params.bend_damping.push(damping);
    }

    /// Adds a rod along these nodes.
    pub(crate) fn rod(&mut self, path: Vec<u32>, stiffness: f32, damping: f32, rest_twist: f32) {
        self.graph.rods.push(path);
        self.params.twist_stiffness.push(stiffness);
        self.params.twist_damping.push(damping);
        self.params.rest_twists_rad.push(rest_twist);
        self.initial.twists.push(0.0);
    }

    /// Adds a control point, resting where it is until driven; returns its endpoint.
    pub(crate) fn control(&mut self, at: Point) -> u32 {
        self.graph.control_rest.push(at);
        (self.graph.node_count() + self.graph.control_count() - 1) as u32
    }

    /// Pins a node to control point `control` at their present offset.
    pub(crate) fn pin(&mut self, node: u32, control: u32) {
        let (x, c) =
            (self.graph.rest_positions[node as usize], self.graph.control_rest[control as usize]);
        let offset_m = [x[0] - c[0], x[1] - c[1], x[2] - c[2]];
        self.graph.pins.push(Pin { node, control, offset_m });
    }

    /// Pins a node where it is.
    pub(crate) fn fix(&mut self, node: u32) {
        let at = self.graph.rest_positions[node as usize];
        let control = self.control(at) - self.graph.node_count() as u32;
        self.pin(node, control);
    }

    /// Runs for `frames`, control points displaced by `path(frame)`.
    pub(crate) fn drive(&mut self, frames: usize, path: impl Fn(usize) -> Point) {
        self.frames = frames;
        self.controls = (0..=frames)
            .flat_map(|f| {
                let d = path(f);
                self.graph.control_rest.iter().map(move |c| [c[0] + d[0], c[1] + d[1], c[2] + d[2]])
            })
            .collect();
    }

    /// Runs for `frames`, control points resting.
    pub(crate) fn last(&mut self, frames: usize) {
        self.drive(frames, |_| [0.0; 3]);
    }

    /// Has nodes at targets [m] in the last frame: the only term of the objective.
    pub(crate) fn track(&mut self, points: Vec<u32>, targets: Vec<Point>) {
        let (of, loss) = (PointSet::Nodes, PointLoss::SquaredDistance);
        let term = Term::Track { of, points, targets, loss };
        self.objective.groups = vec!["track".into()];
        self.objective.terms =
            Arc::new(vec![WeightedTerm { frame: self.frames, weight: 1.0, group: 0, term }]);
    }

    /// [`Scene::track`] for all nodes, with targets along x and down.
    pub(crate) fn track_all(&mut self) {
        let rest = self.graph.rest_positions.iter();
        let targets = rest.map(|p| [p[0] + 0.08, p[1], p[2] - 0.05]).collect();
        self.track((0..self.graph.node_count() as u32).collect(), targets);
    }

    pub(crate) fn ground(&mut self, normal: Point, offset_m: f32, restitution: f32, friction: f32) {
        self.environment.ground = Some(Plane { normal, offset_m });
        self.params.contact.ground_restitution = restitution;
        self.params.contact.ground_friction = friction;
    }

    /// Rest lengths and angles as the rest positions have them.
    pub(crate) fn relax(&mut self) {
        let sample = NodeSample {
            positions: self.graph.rest_positions.clone(),
            kinds: self.graph.kinds.clone(),
            observed_points: self.graph.observed_points.clone(),
            object_ids: self.graph.object_ids.clone(),
            control_rest: self.graph.control_rest.clone(),
            pins: self.graph.pins.clone(),
            edges: None,
            rest_shape: None,
            point_spacing_m: 0.0,
            spacing_scale: 1.0,
            surface: Default::default(),
            left_out: Default::default(),
        };
        (self.params.rest_lengths_m, self.params.rest_angles_rad) =
            rest_geometry(&self.graph, &sample);
    }

    pub(crate) fn model(&self) -> Model {
        Model {
            graph: Arc::new(self.graph.clone()),
            skin: Arc::new(self.skin.clone()),
            params: self.params.clone(),
            environment: self.environment,
            timing: self.timing,
            control_velocity: self.control_velocity,
        }
    }

    pub(crate) fn load(&self, backend: &dyn Backend) -> Result<Loaded, String> {
        backend.load(Arc::new(self.model())).map_err(|e| format!("load: {e}"))
    }

    /// Raises the substeps to what the backend asks for, where it refuses the present number.
    pub(crate) fn stabilise(&mut self, backend: &dyn Backend) -> Result<(), String> {
        match backend.load(Arc::new(self.model())) {
            Err(Error::Unstable { needed, .. }) => {
                // Room for stretched states, which are stiffer than the rest shape.
                self.timing.substeps = needed.saturating_mul(2);
                self.load(backend).map(drop)
            }
            other => other.map(drop).map_err(|e| format!("load: {e}")),
        }
    }

    pub(crate) fn instance(&self, model: Loaded) -> Instance {
        Instance {
            model,
            initial: Arc::new(self.initial.clone()),
            controls: Arc::new(self.controls.clone()),
            frames: self.frames,
            objective: self.objective.clone(),
            world: Arc::new(self.world.clone()),
            motion: Arc::new(self.motion.clone()),
        }
    }

    /// Rolls out alone: every frame, the initial one too, final state and diagnostics.
    pub(crate) fn roll_out(&self, backend: &dyn Backend) -> Result<Rollout, String> {
        let outputs = Outputs {
            every: 1,
            initial: true,
            nodes: None,
            final_state: true,
            diagnose: Diagnose::All,
            velocities: true,
            ..Outputs::default()
        };
        let rollout = self.roll_out_raw(backend, &outputs)?;
        match rollout.diverged {
            None => Ok(rollout),
            Some(d) => Err(format!("diverged in frame {} at node {}", d.frame, d.node)),
        }
    }

    pub(crate) fn roll_out_raw(
        &self,
        backend: &dyn Backend,
        outputs: &Outputs,
    ) -> Result<Rollout, String> {
        let batch = [self.instance(self.load(backend)?)];
        let rollouts = backend.roll_out(&batch, outputs, &CancelToken::default());
        only(rollouts.map_err(|e| format!("roll_out: {e}"))?)
    }

    /// State after the last frame.
    pub(crate) fn end(&self, backend: &dyn Backend) -> Result<State, String> {
        self.roll_out(backend)?.final_state.ok_or_else(|| "no final state came back".to_owned())
    }

    /// States after each frame, the initial one first. Restarts every frame, as velocities are
    /// returned for the last frame only.
    pub(crate) fn states(&self, backend: &dyn Backend) -> Result<Vec<State>, String> {
        let outputs = Outputs { final_state: true, ..Outputs::default() };
        let loaded = self.load(backend)?;
        let c = self.graph.control_count();
        let mut states = vec![self.initial.clone()];
        for frame in 0..self.frames {
            let mut step = self.instance(loaded.clone());
            step.frames = 1;
            step.objective = Objective::default();
            step.controls = Arc::new(self.controls[frame * c..(frame + 2) * c].to_vec());
            step.motion = Arc::new(self.motion_of(frame, 1));
            step.initial = Arc::new(states[frame].clone());
            let rollouts = backend.roll_out(&[step], &outputs, &CancelToken::default());
            let rollout = only(rollouts.map_err(|e| format!("roll_out: {e}"))?)?;
            match (rollout.final_state, rollout.diverged) {
                (Some(state), None) => states.push(state),
                (_, diverged) => return Err(format!("frame {}: {diverged:?}", frame + 1)),
            }
        }
        Ok(states)
    }

    /// The motion of the surroundings in some frames, from this one on.
    pub(crate) fn motion_of(&self, frame: usize, frames: usize) -> Motion {
        let rows = |each: usize| frame * each..(frame + frames + 1) * each;
        let (b, g, r) = (self.world.bodies, self.world.grasps.len(), self.graph.rods.len());
        let Motion { poses, closed, rolls } = &self.motion;
        Motion {
            poses: poses[rows(b)].to_vec(),
            closed: closed[frame * g..(frame + frames) * g].to_vec(),
            rolls: if rolls.is_empty() { Vec::new() } else { rolls[rows(2 * r)].to_vec() },
        }
    }

    /// Adds a body at these poses, one a frame boundary; returns its number.
    pub(crate) fn body(&mut self, path: impl Fn(usize) -> Pose) -> u32 {
        let bodies = self.world.bodies;
        let old = std::mem::take(&mut self.motion.poses);
        for f in 0..=self.frames {
            self.motion.poses.extend_from_slice(&old[f * bodies..(f + 1) * bodies]);
            self.motion.poses.push(path(f));
        }
        self.world.bodies += 1;
        bodies as u32
    }

    /// Adds a grasp that is closed in these frames.
    pub(crate) fn grasp(&mut self, grasp: Grasp, closed: impl Fn(usize) -> bool) {
        let grasps = self.world.grasps.len();
        let old = std::mem::take(&mut self.motion.closed);
        for f in 0..self.frames {
            self.motion.closed.extend_from_slice(&old[f * grasps..(f + 1) * grasps]);
            self.motion.closed.push(closed(f));
        }
        self.world.grasps.push(grasp);
    }

    /// Every frame's forces.
    pub(crate) fn forces(&self, backend: &dyn Backend) -> Result<Forces, String> {
        let outputs = Outputs { forces: true, ..Outputs::NONE };
        let rollout = self.roll_out_raw(backend, &outputs)?;
        rollout.forces.ok_or_else(|| "no forces came back".to_owned())
    }

    pub(crate) fn loss(&self, backend: &dyn Backend) -> Result<Loss, String> {
        let batch = [self.instance(self.load(backend)?)];
        only(backend.losses(&batch, &CancelToken::default()).map_err(|e| format!("losses: {e}"))?)
    }

    pub(crate) fn gradient(
        &self,
        backend: &dyn Backend,
        request: &GradientRequest,
    ) -> Result<Gradient, String> {
        let batch = [self.instance(self.load(backend)?)];
        let gradients = backend.gradients(&batch, request, &CancelToken::default());
        only(gradients.map_err(|e| format!("gradients: {e}"))?)
    }

    pub(crate) fn dt(&self) -> f64 {
        self.timing.dt_s()
    }
}

/// The pose of a body that is shifted and turned about z.
pub(crate) fn pose(at: [f64; 3], about_z: f64) -> Pose {
    let (s, c) = about_z.sin_cos();
    let rows = [[c, -s, 0.0, at[0]], [s, c, 0.0, at[1]], [0.0, 0.0, 1.0, at[2]]];
    rows.map(|row| row.map(|x| x as f32))
}

/// A box around the origin with these half sides.
pub(crate) fn cuboid(half: Point) -> Shape {
    let face = |c: usize, sign: f32| Face {
        normal: std::array::from_fn(|i| if i == c { sign } else { 0.0 }),
        offset_m: half[c],
    };
    Shape::Convex(Arc::new((0..3).flat_map(|c| [face(c, 1.0), face(c, -1.0)]).collect()))
}

/// The one result of a batch of one.
pub(crate) fn only<T>(results: Vec<T>) -> Result<T, String> {
    let count = results.len();
    let mut results = results.into_iter();
    match (results.next(), results.next()) {
        (Some(one), None) => Ok(one),
        _ => Err(format!("{count} results for a batch of one")),
    }
}

/// `a - b` in double precision.
pub(crate) fn difference(a: Point, b: Point) -> [f64; 3] {
    [0, 1, 2].map(|i| f64::from(a[i]) - f64::from(b[i]))
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}
