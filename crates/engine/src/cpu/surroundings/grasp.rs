//! Grasps of bodies: what they take when they close, and how they hold it.
//!
//! At the beginning of a frame all hands commanded to open release first; then those commanded to
//! close take, one after another, the nodes of their region that are neither pinned by a control
//! point nor held. One gripper can therefore hand over to another at the same boundary. A place is
//! `Aᵀ (x - p)` at that boundary's pose. A node that a hand holds by a pin stands at its place with
//! the place's velocity and has no inverse mass, like a pinned node; a spring acts in every
//! substep, like control springs. Places have no velocity where the model ignores that of control
//! points.

use std::sync::Arc;

use super::{
    Around, Surroundings,
    body::{BodyFrame, BodyFrameAdjoint, apply, into_body, into_body_adjoint, turn_back},
};
use crate::{
    cpu::{
        arithmetic::{Node, Quad, Real, add, add_scaled, dot, quad, scale, sub},
        frame::control::progress,
        system::System,
    },
    world::{self, Attachment, Grasping, Phase, Region},
};

/// A grasp in the simulation's scalar.
#[derive(Clone, Debug)]
pub(crate) struct Hand<T> {
    pub(crate) body: usize,
    pub(crate) region: Region,
    /// Stiffness and damping; `None` pins.
    pub(crate) spring: Option<[T; 2]>,
    pub(crate) max_force: f64,
}

impl<T: Real> Hand<T> {
    pub(crate) fn new(grasp: &world::Grasp) -> Self {
        let spring = match grasp.attachment {
            Attachment::Pin => None,
            Attachment::Spring { stiffness, damping } => {
                Some([T::from_f32(stiffness), T::from_f32(damping)])
            }
        };
        Self {
            body: grasp.body as usize,
            region: grasp.region.clone(),
            spring,
            max_force: f64::from(grasp.max_force),
        }
    }

    /// The control points whose springs and pins are the hold.
    pub(crate) fn controls(&self) -> &[u32] {
        match &self.region {
            Region::Controls(controls) => controls,
            _ => &[],
        }
    }

    /// True if a node at `q` in the body's coordinates is in the region.
    fn takes(&self, node: usize, q: Quad<T>) -> bool {
        match &self.region {
            Region::Sphere { center, radius_m } => {
                let (r, radius) = (sub(q, quad(*center)), T::from_f32(*radius_m));
                dot(r, r) <= radius * radius
            }
            Region::Box { low, high } => {
                let (low, high) = (quad::<T>(*low), quad::<T>(*high));
                (0..3).all(|c| low[c] <= q[c] && q[c] <= high[c])
            }
            Region::Nodes(nodes) => nodes.iter().any(|&i| i as usize == node),
            Region::Controls(_) => false,
        }
    }
}

/// A node in a hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hold<T> {
    pub(crate) node: usize,
    pub(crate) grasp: usize,
    /// In the body's coordinates [m].
    pub(crate) place: Quad<T>,
}

/// Holds of all hands between two frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Hands<T> {
    /// Shape [G].
    pub(crate) phases: Vec<Phase>,
    /// Hold of each node.
    pub(crate) holds: Vec<Hold<T>>,
}

impl<T: Real> Hands<T> {
    /// A client's, with the phases that an empty list stands for.
    pub(crate) fn new(grasping: &Grasping, grasps: &[world::Grasp]) -> Self {
        let default = |g: &world::Grasp| match g.region {
            Region::Controls(_) => Phase::Closed,
            _ => Phase::Open,
        };
        let phases = if grasping.phases.is_empty() {
            grasps.iter().map(default).collect()
        } else {
            grasping.phases.clone()
        };
        let hold = |h: &world::Hold| Hold {
            node: h.node as usize,
            grasp: h.grasp as usize,
            place: quad(h.place),
        };
        Self { phases, holds: grasping.holds.iter().map(hold).collect() }
    }

    /// Releases everything in a hand.
    pub(crate) fn release(&mut self, grasp: usize, phase: Phase) {
        self.phases[grasp] = phase;
        self.holds.retain(|h| h.grasp != grasp);
    }

    /// True for the control points whose hands are open.
    pub(crate) fn open_controls(&self, hands: &[Hand<T>], controls: usize) -> Vec<bool> {
        let mut open = vec![false; controls];
        for (hand, phase) in hands.iter().zip(&self.phases) {
            if *phase != Phase::Closed {
                hand.controls().iter().for_each(|&c| open[c as usize] = true);
            }
        }
        open
    }
}

