//! A frame forward: forces, velocities, contact between nodes, ground and pins for every substep
//! (semi-implicit Euler, in the order of the model's definition).

use std::ops::Range;

use super::{
    control::FrameControls,
    surrounded::{self, Frame, SurroundedSubsteps},
};
use crate::cpu::{
    arithmetic::{LANES, Machine, Node, Quad, Real, Work, add, add_scaled, scale},
    collision::{
        clearance::{Clearance, Surfaces},
        contact::{Candidates, collide},
        ground::{advance, may_hit},
        impulse::Law,
    },
    elements::{bend_forces, rod_forces, spring_forces},
    surroundings::Around,
    system::System,
};

/// Everything that changes during a rollout; allocated once.
#[derive(Debug)]
pub(crate) struct Workspace<T> {
    /// Nodes, then control points, shape [N + C].
    pub(crate) nodes: Vec<Node<T>>,
    /// Twists of rods [rad], shape [R].
    pub(crate) twists: Vec<T>,
    /// Forces [N], shape [N + C]; zero between substeps.
    pub(crate) forces: Vec<Quad<T>>,
    /// Velocities before contact, shape [N].
    pub(crate) before: Vec<Quad<T>>,
    /// Velocities after contact between nodes, shape [N].
    pub(crate) after: Vec<Quad<T>>,
    /// Candidates for contact in the current frame.
    pub(crate) candidates: Candidates,
    /// Clearances in the current frame.
    pub(crate) clearance: Clearance<T>,
    /// Surroundings of the object in the current frame.
    pub(crate) around: Around<T>,
}

impl<T: Real> Workspace<T> {
    /// A workspace for a system; all nodes at the origin.
    pub(crate) fn new(system: &System<T>) -> Self {
        let zero = [T::ZERO; 4];
        Self {
            nodes: vec![Node::default(); system.endpoints()],
            twists: vec![T::ZERO; system.rods.rods.len()],
            forces: vec![zero; system.endpoints()],
            before: vec![zero; system.nodes],
            after: vec![zero; system.nodes],
            candidates: Candidates::default(),
            clearance: Clearance::default(),
            around: Around::default(),
        }
    }
}

/// The record that the adjoint needs of successive substeps.
#[derive(Debug, Default)]
pub(crate) struct Tape<T> {
    /// Substeps on it.
    pub(crate) substeps: usize,
    /// Endpoints as the forces saw them, shape [substeps, N + C].
    pub(crate) nodes: Vec<Node<T>>,
    /// Velocities before contact, shape [substeps, N].
    pub(crate) before: Vec<Quad<T>>,
    /// Twists where each substep starts [rad], shape [substeps, R].
    pub(crate) twists: Vec<T>,
}

impl<T> Tape<T> {
    /// Allocates space for the given number of substeps.
    pub(crate) fn clear(&mut self, substeps: usize) {
        self.nodes.clear();
        self.before.clear();
        self.twists.clear();
        self.substeps = substeps;
    }
}

/// The ground's restitution and friction.
pub(crate) fn ground_law<T: Real>(system: &System<T>) -> Law<T> {
    Law {
        restitution: system.parameters.ground_restitution,
        friction: system.parameters.ground_friction,
    }
}

/// Advances the workspace's nodes by a frame; `around` is what surrounds them, if anything does.
pub(crate) fn run_frame<T: Real>(
    system: &System<T>,
    controls: FrameControls<'_, T>,
    around: Option<Frame<'_, T>>,
    workspace: &mut Workspace<T>,
) {
    begin_frame(system, controls, around, workspace);
    run_substeps(system, controls, around, workspace, 0..system.substeps, None);
    if let Some(at) = around {
        surrounded::end_frame(at.of, system.frame_s, &mut workspace.around);
    }
}

/// Work done once per frame: pinned nodes take their new velocity, contact its candidates, and the
/// skin says how far away from the ground nodes touch it.
pub(crate) fn begin_frame<T: Real>(
    system: &System<T>,
    controls: FrameControls<'_, T>,
    around: Option<Frame<'_, T>>,
    workspace: &mut Workspace<T>,
) {
    if let Some(at) = around {
        return surrounded::begin_frame(at, system, controls, workspace);
    }
    controls.begin(system, &mut workspace.nodes);
    let Workspace { nodes, candidates, clearance, .. } = workspace;
    candidates.find(system, nodes);
    clearance.find(&Surfaces::new(system, None), nodes);
}

