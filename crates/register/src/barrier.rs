//! The barrier between nodes and obstacles: no step of a deformation takes a node into one, or through
//! one to its other side.
//!
//! Obstacles are convex. Between a node outside and an obstacle is a plane, that of the obstacle's
//! surface which is nearest to the node. A deformation that would cross the obstacle on the straight
//! way from there ends on the node's side of that plane, so that a node, against any pull of the
//! points, stays on the side where it was before.

mod solid;

use bendtwin_core::{
    Plane, Point,
    geometry::{point, vector3},
};
use bendtwin_engine::{Model, model::State};
use nalgebra::{Matrix3, Vector3};

use self::solid::Solid;
use crate::{Around, correct::fixed};

/// Distance that nodes keep from surfaces, well above the rounding of a position [m].
pub(crate) const CLEARANCE_M: f64 = 1e-5;
/// Sweeps over planes, and over obstacles, that are in each other's way.
const SWEEPS: usize = 20;
/// Part of a normal that another plane has to leave so that it also bounds a node.
const LEAST_NEW: f64 = 1e-2;

/// Takes the nodes of a state out of the ground and of what is around it, along the normal; pinned
/// ones stay.
pub fn leave_obstacles(model: &Model, around: &Around, state: &mut State) {
    let passes = fixed(&model.graph, &around.loose);
    let mut x: Vec<Vector3<f64>> = state.positions.iter().map(|p| vector3(*p)).collect();
    if Barrier::new(model.environment.ground, around, passes).leave(&mut x).is_some() {
        state.positions = x.into_iter().map(point).collect();
    }
}

/// Obstacles of nodes.
#[derive(Debug, Default)]
pub(crate) struct Barrier {
    solids: Vec<Solid>,
    /// Upwards, for nodes that no single surface is the way out for.
    up: Vector3<f64>,
    /// Endpoints that may pass, shape [N + C]: held nodes and control points.
    passes: Vec<bool>,
}

/// Nodes that a deformation starts with, outside of all obstacles.
#[derive(Debug)]
pub(crate) struct Outside<'b> {
    barrier: &'b Barrier,
    /// Positions of all endpoints [m], shape [N + C].
    pub(crate) from: Vec<Vector3<f64>>,
    /// Planes that nodes are on at present.
    pub(crate) contacts: Contacts,
}

/// Planes that nodes are on in a step.
#[derive(Debug, Default)]
pub(crate) struct Contacts(Vec<Contact>);

#[derive(Debug)]
struct Contact {
    node: usize,
    planes: Vec<(Vector3<f64>, f64)>,
    /// Projection onto the directions that the planes leave.
    free: Matrix3<f64>,
}

impl Barrier {
    /// The ground and obstacles, for endpoints that do not pass.
    pub(crate) fn new(ground: Option<Plane>, around: &Around, passes: Vec<bool>) -> Self {
        let up = ground.map_or(Vector3::z(), |g| vector3(g.normal));
        let solids = ground.map(Solid::ground).into_iter();
        let solids = solids.chain(around.obstacles.iter().map(Solid::new)).collect();
        Self { solids, up, passes }
    }

    fn nodes(&self) -> impl Iterator<Item = usize> + '_ {
        let all = if self.solids.is_empty() { 0 } else { self.passes.len() };
        (0..all).filter(|e| !self.passes[*e])
    }

    fn is_free(&self, x: Vector3<f64>) -> bool {
        self.solids.iter().all(|s| s.surface(x).0 >= 0.5 * CLEARANCE_M)
    }

    /// Depth of a point below the surface that it is farthest below; 0 outside [m].
    fn depth(&self, x: Vector3<f64>) -> f64 {
        self.solids.iter().map(|s| -s.surface(x).0).fold(0.0, f64::max)
    }

    /// Mean depth of the nodes [m].
    pub(crate) fn mean_depth(&self, x: &[Vector3<f64>]) -> f64 {
        let (sum, n) = self.nodes().fold((0.0, 0), |(s, n), e| (s + self.depth(x[e]), n + 1));
        sum / f64::from(n.max(1))
    }

    /// Takes nodes out of the obstacles that they are in, along the normal; where a deformation starts
    /// then, `None` if nothing is in its way.
    pub(crate) fn leave(&self, x: &mut [Vector3<f64>]) -> Option<Outside<'_>> {
        for e in self.nodes() {
            if !self.is_free(x[e]) {
                x[e] = self.exit(x[e]);
            }
        }
        (!self.solids.is_empty()).then(|| Outside {
            barrier: self,
            from: x.to_vec(),
            contacts: Contacts::default(),
        })
    }

    /// The nearest place outside along a normal of what a node is in; where obstacles overlap, upwards.
    fn exit(&self, x: Vector3<f64>) -> Vector3<f64> {
        let inside = self.solids.iter().filter(|s| s.surface(x).0 < CLEARANCE_M);
        let exits = inside.flat_map(|s| s.exits(x)).filter(|place| self.is_free(*place));
        let nearest = exits.min_by(|a, b| (a - x).norm().total_cmp(&(b - x).norm()));
        nearest.unwrap_or_else(|| {
            let mut x = x;
            // From one into the next above it, if need be.
            for _ in 0..=self.solids.len() {
                let rise = self.solids.iter().map(|s| s.rise(x, self.up)).fold(0.0, f64::max);
                x += self.up * rise;
                if self.is_free(x) {
                    break;
                }
            }
            x
        })
    }

    /// Takes the part of the velocities away that goes into what nodes touch.
    pub(crate) fn stop(&self, x: &[Vector3<f64>], velocities: &mut [Point]) {
        let n = velocities.len();
        for e in self.nodes().filter(|e| *e < n) {
            let touched: Vec<&Solid> =
                self.solids.iter().filter(|s| s.surface(x[e]).0 < 2.0 * CLEARANCE_M).collect();
            if touched.is_empty() {
                continue;
            }
            let mut v = vector3(velocities[e]);
            for _ in 0..SWEEPS {
                for solid in &touched {
                    let normal = solid.surface(x[e]).1;
                    v -= normal * (v - solid.velocity(x[e])).dot(&normal).min(0.0);
                }
            }
            if v != vector3(velocities[e]) {
                velocities[e] = point(v);
            }
        }
    }
}

