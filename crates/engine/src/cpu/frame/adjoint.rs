//! Adjoint of a frame: [`super::integrate`] backward, substep by substep from the tape, in exactly
//! the reverse order.

use super::{
    control::{FrameControls, FrameControlsAdjoint},
    integrate::{Tape, Workspace, begin_frame, ground_law, run_substeps},
    surrounded::{BackSurrounded, Frame, begin_adjoint},
};
use crate::cpu::{
    arithmetic::{LANES, Machine, Node, Quad, Real, Work, add, add_scaled, product, scale},
    collision::{
        clearance::{Clearance, ClearanceAdjoint, Surfaces},
        contact::{collide, collide_adjoint},
        ground::{advance_adjoint, may_hit},
        impulse::Law,
    },
    elements::{
        RodGradient, SpringGradient, TripletGradient, bend_adjoint, rod_adjoint, spring_adjoint,
    },
    parameters::Parameters,
    surroundings::{force::ForceSeeds, grasp::AroundAdjoint},
    system::System,
};

/// Up to this size a frame's tape is kept whole. Tests use a small one, so that they meet segments.
const WHOLE_TAPE_BYTES: usize = if cfg!(test) { 20_000 } else { 64 << 20 };
/// Otherwise its segments should stay in a core's share of the cache: writing a larger tape to
/// memory and reading it back costs more than running the frame once more.
const SEGMENT_BYTES: usize = if cfg!(test) { 5_000 } else { 12 << 20 };

/// d loss / d everything, as far back as the frames gone through.
#[derive(Debug)]
pub(crate) struct Adjoint<T> {
    /// Adjoint of the state, shape [N + C]; control points' are zero between substeps.
    pub(crate) bar: Vec<Node<T>>,
    /// Share of contact in d loss / d velocities at a substep's start, shape [N]; zero between
    /// substeps.
    pub(crate) start_bar: Vec<Quad<T>>,
    /// Adjoint of the twists, shape [R].
    pub(crate) twist_bar: Vec<T>,
    /// Adjoint of the frame's controls.
    pub(crate) controls: FrameControlsAdjoint<T>,
    /// Adjoint of the frame's clearances.
    pub(crate) clearance: ClearanceAdjoint<T>,
    /// Adjoint of the frame's surroundings.
    pub(crate) around: AroundAdjoint<T>,
    /// Adjoint of the forces, shape [N + C]; zero for control points.
    pub(crate) lambda: Vec<Quad<T>>,
    pub(crate) springs: Vec<SpringGradient<T>>,
    pub(crate) triplets: Vec<TripletGradient<T>>,
    pub(crate) rods: Vec<RodGradient<T>>,
    pub(crate) drag: T,
    pub(crate) ground: Law<T>,
    pub(crate) object: Law<T>,
    pub(crate) tape: Tape<T>,
}

impl<T: Real> Adjoint<T> {
    /// Zero, for the given number of bodies.
    pub(crate) fn zero(system: &System<T>, bodies: usize) -> Self {
        let law = Law { restitution: T::ZERO, friction: T::ZERO };
        Self {
            bar: vec![Node::default(); system.endpoints()],
            start_bar: vec![[T::ZERO; 4]; system.nodes],
            twist_bar: vec![T::ZERO; system.rods.rods.len()],
            controls: FrameControlsAdjoint::zero(system.controls),
            clearance: ClearanceAdjoint::default(),
            around: AroundAdjoint::new(bodies, system.rods.rods.len(), system.nodes),
            lambda: vec![[T::ZERO; 4]; system.endpoints()],
            springs: vec![SpringGradient::ZERO; system.springs.blocks.len()],
            triplets: vec![TripletGradient::ZERO; system.triplets.blocks.len()],
            rods: vec![RodGradient::ZERO; system.rods.rods.len()],
            drag: T::ZERO,
            ground: law,
            object: law,
            tape: Tape::default(),
        }
    }

