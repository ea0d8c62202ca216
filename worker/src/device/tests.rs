use std::sync::{
    Mutex,
    atomic::{AtomicUsize, Ordering},
};

use bendtwin_core::{CancelToken, Environment, Graph, NodeKind, Params, Timing};
use bendtwin_engine::{
    Loaded, Model, Objective,
    backend::{Error as EngineError, Gradient, GradientRequest, Instance, Loss, Outputs, Rollout},
    model::State,
    optimizer::{
        Decay, GradientSample, HostOptimizer, Optimizer, OptimizerInit, Parameter,
        Parameterization, Position, Scale,
    },
};
use bendtwin_rollout::RolloutBackend as _;

use super::*;

/// Takes a set time for every instance and answers with the instance's frame count.
#[derive(Clone, Default)]
struct Slow {
    kind: &'static str,
    each: Duration,
    /// Sizes of the batches seen.
    batches: Arc<Mutex<Vec<usize>>>,
    panics: bool,
    /// Fails as a device does.
    fails: bool,
    /// Slices of rollouts after which one stands still until it is cancelled.
    stops_after: Option<usize>,
    /// The second queue.
    urgent: Option<Arc<Slow>>,
}

impl Slow {
    fn run(&self, batch: &[Instance]) -> Vec<f64> {
        assert!(!self.panics, "the device is broken");
        self.batches.lock().unwrap().push(batch.len());
        std::thread::sleep(self.each * batch.len() as u32);
        batch.iter().map(|i| i.frames as f64).collect()
    }
}

impl Backend for Slow {
    fn device(&self) -> Description {
        Description { kind: self.kind.into(), name: "slow".into(), lanes: 2 }
    }
    fn load(&self, model: Arc<Model>) -> Result<Loaded, EngineError> {
        Ok(Loaded::new(model, Arc::new(())))
    }
    fn with_params(&self, loaded: &Loaded, _: Params) -> Result<Loaded, EngineError> {
        Ok(loaded.clone())
    }
    fn with_environment(&self, _: &Loaded, _: Environment) -> Result<Loaded, EngineError> {
        unreachable!("no test changes the environment")
    }
    fn roll_out(
        &self,
        batch: &[Instance],
        _: &Outputs,
        cancel: &CancelToken,
    ) -> Result<Vec<Rollout>, EngineError> {
        let done = self.batches.lock().unwrap().len();
        if self.stops_after.is_some_and(|slices| done >= slices) {
            while !cancel.is_cancelled() {
                std::thread::sleep(Duration::from_millis(1));
            }
            return Err(EngineError::Cancelled);
        }
        let costs = self.run(batch).into_iter();
        if self.fails {
            return Err(EngineError::Device("a launch failed".into()));
        }
        Ok(costs.map(|cost| Rollout { cost, ..Rollout::default() }).collect())
    }
    fn losses(&self, batch: &[Instance], _: &CancelToken) -> Result<Vec<Loss>, EngineError> {
        let totals = self.run(batch).into_iter();
        Ok(totals.map(|total| Loss { total, ..Loss::default() }).collect())
    }
    fn gradients(
        &self,
        batch: &[Instance],
        _: &GradientRequest,
        _: &CancelToken,
    ) -> Result<Vec<Gradient>, EngineError> {
        self.run(batch);
        let one = |i: &Instance| {
            let params = Params { drag: i.frames as f32, ..Params::default() };
            Gradient { params, ..Gradient::default() }
        };
        Ok(batch.iter().map(one).collect())
    }
    fn optimizer(
        &self,
        inits: Vec<OptimizerInit>,
        decay: Decay,
    ) -> Result<Box<dyn Optimizer>, EngineError> {
        Ok(Box::new(HostOptimizer::new(Arc::new(self.clone()), inits, decay)?))
    }
    fn urgent(&self) -> Option<Arc<dyn Backend>> {
        self.urgent.clone().map(|urgent| urgent as _)
    }
}

fn device(backend: Slow) -> (Device, mpsc::UnboundedReceiver<Error>) {
    let (fatal, died) = mpsc::unbounded_channel();
    (Device::spawn(move || Ok(Arc::new(backend) as _), fatal, 0.25).unwrap(), died)
}

