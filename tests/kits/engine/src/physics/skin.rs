//! Terms at the skin: where its points are, and their gradients.

use std::sync::Arc;

use bendtwin_core::{Graph, Point, Skin};
use bendtwin_engine::{Backend, PointLoss, PointSet, Term, model::State, objective::WeightedTerm};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{
    differences::{Check, matches_differences},
    expect::{Outcome, close, ensure},
    interface::gradients::{keep, sought, tracked},
    random::{RandomOptions, random_model, random_objective},
    scene::{Scene, difference, norm},
};

/// Row-major.
type Matrix = [[f32; 3]; 3];

fn moved(by: &Matrix, p: Point) -> Point {
    let shift = [0.3, -0.2, 0.1];
    std::array::from_fn(|i| shift[i] + (0..3).map(|k| by[i][k] * p[k]).sum::<f32>())
}

/// Moves the nodes of a random model and measures how far from the moved rest places its skin points
/// are: the mean over those that are `wanted`, and as much as 1 cm more with targets that far away.
/// To 2e-6 m, some roundings of coordinates up to 1 m.
fn carried(backend: &dyn Backend, by: &Matrix, wanted: fn(&Skin, usize) -> bool) -> Outcome {
    for seed in 0..4 {
        let model = random_model(seed, &RandomOptions { pins: 0, ..RandomOptions::default() });
        let skin = model.skin.clone();
        let rest = skin.positions(&model.graph.rest_positions);
        let points: Vec<u32> =
            (0..skin.len()).filter(|&m| wanted(&skin, m)).map(|m| m as u32).collect();
        ensure(points.len() > skin.len() / 4, || format!("only {} points", points.len()))?;
        let at = |up: f32| -> Vec<Point> {
            let target = |&m: &u32| {
                let [x, y, z] = moved(by, rest[m as usize]);
                [x, y, z + up]
            };
            points.iter().map(target).collect()
        };
        let state = State {
            positions: model.graph.rest_positions.iter().map(|p| moved(by, *p)).collect(),
            ..State::rest(&model.graph)
        };
        let controls = model.graph.control_rest.clone();
        let mut scene = Scene::around(model, state, controls, 0);
        let track = |targets: Vec<Point>| Term::Track {
            of: PointSet::Skin,
            points: points.clone(),
            targets,
            loss: PointLoss::Distance,
        };
        scene.objective.groups = vec!["here".into(), "off".into()];
        let term = |group: usize, term| WeightedTerm { frame: 0, weight: 1.0, group, term };
        scene.objective.terms = Arc::new(vec![term(0, track(at(0.0))), term(1, track(at(0.01)))]);
        let loss = scene.loss(backend)?;
        close("the skin's distance from its moved places", loss.groups[0], 0.0, 2e-6)?;
        close("from places 1 cm above", loss.groups[1], 0.01, 2e-6)?;
    }
    Ok(())
}

/// Points without offset follow every affine motion of their nodes.
pub(crate) fn skins_follow_affine_motions(backend: &dyn Backend) -> Outcome {
    let shear = [[1.1, 0.3, -0.1], [-0.2, 0.8, 0.2], [0.1, -0.4, 1.3]];
    carried(backend, &shear, |skin, m| skin.offsets_m[m] == [0.0; 3])
}

/// Points in a frame of nodes follow their rigid motions too.
pub(crate) fn skins_follow_rigid_motions(backend: &dyn Backend) -> Outcome {
    let (s, c) = 0.9_f32.sin_cos();
    let turn = [[c, -s, 0.0], [0.6 * s, 0.6 * c, -0.8], [0.8 * s, 0.8 * c, 0.6]];
    carried(backend, &turn, |skin, m| {
        skin.offsets_m[m] == [0.0; 3] || skin.frames[m][0] != Skin::NO_FRAME
    })
}

/// Nodes on a line, and a node named twice, give a frame no direction in any precision: what is off
/// them in it is at the weighted mean. To 2e-6 m.
pub(crate) fn frames_without_a_triangle_hold_nothing_off(backend: &dyn Backend) -> Outcome {
    let line = [0.0, 1.0, 2.0].map(|i: f32| [0.013 * i, 0.037 * i, 0.029 * i]);
    for corners in [[0, 1, 2], [2, 0, 1], [0, 1, 1], [0, 0, 1]] {
        let mut scene = Scene::of(&line);
        scene.skin.push(Graph::NOT_OBSERVED, &[(0, 0.5), (1, 0.5)], corners, [0.02, -0.03, 0.05]);
        scene.frames = 0;
        let term = Term::Track {
            of: PointSet::Skin,
            points: vec![0],
            targets: vec![line[1].map(|x| 0.5 * x)],
            loss: PointLoss::Distance,
        };
        scene.objective.groups = vec!["here".into()];
        scene.objective.terms =
            Arc::new(vec![WeightedTerm { frame: 0, weight: 1.0, group: 0, term }]);
        let loss = scene.loss(backend)?;
        close("the distance from the weighted mean", loss.total, 0.0, 2e-6)?;
    }
    Ok(())
}