    /// Runs a frame again from the workspace's state, and then backward: turns the adjoint of the
    /// state at its end into that at its start. `around` is the surroundings of the object, if any,
    /// and d loss / d the frame's forces, if requested. Returns the adjoint by the velocities with
    /// which held nodes arrive, by node.
    pub(crate) fn back_frame(
        &mut self,
        system: &System<T>,
        controls: FrameControls<'_, T>,
        around: Option<(Frame<'_, T>, Option<&ForceSeeds<T>>)>,
        workspace: &mut Workspace<T>,
    ) -> Vec<(usize, Quad<T>)> {
        let frame = around.map(|(frame, _)| frame);
        begin_frame(system, controls, frame, workspace);
        self.controls.clear();
        self.around.clear();
        self.clearance.clear(&workspace.clearance);
        let segment = segment_length(system);
        let starts: Vec<usize> = (0..system.substeps).step_by(segment).collect();
        let part = |start: usize| start..(start + segment).min(system.substeps);
        let mut marks: Vec<(Vec<Node<T>>, Vec<T>)> = Vec::new();
        for &start in starts.iter().take(starts.len().saturating_sub(1)) {
            marks.push((workspace.nodes.clone(), workspace.twists.clone()));
            run_substeps(system, controls, frame, workspace, part(start), None);
        }
        for &start in starts.iter().rev() {
            let tape = Some(&mut self.tape);
            run_substeps(system, controls, frame, workspace, part(start), tape);
            let plain = BackSubsteps { system, workspace, start, adjoint: self };
            match around {
                None => T::dispatch(plain),
                Some((Frame { of, .. }, seeds)) => {
                    T::dispatch(BackSurrounded { of, seeds, plain });
                }
            }
            if let Some((nodes, twists)) = marks.pop() {
                workspace.nodes.copy_from_slice(&nodes);
                workspace.twists.copy_from_slice(&twists);
            }
        }
        // The tape ends up with the frame's first substep in front, where nodes are as it began.
        let nodes = &self.tape.nodes[..system.nodes];
        let surfaces = Surfaces::new(system, frame.map(|frame| (frame.of, &workspace.around)));
        let (bar, around_bar) = (&mut self.bar, &mut self.around);
        self.clearance.find(&workspace.clearance, &surfaces, nodes, bar, around_bar);
        match around {
            None => {
                self.controls.begin(system, &mut self.bar);
                Vec::new()
            }
            Some((at, seeds)) => begin_adjoint(at, system, &workspace.around, seeds, self),
        }
    }

    /// The gradient by parameter, elements in the graph's order.
    pub(crate) fn parameters(&self, system: &System<T>) -> Parameters<T> {
        let p = &system.parameters;
        let (springs, triplets) = (p.spring_stiffness.len(), p.bend_stiffness.len());
        let mut out = Parameters::zero(springs, triplets, self.rods.len());
        for (b, g) in self.springs.iter().enumerate() {
            for l in 0..LANES {
                let Some(s) = system.spring_at(b, l) else { continue };
                [out.spring_stiffness[s], out.spring_dashpot[s], out.rest_lengths_m[s]] =
                    g.of(&system.springs.blocks[b], l);
            }
        }
        for (b, g) in self.triplets.iter().enumerate() {
            for l in 0..LANES {
                let Some(t) = system.triplet_at(b, l) else { continue };
                out.bend_stiffness[t] = g.stiffness[l];
                out.bend_damping[t] = g.damping[l];
                out.rest_angles_rad[t] = g.rest[l];
            }
        }
        for (r, g) in self.rods.iter().enumerate() {
            out.twist_stiffness[r] = g.stiffness;
            out.twist_damping[r] = g.damping;
            out.rest_twists_rad[r] = g.rest_twist;
        }
        out.drag = self.drag;
        out.ground_restitution = self.ground.restitution;
        out.ground_friction = self.ground.friction;
        out.object_restitution = self.object.restitution;
        out.object_friction = self.object.friction;
        out
    }
}

/// Substeps on tape together: a whole frame, unless that takes too much memory. Then a frame is run
/// once more to mark where its segments start; segments are no shorter than the square root of the
/// number of substeps, which keeps marks and tape together small.
fn segment_length<T: Real>(system: &System<T>) -> usize {
    let substep = system.endpoints() * size_of::<Node<T>>() + system.nodes * size_of::<Quad<T>>();
    let substep = substep.max(1);
    if WHOLE_TAPE_BYTES / substep >= system.substeps {
        return system.substeps.max(1);
    }
    let shortest = system.substeps.isqrt();
    (SEGMENT_BYTES / substep).max(shortest).clamp(1, system.substeps)
}

pub(crate) struct BackSubsteps<'a, T> {
    pub(crate) system: &'a System<T>,
    pub(crate) workspace: &'a mut Workspace<T>,
    /// First substep on tape.
    pub(crate) start: usize,
    pub(crate) adjoint: &'a mut Adjoint<T>,
}

