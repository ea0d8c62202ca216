//! Motion of control points and pinned nodes during a frame: control points move linearly from one
//! frame boundary to the next, pinned nodes follow them exactly.

use crate::cpu::{
    arithmetic::{Node, Quad, Real, add, add_scaled, scale, sub},
    system::System,
};

/// Control points at the two ends of a frame [m], shape [C] each.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameControls<'a, T> {
    pub(crate) from: &'a [Quad<T>],
    pub(crate) to: &'a [Quad<T>],
}

/// Fraction of the frame at which the controls are in a substep: that of its end.
#[inline(always)]
pub(crate) fn progress<T: Real>(system: &System<T>, substep: usize) -> T {
    T::from_f64((substep + 1) as f64 / system.substeps as f64)
}

impl<T: Real> FrameControls<'_, T> {
    /// Velocity of a control point; zero where the model ignores it.
    #[inline(always)]
    fn velocity(&self, system: &System<T>, control: usize) -> Quad<T> {
        if !system.controls_move {
            return [T::ZERO; 4];
        }
        scale(sub(self.to[control], self.from[control]), T::from_f64(1.0 / system.frame_s))
    }

    #[inline(always)]
    fn position(&self, t: T, control: usize) -> Quad<T> {
        // Exact at both ends, so that a rollout may be cut at any frame.
        add_scaled(scale(self.from[control], T::ONE - t), t, self.to[control])
    }

    /// Starts the frame: control points and pinned nodes stand at its first boundary with its
    /// velocity.
    pub(crate) fn begin(&self, system: &System<T>, nodes: &mut [Node<T>]) {
        for c in 0..system.controls {
            nodes[system.nodes + c] = Node { x: self.from[c], v: self.velocity(system, c) };
        }
        for pin in &system.pins {
            let held = nodes[system.nodes + pin.control];
            nodes[pin.node] = Node { x: add(held.x, pin.offset), v: held.v };
        }
    }

    /// Moves the control points to where a substep's forces see them.
    #[inline(always)]
    pub(crate) fn place(&self, system: &System<T>, substep: usize, nodes: &mut [Node<T>]) {
        let t = progress(system, substep);
        for (c, node) in nodes[system.nodes..].iter_mut().enumerate() {
            node.x = self.position(t, c);
        }
    }

    /// Pinned nodes meet other nodes with their control point's velocity.
    #[inline(always)]
    pub(crate) fn pin_velocities(&self, system: &System<T>, velocities: &mut [Quad<T>]) {
        for pin in &system.pins {
            velocities[pin.node] = self.velocity(system, pin.control);
        }
    }

    /// Pinned nodes end the substep where their control point is.
    #[inline(always)]
    pub(crate) fn pin_nodes(&self, system: &System<T>, substep: usize, nodes: &mut [Node<T>]) {
        let t = progress(system, substep);
        for pin in &system.pins {
            let x = add(self.position(t, pin.control), pin.offset);
            nodes[pin.node] = Node { x, v: self.velocity(system, pin.control) };
        }
    }
}

/// d loss / d what the control points do in one frame.
#[derive(Debug)]
pub(crate) struct FrameControlsAdjoint<T> {
    pub(crate) from: Vec<Quad<T>>,
    pub(crate) to: Vec<Quad<T>>,
    velocity: Vec<Quad<T>>,
}

impl<T: Real> FrameControlsAdjoint<T> {
    pub(crate) fn zero(controls: usize) -> Self {
        let zero = || vec![[T::ZERO; 4]; controls];
        Self { from: zero(), to: zero(), velocity: zero() }
    }

    pub(crate) fn clear(&mut self) {
        for part in [&mut self.from, &mut self.to, &mut self.velocity] {
            part.fill([T::ZERO; 4]);
        }
    }

    #[inline(always)]
    fn take(&mut self, control: usize, t: T, bar: &mut Node<T>) {
        self.from[control] = add_scaled(self.from[control], T::ONE - t, bar.x);
        self.to[control] = add_scaled(self.to[control], t, bar.x);
        self.velocity[control] = add(self.velocity[control], bar.v);
        *bar = Node::default();
    }

    /// Adjoint of [`FrameControls::pin_nodes`].
    #[inline(always)]
    pub(crate) fn pin_nodes(&mut self, system: &System<T>, substep: usize, bar: &mut [Node<T>]) {
        let t = progress(system, substep);
        for pin in &system.pins {
            self.take(pin.control, t, &mut bar[pin.node]);
        }
    }

    /// Adjoint of [`FrameControls::pin_velocities`].
    #[inline(always)]
    pub(crate) fn pin_velocities(&mut self, system: &System<T>, bar: &mut [Node<T>]) {
        for pin in &system.pins {
            let v = std::mem::take(&mut bar[pin.node].v);
            self.velocity[pin.control] = add(self.velocity[pin.control], v);
        }
    }

    /// Adjoint of [`FrameControls::place`], and of their velocity.
    #[inline(always)]
    pub(crate) fn place(&mut self, system: &System<T>, substep: usize, bar: &mut [Node<T>]) {
        let t = progress(system, substep);
        for (c, bar) in bar[system.nodes..].iter_mut().enumerate() {
            self.take(c, t, bar);
        }
    }

    /// Adjoint of [`FrameControls::begin`]; what remains afterwards is `from` and `to`.
    pub(crate) fn begin(&mut self, system: &System<T>, bar: &mut [Node<T>]) {
        for pin in &system.pins {
            self.take(pin.control, T::ZERO, &mut bar[pin.node]);
        }
        if system.controls_move {
            let rate = T::from_f64(1.0 / system.frame_s);
            for (c, v) in self.velocity.iter_mut().enumerate() {
                let v = std::mem::take(v);
                self.from[c] = add_scaled(self.from[c], -rate, v);
                self.to[c] = add_scaled(self.to[c], rate, v);
            }
        } else {
            self.velocity.fill([T::ZERO; 4]);
        }
    }
}
