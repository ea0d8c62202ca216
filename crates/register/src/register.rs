//! Registration: from points of an object that stands somewhere to a state of its twin. A rigid
//! motion first, then an elastic deformation that softens, then frames of the twin's own physics
//! during which the points keep pulling, so that the state is one that the twin can be in. Points say on
//! which side of an obstacle a node is; then it is taken out of what it is in, and stays out.

mod physics;

use bendtwin_core::{
    CancelToken, Graph, Pin, Plane, Point, Skin,
    geometry::{Pair, RigidMotion, point, vector3},
};
use bendtwin_engine::{Backend, Loaded, model::State};
use nalgebra::Vector3;

use self::physics::Physics;
use crate::{
    Around, Error, Explained, Observation, Residual,
    barrier::{Barrier, Outside},
    correct::{check, fixed},
    elastic::Elastic,
    observation::is_place,
    residual::{misfit, share_within},
    rigid::{Target, of_tracks, thinned},
    seen::{MatchedSkin, Matcher, node_spacing, position},
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
    /// Nodes that something holds, and where [m]; a node twice counts where it is named last.
    pub held: Vec<(u32, Point)>,
    /// Surroundings of the object, beside the ground of the model.
    pub around: Around,
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
            held: Vec::new(),
            around: Around::default(),
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
    let job =
        Job::new(graph, model.environment.ground, &model.skin, shape, observation, options, cancel);

    let before = Residual::of(&job.seen(observation).distances(&job.shape)?);
    let (rigid, mut x) = job.best()?;
    job.place_controls(&mut x);
    let mut state = start;
    let deformed = x.clone();
    let settled = job.settle(&Physics::new(backend, loaded, options), &mut state, &mut x);
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
        let n = graph.node_count();
        if let Some((node, _)) = self.held.iter().find(|h| h.0 as usize >= n || !is_place(&h.1)) {
            return refuse(format!("node {node} of {n} is held nowhere"));
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
    barrier: Barrier,
    cancel: &'a CancelToken,
}

impl<'a> Job<'a> {
    /// A registration that starts from endpoints at `shape` [m], shape [N + C].
    pub(crate) fn new(
        graph: &'a Graph,
        ground: Option<Plane>,
        skin: &Skin,
        shape: Vec<Vector3<f64>>,
        observation: &'a Observation,
        options: &'a RegisterOptions,
        cancel: &'a CancelToken,
    ) -> Self {
        let skin = MatchedSkin::new(graph, skin);
        let spacing_m = node_spacing(graph);
        let mut passes = fixed(graph, &options.around.loose);
        options.held.iter().for_each(|(node, _)| passes[*node as usize] = true);
        let barrier = Barrier::new(ground, &options.around, passes);
        Self { graph, skin, shape, observation, options, spacing_m, barrier, cancel }
    }

    fn seen<'b>(&'b self, observation: &'b Observation) -> Matcher<'b> {
        Matcher { graph: self.graph, skin: Some(&self.skin), observation }
    }

    /// The best of the deformations that follow the best rigid motions.
    pub(crate) fn best(&self) -> Result<(RigidMotion, Vec<Vector3<f64>>), Error> {
        let motions = self.motions()?;
        let few = self.part(TRIED);
        let mut best: Option<(f64, RigidMotion)> = None;
        if motions.len() > 1 {
            for motion in &motions {
                let (x, depth_m) = self.deform(motion, &few)?;
                let mut distances = self.seen(&few).distances(&x)?;
                distances.sort_by(f64::total_cmp);
                distances.truncate((distances.len() * 9).div_ceil(10));
                // A pose that was in obstacles is as unlikely as one that far from the points.
                let score = distances.iter().map(|d| d + depth_m).sum::<f64>();
                if best.is_none_or(|(least, _)| score < least) {
                    best = Some((score, *motion));
                }
            }
        }
        let motion = best.map(|(_, motion)| motion).or_else(|| motions.first().copied());
        let motion =
            motion.ok_or_else(|| Error::Invalid("the points determine no rigid motion".into()))?;
        Ok((motion, self.deform(&motion, &self.part(USED))?.0))
    }

    /// Candidates for the rigid motion.
    fn motions(&self) -> Result<Vec<RigidMotion>, Error> {
        let n = self.graph.node_count();
        let RegisterOptions { controls, held, around, .. } = self.options;
        let given = controls.iter().zip(n..).filter(|(_, e)| !around.is_loose(e - n));
        let given = given.chain(held.iter().map(|(node, place)| (place, *node as usize)));
        let known: Vec<Pair> = given
            .map(|(to, e)| Pair { before: point(self.shape[e]), after: *to, weight: 1.0 })
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

    /// The shape after a rigid motion, deformed to the points and outside of all obstacles; and how deep
    /// the nodes were in these before, in the mean [m].
    fn deform(
        &self,
        motion: &RigidMotion,
        observation: &Observation,
    ) -> Result<(Vec<Vector3<f64>>, f64), Error> {
        let moved: Vec<Vector3<f64>> =
            self.shape.iter().map(|p| motion.rotation * p + motion.translation).collect();
        let (fixed, mut x) = self.held(moved.clone());
        let elastic = Elastic::new(self.graph, moved, fixed, &self.options.around.loose);
        let soften =
            |x: &mut Vec<Vector3<f64>>, softening: f64, mut outside: Option<Outside<'_>>| {
                for _ in 0..ROUNDS {
                    if self.cancel.is_cancelled() {
                        return Err(Error::Cancelled);
                    }
                    let matches = self.seen(observation).matches(x, self.options.noise_m)?;
                    let give = self.options.give * softening;
                    elastic.relax(x, &matches, give, ITERATIONS, outside.as_mut());
                }
                Ok(())
            };
        for softening in SOFTENING {
            soften(&mut x, softening, None)?;
        }
        let depth_m = self.barrier.mean_depth(&x);
        if depth_m > 0.0 {
            let outside = self.barrier.leave(&mut x);
            soften(&mut x, 1.0, outside)?;
        }
        Ok((x, depth_m))
    }

    /// Endpoints that stay, with given control points and the nodes that they pin.
    fn held(&self, mut x: Vec<Vector3<f64>>) -> (Vec<bool>, Vec<Vector3<f64>>) {
        let n = self.graph.node_count();
        let mut fixed = vec![false; x.len()];
        for (c, given) in self.options.controls.iter().enumerate() {
            (fixed[n + c], x[n + c]) = (true, vector3(*given));
        }
        if !self.options.controls.is_empty() {
            for pin in self.pins() {
                let (node, control) = (pin.node as usize, n + pin.control as usize);
                (fixed[node], x[node]) = (true, x[control] + vector3(pin.offset_m));
            }
        }
        for (node, place) in &self.options.held {
            let node = *node as usize;
            (fixed[node], x[node]) = (true, vector3(*place));
        }
        (fixed, x)
    }

    /// Pins of control points that are not loose.
    fn pins(&self) -> impl Iterator<Item = &Pin> {
        let around = &self.options.around;
        self.graph.pins.iter().filter(|pin| !around.is_loose(pin.control as usize))
    }

    /// Puts control points that pin nodes where these are, and the nodes exactly there.
    fn place_controls(&self, x: &mut [Vector3<f64>]) {
        let n = self.graph.node_count();
        if self.options.controls.is_empty() {
            let mut sums = vec![(Vector3::zeros(), 0.0); self.graph.control_count()];
            for pin in self.pins() {
                let (sum, count) = &mut sums[pin.control as usize];
                *sum += x[pin.node as usize] - vector3(pin.offset_m);
                *count += 1.0;
            }
            for (c, (sum, count)) in sums.into_iter().enumerate().filter(|(_, s)| s.1 > 0.0) {
                x[n + c] = sum / count;
            }
        }
        for pin in self.pins() {
            x[pin.node as usize] = x[n + pin.control as usize] + vector3(pin.offset_m);
        }
    }

    /// Frames of the twin's physics from rest, after each of which the points pull, then one in
    /// which they do not; mean distance that the nodes moved in that [m]. The state keeps the twists.
    fn settle(
        &self,
        physics: &Physics<'_>,
        state: &mut State,
        x: &mut [Vector3<f64>],
    ) -> Result<f64, Error> {
        let n = self.graph.node_count();
        let observation = self.part(USED);
        self.barrier.leave(x);
        for frame in 0..=self.options.settle_frames {
            if self.cancel.is_cancelled() {
                return Err(Error::Cancelled);
            }
            for ((to, v), x) in state.positions.iter_mut().zip(&mut state.velocities).zip(&*x) {
                (*to, *v) = (point(*x), [0.0; 3]);
            }
            let after = physics.frame(state, &x[n..], self.cancel)?;
            let moved: Vec<Vector3<f64>> = after.positions.iter().map(|p| vector3(*p)).collect();
            if frame == self.options.settle_frames {
                let drift = moved.iter().zip(&*x).map(|(a, b)| (a - b).norm()).sum::<f64>();
                return Ok(drift / n.max(1) as f64);
            }
            state.twists = after.twists;
            x[..n].copy_from_slice(&moved);
            let mut outside = self.barrier.leave(x);
            let RegisterOptions { around, held, noise_m, give, .. } = self.options;
            let mut fixed = fixed(self.graph, &around.loose);
            held.iter().for_each(|(node, _)| fixed[*node as usize] = true);
            let elastic = Elastic::new(self.graph, x.to_vec(), fixed, &around.loose);
            let matches = self.seen(&observation).matches(x, *noise_m)?;
            elastic.relax(x, &matches, 0.3 * give, ITERATIONS, outside.as_mut());
        }
        Ok(0.0)
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
                misfit: misfit(&distances, spacing_m, options.noise_m),
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
