//! The CPU backend, the definition of correct. Rayon runs the instances of a
//! batch side by side (so results do not depend on the number of threads), SIMD
//! runs within each.

// Lane arithmetic goes through several arrays side by side, by lane and coordinate.
#![allow(clippy::needless_range_loop)]

pub(crate) mod arithmetic;
pub mod check;
mod collision;
mod diagnostics;
pub(crate) mod elements;
mod frame;
mod gauge;
pub(crate) mod gradient;
pub(crate) mod loss;
pub(crate) mod parameters;
pub(crate) mod rollout;
pub(crate) mod surroundings;
pub(crate) mod system;

use std::sync::Arc;

use bendtwin_core::{CancelToken, Environment, Params};
use rayon::prelude::*;

pub use self::gauge::{Gauge, PathGradient};
use self::{
    arithmetic::{Quad, Real, quad},
    diagnostics::{Observer, hold_of, state_of},
    parameters::{Parameters, saturate},
    rollout::{Scorer, Simulation, nodes_of, twists_of},
    surroundings::{Surroundings, grasp::Hands},
    system::{Layout, System},
};
use crate::{
    Model, World,
    backend::{
        Backend, Device, Error, Gradient, GradientRequest, Instance, Loaded, Loss, Outputs, Rollout,
    },
    model::State,
    objective::{Term, WeightedTerm},
    optimizer::{Decay, HostOptimizer, Optimizer, OptimizerInit},
    world::{Grasping, Hold},
};

/// Runs on the CPU's cores; clones share the threads. Make one with [`cpu`] or
/// [`cpu_with_threads`].
#[derive(Clone)]
pub struct CpuBackend {
    /// `None` on a machine that gives us no threads: then the caller's own does everything.
    pool: Option<Arc<rayon::ThreadPool>>,
    threads: usize,
}

/// A backend on all cores that this process may use.
pub fn cpu() -> Arc<dyn Backend> {
    cpu_with_threads(std::thread::available_parallelism().map_or(1, std::num::NonZero::get))
}

/// A backend on the given number of threads (at least one).
pub fn cpu_with_threads(threads: usize) -> Arc<dyn Backend> {
    Arc::new(CpuBackend::new(threads))
}

/// The CPU backend's part of a loaded model.
struct Resident {
    system: System<f32>,
    layout: Arc<Layout>,
}

impl CpuBackend {
    /// A backend on the given number of threads (at least one).
    pub fn new(threads: usize) -> Self {
        let threads = threads.max(1);
        let builder = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = builder.thread_name(|i| format!("bendtwin-cpu-{i}")).build();
        Self { pool: pool.ok().map(Arc::new), threads }
    }

    fn make(model: Arc<Model>, layout: Arc<Layout>) -> Loaded {
        let system = System::new(&model, &layout, Parameters::from_params(&model.params));
        Loaded::new(model, Arc::new(Resident { system, layout }))
    }

    /// Runs the instances side by side; the first error in batch order wins. Forces are `measured`
    /// if they are asked for.
    fn each<R: Send>(
        &self,
        batch: &[Instance],
        measured: bool,
        work: impl Fn(&Simulation<'_, f32>) -> Result<R, Error> + Sync,
    ) -> Result<Vec<R>, Error> {
        for (index, instance) in batch.iter().enumerate() {
            check::instance(index, instance)?;
        }
        let one = |instance: &Instance| work(&simulation(instance, measured)?);
        let results: Vec<_> = match &self.pool {
            Some(pool) => pool.install(|| batch.par_iter().map(one).collect()),
            None => batch.iter().map(one).collect(),
        };
        results.into_iter().collect()
    }
}

fn resident(loaded: &Loaded) -> Result<&Resident, Error> {
    loaded.resident().ok_or_else(|| {
        Error::InvalidInput("the model was loaded by another backend: load it here".into())
    })
}

/// The simulation of an instance; `measured` if its forces are asked for.
fn simulation(instance: &Instance, measured: bool) -> Result<Simulation<'_, f32>, Error> {
    Ok(simulation_on(&resident(&instance.model)?.system, instance, measured))
}

/// The same on a system of the instance's model.
fn simulation_on<'a>(
    system: &'a System<f32>,
    instance: &'a Instance,
    measured: bool,
) -> Simulation<'a, f32> {
    let (world, motion) = (&*instance.world, &*instance.motion);
    let in_cost = |t: &WeightedTerm| matches!(t.term, Term::Force { .. });
    let measured = measured || instance.objective.terms.iter().any(in_cost);
    let plain = *world == World::default() && motion.rolls.is_empty() && !measured;
    let surroundings = (!plain).then(|| {
        let start = Hands::new(&instance.initial.grasping, &world.grasps);
        Surroundings::new(world, motion, start, measured)
    });
    Simulation {
        surroundings,
        system,
        initial: nodes_of(&instance.initial),
        twists: twists_of(&instance.initial, &instance.model.model().graph),
        controls: instance.controls.iter().map(|&p| quad(p)).collect(),
        frames: instance.frames,
        objective: &instance.objective,
    }
}

