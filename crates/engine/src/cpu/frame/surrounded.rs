//! A frame of an object with surroundings: [`super::integrate`] with grasps, colliders and measured
//! forces in their places, and its adjoint. Kept apart so that substeps of an object with only the
//! ground around it test for none of these.

mod back;

use super::{
    control::{FrameControls, progress},
    integrate::{Substeps, Workspace, accelerate, ground_law},
};
use crate::{
    cpu::{
        arithmetic::{Machine, Node, Quad, Real, Work, dot, scale},
        collision::{
            clearance::{Clearance, Surfaces},
            contact::collide,
            meet::{Obstacle, Scene},
            smooth::Layer,
        },
        elements::{bend_forces, rod_forces, spring_forces},
        surroundings::{Around, Surroundings},
        system::System,
    },
    world::Phase,
};

pub(crate) use self::back::{BackSurrounded, begin_adjoint};

/// A frame of a rollout, 0-based, and what surrounds the object in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame<'a, T> {
    pub(crate) of: &'a Surroundings<T>,
    pub(crate) frame: usize,
    /// Frames F of the rollout.
    pub(crate) frames: usize,
}

/// Work done once per frame: hands open and close, and what they and control points hold takes its
/// new velocity; contact and colliders find their candidates.
pub(crate) fn begin_frame<T: Real>(
    at: Frame<'_, T>,
    system: &System<T>,
    controls: FrameControls<'_, T>,
    workspace: &mut Workspace<T>,
) {
    let Frame { of, frame, frames } = at;
    let Workspace { nodes, twists, candidates, clearance, around, .. } = workspace;
    around.bodies = of.bodies_of(frame, frames, system.frame_s);
    let spans = around.spans(of, system);
    around.open_and_close(of, of.closed_in(frame), system, nodes);
    around.hold_rods(of, &spans, system, twists);
    around.roll_rates = around.roll_rates_in(of, frame, system);
    let own = around.system.clone();
    let system = own.as_deref().unwrap_or(system);
    let mut arrive = std::mem::take(&mut around.arrive);
    if of.measured && arrive.is_empty() {
        arrive.extend(nodes.iter().take(system.nodes).map(|n| n.v));
    }
    controls.begin(system, nodes);
    around.hold_nodes(of, system, T::ZERO, nodes);
    if of.measured {
        around.start_measuring(of, system);
        around.measure_jumps(of, system, nodes, &arrive);
    }
    candidates.find(system, nodes);
    around.find_near(of, system.frame_s, &nodes[..system.nodes]);
    clearance.find(&Surfaces::new(system, Some((of, around))), nodes);
}

/// Work done once a frame is over: its forces are means, and hands that pulled too hard release.
pub(crate) fn end_frame<T: Real>(of: &Surroundings<T>, frame_s: f64, around: &mut Around<T>) {
    if !of.measured {
        return;
    }
    around.forces.average(frame_s);
    for (g, hand) in of.hands.iter().enumerate() {
        let force = around.forces.grasps[g][0];
        let pulls_too_hard = dot(force, force).to_f64().sqrt() > hand.max_force;
        if around.hands.phases[g] == Phase::Closed && pulls_too_hard {
            around.hands.release(g, Phase::Slipped);
        }
    }
}

/// Some of a frame's substeps.
pub(crate) struct SurroundedSubsteps<'a, T> {
    pub(crate) of: &'a Surroundings<T>,
    pub(crate) plain: Substeps<'a, T>,
}

impl<T: Real> Work<T> for SurroundedSubsteps<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<M: Machine<T>>(self, m: M) {
        let Self { of, plain } = self;
        let Substeps { system, controls, workspace: w, substeps, mut tape } = plain;
        let own = w.around.system.clone();
        let system = own.as_deref().unwrap_or(system);
        if let Some(tape) = &mut tape {
            tape.clear(substeps.len());
        }
        for substep in substeps {
            controls.place(system, substep, &mut w.nodes);
            spring_forces(m, &system.springs, &w.nodes, &mut w.forces);
            bend_forces(m, &system.triplets, &w.nodes, &mut w.forces);
            if let Some(tape) = &mut tape {
                tape.twists.extend_from_slice(&w.twists);
            }
            let twists = (&mut *w.twists, &*w.around.roll_rates);
            rod_forces(m, &system.rods, system.dt, &w.nodes, twists, &mut w.forces);
            w.around.pull(of, system, substep, &w.nodes, &mut w.forces);
            if of.measured {
                w.around.measure(of, system, &w.nodes, &w.forces);
            }
            accelerate(system, &w.nodes, &mut w.forces, &mut w.before);
            controls.pin_velocities(system, &mut w.before);
            w.around.hold_velocities(of, system, &mut w.before);
            if let Some(tape) = &mut tape {
                tape.nodes.extend_from_slice(&w.nodes);
                tape.before.extend_from_slice(&w.before);
            }
            w.around.place_obstacles(of, system, substep);
            if w.candidates.is_empty() {
                travel(of, system, &w.clearance, &mut w.nodes, &w.before, &mut w.around);
            } else {
                collide(system, &w.candidates, &w.nodes, &w.before, &mut w.after);
                travel(of, system, &w.clearance, &mut w.nodes, &w.after, &mut w.around);
            }
            controls.pin_nodes(system, substep, &mut w.nodes);
            w.around.hold_nodes(of, system, progress(system, substep), &mut w.nodes);
        }
    }
}

/// Moves nodes: x <- x + v dt, or along obstacles; prescribed nodes are put in their places later.
#[inline(always)]
fn travel<T: Real>(
    of: &Surroundings<T>,
    system: &System<T>,
    clearance: &Clearance<T>,
    nodes: &mut [Node<T>],
    velocities: &[Quad<T>],
    around: &mut Around<T>,
) {
    let Around { obstacles, forces, .. } = around;
    let scene = scene(of, system, obstacles, clearance);
    for (i, (node, &v)) in nodes.iter_mut().zip(velocities).enumerate() {
        if system.inverse_mass[i] == T::ZERO {
            continue;
        }
        let x = node.x;
        *node = scene.advance(i, *node, v, |meeting| {
            if of.measured {
                let impulse = scale(meeting.change, system.masses[i]);
                match meeting.with.map(|o| &obstacles[o]) {
                    None => forces.by_ground(impulse),
                    Some(o) => forces.by_collider(o.collider, &o.body, x, impulse),
                }
            }
        });
    }
}

/// Obstacles that free nodes may meet in a substep.
#[inline(always)]
fn scene<'a, T: Real>(
    of: &'a Surroundings<T>,
    system: &System<T>,
    obstacles: &'a [Obstacle<T>],
    clearance: &'a Clearance<T>,
) -> Scene<'a, T> {
    let ground = system.ground.map(|ground| (ground, ground_law(system)));
    let layer = (of.smoothing > T::ZERO).then(|| Layer::new(of.smoothing, system.dt));
    Scene { of, ground, obstacles, clearance, dt: system.dt, layer }
}
