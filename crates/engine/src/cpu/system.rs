//! A model in the form that the substep loop wants: elements in blocks sorted
//! for locality, parameters combined with rest geometry, everything that is
//! constant over a rollout computed once.

use std::sync::OnceLock;

use bendtwin_core::{Graph, environment::ControlVelocity};

use super::{
    bend::{self, TripletBlock},
    lanes::LANES,
    parameters::Parameters,
    real::{Quad, Real, quad},
    spring::SpringBlock,
};
use crate::Model;

/// What depends on the graph only; shared by all parameter sets on it.
#[derive(Debug, Default)]
pub(crate) struct Layout {
    /// Springs in evaluation order.
    spring_order: Vec<u32>,
    /// Triplets in evaluation order.
    triplet_order: Vec<u32>,
    /// Sorted node pairs that a spring joins; made when self contact first asks for them.
    joined: OnceLock<Vec<[u32; 2]>>,
}

impl Layout {
    /// Orders the elements by endpoints, so that neighbours in memory are neighbours in the graph.
    pub(crate) fn new(graph: &Graph) -> Self {
        let mut spring_order: Vec<u32> = (0..graph.springs.len() as u32).collect();
        spring_order.sort_by_key(|&s| (graph.springs[s as usize], s));
        let mut triplet_order: Vec<u32> = (0..graph.triplets.len() as u32).collect();
        triplet_order.sort_by_key(|&t| {
            let [i, j, k] = graph.triplets[t as usize];
            (j, i, k, t)
        });
        Self { spring_order, triplet_order, joined: OnceLock::new() }
    }

    /// Sorted (smaller, larger) node pairs that a spring joins.
    pub(crate) fn joined(&self, graph: &Graph) -> &[[u32; 2]] {
        self.joined.get_or_init(|| {
            let mut pairs: Vec<[u32; 2]> =
                graph.springs.iter().map(|&[a, b]| [a.min(b), a.max(b)]).collect();
            pairs.sort_unstable();
            pairs.dedup();
            pairs
        })
    }
}

/// A plane in the simulation's scalar.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ground<T> {
    pub(crate) normal: Quad<T>,
    pub(crate) offset: T,
}

/// A node that a control point prescribes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PinnedNode<T> {
    pub(crate) node: usize,
    pub(crate) control: usize,
    pub(crate) offset: Quad<T>,
}

/// Which pairs of nodes may touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactRule {
    pub(crate) distance: f64,
    pub(crate) between_objects: bool,
    pub(crate) within_object: bool,
}

/// A model ready to run.
#[derive(Debug)]
pub(crate) struct System<T> {
    /// Nodes N.
    pub(crate) nodes: usize,
    /// Control points C.
    pub(crate) controls: usize,
    /// Surface nodes; they come first.
    pub(crate) surface: usize,
    pub(crate) masses: Vec<T>,
    /// 1/m, zero where pinned.
    pub(crate) inverse_mass: Vec<T>,
    pub(crate) springs: Vec<SpringBlock<T>>,
    pub(crate) triplets: Vec<TripletBlock<T>>,
    pub(crate) parameters: Parameters<T>,
    spring_order: Vec<u32>,
    triplet_order: Vec<u32>,
    pub(crate) pins: Vec<PinnedNode<T>>,
    pub(crate) gravity: Quad<T>,
    pub(crate) ground: Option<Ground<T>>,
    pub(crate) contact: ContactRule,
    pub(crate) object_ids: Vec<u32>,
    /// Pairs exempt from self contact, sorted; empty if self contact is off.
    pub(crate) joined: Vec<[u32; 2]>,
    pub(crate) dt: T,
    /// Length of a frame [s].
    pub(crate) frame_s: f64,
    pub(crate) substeps: usize,
    /// exp(-dt drag).
    pub(crate) decay: T,
    /// Whether control points have a velocity.
    pub(crate) controls_move: bool,
}