impl<T: Real> Around<T> {
    /// Opens and closes hands at the beginning of a frame; `closed` has shape [G], or is empty after
    /// the last frame. `system` is the model's own.
    pub(crate) fn open_and_close(
        &mut self,
        of: &Surroundings<T>,
        closed: &[bool],
        system: &System<T>,
        nodes: &[Node<T>],
    ) {
        self.taken.clear();
        for (g, &closed) in closed.iter().enumerate() {
            if !closed && self.hands.phases[g] != Phase::Open {
                self.hands.release(g, Phase::Open);
            }
        }
        let opens = self.hands.open_controls(&of.hands, system.controls);
        let mut busy = vec![false; system.nodes];
        system.pins.iter().filter(|p| !opens[p.control]).for_each(|p| busy[p.node] = true);
        self.hands.holds.iter().for_each(|h| busy[h.node] = true);
        for (g, (&closed, hand)) in closed.iter().zip(&of.hands).enumerate() {
            let is_free = self.hands.phases[g] == Phase::Open;
            if !closed || !is_free || matches!(hand.region, Region::Controls(_)) {
                continue;
            }
            self.hands.phases[g] = Phase::Closed;
            let pose = self.bodies[hand.body].from;
            for (node, now) in nodes.iter().enumerate().take(system.nodes) {
                let place = into_body(&pose, now.x);
                if !busy[node] && hand.takes(node, place) {
                    busy[node] = true;
                    self.taken.push((node, now.x));
                    self.hands.holds.push(Hold { node, grasp: g, place });
                }
            }
        }
        self.hands.holds.sort_unstable_by_key(|h| h.node);
        self.find_system(of, opens, system);
    }

    /// The system without open grasps, and with the pinned nodes.
    fn find_system(&mut self, of: &Surroundings<T>, opens: Vec<bool>, system: &System<T>) {
        let is_pinned = |h: &&Hold<T>| of.hands[h.grasp].spring.is_none();
        let pinned: Vec<usize> =
            self.hands.holds.iter().filter(is_pinned).map(|h| h.node).collect();
        if pinned.is_empty() && !opens.contains(&true) {
            self.system = None;
            self.system_of = Default::default();
        } else {
            let held = (opens, pinned, self.spans(of, system));
            if self.system_of != held {
                let (opens, pinned, spans) = &held;
                self.system = Some(Arc::new(system.while_held(opens, pinned, spans)));
                self.system_of = held;
            }
        }
    }

    /// Holds by pins, with their bodies.
    #[inline(always)]
    pub(crate) fn pins<'a>(
        &'a self,
        of: &'a Surroundings<T>,
    ) -> impl Iterator<Item = (&'a Hold<T>, usize, &'a BodyFrame<T>)> + 'a {
        self.hands.holds.iter().filter_map(|h| {
            let hand = &of.hands[h.grasp];
            hand.spring.is_none().then(|| (h, hand.body, &self.bodies[hand.body]))
        })
    }

    /// Nodes held by pins stand at a fraction of the frame where their places are.
    #[inline(always)]
    pub(crate) fn hold_nodes(
        &self,
        of: &Surroundings<T>,
        system: &System<T>,
        t: T,
        nodes: &mut [Node<T>],
    ) {
        for (hold, _, body) in self.pins(of) {
            let v = place_velocity(system, body, hold.place);
            nodes[hold.node] = Node { x: apply(&body.at(t), hold.place), v };
        }
    }

    /// Nodes held by pins meet others with their places' velocity.
    #[inline(always)]
    pub(crate) fn hold_velocities(
        &self,
        of: &Surroundings<T>,
        system: &System<T>,
        velocities: &mut [Quad<T>],
    ) {
        for (hold, _, body) in self.pins(of) {
            velocities[hold.node] = place_velocity(system, body, hold.place);
        }
    }

    /// Adds the forces of holds by springs.
    #[inline(always)]
    pub(crate) fn pull(
        &mut self,
        of: &Surroundings<T>,
        system: &System<T>,
        substep: usize,
        nodes: &[Node<T>],
        forces: &mut [Quad<T>],
    ) {
        let t = progress(system, substep);
        for hold in &self.hands.holds {
            let hand = &of.hands[hold.grasp];
            let (Some([stiffness, damping]), body) = (hand.spring, &self.bodies[hand.body]) else {
                continue;
            };
            let node = nodes[hold.node];
            let r = sub(node.x, apply(&body.at(t), hold.place));
            let w = sub(node.v, place_velocity(system, body, hold.place));
            let force = add_scaled(scale(r, -stiffness), -damping, w);
            forces[hold.node] = add(forces[hold.node], force);
            if of.measured {
                self.forces.by_grasp(hold.grasp, body, node.x, scale(force, system.dt));
            }
        }
    }
}

/// Velocity of a place on a body; zero where the model ignores that of control points.
#[inline(always)]
pub(crate) fn place_velocity<T: Real>(
    system: &System<T>,
    body: &BodyFrame<T>,
    place: Quad<T>,
) -> Quad<T> {
    if system.controls_move { body.velocity(place) } else { [T::ZERO; 4] }
}

