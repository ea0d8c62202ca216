//! Prices of requests that have each part once, and several together: a number that changes here
//! changes what a server admits.

mod memory;
mod reply;
mod surroundings;

use bendtwin_contract::rollout::{Batch, PlannerShape, TwinShape, memory, reply_bytes, work};
use bendtwin_contract_kit::rollout as cases;
use bendtwin_proto::v1::{
    Collider, ConvexMesh, Cost, Cuboid, Ensemble, Fidelity, InitialState, Plausibility, PointSet,
    Returns, RollOutRequest, Tensor, Vary,
    collider::{Carrier, Shape},
    cost::{Clearance, ControlSpeed, Height, Keypoints, Kind, Strain, TargetCloud, When},
    ensemble::Statistic,
    grasp::Region,
    initial_state::{GivenState, State},
    returns::Encoding,
};

const TWIN: TwinShape = TwinShape {
    nodes: 100,
    springs: 400,
    triplets: 50,
    controls: 3,
    skin_points: Some(900),
    rods: Some(20),
    substeps: 30,
    fast_substeps: Some(10),
    planner: Some(PlannerShape { nodes: 30, springs: 500, triplets: 10, substeps: 90 }),
    has_capture: true,
};

const BATCH: Batch = Batch { instances: 40, knots: 3, frames: 12 };

fn zeros(shape: &[usize]) -> Option<Tensor> {
    Some(Tensor::pack(shape, &vec![0.0f32; shape.iter().product()]))
}

fn factors(count: usize) -> Option<Tensor> {
    let factors: Vec<f32> = (0..count).map(|i| 0.5 + i as f32).collect();
    Some(Tensor::pack(&[count], &factors))
}

fn cost(kind: Kind, when: When) -> Cost {
    Cost { kind: Some(kind), when: when.into(), ..Cost::default() }
}

fn costs() -> Vec<Cost> {
    let cloud = TargetCloud { points: zeros(&[40, 1, 70, 3]), ..TargetCloud::default() };
    let nodes = TargetCloud { points: zeros(&[12, 7, 3]), point_set: PointSet::Nodes.into() };
    let named = Some(Tensor::pack(&[2], &[1u32, 2]));
    let keypoints =
        Keypoints { nodes: named.clone(), targets: zeros(&[2, 3]), ..Keypoints::default() };
    let height = Height { nodes: named, ..Height::default() };
    vec![
        Cost { name: "a cloud".into(), ..cost(Kind::TargetCloud(cloud), When::LastFrame) },
        cost(Kind::TargetCloud(nodes), When::EveryFrame),
        cost(Kind::Keypoints(keypoints), When::SoftMin),
        cost(Kind::Strain(Strain::default()), When::EveryFrame),
        cost(Kind::Height(height), When::LastFrame),
        cost(Kind::Clearance(Clearance::default()), When::EveryFrame),
        cost(Kind::ControlSpeed(ControlSpeed::default()), When::LastFrame),
    ]
}

fn everything() -> Returns {
    Returns {
        every_frames: 5,
        velocities: true,
        final_state: true,
        diagnostics: true,
        forces: true,
        frame_costs: true,
        controls: true,
        ..Returns::default()
    }
}

fn gradients() -> Returns {
    Returns {
        control_gradients: true,
        action_gradients: true,
        initial_gradients: true,
        gradient_norms: true,
        ..Returns::default()
    }
}

/// Requests by what they ask for beside trajectories.
fn requests() -> Vec<(&'static str, RollOutRequest)> {
    let plain = RollOutRequest { costs: Vec::new(), ..cases::sound(&TWIN) };
    let costs = RollOutRequest { costs: costs(), ..plain.clone() };
    let returning = |returns: Returns| RollOutRequest { returns: Some(returns), ..costs.clone() };
    let world = cases::sound_in_a_world(&TWIN);
    let vary = Vary { stiffness: factors(40), mass: factors(40), ..Vary::default() };
    let ensemble = |statistic: Statistic, of: &RollOutRequest| RollOutRequest {
        ensemble: Some(Ensemble { members: 4, statistic: statistic.into(), share: 0.5 }),
        vary: Some(Vary { bending: factors(4), ..Vary::default() }),
        ..of.clone()
    };
    let given = GivenState { positions: zeros(&[40, 100, 3]), ..GivenState::default() };
    let mut carried = world.clone();
    let mesh = ConvexMesh { points: zeros(&[50, 3]) };
    carried.world.get_or_insert_default().colliders.extend([
        Collider {
            shape: Some(Shape::ConvexMesh(mesh)),
            carrier: zeros(&[3, 7]).map(Carrier::Path),
            ..Collider::default()
        },
        Collider { shape: Some(Shape::Cuboid(Cuboid::default())), ..Collider::default() },
    ]);
    carried.grasps.iter_mut().for_each(|g| g.region = Some(Region::Cuboid(Cuboid::default())));
    let skin = Returns { point_set: PointSet::Skin.into(), ..everything() };
    let windows = Returns { part_frames: 5, ..skin.clone() };
    let packed = Returns { encoding: Encoding::Int16.into(), spread: true, ..everything() };
    let planner = |of: RollOutRequest| RollOutRequest { fidelity: Fidelity::Planner.into(), ..of };
    let never = Plausibility { start_gap_m: Some(f64::INFINITY), ..Plausibility::default() };
    vec![
        ("nothing", plain.clone()),
        ("costs", costs.clone()),
        ("everything", returning(everything())),
        ("gradients", returning(gradients())),
        ("the best", returning(Returns { best: 3, ..everything() })),
        ("windows", returning(windows.clone())),
        ("world", world),
        ("carried", RollOutRequest { returns: Some(everything()), ..carried.clone() }),
        ("carried gradients", RollOutRequest { returns: Some(gradients()), ..carried.clone() }),
        ("carried windows", RollOutRequest { returns: Some(windows), ..carried.clone() }),
        ("vary", RollOutRequest { vary: Some(vary), ..costs.clone() }),
        ("members", ensemble(Statistic::Worst, &returning(everything()))),
        ("spread", ensemble(Statistic::Cvar, &returning(packed))),
        ("mean", ensemble(Statistic::MeanPrediction, &returning(everything()))),
        ("mean gradients", ensemble(Statistic::MeanPrediction, &returning(gradients()))),
        (
            "given",
            RollOutRequest {
                initial: Some(InitialState { state: Some(State::Given(given)) }),
                ..plain
            },
        ),
        ("fast", RollOutRequest { fidelity: Fidelity::Fast.into(), ..costs.clone() }),
        ("planner", planner(returning(everything()))),
        ("planner gradients", planner(returning(gradients()))),
        ("planner skin", planner(returning(skin))),
        (
            "limited",
            RollOutRequest {
                time_limit_s: Some(1.0),
                plausibility: Some(never),
                ..returning(Returns { diagnostics: true, ..Returns::default() })
            },
        ),
    ]
}

