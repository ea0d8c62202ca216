//! Contact of the skin with the ground and colliders: the distance at which a node touches a
//! surface, found once a frame, and its adjoint.
//!
//! Nodes are inside of the object that they stand for: with its nodes on the ground its skin would be
//! in it. With d the signed distance from a surface where the frame begins, and p the points of the
//! skin that a node at x bears (`Skin::bearers`), the node's clearance is
//!
//! ```text
//! r = max(0, max over p of d(x) - d(p))
//! ```
//!
//! and during the frame it meets that surface where its distance is r, by the same law as with
//! r = 0. So contact stays one of nodes with their own velocities: what rests does not move, what is
//! pressed does not creep, and a substep costs no more. Nodes that bear a point together stop
//! together, so that no node carries it further into the surface; what the others do within a frame
//! moves it by some tenths of a millimetre, which the next frame's r includes. Nothing pushes out
//! nodes nearer than r, so that clearances, which may jump from frame to frame, bring no energy in.
//!
//! The adjoint has the point that decides as fixed, as it has the nearest point of a target.

use bendtwin_core::geometry::Vector;

use super::meet::{Obstacle, SurfaceAdjoint, on_ground};
use crate::cpu::{
    arithmetic::{Node, Quad, Real, add, scale},
    surroundings::{Around, Surroundings, grasp::AroundAdjoint},
    system::System,
};

/// Marks a node without clearance.
const NONE: u32 = u32::MAX;

/// Clearances of a frame; empty where the nodes themselves touch.
#[derive(Clone, Debug, Default)]
pub(crate) struct Clearance<T> {
    nodes: usize,
    /// Distances to the ground, then to the obstacles in their order [m], shape [1 + obstacles, N].
    distances: Vec<T>,
    /// Point of the skin that decides, of the same shape.
    points: Vec<u32>,
}

/// d loss / d the clearances of a frame, shape [1 + obstacles, N] or empty.
#[derive(Clone, Debug, Default)]
pub(crate) struct ClearanceAdjoint<T> {
    nodes: usize,
    bars: Vec<T>,
}

/// The ground and the obstacles at the beginning of a frame.
pub(crate) struct Surfaces<'a, T> {
    system: &'a System<T>,
    of: Option<&'a Surroundings<T>>,
    obstacles: Vec<Obstacle<T>>,
}

impl<'a, T: Real> Surfaces<'a, T> {
    /// Surfaces around an object in a frame; obstacles only if the object has surroundings.
    pub(crate) fn new(
        system: &'a System<T>,
        around: Option<(&'a Surroundings<T>, &Around<T>)>,
    ) -> Self {
        // Without contact of the skin the obstacles are not needed.
        let asked = around.filter(|_| system.skin_contact);
        let obstacles = asked.map(|(of, around)| around.obstacles_at(of, T::ZERO).collect());
        Self { system, of: around.map(|(of, _)| of), obstacles: obstacles.unwrap_or_default() }
    }

    /// The ground (`None`) if there is one, and the obstacles.
    fn all(&self) -> impl Iterator<Item = Option<usize>> + use<T> {
        let ground = self.system.ground.is_some().then_some(None);
        ground.into_iter().chain((0..self.obstacles.len()).map(Some))
    }

    /// Signed distance from one of them.
    fn distance(&self, with: Option<usize>, x: Quad<T>) -> T {
        match (with, &self.system.ground, self.of) {
            (None, Some(ground), _) => on_ground(ground, x).distance,
            (Some(o), _, Some(of)) => {
                let obstacle = &self.obstacles[o];
                obstacle.surface(&of.colliders[obstacle.collider], x).distance
            }
            _ => T::ZERO,
        }
    }

    /// Adjoint of [`Self::distance`]: gives d loss / d x.
    fn distance_adjoint(
        &self,
        with: Option<usize>,
        x: Quad<T>,
        bar: T,
        around: &mut AroundAdjoint<T>,
    ) -> Quad<T> {
        let zero = [T::ZERO; 4];
        match (with, &self.system.ground, self.of) {
            (None, Some(ground), _) => scale(ground.normal, bar),
            (Some(o), _, Some(of)) => {
                let obstacle = &self.obstacles[o];
                let collider = &of.colliders[obstacle.collider];
                let surface = obstacle.surface(collider, x);
                let bar = SurfaceAdjoint { distance: bar, normal: zero, velocity: zero };
                obstacle.surface_adjoint(collider, x, &surface, bar, around)
            }
            _ => zero,
        }
    }
}

/// Place in a table of a node and the ground (`None`) or an obstacle.
#[inline(always)]
fn at(nodes: usize, with: Option<usize>, node: usize) -> usize {
    with.map_or(0, |o| o + 1) * nodes + node
}

/// A node's place in double precision, in which the skin is computed.
fn place<T: Real>(nodes: &[Node<T>], i: u32) -> Vector {
    let x = nodes[i as usize].x;
    std::array::from_fn(|c| x[c].to_f64())
}

/// A point of the skin.
fn point_of<T: Real>(system: &System<T>, nodes: &[Node<T>], p: usize) -> Quad<T> {
    let x = system.skin.position(p, |i| place(nodes, i));
    [T::from_f64(x[0]), T::from_f64(x[1]), T::from_f64(x[2]), T::ZERO]
}

impl<T: Real> Clearance<T> {
    /// True if nodes themselves touch.
    #[inline(always)]
    pub(crate) fn is_zero(&self) -> bool {
        self.distances.is_empty()
    }

