//! Contact between nodes by impulses: candidates once a frame, impulses every
//! substep, and their adjoint. A node takes the mean of its pairs' impulses, all computed from the
//! velocities before contact, so the order of pairs does not matter.
//!
//! Two nodes nearer than the collision distance hit if they approach each other. Those that are at
//! least that far apart at rest are also pushed out of each other, as by a collider: a mean of
//! impulses stops several partners only in part, and what lies on others would sink into them. Nodes
//! of one piece of material may be nearer at rest, and are not pushed.

use super::impulse::{Approach, Contact, Law};
use crate::{
    constants::MAX_PARTNERS,
    cpu::{
        arithmetic::{Node, Quad, Real, add, add_scaled, dot, scale, sub},
        system::{ContactRule, System},
    },
};

/// Nodes that each node may touch during a frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct Candidates {
    starts: Vec<u32>,
    partners: Vec<u32>,
}

impl Candidates {
    /// True if no nodes can touch.
    pub(crate) fn is_empty(&self) -> bool {
        self.partners.is_empty()
    }

    #[inline(always)]
    fn of(&self, node: usize) -> &[u32] {
        &self.partners[self.starts[node] as usize..self.starts[node + 1] as usize]
    }

    /// Recomputes the candidates: nodes nearer than the collision distance plus what the fastest
    /// two can close within the frame (at least once, at most four times the collision distance).
    pub(crate) fn find<T: Real>(&mut self, system: &System<T>, nodes: &[Node<T>]) {
        self.starts.clear();
        self.partners.clear();
        let rule = system.contact;
        let nodes = &nodes[..system.nodes];
        let several = system.object_ids.windows(2).any(|w| w[0] != w[1]);
        if !((rule.between_objects && several) || rule.within_object) || rule.distance <= 0.0 {
            return;
        }
        let fastest = nodes.iter().map(|n| dot(n.v, n.v).to_f64()).fold(0.0, f64::max).sqrt();
        let travel = 2.0 * fastest * system.frame_s;
        let radius = rule.distance + travel.clamp(rule.distance, 4.0 * rule.distance);
        let grid = Grid::new(nodes, radius);
        let mut near = Vec::new();
        self.starts.push(0);
        for (a, node) in nodes.iter().enumerate() {
            near.clear();
            grid.visit(node, |b| {
                let r = sub(nodes[b as usize].x, node.x);
                let square = dot(r, r).to_f64();
                if square <= radius * radius && may_touch(system, rule, a as u32, b) {
                    near.push((square, b));
                }
            });
            if near.len() > MAX_PARTNERS {
                near.sort_unstable_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
                near.truncate(MAX_PARTNERS);
            }
            let first = self.partners.len();
            self.partners.extend(near.iter().map(|p| p.1));
            self.partners[first..].sort_unstable();
            self.starts.push(self.partners.len() as u32);
        }
    }
}

fn may_touch<T>(system: &System<T>, rule: ContactRule, a: u32, b: u32) -> bool {
    if a == b {
        return false;
    }
    if system.object_ids[a as usize] != system.object_ids[b as usize] {
        return rule.between_objects;
    }
    rule.within_object && system.joined.binary_search(&[a.min(b), a.max(b)]).is_err()
}

/// Nodes sorted by the cell of a cubic grid.
struct Grid {
    cells: Vec<([i64; 3], u32)>,
    size: f64,
}

impl Grid {
    fn new<T: Real>(nodes: &[Node<T>], size: f64) -> Self {
        let mut cells: Vec<_> =
            nodes.iter().enumerate().map(|(i, n)| (Self::cell(n, size), i as u32)).collect();
        cells.sort_unstable();
        Self { cells, size }
    }

    #[allow(clippy::cast_possible_truncation)]
    fn cell<T: Real>(node: &Node<T>, size: f64) -> [i64; 3] {
        // A saturating cast: far or non-finite nodes share the outermost cells.
        std::array::from_fn(|c| (node.x[c].to_f64() / size).floor().clamp(-1e15, 1e15) as i64)
    }

    /// Calls `visit` with every node in the 27 cells around `node`.
    fn visit<T: Real>(&self, node: &Node<T>, mut visit: impl FnMut(u32)) {
        let [x, y, z] = Self::cell(node, self.size);
        for dx in -1..=1 {
            for dy in -1..=1 {
                let (low, high) = ([x + dx, y + dy, z - 1], [x + dx, y + dy, z + 1]);
                let first = self.cells.partition_point(|(c, _)| *c < low);
                self.cells[first..].iter().take_while(|(c, _)| *c <= high).for_each(|c| visit(c.1));
            }
        }
    }
}

