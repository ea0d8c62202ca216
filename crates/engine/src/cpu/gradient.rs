//! Loss and gradient of one instance: forward with a checkpoint at every frame,
//! then backward frame by frame, each run again with its substeps on tape.
//! Memory is the frame-end states plus one frame's tape (less for large models).

use super::{
    arithmetic::{Node, Quad, Real, add},
    frame::{adjoint::Adjoint, surrounded::begin_adjoint},
    loss::{Moment, TermBars, Terms},
    parameters::Parameters,
    rollout::{Scorer, Simulation},
    surroundings::{
        body::Pose,
        force::{ForceSeeds, FrameForces},
        grasp::Hands,
    },
    system::System,
};
use crate::backend::{Error, Loss};
use bendtwin_core::CancelToken;

/// Loss and gradient in the simulation's scalar.
#[derive(Debug)]
pub(crate) struct LossGradient<T> {
    pub(crate) loss: Loss,
    pub(crate) parameters: Parameters<T>,
    /// Shape [F + 1, C].
    pub(crate) controls: Vec<Quad<T>>,
    /// Shape [N].
    pub(crate) initial: Vec<Node<T>>,
    /// Shape [R].
    pub(crate) initial_twists: Vec<T>,
    /// The initial holds, with d loss / d place.
    pub(crate) initial_hands: Hands<T>,
    /// Shape [F + 1, B].
    pub(crate) poses: Vec<Pose<T>>,
    /// Shape [F + 1, R], or empty.
    pub(crate) rolls: Vec<T>,
    /// State after the last frame, shape [N]; the last good one if it diverged.
    pub(crate) last: Vec<Node<T>>,
    /// Twists after the last frame, shape [R].
    pub(crate) last_twists: Vec<T>,
    /// Holds of the hands after the last frame.
    pub(crate) last_hands: Hands<T>,
    /// Norm of d loss / d positions of the nodes that nothing pins, shape [F + 1]; NaN if it
    /// diverged.
    pub(crate) norms: Vec<f64>,
}

/// Loss and gradient; `cut_every` as in [`crate::backend::GradientRequest`].
pub(crate) fn gradient<T: Real>(
    simulation: &Simulation<'_, T>,
    cut_every: usize,
    cancel: &CancelToken,
) -> Result<LossGradient<T>, Error> {
    let system = simulation.system;
    let n = system.nodes;
    let mut scorer = Scorer::new(simulation);
    let mut states: Vec<Vec<Node<T>>> = Vec::new();
    let mut twists: Vec<Vec<T>> = Vec::new();
    let mut hands: Vec<Hands<T>> = Vec::new();
    let mut forces: Vec<FrameForces<T>> = Vec::new();
    let diverged = simulation.run(cancel, |frame, now| {
        scorer.see(frame, now);
        states.push(now.nodes[..n].to_vec());
        twists.push(now.twists.clone());
        hands.push(now.around.hands.clone());
        if simulation.measures().is_some() {
            forces.push(now.around.forces.clone());
        }
    })?;
    let (loss, _) = scorer.finish(diverged, simulation.frames);
    let around = simulation.surroundings.as_ref();
    let mut adjoint = Adjoint::zero(system, around.map_or(0, |of| of.bodies));
    let mut prescribed = Prescribed {
        controls: vec![[T::ZERO; 4]; simulation.controls.len()],
        poses: vec![Pose::default(); around.map_or(0, |of| of.poses.len())],
        rolls: vec![T::ZERO; around.map_or(0, |of| of.rolls.len())],
    };
    let mut rest_lengths = vec![T::ZERO; system.parameters.rest_lengths_m.len()];
    let mut norms = vec![f64::NAN; simulation.frames + 1];
    if diverged.is_none() {
        let mut backward = Backward {
            simulation,
            states: &states,
            twists: &twists,
            hands: &hands,
            forces: &forces,
            terms: Terms::new(simulation.objective),
            rest_lengths: &mut rest_lengths,
            norms: &mut norms,
        };
        backward.run(&mut adjoint, &mut prescribed, cut_every, cancel)?;
    }
    let mut initial_hands = around.map(|of| of.start.clone()).unwrap_or_default();
    for hold in &mut initial_hands.holds {
        hold.place = adjoint.around.places[hold.node];
    }
    let mut parameters = adjoint.parameters(system);
    for (all, by_terms) in parameters.rest_lengths_m.iter_mut().zip(rest_lengths) {
        *all += by_terms;
    }
    adjoint.bar.truncate(n);
    Ok(LossGradient {
        loss,
        parameters,
        controls: prescribed.controls,
        initial: adjoint.bar,
        initial_twists: adjoint.twist_bar,
        initial_hands,
        poses: prescribed.poses,
        rolls: prescribed.rolls,
        last: states.pop().unwrap_or_default(),
        last_twists: twists.pop().unwrap_or_default(),
        last_hands: hands.pop().unwrap_or_default(),
        norms,
    })
}

