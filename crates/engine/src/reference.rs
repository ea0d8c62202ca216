//! The simulation in `f64`, with parameters in `f64`: the standard for other results, and the
//! function that finite differences perturb.

use bendtwin_core::CancelToken;

pub use crate::cpu::parameters::Parameters;
use crate::{
    Model, Objective, Term,
    backend::{Error, Loss},
    cpu::{
        arithmetic::{Node, Quad},
        check,
        gradient::gradient,
        rollout::{Simulation, losses},
        surroundings::{Surroundings, grasp::Hands},
        system::{Layout, System},
    },
    objective::WeightedTerm,
    world::{Grasping, Motion, World},
};

/// A point or vector in double precision.
pub type Point64 = [f64; 3];

/// A [`Pose`](crate::world::Pose) in double precision.
pub type Pose64 = [[f64; 4]; 3];

/// A simulation in double precision. Fields may be changed at will; lengths must not change.
///
/// What runs it is `#[inline]`, so that the kernels are compiled in `f64` only by crates that use
/// it, which are tests.
#[derive(Clone, Debug)]
pub struct Reference {
    model: Model,
    /// Parameters; start as the model's.
    pub parameters: Parameters<f64>,
    /// Initial positions [m], shape [N, 3]; start at rest.
    pub positions: Vec<Point64>,
    /// Initial velocities [m/s], shape [N, 3]; start at zero.
    pub velocities: Vec<Point64>,
    /// Initial twists [rad], shape [R]; start at zero.
    pub twists: Vec<f64>,
    /// Control positions at frame boundaries [m], shape [F + 1, C, 3]; start at rest.
    pub controls: Vec<Point64>,
    /// Surroundings of the object; none at first.
    pub world: World,
    /// Poses of bodies at frame boundaries, shape [F + 1, B].
    pub poses: Vec<Pose64>,
    /// See [`crate::Motion::closed`], shape [F, G].
    pub closed: Vec<bool>,
    /// See [`crate::Motion::rolls`] [rad], shape [F + 1, R, 2], or empty.
    pub rolls: Vec<f64>,
    /// Holds of grasps at the start; none at first.
    pub grasping: Grasping,
    /// Places of the holds of `grasping` [m], which replace theirs.
    pub places: Vec<Point64>,
    frames: usize,
}

/// Positions and velocities of all nodes, and twists of all rods, in double precision.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceState {
    /// Positions [m], shape [N, 3].
    pub positions: Vec<Point64>,
    /// Velocities [m/s], shape [N, 3].
    pub velocities: Vec<Point64>,
    /// Twists [rad], shape [R].
    pub twists: Vec<f64>,
}

/// Loss and gradient in double precision.
#[derive(Clone, Debug)]
pub struct ReferenceGradient {
    /// The loss.
    pub loss: Loss,
    /// Gradient by parameter.
    pub parameters: Parameters<f64>,
    /// Gradient by initial position, shape [N, 3].
    pub positions: Vec<Point64>,
    /// Gradient by initial velocity, shape [N, 3].
    pub velocities: Vec<Point64>,
    /// Gradient by initial twist, shape [R].
    pub twists: Vec<f64>,
    /// Gradient by control position, shape [F + 1, C, 3].
    pub controls: Vec<Point64>,
    /// Gradient by pose, shape [F + 1, B].
    pub poses: Vec<Pose64>,
    /// Gradient by roll, shape as in [`Reference`].
    pub rolls: Vec<f64>,
    /// Gradient by place of the initial holds.
    pub places: Vec<Point64>,
    /// Norms at frame boundaries, as in [`crate::backend::Gradient`], shape [F + 1].
    pub norms: Vec<f64>,
}

impl Reference {
    /// A model at rest, with the given number of frames to run.
    ///
    /// # Errors
    /// If the model contradicts itself.
    pub fn new(model: &Model, frames: usize) -> Result<Self, Error> {
        check::model(model)?;
        let wide = |p: &[f32; 3]| p.map(f64::from);
        let rest: Vec<Point64> = model.graph.rest_positions.iter().map(wide).collect();
        let held: Vec<Point64> = model.graph.control_rest.iter().map(wide).collect();
        Ok(Self {
            parameters: Parameters::from_params(&model.params),
            velocities: vec![[0.0; 3]; rest.len()],
            positions: rest,
            twists: vec![0.0; model.graph.rods.len()],
            controls: held.repeat(frames + 1),
            world: World::default(),
            poses: Vec::new(),
            closed: Vec::new(),
            rolls: Vec::new(),
            grasping: Grasping::default(),
            places: Vec::new(),
            model: model.clone(),
            frames,
        })
    }

