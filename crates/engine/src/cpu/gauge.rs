//! Costs along positions that no simulation made, such as the mean of several simulations, and their
//! gradient by these positions.

use bendtwin_core::Point;

use super::{
    arithmetic::{Node, quad},
    gradient::moment,
    gradient_point,
    loss::{TermBars, Terms},
    parameters::{Parameters, saturate},
    simulation_on,
    system::{Layout, System},
};
use crate::{Model, backend::Instance, world::Pose};

/// Measures terms along given positions, with the same bits as the CPU backend does along the same
/// simulated positions. Terms of forces, which do not follow from positions, count as zero.
pub struct Gauge {
    system: System<f32>,
}

/// d loss / d what terms depend on along given positions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PathGradient {
    /// Gradient by positions, shape [F + 1, N, 3].
    pub positions: Vec<Point>,
    /// Gradient by poses of the world's bodies, which colliders are on, shape [F + 1, B].
    pub poses: Vec<Pose>,
}

impl Gauge {
    /// A gauge whose skin and springs are those of a checked model.
    pub fn new(model: &Model) -> Self {
        let parameters = Parameters::from_params(&model.params);
        Self { system: System::new(model, &Layout::new(&model.graph), parameters) }
    }

    /// Weighted sums by frame and group, shape [F + 1, groups], of an instance that a backend has
    /// accepted, along positions [m] of shape [F + 1, N, 3]. Nothing is added up in frames that these
    /// do not reach.
    pub fn frame_costs(&self, of: &Instance, positions: &[Point]) -> Vec<f64> {
        let (simulation, states) = (simulation_on(&self.system, of, false), self.states(positions));
        let (terms, groups) = (Terms::new(&of.objective), of.objective.groups.len());
        let mut costs = vec![0.0; (of.frames + 1) * groups];
        for (frame, row) in costs.chunks_exact_mut(groups.max(1)).enumerate() {
            if let Some(moment) = moment(&simulation, &states, &[], frame) {
                terms.score(frame, moment, row);
            }
        }
        costs
    }

    /// The gradient of the sum of all of [`Gauge::frame_costs`].
    pub fn gradient(&self, of: &Instance, positions: &[Point]) -> PathGradient {
        let (simulation, states) = (simulation_on(&self.system, of, false), self.states(positions));
        let (terms, bodies) = (Terms::new(&of.objective), of.world.bodies);
        let mut gradient = PathGradient::default();
        let mut rest_lengths = vec![0.0; self.system.parameters.rest_lengths_m.len()];
        for frame in 0..=of.frames {
            let mut nodes = vec![Node::default(); self.system.nodes];
            let mut poses = vec![Default::default(); bodies];
            for back in [1, 2] {
                if let Some(later) = moment(&simulation, &states, &[], frame + back) {
                    terms.add_gradient_back(frame + back, back, later, &mut nodes);
                }
            }
            if let Some(moment) = moment(&simulation, &states, &[], frame) {
                let mut bars = TermBars {
                    nodes: &mut nodes,
                    rest_lengths: &mut rest_lengths,
                    poses: &mut poses,
                    forces: None,
                };
                terms.add_gradient(frame, moment, &mut bars);
            }
            gradient.positions.extend(nodes.iter().map(|node| gradient_point(node.x)));
            gradient.poses.extend(poses.iter().map(|pose| pose.map(|row| row.map(saturate))));
        }
        gradient
    }

    fn states(&self, positions: &[Point]) -> Vec<Vec<Node<f32>>> {
        let nodes = |row: &[Point]| -> Vec<Node<f32>> {
            row.iter().map(|&point| Node { x: quad(point), v: [0.0; 4] }).collect()
        };
        positions.chunks_exact(self.system.nodes.max(1)).map(nodes).collect()
    }
}

#[cfg(test)]
mod tests;
