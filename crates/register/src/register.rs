//! Registration: from points of an object that stands somewhere to a state of its twin. A rigid
//! motion first, then an elastic deformation that softens, then frames of the twin's own physics
//! during which the points keep pulling, so that the state is one that the twin can be in.

use std::sync::Arc;

use bendtwin_core::{
    CancelToken, Graph, Point, Skin,
    geometry::{Pair, RigidMotion, point, vector3},
};
use bendtwin_engine::{
    Backend, Loaded, Objective,
    backend::{Instance, Outputs},
    model::State,
};
use nalgebra::Vector3;

use crate::{
    Error, Explained, Observation, Residual,
    correct::check,
    elastic::Elastic,
    observation::is_place,
    residual::share_within,
    rigid::{Target, of_tracks, thinned},
    seen::{MatchedSkin, Seen, node_spacing, position},
    surface::Surface,
    visible::visible,
};

/// Fewest points of a cloud: fewer fit anywhere.
const LEAST_CLOUD: usize = 10;
/// Points with which candidates are deformed, and the best of them.
const TRIED: usize = 300;
const USED: usize = 4000;
/// Steps in which the deformation softens: `give` by these.
const SOFTENING: [f64; 4] = [0.1, 0.25, 0.5, 1.0];
/// Rounds of matching in each step, and iterations of the deformation in each round.
const ROUNDS: usize = 6;
const ITERATIONS: usize = 3;

/// Options of [`register`].
#[derive(Clone, Debug, PartialEq)]
pub struct RegisterOptions {
    /// Shape to start from and its control points; `None` is the rest shape.
    pub initial: Option<(State, Vec<Point>)>,
    /// Positions of the control points that are known, say of the gripper [m], shape [C]; empty if
    /// they go where the nodes go that they hold.
    pub controls: Vec<Point>,
    /// True if the start is near already, so that no other pose is tried.
    pub near: bool,
    /// Deviation of an observed point from the surface [m].
    pub noise_m: f64,
    /// Deviation of a spring by its length.
    pub give: f64,
    /// Frames of physics under the pull of the points; 0 leaves the shape as the points have it.
    pub settle_frames: usize,
    /// Largest median residual, beyond which the registration is refused [m]; `None` is half the
    /// distance between neighbouring nodes, or 5 mm if that is more.
    pub max_residual_m: Option<f64>,
    /// Least share of the points that must be explained, 0..=1.
    pub least_explained: f64,
}

impl Default for RegisterOptions {
    fn default() -> Self {
        Self {
            initial: None,
            controls: Vec::new(),
            near: false,
            noise_m: 0.004,
            give: 0.1,
            settle_frames: 12,
            max_residual_m: None,
            least_explained: 0.5,
        }
    }
}

/// A registered state.
#[derive(Clone, Debug, PartialEq)]
pub struct Registered {
    /// The state, at rest.
    pub state: State,
    /// Control points [m], shape [C, 3].
    pub controls: Vec<Point>,
    /// Distances of the observed points from the start.
    pub before: Residual,
    /// Distances of the observed points.
    pub residual: Residual,
    /// Shares that explain each other.
    pub explained: Explained,
    /// The rigid part of the motion from the start.
    pub rigid: RigidMotion,
    /// Mean distance by which the nodes move in a frame when the points stop pulling: how far the
    /// state is from force balance [mm].
    pub drift_mm: f64,
}

/// Registers an observation to a twin.
///
/// # Errors
/// If the input does not fit the model, if the twin does not explain the points, on cancellation, or
/// if the backend fails.
pub fn register(
    backend: &dyn Backend,
    loaded: &Loaded,
    observation: &Observation,
    options: &RegisterOptions,
    cancel: &CancelToken,
) -> Result<Registered, Error> {
    let model = loaded.model();
    let graph = &*model.graph;
    observation.check(graph)?;
    let (start, start_controls) = match &options.initial {
        Some((state, controls)) => (state.clone(), controls.clone()),
        None => (State::rest(graph), graph.control_rest.clone()),
    };
    check(graph, &start, &start_controls)?;
    options.check(graph)?;
    check_cloud(observation, options)?;
    let shape = start.positions.iter().chain(&start_controls).map(|p| vector3(*p)).collect();
    let job = Job::new(graph, &model.skin, shape, observation, options, cancel);

    let before = Residual::of(&job.seen(observation).distances(&job.shape)?);
    let (rigid, mut x) = job.best()?;
    job.place_controls(&mut x);
    let mut state = start;
    let deformed = x.clone();
    let settled = job.settle(backend, loaded, &mut state, &mut x);
    if matches!(settled, Err(Error::Invalid(_))) {
        // The shape of points that are not this object's: that is what to say of it.
        job.explain(&deformed)?;
    }
    let drift_mm = 1e3 * settled?;
    let n = graph.node_count();
    for ((to, v), x) in state.positions.iter_mut().zip(&mut state.velocities).zip(&x) {
        (*to, *v) = (point(*x), [0.0; 3]);
    }
    let controls = x[n..].iter().map(|p| point(*p)).collect();
    let (residual, explained) = job.explain(&x)?;
    Ok(Registered { state, controls, before, residual, explained, rigid, drift_mm })
}

