//! Twins with nothing but what a test is about.

use bendtwin_core::{
    Environment, Graph, Params, Quality, Skin, Timing, Twin, environment::ControlVelocity,
    twin::Provenance,
};

/// A twin of a graph and its parameters: its skin is its nodes, it was not scored, and it moves at 30
/// frames a second with one substep a frame, above the ground. Tests change what they are about:
/// `Twin { timing, ..twin_of(graph, params) }`.
pub fn twin_of(graph: Graph, params: Params) -> Twin {
    Twin {
        skin: Skin::of_nodes(&graph),
        graph,
        params,
        environment: Environment::Z_UP,
        timing: Timing { fps: 30.0, substeps: 1 },
        control_velocity: ControlVelocity::True,
        provenance: Provenance::default(),
        quality: Quality::default(),
        mass_kg: None,
        control_hands: Vec::new(),
        members: Vec::new(),
        appearance: None,
        planner: None,
    }
}
