//! Outputs of a rollout beside its costs: recorded positions and velocities, final state and
//! diagnostics.
//!
//! Velocities, speeds and energies are those of the states at frames' ends: what a state holds and
//! what is reported of it agree.

use bendtwin_core::{Plane, Point};

use super::{
    arithmetic::{Node, Real, dot},
    frame::integrate::Workspace,
    parameters::narrow,
    rollout::Simulation,
    surroundings::{
        force::{FrameForces, Wrench},
        grasp::{Hands, Hold},
    },
    system::System,
};
use crate::{
    backend::{Diagnose, Diagnostics, Forces, Loss, Outputs, Rollout},
    energy,
    model::{State, ground_contacts},
    world::{self, Grasping},
};

/// Watches a rollout.
pub(crate) struct Observer<'a, T> {
    system: &'a System<T>,
    outputs: &'a Outputs,
    frames: usize,
    rollout: Rollout,
    sanity: Diagnostics,
}

impl<'a, T: Real> Observer<'a, T> {
    pub(crate) fn new(simulation: &'a Simulation<'_, T>, outputs: &'a Outputs) -> Self {
        Self {
            system: simulation.system,
            outputs,
            frames: simulation.frames,
            rollout: Rollout { forces: outputs.forces.then(Forces::default), ..Rollout::default() },
            sanity: Diagnostics {
                kinetic_energy: f32::NAN,
                elastic_energy: f32::NAN,
                ..Diagnostics::default()
            },
        }
    }

    fn diagnoses(&self) -> bool {
        self.outputs.diagnose != Diagnose::Nothing
    }

    pub(crate) fn see(&mut self, frame: usize, now: &Workspace<T>) {
        let nodes = &now.nodes[..self.system.nodes];
        let every = self.outputs.every;
        let wanted = if frame == 0 {
            self.outputs.initial
        } else {
            every > 0 && frame.is_multiple_of(every)
        };
        if wanted {
            self.rollout.frames.push(frame);
            self.record(nodes);
        }
        let last = frame == self.frames;
        if let Some(forces) = self.rollout.forces.as_mut().filter(|_| frame > 0) {
            record_forces(forces, &now.around.forces);
        }
        if self.outputs.final_state && last {
            self.rollout.final_state = Some(state_of(nodes, &now.twists, &now.around.hands));
        }
        if self.diagnoses() && (frame > 0 || last) {
            self.measure(now, last);
        }
    }

    /// Records positions, and velocities if they are wanted.
    fn record(&mut self, nodes: &[Node<T>]) {
        let Rollout { positions, velocities, .. } = &mut self.rollout;
        let mut one = |n: &Node<T>| {
            positions.push(point(n.x));
            if self.outputs.velocities {
                velocities.push(point(n.v));
            }
        };
        match &self.outputs.nodes {
            None => nodes.iter().for_each(one),
            Some(some) => some.iter().for_each(|&i| one(&nodes[i as usize])),
        }
    }

    fn measure(&mut self, now: &Workspace<T>, last: bool) {
        let nodes = &now.nodes[..self.system.nodes];
        let sanity = &mut self.sanity;
        let squares = nodes.iter().map(|n| dot(n.v, n.v).to_f64());
        let speed = squares.fold(0.0, f64::max).sqrt();
        sanity.max_speed_m_s = sanity.max_speed_m_s.max(narrow(speed));
        let [strain, of_controls] = energy::max_strains(self.system, &now.nodes);
        sanity.max_strain = sanity.max_strain.max(narrow(strain));
        sanity.max_control_strain = sanity.max_control_strain.max(narrow(of_controls));
        if self.outputs.diagnose != Diagnose::All {
            return;
        }
        // Of the last frame that is reached, which may not be the last.
        if let Some(g) = &self.system.ground {
            let plane = Plane { normal: point(g.normal), offset_m: narrow(g.offset) };
            let positions: Vec<Point> = nodes.iter().map(|n| point(n.x)).collect();
            let skin = self.system.skin_contact.then_some(&*self.system.skin);
            sanity.ground_contacts = ground_contacts(&plane, skin, &positions);
        }
        if last {
            let system = now.around.system.as_deref().unwrap_or(self.system);
            let energy = energy::of_nodes(system, &now.nodes, &now.twists);
            sanity.kinetic_energy = narrow(energy.kinetic);
            sanity.elastic_energy = narrow(energy.elastic);
        }
    }

    /// The rollout; `frame_costs` as in [`Rollout`].
    pub(crate) fn finish(self, loss: Loss, frame_costs: Vec<f64>) -> Rollout {
        let (ended, diagnoses) = (loss.diverged.is_none(), self.diagnoses());
        let wants_costs = self.outputs.frame_costs;
        Rollout {
            frame_costs: if wants_costs { frame_costs } else { Vec::new() },
            cost: loss.total,
            group_costs: loss.groups,
            diverged: loss.diverged,
            final_state: self.rollout.final_state.filter(|_| ended),
            diagnostics: diagnoses.then_some(self.sanity),
            ..self.rollout
        }
    }
}

/// Converts a point to the client's type.
pub(crate) fn point<T: Real>(x: [T; 4]) -> [f32; 3] {
    [narrow(x[0]), narrow(x[1]), narrow(x[2])]
}

/// Converts a hold to the client's type.
pub(crate) fn hold_of<T: Real>(h: &Hold<T>) -> world::Hold {
    world::Hold { node: h.node as u32, grasp: h.grasp as u32, place: point(h.place) }
}

/// A client's view of nodes, twists and grasps.
pub(crate) fn state_of<T: Real>(nodes: &[Node<T>], twists: &[T], hands: &Hands<T>) -> State {
    State {
        positions: nodes.iter().map(|n| point(n.x)).collect(),
        velocities: nodes.iter().map(|n| point(n.v)).collect(),
        twists: twists.iter().map(|&x| narrow(x)).collect(),
        grasping: Grasping {
            phases: hands.phases.clone(),
            holds: hands.holds.iter().map(hold_of).collect(),
        },
    }
}

/// Records the forces of a frame.
fn record_forces<T: Real>(forces: &mut Forces, of: &FrameForces<T>) {
    let wrench = |[force, torque]: &Wrench<T>| {
        let ([fx, fy, fz], [tx, ty, tz]) = (point(*force), point(*torque));
        [fx, fy, fz, tx, ty, tz]
    };
    forces.controls.extend(of.controls.iter().map(|&f| point(f)));
    forces.grasps.extend(of.grasps.iter().map(wrench));
    forces.ground.push(point(of.ground));
    forces.colliders.extend(of.colliders.iter().map(wrench));
}
