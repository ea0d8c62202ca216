//! Faults that a client can make in the surroundings of an object.

use bendtwin_core::Point;

use crate::{
    Model,
    backend::Instance,
    model::State,
    objective::{ForceBy, Objective, Term},
    world::{
        Attachment, Collider, Face, Grasp, MAX_FACES, MAX_PARTS, Motion, Phase, Pose, Region,
        Shape, World, spring_share,
    },
};

/// Deviation of lengths and angles from those of rotations and unit vectors that is taken for
/// rounding.
const ROUNDING: f32 = 1e-3;
/// Widest layer of smooth contact [m].
const MAX_SMOOTHING_M: f32 = 0.1;

type Check = Result<(), String>;

/// Checks surroundings, their motion, and what grasps hold at the start.
///
/// # Errors
/// The first fault, as a sentence.
pub(super) fn surroundings(instance: &Instance) -> Check {
    let (world, motion) = (&*instance.world, &*instance.motion);
    let model = instance.model.model();
    for (what, count) in [
        ("bodies", world.bodies),
        ("colliders", world.colliders.len()),
        ("grasps", world.grasps.len()),
    ] {
        ensure(count <= MAX_PARTS, || format!("{count} {what}: {MAX_PARTS} is the most"))?;
    }
    let s = world.smoothing_m;
    ensure((0.0..=MAX_SMOOTHING_M).contains(&s), || {
        format!("contact smoothed over {s} m: it takes 0 to {MAX_SMOOTHING_M}")
    })?;
    self::motion(world, motion, instance.frames, model.graph.rods.len())?;
    for (k, c) in world.colliders.iter().enumerate() {
        collider(c, world.bodies).map_err(|e| format!("collider {k}: {e}"))?;
    }
    let mut owners = vec![None; model.graph.control_count()];
    for (g, of) in world.grasps.iter().enumerate() {
        let checked = grasp(of, world.bodies, model).and_then(|()| own(of, g, &mut owners));
        checked.map_err(|e| format!("grasp {g}: {e}"))?;
    }
    grasping(&instance.initial, world, model, &owners)
}

/// Checks the terms of an objective that name a part of the surroundings.
///
/// # Errors
/// The first fault, as a sentence.
pub(crate) fn terms(objective: &Objective, world: &World, controls: usize) -> Check {
    for (t, weighted) in objective.terms.iter().enumerate() {
        let exists = |what: &str, i: u32, n: usize| {
            ensure((i as usize) < n, || format!("objective term {t}: {what} {i} of {n}"))
        };
        let limit = match &weighted.term {
            Term::Force { by, limit } => {
                match *by {
                    ForceBy::Control(c) => exists("control point", c, controls)?,
                    ForceBy::Grasp(g) => exists("grasp", g, world.grasps.len())?,
                    ForceBy::Collider(k) => exists("collider", k, world.colliders.len())?,
                    ForceBy::Controls | ForceBy::Ground => (),
                }
                *limit
            }
            Term::Clearance { collider, margin_m } => {
                exists("collider", *collider, world.colliders.len())?;
                *margin_m
            }
            _ => continue,
        };
        ensure(limit.is_finite() && limit >= 0.0, || {
            format!("objective term {t}: a limit of {limit}: it must be finite and not negative")
        })?;
    }
    Ok(())
}

fn ensure(ok: bool, message: impl FnOnce() -> String) -> Check {
    if ok { Ok(()) } else { Err(message()) }
}

fn finite(point: &Point) -> bool {
    point.iter().all(|x| x.is_finite())
}

fn motion(world: &World, motion: &Motion, frames: usize, rods: usize) -> Check {
    let rows = |each: usize| frames.checked_add(1).and_then(|f| f.checked_mul(each));
    ensure(rows(world.bodies) == Some(motion.poses.len()), || {
        format!(
            "{} poses, expected ({frames} frames + 1) x {} bodies",
            motion.poses.len(),
            world.bodies
        )
    })?;
    ensure(frames.checked_mul(world.grasps.len()) == Some(motion.closed.len()), || {
        format!(
            "{} entries of closed, expected {frames} frames x {} grasps",
            motion.closed.len(),
            world.grasps.len()
        )
    })?;
    ensure(motion.rolls.is_empty() || rows(2 * rods) == Some(motion.rolls.len()), || {
        format!("{} rolls, expected ({frames} frames + 1) x {rods} rods x 2", motion.rolls.len())
    })?;
    ensure(motion.rolls.iter().all(|x| x.is_finite()), || "a roll is not finite".into())?;
    let wrong = motion.poses.iter().position(|p| !is_rigid(p));
    ensure(wrong.is_none(), || {
        let at = wrong.unwrap_or_default();
        let (frame, body) = (at / world.bodies.max(1), at % world.bodies.max(1));
        format!("the pose of body {body} at frame {frame} is not finite, or its matrix no rotation")
    })
}

/// True for a finite pose whose matrix is a rotation up to rounding.
fn is_rigid(pose: &Pose) -> bool {
    let [a, b, c] = pose;
    let dot = |a: &[f32; 4], b: &[f32; 4]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let volume = cross[0] * c[0] + cross[1] * c[1] + cross[2] * c[2];
    let off = [dot(a, b), dot(b, c), dot(c, a)];
    let lengths = [dot(a, a) - 1.0, dot(b, b) - 1.0, dot(c, c) - 1.0, volume - 1.0];
    pose.iter().flatten().all(|x| x.is_finite())
        && off.iter().chain(&lengths).all(|x| x.abs() <= 2.0 * ROUNDING)
}

