use bendtwin_proto::v1::{
    Collider, Fidelity, Grasp, Grasping, InitialState, SessionStates, Sphere, Tensor, World,
    collider::{Carrier, Shape},
    grasp::Region,
    initial_state::GivenState,
};
use prost::Message as _;

use super::*;

const TWIN: TwinShape = TwinShape {
    nodes: 5,
    springs: 4,
    triplets: 3,
    controls: 2,
    skin_points: Some(9),
    rods: Some(1),
    substeps: 10,
    fast_substeps: None,
    planner: None,
    has_capture: false,
};

fn grasp(gripper: u32) -> Grasp {
    let region = Some(Region::Sphere(Sphere { center: Vec::new(), radius_m: 0.1 }));
    Grasp { gripper, region, ..Grasp::default() }
}

fn given(shape: &[usize]) -> Option<InitialState> {
    let zeros = vec![0.0f32; shape.iter().product()];
    let positions = Some(Tensor::pack(shape, &zeros));
    let given = GivenState { positions, ..GivenState::default() };
    Some(InitialState { state: Some(State::Given(given)) })
}

fn path(knots: usize) -> World {
    let pose = [0.0f32, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let carrier = Some(Carrier::Path(Tensor::pack(&[knots, 7], &pose.repeat(knots))));
    let shape = Some(Shape::Sphere(Sphere { center: Vec::new(), radius_m: 0.1 }));
    World {
        colliders: vec![Collider { carrier, shape, ..Collider::default() }],
        ..World::default()
    }
}

fn checked(request: &OpenSessionRequest) -> Result<(), String> {
    check_session(request, &TWIN, &Limits::default()).map_err(|e| e.to_string())
}

#[test]
fn what_hangs_on_the_actions_is_left_to_them() {
    for knots in [2, 3, 30] {
        let closed = Some(Tensor::pack(&[knots], &vec![1u32; knots]));
        let grasps = vec![Grasp { closed, ..grasp(31) }];
        let world = Some(path(knots));
        let request = OpenSessionRequest { slots: 3, world, ..OpenSessionRequest::default() };
        checked(&request).unwrap();
        checked(&OpenSessionRequest { world: None, grasps, ..request }).unwrap();
    }
}

#[test]
fn faults_are_named() {
    let open = OpenSessionRequest { slots: 3, ..OpenSessionRequest::default() };
    let at = |initial| OpenSessionRequest { initial, ..open.clone() };
    let holding = |grasps| OpenSessionRequest { grasps, ..open.clone() };
    let session = InitialState { state: Some(State::Session(Default::default())) };
    let cases = [
        ("number of slots", OpenSessionRequest { slots: MOST_SLOTS + 1, ..open.clone() }),
        ("initial.session", at(Some(session))),
        ("initial.given.positions", at(given(&[2, 5, 3]))),
        ("5 nodes", at(given(&[4, 3]))),
        ("grasps[0].region", holding(vec![Grasp::default()])),
        ("grasps", holding(vec![grasp(0); 33])),
        ("33 carriers", holding(vec![grasp(32)])),
        ("4294967296 carriers", holding(vec![grasp(u32::MAX)])),
        ("fast variant", OpenSessionRequest { fidelity: Fidelity::Fast.into(), ..open.clone() }),
        ("fidelity", OpenSessionRequest { fidelity: 77, ..open.clone() }),
    ];
    for (names, request) in cases {
        let error = checked(&request).unwrap_err();
        assert!(error.contains(names), "{names}: {error}");
    }
    for sound in [given(&[5, 3]), given(&[3, 5, 3]), None] {
        checked(&at(sound)).unwrap();
    }
}

#[test]
fn states_are_no_larger_than_expected() {
    let limits = Limits::default();
    for (slots, grasps) in [(1, 0), (3, 2), (300, 32)] {
        let (n, c, r) = (5, 2, 1);
        let points = |n: usize| Some(Tensor::pack(&[slots, n, 3], &vec![0.0f32; slots * n * 3]));
        let numbers = |n: usize| Some(Tensor::pack(&[slots, n], &vec![1u32; slots * n]));
        let states = GivenState {
            positions: points(n),
            velocities: points(n),
            twists: Some(Tensor::pack(&[slots, r], &vec![0.0f32; slots * r])),
            controls: points(c),
            commanded_controls: points(c),
            grasping: (grasps > 0).then(|| Grasping {
                phases: numbers(grasps),
                holders: numbers(n),
                places: points(n),
            }),
        };
        let reply = SessionStates {
            states: Some(states),
            slots: vec![u32::MAX; slots],
            frames: vec![u64::MAX; slots],
        };
        let bound = states_bytes(slots as u64, grasps as u64, &TWIN, &limits).unwrap();
        let size = reply.encoded_len() as u64;
        assert!(size <= bound && bound <= 2 * size, "{size} {bound}");
    }
    let large = TwinShape { nodes: 100_000, ..TWIN };
    let error = states_bytes(4096, 0, &large, &limits).unwrap_err().to_string();
    assert!(error.contains("fewer slots"), "{error}");
}
