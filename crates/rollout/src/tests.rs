//! Requests against a small real twin on the CPU.

mod carry;
mod costs;
mod direct;
mod fidelity;
mod gradients;
mod limit;
mod obstacles;
mod pictures;
mod planner;
mod registration;
mod skin;
mod split;
mod states;
mod world;

use std::{sync::Arc, time::Instant};

use bendtwin_contract::rollout::{self, Limits};
use bendtwin_contract_kit::{
    hanging::{keypoint_cost, request, twin},
    rollout as cases,
};
use bendtwin_core::{
    CancelToken, Category, Environment, Graph, NodeKind, Params, Problem as _, Skin, Twin,
    ids::TwinId,
};
use bendtwin_engine::{Backend, Model};
use bendtwin_proto::v1::{
    ControlTrajectories, Cost, InitialState, KnotTimes, Returns, RollOutRequest, RollOutResponse,
    Tensor,
    cost::{Keypoints, Kind, Smoothness, TargetCloud, When},
    initial_state::{GivenState, State},
    knot_times::Times,
    returns::Encoding,
    roll_out_request::Actions,
};
use proptest::prelude::*;
use prost::Message as _;

use self::direct::Direct;
use crate::{
    error::Error,
    request::{
        checked::{Checked, Room},
        initial::{Starts, Wanted},
    },
    run::{
        execute::Execution,
        plan::{Plan, shape},
    },
    twin::{serve::Served, warm::Warm},
};

struct Bench {
    backend: Direct,
    warm: Arc<Warm>,
}

impl Bench {
    fn new() -> Self {
        Self::on(bendtwin_engine::cpu_with_threads(2))
    }

    /// On a backend.
    fn on(backend: Arc<dyn Backend>) -> Self {
        Self::of(twin(), backend)
    }

    /// A bench with a twin.
    fn of(twin: Twin, backend: Arc<dyn Backend>) -> Self {
        let backend = Direct::new(backend);
        let warm = Warm::load(TwinId::generate(), twin, &backend, None).unwrap();
        Self { backend, warm: Arc::new(warm) }
    }

    fn plan(&self, request: RollOutRequest, part: u32) -> Result<(Plan, Wanted), Error> {
        self.plan_for(request, part, Served::exact(Arc::clone(&self.warm)))
    }

    fn plan_for(
        &self,
        request: RollOutRequest,
        part: u32,
        served: Served,
    ) -> Result<(Plan, Wanted), Error> {
        let room = Room { bytes: 256 << 20, lanes: 2 };
        let checked = Checked::new(request, "", part, served, &limits(), room)?;
        Plan::new(checked, &self.backend, &CancelToken::default())
    }

    fn run(&self, request: RollOutRequest, part: u32) -> Result<Vec<RollOutResponse>, Error> {
        let (plan, wanted) = self.plan(request, part)?;
        self.execute(&plan, &plan.starts(wanted, None)?)
    }

    fn execute(&self, plan: &Plan, starts: &Starts) -> Result<Vec<RollOutResponse>, Error> {
        self.execute_until(plan, starts, None)
    }

    fn execute_until(
        &self,
        plan: &Plan,
        starts: &Starts,
        until: Option<Instant>,
    ) -> Result<Vec<RollOutResponse>, Error> {
        let cancel = CancelToken::default();
        let execution = Execution {
            plan,
            starts,
            backend: &self.backend,
            cancel: &cancel,
            until,
            arrived: Instant::now(),
            worker: "w",
            keeps_states: false,
        };
        let mut parts = Vec::new();
        execution.run(|part| {
            parts.push(part);
            Ok(())
        })?;
        // Time is the one thing that may differ from run to run.
        for part in &mut parts {
            part.timing = None;
        }
        Ok(parts)
    }
}

fn limits() -> Limits {
    Limits { instances: 64, reply_bytes: 1 << 20, work: 50_000_000, ..Limits::default() }
}

fn f64s(tensor: &Option<Tensor>) -> Vec<f64> {
    tensor.as_ref().unwrap().unpack::<f64>("t").unwrap().1
}

