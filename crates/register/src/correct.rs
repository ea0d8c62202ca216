//! Correction of a running state: it moves towards an observation that is small beside the motion
//! so far, smoothly, without straining the object, without touching what control points hold, and
//! outside of obstacles, on the side of them where it was.

use bendtwin_core::{
    CancelToken, Graph, Point,
    geometry::{point, vector3},
};
use bendtwin_engine::{Model, model::State};
use nalgebra::Vector3;

use crate::{
    Around, Error, Observation, Residual,
    barrier::Barrier,
    elastic::Elastic,
    observation::is_place,
    residual::{misfit, share_within},
    seen::{MatchedSkin, Matcher, node_spacing},
};

/// Options of [`correct`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CorrectOptions {
    /// Deviation of an observed point from its place [m]: noise of the camera, and what a coarse
    /// twin cannot follow.
    pub noise_m: f64,
    /// Deviation of a spring, by its length, in one correction: how far the twin's shape is
    /// doubted.
    pub give: f64,
    /// Deviation of an observed velocity [m/s].
    pub velocity_noise_m_s: f64,
    /// Share of the displacement that is added to the velocity, by time [1/s]; for observations
    /// without velocities. 0 keeps velocities.
    pub velocity_gain_per_s: f64,
    /// Largest increase of the strain of any spring between two nodes; beyond it the correction is
    /// cut in half until it fits.
    pub most_added_strain: f64,
    /// Largest median residual that is left, beyond which the correction is refused [m]; `None` is
    /// half the distance between neighbouring nodes, or 5 mm if that is more.
    pub max_residual_m: Option<f64>,
}

impl Default for CorrectOptions {
    fn default() -> Self {
        Self {
            noise_m: 0.005,
            give: 0.03,
            velocity_noise_m_s: 0.2,
            velocity_gain_per_s: 0.0,
            most_added_strain: 0.5,
            max_residual_m: None,
        }
    }
}

/// A corrected state.
#[derive(Clone, Debug, PartialEq)]
pub struct Corrected {
    /// Corrected state; twists and holds of grasps are unchanged.
    pub state: State,
    /// Distances before.
    pub before: Residual,
    /// Distances after.
    pub after: Residual,
    /// Largest displacement of a node [m].
    pub moved_m: f64,
    /// Misfit of the corrected state: up to 1 noise and the twin's resolution explain what is left
    /// ([`Tracking`](crate::Tracking)).
    pub misfit: f64,
}

/// Rounds of matching and reweighting.
const ROUNDS: usize = 5;
/// Iterations of the deformation in each.
const ITERATIONS: usize = 4;

/// Corrects a state whose control points are at `controls` [m], shape [C, 3]; they, the nodes that
/// they pin and the nodes in grasps stay. All others are outside of the model's ground and of what is
/// around, a node that was outside on the side where it was and one that was inside along the normal,
/// and have no velocity into what they touch.
///
/// # Errors
/// If the input does not fit the model, if more than the stated residual is left, or on
/// cancellation.
pub fn correct(
    model: &Model,
    state: &State,
    controls: &[Point],
    around: &Around,
    observation: &Observation,
    options: &CorrectOptions,
    cancel: &CancelToken,
) -> Result<Corrected, Error> {
    let graph = &model.graph;
    observation.check(graph)?;
    check(graph, state, controls)?;
    options.check()?;
    let n = graph.node_count();
    let start: Vec<Vector3<f64>> =
        state.positions.iter().chain(controls).map(|p| vector3(*p)).collect();
    let mut fixed = fixed(graph, &around.loose);
    for hold in &state.grasping.holds {
        if let Some(node) = fixed[..n].get_mut(hold.node as usize) {
            *node = true;
        }
    }
    let barrier = Barrier::new(model.environment.ground, around, fixed.clone());
    let elastic = Elastic::new(graph, start.clone(), fixed, &around.loose);

    // Tracks say where they are: no skin is matched.
    let skin = observation.tracks.is_none().then(|| MatchedSkin::new(graph, &model.skin));
    let seen = Matcher { graph, skin: skin.as_ref(), observation };
    let before = seen.distances(&start)?;
    let mut x = start.clone();
    let mut outside = barrier.leave(&mut x);
    for _ in 0..ROUNDS {
        if cancel.is_cancelled() {
            return Err(Error::Cancelled);
        }
        let matches = seen.matches(&x, options.noise_m)?;
        elastic.relax(&mut x, &matches, options.give, ITERATIONS, outside.as_mut());
    }
    let from = outside.as_ref().map_or(&start, |outside| &outside.from);
    limit_strain(graph, [&start, from], &mut x, options.most_added_strain);

    let distances = seen.distances(&x)?;
    let after = Residual::of(&distances);
    let spacing_m = node_spacing(graph);
    let misfit = misfit(&distances, spacing_m, options.noise_m);
    let limit_m = options.max_residual_m.unwrap_or((0.5 * spacing_m).max(0.005));
    let fits = after.median_mm <= 1e3 * limit_m;
    if !fits || x.iter().flatten().any(|c| !c.is_finite()) {
        return Err(Error::NotExplained {
            median_mm: after.median_mm,
            limit_mm: 1e3 * limit_m,
            explained: share_within(&distances, limit_m),
            least_explained: 0.0,
            misfit,
        });
    }
    let mut corrected = state.clone();
    for ((to, x), from) in corrected.positions.iter_mut().zip(&x).zip(&start) {
        if x != from {
            *to = point(*x);
        }
    }
    let rate = options.velocity_gain_per_s;
    for ((v, x), from) in corrected.velocities.iter_mut().zip(&x).zip(&start) {
        *v = point(vector3(*v) + (x - from) * rate);
    }
    let [noise, give] = [options.velocity_noise_m_s, options.give / options.noise_m];
    if let Some(change) = seen.velocity_change(&elastic, &corrected.velocities, noise, give) {
        for (v, change) in corrected.velocities.iter_mut().zip(change) {
            *v = point(vector3(*v) + change);
        }
    }
    barrier.stop(&x, &mut corrected.velocities);
    let moved_m = x.iter().zip(&start).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    let before = Residual::of(&before);
    Ok(Corrected { state: corrected, before, after, moved_m, misfit })
}

