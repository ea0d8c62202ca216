//! Rollouts with a time limit.

use std::{sync::Mutex, time::Duration};

use bendtwin_core::{Environment, Params};
use bendtwin_engine::{
    Loaded,
    backend::{Error as EngineError, Gradient, GradientRequest, Instance, Loss, Outputs, Rollout},
    optimizer::{Decay, Optimizer, OptimizerInit},
};

use super::*;

/// Longer than a slice takes: there is one for each instance.
const SLOW: Duration = Duration::from_millis(50);

/// The CPU, one instance at a time, which stalls once after a number of instances.
struct Stopping {
    cpu: Arc<dyn Backend>,
    left: Mutex<usize>,
}

impl Backend for Stopping {
    fn device(&self) -> bendtwin_engine::Device {
        bendtwin_engine::Device { lanes: 1, ..self.cpu.device() }
    }
    fn load(&self, model: Arc<Model>) -> Result<Loaded, EngineError> {
        self.cpu.load(model)
    }
    fn with_params(&self, loaded: &Loaded, params: Params) -> Result<Loaded, EngineError> {
        self.cpu.with_params(loaded, params)
    }
    fn with_environment(&self, loaded: &Loaded, to: Environment) -> Result<Loaded, EngineError> {
        self.cpu.with_environment(loaded, to)
    }
    fn roll_out(
        &self,
        batch: &[Instance],
        outputs: &Outputs,
        cancel: &CancelToken,
    ) -> Result<Vec<Rollout>, EngineError> {
        let mut left = self.left.lock().unwrap();
        if *left < batch.len() {
            while !cancel.is_cancelled() {
                std::thread::sleep(Duration::from_millis(1));
            }
            *left = usize::MAX;
            return Err(EngineError::Cancelled);
        }
        *left -= batch.len();
        std::thread::sleep(SLOW * batch.len() as u32);
        self.cpu.roll_out(batch, outputs, cancel)
    }
    fn losses(&self, batch: &[Instance], cancel: &CancelToken) -> Result<Vec<Loss>, EngineError> {
        self.cpu.losses(batch, cancel)
    }
    fn gradients(
        &self,
        batch: &[Instance],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<Gradient>, EngineError> {
        self.cpu.gradients(batch, request, cancel)
    }
    fn optimizer(
        &self,
        inits: Vec<OptimizerInit>,
        decay: Decay,
    ) -> Result<Box<dyn Optimizer>, EngineError> {
        self.cpu.optimizer(inits, decay)
    }
}

/// Rolls out on a device that simulates `instances` before the time is over.
fn limited(request: RollOutRequest, instances: usize) -> RollOutResponse {
    let cpu = bendtwin_engine::cpu_with_threads(1);
    let bench = Bench::on(Arc::new(Stopping { cpu, left: Mutex::new(instances) }));
    let request = RollOutRequest { time_limit_s: Some(1.0), ..request };
    let (plan, wanted) = bench.plan(request, 0).unwrap();
    let Wanted::Ready(starts) = wanted else { panic!("a state") };
    let until = Instant::now() + SLOW * (2 + 10 * instances as u32);
    bench.execute_until(&plan, &starts, Some(until)).unwrap().remove(0)
}

fn unfinished(reply: &RollOutResponse) -> Vec<u32> {
    reply.unfinished.as_ref().unwrap().unpack("u").unwrap().1
}

fn f64s(tensor: &Option<Tensor>) -> Vec<f64> {
    tensor.as_ref().unwrap().unpack("t").unwrap().1
}

fn returns() -> Returns {
    Returns {
        every_frames: 1,
        final_state: true,
        diagnostics: true,
        frame_costs: true,
        forces: true,
        ..Returns::default()
    }
}

#[test]
fn what_is_done_in_time_has_the_bits_of_the_whole_and_the_rest_is_listed() {
    let mut request = RollOutRequest { returns: Some(returns()), ..request(5) };
    request.costs[0].success_at_most = Some(1e3);
    let whole = Bench::new().run(request.clone(), 0).unwrap().remove(0);
    let reply = limited(request, 3);
    assert_eq!(unfinished(&reply), [3, 4]);
    let (costs, all) = (f64s(&reply.costs), f64s(&whole.costs));
    assert_eq!(costs[..3], all[..3]);
    assert_eq!(costs[3..], [f64::INFINITY; 2]);
    let successes = reply.successes.unwrap().unpack::<f32>("s").unwrap().1;
    assert_eq!(successes, [1.0, 1.0, 1.0, 0.0, 0.0]);
    let (of, to) = (&reply.positions.unwrap(), &whole.positions.unwrap());
    assert_eq!(of.shape, to.shape);
    let done = of.data.len() / 5 * 3;
    assert_eq!(of.data[..done], to.data[..done]);
    let rest = of.unpack::<f32>("p").unwrap().1;
    assert!(rest[done / 4..].iter().all(|x| x.is_nan()));
    assert!(reply.diagnostics[4].max_strain.is_nan() && reply.diagnostics[2].max_strain > 0.0);
    assert!(reply.diverged.is_empty());
    let rows = f64s(&reply.frame_costs);
    assert!(rows.len() == 5 * 7 && rows[21..].iter().all(|x| *x == f64::INFINITY));
}

#[test]
fn everything_in_time_is_the_whole() {
    let request = RollOutRequest { returns: Some(returns()), ..request(5) };
    let mut whole = Bench::new().run(request.clone(), 0).unwrap().remove(0);
    let reply = limited(request, 5);
    assert!(unfinished(&reply).is_empty());
    whole.unfinished.clone_from(&reply.unfinished);
    assert_eq!(reply.encode_to_vec(), whole.encode_to_vec());
}

#[test]
fn nothing_in_time_is_an_answer_too() {
    let best = Some(Returns { best: 2, ..returns() });
    for returns in [Some(returns()), best] {
        let reply = limited(RollOutRequest { returns, ..request(3) }, 0);
        assert_eq!(unfinished(&reply), [0, 1, 2]);
        assert_eq!(f64s(&reply.costs), [f64::INFINITY; 3]);
    }
}

#[test]
fn the_best_are_of_those_that_were_done() {
    let returns = Some(Returns { best: 3, ..returns() });
    let reply = limited(RollOutRequest { returns, ..request(4) }, 2);
    assert_eq!(unfinished(&reply), [2, 3]);
    let costs = f64s(&reply.costs);
    let best = if costs[0] <= costs[1] { [0, 1] } else { [1, 0] };
    assert_eq!(reply.instances.unwrap().unpack::<u32>("i").unwrap().1, best);
    assert_eq!(reply.positions.unwrap().shape, [2, 6, 4, 3]);
}