impl<T: Real> Work<T> for BackSubsteps<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<M: Machine<T>>(self, m: M) {
        let Self { system, workspace: w, start, adjoint: a } = self;
        let (e, n, r) = (system.endpoints(), system.nodes, system.rods.rods.len());
        let substeps = a.tape.substeps;
        for on_tape in (0..substeps).rev() {
            let substep = start + on_tape;
            let nodes = &a.tape.nodes[on_tape * e..(on_tape + 1) * e];
            let before = &a.tape.before[on_tape * n..(on_tape + 1) * n];
            let twists = &a.tape.twists[on_tape * r..(on_tape + 1) * r];
            a.controls.pin_nodes(system, substep, &mut a.bar);
            if w.candidates.is_empty() {
                let bars = (&mut *a.bar, &mut *a.start_bar);
                let clearance = (&w.clearance, &mut a.clearance);
                travel_adjoint(m, system, clearance, nodes, before, bars, &mut a.ground);
            } else {
                collide(system, &w.candidates, nodes, before, &mut w.after);
                let bars = (&mut *a.bar, &mut *a.start_bar);
                let clearance = (&w.clearance, &mut a.clearance);
                travel_adjoint(m, system, clearance, nodes, &w.after, bars, &mut a.ground);
                let bars = (&mut *a.bar, &mut *a.start_bar);
                let (scratch, law_bar) = (&mut w.after, &mut a.object);
                collide_adjoint(system, &w.candidates, nodes, before, bars, scratch, law_bar);
            }
            a.controls.pin_velocities(system, &mut a.bar);
            let bars = (&mut *a.bar, &mut *a.start_bar);
            a.drag += accelerate_adjoint(system, before, bars, &mut a.lambda);
            spring_adjoint(m, &system.springs, nodes, &a.lambda, &mut a.bar, &mut a.springs);
            bend_adjoint(m, &system.triplets, nodes, &a.lambda, &mut a.bar, &mut a.triplets);
            let (bar, twist_bar) = (&mut a.bar, (&mut *a.twist_bar, &mut [][..]));
            let twists = (twists, &[][..]);
            let (rods, gradients) = (&system.rods, &mut a.rods);
            rod_adjoint(m, rods, system.dt, nodes, twists, &a.lambda, bar, twist_bar, gradients);
            a.controls.place(system, substep, &mut a.bar);
        }
    }
}

/// Adjoint of `travel`, from the end of the substep to velocities after contact between nodes.
#[inline(always)]
fn travel_adjoint<T: Real, M: Machine<T>>(
    m: M,
    system: &System<T>,
    (clearance, clearance_bar): (&Clearance<T>, &mut ClearanceAdjoint<T>),
    nodes: &[Node<T>],
    velocities: &[Quad<T>],
    (bar, start_bar): (&mut [Node<T>], &mut [Quad<T>]),
    law_bar: &mut Law<T>,
) {
    let (dt, ground, law) = (system.dt, system.ground, ground_law(system));
    if let (Some(ground), false) = (&ground, clearance.is_zero()) {
        for (i, (&node, &v)) in nodes.iter().zip(velocities).enumerate() {
            let raised = ground.raised(clearance.of(None, i));
            let height_bar;
            (bar[i], start_bar[i], height_bar) =
                advance_adjoint(&raised, law, dt, (node, v), bar[i], law_bar);
            clearance_bar.add(None, i, -height_bar);
        }
        return;
    }
    let bars = bar.chunks_mut(LANES).zip(start_bar.chunks_mut(LANES));
    let chunks = nodes.chunks(LANES).zip(velocities.chunks(LANES)).zip(bars);
    for ((nodes, v), (bar, start_bar)) in chunks {
        match &ground {
            Some(ground) if may_hit(m, ground, dt, nodes, v) => {
                let bars = bar.iter_mut().zip(start_bar);
                for ((&node, &v), (bar, start_bar)) in nodes.iter().zip(v).zip(bars) {
                    (*bar, *start_bar, _) =
                        advance_adjoint(ground, law, dt, (node, v), *bar, law_bar);
                }
            }
            _ => {
                for (bar, _) in bar.iter_mut().zip(v) {
                    bar.v = add_scaled(bar.v, dt, bar.x);
                }
            }
        }
    }
}

/// Adjoint of `accelerate`: velocities before contact to velocities before the substep, and
/// forces; takes what contact adds to the former and gives d loss / d drag.
#[inline(always)]
pub(crate) fn accelerate_adjoint<T: Real>(
    system: &System<T>,
    before: &[Quad<T>],
    (bar, start_bar): (&mut [Node<T>], &mut [Quad<T>]),
    lambda: &mut [Quad<T>],
) -> T {
    let (dt, decay) = (system.dt, system.decay);
    let mut sum = [T::ZERO; 4];
    let bars = bar.iter_mut().zip(lambda).zip(start_bar);
    for (((bar, lambda), start), (&v, &inverse_mass)) in
        bars.zip(before.iter().zip(&system.inverse_mass))
    {
        sum = add(sum, product(bar.v, v));
        bar.v = scale(bar.v, decay);
        *lambda = scale(bar.v, inverse_mass * dt);
        bar.v = add(bar.v, *start);
        *start = [T::ZERO; 4];
    }
    let decay = sum[0] + sum[1] + sum[2];
    -(decay * system.dt)
}
