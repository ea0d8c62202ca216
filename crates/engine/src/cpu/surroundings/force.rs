//! Forces on the object by what surrounds it, as impulses that are added up over a frame.
//!
//! A control point exerts minus the force that springs and triplets exert on it. A node
//! follows a control point or a body by the impulse, in every substep,
//! `m (v_held - (v + (f/m + g) dt) exp(-dt drag))`, with f the force of springs, triplets and rods on
//! the node, and at a frame's beginning `m (v_new - v)`. Ground and colliders exert
//! `m (v_after - v_before)` by each meeting. Impulses between nodes that touch are within the object.
//! The arm of a torque ends where the node or the control point is when the impulse acts: a
//! substep's forces see control points at its end and nodes at its start.

use super::{
    Around, Surroundings,
    body::{BodyFrame, origin},
    grasp::place_velocity,
};
use crate::cpu::{
    arithmetic::{Node, Quad, Real, add, add_scaled, scale, sub},
    system::System,
};

/// Impulse [N s] and its moment [N m s]; once the frame is over, force and torque.
pub(crate) type Wrench<T> = [Quad<T>; 2];

/// Impulses so far in a frame; once it is over, mean forces.
#[derive(Clone, Debug, Default)]
pub(crate) struct FrameForces<T> {
    /// Shape [C].
    pub(crate) controls: Vec<Quad<T>>,
    /// Shape [G].
    pub(crate) grasps: Vec<Wrench<T>>,
    pub(crate) ground: Quad<T>,
    /// Shape [K].
    pub(crate) colliders: Vec<Wrench<T>>,
}

impl<T: Real> FrameForces<T> {
    /// All zero.
    pub(crate) fn zero(controls: usize, grasps: usize, colliders: usize) -> Self {
        let zero = [T::ZERO; 4];
        Self {
            controls: vec![zero; controls],
            grasps: vec![[zero; 2]; grasps],
            ground: zero,
            colliders: vec![[zero; 2]; colliders],
        }
    }

    /// Adds an impulse by a grasp at a point, its moment about the body's origin at the frame's end.
    #[inline(always)]
    pub(crate) fn by_grasp(&mut self, grasp: usize, body: &BodyFrame<T>, at: Quad<T>, by: Quad<T>) {
        add_wrench(&mut self.grasps[grasp], sub(at, origin(&body.to)), by);
    }

    /// Adds a force from a collider, like [`Self::by_grasp`].
    #[inline(always)]
    pub(crate) fn by_collider(&mut self, k: usize, body: &BodyFrame<T>, at: Quad<T>, by: Quad<T>) {
        add_wrench(&mut self.colliders[k], sub(at, origin(&body.to)), by);
    }

    /// Adds an impulse by the ground.
    #[inline(always)]
    pub(crate) fn by_ground(&mut self, by: Quad<T>) {
        self.ground = add(self.ground, by);
    }

    /// Impulses to mean forces.
    pub(crate) fn average(&mut self, frame_s: f64) {
        let rate = T::from_f64(1.0 / frame_s);
        self.ground = scale(self.ground, rate);
        self.controls.iter_mut().for_each(|f| *f = scale(*f, rate));
        for wrench in self.grasps.iter_mut().chain(&mut self.colliders) {
            *wrench = wrench.map(|f| scale(f, rate));
        }
    }
}

#[inline(always)]
fn add_wrench<T: Real>(wrench: &mut Wrench<T>, arm: Quad<T>, by: Quad<T>) {
    let moment = [
        arm[1] * by[2] - arm[2] * by[1],
        arm[2] * by[0] - arm[0] * by[2],
        arm[0] * by[1] - arm[1] * by[0],
        T::ZERO,
    ];
    *wrench = [add(wrench[0], by), add(wrench[1], moment)];
}

/// d loss / d mean forces of a frame. Torques are in no loss.
#[derive(Clone, Debug)]
pub(crate) struct ForceSeeds<T> {
    /// Seeds of control points, shape [C], including those through their grasps.
    pub(crate) controls: Vec<Quad<T>>,
    /// Shape [G].
    pub(crate) grasps: Vec<Quad<T>>,
    pub(crate) ground: Quad<T>,
    /// Shape [K].
    pub(crate) colliders: Vec<Quad<T>>,
}

