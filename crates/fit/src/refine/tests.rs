use bendtwin_capture::{MakeOptions, Scene, make};
use bendtwin_core::{FitSettings, Params, Progress, Stage};
use bendtwin_engine::{
    Device, Loaded, Model,
    backend::{Error as EngineError, Gradient, Loss, Recording, Rollout},
    descent::HostDescent,
};

use crate::{FitJob, Observer, ObserverError};

use super::*;

/// The CPU, but every gradient has left the finite numbers on its way; losses are as they should be.
#[derive(Clone)]
struct Exploding(Arc<dyn Backend>);

impl Backend for Exploding {
    fn device(&self) -> Device {
        self.0.device()
    }
    fn load(&self, model: Arc<Model>) -> Result<Loaded, EngineError> {
        self.0.load(model)
    }
    fn with_params(&self, loaded: &Loaded, params: Params) -> Result<Loaded, EngineError> {
        self.0.with_params(loaded, params)
    }
    fn roll_out(
        &self,
        batch: &[Instance],
        recording: &Recording,
        cancel: &CancelToken,
    ) -> Result<Vec<Rollout>, EngineError> {
        self.0.roll_out(batch, recording, cancel)
    }
    fn losses(&self, batch: &[Instance], cancel: &CancelToken) -> Result<Vec<Loss>, EngineError> {
        self.0.losses(batch, cancel)
    }
    fn gradients(
        &self,
        batch: &[Instance],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<Gradient>, EngineError> {
        let gradients = self.0.gradients(batch, request, cancel)?;
        Ok(gradients.into_iter().map(|g| Gradient { overflowed: true, ..g }).collect())
    }
    fn descent(&self, starts: Vec<Start>, decay: Decay) -> Result<Box<dyn Descent>, EngineError> {
        Ok(Box::new(HostDescent::new(Arc::new(self.clone()), starts, decay)?))
    }
}

#[derive(Default)]
struct Passes(Vec<Progress>);

impl Observer for Passes {
    fn progress(&mut self, progress: Progress) {
        if progress.stage == Stage::Refine {
            self.0.push(progress);
        }
    }
    fn checkpoint(&mut self, _: Vec<u8>) -> Result<(), ObserverError> {
        Ok(())
    }
}

#[test]
fn a_gradient_that_is_not_finite_takes_no_step() {
    let capture = make(Scene::Rope, &MakeOptions::tiny(2)).unwrap();
    let mut settings = FitSettings { compare_axial: false, ..FitSettings::default() };
    settings.graph.max_nodes = 24;
    settings.search.generations = 0;
    settings.refine.passes = 2;
    let backend = Arc::new(Exploding(bendtwin_engine::cpu_with_threads(1)));
    let job = FitJob { capture: &capture, capture_digest: "digest".into(), settings, backend };
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
