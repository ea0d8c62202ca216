//! The least time that a device's instruction issue allows, counted by hand. The fraction reached
//! shows how much of the machine a backend uses; better algorithms, which need fewer instructions,
//! are not considered.
//!
//! **Count.** A bound is (instructions of a substep) / (instructions that the whole device issues a
//! second). Only what no arrangement avoids is counted: the arithmetic of the formulas in the
//! engine's `spring.rs`, `bend.rs`, `ground.rs` and `integrate.rs`, and on a GPU the loads of
//! operands. Barriers, latency, bank conflicts, loop counters and losses are not, nor is contact
//! between nodes. A single instance is held against the whole device too, though it may not be able
//! to fill it.

mod cpu;
mod cuda;

use serde::Serialize;

use crate::scene::Scene;

/// Lane-wide instructions that a piece of work takes, per element.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Instructions {
    /// A spring seen from one of its ends, or from both together (see [`IssueBound::both_ends`]).
    pub spring: f64,
    /// A triplet, all three ends together.
    pub triplet: f64,
    /// A node's gravity, drag, step and ground.
    pub node: f64,
}

/// A device's instruction issue, and the instructions that the physics needs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IssueBound {
    /// Forward, per element.
    pub forward: Instructions,
    /// Forward once more and backward together, per element; triplets are not counted.
    pub gradient: Instructions,
    /// True if a spring is evaluated once from each of its nodes (as a gather without atomics does)
    /// rather than once.
    pub both_ends: bool,
    /// Elements an instruction works on.
    pub lanes: f64,
    /// Instructions a second, whole device.
    pub per_second: f64,
    /// Method of counting and measuring, in sentences for the reader of the report.
    pub how: String,
}

impl IssueBound {
    /// The bound of a device, by the kind and name that its backend gives; `None` where it is not
    /// known. On a CPU, its rate is measured: this takes about a tenth of a second.
    pub fn of(device: &bendtwin_engine::Device) -> Option<Self> {
        match device.kind.as_str() {
            "cpu" => cpu::bound(device.lanes),
            "cuda" => cuda::bound(&device.name),
            _ => None,
        }
    }

    /// Least time of a substep of one instance [s].
    pub fn forward_s(&self, scene: &Scene) -> f64 {
        self.seconds(&self.forward, scene)
    }

    /// Least time of a substep's forward and backward of one instance [s]; `None` with triplets,
    /// whose adjoint is not counted.
    pub fn gradient_s(&self, scene: &Scene) -> Option<f64> {
        let is_axial = scene.model.graph.triplets.is_empty();
        is_axial.then(|| self.seconds(&self.gradient, scene))
    }

    fn seconds(&self, count: &Instructions, scene: &Scene) -> f64 {
        let graph = &scene.model.graph;
        let springs = graph.springs.len();
        // A control point needs no force: its springs are seen from the node only.
        let evaluations =
            if self.both_ends { 2 * springs - scene.control_spring_count() } else { springs };
        let total = count.spring * evaluations as f64
            + count.triplet * graph.triplets.len() as f64
            + count.node * graph.node_count() as f64;
        total / self.lanes / self.per_second
    }
}

#[cfg(test)]
mod tests;