/// Distances of an observation from a state whose control points are at `controls` [m], shape [C, 3].
///
/// # Errors
/// If the input does not fit the model.
pub fn residual(
    model: &Model,
    state: &State,
    controls: &[Point],
    observation: &Observation,
) -> Result<Residual, Error> {
    let graph = &model.graph;
    observation.check(graph)?;
    check(graph, state, controls)?;
    let x: Vec<Vector3<f64>> =
        state.positions.iter().chain(controls).map(|p| vector3(*p)).collect();
    let skin = observation.tracks.is_none().then(|| MatchedSkin::new(graph, &model.skin));
    let seen = Matcher { graph, skin: skin.as_ref(), observation };
    Ok(Residual::of(&seen.distances(&x)?))
}

impl CorrectOptions {
    fn check(&self) -> Result<(), Error> {
        let numbers = [
            ("noise_m", self.noise_m, 1e-6..=1.0),
            ("give", self.give, 1e-6..=10.0),
            ("velocity_noise_m_s", self.velocity_noise_m_s, 1e-6..=1e3),
            ("velocity_gain_per_s", self.velocity_gain_per_s, 0.0..=1e3),
            ("most_added_strain", self.most_added_strain, 0.0..=10.0),
            ("max_residual_m", self.max_residual_m.unwrap_or(0.0), 0.0..=1e3),
        ];
        match numbers.into_iter().find(|(_, x, range)| !range.contains(x)) {
            Some((name, x, range)) => Err(Error::Invalid(format!(
                "{name} is {x}: give {} to {}",
                range.start(),
                range.end()
            ))),
            None => Ok(()),
        }
    }
}

/// Checks that a state and control points belong to a graph.
pub(crate) fn check(graph: &Graph, state: &State, controls: &[Point]) -> Result<(), Error> {
    let (n, c) = (graph.node_count(), graph.control_count());
    if graph.surface_count() == 0 {
        return Err(Error::Invalid("the twin has no surface".into()));
    }
    if state.positions.len() != n || state.velocities.len() != n || controls.len() != c {
        return Err(Error::Invalid(format!(
            "the state has {} positions, {} velocities and {} control points: the twin has {n} nodes and {c} control points",
            state.positions.len(),
            state.velocities.len(),
            controls.len()
        )));
    }
    let all = state.positions.iter().chain(&state.velocities).chain(controls);
    match all.into_iter().all(is_place) {
        true => Ok(()),
        false => Err(Error::Invalid("the state is not finite, or farther than 1 km off".into())),
    }
}

/// Endpoints that stay while control points do: these, and what those of them pin that are not loose,
/// shape [N + C].
pub(crate) fn fixed(graph: &Graph, loose: &[u32]) -> Vec<bool> {
    let n = graph.node_count();
    let mut fixed = vec![false; n + graph.control_count()];
    fixed[n..].fill(true);
    let pins = graph.pins.iter().filter(|pin| !loose.contains(&pin.control));
    pins.for_each(|pin| fixed[pin.node as usize] = true);
    fixed
}

/// Cuts the way from the second of two states in half until no spring between two nodes is strained
/// much more than it was in one of them. The states are the start, before and after it left obstacles.
fn limit_strain(graph: &Graph, states: [&[Vector3<f64>]; 2], x: &mut [Vector3<f64>], most: f64) {
    let n = graph.node_count();
    let length = |x: &[Vector3<f64>], s: &[u32; 2]| (x[s[0] as usize] - x[s[1] as usize]).norm();
    let within = |x: &[Vector3<f64>]| {
        graph.springs.iter().filter(|s| (s[1] as usize) < n).all(|s| {
            let rest =
                (vector3(graph.rest_endpoint(s[0])) - vector3(graph.rest_endpoint(s[1]))).norm();
            let strain = |x: &[Vector3<f64>]| (length(x, s) / rest.max(1e-9) - 1.0).abs();
            strain(x) <= strain(states[0]).max(strain(states[1])) + most
        })
    };
    let from = states[1];
    for _ in 0..6 {
        if within(x) {
            return;
        }
        // A part of a way that meets no obstacle meets none.
        for (x, from) in x.iter_mut().zip(from) {
            *x = (*x + *from) * 0.5;
        }
    }
    if !within(x) {
        x.copy_from_slice(from);
    }
}

#[cfg(test)]
mod tests;
