//! Everything that a client can get wrong about a model or an instance, found before the simulation
//! starts.

pub(crate) mod surroundings;

use std::sync::Arc;

use bendtwin_core::{Environment, Point, environment::ControlVelocity};

use crate::{
    Model,
    backend::{Error, Instance, Outputs},
    objective::{Objective, PointLoss, PointSet, Term, WeightedTerm},
    stability::enough_substeps,
};

/// Largest number of substeps a frame, within which a rollout cannot be cancelled.
const MAX_SUBSTEPS: u32 = 1_000_000;
/// Largest number of frames of a rollout, which nothing else bounds without control points.
const MAX_FRAMES: usize = 1_000_000;

/// Least and greatest reach of a coverage [m], whose squares are numbers in single precision.
const REACHES_M: std::ops::RangeInclusive<f32> = 1e-6..=1e6;

/// Fault of a term of a model without skin.
const NO_SKIN: &str = "the model has no skin: ask for its nodes";

/// Checks a model's graph, parameters, timing and environment.
///
/// # Errors
/// The first fault, as a sentence.
pub fn model(model: &Model) -> Result<(), Error> {
    unstepped_model(model)?;
    if model.timing.substeps == 0 {
        return Err(Error::InvalidModel("0 substeps a frame: at least one is needed".into()));
    }
    if model.timing.substeps > MAX_SUBSTEPS {
        return Err(Error::InvalidModel(format!(
            "{} substeps a frame: {MAX_SUBSTEPS} is the most",
            model.timing.substeps
        )));
    }
    Ok(())
}

/// Checks a model and that its substep is short enough for its stiffness.
///
/// # Errors
/// The first fault, as a sentence; [`Error::Unstable`] has the number of substeps that are needed.
pub fn loadable(model: &Model) -> Result<(), Error> {
    self::model(model)?;
    let substeps = model.timing.substeps;
    enough_substeps(model, substeps).map_err(|needs| Error::Unstable {
        substeps,
        needed: needs.needed,
        node: needs.stiffest_node,
    })
}

/// Checks a model whose number of substeps is still to be chosen.
///
/// # Errors
/// The first fault, as a sentence.
pub fn unstepped_model(model: &Model) -> Result<(), Error> {
    let invalid = Error::InvalidModel;
    model.graph.check().map_err(invalid)?;
    model.params.check(&model.graph).map_err(invalid)?;
    model.skin.check(model.graph.node_count()).map_err(invalid)?;
    if !model.graph.rods.is_empty() && model.control_velocity == ControlVelocity::Ignored {
        let why = "rods twist by how their clamps move: they need the controls' true velocity";
        return Err(invalid(why.into()));
    }
    let timing = model.timing;
    if !(timing.fps.is_finite() && timing.fps > 0.0) {
        return Err(invalid(format!("{} frames a second: it must be positive", timing.fps)));
    }
    environment(&model.environment)
}

/// Checks gravity and ground.
///
/// # Errors
/// The first fault, as a sentence.
pub fn environment(environment: &Environment) -> Result<(), Error> {
    let invalid = Error::InvalidModel;
    if !finite(&[environment.gravity]) {
        return Err(invalid("gravity is not finite".into()));
    }
    if let Some(g) = environment.ground {
        let length = g.normal.iter().map(|x| x * x).sum::<f32>().sqrt();
        if !(g.offset_m.is_finite() && (length - 1.0).abs() < 1e-3) {
            return Err(invalid(format!(
                "the ground's normal has length {length} and its offset is {}: the normal must be a unit vector",
                g.offset_m
            )));
        }
    }
    Ok(())
}

/// Checks an instance against its model.
///
/// # Errors
/// The first fault, as a sentence.
pub fn instance(index: usize, instance: &Instance) -> Result<(), Error> {
    let graph = &instance.model.model().graph;
    let (n, c) = (graph.node_count(), graph.control_count());
    let wrong = |what: String| Err(Error::InvalidInput(format!("instance {index}: {what}")));
    let state = &instance.initial;
    if state.positions.len() != n || state.velocities.len() != n {
        return wrong(format!(
            "{} initial positions and {} velocities for {n} nodes",
            state.positions.len(),
            state.velocities.len()
        ));
    }
    let rods = graph.rods.len();
    if !(state.twists.is_empty() || state.twists.len() == rods) {
        return wrong(format!("{} initial twists for {rods} rods", state.twists.len()));
    }
    if !state.twists.iter().all(|x| x.is_finite()) {
        return wrong("an initial twist is not finite".into());
    }
    if !finite(&state.positions) || !finite(&state.velocities) {
        return wrong("the initial state is not finite".into());
    }
    if instance.frames > MAX_FRAMES {
        return wrong(format!("{} frames: {MAX_FRAMES} is the most", instance.frames));
    }
    let rows = instance.frames.checked_add(1).and_then(|f| f.checked_mul(c));
    if rows != Some(instance.controls.len()) {
        return wrong(format!(
            "{} control positions, expected ({} frames + 1) x {c} control points",
            instance.controls.len(),
            instance.frames
        ));
    }
    if !finite(&instance.controls) {
        return wrong("a control position is not finite".into());
    }
    surroundings::surroundings(instance).or_else(wrong)?;
    surroundings::terms(&instance.objective, &instance.world, c).or_else(wrong)?;
    let skin = instance.model.model().skin.len();
    objective(&instance.objective, instance.frames, [n, skin]).or_else(wrong)
}