/// Refuses a cloud that fits anywhere.
pub(crate) fn check_cloud(
    observation: &Observation,
    options: &RegisterOptions,
) -> Result<(), Error> {
    let points = observation.points.len();
    if observation.tracks.is_some() || points >= LEAST_CLOUD || options.near {
        return Ok(());
    }
    Err(Error::Invalid(format!(
        "{points} points without tracks fit anywhere: give at least {LEAST_CLOUD}, or say which nodes they are"
    )))
}

impl RegisterOptions {
    pub(crate) fn check(&self, graph: &Graph) -> Result<(), Error> {
        let refuse = |text: String| Err(Error::Invalid(text));
        let (given, c) = (self.controls.len(), graph.control_count());
        if given != 0 && given != c {
            return refuse(format!("{given} control points are given: the twin has {c}"));
        }
        if !self.controls.iter().all(is_place) {
            return refuse("a control point is not finite, or farther than 1 km off".into());
        }
        if self.settle_frames > 1000 {
            return refuse(format!("settle_frames is {}: give at most 1000", self.settle_frames));
        }
        let numbers = [
            ("noise_m", self.noise_m, 1e-6..=1.0),
            ("give", self.give, 1e-6..=10.0),
            ("max_residual_m", self.max_residual_m.unwrap_or(0.0), 0.0..=1e3),
            ("least_explained", self.least_explained, 0.0..=1.0),
        ];
        match numbers.into_iter().find(|(_, x, range)| !range.contains(x)) {
            Some((name, x, range)) => {
                refuse(format!("{name} is {x}: give {} to {}", range.start(), range.end()))
            }
            None => Ok(()),
        }
    }
}

/// A registration in progress.
pub(crate) struct Job<'a> {
    graph: &'a Graph,
    skin: MatchedSkin,
    /// Nodes and control points of the start [m], shape [N + C].
    shape: Vec<Vector3<f64>>,
    observation: &'a Observation,
    options: &'a RegisterOptions,
    /// Distance of neighbouring nodes [m].
    spacing_m: f64,
    cancel: &'a CancelToken,
}

impl<'a> Job<'a> {
    /// A registration that starts from endpoints at `shape` [m], shape [N + C].
    pub(crate) fn new(
        graph: &'a Graph,
        skin: &Skin,
        shape: Vec<Vector3<f64>>,
        observation: &'a Observation,
        options: &'a RegisterOptions,
        cancel: &'a CancelToken,
    ) -> Self {
        let skin = MatchedSkin::new(graph, skin);
        let spacing_m = node_spacing(graph);
        Self { graph, skin, shape, observation, options, spacing_m, cancel }
    }

    fn seen<'b>(&'b self, observation: &'b Observation) -> Seen<'b> {
        Seen { graph: self.graph, skin: Some(&self.skin), observation }
    }

    /// The best of the deformations that follow the best rigid motions.
    pub(crate) fn best(&self) -> Result<(RigidMotion, Vec<Vector3<f64>>), Error> {
        let motions = self.motions()?;
        let few = self.part(TRIED);
        let mut best: Option<(f64, RigidMotion)> = None;
        if motions.len() > 1 {
            for motion in &motions {
                let x = self.deform(motion, &few)?;
                let mut distances = self.seen(&few).distances(&x)?;
                distances.sort_by(f64::total_cmp);
                distances.truncate((distances.len() * 9).div_ceil(10));
                let score = distances.iter().sum::<f64>();
                if best.is_none_or(|(least, _)| score < least) {
                    best = Some((score, *motion));
                }
            }
        }
        let motion = best.map(|(_, motion)| motion).or_else(|| motions.first().copied());
        let motion =
            motion.ok_or_else(|| Error::Invalid("the points determine no rigid motion".into()))?;
        Ok((motion, self.deform(&motion, &self.part(USED))?))
    }

