//! Placement: the shape in which a graph explains observed points, by geometry alone. A graph that
//! has no parameters yet is placed by it, and one whose control points are another recording's.

use bendtwin_core::{
    CancelToken, Graph, Point, Skin,
    geometry::{RigidMotion, point, vector3},
};

use crate::{
    Around, Error, Explained, Observation, RegisterOptions, Residual,
    register::{Job, check_cloud},
};

/// A graph in the shape of observed points.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// Positions of the nodes [m], shape [N, 3].
    pub positions: Vec<Point>,
    /// Distances of the observed points.
    pub residual: Residual,
    /// Shares that explain each other.
    pub explained: Explained,
    /// The rigid part of the motion from the rest shape.
    pub rigid: RigidMotion,
}

/// Places the nodes of a graph, from their rest shape, so that its skin explains an observation.
/// Control points and pins of the graph take no part; of the options, what is held or around and frames
/// of physics neither.
///
/// # Errors
/// If the input does not fit the graph, if it does not explain the points, or on cancellation.
pub fn place(
    graph: &Graph,
    skin: &Skin,
    observation: &Observation,
    options: &RegisterOptions,
    cancel: &CancelToken,
) -> Result<Placement, Error> {
    observation.check(graph)?;
    let options = RegisterOptions {
        initial: None,
        controls: Vec::new(),
        held: Vec::new(),
        around: Around::default(),
        ..options.clone()
    };
    let nodes = nodes_alone(graph);
    options.check(&nodes)?;
    check_cloud(observation, &options)?;
    if graph.surface_count() == 0 {
        return Err(Error::Invalid("the twin has no surface".into()));
    }
    let shape = nodes.rest_positions.iter().map(|p| vector3(*p)).collect();
    let job = Job::new(&nodes, None, skin, shape, observation, &options, cancel);
    let (rigid, x) = job.best()?;
    let (residual, explained) = job.explain(&x)?;
    Ok(Placement { positions: x.into_iter().map(point).collect(), residual, explained, rigid })
}

/// The nodes of a graph and the springs between them.
fn nodes_alone(graph: &Graph) -> Graph {
    let n = graph.node_count();
    Graph {
        rest_positions: graph.rest_positions.clone(),
        kinds: graph.kinds.clone(),
        masses: graph.masses.clone(),
        object_ids: graph.object_ids.clone(),
        observed_points: graph.observed_points.clone(),
        springs: graph.springs.iter().filter(|s| (s[1] as usize) < n).copied().collect(),
        ..Graph::default()
    }
}

#[cfg(test)]
mod tests;