/// Checks an objective of a rollout, given its number of frames and the numbers of nodes and skin
/// points.
///
/// # Errors
/// The first fault, as a sentence.
pub fn objective(objective: &Objective, frames: usize, counts: [usize; 2]) -> Result<(), String> {
    let groups = objective.groups.len();
    for (t, weighted) in objective.terms.iter().enumerate() {
        term(weighted, frames, groups, counts).map_err(|e| format!("objective term {t}: {e}"))?;
    }
    Ok(())
}

fn term(
    t: &WeightedTerm,
    frames: usize,
    groups: usize,
    [nodes, skin]: [usize; 2],
) -> Result<(), String> {
    if t.frame > frames {
        return Err(format!("frame {} of a rollout of {frames} frames", t.frame));
    }
    if t.group >= groups {
        return Err(format!("group {} of {groups} groups", t.group));
    }
    if !t.weight.is_finite() {
        return Err("its weight is not finite".into());
    }
    match &t.term {
        Term::Chamfer { of, targets } => surface(*of, targets, skin),
        Term::Coverage { of, targets, reach_m } => {
            if !REACHES_M.contains(reach_m) {
                let (least, most) = (REACHES_M.start(), REACHES_M.end());
                return Err(format!("a reach of {reach_m} m: it must lie in {least}..={most}"));
            }
            surface(*of, targets, skin)
        }
        Term::Order { of, points, direction, gap_m } => {
            if !(gap_m.is_finite() && *gap_m >= 0.0) {
                return Err(format!("a gap of {gap_m} m: it must be finite and not negative"));
            }
            unit(direction)?;
            some_points(*of, points, [nodes, skin])
        }
        Term::Winding { of, points, origin, direction, turns } => {
            if !(finite(&[*origin]) && turns.is_finite()) {
                return Err(format!("{turns} turns around {origin:?}: all must be finite"));
            }
            unit(direction)?;
            some_points(*of, points, [nodes, skin])
        }
        Term::Track { of, points, targets, loss } => {
            if points.len() != targets.len() {
                return Err(format!("{} points but {} targets", points.len(), targets.len()));
            }
            some_points(*of, points, [nodes, skin])?;
            if !finite(targets) {
                return Err("a target is not finite".into());
            }
            match loss {
                PointLoss::SmoothL1 { beta_m } if !(beta_m.is_finite() && *beta_m >= 0.0) => {
                    Err(format!("beta is {beta_m} m: it must be finite and not negative"))
                }
                _ => Ok(()),
            }
        }
        Term::Strain { limit } if !(limit.is_finite() && *limit >= 0.0) => {
            Err(format!("a strain of {limit} as the limit: it must be finite and not negative"))
        }
        Term::Above { nodes: of, normal, offset_m } => {
            if !offset_m.is_finite() {
                return Err(format!("its offset is {offset_m}: it must be finite"));
            }
            unit(normal)?;
            some_nodes(of.as_ref(), nodes)
        }
        Term::Within { nodes: of, low, high } => {
            if !(finite(&[*low, *high]) && low.iter().zip(high).all(|(low, high)| low <= high)) {
                return Err(format!("no box lies between {low:?} and {high:?}"));
            }
            some_nodes(of.as_ref(), nodes)
        }
        _ => Ok(()),
    }
}

/// Checks targets whose nearest points are sought.
fn surface(of: PointSet, targets: &[Point], skin: usize) -> Result<(), String> {
    if of == PointSet::Skin && skin == 0 {
        return Err(NO_SKIN.into());
    }
    if finite(targets) { Ok(()) } else { Err("a target is not finite".into()) }
}

/// Checks that points exist, given the numbers of nodes and skin points.
fn some_points(of: PointSet, points: &[u32], [nodes, skin]: [usize; 2]) -> Result<(), String> {
    let (what, count) = match of {
        PointSet::Nodes => ("node", nodes),
        PointSet::Skin => ("skin point", skin),
    };
    match points.iter().find(|&&i| i as usize >= count) {
        Some(point) => Err(format!("{what} {point} of {count} {what}s")),
        None => Ok(()),
    }
}

/// Checks that a direction has length one.
fn unit(direction: &Point) -> Result<(), String> {
    let length = direction.iter().map(|x| x * x).sum::<f32>().sqrt();
    if (length - 1.0).abs() < 1e-3 {
        return Ok(());
    }
    Err(format!("its direction {direction:?} has length {length}: it must be a unit vector"))
}

/// Checks that nodes exist.
fn some_nodes(some: Option<&Arc<Vec<u32>>>, nodes: usize) -> Result<(), String> {
    match some.and_then(|some| some.iter().find(|&&i| i as usize >= nodes)) {
        Some(node) => Err(format!("node {node} of {nodes} nodes")),
        None => Ok(()),
    }
}

/// Checks what to record against an instance's model.
///
/// # Errors
/// The first fault, as a sentence.
pub fn outputs(index: usize, of: &Instance, outputs: &Outputs) -> Result<(), Error> {
    let n = of.model.model().graph.node_count();
    let outside = outputs.nodes.as_ref().and_then(|s| s.iter().find(|&&i| i as usize >= n));
    match outside {
        Some(node) => Err(Error::InvalidInput(format!(
            "instance {index}: node {node} is to be recorded, but the model has {n} nodes"
        ))),
        None => Ok(()),
    }
}

fn finite(points: &[Point]) -> bool {
    points.iter().flatten().all(|x| x.is_finite())
}