/// Work; bytes of a message of the reply; memory that is fixed, of an instance that is prepared, and
/// of one that runs.
type Price = (u128, u64, u64, u64, u64);

#[rustfmt::skip]
const PRICES: &[(&str, u32, Price)] = &[
    ("nothing", 0, (7920000, 7310, 37228, 1492, 26992)),
    ("nothing", 16, (7920000, 3014, 32100, 1492, 26992)),
    ("costs", 0, (10672000, 9603, 249472, 6610, 146718)),
    ("costs", 16, (10672000, 3963, 242764, 6610, 146718)),
    ("everything", 0, (10672000, 375212, 1711908, 6610, 147342)),
    ("everything", 16, (10672000, 150323, 1413644, 6610, 147342)),
    ("gradients", 0, (10672000, 128910, 726700, 51854, 398450)),
    ("gradients", 16, (10672000, 51744, 625012, 51854, 398450)),
    ("the best", 0, (10672000, 38789, 366216, 6610, 147342)),
    ("the best", 16, (10672000, 32117, 467996, 6610, 147342)),
    ("windows", 0, (10672000, 1008018, 4243932, 11410, 147342)),
    ("windows", 16, (10672000, 403456, 3658548, 11410, 147342)),
    ("world", 0, (10800800, 7639, 133280, 8005, 27633)),
    ("world", 16, (10800800, 3151, 127932, 8005, 27633)),
    ("carried", 0, (49680800, 460030, 1942844, 8629, 30129)),
    ("carried", 16, (49680800, 184260, 1576804, 8629, 30129)),
    ("carried gradients", 0, (49680800, 126946, 610508, 19121, 279989)),
    ("carried gradients", 16, (49680800, 50932, 510180, 19121, 279989)),
    ("carried windows", 0, (49680800, 1079397, 4421112, 13429, 30129)),
    ("carried windows", 16, (49680800, 432016, 3874996, 13429, 30129)),
    ("vary", 0, (10870000, 9603, 2381952, 6610, 146718)),
    ("vary", 16, (10870000, 3963, 2375244, 6610, 146718)),
    ("members", 0, (59584000, 1493880, 6582228, 6610, 147342)),
    ("members", 16, (59584000, 597801, 5389116, 6610, 147342)),
    ("spread", 0, (59584000, 338861, 12196796, 6610, 147342)),
    ("spread", 16, (59584000, 135810, 7567080, 6610, 147342)),
    ("mean", 0, (62336000, 402825, 8556408, 69010, 147342)),
    ("mean", 16, (62336000, 161376, 7043004, 69010, 147342)),
    ("mean gradients", 0, (62336000, 151363, 2514632, 124654, 549170)),
    ("mean gradients", 16, (62336000, 60733, 2275084, 124654, 549170)),
    ("given", 0, (7920000, 7310, 175288, 1492, 26992)),
    ("given", 16, (7920000, 3014, 170160, 1492, 26992)),
    ("fast", 0, (5392000, 9603, 249472, 6610, 146718)),
    ("fast", 16, (5392000, 3963, 242764, 6610, 146718)),
    ("planner", 0, (26080000, 375212, 1713508, 16210, 160142)),
    ("planner", 16, (26080000, 150323, 1415244, 16210, 160142)),
    ("planner gradients", 0, (26080000, 128910, 728300, 53454, 719090)),
    ("planner gradients", 16, (26080000, 51744, 626612, 53454, 719090)),
    ("planner skin", 0, (26080000, 1911214, 7863916, 16210, 160142)),
    ("planner skin", 16, (26080000, 764725, 6336860, 16210, 160142)),
    ("limited", 0, (10672000, 10135, 251600, 6610, 146718)),
    ("limited", 16, (10672000, 4181, 244508, 6610, 146718)),
];

#[test]
fn prices_are_those_of_the_table() {
    let mut found = Vec::new();
    for (name, request) in requests() {
        for part in [0, 16] {
            let bytes = reply_bytes(&request, &BATCH, &TWIN, part);
            let memory = memory(&request, &BATCH, &TWIN, part);
            let work = work(&request, &BATCH, &TWIN);
            let price = (work, bytes, memory.fixed, memory.prepared, memory.running);
            found.push((name, part, price));
        }
    }
    let rows: Vec<String> = found.iter().map(|row| format!("    {row:?},")).collect();
    assert_eq!(found, PRICES, "the table is now:\n{}", rows.join("\n"));
}