    /// Candidates for the rigid motion.
    fn motions(&self) -> Result<Vec<RigidMotion>, Error> {
        let n = self.graph.node_count();
        let given = self.options.controls.iter().zip(&self.shape[n..]);
        let known: Vec<Pair> = given
            .map(|(to, from)| Pair { before: point(*from), after: *to, weight: 1.0 })
            .collect();
        if self.options.near {
            let (rotation, translation) = (nalgebra::Matrix3::identity(), Vector3::zeros());
            return Ok(vec![RigidMotion { rotation, translation }]);
        }
        if let Some(tracks) = &self.observation.tracks {
            let at = |p: usize| point(position(tracks, p, &self.shape));
            let points = self.observation.points.iter().enumerate();
            let pair = |(p, y): (usize, &Point)| Pair {
                before: at(p),
                after: *y,
                weight: self.observation.weight(p),
            };
            let pairs: Vec<Pair> = points.map(pair).chain(known).collect();
            return Ok(of_tracks(&pairs, self.options.noise_m).into_iter().collect());
        }
        let skin = self.skin.positions(&self.shape);
        let surface = self.skin.surface(&skin)?;
        let points = &self.observation.points;
        Target { surface: &surface, skin: &skin, points, known: &known, up: Vector3::z() }
            .motions(self.cancel)
    }

    /// The shape after a rigid motion, deformed to the points.
    fn deform(
        &self,
        motion: &RigidMotion,
        observation: &Observation,
    ) -> Result<Vec<Vector3<f64>>, Error> {
        let moved: Vec<Vector3<f64>> =
            self.shape.iter().map(|p| motion.rotation * p + motion.translation).collect();
        let (fixed, mut x) = self.held(moved.clone());
        let elastic = Elastic::new(self.graph, moved, fixed);
        for softening in SOFTENING {
            for _ in 0..ROUNDS {
                if self.cancel.is_cancelled() {
                    return Err(Error::Cancelled);
                }
                let matches = self.seen(observation).matches(&x, self.options.noise_m)?;
                elastic.relax(&mut x, &matches, self.options.give * softening, ITERATIONS);
            }
        }
        Ok(x)
    }

    /// Endpoints that stay, with given control points and what they pin in place.
    fn held(&self, mut x: Vec<Vector3<f64>>) -> (Vec<bool>, Vec<Vector3<f64>>) {
        let n = self.graph.node_count();
        let mut fixed = vec![false; x.len()];
        for (c, given) in self.options.controls.iter().enumerate() {
            (fixed[n + c], x[n + c]) = (true, vector3(*given));
        }
        if !self.options.controls.is_empty() {
            for pin in &self.graph.pins {
                let (node, control) = (pin.node as usize, n + pin.control as usize);
                (fixed[node], x[node]) = (true, x[control] + vector3(pin.offset_m));
            }
        }
        (fixed, x)
    }

    /// Puts control points that pin nodes where these are, and the nodes exactly there.
    fn place_controls(&self, x: &mut [Vector3<f64>]) {
        let n = self.graph.node_count();
        if self.options.controls.is_empty() {
            let mut sums = vec![(Vector3::zeros(), 0.0); self.graph.control_count()];
            for pin in &self.graph.pins {
                let (sum, count) = &mut sums[pin.control as usize];
                *sum += x[pin.node as usize] - vector3(pin.offset_m);
                *count += 1.0;
            }
            for (c, (sum, count)) in sums.into_iter().enumerate().filter(|(_, s)| s.1 > 0.0) {
                x[n + c] = sum / count;
            }
        }
        for pin in &self.graph.pins {
            x[pin.node as usize] = x[n + pin.control as usize] + vector3(pin.offset_m);
        }
    }