/// d loss / d everything that moves as prescribed.
struct Prescribed<T> {
    /// Shape [F + 1, C].
    controls: Vec<Quad<T>>,
    /// Shape [F + 1, B].
    poses: Vec<Pose<T>>,
    /// Shape [F + 1, R, 2], or empty.
    rolls: Vec<T>,
}

impl<T: Real> Prescribed<T> {
    /// Adjoint of the bodies' poses at a frame's end.
    fn poses_at(&mut self, frame: usize, simulation: &Simulation<'_, T>) -> &mut [Pose<T>] {
        let bodies = simulation.surroundings.as_ref().map_or(0, |of| of.bodies);
        &mut self.poses[frame * bodies..(frame + 1) * bodies]
    }

    /// Adds what a frame's adjoint, 0-based, has gathered; after the last frame there is no row for
    /// what stands still.
    fn gather(&mut self, adjoint: &Adjoint<T>, frame: usize) {
        let (from, to) = (&adjoint.controls.from, &adjoint.controls.to);
        let c = from.len();
        let rows = &mut self.controls[frame * c..];
        rows.iter_mut().zip(from.iter().chain(to)).for_each(|(a, b)| *a = add(*a, *b));
        let bodies = &adjoint.around.bodies;
        let both = bodies.iter().map(|b| &b.from).chain(bodies.iter().map(|b| &b.to));
        for (row, bar) in self.poses[frame * bodies.len()..].iter_mut().zip(both) {
            for i in 0..3 {
                row[i] = add(row[i], bar[i]);
            }
        }
        if !self.rolls.is_empty() {
            let by = &adjoint.around.rolls;
            let rows = &mut self.rolls[frame * by.len()..];
            let both = by.iter().map(|&x| -x).chain(by.iter().copied());
            rows.iter_mut().zip(both).for_each(|(a, x)| *a += x);
        }
    }
}

struct Backward<'a, T> {
    simulation: &'a Simulation<'a, T>,
    /// Frame-end states, shape [F + 1, N].
    states: &'a [Vec<Node<T>>],
    /// Frame-end twists, shape [F + 1, R].
    twists: &'a [Vec<T>],
    /// Holds of the hands at frames' ends, shape [F + 1].
    hands: &'a [Hands<T>],
    /// Frames' forces, shape [F + 1], or empty.
    forces: &'a [FrameForces<T>],
    terms: Terms<'a>,
    /// d loss / d rest lengths by terms that depend on them directly, shape [E].
    rest_lengths: &'a mut [T],
    /// Shape [F + 1].
    norms: &'a mut [f64],
}