/// d loss / d what surrounds the object, in one frame; places over all frames gone through.
#[derive(Debug, Default)]
pub(crate) struct AroundAdjoint<T> {
    /// Shape [B].
    pub(crate) bodies: Vec<BodyFrameAdjoint<T>>,
    /// Adjoint of the rates that clamps impose, shape [R].
    pub(crate) roll_rates: Vec<T>,
    /// Adjoint of the angles by which control points turn the two clamps of a rod in the frame,
    /// shape [R, 2].
    pub(crate) rolls: Vec<T>,
    /// Adjoint of the place of a held node, shape [N], zero for others.
    pub(crate) places: Vec<Quad<T>>,
}

impl<T: Real> AroundAdjoint<T> {
    pub(crate) fn new(bodies: usize, rods: usize, nodes: usize) -> Self {
        Self {
            bodies: vec![BodyFrameAdjoint::default(); bodies],
            roll_rates: vec![T::ZERO; rods],
            rolls: vec![T::ZERO; 2 * rods],
            places: vec![[T::ZERO; 4]; nodes],
        }
    }

    /// Forgets the frame.
    pub(crate) fn clear(&mut self) {
        self.bodies.fill(BodyFrameAdjoint::default());
        self.roll_rates.fill(T::ZERO);
        self.rolls.fill(T::ZERO);
    }

    #[inline(always)]
    fn take_velocity(
        &mut self,
        system: &System<T>,
        (body, b): (&BodyFrame<T>, usize),
        hold: &Hold<T>,
        v_bar: Quad<T>,
    ) {
        if !system.controls_move {
            return;
        }
        self.bodies[b].velocity(body, hold.place, v_bar);
        let v_bar = scale(v_bar, body.rate);
        let place = sub(turn_back(&body.to, v_bar), turn_back(&body.from, v_bar));
        self.places[hold.node] = add(self.places[hold.node], place);
    }

    #[inline(always)]
    fn take_point(
        &mut self,
        (body, b): (&BodyFrame<T>, usize),
        t: T,
        hold: &Hold<T>,
        x_bar: Quad<T>,
    ) {
        self.bodies[b].point(t, hold.place, x_bar);
        let place = turn_back(&body.at(t), x_bar);
        self.places[hold.node] = add(self.places[hold.node], place);
    }

    /// Adjoint of [`Around::hold_nodes`].
    #[inline(always)]
    pub(crate) fn hold_nodes(
        &mut self,
        (of, around): (&Surroundings<T>, &Around<T>),
        system: &System<T>,
        t: T,
        bar: &mut [Node<T>],
    ) {
        for (hold, b, body) in around.pins(of) {
            let Node { x, v } = std::mem::take(&mut bar[hold.node]);
            self.take_point((body, b), t, hold, x);
            self.take_velocity(system, (body, b), hold, v);
        }
    }

    /// Adjoint of [`Around::hold_velocities`].
    #[inline(always)]
    pub(crate) fn hold_velocities(
        &mut self,
        (of, around): (&Surroundings<T>, &Around<T>),
        system: &System<T>,
        bar: &mut [Node<T>],
    ) {
        for (hold, b, body) in around.pins(of) {
            let v = std::mem::take(&mut bar[hold.node].v);
            self.take_velocity(system, (body, b), hold, v);
        }
    }

    /// Adjoint of [`Around::pull`]; `seeds` are d loss / d impulse by each grasp times a substep,
    /// that is by its force, shape [G], or empty.
    #[inline(always)]
    pub(crate) fn pull(
        &mut self,
        (of, around): (&Surroundings<T>, &Around<T>),
        system: &System<T>,
        substep: usize,
        (lambda, seeds): (&[Quad<T>], &[Quad<T>]),
        bar: &mut [Node<T>],
    ) {
        let t = progress(system, substep);
        for hold in &around.hands.holds {
            let hand = &of.hands[hold.grasp];
            let Some([stiffness, damping]) = hand.spring else { continue };
            let body = (&around.bodies[hand.body], hand.body);
            let mut force = lambda[hold.node];
            if let Some(&seed) = seeds.get(hold.grasp) {
                force = add(force, seed);
            }
            let (x, v) = (scale(force, stiffness), scale(force, damping));
            let node = &mut bar[hold.node];
            *node = Node { x: sub(node.x, x), v: sub(node.v, v) };
            self.take_point(body, t, hold, x);
            self.take_velocity(system, body, hold, v);
        }
    }

    /// Adjoint of taking nodes at the beginning of the frame.
    pub(crate) fn taken(&mut self, of: &Surroundings<T>, around: &Around<T>, bar: &mut [Node<T>]) {
        for &(node, x) in &around.taken {
            let Ok(h) = around.hands.holds.binary_search_by_key(&node, |h| h.node) else {
                continue;
            };
            let b = of.hands[around.hands.holds[h].grasp].body;
            let place_bar = std::mem::take(&mut self.places[node]);
            let from = &around.bodies[b].from;
            let x_bar = into_body_adjoint(from, x, place_bar, &mut self.bodies[b].from);
            bar[node].x = add(bar[node].x, x_bar);
        }
    }
}
