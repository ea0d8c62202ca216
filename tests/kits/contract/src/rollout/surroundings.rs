//! Faults of worlds, grasps, parameters by instance and limits of what is plausible.

use bendtwin_contract::rollout::TwinShape;
use bendtwin_proto::v1::{
    Capsule, Collider, ConvexMesh, Cost, Cuboid, Ensemble, GradientOptions, Grasp, GripperPoses,
    Plane, Plausibility, Returns, RollOutRequest, Sphere, Tensor, Vary, World,
    collider::{Carrier, Shape},
    cost::{
        Force, Kind,
        force::{All, By},
    },
    ensemble::Statistic,
    grasp::{Attachment, CaptureHand, Region},
    roll_out_request::Actions,
    world::GroundChoice,
};

use super::{Case, zeros};

/// Two instances of three knots of one gripper, with a cost, in a world with a collider and a grasp.
pub(super) fn sound(good: &RollOutRequest) -> RollOutRequest {
    let row = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0f32];
    let poses = Some(Tensor::pack(&[2, 3, 1, 7], row.repeat(6).as_slice()));
    RollOutRequest {
        actions: Some(Actions::Poses(GripperPoses { poses, ..GripperPoses::default() })),
        world: Some(World { colliders: vec![collider()], ..World::default() }),
        grasps: vec![grasp()],
        ..good.clone()
    }
}

/// Requests with one fault each.
pub(super) fn malformed(good: &RollOutRequest, twin: &TwinShape) -> Vec<Case> {
    let good = sound(good);
    let mut cases = Vec::new();
    let mut add = |what, names, request| cases.push(Case { what, names, request });
    for (what, names, world) in worlds() {
        add(what, names, RollOutRequest { world: Some(world), ..good.clone() });
    }
    for (what, names, collider) in colliders() {
        let world = Some(World { colliders: vec![collider], ..World::default() });
        add(what, names, RollOutRequest { world, ..good.clone() });
    }
    for (what, names, grasp) in grasps(twin.nodes) {
        add(what, names, RollOutRequest { grasps: vec![grasp], ..good.clone() });
    }
    let positions = Some(zeros(&[2, 3, twin.controls, 3]));
    let trajectories = bendtwin_proto::v1::ControlTrajectories { positions, interpolation: 0 };
    let actions = Some(Actions::Trajectories(trajectories));
    add("a grasp without grippers", "`poses`", RollOutRequest { actions, ..good.clone() });
    let hand = || Grasp { region: Some(Region::Hand(CaptureHand { hand: 1 })), ..grasp() };
    let twice = vec![hand(), hand()];
    add("a hand twice", "`grasps[1].hand.hand`", RollOutRequest { grasps: twice, ..good.clone() });
    let many = vec![grasp(); 33];
    add("33 grasps", "`grasps`", RollOutRequest { grasps: many, ..good.clone() });
    for (what, names, vary) in varied() {
        add(what, names, RollOutRequest { vary: Some(vary), ..good.clone() });
    }
    for (what, names, ensemble, vary) in ensembles() {
        let ensemble = Some(ensemble);
        add(what, names, RollOutRequest { ensemble, vary, ..good.clone() });
    }
    let (_, _, ensemble, _) = ensembles().swap_remove(1);
    let vary = Some(Vary { fits: true, ..Vary::default() });
    let fast = bendtwin_proto::v1::Fidelity::Fast.into();
    let of_fits = RollOutRequest { ensemble: Some(ensemble), vary, ..good.clone() };
    add(
        "fits of the fast variant",
        "`vary.fits`",
        RollOutRequest { fidelity: fast, ..of_fits.clone() },
    );
    let spread = |every_frames| Some(Returns { spread: true, every_frames, ..Returns::default() });
    for (what, names, request) in mean_predictions(&of_fits) {
        add(what, names, request);
    }
    add(
        "a spread of nothing",
        "`returns.spread`",
        RollOutRequest { returns: spread(0), ..of_fits },
    );
    let alone = RollOutRequest { returns: spread(1), ..good.clone() };
    add("a spread of one prediction", "`returns.spread`", alone);
    for (what, smoothing_m) in
        [("a smoothing that is NaN", f64::NAN), ("a metre of smoothing", 1.0)]
    {
        let gradient = Some(GradientOptions { smoothing_m, reach_frames: 0 });
        add(what, "`gradient.smoothing_m`", RollOutRequest { gradient, ..good.clone() });
    }
    let plausibility = Some(Plausibility { strain: Some(f64::NAN), ..Plausibility::default() });
    let strained = RollOutRequest { plausibility, ..good.clone() };
    add("a limit that is NaN", "`plausibility.strain`", strained);
    let plausibility = Some(Plausibility { grasp_force_n: Some(-1.0), ..Plausibility::default() });
    let pulled = RollOutRequest { plausibility, ..good };
    add("a force below 0", "`plausibility.grasp_force_n`", pulled);
    cases
}

type Named<T> = Vec<(&'static str, &'static str, T)>;

fn ball() -> Sphere {
    Sphere { center: vec![0.0, 0.0, 0.1], radius_m: 0.05 }
}