#[test]
fn a_batch_comes_back_with_everything_that_was_asked_for() {
    let bench = Bench::new();
    let mut request = request(5);
    request.costs.push(Cost {
        name: "smooth".into(),
        weight: Some(0.5),
        when: When::EveryFrame.into(),
        kind: Some(Kind::Smoothness(Smoothness {})),
        ..Cost::default()
    });
    request.returns = Some(Returns {
        every_frames: 2,
        nodes: Some(Tensor::pack(&[2], &[3u32, 0])),
        final_state: true,
        diagnostics: true,
        control_gradients: true,
        ..Returns::default()
    });
    let parts = bench.run(request, 0).unwrap();
    assert_eq!(parts.len(), 1);
    let part = &parts[0];
    assert_eq!(part.cost_names, ["cost0", "smooth"]);
    assert_eq!(part.cost_terms.as_ref().unwrap().shape, [5, 2]);
    assert_eq!(part.positions.as_ref().unwrap().shape, [5, 3, 2, 3]);
    assert_eq!(part.frames.as_ref().unwrap().unpack::<u32>("f").unwrap().1, [2, 4, 6]);
    assert_eq!(part.final_positions.as_ref().unwrap().shape, [5, 4, 3]);
    assert_eq!(part.control_gradients.as_ref().unwrap().shape, [5, 7, 1, 3]);
    assert_eq!(part.diagnostics.len(), 5);
    let (costs, terms) = (f64s(&part.costs), f64s(&part.cost_terms));
    for (i, cost) in costs.iter().enumerate() {
        assert!((cost - terms[2 * i] - terms[2 * i + 1]).abs() < 1e-9);
    }
    // The last recorded frame is the final state.
    let recorded = part.positions.as_ref().unwrap().unpack_points("p").unwrap().1;
    let last = part.final_positions.as_ref().unwrap().unpack_points("p").unwrap().1;
    assert_eq!(recorded[5], last[0]);
}

#[test]
fn the_same_request_gives_the_same_bytes_in_any_parts() {
    let bench = Bench::new();
    let mut request = request(9);
    request.returns = Some(Returns { every_frames: 3, ..Returns::default() });
    let whole = bench.run(request.clone(), 0).unwrap();
    assert_eq!(whole, bench.run(request.clone(), 0).unwrap());
    let parts = bench.run(request, 4).unwrap();
    assert_eq!(parts.iter().map(|p| p.first_instance).collect::<Vec<_>>(), [0, 4, 8]);
    let joined: Vec<f64> = parts.iter().flat_map(|p| f64s(&p.costs)).collect();
    assert_eq!(joined, f64s(&whole[0].costs));
    let bytes: Vec<u8> = parts.iter().flat_map(|p| p.positions.clone().unwrap().data).collect();
    assert_eq!(bytes, whole[0].positions.as_ref().unwrap().data);
}

#[test]
fn the_best_come_last_and_lowest_first() {
    let bench = Bench::new();
    let mut request = request(9);
    request.returns =
        Some(Returns { best: 2, final_state: true, every_frames: 6, ..Returns::default() });
    let parts = bench.run(request.clone(), 4).unwrap();
    assert!(parts[0].instances.is_none() && parts[0].final_positions.is_none());
    let last = parts.last().unwrap();
    let best = last.instances.as_ref().unwrap().unpack::<u32>("i").unwrap().1;
    let costs: Vec<f64> = parts.iter().flat_map(|p| f64s(&p.costs)).collect();
    assert!(costs[best[0] as usize] <= costs[best[1] as usize]);
    assert!(costs.iter().all(|c| *c >= costs[best[0] as usize]));
    assert_eq!(last.final_positions.as_ref().unwrap().shape, [2, 4, 3]);
    // Their arrays are those of the full answer.
    request.returns = Some(Returns { final_state: true, ..Returns::default() });
    let all = bench.run(request, 0).unwrap().remove(0);
    let (_, all) = all.final_positions.unwrap().unpack_points("p").unwrap();
    let (_, chosen) = last.final_positions.as_ref().unwrap().unpack_points("p").unwrap();
    assert_eq!(chosen[..4], all[4 * best[0] as usize..][..4]);
}

