//! A whole fit as PhysTwin counts it: 20 generations of 11 candidates, then 200 passes, over 100
//! frames, through the same [`FitJob`] that a worker runs, timed by stage.

mod target;

use std::{sync::Arc, time::Instant};

use bendtwin_core::{
    CancelToken, FitSettings, Observer, Progress, Stage,
    environment::ControlVelocity,
    settings::{GradientWindow, RefineSettings, SearchSettings},
};
use bendtwin_engine::Backend;
use bendtwin_fit::FitJob;
use serde::Serialize;

use crate::{
    Error, MemoryProbe,
    scene::Scene,
    timed::{TimeSpent, TimedBackend},
};

/// The frequency of the refinement's steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Scheme {
    /// A step of Adam a frame, the gradient cut at each frame's start: PhysTwin's scheme, with its
    /// learning rate.
    Frame,
    /// A step of Adam a pass, the gradient through all frames: this project's default.
    Pass,
    /// A step of Adam a pass, the gradient cut at each frame's start as PhysTwin cuts it, so that a
    /// GPU runs all frames backward side by side.
    Cut,
}

/// Learning rate of [`Scheme::Cut`]: of 0.05, 0.1, 0.2 and 0.4 the one with the least final loss
/// (4.7, 4.3, 0.9 and 1.4 in 1e-9) in
/// `cargo lab bench rope --backend cpu --bending without --fit cut --frames 10 --generations 2`.
const CUT_RATE: f64 = 0.2;

impl Scheme {
    /// Name on the command line.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Frame => "frame",
            Self::Pass => "pass",
            Self::Cut => "cut",
        }
    }
}

/// The plan of a whole fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct FitPlan {
    /// The frequency of the refinement's steps.
    pub scheme: Scheme,
    /// Frames of the capture, the initial one included: at least 2.
    pub frames: usize,
    /// Generations of the search.
    pub generations: u32,
    /// Candidates a generation.
    pub candidates: usize,
    /// Passes of the refinement.
    pub passes: u32,
}

impl FitPlan {
    /// PhysTwin's counts: 220 candidates, 200 passes, 100 frames.
    pub const fn phystwin(scheme: Scheme) -> Self {
        Self { scheme, frames: 100, generations: 20, candidates: 11, passes: 200 }
    }
}

/// A whole fit, timed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FitRun {
    /// Plan of the fit.
    pub plan: FitPlan,
    /// Reading the capture and all generations: sampling, graphs, CMA-ES.
    pub search: SearchTime,
    /// All passes.
    pub refine: RefineTime,
    /// Scoring the twin, with rollouts of the whole capture.
    pub evaluate_s: f64,
    /// From the capture to the twin.
    pub total_s: f64,
    /// Best loss of the first generation; without a search, the first of the refinement.
    pub initial_loss: Option<f64>,
    /// Best loss of the search.
    pub search_loss: Option<f64>,
    /// Best loss of the refinement.
    pub final_loss: Option<f64>,
    /// The most memory seen in use after an iteration [bytes].
    pub memory_bytes: Option<u64>,
}

/// Time of the search by kind of work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct SearchTime {
    /// All of it.
    pub total_s: f64,
    /// Candidates that were simulated; the others would have needed more substeps than the scene
    /// has.
    pub rollouts: u64,
    /// Rollouts with their losses.
    pub forward_s: f64,
    /// Loading candidates.
    pub load_s: f64,
    /// Everything else: joining nodes, estimating stability, CMA-ES.
    pub host_s: f64,
}

/// Time of the refinement by kind of work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct RefineTime {
    /// All of it.
    pub total_s: f64,
    /// Forward and backward with losses.
    pub gradient_s: f64,
    /// Rollouts that score a pass, or with one step a pass its end alone.
    pub forward_s: f64,
    /// Steps of Adam, and what it takes to simulate with the new parameters.
    pub step_s: f64,
    /// Transfers of parameters, and new loading where substeps change.
    pub params_s: f64,
    /// Everything else: estimating stability, checkpoints.
    pub host_s: f64,
}

