//! A rollout of an instance through all its frames, in any scalar.

use bendtwin_core::{CancelToken, Graph};

use super::{
    arithmetic::{Node, Quad, Real, quad},
    frame::{
        control::FrameControls,
        integrate::{Workspace, begin_frame, run_frame},
        surrounded::Frame,
    },
    loss::{Moment, Terms},
    surroundings::Surroundings,
    system::System,
};
use crate::{
    backend::{Divergence, Error, Loss},
    constants::MAX_COORDINATE_M,
    model::State,
    objective::Objective,
};

/// A simulation to run.
pub(crate) struct Simulation<'a, T> {
    pub(crate) system: &'a System<T>,
    /// Initial state, shape [N].
    pub(crate) initial: Vec<Node<T>>,
    /// Initial twists [rad], shape [R].
    pub(crate) twists: Vec<T>,
    /// Shape [F + 1, C].
    pub(crate) controls: Vec<Quad<T>>,
    /// Frames F.
    pub(crate) frames: usize,
    pub(crate) objective: &'a Objective,
    /// Surroundings of the object beside the ground.
    pub(crate) surroundings: Option<Surroundings<T>>,
}

/// A client's state in the simulation's scalar.
pub(crate) fn nodes_of<T: Real>(state: &State) -> Vec<Node<T>> {
    let both = state.positions.iter().zip(&state.velocities);
    both.map(|(&x, &v)| Node { x: quad(x), v: quad(v) }).collect()
}

/// A client's twists in the simulation's scalar; zero where it names none.
pub(crate) fn twists_of<T: Real>(state: &State, graph: &Graph) -> Vec<T> {
    let mut twists: Vec<T> = state.twists.iter().map(|&x| T::from_f32(x)).collect();
    twists.resize(graph.rods.len(), T::ZERO);
    twists
}

impl<T: Real> Simulation<'_, T> {
    /// Motion of the controls during a frame, 0-based.
    pub(crate) fn controls_of(&self, frame: usize) -> FrameControls<'_, T> {
        let row = |f: usize| {
            let c = self.system.controls;
            &self.controls[f * c..(f + 1) * c]
        };
        FrameControls { from: row(frame), to: row((frame + 1).min(self.frames)) }
    }

    /// Surroundings of the object during a frame, 0-based.
    pub(crate) fn around(&self, frame: usize) -> Option<Frame<'_, T>> {
        self.surroundings.as_ref().map(|of| Frame { of, frame, frames: self.frames })
    }

    /// The surroundings, if their forces are measured.
    pub(crate) fn measures(&self) -> Option<&Surroundings<T>> {
        self.surroundings.as_ref().filter(|of| of.measured)
    }

    /// A workspace at the initial state, pinned nodes on their control points; hands have opened and
    /// closed for the first frame.
    pub(crate) fn start(&self) -> Workspace<T> {
        let mut workspace = Workspace::new(self.system);
        workspace.nodes[..self.system.nodes].copy_from_slice(&self.initial);
        workspace.twists.copy_from_slice(&self.twists);
        match self.around(0) {
            None => self.controls_of(0).begin(self.system, &mut workspace.nodes),
            Some(at) => {
                workspace.around.hands = at.of.start.clone();
                begin_frame(self.system, self.controls_of(0), Some(at), &mut workspace);
                // A rollout that resumes at a frame's end measures what the whole one does.
                if at.of.measured {
                    workspace.around.arrive.extend(self.initial.iter().map(|n| n.v));
                }
            }
        }
        workspace
    }

    /// Runs all frames and shows endpoints and twists at every frame's end, the initial ones
    /// first, until a frame has diverged.
    pub(crate) fn run(
        &self,
        cancel: &CancelToken,
        mut on_frame: impl FnMut(usize, &Workspace<T>),
    ) -> Result<Option<Divergence>, Error> {
        let n = self.system.nodes;
        let mut workspace = self.start();
        on_frame(0, &workspace);
        for frame in 1..=self.frames {
            if cancel.is_cancelled() {
                return Err(Error::Cancelled);
            }
            let around = self.around(frame - 1);
            run_frame(self.system, self.controls_of(frame - 1), around, &mut workspace);
            if let Some(node) = first_diverged(&workspace.nodes[..n]) {
                return Ok(Some(Divergence { frame, node }));
            }
            on_frame(frame, &workspace);
        }
        Ok(None)
    }
}

/// First node that is not finite or is farther than [`MAX_COORDINATE_M`] from the origin along an
/// axis.
fn first_diverged<T: Real>(nodes: &[Node<T>]) -> Option<usize> {
    let max_distance = T::from_f64(MAX_COORDINATE_M);
    let inside = |n: &Node<T>| {
        n.x[..3].iter().all(|x| x.abs() <= max_distance) && n.v[..3].iter().all(|v| v.is_finite())
    };
    nodes.iter().position(|n| !inside(n))
}

/// Adds up an objective along a rollout.
pub(crate) struct Scorer<'a, T> {
    terms: Terms<'a>,
    /// Losses by frame, shape [frames seen, groups].
    frames: Vec<f64>,
    groups: usize,
    simulation: &'a Simulation<'a, T>,
    /// The two latest frames, newest last, if a term looks back.
    recent: Vec<Vec<Node<T>>>,
}

impl<'a, T: Real> Scorer<'a, T> {
    pub(crate) fn new(simulation: &'a Simulation<'_, T>) -> Self {
        let objective = simulation.objective;
        let frames = Vec::with_capacity(objective.groups.len() * (simulation.frames + 1));
        let groups = objective.groups.len();
        Self { terms: Terms::new(objective), frames, groups, simulation, recent: Vec::new() }
    }

    pub(crate) fn see(&mut self, frame: usize, workspace: &Workspace<T>) {
        let system = self.simulation.system;
        let now = &workspace.nodes[..system.nodes];
        let earlier = match &*self.recent {
            [two, one] => Some([&**one, &**two]),
            _ => None,
        };
        let start = self.frames.len();
        self.frames.resize(start + self.groups, 0.0);
        let around = self.simulation.surroundings.as_ref();
        let forces = around.filter(|of| of.measured && frame > 0).map(|_| &workspace.around.forces);
        let moment = Moment { frame, now, earlier, system, around, forces };
        self.terms.score(frame, moment, &mut self.frames[start..]);
        if self.terms.look_back() {
            if self.recent.len() == 2 {
                self.recent.remove(0);
            }
            self.recent.push(now.to_vec());
        }
    }

    /// The loss, and the groups' values by frame, shape [F + 1, groups].
    pub(crate) fn finish(
        mut self,
        diverged: Option<Divergence>,
        frames: usize,
    ) -> (Loss, Vec<f64>) {
        self.frames.resize((frames + 1) * self.groups, f64::INFINITY);
        let mut groups = vec![0.0; self.groups];
        for frame in self.frames.chunks_exact(self.groups.max(1)) {
            groups.iter_mut().zip(frame).for_each(|(sum, value)| *sum += value);
        }
        if diverged.is_some() {
            groups.fill(f64::INFINITY);
        }
        let total = if diverged.is_some() { f64::INFINITY } else { groups.iter().sum() };
        (Loss { total, groups, diverged }, self.frames)
    }
}

/// The initial state and every frame's end.
pub(crate) fn losses<T: Real>(
    simulation: &Simulation<'_, T>,
    cancel: &CancelToken,
) -> Result<Loss, Error> {
    let mut scorer = Scorer::new(simulation);
    let diverged = simulation.run(cancel, |frame, now| scorer.see(frame, now))?;
    Ok(scorer.finish(diverged, simulation.frames).0)
}
