//! Loss and gradient of one instance: forward with a checkpoint at every frame,
//! then backward frame by frame, each run again with its substeps on tape.
//! Memory is the frame-end states plus one frame's tape (less for large models).

use super::{
    adjoint::Adjoint,
    lanes::Node,
    loss::{Moment, TermBars, Terms},
    parameters::Parameters,
    real::{Quad, Real, add},
    rollout::{Scorer, Simulation},
    system::System,
};
use bendtwin_core::CancelToken;

use crate::backend::{Error, Loss};

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
    /// State after the last frame, shape [N]; the last good one if it diverged.
    pub(crate) last: Vec<Node<T>>,
    /// Twists after the last frame, shape [R].
    pub(crate) last_twists: Vec<T>,
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
    let diverged = simulation.run(cancel, |frame, now| {
        scorer.see(frame, &now.nodes[..n]);
        states.push(now.nodes[..n].to_vec());
        twists.push(now.twists.clone());
    })?;
    let (loss, _) = scorer.finish(diverged, simulation.frames);
    let mut adjoint = Adjoint::zero(system);
    let mut controls = vec![[T::ZERO; 4]; simulation.controls.len()];
    let mut rest_lengths = vec![T::ZERO; system.parameters.rest_lengths_m.len()];
    let mut norms = vec![f64::NAN; simulation.frames + 1];
    if diverged.is_none() {
        let terms = Terms::new(simulation.objective);
        let mut backward = Backward {
            simulation,
            states: &states,
            twists: &twists,
            terms,
            rest_lengths: &mut rest_lengths,
            norms: &mut norms,
        };
        backward.run(&mut adjoint, &mut controls, cut_every, cancel)?;
    }
    let mut parameters = adjoint.parameters(system);
    for (all, by_terms) in parameters.rest_lengths_m.iter_mut().zip(rest_lengths) {
        *all += by_terms;
    }
    adjoint.bar.truncate(n);
    Ok(LossGradient {
        loss,
        parameters,
        controls,
        initial: adjoint.bar,
        initial_twists: adjoint.twist_bar,
        last: states.pop().unwrap_or_default(),
        last_twists: twists.pop().unwrap_or_default(),
        norms,
    })
}

struct Backward<'a, T> {
    simulation: &'a Simulation<'a, T>,
    /// Frame-end states, shape [F + 1, N].
    states: &'a [Vec<Node<T>>],
    /// Frame-end twists, shape [F + 1, R].
    twists: &'a [Vec<T>],
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
        controls: &mut [Quad<T>],
        cut_every: usize,
        cancel: &CancelToken,
    ) -> Result<(), Error> {
        let (simulation, c) = (self.simulation, self.simulation.system.controls);
        let mut workspace = simulation.start();
        for frame in (0..=simulation.frames).rev() {
            self.add_later_terms(frame, &mut adjoint.bar);
            if frame > 0 && cut_every > 0 && frame.is_multiple_of(cut_every) {
                adjoint.bar.fill(Node::default());
                adjoint.twist_bar.fill(T::ZERO);
            }
            if let Some(moment) = moment(self.states, frame, simulation.system) {
                let rest_lengths = &mut *self.rest_lengths;
                let mut bars = TermBars { nodes: &mut adjoint.bar, rest_lengths };
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
            adjoint.back_frame(
                simulation.system,
                simulation.controls_of(frame - 1),
                &mut workspace,
            );
            accumulate(&mut controls[(frame - 1) * c..frame * c], &adjoint.controls.from);
            accumulate(&mut controls[frame * c..(frame + 1) * c], &adjoint.controls.to);
        }
        // Pinned nodes were put onto their control points before frame 0 was measured.
        adjoint.controls.clear();
        adjoint.controls.begin(simulation.system, &mut adjoint.bar);
        accumulate(&mut controls[..c], &adjoint.controls.from);
        if simulation.frames > 0 {
            accumulate(&mut controls[c..2 * c], &adjoint.controls.to);
        }
        Ok(())
    }

    /// Terms of the next two frames that look back at this one.
    fn add_later_terms(&self, frame: usize, bar: &mut [Node<T>]) {
        if !self.terms.look_back() {
            return;
        }
        for back in [1, 2] {
            let system = self.simulation.system;
            if let Some(moment) = moment(self.states, frame + back, system) {
                self.terms.add_gradient_back(frame + back, back, moment, bar);
            }
        }
    }
}

/// A frame's end, with the two before it; `None` after the last.
fn moment<'a, T>(
    states: &'a [Vec<Node<T>>],
    frame: usize,
    system: &'a System<T>,
) -> Option<Moment<'a, T>> {
    let now = states.get(frame)?;
    let earlier = match frame.checked_sub(2) {
        Some(two) => Some([&*states[frame - 1], &*states[two]]),
        None => None,
    };
    Some(Moment { now, earlier, system })
}

/// Norm of d loss / d positions; what is pinned does not move by itself.
fn norm<T: Real>(system: &System<T>, bar: &[Node<T>]) -> f64 {
    let free = bar.iter().zip(&system.inverse_mass).filter(|(_, m)| **m > T::ZERO);
    let square = |x: Quad<T>| x[..3].iter().map(|x| x.to_f64().powi(2)).sum::<f64>();
    free.map(|(bar, _)| square(bar.x)).sum::<f64>().sqrt()
}

fn accumulate<T: Real>(into: &mut [Quad<T>], from: &[Quad<T>]) {
    for (a, b) in into.iter_mut().zip(from) {
        *a = add(*a, *b);
    }
}