#[test]
fn gradients_point_the_way_down() {
    let bench = Bench::new();
    let mut request = request(1);
    request.returns = Some(Returns { control_gradients: true, ..Returns::default() });
    let part = bench.run(request, 0).unwrap().remove(0);
    let (_, gradient) = part.control_gradients.unwrap().unpack_points("g").unwrap();
    // The target lies at larger x, so moving the control there lowers the cost.
    let along_x: f32 = gradient.iter().map(|g| g[0]).sum();
    assert!(along_x < 0.0, "{along_x}");
}

#[test]
fn a_given_state_starts_each_instance() {
    let bench = Bench::new();
    let mut request = request(2);
    let rest = bench.warm.twin.graph.rest_positions.clone();
    let raised: Vec<_> = rest.iter().map(|p| [p[0], p[1], p[2] + 0.3]).collect();
    let positions: Vec<_> = rest.iter().chain(&raised).copied().collect();
    request.initial = Some(InitialState {
        state: Some(State::Given(GivenState {
            positions: Some(Tensor::pack_points(&[2, 4], &positions)),
            velocities: None,
            twists: None,
            ..GivenState::default()
        })),
    });
    request.returns = Some(Returns { final_state: true, ..Returns::default() });
    let part = bench.run(request, 0).unwrap().remove(0);
    let (_, last) = part.final_positions.unwrap().unpack_points("p").unwrap();
    assert_ne!(last[..4], last[4..]);
}

