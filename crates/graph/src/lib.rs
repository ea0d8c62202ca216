//! Graph building, from a capture to a graph: nodes are sampled once, springs and triplets are
//! built again for every candidate of a search. Everything here is deterministic: the same capture,
//! settings and seed give the same graph. No physics.
//!
//! [`sample_nodes`] decides which points become nodes, [`connect`] joins them,
//! [`rest_geometry`] measures their undeformed geometry.

mod components;
mod connect;
mod error;
mod order;
mod rest;
mod rods;
mod sample;
mod skin;
mod spread;
mod triplets;

use bendtwin_core::{
    NodeKind, Pin, Point,
    settings::{GraphSettings, TripletReference},
};

pub use self::{
    connect::{Notes, connect, connect_with_notes, hand_of_each, hold},
    error::Error,
    rest::rest_geometry,
    sample::sample_nodes,
    skin::{bind_points, bind_skin},
    spread::{farthest_points, mean_spacing},
};

/// Spring radius at full sampling where settings leave it open [m].
const RADIUS_M: f64 = 0.02;
/// Most springs that a node opens where settings leave it open.
const MAX_NEIGHBOURS: usize = 12;
/// Spring radius over the distance of the capture's points to their sixth neighbours, where
/// settings leave it open: enough for thirty neighbours at the surface of a body.
const RADIUS_SPACINGS: f64 = 3.0;
/// Bounds of that radius [m].
const LEAST_RADIUS_M: f64 = 1e-5;
const MOST_RADIUS_M: f64 = 10.0;
/// Springs whose rest length would be shorter than this are left out [m].
pub const MIN_REST_LENGTH_M: f32 = 1e-4;

/// The nodes of a graph before they are joined.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeSample {
    /// Positions at the start frame of the first sequence [m], shape [N, 3].
    pub positions: Vec<Point>,
    /// Kind of each node, shape [N]; non-decreasing.
    pub kinds: Vec<NodeKind>,
    /// Tracked point of each node, or [`bendtwin_core::Graph::NOT_OBSERVED`], shape [N].
    pub observed_points: Vec<u32>,
    /// Object of each node, shape [N].
    pub object_ids: Vec<u32>,
    /// Control points at the start frame [m], shape [C, 3].
    pub control_rest: Vec<Point>,
    /// Nodes that control points prescribe.
    pub pins: Vec<Pin>,
    /// Known topology as pairs of nodes (a cable's); `None` means that springs are found by radius.
    pub edges: Option<Vec<[u32; 2]>>,
    /// Undeformed positions [m], shape [N, 3], where they are not [`NodeSample::positions`].
    pub rest_shape: Option<Vec<Point>>,
    /// Mean distance of all points to their sixth neighbours [m].
    pub point_spacing_m: f64,
    /// Mean spacing of the nodes over that of all points, at least 1: what radii are multiplied by.
    /// 1 where settings fix the radius.
    pub spacing_scale: f64,
    /// All points of the surface, nodes or not.
    pub surface: SurfacePoints,
    /// Points that could not become nodes.
    pub left_out: LeftOut,
}

/// Points of a capture's surface at the start frame of its first sequence: observed ones, then the
/// completed surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfacePoints {
    /// Positions [m], shape [M, 3].
    pub positions: Vec<Point>,
    /// Observed point of each, or [`bendtwin_core::Graph::NOT_OBSERVED`], shape [M].
    pub observed_points: Vec<u32>,
}

impl NodeSample {
    /// Number of nodes N.
    pub fn node_count(&self) -> usize {
        self.positions.len()
    }

    /// Spring radius at full sampling [m]: that of the settings, or one that suits the spacing of the
    /// points.
    pub fn radius_m(&self, settings: &GraphSettings) -> f64 {
        let suited = RADIUS_SPACINGS * self.point_spacing_m;
        settings.radius_m.unwrap_or(suited.clamp(LEAST_RADIUS_M, MOST_RADIUS_M))
    }

    /// Positions of the undeformed object [m], shape [N, 3].
    pub fn undeformed(&self) -> &[Point] {
        self.rest_shape.as_deref().unwrap_or(&self.positions)
    }
}

/// Numbers of points of the capture that could not become nodes, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LeftOut {
    /// Position at the start frame is not a finite number.
    pub not_finite: usize,
    /// Seen in no frame of any sequence.
    pub never_visible: usize,
    /// Seen later, but not at the start frame: where they started is a guess.
    pub hidden_at_start: usize,
    /// In the place of another node, which no spring would join to them.
    pub coincident: usize,
}

impl LeftOut {
    /// All of them.
    pub fn total(&self) -> usize {
        self.not_finite + self.never_visible + self.hidden_at_start + self.coincident
    }
}

/// Connections between nodes: the topology variables of a fit's search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Connectivity {
    /// Spring radius at full sampling [m].
    pub radius_m: f64,
    /// Most springs that a node opens.
    pub max_neighbours: usize,
    /// Radius of control springs [m].
    pub control_radius_m: f64,
    /// Most springs that a control point opens; 0 means no control springs.
    pub control_neighbours: usize,
    /// Bending triplets, if any.
    pub triplets: Option<Triplets>,
    /// Rods that twist between two clamps of a cable with known edges.
    pub rods: bool,
}

/// Choice of triplets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Triplets {
    /// Most triplets with the same centre.
    pub max_per_node: usize,
    /// Pairs of neighbours that form them.
    pub reference: TripletReference,
}

impl Connectivity {
    /// The settings' own values; without `bending`, without triplets and rods.
    pub fn from_settings(settings: &GraphSettings, bending: bool) -> Self {
        Self {
            radius_m: settings.radius_m.unwrap_or(RADIUS_M),
            max_neighbours: settings.max_neighbours.unwrap_or(MAX_NEIGHBOURS),
            control_radius_m: settings.control_radius_m,
            control_neighbours: settings.control_neighbours,
            triplets: (bending && settings.max_triplets > 0).then_some(Triplets {
                max_per_node: settings.max_triplets,
                reference: settings.triplet_reference,
            }),
            rods: bending && settings.twist,
        }
    }
}

#[cfg(test)]
mod tests;
