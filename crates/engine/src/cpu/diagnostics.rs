//! Outputs of a rollout beside its costs: recorded positions, final state and diagnostics.

use super::{
    body::Pose,
    force::{FrameForces, Wrench},
    grasp::{Hands, Hold},
    integrate::Workspace,
    lanes::Node,
    parameters::narrow,
    real::{Real, dot},
    rollout::Simulation,
    system::System,
};
use crate::constants::ON_GROUND_M;
use crate::{
    backend::{Diagnostics, Forces, Loss, Outputs, Rollout},
    energy,
    model::State,
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
            rollout: Rollout {
                forces: outputs.forces.then(Forces::default),
                ..Rollout::default()
            },
            sanity: Diagnostics::default(),
        }
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
            let positions = &mut self.rollout.positions;
            match &self.outputs.nodes {
                None => positions.extend(nodes.iter().map(|n| point(n.x))),
                Some(some) => positions.extend(some.iter().map(|&i| point(nodes[i as usize].x))),
            }
        }
        let last = frame == self.frames;
        if let Some(forces) = self.rollout.forces.as_mut().filter(|_| frame > 0) {
            record(forces, &now.around.forces);
        }
        if self.outputs.final_state && last {
            self.rollout.final_state = Some(state_of(nodes, &now.twists, &now.around.hands));
        }
        if self.outputs.diagnostics && (frame > 0 || last) {
            self.measure(now, last);
        }
    }

    fn measure(&mut self, now: &Workspace<T>, last: bool) {
        let nodes = &now.nodes[..self.system.nodes];
        let speed = nodes.iter().map(|n| dot(n.v, n.v).to_f64()).fold(0.0, f64::max).sqrt();
        self.sanity.max_speed_m_s = self.sanity.max_speed_m_s.max(narrow(speed));
        let strain = energy::max_strain(self.system, &now.nodes);
        self.sanity.max_strain = self.sanity.max_strain.max(narrow(strain));
        if last {
            let system = now.around.system.as_deref().unwrap_or(self.system);
            let energy = energy::of_nodes(system, &now.nodes, &now.twists);
            self.sanity.kinetic_energy = narrow(energy.kinetic);
            self.sanity.elastic_energy = narrow(energy.elastic);
            if let Some(g) = &self.system.ground {
                let on_ground =
                    |n: &&Node<T>| (dot(g.normal, n.x) - g.offset).to_f64() < ON_GROUND_M;
                self.sanity.ground_contacts = nodes.iter().filter(on_ground).count() as u32;
            }
        }
    }

    pub(crate) fn finish(self, loss: Loss) -> Rollout {
        let ended = loss.diverged.is_none();
        Rollout {
            cost: loss.total,
            group_costs: loss.groups,
            diverged: loss.diverged,
            final_state: self.rollout.final_state.filter(|_| ended),
            diagnostics: (self.outputs.diagnostics && ended).then_some(self.sanity),
            ..self.rollout
        }
    }
}

/// To a client's point.
pub(crate) fn point<T: Real>(x: [T; 4]) -> [f32; 3] {
    [narrow(x[0]), narrow(x[1]), narrow(x[2])]
}

/// To a client's pose.
pub(crate) fn pose<T: Real>(pose: &Pose<T>) -> world::Pose {
    pose.map(|row| row.map(narrow))
}

/// A client's view of nodes, twists and grasps.
pub(crate) fn state_of<T: Real>(nodes: &[Node<T>], twists: &[T], hands: &Hands<T>) -> State {
    let hold = |h: &Hold<T>| world::Hold {
        node: h.node as u32,
        grasp: h.grasp as u32,
        place: point(h.place),
    };
    State {
        positions: nodes.iter().map(|n| point(n.x)).collect(),
        velocities: nodes.iter().map(|n| point(n.v)).collect(),
        twists: twists.iter().map(|&x| narrow(x)).collect(),
        grasping: Grasping {
            phases: hands.phases.clone(),
            holds: hands.holds.iter().map(hold).collect(),
        },
    }
}

/// Records the forces of a frame.
fn record<T: Real>(forces: &mut Forces, of: &FrameForces<T>) {
    let wrench = |[force, torque]: &Wrench<T>| {
        let ([fx, fy, fz], [tx, ty, tz]) = (point(*force), point(*torque));
        [fx, fy, fz, tx, ty, tz]
    };
    forces.controls.extend(of.controls.iter().map(|&f| point(f)));
    forces.grasps.extend(of.grasps.iter().map(wrench));
    forces.ground.push(point(of.ground));
    forces.colliders.extend(of.colliders.iter().map(wrench));
}