fn instances(backend: &QueuedBackend, frames: impl IntoIterator<Item = usize>) -> Vec<Instance> {
    let graph = Graph {
        rest_positions: vec![[0.0; 3]],
        kinds: vec![NodeKind::Interior],
        masses: vec![1.0],
        object_ids: vec![0],
        observed_points: vec![Graph::NOT_OBSERVED],
        ..Graph::default()
    };
    let model = Model {
        graph: Arc::new(graph),
        skin: Arc::default(),
        params: Params::default(),
        environment: Environment::Z_UP,
        timing: Timing { fps: 30.0, substeps: 10 },
        control_velocity: Default::default(),
    };
    let model = backend.load(Arc::new(model)).unwrap();
    let instance = |frames| Instance {
        model: model.clone(),
        initial: Arc::new(State::default()),
        controls: Arc::new(Vec::new()),
        frames,
        objective: Objective::default(),
        world: Arc::default(),
        motion: Arc::default(),
    };
    frames.into_iter().map(instance).collect()
}

#[test]
fn results_come_back_in_order_for_any_slices() {
    let (device, _died) = device(Slow::default());
    let backend = device.backend(Priority::Background);
    let frames: Vec<usize> = (1..=23).map(|i| i * 7 % 11 + 1).collect();
    let losses =
        backend.losses(&instances(&backend, frames.clone()), &CancelToken::default()).unwrap();
    let expected: Vec<f64> = frames.iter().map(|f| *f as f64).collect();
    assert_eq!(losses.iter().map(|l| l.total).collect::<Vec<_>>(), expected);
}

#[test]
fn a_rollout_is_answered_while_a_long_fit_batch_runs() {
    let (device, _died) = device(Slow { each: Duration::from_millis(20), ..Slow::default() });
    let fit = device.backend(Priority::Background);
    let batch = instances(&fit, std::iter::repeat_n(1, 100));
    let done = Arc::new(AtomicUsize::new(0));
    let finished = Arc::clone(&done);
    let fitting = std::thread::spawn(move || {
        let losses = fit.losses(&batch, &CancelToken::default()).unwrap();
        finished.store(losses.len(), Ordering::SeqCst);
    });
    std::thread::sleep(Duration::from_millis(100));
    let backend = device.backend(Priority::Interactive);
    let started = Instant::now();
    let rollout = instances(&backend, [3]);
    let costs = backend.roll_out(&rollout, &Outputs::default(), &CancelToken::default()).unwrap();
    // The whole batch takes two seconds, a slice one round of lanes: 40 ms.
    assert!(started.elapsed() < Duration::from_millis(800), "{:?}", started.elapsed());
    assert_eq!(done.load(Ordering::SeqCst), 0, "the fit must still be running");
    assert_eq!(costs[0].cost, 3.0);
    fitting.join().unwrap();
    assert_eq!(done.load(Ordering::SeqCst), 100);
}

#[test]
fn slices_grow_to_what_a_slices_time_holds() {
    let batches = Arc::new(Mutex::new(Vec::new()));
    let slow = Slow { each: Duration::from_millis(5), batches: batches.clone(), ..Slow::default() };
    let (device, _died) = device(slow);
    let backend = device.backend(Priority::Background);
    backend
        .losses(&instances(&backend, std::iter::repeat_n(1, 60)), &CancelToken::default())
        .unwrap();
    let sizes = batches.lock().unwrap().clone();
    assert_eq!(sizes.iter().sum::<usize>(), 60);
    assert_eq!(sizes[0], 2, "the first slice is one round of the lanes");
    // 30 ms, in whole rounds of two.
    assert!(sizes.iter().all(|s| *s <= 6), "{sizes:?}");
    // How much they grow depends on how late a busy machine wakes the thread.
    assert!(sizes.iter().any(|s| *s > 2), "{sizes:?}");
}

#[test]
fn cancellation_ends_a_batch_between_slices() {
    let (device, _died) = device(Slow { each: Duration::from_millis(10), ..Slow::default() });
    let backend = device.backend(Priority::Background);
    let batch = instances(&backend, std::iter::repeat_n(1, 1000));
    let cancel = CancelToken::default();
    let remote = cancel.clone();
    std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(100));
        remote.cancel();
    });
    let started = Instant::now();
    assert_eq!(backend.losses(&batch, &cancel), Err(EngineError::Cancelled));
    assert!(started.elapsed() < Duration::from_secs(1));
}