    /// Clearance of a node to the ground (`None`) or to an obstacle.
    #[inline(always)]
    pub(crate) fn of(&self, with: Option<usize>, node: usize) -> T {
        if self.is_zero() { T::ZERO } else { self.distances[at(self.nodes, with, node)] }
    }

    /// Recomputes the clearances at the beginning of a frame.
    pub(crate) fn find(&mut self, surfaces: &Surfaces<'_, T>, nodes: &[Node<T>]) {
        let system = surfaces.system;
        self.distances.clear();
        self.points.clear();
        if !system.skin_contact || surfaces.all().next().is_none() {
            return;
        }
        self.nodes = system.nodes;
        let size = (1 + surfaces.obstacles.len()) * system.nodes;
        self.distances.resize(size, T::ZERO);
        self.points.resize(size, NONE);
        let skin = &system.skin;
        let points: Vec<Quad<T>> = (0..skin.len()).map(|p| point_of(system, nodes, p)).collect();
        for with in surfaces.all() {
            let of_nodes: Vec<T> =
                nodes[..system.nodes].iter().map(|n| surfaces.distance(with, n.x)).collect();
            for (p, &x) in points.iter().enumerate() {
                let of_point = surfaces.distance(with, x);
                for node in skin.bearers(p).map(|i| i as usize) {
                    let k = at(self.nodes, with, node);
                    if of_nodes[node] - of_point > self.distances[k] {
                        self.distances[k] = of_nodes[node] - of_point;
                        self.points[k] = p as u32;
                    }
                }
            }
        }
    }
}

impl<T: Real> ClearanceAdjoint<T> {
    /// Zero, of these clearances.
    pub(crate) fn clear(&mut self, of: &Clearance<T>) {
        self.nodes = of.nodes;
        self.bars.clear();
        self.bars.resize(of.distances.len(), T::ZERO);
    }

    /// Adds d loss / d a clearance.
    #[inline(always)]
    pub(crate) fn add(&mut self, with: Option<usize>, node: usize, bar: T) {
        if !self.bars.is_empty() {
            self.bars[at(self.nodes, with, node)] += bar;
        }
    }

    /// Adjoint of [`Clearance::find`], with the nodes' positions at the beginning of the frame:
    /// adds to d loss / d positions, and to the adjoint of the surroundings.
    pub(crate) fn find(
        &self,
        of: &Clearance<T>,
        surfaces: &Surfaces<'_, T>,
        nodes: &[Node<T>],
        bar: &mut [Node<T>],
        around: &mut AroundAdjoint<T>,
    ) {
        if self.bars.is_empty() {
            return;
        }
        let system = surfaces.system;
        for with in surfaces.all() {
            for node in 0..system.nodes {
                let k = at(self.nodes, with, node);
                let (own, p) = (self.bars[k], of.points[k]);
                if p == NONE || own == T::ZERO {
                    continue;
                }
                let p = p as usize;
                let by_node = surfaces.distance_adjoint(with, nodes[node].x, own, around);
                bar[node].x = add(bar[node].x, by_node);
                let x = point_of(system, nodes, p);
                let by_point = surfaces.distance_adjoint(with, x, -own, around);
                let by_point = std::array::from_fn(|c| by_point[c].to_f64());
                system.skin.add_gradient(
                    p,
                    |i| place(nodes, i),
                    by_point,
                    |i, by| {
                        let [x, y, z] = by.map(T::from_f64);
                        bar[i as usize].x = add(bar[i as usize].x, [x, y, z, T::ZERO]);
                    },
                );
            }
        }
    }
}