fn collider() -> Collider {
    Collider { shape: Some(Shape::Sphere(ball())), ..Collider::default() }
}

fn grasp() -> Grasp {
    Grasp { region: Some(Region::Sphere(ball())), ..Grasp::default() }
}

fn worlds() -> Named<World> {
    let plane = |normal: &[f32], offset_m| {
        let plane = Plane { normal: normal.to_vec(), offset_m };
        World { ground_choice: Some(GroundChoice::Ground(plane)), ..World::default() }
    };
    let named = |name: &str| Collider { name: name.to_owned(), ..collider() };
    let with = |colliders| World { colliders, ..World::default() };
    vec![
        (
            "gravity of two numbers",
            "`world.gravity`",
            World { gravity: vec![0.0; 2], ..World::default() },
        ),
        (
            "gravity that is NaN",
            "`world.gravity`",
            World { gravity: vec![0.0, f32::NAN, 0.0], ..World::default() },
        ),
        ("a normal of length 2", "`world.ground.normal`", plane(&[0.0, 0.0, 2.0], 0.0)),
        ("a ground at infinity", "`world.ground.offset_m`", plane(&[], f32::INFINITY)),
        (
            "too much friction of the ground",
            "`world.ground_friction`",
            World { ground_friction: Some(2.5), ..World::default() },
        ),
        (
            "restitution that is NaN",
            "`world.ground_restitution`",
            World { ground_restitution: Some(f32::NAN), ..World::default() },
        ),
        ("33 colliders", "`world.colliders`", with(vec![collider(); 33])),
        (
            "a collider's name twice",
            "`world.colliders[1].name`",
            with(vec![collider(), named("collider0")]),
        ),
        (
            "a collider's name with a line break",
            "`world.colliders[0].name`",
            with(vec![named("a\nb")]),
        ),
    ]
}

fn colliders() -> Named<Collider> {
    const PATH: &str = "`world.colliders[0].path`";
    const POSE: &str = "`world.colliders[0].pose`";
    const POINTS: &str = "`world.colliders[0].convex_mesh.points`";
    let shaped = |shape| Collider { shape: Some(shape), ..Collider::default() };
    let sphere = |center: &[f32], radius_m| {
        shaped(Shape::Sphere(Sphere { center: center.to_vec(), radius_m }))
    };
    let carried = |carrier| Collider { carrier: Some(carrier), ..collider() };
    let mesh = |points| shaped(Shape::ConvexMesh(ConvexMesh { points }));
    let cuboid = |low: [f32; 3], high: [f32; 3]| {
        shaped(Shape::Cuboid(Cuboid { low: low.to_vec(), high: high.to_vec() }))
    };
    let capsule = Capsule { from: vec![0.0; 3], to: vec![0.0; 2], radius_m: 0.1 };
    let posed = |pose: &[f32]| Collider { pose: pose.to_vec(), ..collider() };
    vec![
        ("no shape", "`world.colliders[0].shape`", Collider::default()),
        (
            "a sphere of radius 0",
            "`world.colliders[0].sphere.radius_m`",
            sphere(&[0.0, 0.0, 0.1], 0.0),
        ),
        ("a centre of NaN", "`world.colliders[0].sphere.center`", sphere(&[f32::NAN; 3], 0.1)),
        (
            "an end of two numbers",
            "`world.colliders[0].capsule.to`",
            shaped(Shape::Capsule(capsule)),
        ),
        ("a box inside out", "`world.colliders[0].cuboid.low`", cuboid([0.1; 3], [0.0; 3])),
        ("no points of a mesh", POINTS, mesh(None)),
        ("three points of a mesh", POINTS, mesh(Some(zeros(&[3, 3])))),
        ("4097 points of a mesh", POINTS, mesh(Some(zeros(&[4097, 3])))),
        ("a mesh of millimetres", POINTS, mesh(Some(super::with(&[4, 3], 1e4)))),
        (
            "friction below 0",
            "`world.colliders[0].friction`",
            Collider { friction: Some(-0.1), ..collider() },
        ),
        (
            "a margin that is NaN",
            "`world.colliders[0].margin_m`",
            Collider { margin_m: f32::NAN, ..collider() },
        ),
        (
            "a carrier that is not there",
            "`world.colliders[0].gripper`",
            carried(Carrier::Gripper(1)),
        ),
        ("a path of other knots", PATH, carried(Carrier::Path(zeros(&[4, 7])))),
        ("a path without rotations", "length zero", carried(Carrier::Path(zeros(&[3, 7])))),
        ("a pose of six numbers", POSE, posed(&[0.0; 6])),
        ("a pose without a rotation", "length zero", posed(&[0.0; 7])),
        ("a pose of NaN", POSE, posed(&[f32::NAN; 7])),
    ]
}