    /// Frames of the twin's physics from rest, after each of which the points pull, then one in
    /// which they do not; mean distance that the nodes moved in that [m]. The state keeps the twists.
    fn settle(
        &self,
        backend: &dyn Backend,
        loaded: &Loaded,
        state: &mut State,
        x: &mut [Vector3<f64>],
    ) -> Result<f64, Error> {
        let n = self.graph.node_count();
        let observation = self.part(USED);
        for frame in 0..=self.options.settle_frames {
            if self.cancel.is_cancelled() {
                return Err(Error::Cancelled);
            }
            for ((to, v), x) in state.positions.iter_mut().zip(&mut state.velocities).zip(&*x) {
                (*to, *v) = (point(*x), [0.0; 3]);
            }
            let after = self.frame(backend, loaded, state, &x[n..])?;
            let moved: Vec<Vector3<f64>> = after.positions.iter().map(|p| vector3(*p)).collect();
            if frame == self.options.settle_frames {
                let drift = moved.iter().zip(&*x).map(|(a, b)| (a - b).norm()).sum::<f64>();
                return Ok(drift / n.max(1) as f64);
            }
            state.twists = after.twists;
            x[..n].copy_from_slice(&moved);
            let mut fixed = vec![false; x.len()];
            fixed[n..].fill(true);
            self.graph.pins.iter().for_each(|p| fixed[p.node as usize] = true);
            let elastic = Elastic::new(self.graph, x.to_vec(), fixed);
            let matches = self.seen(&observation).matches(x, self.options.noise_m)?;
            elastic.relax(x, &matches, 0.3 * self.options.give, ITERATIONS);
        }
        Ok(0.0)
    }

    /// The state after a frame in which the control points stay.
    fn frame(
        &self,
        backend: &dyn Backend,
        loaded: &Loaded,
        state: &State,
        controls: &[Vector3<f64>],
    ) -> Result<State, Error> {
        let both = controls.iter().chain(controls).map(|p| point(*p)).collect();
        let instance = Instance {
            model: loaded.clone(),
            initial: Arc::new(state.clone()),
            controls: Arc::new(both),
            frames: 1,
            objective: Objective::default(),
            world: Arc::default(),
            motion: Arc::default(),
        };
        let outputs = Outputs { final_state: true, ..Outputs::NONE };
        let rollout = backend.roll_out(&[instance], &outputs, self.cancel)?.into_iter().next();
        rollout.and_then(|r| r.final_state).ok_or_else(|| {
            Error::Invalid("the twin explodes in the shape of the points: raise noise_m".into())
        })
    }

    /// Distances that are left between the observation and nodes at `x`, unless they are too large.
    pub(crate) fn explain(&self, x: &[Vector3<f64>]) -> Result<(Residual, Explained), Error> {
        let Self { options, spacing_m, .. } = *self;
        let distances = self.seen(self.observation).distances(x)?;
        let residual = Residual::of(&distances);
        // Nodes far apart cannot follow all that their skin shows, a sparse skin leaves gaps.
        let within_m = (0.5 * spacing_m).max(0.75 * self.skin.spacing_m).max(3.0 * options.noise_m);
        let points = share_within(&distances, within_m);
        let limit_mm = 1e3 * options.max_residual_m.unwrap_or((0.5 * spacing_m).max(0.005));
        let fits = residual.median_mm <= limit_mm && points >= options.least_explained;
        if !fits || x.iter().flatten().any(|c| !c.is_finite()) {
            return Err(Error::NotExplained {
                median_mm: residual.median_mm,
                limit_mm,
                explained: points,
                least_explained: options.least_explained,
            });
        }
        let surface = self.covered(x, within_m.max(self.skin.spacing_m));
        Ok((residual, Explained { points, surface, within_mm: 1e3 * within_m }))
    }

    /// Share of the skin that could have been seen and is near an observed point.
    fn covered(&self, x: &[Vector3<f64>], within_m: f64) -> f64 {
        let skin = self.skin.positions(x);
        let cameras: Vec<Vector3<f64>> =
            self.observation.cameras.iter().map(|p| vector3(*p)).collect();
        let points: Vec<Vector3<f64>> =
            self.observation.points.iter().map(|p| vector3(*p)).collect();
        let Some(cloud) = Surface::new(&points, self.skin.spacing_m) else { return 0.0 };
        let seen = visible(&skin, &cameras);
        let distances: Vec<f64> = seen.iter().map(|p| cloud.nearest(point(*p)).1).collect();
        share_within(&distances, within_m)
    }

    /// An evenly chosen part of the observation.
    fn part(&self, most: usize) -> Observation {
        let all: Vec<usize> = (0..self.observation.points.len()).collect();
        let chosen = thinned(&all, most);
        let o = self.observation;
        Observation {
            points: chosen.iter().map(|&p| o.points[p]).collect(),
            tracks: o.tracks.as_ref().map(|tracks| tracks.select(&chosen)),
            weights: chosen.iter().filter_map(|&p| o.weights.get(p).copied()).collect(),
            velocities: Vec::new(),
            cameras: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests;