/// A touching pair as seen from its first node.
struct ContactPair<T> {
    /// Unit vector from the first to the second.
    normal: Quad<T>,
    distance: T,
    /// Distance by which they are farther apart than the collision distance; below zero.
    inside: T,
    /// Velocity of the second relative to the first.
    approach: Approach<T>,
    contact: Contact<T>,
    /// 1 / (1/m1 + 1/m2).
    mass: T,
}

#[inline(always)]
fn touch<T: Real>(
    system: &System<T>,
    law: Law<T>,
    nodes: &[Node<T>],
    velocities: &[Quad<T>],
    a: usize,
    b: usize,
) -> Option<ContactPair<T>> {
    let r = sub(nodes[b].x, nodes[a].x);
    let square = dot(r, r);
    let limit = T::from_f64(system.contact.distance);
    let inverse = system.inverse_mass[a] + system.inverse_mass[b];
    let is_near = square < limit * limit && square > T::from_f64(1e-24) && inverse > T::ZERO;
    if !is_near {
        return None;
    }
    let v = sub(velocities[b], velocities[a]);
    let hits = dot(r, v) < T::ZERO;
    let pushes = are_apart_at_rest(system, a, b);
    if !(hits | pushes) {
        return None;
    }
    let distance = square.sqrt();
    let normal = scale(r, T::ONE / distance);
    let approach = Approach { start: sub(nodes[b].v, nodes[a].v), now: v };
    let inside = distance - limit;
    let contact = Contact::new(law, approach, normal, hits, pushes.then_some(inside));
    let mass = T::ONE / inverse;
    contact.acts().then_some(ContactPair { normal, distance, inside, approach, contact, mass })
}

/// True if two nodes do not touch in the rest shape.
#[inline(always)]
fn are_apart_at_rest<T: Real>(system: &System<T>, a: usize, b: usize) -> bool {
    let r = sub(system.rest[b], system.rest[a]);
    let limit = T::from_f64(system.contact.distance);
    dot(r, r) >= limit * limit
}

fn law<T: Real>(system: &System<T>) -> Law<T> {
    Law {
        restitution: system.parameters.object_restitution,
        friction: system.parameters.object_friction,
    }
}

/// Velocities after contact from those `before` it.
#[inline(always)]
pub(crate) fn collide<T: Real>(
    system: &System<T>,
    candidates: &Candidates,
    nodes: &[Node<T>],
    before: &[Quad<T>],
    after: &mut [Quad<T>],
) {
    let law = law(system);
    for (a, out) in after.iter_mut().enumerate().take(system.nodes) {
        let (mut sum, mut count) = ([T::ZERO; 4], T::ZERO);
        for &b in candidates.of(a) {
            if let Some(t) = touch(system, law, nodes, before, a, b as usize) {
                sum = add_scaled(sum, t.mass, t.contact.change);
                count += T::ONE;
            }
        }
        *out = before[a];
        if count > T::ZERO {
            *out = add_scaled(*out, -(system.inverse_mass[a] / count), sum);
        }
    }
}

/// Adjoint of [`collide`]: turns d loss / d velocity after contact in `bar` into that before it,
/// `after` is scratch; adds to the positions' adjoints, to those of the velocities at the substep's
/// start, shape [N], and to `law_bar`.
#[inline(always)]
pub(crate) fn collide_adjoint<T: Real>(
    system: &System<T>,
    candidates: &Candidates,
    nodes: &[Node<T>],
    before: &[Quad<T>],
    (bar, start_bar): (&mut [Node<T>], &mut [Quad<T>]),
    after: &mut [Quad<T>],
    law_bar: &mut Law<T>,
) {
    let law = law(system);
    for (out, b) in after.iter_mut().zip(&*bar) {
        *out = b.v;
    }
    for a in 0..system.nodes {
        let partners = candidates.of(a);
        let touches = |b: &&u32| touch(system, law, nodes, before, a, **b as usize).is_some();
        let count = partners.iter().filter(touches).count();
        if count == 0 {
            continue;
        }
        let share = -(system.inverse_mass[a] / T::from_f64(count as f64));
        for &b in partners {
            let b = b as usize;
            let Some(t) = touch(system, law, nodes, before, a, b) else { continue };
            let change_bar = scale(after[a], share * t.mass);
            let g = t.contact.adjoint(law, t.approach, t.normal, t.inside, change_bar);
            law_bar.add(&g);
            let flat = add_scaled(g.normal, -dot(g.normal, t.normal), t.normal);
            let r_bar = add_scaled(scale(flat, T::ONE / t.distance), g.distance, t.normal);
            bar[a].x = sub(bar[a].x, r_bar);
            bar[b].x = add(bar[b].x, r_bar);
            bar[a].v = sub(bar[a].v, g.v);
            bar[b].v = add(bar[b].v, g.v);
            start_bar[a] = sub(start_bar[a], g.start);
            start_bar[b] = add(start_bar[b], g.start);
        }
    }
}