#[test]
fn what_is_not_done_in_time_is_missing_and_the_rest_is_there() {
    let (device, _died) = device(Slow { stops_after: Some(1), ..Slow::default() });
    let backend = device.backend(Priority::Interactive);
    let batch = instances(&backend, [1, 3, 2, 4, 1]);
    let in_time = |cancel: &CancelToken| {
        let done = backend.roll_out_in_time(&batch, &Outputs::default(), cancel).unwrap();
        done.into_iter().map(|rollout| rollout.map(|r| r.cost)).collect::<Vec<_>>()
    };
    let cancel = CancelToken::default();
    // The first slice has the largest two; the second one would never end.
    let limited = cancel.until(Instant::now() + Duration::from_secs(1));
    assert_eq!(in_time(&limited), [None, Some(3.0), None, Some(4.0), None]);
    assert_eq!(in_time(&limited), [None; 5]);
}

#[test]
fn a_panic_is_caught_and_reported() {
    let (device, mut died) = device(Slow { panics: true, ..Slow::default() });
    let backend = device.backend(Priority::Interactive);
    let batch = instances(&backend, [1]);
    let result = backend.losses(&batch, &CancelToken::default());
    assert!(matches!(result, Err(EngineError::Device(_))), "{result:?}");
    assert_eq!(device.broken_by(), Some(Priority::Interactive));
    let fatal = died.blocking_recv();
    assert!(matches!(fatal, Some(Error::Panicked(text)) if text.contains("broken")));
    // Later callers do not wait for a thread that is gone.
    assert!(backend.losses(&batch, &CancelToken::default()).is_err());
}

#[test]
fn an_optimizer_measures_in_slices_and_keeps_the_order_of_its_gradients() {
    let slow = Slow { each: Duration::from_millis(2), ..Slow::default() };
    let batches = slow.batches.clone();
    let direct = slow.clone();
    let (device, _died) = device(slow);
    let backend = device.backend(Priority::Background);
    let frames: Vec<usize> = (1..=9).map(|i| i * 7 % 11 + 1).collect();
    let instances = instances(&backend, frames.clone());
    let parameterization = Parameterization::new(Params { drag: 1.0, ..Params::default() });
    let parameterization =
        parameterization.with(Parameter::Drag, Scale::Linear, 1.0, |_| [0.0, 2.0]);
    let position = parameterization.at_rest(parameterization.start());
    let init = OptimizerInit { loaded: instances[0].model.clone(), parameterization, position };
    let sample = |instance: &Instance| GradientSample { run: 0, instance: instance.clone() };
    let samples: Vec<GradientSample> = instances.iter().map(sample).collect();
    let decay = Decay { beta1: 0.9, beta2: 0.99, prior: 0.7 };
    // A gradient in the wrong place would change the moments.
    let weights: Vec<f64> = frames.iter().enumerate().map(|(i, f)| i as f64 / *f as f64).collect();
    let measured = |backend: &dyn Backend| {
        let mut optimizer = backend.optimizer(vec![init.clone()], decay).unwrap();
        let request = GradientRequest::default();
        let norms = optimizer.measure(&samples, &request, &CancelToken::default()).unwrap();
        optimizer.step(0, &weights, 0.1).unwrap();
        (norms, optimizer.position(0).unwrap())
    };
    let queued = measured(&backend);
    assert!(batches.lock().unwrap().len() > 1, "one slice is no test");
    assert_eq!(queued, measured(&direct));
    let norms: Vec<f64> = queued.0.iter().map(|s| s.norm).collect();
    assert_eq!(norms, frames.iter().map(|f| *f as f64).collect::<Vec<_>>());
    assert!(backend.compute() > Duration::ZERO);
}

#[test]
fn an_optimizer_is_dropped_on_the_device_thread() {
    let (device, _died) = device(Slow::default());
    let backend = device.backend(Priority::Background);
    let loaded = instances(&backend, [1])[0].model.clone();
    let parameterization = Parameterization::new(Params::default());
    let init = OptimizerInit { loaded, parameterization, position: Position::default() };
    let optimizer =
        backend.optimizer(vec![init], Decay { beta1: 0.9, beta2: 0.99, prior: 0.7 }).unwrap();
    drop(optimizer);
    // Jobs of one priority run in order, so by now it is gone, and the device still works.
    assert_eq!(
        backend.losses(&instances(&backend, [5]), &CancelToken::default()).unwrap()[0].total,
        5.0
    );
}

/// A device with two queues; the second takes no time.
fn two_queues(urgent: Slow) -> (Device, mpsc::UnboundedReceiver<Error>) {
    let each = Duration::from_millis(400);
    device(Slow { kind: "cuda", each, urgent: Some(Arc::new(urgent)), ..Slow::default() })
}

