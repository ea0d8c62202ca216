use std::sync::atomic::{AtomicUsize, Ordering};

use bendtwin_core::{
    Environment, FitSettings, Observer, Params, Progress, Stage, settings::GradientWindow,
};
use bendtwin_engine::{
    Device, Loaded, Model,
    backend::{Error as EngineError, Gradient, Loss, Outputs, Rollout},
    optimizer::HostOptimizer,
};
use bendtwin_synth::{MakeOptions, Scene, make};

use crate::FitJob;

use bendtwin_core::settings::DeviceKind;

use super::*;

/// The CPU backend with a counter; on request, every gradient is not finite, but losses are as they
/// should be.
#[derive(Clone)]
struct Watched {
    cpu: Arc<dyn Backend>,
    explodes: bool,
    /// Calls of `losses`.
    scored: Arc<AtomicUsize>,
    /// Reach of the last gradients.
    cut_every: Arc<AtomicUsize>,
}

impl Watched {
    fn new(explodes: bool) -> Self {
        let cpu = bendtwin_engine::cpu_with_threads(1);
        Self { cpu, explodes, scored: Arc::default(), cut_every: Arc::default() }
    }
}

impl Backend for Watched {
    fn device(&self) -> Device {
        self.cpu.device()
    }
    fn load(&self, model: Arc<Model>) -> Result<Loaded, EngineError> {
        self.cpu.load(model)
    }
    fn with_params(&self, loaded: &Loaded, params: Params) -> Result<Loaded, EngineError> {
        self.cpu.with_params(loaded, params)
    }
    fn with_environment(
        &self,
        loaded: &Loaded,
        environment: Environment,
    ) -> Result<Loaded, EngineError> {
        self.cpu.with_environment(loaded, environment)
    }
    fn roll_out(
        &self,
        batch: &[Instance],
        outputs: &Outputs,
        cancel: &CancelToken,
    ) -> Result<Vec<Rollout>, EngineError> {
        self.cpu.roll_out(batch, outputs, cancel)
    }
    fn losses(&self, batch: &[Instance], cancel: &CancelToken) -> Result<Vec<Loss>, EngineError> {
        self.scored.fetch_add(1, Ordering::Relaxed);
        self.cpu.losses(batch, cancel)
    }
    fn gradients(
        &self,
        batch: &[Instance],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<Gradient>, EngineError> {
        self.cut_every.store(request.cut_every, Ordering::Relaxed);
        let gradients = self.cpu.gradients(batch, request, cancel)?;
        let spoilt = |g: Gradient| Gradient { overflowed: g.overflowed || self.explodes, ..g };
        Ok(gradients.into_iter().map(spoilt).collect())
    }
    fn optimizer(
        &self,
        inits: Vec<OptimizerInit>,
        decay: Decay,
    ) -> Result<Box<dyn Optimizer>, EngineError> {
        Ok(Box::new(HostOptimizer::new(Arc::new(self.clone()), inits, decay)?))
    }
}

#[derive(Default)]
struct Passes(Vec<Progress>);

impl Observer<Progress> for Passes {
    fn progress(&mut self, progress: Progress) {
        if progress.stage == Stage::Refine {
            self.0.push(progress);
        }
    }
}

/// A fit that is refinement alone.
fn settings(passes: u32) -> FitSettings {
    let mut settings = FitSettings { compare_axial: false, ..FitSettings::default() };
    settings.graph.max_nodes = Some(24);
    settings.search.generations = Some(0);
    settings.refine.passes = Some(passes);
    settings
}

#[test]
fn a_gradient_that_is_not_finite_takes_no_step() {
    let capture = make(Scene::Rope, &MakeOptions::tiny(2)).unwrap();
    let (settings, backend) = (settings(2), Arc::new(Watched::new(true)));
    let job = FitJob {
        capture: &capture,
        capture_digest: "digest".into(),
        settings,
        backend,
        look: None,
    };
    let mut passes = Passes::default();
    job.run(None, &mut passes, &CancelToken::default()).unwrap();
    assert_eq!(passes.0.len(), 2);
    for pass in &passes.0 {
        let note = pass.note.as_deref().unwrap_or_default();
        assert!(note.contains("gradient is not finite"), "{note}");
        assert_eq!(pass.loss, pass.best_loss, "it stays where it started");
    }
    assert_eq!(passes.0[0].best_loss, passes.0[1].best_loss);
}

/// The loss that a fit reports of its best parameters is that of a rollout of its twin, however it
/// was computed, and whether steps led downhill or, being far too long, anywhere.
#[test]
fn the_best_loss_is_the_twins() {
    let capture = make(Scene::Cable, &MakeOptions::tiny(2)).unwrap();
    for (window, rate, passes) in [
        (GradientWindow::Pass, 0.02, 3),
        (GradientWindow::Pass, 1.0, 9),
        (GradientWindow::Pass, 0.02, 0),
        (GradientWindow::Frames(9), 0.02, 2),
    ] {
        let mut settings = settings(passes);
        (settings.refine.window, settings.refine.learning_rate) = (window, rate);
        let backend: Arc<dyn Backend> = Arc::new(Watched::new(false));
        let (digest, of) = ("digest".into(), settings.clone());
        let job = FitJob {
            capture: &capture,
            capture_digest: digest,
            settings: of,
            backend: backend.clone(),
            look: None,
        };
        let (mut seen, cancel) = (Passes::default(), CancelToken::default());
        let twin = job.run(None, &mut seen, &cancel).unwrap().twin;
        let losses: Vec<f64> = seen.0.iter().filter_map(|p| p.best_loss).collect();
        assert!(losses.is_sorted_by(|a, b| a >= b), "{losses:?}");
        let task =
            Task::new(&capture, &settings, DeviceKind::Cpu, &CancelToken::default()).unwrap();
        let loaded = backend.load(Arc::new(Model::from(&twin))).unwrap();
        let batch: Vec<_> = task.training.iter().map(|t| t.instance(&loaded)).collect();
        let loss = task.loss(backend.losses(&batch, &cancel).unwrap().iter().map(|l| l.total));
        assert!(loss.is_finite());
        assert!(losses.last().is_none_or(|best| *best == loss), "{window:?}: {loss} {losses:?}");
    }
}

#[test]
fn gradients_reach_as_far_as_the_settings_say() {
    let capture = make(Scene::Rope, &MakeOptions::tiny(2)).unwrap();
    for reach in [0, 1, 5] {
        let (mut settings, backend) = (settings(1), Watched::new(false));
        settings.refine.reach = Some(reach);
        let (cut_every, backend) = (backend.cut_every.clone(), Arc::new(backend));
        let job = FitJob {
            capture: &capture,
            capture_digest: "digest".into(),
            settings,
            backend,
            look: None,
        };
        job.run(None, &mut (), &CancelToken::default()).unwrap();
        assert_eq!(cut_every.load(Ordering::Relaxed), reach as usize);
    }
}

/// Apart from its end, a run of single steps is scored by its gradients.
#[test]
fn a_pass_of_one_step_needs_no_rollout_beside() {
    let capture = make(Scene::Cable, &MakeOptions::tiny(2)).unwrap();
    let scored = |window: GradientWindow| {
        let backend = Watched::new(false);
        let scored = backend.scored.clone();
        let mut settings = settings(4);
        settings.refine.window = window;
        let backend = Arc::new(backend);
        let job = FitJob {
            capture: &capture,
            capture_digest: "digest".into(),
            settings,
            backend,
            look: None,
        };
        let mut before_the_end = Counting { scored, after_passes: Vec::new() };
        job.run(None, &mut before_the_end, &CancelToken::default()).unwrap();
        before_the_end.after_passes
    };
    let once = scored(GradientWindow::Pass);
    assert!(once[..3].iter().all(|&n| n == 0), "{once:?}");
    assert!(once[3] > 0, "where it ends has to be measured: {once:?}");
    let each = scored(GradientWindow::Frames(9));
    assert!(each.is_sorted_by(|a, b| a < b) && each[0] > 0, "{each:?}");
}

/// The passes of a shorter fit are the first ones of a longer one.
#[test]
fn more_passes_never_end_at_a_larger_loss() {
    let capture = make(Scene::Rope, &MakeOptions::tiny(2)).unwrap();
    let best_losses = |passes: u32| -> Vec<f64> {
        let job = FitJob {
            capture: &capture,
            capture_digest: "digest".into(),
            settings: settings(passes),
            backend: Arc::new(Watched::new(false)),
            look: None,
        };
        let mut seen = Passes::default();
        job.run(None, &mut seen, &CancelToken::default()).unwrap();
        seen.0.iter().filter_map(|p| p.best_loss).collect()
    };
    let (short, long) = (best_losses(12), best_losses(36));
    assert_eq!((short.len(), long.len()), (12, 36));
    assert_eq!(short[..11], long[..11], "where the last step led to is measured after it");
    assert!(long[35] <= short[11], "{short:?} {long:?}");
    assert!(long[35] < long[0], "{long:?}");
}

/// Notes how often losses were asked for after every pass.
struct Counting {
    scored: Arc<AtomicUsize>,
    after_passes: Vec<usize>,
}

impl Observer<Progress> for Counting {
    fn progress(&mut self, progress: Progress) {
        if progress.stage == Stage::Refine {
            self.after_passes.push(self.scored.load(Ordering::Relaxed));
        }
    }
}
