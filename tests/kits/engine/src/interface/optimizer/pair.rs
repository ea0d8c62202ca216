//! Two optimizer runs over different graphs, and the same runs computed by hand.

use std::sync::Arc;

use bendtwin_core::CancelToken;
use bendtwin_engine::{
    Backend,
    backend::GradientRequest,
    optimizer::{
        Bounds, Decay, GradientSample, Optimizer, OptimizerInit, Parameter, Parameterization,
        Position, Scale,
    },
};

use crate::{
    random::{RandomOptions, random_model, random_motion, random_objective},
    scene::Scene,
};

pub(crate) const REQUEST: GradientRequest = GradientRequest {
    cut_every: 0,
    controls: false,
    initial: false,
    final_state: true,
    ..GradientRequest::PARAMS
};

/// Two runs, with their initial states and scenes.
pub(crate) struct Pair {
    pub(crate) inits: Vec<OptimizerInit>,
    pub(crate) decay: Decay,
    scenes: Vec<Scene>,
}

impl Pair {
    pub(crate) fn new(backend: &dyn Backend) -> Result<Self, String> {
        let scene = |seed: u64, nodes: usize, bending: bool| {
            let (rod, pins) = if bending { (true, 4) } else { (false, 1) };
            let options =
                RandomOptions { nodes, bending, rod, pins, ground: true, ..Default::default() };
            let model = random_model(seed, &options);
            let frames = 3;
            let (state, controls) = random_motion(seed, &model, frames);
            let objective = random_objective(seed, &model, frames);
            let mut scene = Scene::around(model, state, controls, frames);
            scene.objective = objective;
            // Room for what steps and other parameters do to stability.
            scene.timing.substeps *= 2;
            scene
        };
        let scenes = vec![scene(3, 24, true), scene(4, 17, false)];
        let start = |scene: &Scene| {
            let loaded = scene.load(backend)?;
            let parameterization = parameterization(scene);
            let position = parameterization.at_rest(parameterization.start());
            // Loaded with exactly what the parameterization makes of its start.
            let loaded = backend.with_params(&loaded, parameterization.params(&position.theta));
            let loaded = loaded.map_err(|e| format!("with_params: {e}"))?;
            Ok(OptimizerInit { loaded, parameterization, position })
        };
        let inits = scenes.iter().map(start).collect::<Result<_, String>>()?;
        Ok(Self { inits, decay: Decay { beta1: 0.9, beta2: 0.99, prior: 0.7 }, scenes })
    }

    pub(crate) fn optimizer(&self, backend: &dyn Backend) -> Result<Box<dyn Optimizer>, String> {
        backend.optimizer(self.inits.clone(), self.decay).map_err(|e| format!("optimizer: {e}"))
    }

    /// Two instances of the first run, of different lengths, around one of the second.
    pub(crate) fn samples(&self) -> Vec<GradientSample> {
        let sample = |run: usize| {
            let instance = self.scenes[run].instance(self.inits[run].loaded.clone());
            GradientSample { run, instance }
        };
        let mut shorter = sample(0);
        let c = self.scenes[0].graph.control_count();
        shorter.instance.frames = 2;
        shorter.instance.controls = Arc::new(self.scenes[0].controls[..3 * c].to_vec());
        let terms = self.scenes[0].objective.terms.iter().filter(|t| t.frame <= 2).cloned();
        shorter.instance.objective.terms = Arc::new(terms.collect());
        vec![sample(0), sample(1), shorter]
    }
}

/// Every parameter; positive ones by their logarithm. Narrow enough for steps to meet a bound.
fn parameterization(scene: &Scene) -> Parameterization {
    use Parameter::{
        BendDamping, BendStiffness, Drag, GroundFriction, GroundRestitution, ObjectFriction,
        ObjectRestitution, RestAngle, RestLength, RestTwist, SpringDashpot, SpringStiffness,
        TwistDamping, TwistStiffness,
    };
    let near = |span: f64| move |x: f64| [x - span, x + span];
    let mut parameterization = Parameterization::new(scene.params.clone());
    let logarithms = [SpringStiffness, SpringDashpot, BendStiffness, BendDamping];
    for parameter in logarithms.into_iter().chain([TwistStiffness, TwistDamping, Drag]) {
        parameterization = parameterization.with(parameter, Scale::Logarithmic, 1.0, near(0.5));
    }
    parameterization = parameterization.with(RestLength, Scale::Logarithmic, 0.04, near(0.05));
    parameterization = parameterization.with(RestTwist, Scale::Linear, 1.0, near(0.5));
    parameterization = parameterization.with(RestAngle, Scale::Linear, 0.3, |x| {
        [(x - 0.3).max(0.0), (x + 0.3).min(std::f64::consts::PI)]
    });
    for parameter in [GroundRestitution, GroundFriction, ObjectRestitution, ObjectFriction] {
        parameterization = parameterization.with(parameter, Scale::Linear, 1.0, |_| [0.0, 1.0]);
    }
    parameterization
}

/// Positions of the runs after steps with these weights and rates, computed from `gradients`,
/// parameterizations and Adam.
pub(crate) fn by_hand(
    backend: &dyn Backend,
    pair: &Pair,
    weights: &[Vec<f64>],
    rates: &[f64],
) -> Result<Vec<Position>, String> {
    let mut positions = Vec::new();
    for (run, start) in pair.inits.iter().enumerate() {
        let parameterization = &start.parameterization;
        let mut position = start.position.clone();
        let mut loaded = start.loaded.clone();
        for rate in rates {
            let own = pair.samples().into_iter().filter(|p| p.run == run);
            let batch: Vec<_> = own
                .map(|p| bendtwin_engine::backend::Instance { model: loaded.clone(), ..p.instance })
                .collect();
            let gradients = backend.gradients(&batch, &REQUEST, &CancelToken::default());
            let mut sum = vec![0.0; parameterization.len()];
            for (g, weight) in gradients.map_err(|e| e.to_string())?.iter().zip(&weights[run]) {
                let own = parameterization.gradient(&loaded.model().params, &g.params);
                sum.iter_mut().zip(own).for_each(|(s, g)| *s += weight * g);
            }
            let (rates, start): (Vec<f64>, _) =
                (parameterization.rates().collect(), parameterization.start());
            let bounds = Bounds {
                kinds: &parameterization.kinds(),
                rates: &rates,
                bounds: parameterization.bounds(),
                start: &start,
            };
            let Position { theta, adam } = &mut position;
            adam.step(theta, &sum, *rate, bounds, pair.decay);
            let moved = backend.with_params(&loaded, parameterization.params(theta));
            loaded = moved.map_err(|e| format!("with_params: {e}"))?;
        }
        positions.push(position);
    }
    Ok(positions)
}

/// Root of the mean squared difference.
pub(crate) fn distance(a: &[f64], b: &[f64]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
    (squares / a.len().max(1) as f64).sqrt()
}
