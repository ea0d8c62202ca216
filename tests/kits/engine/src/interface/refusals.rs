//! Inputs that a backend must refuse, with a typed error and never a panic.

use std::sync::Arc;

use bendtwin_core::{CancelToken, Pin, Plane, environment::ControlVelocity};
use bendtwin_engine::{
    Backend, Error, Loaded, PointLoss, PointSet, Term,
    backend::{GradientRequest, Instance, Outputs},
    objective::WeightedTerm,
    world::{
        Attachment, Collider, Face, Grasp, Hold, IDENTITY, MAX_FACES, MAX_PARTS, Phase, Region,
        Shape,
    },
};

use crate::{
    expect::{Outcome, ensure},
    random::{RandomOptions, random_model, random_motion, random_objective},
    scene::Scene,
};

fn scene() -> Scene {
    let options = RandomOptions { ground: true, rod: true, pins: 4, ..RandomOptions::default() };
    let model = random_model(3, &options);
    let (state, controls) = random_motion(3, &model, 2);
    let objective = random_objective(3, &model, 2);
    let mut scene = Scene::around(model, state, controls, 2);
    scene.objective = objective;
    scene
}

/// A substep beyond the stability limit is refused with the number that would do and the node
/// that needs it; that number then is accepted and runs finite. The limit of semi-implicit Euler is
/// w dt < 2, so `needed` is at least the exact w dt / 2 and, as an estimate, at most 4 times that.
pub(crate) fn unstable_substeps_are_refused(backend: &dyn Backend) -> Outcome {
    let spring = |stiffness: f32, dashpot: f32| {
        let mut scene = Scene::of(&[[0.0; 3], [0.1, 0.0, 0.0], [0.2, 0.0, 0.0], [0.21, 0.0, 0.0]]);
        scene.spring([0, 1], 1.0, 0.01);
        scene.spring([1, 2], 1.0, 0.01);
        scene.spring([2, 3], stiffness, dashpot);
        scene.timing.fps = 30.0;
        scene.timing.substeps = 5;
        scene.last(30);
        scene
    };
    // w² = (k/l0)(1/m1 + 1/m2) = 2e7; a dashpot alone needs gamma (1/m1 + 1/m2) dt < 2.
    let stiff = (spring(1e5, 0.0), (2e7_f64).sqrt() / 2.0 / 30.0);
    let viscous = (spring(1.0, 1e3), 2e3 / 2.0 / 30.0);
    let mut bent = Scene::of(&[[0.0; 3], [0.01, 0.0, 0.0], [0.02, 0.0, 0.0]]);
    bent.triplet([0, 1, 2], std::f32::consts::PI, 100.0, 0.0);
    bent.timing = stiff.0.timing;
    bent.last(30);
    // theta = pi - (w0 - 2 w1 + w2)/h: w² = 6 k_theta / h².
    let bent = (bent, (600.0_f64 / 1e-4).sqrt() / 2.0 / 30.0);
    for (name, (mut scene, limit), nodes) in [
        ("a stiff spring", stiff, 2..=3),
        ("a strong dashpot", viscous, 2..=3),
        ("a stiff triplet", bent, 0..=2),
    ] {
        let refused = backend.load(Arc::new(scene.model()));
        let Err(Error::Unstable { substeps, needed, node }) = refused else {
            return Err(format!("{name} at {} substeps: {refused:?}", scene.timing.substeps));
        };
        let plausible = f64::from(needed) >= limit && f64::from(needed) <= 4.0 * limit + 2.0;
        ensure(substeps == 5 && plausible && nodes.contains(&node), || {
            format!(
                "{name}: needed {needed} (exact limit {limit:.1}), substeps {substeps}, node {node}"
            )
        })?;
        scene.timing.substeps = needed;
        scene.initial.velocities[0] = [0.01, 0.02, 0.0];
        scene.end(backend).map_err(|e| format!("{name} at {needed} substeps: {e}"))?;
    }
    Ok(())
}