impl<T: Real> Backward<'_, T> {
    fn run(
        &mut self,
        adjoint: &mut Adjoint<T>,
        prescribed: &mut Prescribed<T>,
        cut_every: usize,
        cancel: &CancelToken,
    ) -> Result<(), Error> {
        let simulation = self.simulation;
        let mut workspace = simulation.start();
        let taken = std::mem::take(&mut workspace.around.taken);
        let rods = std::mem::take(&mut workspace.around.rods);
        workspace.around.arrive.clear();
        let mut arriving = Vec::new();
        for frame in (0..=simulation.frames).rev() {
            self.add_later_terms(frame, &mut adjoint.bar);
            if frame > 0 && cut_every > 0 && frame.is_multiple_of(cut_every) {
                adjoint.bar.fill(Node::default());
                adjoint.twist_bar.fill(T::ZERO);
                adjoint.around.places.fill([T::ZERO; 4]);
                arriving.clear();
            }
            let mut seeds = simulation.measures().map(|of| ForceSeeds::zero(of, simulation.system));
            if let Some(moment) = moment(simulation, self.states, self.forces, frame) {
                let rest_lengths = &mut *self.rest_lengths;
                let nodes = &mut adjoint.bar;
                let poses = prescribed.poses_at(frame, simulation);
                let forces = seeds.as_mut();
                let mut bars = TermBars { nodes, rest_lengths, poses, forces };
                self.terms.add_gradient(frame, moment, &mut bars);
            }
            self.norms[frame] = norm(simulation.system, &adjoint.bar);
            if frame == 0 {
                break;
            }
            if cancel.is_cancelled() {
                return Err(Error::Cancelled);
            }
            workspace.nodes[..simulation.system.nodes].copy_from_slice(&self.states[frame - 1]);
            workspace.twists.copy_from_slice(&self.twists[frame - 1]);
            workspace.around.hands.clone_from(&self.hands[frame - 1]);
            let around = simulation.around(frame - 1).map(|at| {
                // No term asks for a force: then nothing is measured again.
                let matter = seeds.as_mut().is_some_and(|s| s.spread(at.of));
                (at, seeds.as_ref().filter(|_| matter))
            });
            let controls = simulation.controls_of(frame - 1);
            arriving = adjoint.back_frame(simulation.system, controls, around, &mut workspace);
            prescribed.gather(adjoint, frame - 1);
            if frame > 1 {
                add_velocities(&mut adjoint.bar, &arriving);
            }
        }
        // Pinned nodes were put onto their control points, and hands took nodes, before frame 0 was
        // measured.
        adjoint.controls.clear();
        adjoint.around.clear();
        match simulation.around(0) {
            None => adjoint.controls.begin(simulation.system, &mut adjoint.bar),
            Some(at) => {
                workspace.around.taken = taken;
                workspace.around.rods = rods;
                begin_adjoint(at, simulation.system, &workspace.around, None, adjoint);
                add_velocities(&mut adjoint.bar, &arriving);
            }
        }
        prescribed.gather(adjoint, 0);
        Ok(())
    }

    /// Terms of the next two frames that look back at this one.
    fn add_later_terms(&self, frame: usize, bar: &mut [Node<T>]) {
        if !self.terms.look_back() {
            return;
        }
        for back in [1, 2] {
            if let Some(moment) = moment(self.simulation, self.states, self.forces, frame + back) {
                self.terms.add_gradient_back(frame + back, back, moment, bar);
            }
        }
    }
}

fn add_velocities<T: Real>(bar: &mut [Node<T>], velocities: &[(usize, Quad<T>)]) {
    for &(node, v) in velocities {
        bar[node].v = add(bar[node].v, v);
    }
}

/// Norm of d loss / d positions; pinned nodes, which do not move by themselves, count as zero.
fn norm<T: Real>(system: &System<T>, bar: &[Node<T>]) -> f64 {
    let free = bar.iter().zip(&system.inverse_mass).filter(|(_, m)| **m > T::ZERO);
    let square = |x: Quad<T>| x[..3].iter().map(|x| x.to_f64().powi(2)).sum::<f64>();
    free.map(|(bar, _)| square(bar.x)).sum::<f64>().sqrt()
}

/// A frame's end, with the two before it; `None` after the last.
pub(super) fn moment<'a, T>(
    simulation: &'a Simulation<'_, T>,
    states: &'a [Vec<Node<T>>],
    forces: &'a [FrameForces<T>],
    frame: usize,
) -> Option<Moment<'a, T>> {
    let now = states.get(frame)?;
    let earlier = match frame.checked_sub(2) {
        Some(two) => Some([&*states[frame - 1], &*states[two]]),
        None => None,
    };
    let forces = if frame > 0 { forces.get(frame) } else { None };
    let (system, around) = (simulation.system, simulation.surroundings.as_ref());
    Some(Moment { frame, now, earlier, system, around, forces })
}