impl<T: Real> ForceSeeds<T> {
    /// Zero.
    pub(crate) fn zero(of: &Surroundings<T>, system: &System<T>) -> Self {
        let zero = |n: usize| vec![[T::ZERO; 4]; n];
        Self {
            controls: zero(system.controls),
            grasps: zero(of.hands.len()),
            ground: [T::ZERO; 4],
            colliders: zero(of.colliders.len()),
        }
    }

    /// Hands what belongs to grasps of control points on to these; false if all is zero.
    pub(crate) fn spread(&mut self, of: &Surroundings<T>) -> bool {
        for (hand, &seed) in of.hands.iter().zip(&self.grasps) {
            for &c in hand.controls() {
                self.controls[c as usize] = add(self.controls[c as usize], seed);
            }
        }
        let all = self.controls.iter().chain(&self.grasps).chain(&self.colliders);
        all.chain([&self.ground]).any(|seed| *seed != [T::ZERO; 4])
    }

    /// Seeds of all prescribed nodes.
    pub(crate) fn held(
        &self,
        of: &Surroundings<T>,
        system: &System<T>,
        around: &Around<T>,
    ) -> Vec<(usize, Quad<T>)> {
        let pins = system.pins.iter().map(|p| (p.node, self.controls[p.control]));
        let holds = around.pins(of).map(|(hold, _, _)| (hold.node, self.grasps[hold.grasp]));
        pins.chain(holds).collect()
    }
}

impl<T: Real> Around<T> {
    /// Resets the sums of a frame.
    pub(crate) fn start_measuring(&mut self, of: &Surroundings<T>, system: &System<T>) {
        let (hands, colliders) = (of.hands.len(), of.colliders.len());
        self.forces = FrameForces::zero(system.controls, hands, colliders);
    }

    fn by_control(&mut self, of: &Surroundings<T>, control: usize, at: Quad<T>, by: Quad<T>) {
        self.forces.controls[control] = add(self.forces.controls[control], by);
        if let Some(grasp) = of.hand_of(control) {
            let body = self.bodies[of.hands[grasp].body];
            self.forces.by_grasp(grasp, &body, at, by);
        }
    }

    /// Measures what makes nodes jump to the velocity with which they are held at a frame's
    /// beginning, from those with which they `arrive`, shape [N].
    pub(crate) fn measure_jumps(
        &mut self,
        of: &Surroundings<T>,
        system: &System<T>,
        nodes: &[Node<T>],
        arrive: &[Quad<T>],
    ) {
        let jump = |node: usize| scale(sub(nodes[node].v, arrive[node]), system.masses[node]);
        for pin in &system.pins {
            self.by_control(of, pin.control, nodes[pin.node].x, jump(pin.node));
        }
        let Self { hands, bodies, forces, .. } = self;
        for hold in &hands.holds {
            let hand = &of.hands[hold.grasp];
            if hand.spring.is_none() {
                let at = nodes[hold.node].x;
                forces.by_grasp(hold.grasp, &bodies[hand.body], at, jump(hold.node));
            }
        }
    }

    /// Measures control points' and pins' impulses of a substep from the forces on all endpoints.
    pub(crate) fn measure(
        &mut self,
        of: &Surroundings<T>,
        system: &System<T>,
        nodes: &[Node<T>],
        forces: &[Quad<T>],
    ) {
        for control in 0..system.controls {
            let endpoint = system.nodes + control;
            let impulse = scale(forces[endpoint], -system.dt);
            self.by_control(of, control, nodes[endpoint].x, impulse);
        }
        let need = |node: usize, held: Quad<T>| {
            let free =
                scale(free_momentum(system, node, nodes[node].v, forces[node]), system.decay);
            sub(scale(held, system.masses[node]), free)
        };
        for pin in &system.pins {
            let held = nodes[system.nodes + pin.control].v;
            self.by_control(of, pin.control, nodes[pin.node].x, need(pin.node, held));
        }
        let Self { hands, bodies, forces: sums, .. } = self;
        for hold in &hands.holds {
            let hand = &of.hands[hold.grasp];
            if hand.spring.is_none() {
                let body = &bodies[hand.body];
                let held = place_velocity(system, body, hold.place);
                sums.by_grasp(hold.grasp, body, nodes[hold.node].x, need(hold.node, held));
            }
        }
    }
}

/// m v + (f + m g) dt.
#[inline(always)]
pub(crate) fn free_momentum<T: Real>(
    system: &System<T>,
    node: usize,
    v: Quad<T>,
    force: Quad<T>,
) -> Quad<T> {
    let m = system.masses[node];
    add_scaled(scale(add_scaled(v, system.dt, system.gravity), m), system.dt, force)
}
