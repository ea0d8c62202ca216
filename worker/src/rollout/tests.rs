//! Answers of a device that fails.

use std::{sync::Arc, time::Instant};

use bendtwin_contract::rollout::Limits;
use bendtwin_contract_kit::hanging::{request, twin};
use bendtwin_core::{CancelToken, Category, Problem as _, ids::TwinId};
use bendtwin_engine::backend;
use bendtwin_proto::v1::{RollOutRequest, RollOutResponse};
use bendtwin_rollout::{Checked, Error, Execution, Plan, Room, Served, Warm};
use tokio::sync::mpsc;

use crate::{
    device::{Device, Priority},
    faulty::{Faulty, InjectedFault, Script},
};

struct Bench {
    device: Device,
    warm: Arc<Warm>,
}

impl Bench {
    fn run(&self, request: RollOutRequest) -> Result<Vec<RollOutResponse>, Error> {
        let backend = self.device.backend(Priority::Interactive);
        let served = Served::exact(Arc::clone(&self.warm));
        let (limits, room) = (Limits::default(), Room { bytes: 256 << 20, lanes: 2 });
        let checked = Checked::new(request, "", 0, served, &limits, room)?;
        let cancel = CancelToken::default();
        let (plan, wanted) = Plan::new(checked, &backend, &cancel)?;
        let execution = Execution {
            plan: &plan,
            starts: &plan.starts(wanted, None)?,
            backend: &backend,
            cancel: &cancel,
            until: None,
            arrived: Instant::now(),
            worker: "w",
            keeps_states: false,
        };
        let mut parts = Vec::new();
        execution.run(|part| {
            parts.push(part);
            Ok(())
        })?;
        Ok(parts)
    }
}

/// A twin on a device that fails on request; also says where the end of the worker is announced.
fn bench() -> (Bench, Arc<Script>, mpsc::UnboundedReceiver<crate::Error>) {
    let (backend, script) = Faulty::new(9);
    let (fatal, died) = mpsc::unbounded_channel();
    let device = Device::spawn(move || Ok(Arc::new(backend) as _), fatal, 0.25).unwrap();
    let backend = device.backend(Priority::Interactive);
    let warm = Warm::load(TwinId::generate(), twin(), &backend, None).unwrap();
    (Bench { device, warm: Arc::new(warm) }, script, died)
}

fn costs(part: &RollOutResponse) -> Vec<f64> {
    part.costs.as_ref().unwrap().unpack("costs").unwrap().1
}

fn inject(script: &Script, injected: InjectedFault, times: usize) {
    *script.rollouts.lock().unwrap() = vec![injected; times];
}

fn full() -> InjectedFault {
    InjectedFault::Fails(backend::Error::OutOfMemory { needed: 5, available: 2 })
}

#[test]
fn a_batch_that_finds_no_memory_is_refused_and_the_worker_lives() {
    let (bench, script, mut died) = bench();
    inject(&script, full(), 1);
    let error = bench.run(request(2)).unwrap_err();
    assert_eq!(error.category(), Category::ResourceExhausted);
    assert!(error.to_string().contains("smaller batch"), "{error}");
    assert!(bench.run(request(2)).is_ok());
    assert!(died.try_recv().is_err());
}

#[test]
fn memory_that_can_be_spared_is_given_up_for_a_batch() {
    let (bench, script, _died) = bench();
    let asked = Arc::new(std::sync::Mutex::new(Vec::new()));
    let seen = Arc::clone(&asked);
    bench.device.on_shortage(move |bytes| {
        seen.lock().unwrap().push(bytes);
        true
    });
    inject(&script, full(), 1);
    assert!(bench.run(request(2)).is_ok());
    assert_eq!(*asked.lock().unwrap(), [3]);
    // The estimate was too small: then everything goes. After that it is refused.
    inject(&script, full(), 2);
    assert!(bench.run(request(2)).is_ok());
    inject(&script, full(), 3);
    assert!(bench.run(request(2)).is_err());
    assert_eq!(*asked.lock().unwrap(), [3, 3, u64::MAX, 3, u64::MAX]);
}

#[test]
fn a_failed_launch_is_reported_to_the_caller_and_ends_the_worker() {
    let (bench, script, mut died) = bench();
    let launch = backend::Error::Device("integrate<<<132, 256>>>: illegal address".into());
    inject(&script, InjectedFault::Fails(launch), 1);
    let error = bench.run(request(2)).unwrap_err();
    assert_eq!((error.category(), error.reason()), (Category::Internal, "DEVICE_FAILED"));
    assert!(error.to_string().contains("integrate"), "{error}");
    let fatal = died.blocking_recv();
    assert!(matches!(fatal, Some(crate::Error::DeviceFailed(why)) if why.contains("integrate")));
    // What comes before the process has ended finds no device.
    assert!(bench.run(request(2)).is_err());
}

#[test]
fn nan_is_reported_as_divergence_and_the_worker_lives() {
    let (bench, script, mut died) = bench();
    inject(&script, InjectedFault::Diverges, 1);
    let part = bench.run(request(2)).unwrap().remove(0);
    assert_eq!(part.diverged.len(), 2);
    assert_eq!((part.diverged[1].instance, part.diverged[1].frame), (1, 1));
    assert_eq!(costs(&part), [f64::INFINITY; 2]);
    assert!(costs(&bench.run(request(2)).unwrap()[0])[0].is_finite());
    assert!(died.try_recv().is_err());
}