fn roll_out(backend: &QueuedBackend) -> Result<Vec<Rollout>, EngineError> {
    backend.roll_out(&instances(backend, [3]), &Outputs::default(), &CancelToken::default())
}

#[test]
fn with_a_second_queue_rollouts_run_while_a_fits_slice_does() {
    let urgent = Slow::default();
    let answered = urgent.batches.clone();
    let (device, _died) = two_queues(urgent);
    let fit = device.backend(Priority::Background);
    let batch = instances(&fit, [1, 1]);
    let fitting = std::thread::spawn(move || {
        let losses = fit.losses(&batch, &CancelToken::default()).unwrap();
        (losses.len(), Instant::now())
    });
    let backend = device.backend(Priority::Interactive);
    let mut answers = 0;
    while !fitting.is_finished() {
        assert_eq!(roll_out(&backend).unwrap()[0].cost, 3.0);
        answers += 1;
    }
    let (fitted, _) = fitting.join().unwrap();
    assert_eq!(fitted, 2);
    // One slice of 0.8 s; with one queue at most two rollouts could come around it.
    assert!(answers > 2, "{answers} rollouts were answered meanwhile");
    assert_eq!(answered.lock().unwrap().len(), answers);
}

#[test]
fn what_breaks_in_one_queue_ends_both() {
    for broken in
        [Slow { panics: true, ..Slow::default() }, Slow { fails: true, ..Slow::default() }]
    {
        let (device, mut died) = two_queues(broken);
        assert!(matches!(
            roll_out(&device.backend(Priority::Interactive)),
            Err(EngineError::Device(_))
        ));
        assert!(matches!(died.blocking_recv(), Some(Error::Panicked(_) | Error::DeviceFailed(_))));
        assert_eq!(device.broken_by(), Some(Priority::Interactive));
        let fit = device.backend(Priority::Background);
        let model = Arc::new(Model {
            graph: Arc::new(Graph::default()),
            skin: Arc::default(),
            params: Params::default(),
            environment: Environment::Z_UP,
            timing: Timing { fps: 30.0, substeps: 10 },
            control_velocity: Default::default(),
        });
        assert!(matches!(fit.load(model), Err(EngineError::Device(_))));
        assert_eq!(device.broken_by(), Some(Priority::Interactive), "the fit found it broken");
    }
}

#[test]
fn with_a_second_queue_a_batch_is_always_cut_in_the_same_way() {
    let urgent = Slow { each: Duration::from_millis(1), ..Slow::default() };
    let batches = urgent.batches.clone();
    let (device, _died) = two_queues(urgent);
    let cancel = CancelToken::default();
    for _ in 0..2 {
        let backend = device.backend(Priority::Interactive);
        let batch = instances(&backend, std::iter::repeat_n(1, 20));
        backend.roll_out(&batch, &Outputs::default(), &cancel).unwrap();
    }
    assert_eq!(*batches.lock().unwrap(), [20, 20]);
}

/// Rollouts of this many slices each, one after another, until `stop`; counts the slices.
fn greedy(device: &Device, stop: &CancelToken) -> std::thread::JoinHandle<usize> {
    let (device, stop) = (device.clone(), stop.clone());
    std::thread::spawn(move || {
        let mut slices = 0;
        while !stop.is_cancelled() {
            let backend = device.backend(Priority::Interactive);
            // Slices of two instances: the first measures the speed, the others fill their time.
            let batch = instances(&backend, std::iter::repeat_n(1, 8));
            let _ = backend.roll_out(&batch, &Outputs::default(), &stop);
            slices += batch.len() / 2;
        }
        slices
    })
}

#[test]
fn a_fit_advances_beside_greedy_rollouts() {
    // A round of lanes fills a slice, both for rollouts and for the fit.
    let (device, _died) = device(Slow { each: Duration::from_millis(15), ..Slow::default() });
    let stop = CancelToken::default();
    let clients: Vec<_> = (0..4).map(|_| greedy(&device, &stop)).collect();
    let fit = device.backend(Priority::Background);
    let batch = instances(&fit, std::iter::repeat_n(1, 20));
    fit.losses(&batch, &CancelToken::default()).unwrap();
    stop.cancel();
    let rollouts: usize = clients.into_iter().map(|c| c.join().unwrap()).sum();
    // Its ten slices are a quarter of all; twice that is left for what happens at both ends.
    assert!(rollouts <= 60, "{rollouts} slices of rollouts beside 10 of the fit");
}

