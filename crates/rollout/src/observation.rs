//! Observations and options of a checked request as `bendtwin-register` takes them, and what it
//! finds as messages.

use bendtwin_contract::registration::{MAX_CAMERAS, MAX_POINTS};
use bendtwin_core::{Graph, Point, Skin};
use bendtwin_proto::v1::{self, Tensor, observation::Places, observation::Tracks};
use bendtwin_register::{
    self as register, CorrectOptions, Explained, Observation, Residual, Tracking, bind_tracks,
};

use crate::error::Error;

// The contract knows no physics, so it says once more what is possible.
const _: () = assert!(MAX_POINTS == register::MAX_POINTS as u64);
const _: () = assert!(MAX_CAMERAS == register::MAX_CAMERAS as u64);

/// Reads an observation of a twin with this graph.
pub(crate) fn read(wire: Option<v1::Observation>, graph: &Graph) -> Result<Observation, Error> {
    let wire = wire.unwrap_or_default();
    let tracks = match wire.tracks {
        None => None,
        Some(Tracks::Nodes(nodes)) => {
            let (_, nodes) = nodes.unpack::<u32>("observation.nodes")?;
            Some(Skin::at_nodes(&nodes))
        }
        Some(Tracks::Places(places)) => Some(tracks(places, graph)?),
    };
    let weights = match wire.weights.filter(|t| !t.is_absent()) {
        None => Vec::new(),
        Some(weights) => weights.unpack("observation.weights")?.1,
    };
    Ok(Observation {
        points: points(wire.points, "observation.points")?,
        tracks,
        weights,
        velocities: points(wire.velocities, "observation.velocities")?,
        cameras: points(wire.cameras, "observation.cameras")?,
    })
}

/// Places between nodes, bound where the message says or at rest.
fn tracks(places: Places, graph: &Graph) -> Result<Skin, Error> {
    let at = points(places.points, "observation.places.points")?;
    let nodes = points(places.node_positions, "observation.places.node_positions")?;
    let nodes = if nodes.is_empty() { &graph.rest_positions } else { &nodes };
    bind_tracks(graph, nodes, &at)
        .ok_or_else(|| Error::field("observation.places", "cannot be bound: the twin has no nodes"))
}

/// Points of a tensor that may be absent [m], shape [M, 3].
pub(crate) fn points(tensor: Option<Tensor>, field: &str) -> Result<Vec<Point>, Error> {
    match tensor.filter(|t| !t.is_absent()) {
        None => Ok(Vec::new()),
        Some(tensor) => Ok(tensor.unpack_points(field)?.1),
    }
}

/// Options of a correction.
pub(crate) fn correct_options(wire: Option<v1::CorrectOptions>) -> CorrectOptions {
    let wire = wire.unwrap_or_default();
    let mut options = CorrectOptions::default();
    let given = [
        (&mut options.noise_m, wire.noise_m),
        (&mut options.give, wire.give),
        (&mut options.velocity_noise_m_s, wire.velocity_noise_m_s),
        (&mut options.velocity_gain_per_s, wire.velocity_gain_per_s),
        (&mut options.most_added_strain, wire.most_added_strain),
    ];
    for (option, given) in given {
        *option = given.unwrap_or(*option);
    }
    options.max_residual_m = wire.max_residual_m;
    options
}

/// Distances as a message.
pub(crate) fn residual(of: Residual) -> v1::Residual {
    let Residual { median_mm, mean_mm, p95_mm } = of;
    v1::Residual { median_mm, mean_mm, p95_mm }
}

/// A record as a message.
pub(crate) fn tracking(of: Tracking) -> v1::Tracking {
    let Tracking { misfit, unexplained } = of;
    v1::Tracking { lost: of.is_lost(), misfit, unexplained }
}

/// Shares as a message.
pub(crate) fn explained(of: Explained) -> v1::Explained {
    let Explained { points, surface, within_mm } = of;
    v1::Explained { points, surface, within_mm }
}
