//! A model in the form that the substep loop uses: elements in blocks sorted
//! for locality, parameters combined with rest geometry, everything that is
//! constant over a rollout computed once.

use std::sync::{Arc, OnceLock};

use bendtwin_core::{Graph, Skin, environment::ControlVelocity};

use super::{
    arithmetic::{Quad, Real, quad},
    elements::{OwnedElement, Rods, Span, Spring, Springs, Strips, Triplet, Triplets, strips},
    parameters::Parameters,
};
use crate::Model;

/// The part of a system that depends on the graph only; shared by all parameter sets on it.
#[derive(Debug, Default)]
pub(crate) struct Layout {
    spring_order: Arc<Strips>,
    triplet_order: Arc<Strips>,
    /// Sorted node pairs that a spring joins; built at the first use by self contact.
    joined: OnceLock<Vec<[u32; 2]>>,
}

impl Layout {
    /// Orders the elements.
    pub(crate) fn new(graph: &Graph) -> Self {
        let endpoints = graph.node_count() + graph.control_count();
        let springs = strips::share(&graph.springs, endpoints);
        let centred = |(element, &[i, j, k]): (usize, &[u32; 3])| OwnedElement {
            owner: j,
            others: [i, k],
            element: element as u32,
        };
        let triplets = graph.triplets.iter().enumerate().map(centred).collect();
        Self {
            spring_order: Arc::new(Strips::new(springs, endpoints)),
            triplet_order: Arc::new(Strips::new(triplets, endpoints)),
            joined: OnceLock::new(),
        }
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

impl<T: Real> Ground<T> {
    /// The ground for a node that touches it at a distance.
    #[inline(always)]
    pub(crate) fn raised(self, by: T) -> Self {
        Self { offset: self.offset + by, ..self }
    }
}

/// A node that a control point prescribes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PinnedNode<T> {
    pub(crate) node: usize,
    pub(crate) control: usize,
    pub(crate) offset: Quad<T>,
}

/// The pairs of nodes that may touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactRule {
    pub(crate) distance: f64,
    pub(crate) between_objects: bool,
    pub(crate) within_object: bool,
}

/// A model ready to run.
#[derive(Clone, Debug)]
pub(crate) struct System<T> {
    /// Nodes N.
    pub(crate) nodes: usize,
    /// Control points C.
    pub(crate) controls: usize,
    /// Surface nodes; they come first.
    pub(crate) surface: usize,
    /// Surface points that nodes carry.
    pub(crate) skin: Arc<Skin>,
    /// Ground and colliders meet the skin.
    pub(crate) skin_contact: bool,
    pub(crate) masses: Vec<T>,
    /// 1/m, zero where pinned.
    pub(crate) inverse_mass: Vec<T>,
    pub(crate) springs: Springs<T>,
    pub(crate) triplets: Triplets<T>,
    pub(crate) rods: Rods<T>,
    pub(crate) parameters: Parameters<T>,
    spring_order: Arc<Strips>,
    triplet_order: Arc<Strips>,
    pub(crate) pins: Vec<PinnedNode<T>>,
    pub(crate) gravity: Quad<T>,
    pub(crate) ground: Option<Ground<T>>,
    pub(crate) contact: ContactRule,
    /// Positions at rest [m], shape [N].
    pub(crate) rest: Vec<Quad<T>>,
    pub(crate) object_ids: Vec<u32>,
    /// Pairs exempt from self contact, sorted; empty if self contact is off.
    pub(crate) joined: Vec<[u32; 2]>,
    pub(crate) dt: T,
    /// Length of a frame [s].
    pub(crate) frame_s: f64,
    pub(crate) substeps: usize,
    /// exp(-dt drag).
    pub(crate) decay: T,
    /// True if control points have a velocity.
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
            skin: model.skin.clone(),
            skin_contact: contact.skin && !model.skin.is_empty(),
            masses,
            inverse_mass,
            springs: springs(graph, &layout.spring_order, &parameters),
            triplets: triplets(graph, &layout.triplet_order, &parameters),
            rods: rods(graph, &parameters),
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
            rest: graph.rest_positions.iter().map(|&x| quad(x)).collect(),
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

    /// The system while hands hold what they do: springs and triplets at open control points, shape
    /// [C], exert nothing and their pins hold nothing; nodes held by pins have no inverse mass; rods
    /// twist within `spans`, shape [R], or as a whole without any.
    pub(crate) fn while_held(&self, open: &[bool], held: &[usize], spans: &[Span]) -> Self {
        let mut system = self.clone();
        let is_open = |e: u32| {
            let control = (e as usize).checked_sub(self.nodes);
            control.is_some_and(|c| open.get(c).copied().unwrap_or(false))
        };
        for pin in self.pins.iter().filter(|p| open[p.control]) {
            system.inverse_mass[pin.node] = T::ONE / self.masses[pin.node];
        }
        system.pins.retain(|p| !open[p.control]);
        system.springs.leave_out(is_open);
        system.triplets.leave_out(is_open);
        held.iter().for_each(|&node| system.inverse_mass[node] = T::ZERO);
        if !self.rods.are_whole(spans) {
            system.rods = self.rods.within(spans);
        }
        system
    }

    /// Nodes and control points.
    pub(crate) fn endpoints(&self) -> usize {
        self.nodes + self.controls
    }

    /// The spring that stands in a lane of a block; `None` in a lane that only fills up.
    pub(crate) fn spring_at(&self, block: usize, lane: usize) -> Option<usize> {
        self.spring_order.at(block, lane)
    }

    /// The triplet that stands in a lane of a block; `None` in a lane that only fills up.
    pub(crate) fn triplet_at(&self, block: usize, lane: usize) -> Option<usize> {
        self.triplet_order.at(block, lane)
    }
}

fn springs<T: Real>(graph: &Graph, order: &Strips, p: &Parameters<T>) -> Springs<T> {
    Springs::new(order, |s| Spring {
        ends: graph.springs[s],
        stiffness: p.spring_stiffness[s],
        rest: p.rest_lengths_m[s],
        dashpot: p.spring_dashpot[s],
    })
}

fn triplets<T: Real>(graph: &Graph, order: &Strips, p: &Parameters<T>) -> Triplets<T> {
    Triplets::new(order, |t| Triplet {
        ends: graph.triplets[t],
        stiffness: p.bend_stiffness[t],
        damping: p.bend_damping[t],
        rest_angle: p.rest_angles_rad[t],
    })
}

fn rods<T: Real>(graph: &Graph, p: &Parameters<T>) -> Rods<T> {
    let has_arm = |rod: &[u32]| graph.has_arm(rod);
    Rods::new(
        &graph.rods,
        has_arm,
        |rod| graph.rod_shares(rod),
        |r| [p.twist_stiffness[r], p.twist_damping[r], p.rest_twists_rad[r]],
    )
}