#[test]
fn refusals_name_the_field() {
    let bench = Bench::new();
    let refuse = |change: &dyn Fn(&mut RollOutRequest)| {
        let mut request = request(2);
        change(&mut request);
        bench.plan(request, 0).map(|_| ()).expect_err("must be refused")
    };
    type Change<'a> = &'a dyn Fn(&mut RollOutRequest);
    let cases: [(Change<'_>, &str); 10] = [
        (&|r| r.actions = None, "actions"),
        (&|r| r.frames = 200_000, "frames"),
        (&|r| r.costs[0].weight = Some(f64::NAN), "costs[0].weight"),
        (&|r| r.costs[0].when = 9, "costs[0].when"),
        (&|r| r.costs[0].kind = None, "costs[0].kind"),
        (
            &|r| {
                r.costs[0].kind = Some(Kind::TargetCloud(TargetCloud::default()));
            },
            "target_cloud.points",
        ),
        (
            &|r| {
                let again = Cost { name: "cost0".into(), ..keypoint_cost(0.1) };
                r.costs.push(again);
            },
            "costs[1].name",
        ),
        (
            &|r| {
                let nodes = Some(Tensor::pack(&[1], &[4u32]));
                r.returns = Some(Returns { nodes, ..Returns::default() });
            },
            "returns.nodes",
        ),
        (
            &|r| {
                r.costs.clear();
                r.returns = Some(Returns { control_gradients: true, ..Returns::default() });
            },
            "returns.control_gradients",
        ),
        (&|r| r.returns = Some(Returns { encoding: 7, ..Returns::default() }), "returns.encoding"),
    ];
    for (change, field) in cases {
        let error = refuse(change);
        assert_eq!(error.category(), Category::InvalidArgument, "{error}");
        assert!(error.to_string().contains(field), "`{error}` must name {field}");
    }
}

#[test]
fn a_malformed_request_gets_the_fault_of_the_check() {
    let bench = Bench::new();
    let shape = shape(&bench.warm.twin, false);
    assert!(bench.plan(cases::sound(&shape), 0).is_ok());
    for case in cases::malformed(&shape) {
        let expected = rollout::check_for(&case.request, &shape, &limits(), 0).unwrap_err();
        let error = bench.plan(case.request, 0).map(|_| ()).unwrap_err();
        assert_eq!(error.fault(), expected.fault(), "{}", case.what);
    }
}

#[test]
fn a_cost_of_weight_zero_is_reported_as_zero_and_changes_no_other() {
    let bench = Bench::new();
    let mut with = request(2);
    with.returns = Some(Returns { control_gradients: true, ..Returns::default() });
    let without = bench.run(with.clone(), 0).unwrap().remove(0);
    with.costs.push(Cost { weight: Some(0.0), name: "off".into(), ..keypoint_cost(1e30) });
    let part = bench.run(with.clone(), 0).unwrap().remove(0);
    assert_eq!(part.cost_names, ["cost0", "off"]);
    assert_eq!(
        (&part.costs, &part.control_gradients),
        (&without.costs, &without.control_gradients)
    );
    let terms = f64s(&part.cost_terms);
    assert_eq!((terms[1], terms[3]), (0.0, 0.0));
    // Alone, its gradient is zero.
    with.costs.remove(0);
    let part = bench.run(with, 0).unwrap().remove(0);
    assert_eq!(f64s(&part.costs), [0.0, 0.0]);
    let (_, gradient) = part.control_gradients.unwrap().unpack_points("g").unwrap();
    assert!(gradient.as_flattened().iter().all(|g| *g == 0.0));
}

#[test]
fn a_reply_is_no_larger_than_the_check_says() {
    let bench = Bench::new();
    let shape = shape(&bench.warm.twin, false);
    let mut request = request(9);
    for encoding in [Encoding::Float32, Encoding::Int16] {
        for (best, part) in [(0, 0), (0, 4), (2, 0)] {
            request.returns = Some(Returns {
                every_frames: 2,
                encoding: encoding.into(),
                best,
                final_state: true,
                diagnostics: true,
                control_gradients: true,
                action_gradients: true,
                initial_gradients: true,
                gradient_norms: true,
                velocities: true,
                frame_costs: true,
                controls: true,
                ..Returns::default()
            });
            let batch = rollout::check_for(&request, &shape, &limits(), part).unwrap();
            let bound = rollout::reply_bytes(&request, &batch, &shape, part) as usize;
            let parts = bench.run(request.clone(), part).unwrap();
            let largest = parts.iter().map(|p| p.encoded_len()).max().unwrap();
            // What may be added: the worker's name, times, that each instance diverges, that its
            // control points are below the ground, and that it is implausible in every way.
            let most = largest + 250 + (25 + 4 * 56) * 9;
            assert!((largest..=most).contains(&bound), "{bound} {largest}");
        }
    }
}

#[test]
fn too_much_work_or_reply_is_refused_with_advice() {
    let bench = Bench::new();
    let mut long = request(60);
    long.frames = 5_000;
    let error = bench.plan(long, 0).map(|_| ()).unwrap_err();
    assert_eq!(error.category(), Category::InvalidArgument);
    assert_eq!(error.reason(), "ROLLOUT_TOO_LARGE");
    assert!(error.to_string().contains("shorter horizon"), "{error}");
    let mut large = request(60);
    large.frames = 500;
    large.returns = Some(Returns { every_frames: 1, ..Returns::default() });
    let error = bench.plan(large.clone(), 0).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("returns.every_frames"), "{error}");
    // In parts it fits.
    assert!(bench.plan(large, 10).is_ok());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    /// Any request: an answer or a refusal, never a panic.
    #[test]
    fn no_request_panics(
        frames in prop_oneof![0u32..12, Just(u32::MAX)],
        every in 0u32..20,
        best in 0u32..9,
        weight in prop_oneof![Just(f64::INFINITY), -2.0f64..2.0],
        node in 0u32..6,
        target in prop::array::uniform3(prop_oneof![Just(f32::NAN), -1.0f32..1.0]),
        when in -1i32..5,
        part in 0u32..5,
        flags in any::<[bool; 8]>(),
    ) {
        let bench = Bench::new();
        let mut request = request(3);
        request.frames = frames;
        request.costs = vec![Cost {
            weight: Some(weight),
            when,
            temperature: f64::from(part),
            kind: Some(Kind::Keypoints(Keypoints {
                nodes: Some(Tensor::pack(&[1], &[node])),
                targets: Some(Tensor::pack_points(&[1], &[target])),
                squared: flags[0],
                skin_points: None,
            })),
            ..Cost::default()
        }];
        request.returns = Some(Returns {
            every_frames: every,
            best,
            final_state: flags[1],
            control_gradients: flags[2],
            diagnostics: flags[3],
            velocities: flags[4],
            frame_costs: flags[5],
            controls: flags[6],
            initial_gradients: flags[7],
            gradient_norms: flags[7],
            ..Returns::default()
        });
        if let Ok(parts) = bench.run(request, part) {
            let costs: Vec<f64> = parts.iter().flat_map(|p| f64s(&p.costs)).collect();
            prop_assert_eq!(costs.len(), 3);
            prop_assert!(costs.iter().all(|c| !c.is_nan()));
        }
    }
}