impl<T: Real> System<T> {
    /// Combines a checked model's graph with parameters that fit it.
    pub(crate) fn new(model: &Model, layout: &Layout, parameters: Parameters<T>) -> Self {
        let graph = &*model.graph;
        let masses: Vec<T> = graph.masses.iter().map(|&m| T::from_f32(m)).collect();
        let mut inverse_mass: Vec<T> = masses.iter().map(|&m| T::ONE / m).collect();
        for pin in &graph.pins {
            inverse_mass[pin.node as usize] = T::ZERO;
        }
        let contact = &model.params.contact;
        let dt = model.timing.dt_s();
        Self {
            nodes: graph.node_count(),
            controls: graph.control_count(),
            surface: graph.surface_count(),
            masses,
            inverse_mass,
            springs: spring_blocks(graph, &layout.spring_order, &parameters),
            triplets: triplet_blocks(graph, &layout.triplet_order, &parameters),
            spring_order: layout.spring_order.clone(),
            triplet_order: layout.triplet_order.clone(),
            pins: graph
                .pins
                .iter()
                .map(|p| PinnedNode {
                    node: p.node as usize,
                    control: p.control as usize,
                    offset: quad(p.offset_m),
                })
                .collect(),
            gravity: quad(model.environment.gravity),
            ground: model
                .environment
                .ground
                .map(|g| Ground { normal: quad(g.normal), offset: T::from_f32(g.offset_m) }),
            contact: ContactRule {
                distance: f64::from(contact.collision_distance_m),
                between_objects: contact.between_objects,
                within_object: contact.within_object,
            },
            object_ids: graph.object_ids.clone(),
            joined: if contact.within_object { layout.joined(graph).to_vec() } else { Vec::new() },
            dt: T::from_f64(dt),
            frame_s: model.timing.frame_s(),
            substeps: model.timing.substeps as usize,
            decay: T::from_f64((-dt * parameters.drag.to_f64()).exp()),
            controls_move: model.control_velocity == ControlVelocity::True,
            parameters,
        }
    }

    /// Nodes and control points.
    pub(crate) fn endpoints(&self) -> usize {
        self.nodes + self.controls
    }

    /// The spring that stands in a lane of a block; `None` in a lane that only fills up.
    pub(crate) fn spring_at(&self, block: usize, lane: usize) -> Option<usize> {
        self.spring_order.get(block * LANES + lane).map(|&s| s as usize)
    }

    /// The triplet that stands in a lane of a block; `None` in a lane that only fills up.
    pub(crate) fn triplet_at(&self, block: usize, lane: usize) -> Option<usize> {
        self.triplet_order.get(block * LANES + lane).map(|&t| t as usize)
    }
}

fn spring_blocks<T: Real>(graph: &Graph, order: &[u32], p: &Parameters<T>) -> Vec<SpringBlock<T>> {
    let mut blocks = Vec::with_capacity(order.len().div_ceil(LANES));
    for chunk in order.chunks(LANES) {
        let mut block = SpringBlock::EMPTY;
        for (l, &s) in chunk.iter().enumerate() {
            let s = s as usize;
            [block.first[l], block.second[l]] = graph.springs[s];
            let rest = p.rest_lengths_m[s];
            let rate = p.spring_stiffness[s] / rest;
            block.rate[l] = rate.only_if(rest > T::ZERO && rate.is_finite());
            block.rest[l] = rest;
            block.dashpot[l] = p.spring_dashpot[s];
        }
        blocks.push(block);
    }
    blocks
}

fn triplet_blocks<T: Real>(
    graph: &Graph,
    order: &[u32],
    p: &Parameters<T>,
) -> Vec<TripletBlock<T>> {
    let mut blocks = Vec::with_capacity(order.len().div_ceil(LANES));
    for chunk in order.chunks(LANES) {
        let mut block = TripletBlock::EMPTY;
        for (l, &t) in chunk.iter().enumerate() {
            let t = t as usize;
            [block.i[l], block.j[l], block.k[l]] = graph.triplets[t];
            block.stiffness[l] = p.bend_stiffness[t];
            block.damping[l] = p.bend_damping[t];
            block.rest_bend[l] = bend::rest_bend(p.rest_angles_rad[t]);
        }
        blocks.push(block);
    }
    blocks
}