/// A fault by name, and a function that introduces it.
type Break<T> = (&'static str, fn(&mut T));

/// Every contradiction in a model is InvalidModel.
pub(crate) fn wrong_models_are_refused(backend: &dyn Backend) -> Outcome {
    let breaks: [Break<Scene>; 32] = [
        ("a spring to nowhere", |s| s.graph.springs[0] = [0, 10_000]),
        ("a spring to itself", |s| s.graph.springs[0] = [4, 4]),
        ("a spring that starts at a control point", |s| {
            s.graph.springs[0] = [s.graph.node_count() as u32, 0];
        }),
        ("a triplet to nowhere", |s| s.graph.triplets[0] = [0, 1, u32::MAX]),
        ("a triplet with an arm twice", |s| s.graph.triplets[0] = [0, 1, 0]),
        ("a mass of zero", |s| s.graph.masses[2] = 0.0),
        ("a negative mass", |s| s.graph.masses[2] = -1.0),
        ("a rest position that is no number", |s| s.graph.rest_positions[0][1] = f32::NAN),
        ("too few kinds", |s| {
            s.graph.kinds.pop();
        }),
        ("kinds out of order", |s| s.graph.kinds.reverse()),
        ("a pin of no node", |s| s.graph.pins[0].node = 999),
        ("a pin to no control point", |s| s.graph.pins[0].control = 999),
        ("a node pinned twice", |s| {
            let pin: Pin = s.graph.pins[0];
            s.graph.pins.push(pin);
        }),
        ("a stiffness too few", |s| {
            s.params.spring_stiffness.pop();
        }),
        ("a rest angle too many", |s| s.params.rest_angles_rad.push(1.0)),
        ("a negative stiffness", |s| s.params.spring_stiffness[1] = -1.0),
        ("a damping that is no number", |s| s.params.bend_damping[0] = f32::NAN),
        ("an infinite dashpot", |s| s.params.spring_dashpot[0] = f32::INFINITY),
        ("a restitution above one", |s| s.params.contact.ground_restitution = 1.5),
        ("negative drag", |s| s.params.drag = -1.0),
        ("gravity that is no number", |s| s.environment.gravity[0] = f32::NAN),
        ("a ground without direction", |s| {
            s.environment.ground = Some(Plane { normal: [0.0; 3], offset_m: 0.0 });
        }),
        ("a rod through nowhere", |s| s.graph.rods[0][2] = 999),
        ("a rod without clamps", |s| s.graph.rods[0].rotate_left(2)),
        ("a rod that is all clamp", |s| s.graph.rods[0].truncate(3)),
        ("a rod through a node twice", |s| s.graph.rods[0][3] = s.graph.rods[0][2]),
        ("a twist stiffness too few", |s| s.params.twist_stiffness.clear()),
        ("a negative twist damping", |s| s.params.twist_damping[0] = -1.0),
        ("a rest twist that is no number", |s| s.params.rest_twists_rad[0] = f32::NAN),
        ("a rod whose clamps' velocity is ignored", |s| {
            s.control_velocity = ControlVelocity::Ignored;
        }),
        ("no substeps", |s| s.timing.substeps = 0),
        ("a frame rate that is no number", |s| s.timing.fps = f64::NAN),
    ];
    scene().load(backend)?;
    for (what, break_it) in breaks {
        let mut scene = scene();
        break_it(&mut scene);
        let got = backend.load(Arc::new(scene.model()));
        ensure(matches!(got, Err(Error::InvalidModel(_))), || {
            format!("{what}: {got:?}, expected InvalidModel")
        })?;
    }
    Ok(())
}

/// The arguments of one call.
struct Request {
    instance: Instance,
    outputs: Outputs,
}

fn state(request: &mut Request) -> &mut bendtwin_engine::model::State {
    Arc::make_mut(&mut request.instance.initial)
}

fn add_term(request: &mut Request, frame: usize, group: usize, term: Term) {
    let terms = Arc::make_mut(&mut request.instance.objective.terms);
    terms.push(WeightedTerm { frame, weight: 1.0, group, term });
}

fn track(nodes: Vec<u32>, targets: Vec<[f32; 3]>) -> Term {
    Term::Track { of: PointSet::Nodes, points: nodes, targets, loss: PointLoss::Distance }
}

/// Every input that does not fit its model is InvalidInput, in all three calls (wrong outputs:
/// in the one that records), and a good input after it still runs.
pub(crate) fn wrong_inputs_are_refused(backend: &dyn Backend) -> Outcome {
    let breaks: [Break<Request>; 30] = [
        ("a position too few", |r| {
            state(r).positions.pop();
        }),
        ("a velocity too many", |r| state(r).velocities.push([0.0; 3])),
        ("no state at all", |r| *state(r) = Default::default()),
        ("a position that is no number", |r| state(r).positions[3][0] = f32::NAN),
        ("an infinite velocity", |r| state(r).velocities[3][0] = f32::INFINITY),
        ("a twist too many", |r| state(r).twists.push(0.0)),
        ("a twist that is no number", |r| state(r).twists[0] = f32::NAN),
        ("a control too few", |r| {
            Arc::make_mut(&mut r.instance.controls).pop();
        }),
        ("no controls", |r| Arc::make_mut(&mut r.instance.controls).clear()),
        ("more frames than controls", |r| r.instance.frames += 1),
        ("a control that is no number", |r| {
            Arc::make_mut(&mut r.instance.controls)[1][2] = f32::NAN;
        }),
        ("a term after the last frame", |r| add_term(r, 99, 0, Term::Acceleration)),
        ("a term of no group", |r| add_term(r, 2, 99, Term::Acceleration)),
        ("a track of no node", |r| add_term(r, 2, 0, track(vec![9999], vec![[0.0; 3]]))),
        ("a track without targets", |r| add_term(r, 2, 0, track(vec![0, 1], vec![[0.0; 3]]))),
        ("a track of no skin point", |r| {
            let (points, targets) = (vec![9999], vec![[0.0; 3]]);
            let loss = PointLoss::Distance;
            add_term(r, 2, 0, Term::Track { of: PointSet::Skin, points, targets, loss });
        }),
        ("a target that is no number", |r| {
            add_term(r, 2, 0, Term::Chamfer { of: PointSet::Nodes, targets: vec![[f32::NAN; 3]] });
        }),
        ("a negative limit of strain", |r| add_term(r, 2, 0, Term::Strain { limit: -0.1 })),
        ("a half space without direction", |r| {
            add_term(r, 2, 0, Term::Above { nodes: None, normal: [0.0; 3], offset_m: 0.0 });
        }),
        ("a half space of no node", |r| {
            let nodes = Some(Arc::new(vec![9999]));
            add_term(r, 2, 0, Term::Above { nodes, normal: [0.0, 0.0, 1.0], offset_m: 0.0 });
        }),
        ("a box without extent", |r| {
            add_term(r, 2, 0, Term::Within { nodes: None, low: [0.1; 3], high: [0.0; 3] });
        }),
        ("a box that is no number", |r| {
            add_term(r, 2, 0, Term::Within { nodes: None, low: [f32::NAN; 3], high: [0.0; 3] });
        }),
        ("an order of no node", |r| {
            let (of, points) = (PointSet::Nodes, Arc::new(vec![0, 9999]));
            add_term(r, 2, 0, Term::Order { of, points, direction: [1.0, 0.0, 0.0], gap_m: 0.0 });
        }),
        ("an order without direction", |r| {
            let (of, points) = (PointSet::Nodes, Arc::new(vec![0, 1]));
            add_term(r, 2, 0, Term::Order { of, points, direction: [0.0; 3], gap_m: 0.0 });
        }),
        ("a negative gap", |r| {
            let (of, points) = (PointSet::Nodes, Arc::new(vec![0, 1]));
            add_term(r, 2, 0, Term::Order { of, points, direction: [1.0, 0.0, 0.0], gap_m: -0.1 });
        }),
        ("a winding of turns that are no number", |r| {
            let (of, points, origin) = (PointSet::Nodes, Arc::new(vec![0, 1]), [0.0; 3]);
            let (direction, turns) = ([1.0, 0.0, 0.0], f32::NAN);
            add_term(r, 2, 0, Term::Winding { of, points, origin, direction, turns });
        }),
        ("a coverage without reach", |r| {
            let (of, targets) = (PointSet::Nodes, Arc::new(vec![[0.0; 3]]));
            add_term(r, 2, 0, Term::Coverage { of, targets, reach_m: 0.0 });
        }),
        ("a weight that is no number", |r| {
            add_term(r, 2, 0, Term::Acceleration);
            if let Some(term) = Arc::make_mut(&mut r.instance.objective.terms).last_mut() {
                term.weight = f32::NAN;
            }
        }),
        ("outputs of no node", |r| r.outputs.nodes = Some(Arc::new(vec![0, 9999]))),
        ("a model of another backend", |r| {
            let model = r.instance.model.model().clone();
            r.instance.model = Loaded::new(model, Arc::new("not yours"));
        }),
    ];
    let scene = scene();
    let loaded = scene.load(backend)?;
    let cancel = CancelToken::default();
    for (what, break_it) in breaks {
        let mut request =
            Request { instance: scene.instance(loaded.clone()), outputs: Outputs::default() };
        break_it(&mut request);
        let records = request.outputs != Outputs::default();
        let good = scene.instance(loaded.clone());
        let batch = [good.clone(), request.instance];
        let mut errors = vec![backend.roll_out(&batch, &request.outputs, &cancel).err()];
        if !records {
            errors.push(backend.losses(&batch, &cancel).err());
            errors.push(backend.gradients(&batch, &GradientRequest::default(), &cancel).err());
        }
        for error in errors {
            ensure(matches!(error, Some(Error::InvalidInput(_))), || {
                format!("{what}: {error:?}, expected InvalidInput")
            })?;
        }
        backend.losses(&[good], &cancel).map_err(|e| format!("after {what}: {e}"))?;
    }
    Ok(())
}

/// [`scene`] with a body that carries a hand and a collider.
fn surrounded() -> Scene {
    let mut scene = scene();
    let body = scene.body(|_| IDENTITY);
    let region = Region::Sphere { center: [0.0; 3], radius_m: 0.01 };
    let attachment = Attachment::Spring { stiffness: 100.0, damping: 1.0 };
    scene.grasp(Grasp { body, region, attachment, max_force: 100.0 }, |_| true);
    let face = Face { normal: [0.0, 0.0, -1.0], offset_m: 1.0 };
    let shape = Shape::Convex(Arc::new(vec![face]));
    scene.world.colliders.push(Collider {
        body: Some(body),
        shape,
        friction: 0.5,
        restitution: 0.0,
    });
    scene
}

fn hold(scene: &mut Scene, node: u32, grasp: u32, place: [f32; 3]) {
    scene.initial.grasping.phases = vec![Phase::Closed];
    scene.initial.grasping.holds.push(Hold { node, grasp, place });
}

fn convex(scene: &mut Scene, normal: [f32; 3], count: usize) {
    let faces = vec![Face { normal, offset_m: 1.0 }; count];
    scene.world.colliders[0].shape = Shape::Convex(Arc::new(faces));
}

/// Everything about surroundings that cannot be is InvalidInput.
pub(crate) fn wrong_surroundings_are_refused(backend: &dyn Backend) -> Outcome {
    let breaks: [Break<Scene>; 28] = [
        ("a pose too few", |s| {
            s.motion.poses.pop();
        }),
        ("a pose that is no number", |s| s.motion.poses[1][0][3] = f32::NAN),
        ("a pose that shears", |s| s.motion.poses[1][0][1] = 0.1),
        ("a pose that mirrors", |s| s.motion.poses[0][2][2] = -1.0),
        ("an entry of closed too many", |s| s.motion.closed.push(true)),
        ("a roll too many", |s| s.motion.rolls = vec![0.0; 99]),
        ("a roll that is no number", |s| s.motion.rolls = vec![f32::NAN; 3]),
        ("a collider on no body", |s| s.world.colliders[0].body = Some(7)),
        ("friction above 2", |s| s.world.colliders[0].friction = 2.5),
        ("a negative restitution", |s| s.world.colliders[0].restitution = -0.1),
        ("a normal that is no unit vector", |s| convex(s, [0.0, 0.0, 2.0], 1)),
        ("too many faces", |s| convex(s, [0.0, 0.0, -1.0], MAX_FACES + 1)),
        ("no face", |s| convex(s, [0.0, 0.0, -1.0], 0)),
        ("a capsule without radius", |s| {
            let (from, to) = ([0.0; 3], [1.0; 3]);
            s.world.colliders[0].shape = Shape::Capsule { from, to, radius_m: 0.0 };
        }),
        ("too many colliders", |s| {
            s.world.colliders = vec![s.world.colliders[0].clone(); MAX_PARTS + 1];
        }),
        ("a grasp of no body", |s| s.world.grasps[0].body = 1),
        ("a largest force of zero", |s| s.world.grasps[0].max_force = 0.0),
        ("a spring that is not stable", |s| {
            s.world.grasps[0].attachment = Attachment::Spring { stiffness: 1e9, damping: 0.0 };
        }),
        ("a region of no node", |s| {
            s.world.grasps[0].region = Region::Nodes(Arc::new(vec![9999]));
        }),
        ("a region of no control point", |s| {
            s.world.grasps[0].region = Region::Controls(Arc::new(vec![9999]));
        }),
        ("a box with nothing in it", |s| {
            s.world.grasps[0].region = Region::Box { low: [1.0; 3], high: [0.0; 3] };
        }),
        ("a negative width of contact", |s| s.world.smoothing_m = -1e-3),
        ("a phase too many", |s| s.initial.grasping.phases = vec![Phase::Open; 2]),
        ("a hold of no node", |s| hold(s, 9999, 0, [0.0; 3])),
        ("a hold of no grasp", |s| hold(s, 5, 3, [0.0; 3])),
        ("a hold twice", |s| {
            hold(s, 5, 0, [0.0; 3]);
            hold(s, 5, 0, [0.0; 3]);
        }),
        ("a hold in an open hand", |s| {
            hold(s, 5, 0, [0.0; 3]);
            s.initial.grasping.phases = vec![Phase::Open];
        }),
        ("a hold of a pinned node", |s| {
            let node = s.graph.pins[0].node;
            hold(s, node, 0, [0.0; 3]);
        }),
    ];
    let cancel = CancelToken::default();
    surrounded().loss(backend)?;
    for (what, break_it) in breaks {
        let mut scene = surrounded();
        break_it(&mut scene);
        let batch = [scene.instance(scene.load(backend)?)];
        let error = backend.losses(&batch, &cancel).err();
        ensure(matches!(error, Some(Error::InvalidInput(_))), || {
            format!("{what}: {error:?}, expected InvalidInput")
        })?;
    }
    Ok(())
}