/// Times the fit of a capture that is simulated with hidden parameters. The time of simulating the
/// capture does not count.
///
/// # Errors
/// If the backend or the fit fails, or on cancellation.
pub fn whole_fit(
    scene: &Scene,
    backend: &Arc<dyn Backend>,
    plan: &FitPlan,
    memory: &dyn MemoryProbe,
    cancel: &CancelToken,
) -> Result<FitRun, Error> {
    let capture = target::capture(scene, plan.frames, &**backend, cancel)?;
    let timed = Arc::new(TimedBackend::new(Arc::clone(backend)));
    let began = Instant::now();
    let mut timer = StageTimer::new(timed.clone(), began, memory);
    let job = FitJob {
        capture: &capture,
        capture_digest: String::new(),
        settings: settings(scene, plan),
        backend: timed,
        look: None,
    };
    job.run(None, &mut timer, cancel)?;
    let total_s = began.elapsed().as_secs_f64();
    Ok(timer.run(*plan, total_s))
}

/// PhysTwin's settings at the scene's substeps, the true velocity of control points apart.
fn settings(scene: &Scene, plan: &FitPlan) -> FitSettings {
    let published = FitSettings::phystwin();
    let pass = RefineSettings {
        window: GradientWindow::Pass,
        rest_shape: false,
        ..RefineSettings::default()
    };
    let refine = match plan.scheme {
        Scheme::Frame => RefineSettings { window: GradientWindow::Frame, ..published.refine },
        Scheme::Pass => pass,
        Scheme::Cut => RefineSettings { reach: Some(1), learning_rate: CUT_RATE, ..pass },
    };
    FitSettings {
        bending: scene.bending,
        control_velocity: ControlVelocity::True,
        search: SearchSettings {
            generations: Some(plan.generations),
            population: Some(plan.candidates),
            ..published.search
        },
        refine: RefineSettings { passes: Some(plan.passes), ..refine },
        ..FitSettings::phystwin()
    }
}

/// The end of a stage: time since the start [s], and time spent in calls until then.
#[derive(Clone, Copy, Debug, Default)]
struct StageEnd {
    at_s: f64,
    spent: TimeSpent,
    best_loss: Option<f64>,
}

/// Records the ends of stages.
struct StageTimer<'a> {
    timed: Arc<TimedBackend>,
    began: Instant,
    memory: &'a dyn MemoryProbe,
    memory_bytes: Option<u64>,
    initial_loss: Option<f64>,
    search: StageEnd,
    refine: Option<StageEnd>,
}

impl<'a> StageTimer<'a> {
    fn new(timed: Arc<TimedBackend>, began: Instant, memory: &'a dyn MemoryProbe) -> Self {
        let (search, refine) = (StageEnd::default(), None);
        Self { timed, began, memory, memory_bytes: None, initial_loss: None, search, refine }
    }

    fn run(&self, plan: FitPlan, total_s: f64) -> FitRun {
        let (search, refine) = (self.search, self.refine.unwrap_or(self.search));
        let (first, then) = (search.spent, refine.spent - search.spent);
        let refine_s = refine.at_s - search.at_s;
        FitRun {
            plan,
            search: SearchTime {
                total_s: search.at_s,
                rollouts: first.rollouts,
                forward_s: first.forward_s,
                load_s: first.load_s,
                host_s: search.at_s - first.total_s(),
            },
            refine: RefineTime {
                total_s: refine_s,
                gradient_s: then.gradient_s,
                forward_s: then.forward_s,
                step_s: then.step_s,
                params_s: then.params_s + then.load_s,
                host_s: refine_s - then.total_s(),
            },
            evaluate_s: total_s - refine.at_s,
            total_s,
            initial_loss: self.initial_loss,
            search_loss: search.best_loss,
            final_loss: refine.best_loss,
            memory_bytes: self.memory_bytes,
        }
    }
}

impl Observer<Progress> for StageTimer<'_> {
    fn progress(&mut self, progress: Progress) {
        let end = || StageEnd {
            at_s: self.began.elapsed().as_secs_f64(),
            spent: self.timed.spent(),
            best_loss: progress.best_loss,
        };
        match progress.stage {
            Stage::Search => self.search = end(),
            Stage::Refine => self.refine = Some(end()),
            Stage::Ingest | Stage::Evaluate | Stage::Appearance => {}
        }
        self.initial_loss = self.initial_loss.or(progress.loss);
        // Asked while everything that the fit needs is in memory, and after the clock.
        self.memory_bytes = self.memory_bytes.max(self.memory.used_bytes());
    }
}

#[cfg(test)]
mod tests;