fn grasps(n: u64) -> Named<Grasp> {
    let nodes = |nodes: &[u32]| Grasp {
        region: Some(Region::Nodes(Tensor::pack(&[nodes.len()], nodes))),
        ..Grasp::default()
    };
    let closed = |shape: &[usize], value: u32| Grasp {
        closed: Some(Tensor::pack(shape, &vec![value; shape.iter().product()])),
        ..grasp()
    };
    let empty = Region::Sphere(Sphere { radius_m: 0.0, ..ball() });
    vec![
        (
            "a gripper with a grasp that is not there",
            "`grasps[0].gripper`",
            Grasp { gripper: 1, ..grasp() },
        ),
        ("no region", "`grasps[0].region`", Grasp::default()),
        (
            "a region of radius 0",
            "`grasps[0].sphere.radius_m`",
            Grasp { region: Some(empty), ..grasp() },
        ),
        ("a grasp of no nodes", "`grasps[0].nodes`", nodes(&[])),
        ("a grasp of a node that is not there", "`grasps[0].nodes`", nodes(&[0, n as u32])),
        ("a grasp of a node twice", "`grasps[0].nodes`", nodes(&[1, 0, 1])),
        ("an unknown attachment", "`grasps[0].attachment`", Grasp { attachment: 7, ..grasp() }),
        ("the stiffness of a pin", "`grasps[0].stiffness`", Grasp { stiffness: 9.0, ..grasp() }),
        (
            "a damping that is NaN",
            "`grasps[0].damping`",
            Grasp { attachment: Attachment::Springs.into(), damping: f32::NAN, ..grasp() },
        ),
        ("closed by frames", "`grasps[0].closed`", closed(&[4], 1)),
        ("half closed", "`grasps[0].closed`", closed(&[3], 2)),
        ("closed for three instances", "`grasps[0].closed`", closed(&[3, 3], 1)),
        ("a force of 0", "`grasps[0].max_force_n`", Grasp { max_force_n: Some(0.0), ..grasp() }),
    ]
}

fn factors(values: &[f32]) -> Option<Tensor> {
    Some(Tensor::pack(&[values.len()], values))
}

fn varied() -> Named<Vary> {
    let stiffness = |values: &[f32]| Vary { stiffness: factors(values), ..Vary::default() };
    let mass = |values: &[f32]| Vary { mass: factors(values), ..Vary::default() };
    vec![
        ("a factor for three instances", "`vary.stiffness`", stiffness(&[1.0; 3])),
        ("a stiffness of 0", "`vary.stiffness`", stiffness(&[1.0, 0.0])),
        ("a mass that is NaN", "`vary.mass`", mass(&[f32::NAN, 1.0])),
        ("a mass of 101", "`vary.mass`", mass(&[1.0, 101.0])),
        (
            "a restitution above 1",
            "`vary.ground_restitution`",
            Vary { ground_restitution: factors(&[0.0, 1.5]), ..Vary::default() },
        ),
        ("fits without an ensemble", "`vary.fits`", Vary { fits: true, ..Vary::default() }),
    ]
}

/// What a mean of positions does not tell.
fn mean_predictions(of_fits: &RollOutRequest) -> Named<RollOutRequest> {
    let statistic = Statistic::MeanPrediction.into();
    let ensemble = Some(Ensemble { members: 3, statistic, share: 0.0 });
    let request = RollOutRequest { ensemble, ..of_fits.clone() };
    let force = Force { by: Some(By::Ground(All {})), limit_n: 0.0 };
    let cost = Cost { kind: Some(Kind::Force(force)), ..Cost::default() };
    let returning = |returns| RollOutRequest { returns: Some(returns), ..request.clone() };
    vec![
        (
            "a force in a mean",
            "`costs[0].force`",
            RollOutRequest { costs: vec![cost], ..request.clone() },
        ),
        (
            "the forces of a mean",
            "`returns.forces`",
            returning(Returns { forces: true, ..Returns::default() }),
        ),
        (
            "a mean in parts",
            "`returns.part_frames`",
            returning(Returns { part_frames: 1, ..Returns::default() }),
        ),
    ]
}

fn ensembles() -> Vec<(&'static str, &'static str, Ensemble, Option<Vary>)> {
    let of = |members, statistic: Statistic, share| Ensemble {
        members,
        statistic: statistic.into(),
        share,
    };
    let fits = || Some(Vary { fits: true, ..Vary::default() });
    let vary = |count: usize| Some(Vary { mass: factors(&vec![1.0; count]), ..Vary::default() });
    vec![
        ("no members", "`ensemble.members`", of(0, Statistic::Mean, 0.0), None),
        ("members that are the same", "`vary`", of(3, Statistic::Worst, 0.0), None),
        ("factors by instance of an ensemble", "`vary.mass`", of(3, Statistic::Mean, 0.0), vary(2)),
        ("a share of 0", "`ensemble.share`", of(3, Statistic::Cvar, 0.0), vary(3)),
        (
            "an unknown statistic",
            "`ensemble.statistic`",
            Ensemble { members: 3, statistic: 9, share: 0.0 },
            vary(3),
        ),
        (
            "more fits than the limits allow",
            "actions x members",
            of(u32::MAX, Statistic::Mean, 0.0),
            fits(),
        ),
        ("2^32 - 1 members", "actions x members", of(u32::MAX, Statistic::Mean, 0.0), vary(3)),
    ]
}