/// A gradient by a point as a client sees it.
fn gradient_point<T: Real>(x: Quad<T>) -> [f32; 3] {
    [saturate(x[0]), saturate(x[1]), saturate(x[2])]
}

impl Backend for CpuBackend {
    fn device(&self) -> Device {
        let lanes = self.pool.as_ref().map_or(1, |pool| pool.current_num_threads());
        // `V3(..)` is AVX2 with fused multiply-add, as in x86-64-v3.
        let arch = format!("{:?}", pulp::Arch::new());
        let arch = arch.split('(').next().unwrap_or_default();
        Device { kind: "cpu".into(), name: format!("{lanes} threads, {arch} instructions"), lanes }
    }

    fn load(&self, model: Arc<Model>) -> Result<Loaded, Error> {
        check::loadable(&model)?;
        let layout = Arc::new(Layout::new(&model.graph));
        Ok(Self::make(model, layout))
    }

    fn with_params(&self, loaded: &Loaded, params: Params) -> Result<Loaded, Error> {
        let layout = resident(loaded)?.layout.clone();
        let model = Model { params, ..Model::clone(loaded.model()) };
        model.params.check(&model.graph).map_err(Error::InvalidModel)?;
        Ok(Self::make(Arc::new(model), layout))
    }

    fn with_environment(&self, loaded: &Loaded, environment: Environment) -> Result<Loaded, Error> {
        let layout = resident(loaded)?.layout.clone();
        let model = Model { environment, ..Model::clone(loaded.model()) };
        check::environment(&environment)?;
        Ok(Self::make(Arc::new(model), layout))
    }

    fn roll_out(
        &self,
        batch: &[Instance],
        outputs: &Outputs,
        cancel: &CancelToken,
    ) -> Result<Vec<Rollout>, Error> {
        for (index, instance) in batch.iter().enumerate() {
            check::outputs(index, instance, outputs)?;
        }
        self.each(batch, outputs.forces, |simulation| {
            let mut scorer = Scorer::new(simulation);
            let mut observer = Observer::new(simulation, outputs);
            let diverged = simulation.run(cancel, |frame, now| {
                scorer.see(frame, now);
                observer.see(frame, now);
            })?;
            let (loss, frame_costs) = scorer.finish(diverged, simulation.frames);
            Ok(observer.finish(loss, frame_costs))
        })
    }

    fn losses(&self, batch: &[Instance], cancel: &CancelToken) -> Result<Vec<Loss>, Error> {
        self.each(batch, false, |simulation| rollout::losses(simulation, cancel))
    }

    fn gradients(
        &self,
        batch: &[Instance],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<Gradient>, Error> {
        self.each(batch, false, |simulation| {
            let g = gradient::gradient(simulation, request.cut_every, cancel)?;
            let diverged = g.loss.diverged.is_some();
            // Nothing was differentiated then, and zero would say that nothing matters.
            let unknown = |p: [f32; 3]| if diverged { [f32::NAN; 3] } else { p };
            let controls = g.controls.into_iter().map(|x| unknown(gradient_point(x)));
            let by_hold = |h: &surroundings::grasp::Hold<f32>| Hold {
                place: unknown(gradient_point(h.place)),
                ..hold_of(h)
            };
            let number = |x: f32| if diverged { f32::NAN } else { saturate(x) };
            let by_pose = |p: &surroundings::body::Pose<f32>| p.map(|row| row.map(number));
            let rolls = g.rolls.iter().map(|&x| number(x));
            let initial = || State {
                positions: g.initial.iter().map(|n| unknown(gradient_point(n.x))).collect(),
                velocities: g.initial.iter().map(|n| unknown(gradient_point(n.v))).collect(),
                twists: g.initial_twists.iter().map(|&x| unknown([saturate(x); 3])[0]).collect(),
                grasping: Grasping {
                    phases: g.initial_hands.phases.clone(),
                    holds: g.initial_hands.holds.iter().map(by_hold).collect(),
                },
            };
            Ok(Gradient {
                overflowed: !g.parameters.fit_f32(),
                loss: g.loss,
                params: g.parameters.into_gradient(),
                controls: if request.controls { controls.collect() } else { Vec::new() },
                poses: if request.motion {
                    g.poses.iter().map(by_pose).collect()
                } else {
                    Vec::new()
                },
                rolls: if request.motion { rolls.collect() } else { Vec::new() },
                norms: if request.norms { g.norms } else { Vec::new() },
                initial: request.initial.then(initial),
                final_state: (request.final_state && !diverged)
                    .then(|| state_of(&g.last, &g.last_twists, &g.last_hands)),
            })
        })
    }

    fn optimizer(
        &self,
        inits: Vec<OptimizerInit>,
        decay: Decay,
    ) -> Result<Box<dyn Optimizer>, Error> {
        Ok(Box::new(HostOptimizer::new(Arc::new(self.clone()), inits, decay)?))
    }

    /// A backend with the same number of other threads: those of this one may all be busy until the
    /// end of a frame.
    fn urgent(&self) -> Option<Arc<dyn Backend>> {
        self.pool.as_ref()?;
        Some(Arc::new(Self::new(self.threads)))
    }
}

#[cfg(test)]
mod tests;