    /// The state at every frame's end, the initial one first: F + 1 of them, fewer if it diverges.
    ///
    /// # Errors
    /// If a length or the objective does not fit.
    #[inline]
    pub fn roll_out(&self) -> Result<Vec<ReferenceState>, Error> {
        let objective = Objective::default();
        let mut states = Vec::new();
        self.with_simulation(&objective, |simulation| {
            simulation.run(&CancelToken::default(), |_, now| {
                let nodes = &now.nodes[..simulation.system.nodes];
                states.push(ReferenceState {
                    positions: nodes.iter().map(|n| point(n.x)).collect(),
                    velocities: nodes.iter().map(|n| point(n.v)).collect(),
                    twists: now.twists.clone(),
                });
            })
        })?;
        Ok(states)
    }

    /// The loss.
    ///
    /// # Errors
    /// If a length or the objective does not fit.
    #[inline]
    pub fn loss(&self, objective: &Objective) -> Result<Loss, Error> {
        self.with_simulation(objective, |simulation| losses(simulation, &CancelToken::default()))
    }

    /// Loss and gradient, `cut_every` as in [`crate::backend::GradientRequest`].
    ///
    /// # Errors
    /// If a length or the objective does not fit.
    #[inline]
    pub fn gradient(
        &self,
        objective: &Objective,
        cut_every: usize,
    ) -> Result<ReferenceGradient, Error> {
        let g = self.with_simulation(objective, |simulation| {
            gradient(simulation, cut_every, &CancelToken::default())
        })?;
        Ok(ReferenceGradient {
            loss: g.loss,
            parameters: g.parameters,
            positions: g.initial.iter().map(|n| point(n.x)).collect(),
            velocities: g.initial.iter().map(|n| point(n.v)).collect(),
            twists: g.initial_twists,
            controls: g.controls.into_iter().map(point).collect(),
            poses: g.poses,
            rolls: g.rolls,
            places: g.initial_hands.holds.iter().map(|h| point(h.place)).collect(),
            norms: g.norms,
        })
    }

    /// Surroundings of the object, if any.
    fn surroundings(&self, objective: &Objective) -> Option<Surroundings<f64>> {
        let in_cost = |t: &WeightedTerm| matches!(t.term, Term::Force { .. });
        let measured = objective.terms.iter().any(in_cost);
        if self.world == World::default() && self.rolls.is_empty() && !measured {
            return None;
        }
        let mut start = Hands::new(&self.grasping, &self.world.grasps);
        for (hold, place) in start.holds.iter_mut().zip(&self.places) {
            hold.place = quad(*place);
        }
        let motion = Motion { closed: self.closed.clone(), ..Motion::default() };
        let mut surroundings = Surroundings::new(&self.world, &motion, start, measured);
        surroundings.poses.clone_from(&self.poses);
        surroundings.rolls.clone_from(&self.rolls);
        Some(surroundings)
    }

    fn with_simulation<R>(
        &self,
        objective: &Objective,
        work: impl FnOnce(&Simulation<'_, f64>) -> Result<R, Error>,
    ) -> Result<R, Error> {
        let graph = &self.model.graph;
        let (n, c, p) = (graph.node_count(), graph.control_count(), &self.parameters);
        let (e, t, r) = (graph.springs.len(), graph.triplets.len(), graph.rods.len());
        let springs = [&p.spring_stiffness, &p.spring_dashpot, &p.rest_lengths_m];
        let triplets = [&p.bend_stiffness, &p.bend_damping, &p.rest_angles_rad];
        let rods = [&p.twist_stiffness, &p.twist_damping, &p.rest_twists_rad, &self.twists];
        let fits = self.positions.len() == n
            && self.velocities.len() == n
            && self.controls.len() == (self.frames + 1) * c
            && springs.iter().all(|v| v.len() == e)
            && triplets.iter().all(|v| v.len() == t)
            && rods.iter().all(|v| v.len() == r)
            && self.poses.len() == (self.frames + 1) * self.world.bodies
            && self.closed.len() == self.frames * self.world.grasps.len()
            && [0, 2 * (self.frames + 1) * r].contains(&self.rolls.len())
            && self.places.len() == self.grasping.holds.len();
        if !fits {
            return Err(Error::InvalidInput("a length of the reference was changed".into()));
        }
        let counts = [n, self.model.skin.len()];
        check::objective(objective, self.frames, counts).map_err(Error::InvalidInput)?;
        let terms = check::surroundings::terms(objective, &self.world, c);
        terms.map_err(Error::InvalidInput)?;
        let system = System::new(&self.model, &Layout::new(graph), p.clone());
        let both = self.positions.iter().zip(&self.velocities);
        work(&Simulation {
            surroundings: self.surroundings(objective),
            system: &system,
            initial: both.map(|(&x, &v)| Node { x: quad(x), v: quad(v) }).collect(),
            twists: self.twists.clone(),
            controls: self.controls.iter().map(|&p| quad(p)).collect(),
            frames: self.frames,
            objective,
        })
    }
}

fn quad(p: Point64) -> Quad<f64> {
    [p[0], p[1], p[2], 0.0]
}

fn point(q: Quad<f64>) -> Point64 {
    [q[0], q[1], q[2]]
}

#[cfg(test)]
mod tests;