fn collider(collider: &Collider, bodies: usize) -> Check {
    if let Some(body) = collider.body {
        ensure((body as usize) < bodies, || format!("body {body} of {bodies} bodies"))?;
    }
    let Collider { friction, restitution, .. } = collider;
    ensure((0.0..=2.0).contains(friction), || format!("friction {friction}: it takes 0 to 2"))?;
    ensure((0.0..=1.0).contains(restitution), || {
        format!("restitution {restitution}: it takes 0 to 1")
    })?;
    match &collider.shape {
        Shape::Capsule { from, to, radius_m } => {
            ensure(finite(from) && finite(to), || "an end is not finite".into())?;
            ensure(radius_m.is_finite() && *radius_m > 0.0, || {
                format!("a radius of {radius_m} m: it must be positive")
            })
        }
        Shape::Convex(faces) => {
            ensure((1..=MAX_FACES).contains(&faces.len()), || {
                format!("{} faces: it takes 1 to {MAX_FACES}", faces.len())
            })?;
            let is_unit = |f: &Face| {
                let square: f32 = f.normal.iter().map(|x| x * x).sum();
                f.offset_m.is_finite() && (square - 1.0).abs() <= 2.0 * ROUNDING
            };
            let wrong = faces.iter().position(|f| !is_unit(f));
            ensure(wrong.is_none(), || {
                format!(
                    "the normal of face {} is no unit vector, or its offset not finite",
                    wrong.unwrap_or_default()
                )
            })
        }
    }
}

fn grasp(grasp: &Grasp, bodies: usize, model: &Model) -> Check {
    let Grasp { body, region, attachment, max_force } = grasp;
    ensure((*body as usize) < bodies, || format!("body {body} of {bodies} bodies"))?;
    ensure(*max_force > 0.0, || {
        format!("a largest force of {max_force} N: it must be positive, infinite for none")
    })?;
    let (nodes, controls) = (model.graph.node_count(), model.graph.control_count());
    let outside = |of: &[u32], n: usize| of.iter().find(|&&i| i as usize >= n).copied();
    match region {
        Region::Sphere { center, radius_m } => {
            ensure(finite(center) && radius_m.is_finite() && *radius_m >= 0.0, || {
                format!("a sphere of {radius_m} m around {center:?}")
            })?;
        }
        Region::Box { low, high } => {
            let fits = low.iter().zip(high).all(|(low, high)| low <= high);
            ensure(finite(low) && finite(high) && fits, || {
                format!("a box from {low:?} to {high:?}")
            })?;
        }
        Region::Nodes(of) => {
            if let Some(node) = outside(of, nodes) {
                return Err(format!("node {node} of {nodes} nodes"));
            }
        }
        Region::Controls(of) => match outside(of, controls) {
            Some(control) => return Err(format!("control point {control} of {controls}")),
            // They hold by what the twin has for them.
            None => return Ok(()),
        },
    }
    let Attachment::Spring { stiffness, damping } = *attachment else { return Ok(()) };
    let share = spring_share(model, stiffness, damping);
    ensure(stiffness >= 0.0 && damping >= 0.0 && share <= 1.0, || {
        let most = crate::world::largest_stiffness(model);
        let fits = share.is_finite() && share > 0.0;
        let (k, c) = if fits { (stiffness / share, damping / share) } else { (most, 0.0) };
        format!(
            "a spring of {stiffness} N/m with {damping} N s/m is not stable at {} substeps a frame: \
             at most {k:.3} N/m with {c:.4} N s/m, or {most:.3} N/m without damping",
            model.timing.substeps
        )
    })
}

fn own(grasp: &Grasp, g: usize, owners: &mut [Option<usize>]) -> Check {
    let Region::Controls(controls) = &grasp.region else { return Ok(()) };
    for &c in controls.iter() {
        if let Some(other) = owners[c as usize].replace(g) {
            return Err(format!("control point {c} is in grasp {other} already"));
        }
    }
    Ok(())
}

fn grasping(state: &State, world: &World, model: &Model, owners: &[Option<usize>]) -> Check {
    let (phases, holds) = (&state.grasping.phases, &state.grasping.holds);
    let (n, g) = (model.graph.node_count(), world.grasps.len());
    ensure(phases.is_empty() || phases.len() == g, || {
        format!("{} initial phases for {g} grasps", phases.len())
    })?;
    ensure(holds.windows(2).all(|w| w[0].node < w[1].node), || {
        "initial holds are not in the order of their nodes, or one stands there twice".into()
    })?;
    if holds.is_empty() {
        return Ok(());
    }
    let phase = |grasp: usize| phases.get(grasp).copied().unwrap_or_default();
    let pinned = |node: u32| {
        let holds = |c: u32| match owners[c as usize] {
            // Without phases, hands of control points are closed.
            Some(g) => phases.get(g).is_none_or(|p| *p == Phase::Closed),
            None => true,
        };
        model.graph.pins.iter().any(|p| p.node == node && holds(p.control))
    };
    for hold in holds {
        let (node, grasp) = (hold.node, hold.grasp);
        let fault = if node as usize >= n {
            format!("node {node} of {n} nodes")
        } else if grasp as usize >= g {
            format!("grasp {grasp} of {g} grasps")
        } else if matches!(world.grasps[grasp as usize].region, Region::Controls(_)) {
            format!("grasp {grasp} holds by control points and takes no nodes")
        } else if phase(grasp as usize) != Phase::Closed {
            format!("grasp {grasp} is not closed")
        } else if !finite(&hold.place) {
            "its place is not finite".into()
        } else if pinned(node) {
            format!("a control point pins node {node}")
        } else {
            continue;
        };
        return Err(format!("initial hold of node {node}: {fault}"));
    }
    Ok(())
}