impl Outside<'_> {
    /// Adds the planes of what nodes meet on their way; true if there were such planes.
    pub(crate) fn meet(&mut self, to: &[Vector3<f64>]) -> bool {
        let mut found = false;
        for e in self.barrier.nodes() {
            let from = self.from[e];
            for solid in self.barrier.solids.iter().filter(|s| s.is_hit(from, to[e])) {
                found |= self.contacts.add(e, solid.plane(from));
            }
        }
        found
    }

    /// Ends ways that meet something beside it, or where they began.
    pub(crate) fn keep(&self, to: &mut [Vector3<f64>]) {
        let solids = &self.barrier.solids;
        for e in self.barrier.nodes() {
            let from = self.from[e];
            let is_hit = |to| solids.iter().any(|s| s.is_hit(from, to));
            if !is_hit(to[e]) {
                continue;
            }
            let mut beside = to[e];
            for _ in 0..SWEEPS {
                for solid in solids {
                    if solid.is_hit(from, beside) {
                        let (normal, offset) = solid.plane(from);
                        beside += normal * (offset - normal.dot(&beside)).max(0.0);
                    }
                }
            }
            to[e] = if is_hit(beside) { from } else { beside };
        }
    }
}

impl Contacts {
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// True unless the node has such a plane already.
    fn add(&mut self, node: usize, plane: (Vector3<f64>, f64)) -> bool {
        let at = self.0.partition_point(|c| c.node < node);
        if self.0.get(at).is_none_or(|c| c.node != node) {
            self.0.insert(at, Contact { node, planes: Vec::new(), free: Matrix3::identity() });
        }
        let contact = &mut self.0[at];
        let is_new = (contact.free * plane.0).norm() > LEAST_NEW;
        if is_new {
            contact.planes.push(plane);
            contact.project();
        }
        is_new
    }

    /// Puts nodes on their planes.
    pub(crate) fn place(&self, x: &mut [Vector3<f64>]) {
        for contact in &self.0 {
            for _ in 0..if contact.planes.len() > 1 { SWEEPS } else { 1 } {
                for (normal, offset) in &contact.planes {
                    x[contact.node] += normal * (offset - normal.dot(&x[contact.node]));
                }
            }
        }
    }

    /// Takes the part of vectors away that leads off the planes.
    pub(crate) fn project(&self, v: &mut [Vector3<f64>]) {
        for contact in &self.0 {
            v[contact.node] = contact.free * v[contact.node];
        }
    }

    /// Drops the planes that nodes are pulled away from; true if there were such planes.
    pub(crate) fn release(&mut self, pull: &[Vector3<f64>]) -> bool {
        let mut released = false;
        for contact in &mut self.0 {
            let before = contact.planes.len();
            contact.planes.retain(|(normal, _)| normal.dot(&pull[contact.node]) <= 0.0);
            if contact.planes.len() < before {
                contact.project();
                released = true;
            }
        }
        self.0.retain(|c| !c.planes.is_empty());
        released
    }
}

impl Contact {
    fn project(&mut self) {
        self.free = Matrix3::identity();
        for (normal, _) in &self.planes {
            let rest = self.free * normal;
            if rest.norm() > LEAST_NEW {
                let u = rest.normalize();
                self.free -= u * u.transpose();
            }
        }
    }
}

#[cfg(test)]
mod tests;