/// Every term at the skin: to 1 %. Targets lie so near to where points come that the nearest point stays
/// the same within a step.
pub(crate) fn gradients_of_skin_terms(backend: &dyn Backend) -> Outcome {
    let wanted: [fn(&Term) -> bool; 7] = [
        |t| matches!(t, Term::Chamfer { of: PointSet::Skin, .. }),
        |t| matches!(t, Term::Track { of: PointSet::Skin, loss: PointLoss::Distance, .. }),
        |t| matches!(t, Term::Track { of: PointSet::Skin, loss: PointLoss::SmoothL1 { .. }, .. }),
        |t| matches!(t, Term::Track { of: PointSet::Skin, loss: PointLoss::SquaredDistance, .. }),
        |t| matches!(t, Term::Order { of: PointSet::Skin, .. }),
        |t| matches!(t, Term::Winding { of: PointSet::Skin, .. }),
        |t| matches!(t, Term::Coverage { of: PointSet::Skin, .. }),
    ];
    for (i, wanted) in wanted.into_iter().enumerate() {
        let seed = 40 + i as u64;
        let mut scene = tracked(seed, &RandomOptions::default(), 4);
        in_frames(&mut scene.skin);
        scene.objective = random_objective(seed, &scene.model(), 4);
        keep(&mut scene.objective, wanted);
        near_skin(backend, &mut scene)?;
        let must_matter: &[&str] = &["initial velocities", "initial positions"];
        matches_differences(backend, &scene, &Check { seed, tolerance: 1e-2, must_matter })?;
    }
    Ok(())
}

/// Puts every third point of a skin 1 cm off its weighted mean, in a frame of its first three
/// carriers.
pub fn in_frames(skin: &mut Skin) {
    for m in (0..skin.len()).step_by(3) {
        let first = skin.starts[m] as usize;
        if let [a, b, c] = skin.nodes[first..first + 3] {
            (skin.frames[m], skin.offsets_m[m]) = ([a, b, c], [0.01, -0.005, 0.007]);
        }
    }
}

/// Moves targets whose nearest points are sought to within some 2 mm of skin points in their frame.
fn near_skin(backend: &dyn Backend, scene: &mut Scene) -> Outcome {
    let rollout = scene.roll_out(backend)?;
    let n = scene.graph.node_count();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for term in Arc::make_mut(&mut scene.objective.terms) {
        let points = scene.skin.positions(&rollout.positions[term.frame * n..][..n]);
        if let Some(targets) = sought(&mut term.term) {
            for (target, point) in targets.iter_mut().zip(&points) {
                *target = point.map(|x| x + 0.004 * (rng.random::<f32>() - 0.3));
            }
        }
    }
    Ok(())
}

/// Terms at a skin that is the surface nodes are those at the nodes: to 1e-6 of each.
pub(crate) fn a_skin_of_nodes_is_the_nodes(backend: &dyn Backend) -> Outcome {
    let mut scene = tracked(3, &RandomOptions::default(), 4);
    scene.skin = Skin::of_nodes(&scene.graph);
    scene.objective = random_objective(3, &scene.model(), 4);
    keep(&mut scene.objective, |t| {
        matches!(
            t,
            Term::Chamfer { of: PointSet::Nodes, .. }
                | Term::Track { of: PointSet::Nodes, .. }
                | Term::Order { of: PointSet::Nodes, .. }
                | Term::Winding { of: PointSet::Nodes, .. }
                | Term::Coverage { of: PointSet::Nodes, .. }
        )
    });
    let at_nodes = scene.gradient(backend, &crate::differences::REQUEST)?;
    for term in Arc::make_mut(&mut scene.objective.terms) {
        match &mut term.term {
            Term::Chamfer { of, .. }
            | Term::Track { of, .. }
            | Term::Order { of, .. }
            | Term::Winding { of, .. }
            | Term::Coverage { of, .. } => *of = PointSet::Skin,
            other => return Err(format!("{other:?} is no term of points")),
        }
    }
    let at_skin = scene.gradient(backend, &crate::differences::REQUEST)?;
    let (nodes, skin) = (at_nodes.loss.total, at_skin.loss.total);
    ensure(nodes > 1e-6, || format!("the loss is {nodes}"))?;
    close("the loss at the skin", skin, nodes, 1e-6 * nodes)?;
    let starts = [at_nodes, at_skin].map(|g| g.initial.map(|s| s.positions).unwrap_or_default());
    let size = starts[0].iter().map(|p| norm(difference(*p, [0.0; 3]))).fold(0.0, f64::max);
    for (a, b) in starts[0].iter().zip(&starts[1]) {
        close("a gradient", norm(difference(*a, *b)), 0.0, 1e-5 * size)?;
    }
    Ok(())
}
