use std::sync::{
    Mutex,
    atomic::{AtomicUsize, Ordering},
};

use bendtwin_core::{Capture, Environment, FitSettings, Params};
use bendtwin_engine::{
    Model,
    backend::{
        Device, Error as EngineError, Gradient, GradientRequest, Instance, Loss, Outputs, Rollout,
    },
    optimizer::{Decay, Optimizer, OptimizerInit},
};
use bendtwin_synth::{MakeOptions, Scene, make};

use bendtwin_core::settings::DeviceKind;

use super::*;
use crate::job::{checkpoint::ModelFitState, model_fit::ModelFit};

/// Counts the models that are loaded at a time, and notes the sizes of batches.
#[derive(Default)]
struct Counts {
    loaded: AtomicUsize,
    most: AtomicUsize,
    batches: Mutex<Vec<usize>>,
}

struct Counting {
    cpu: Arc<dyn Backend>,
    counts: Arc<Counts>,
}

/// A model that counts until it is dropped.
struct CountedModel {
    inner: Loaded,
    counts: Arc<Counts>,
}

impl Drop for CountedModel {
    fn drop(&mut self) {
        self.counts.loaded.fetch_sub(1, Ordering::SeqCst);
    }
}

impl Backend for Counting {
    fn device(&self) -> Device {
        self.cpu.device()
    }
    fn load(&self, model: Arc<Model>) -> Result<Loaded, EngineError> {
        let inner = self.cpu.load(model)?;
        let now = self.counts.loaded.fetch_add(1, Ordering::SeqCst) + 1;
        self.counts.most.fetch_max(now, Ordering::SeqCst);
        let (model, counts) = (inner.model().clone(), self.counts.clone());
        Ok(Loaded::new(model, Arc::new(CountedModel { inner, counts })))
    }
    fn with_params(&self, _: &Loaded, _: Params) -> Result<Loaded, EngineError> {
        panic!("a search loads")
    }
    fn with_environment(&self, _: &Loaded, _: Environment) -> Result<Loaded, EngineError> {
        unreachable!("no test changes the environment")
    }
    fn roll_out(
        &self,
        _: &[Instance],
        _: &Outputs,
        _: &CancelToken,
    ) -> Result<Vec<Rollout>, EngineError> {
        panic!("a search needs losses")
    }
    fn losses(&self, batch: &[Instance], cancel: &CancelToken) -> Result<Vec<Loss>, EngineError> {
        self.counts.batches.lock().unwrap().push(batch.len());
        let inner = |i: &Instance| {
            let model = i.model.resident::<CountedModel>().unwrap().inner.clone();
            Instance { model, ..i.clone() }
        };
        let batch: Vec<Instance> = batch.iter().map(inner).collect();
        self.cpu.losses(&batch, cancel)
    }
    fn gradients(
        &self,
        _: &[Instance],
        _: &GradientRequest,
        _: &CancelToken,
    ) -> Result<Vec<Gradient>, EngineError> {
        panic!("a search needs losses")
    }
    fn optimizer(
        &self,
        _: Vec<OptimizerInit>,
        _: Decay,
    ) -> Result<Box<dyn Optimizer>, EngineError> {
        panic!("a search has none")
    }
}

/// Losses of two generations with `most_loaded` candidates loaded at a time, and what was counted.
fn generations(capture: &Capture, most_loaded: usize) -> (Vec<Vec<f64>>, Vec<usize>, usize) {
    let mut settings = FitSettings { seed: 3, ..FitSettings::default() };
    settings.graph.max_nodes = Some(16);
    settings.search.population = Some(101);
    settings.search.topology = true;
    // Few enough that some candidates are too stiff.
    settings.substeps = bendtwin_core::settings::Substeps::Auto { safety: 1.1, max: Some(25) };
    let task = Task::new(capture, &settings, DeviceKind::Cpu, &CancelToken::default()).unwrap();
    let mut models = ModelFit::all(&task);
    let counts = Arc::new(Counts::default());
    let backend =
        Counting { cpu: bendtwin_engine::cpu_with_threads(2), counts: Arc::clone(&counts) };
    let mut search = Search::new(&task).with_most_loaded(most_loaded);
    let mut losses = Vec::new();
    for _ in 0..2 {
        let ModelFit { space, state: ModelFitState::Search(strategy), .. } = &mut models[0] else {
            panic!("it is in the search")
        };
        let mut searchers = [Searcher { model: 0, space, strategy }];
        let made = search.generation(&mut searchers, &backend, &CancelToken::default()).unwrap();
        assert!(made[0].failures.too_stiff > 0, "none is too stiff");
        losses.push(made[0].losses.clone());
    }
    assert_eq!(counts.loaded.load(Ordering::SeqCst), 0);
    let batches = counts.batches.lock().unwrap().clone();
    (losses, batches, counts.most.load(Ordering::SeqCst))
}

#[test]
fn a_generation_in_parts_has_the_same_losses_from_the_same_batches() {
    let capture = make(Scene::Rope, &MakeOptions::tiny(2)).unwrap();
    let (losses, batches, most) = generations(&capture, usize::MAX);
    assert!(most > 20, "{most} candidates are stable");
    let of_slice = 4;
    for most_loaded in [1, 7] {
        let (in_parts, same_batches, most) = generations(&capture, most_loaded);
        assert_eq!((&in_parts, &same_batches), (&losses, &batches), "{most_loaded}");
        // One part, and what did not fill a slice before.
        assert!(most <= most_loaded.max(of_slice) + of_slice, "{most}");
    }
}
