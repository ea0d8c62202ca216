//! A whole benchmark: scene by scene, the measurements that the plan asks for.

use std::{
    sync::Arc,
    time::{Duration, Instant},
};

use bendtwin_core::CancelToken;
use bendtwin_engine::Backend;

use crate::{
    Error, MemoryProbe, Report,
    bound::IssueBound,
    fit::{FitPlan, whole_fit},
    measure::{Bench, Budget},
    report::{DeviceName, SceneReport},
    scene::{Scene, SceneName},
};

/// The measurements to make.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Scenes, with or without bending.
    pub scenes: Vec<(SceneName, bool)>,
    /// Sizes of batches of rollouts.
    pub batches: Vec<usize>,
    /// Sizes of batches of windows for gradients.
    pub windows: Vec<usize>,
    /// Frames of a rollout, at most; slow backends get fewer.
    pub horizon: usize,
    /// Time for the repeats of one measurement.
    pub measurement: Duration,
    /// A measurement whose single call would take longer than this is left out.
    pub patience: Duration,
    /// Whole fits of every scene.
    pub fits: Vec<FitPlan>,
}

/// The system under test.
pub struct Setup<'a> {
    /// The backend that is measured.
    pub backend: Arc<dyn Backend>,
    /// Probe of the memory that it takes.
    pub memory: &'a dyn MemoryProbe,
    /// Ends the benchmark early.
    pub cancel: &'a CancelToken,
}

/// Makes the measurements, and calls `say` with the name of each before it starts. Results are
/// added to the report after every scene, so that a failure loses only the scene in which it
/// happens.
///
/// # Errors
/// If the backend fails or computes nonsense, or on cancellation.
pub fn run(
    plan: &Plan,
    setup: &Setup<'_>,
    report: &mut Report,
    say: &mut dyn FnMut(&str),
) -> Result<(), Error> {
    for &(name, bending) in &plan.scenes {
        let scene = Scene::new(name, bending)?;
        let done = one_scene(plan, setup, report.bound.as_ref(), scene, say)?;
        report.scenes.push(done);
    }
    Ok(())
}

impl Report {
    /// An empty report with the device's bound; on a CPU, that is measured here.
    pub fn new(plan: &Plan, backend: &dyn Backend) -> Self {
        let device = backend.device();
        Self {
            build: bendtwin_core::BUILD.to_owned(),
            bound: IssueBound::of(&device),
            device: DeviceName { kind: device.kind, name: device.name, lanes: device.lanes },
            method: method(plan),
            scenes: Vec::with_capacity(plan.scenes.len()),
        }
    }
}

fn one_scene(
    plan: &Plan,
    setup: &Setup<'_>,
    bound: Option<&IssueBound>,
    scene: Scene,
    say: &mut dyn FnMut(&str),
) -> Result<SceneReport, Error> {
    let title = format!("{}{}", scene.name, if scene.bending { " with bending" } else { "" });
    let (graph, timing) = (&scene.model.graph, scene.model.timing);
    setup.memory.reset();
    say(&format!("{title}: rollouts"));
    let began = Instant::now();
    let loaded = setup.backend.load(scene.model.clone())?;
    let load_s = began.elapsed().as_secs_f64();
    let bench = Bench {
        backend: &*setup.backend,
        scene: &scene,
        loaded,
        budget: Budget {
            measurement: plan.measurement,
            patience: plan.patience,
            horizon: plan.horizon.max(1),
        },
        cancel: setup.cancel,
    };
    let forward = bench.forward(&plan.batches, bound.map(|b| b.forward_s(&scene)))?;
    say(&format!("{title}: gradients"));
    let gradient = bench.gradient(&plan.windows, bound.and_then(|b| b.gradient_s(&scene)))?;
    let memory_bytes = setup.memory.used_bytes();
    drop(bench);
    let mut fits = Vec::with_capacity(plan.fits.len());
    for fit in &plan.fits {
        setup.memory.reset();
        say(&format!("{title}: a whole fit, a step a {}", fit.scheme.as_str()));
        fits.push(whole_fit(&scene, &setup.backend, fit, setup.memory, setup.cancel)?);
    }
    Ok(SceneReport {
        name: scene.name.as_str(),
        bending: scene.bending,
        nodes: graph.node_count(),
        springs: graph.springs.len(),
        control_springs: scene.control_spring_count(),
        triplets: graph.triplets.len(),
        controls: graph.control_count(),
        substeps: timing.substeps,
        dt_s: timing.dt_s(),
        stiffness: scene.stiffness,
        load_s,
        forward,
        gradient,
        memory_bytes,
        fits,
    })
}

fn method(plan: &Plan) -> String {
    format!(
        "Rollouts of up to {} frames (fewer where a call would outlast a quarter of {:.1} s), through the call that returns \
         one number an instance; gradients of windows of one frame with Chamfer and track terms. One call to warm up, \
         then the median of the calls within {:.1} s. A time per substep is of the whole batch. Measurements whose \
         single call would take over {:.0} s are left out.",
        plan.horizon,
        plan.measurement.as_secs_f64(),
        plan.measurement.as_secs_f64(),
        plan.patience.as_secs_f64()
    )
}

#[cfg(test)]
mod tests;