/// Some of a frame's substeps; fills the tape if there is one.
pub(crate) fn run_substeps<T: Real>(
    system: &System<T>,
    controls: FrameControls<'_, T>,
    around: Option<Frame<'_, T>>,
    workspace: &mut Workspace<T>,
    substeps: Range<usize>,
    tape: Option<&mut Tape<T>>,
) {
    let plain = Substeps { system, controls, workspace, substeps, tape };
    match around {
        None => T::dispatch(plain),
        Some(Frame { of, .. }) => T::dispatch(SurroundedSubsteps { of, plain }),
    }
}

/// Some of a frame's substeps, with only the ground around.
pub(crate) struct Substeps<'a, T> {
    pub(crate) system: &'a System<T>,
    pub(crate) controls: FrameControls<'a, T>,
    pub(crate) workspace: &'a mut Workspace<T>,
    pub(crate) substeps: Range<usize>,
    pub(crate) tape: Option<&'a mut Tape<T>>,
}

impl<T: Real> Work<T> for Substeps<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<M: Machine<T>>(self, m: M) {
        let Self { system, controls, workspace: w, substeps, mut tape } = self;
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
            let twists = (&mut *w.twists, &[][..]);
            rod_forces(m, &system.rods, system.dt, &w.nodes, twists, &mut w.forces);
            accelerate(system, &w.nodes, &mut w.forces, &mut w.before);
            controls.pin_velocities(system, &mut w.before);
            if let Some(tape) = &mut tape {
                tape.nodes.extend_from_slice(&w.nodes);
                tape.before.extend_from_slice(&w.before);
            }
            if w.candidates.is_empty() {
                travel(m, system, &w.clearance, &mut w.nodes, &w.before);
            } else {
                collide(system, &w.candidates, &w.nodes, &w.before, &mut w.after);
                travel(m, system, &w.clearance, &mut w.nodes, &w.after);
            }
            controls.pin_nodes(system, substep, &mut w.nodes);
        }
    }
}

/// v <- (v + (f/m + g) dt) exp(-dt drag); forces start again from zero.
#[inline(always)]
pub(crate) fn accelerate<T: Real>(
    system: &System<T>,
    nodes: &[Node<T>],
    forces: &mut [Quad<T>],
    velocities: &mut [Quad<T>],
) {
    // Copies: what is written might otherwise change them, and nothing would be vectorised.
    let (dt, decay) = (system.dt, system.decay);
    let kick = scale(system.gravity, dt);
    let per_node = nodes.iter().zip(&mut *forces).zip(&system.inverse_mass).zip(velocities);
    for (((node, f), &inverse_mass), v) in per_node {
        let change = add(scale(*f, inverse_mass * dt), kick);
        *v = scale(add(node.v, change), decay);
        *f = [T::ZERO; 4];
    }
    forces[system.nodes..].fill([T::ZERO; 4]);
}

/// x <- x + v dt, or the way over the ground.
#[inline(always)]
fn travel<T: Real, M: Machine<T>>(
    m: M,
    system: &System<T>,
    clearance: &Clearance<T>,
    nodes: &mut [Node<T>],
    velocities: &[Quad<T>],
) {
    let (dt, ground, law) = (system.dt, system.ground, ground_law(system));
    if let (Some(ground), false) = (&ground, clearance.is_zero()) {
        for (i, (node, &v)) in nodes.iter_mut().zip(velocities).enumerate() {
            *node = advance(&ground.raised(clearance.of(None, i)), law, dt, *node, v);
        }
        return;
    }
    for (nodes, v) in nodes.chunks_mut(LANES).zip(velocities.chunks(LANES)) {
        match &ground {
            Some(ground) if may_hit(m, ground, dt, nodes, v) => {
                for (node, &v) in nodes.iter_mut().zip(v) {
                    *node = advance(ground, law, dt, *node, v);
                }
            }
            _ => {
                for (node, &v) in nodes.iter_mut().zip(v) {
                    *node = Node { x: add_scaled(node.x, dt, v), v };
                }
            }
        }
    }
}