#[test]
fn a_small_rollout_passes_between_the_slices_of_large_ones() {
    let slow = Slow { each: Duration::from_millis(15), ..Slow::default() };
    let batches = slow.batches.clone();
    let (device, _died) = device(slow);
    let stop = CancelToken::default();
    let large: Vec<_> = (0..6)
        .map(|_| {
            let backend = device.backend(Priority::Interactive);
            let batch = instances(&backend, std::iter::repeat_n(1, 1_000));
            let stop = stop.clone();
            std::thread::spawn(move || backend.roll_out(&batch, &Outputs::default(), &stop))
        })
        .collect();
    // All are under way.
    while batches.lock().unwrap().len() < 12 {
        std::thread::sleep(Duration::from_millis(5));
    }
    let small = device.backend(Priority::Interactive);
    let batch = instances(&small, [3]);
    let before = batches.lock().unwrap().len();
    small.roll_out(&batch, &Outputs::default(), &CancelToken::default()).unwrap();
    let after = batches.lock().unwrap().len();
    stop.cancel();
    assert!(large.into_iter().all(|l| l.join().unwrap() == Err(EngineError::Cancelled)));
    // The slice under way, its own, and one that began before it was counted here.
    assert!(after - before <= 4, "{} slices", after - before);
}

/// Instances of a model whose nodes fall, for the CPU backend.
fn falling(backend: &QueuedBackend, instances: usize, frames: usize) -> Vec<Instance> {
    let mut made = self::instances(backend, std::iter::repeat_n(frames, instances));
    let still = State { velocities: vec![[0.0; 3]], positions: vec![[0.0; 3]], ..State::default() };
    let start = Arc::new(still);
    made.iter_mut().for_each(|i| i.initial = Arc::clone(&start));
    made
}

#[test]
fn a_fit_on_the_cpu_pauses_within_a_batch_and_its_results_are_the_same() {
    let (fatal, _died) = mpsc::unbounded_channel();
    let open = || Ok(bendtwin_engine::cpu_with_threads(2));
    let device = Device::spawn(open, fatal, 0.25).unwrap();
    let fit = device.backend(Priority::Background);
    let batch = falling(&fit, 8, 20_000);
    let outputs = Outputs { final_state: true, ..Outputs::default() };
    let cancel = CancelToken::default();
    let undisturbed = fit.roll_out(&batch, &outputs, &cancel).unwrap();
    let fitting = {
        let outputs = outputs.clone();
        std::thread::spawn(move || fit.roll_out(&batch, &outputs, &CancelToken::default()))
    };
    let mut answered = 0;
    while !fitting.is_finished() {
        let backend = device.backend(Priority::Interactive);
        let rollout = falling(&backend, 1, 1);
        assert_eq!(backend.roll_out(&rollout, &outputs, &cancel).unwrap().len(), 1);
        answered += 1;
    }
    assert!(answered > 2, "{answered} rollouts beside one batch of the fit");
    assert_eq!(fitting.join().unwrap().unwrap(), undisturbed);
}

#[test]
fn work_for_the_processor_has_turns_at_the_device_only_if_that_is_the_processor() {
    for (kind, at_device) in [("cpu", true), ("cuda", false)] {
        let (device, _died) = device(Slow { kind, ..Slow::default() });
        let backend = device.backend(Priority::Interactive);
        let own = std::thread::current().id();
        let other = backend.on_processor(move || std::thread::current().id() != own).unwrap();
        assert_eq!(other, at_device, "{kind}");
    }
    // Pieces beside a GPU exclude one another.
    let (device, _died) = device(Slow { kind: "cuda", ..Slow::default() });
    let (under_way, most) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicUsize::new(0)));
    std::thread::scope(|scope| {
        for _ in 0..4 {
            let (under_way, most) = (Arc::clone(&under_way), Arc::clone(&most));
            let backend = device.backend(Priority::Interactive);
            scope.spawn(move || {
                let piece = move || {
                    most.fetch_max(under_way.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
                    std::thread::yield_now();
                    under_way.fetch_sub(1, Ordering::SeqCst);
                };
                backend.on_processor(piece).unwrap();
            });
        }
    });
    assert_eq!(most.load(Ordering::SeqCst), 1);
}
