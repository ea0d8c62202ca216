//! A model linearised at rest and normalised by mass: its elements in f64, what each weighs in a
//! vector, and where to start looking for its stiffest mode.

use crate::{
    Model, constants,
    cpu::elements::{bend, turned_pattern},
};

pub(super) type Vector = [f64; 3];

/// Twist from rest assumed for rods: a full turn.
const TWIST_RAD: f64 = std::f64::consts::TAU;

/// Stiffness and damping of a spring for a relative displacement.
pub(super) struct Bar {
    pub(super) ends: [u32; 2],
    /// Zero if all directions are equally stiff.
    pub(super) direction: Vector,
    pub(super) along: f64,
    pub(super) across: f64,
    pub(super) damping: f64,
}

/// Stiffness and damping of a triplet for one pattern of displacement.
pub(super) struct Hinge {
    pub(super) ends: [u32; 3],
    pub(super) pattern: [Vector; 3],
    pub(super) stiffness: f64,
    pub(super) damping: f64,
}

/// Stiffness and damping of a rod for one pattern of displacement of all its nodes.
pub(super) struct Twist {
    pub(super) ends: Vec<u32>,
    pub(super) pattern: Vec<Vector>,
    pub(super) stiffness: f64,
    pub(super) damping: f64,
}

impl Twist {
    /// Weight of the pattern, given the roots of its ends.
    pub(super) fn square(&self, roots: &[f64]) -> f64 {
        let parts = self.ends.iter().zip(&self.pattern);
        parts.map(|(&e, &g)| dot(g, g) * roots[e as usize].powi(2)).sum()
    }
}

/// The linearised, mass-normalised model.
pub(super) struct Linear {
    /// 1/sqrt(m) of every endpoint; zero where it is prescribed.
    pub(super) roots: Vec<f64>,
    pub(super) bars: Vec<Bar>,
    pub(super) hinges: Vec<Hinge>,
    pub(super) twists: Vec<Twist>,
}

impl Linear {
    /// Linearization of a model whose indices exist.
    pub(super) fn new(model: &Model) -> Self {
        let (graph, params) = (&*model.graph, &model.params);
        let mut roots: Vec<f64> =
            graph.masses.iter().map(|&m| f64::from(m).sqrt().recip()).collect();
        graph.pins.iter().for_each(|p| roots[p.node as usize] = 0.0);
        roots.resize(graph.node_count() + graph.control_count(), 0.0);
        let at = |e: u32| graph.rest_endpoint(e).map(f64::from);
        let arm = |a: u32, b: u32| -> Vector {
            let (a, b) = (at(a), at(b));
            std::array::from_fn(|c| b[c] - a[c])
        };
        let mut bars: Vec<Bar> = graph
            .springs
            .iter()
            .enumerate()
            .map(|(s, &[a, b])| {
                let [k, rest, damping] =
                    [&params.spring_stiffness, &params.rest_lengths_m, &params.spring_dashpot]
                        .map(|v| f64::from(v[s]));
                bar([a, b], arm(a, b), k, rest, damping)
            })
            .collect();
        let mut hinges = Vec::new();
        for (t, &[i, j, k]) in graph.triplets.iter().enumerate() {
            let [stiffness, damping, rest] =
                [&params.bend_stiffness, &params.bend_damping, &params.rest_angles_rad]
                    .map(|v| f64::from(v[t]));
            for pattern in bend_patterns(arm(j, i), arm(j, k), bend::rest_bend(rest)) {
                hinges.push(Hinge { ends: [i, j, k], pattern, stiffness, damping });
            }
        }
        let mut twists = Vec::with_capacity(graph.rods.len());
        for (r, rod) in graph.rods.iter().enumerate() {
            let [stiffness, damping, rest] =
                [&params.twist_stiffness, &params.twist_damping, &params.rest_twists_rad]
                    .map(|v| f64::from(v[r]));
            let points: Vec<Vector> = rod.iter().map(|&e| at(e)).collect();
            let torque = stiffness * (rest.abs() + TWIST_RAD);
            let edges = rod.iter().zip(&rod[1..]).zip(points.windows(2));
            bars.extend(edges.map(|((&a, &b), x)| slanted([a, b], x, torque)));
            let pattern = turned_pattern(&points, graph.has_arm(rod));
            twists.push(Twist { ends: rod.clone(), pattern, stiffness, damping });
        }
        Self { bars, roots, hinges, twists }
    }

    /// Stiffness and damping of every endpoint by itself, all others held and all springs in one
    /// line.
    fn alone(&self) -> Vec<(f64, f64)> {
        let mut alone = vec![(0.0, 0.0); self.roots.len()];
        for b in &self.bars {
            for e in b.ends.map(|e| e as usize) {
                alone[e].0 += b.along.max(b.across) * self.roots[e].powi(2);
                alone[e].1 += b.damping * self.roots[e].powi(2);
            }
        }
        for h in &self.hinges {
            for (e, g) in h.ends.into_iter().zip(h.pattern) {
                let square = dot(g, g) * self.roots[e as usize].powi(2);
                alone[e as usize].0 += h.stiffness * square;
                alone[e as usize].1 += h.damping * square;
            }
        }
        for t in &self.twists {
            for (&e, &g) in t.ends.iter().zip(&t.pattern) {
                let square = dot(g, g) * self.roots[e as usize].powi(2);
                alone[e as usize].0 += t.stiffness * square;
                alone[e as usize].1 += t.damping * square;
            }
        }
        alone
    }

    /// An arbitrary but reproducible vector with a share in every mode, larger where a node is
    /// stiffer by itself, so that a single stiff spot in a large soft body is found immediately;
    /// and the largest stable step of the stiffest such node [s], infinite if nothing is stiff.
    pub(super) fn start(&self) -> (Vec<Vector>, f64) {
        let alone = self.alone();
        let rates: Vec<f64> = alone.iter().map(|&(k, c)| largest_dt(k, c).recip()).collect();
        let most = rates.iter().fold(0.0_f64, |m, r| m.max(*r));
        let mut bits = 0x9e37_79b9_7f4a_7c15_u64;
        let mut next = || {
            bits ^= bits << 13;
            bits ^= bits >> 7;
            bits ^= bits << 17;
            (bits >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let mut v: Vec<Vector> = Vec::with_capacity(rates.len());
        for (&root, rate) in self.roots.iter().zip(rates) {
            let share = (rate / most.max(f64::MIN_POSITIVE)).powi(4).clamp(1e-4, 1.0);
            let share = if root > 0.0 { share } else { 0.0 };
            v.push([next(), next(), next()].map(|x| share * x));
        }
        (v, most.recip())
    }

    /// z*Kz and z*Cz, each over z*z.
    pub(super) fn quotients(&self, z: &[Vector]) -> (f64, f64) {
        let (mut stiff, mut damp) = (0.0, 0.0);
        let moved: Vec<Vector> =
            z.iter().zip(&self.roots).map(|(v, root)| v.map(|x| root * x)).collect();
        for b in &self.bars {
            let [p, q] = b.ends.map(|e| moved[e as usize]);
            let r: Vector = std::array::from_fn(|c| q[c] - p[c]);
            let along = dot(r, b.direction).powi(2);
            stiff += b.along * along + b.across * (dot(r, r) - along);
            damp += b.damping * along;
        }
        for h in &self.hinges {
            let parts = h.ends.into_iter().zip(h.pattern);
            let bent = parts.map(|(e, g)| dot(g, moved[e as usize])).sum::<f64>().powi(2);
            stiff += h.stiffness * bent;
            damp += h.damping * bent;
        }
        for t in &self.twists {
            let parts = t.ends.iter().zip(&t.pattern);
            let turned = parts.map(|(&e, &g)| dot(g, moved[e as usize])).sum::<f64>().powi(2);
            stiff += t.stiffness * turned;
            damp += t.damping * turned;
        }
        let square: f64 = z.iter().map(|&v| dot(v, v)).sum();
        if square > 0.0 { (stiff / square, damp / square) } else { (0.0, 0.0) }
    }
}

/// Largest stable step of a single mode, given its stiffness and damping.
pub(super) fn largest_dt(k: f64, c: f64) -> f64 {
    4.0 / (c + (c * c + 4.0 * k).sqrt())
}

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn bar(ends: [u32; 2], r: Vector, k: f64, rest: f64, damping: f64) -> Bar {
    let length = dot(r, r).sqrt();
    let along = if rest > 0.0 { k / rest } else { 0.0 };
    if length < 1e-9 {
        // It may turn into any direction.
        return Bar { ends, direction: [0.0; 3], along, across: along.max(damping), damping };
    }
    let across = (along * (length - rest) / length).max(0.0);
    Bar { ends, direction: r.map(|x| x / length), along, across, damping }
}

/// Destabilizing torque of a twisted rod, which tends to coil also where it is straight. In slopes
/// s of its edges (displacements over length) that is a torque times a sum of `s_j x s_(j+1)`,
/// which is never more than the sum of their squares.
fn slanted(ends: [u32; 2], x: &[Vector], torque: f64) -> Bar {
    let edge: Vector = std::array::from_fn(|c| x[1][c] - x[0][c]);
    let square = dot(edge, edge);
    let across = if square > constants::MIN_EDGE_M.powi(2) { torque / square } else { 0.0 };
    Bar { ends, direction: [0.0; 3], along: across, across, damping: 0.0 }
}

/// Gradients of the angle with respect to the three ends: one, or where the rest shape is straight
/// the two across.
fn bend_patterns(u: Vector, w: Vector, rest_bend: f64) -> Vec<[Vector; 3]> {
    let (lu, lw) = (dot(u, u).sqrt(), dot(w, w).sqrt());
    if lu.min(lw) < 1e-6 {
        return Vec::new();
    }
    let cosine = dot(u, w) / (lu * lw);
    let n = cross(u, w);
    let sine = dot(n, n).sqrt() / (lu * lw);
    let pattern = |across_u: Vector, across_w: Vector| {
        let (gi, gk) = (across_u.map(|x| -x / lu), across_w.map(|x| -x / lw));
        [gi, std::array::from_fn(|c| -gi[c] - gk[c]), gk]
    };
    let collinear = sine < constants::MIN_SINE;
    let normal = if collinear { any_normal(u) } else { n.map(|x| x / (lu * lw * sine)) };
    // In the plane of the arms, away from the other arm; g = -across / length.
    let in_plane =
        |arm: Vector, length: f64, turn: f64| cross(normal, arm).map(|x| turn * x / length);
    let mut patterns = vec![pattern(in_plane(u, lu, 1.0), in_plane(w, lw, -1.0))];
    if collinear || rest_bend == 0.0 {
        patterns.push(pattern(normal, normal.map(|x| if cosine < 0.0 { x } else { -x })));
    }
    patterns
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn any_normal(u: Vector) -> Vector {
    let axis =
        if u[0].abs() < u[1].abs().max(u[2].abs()) { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let n = cross(u, axis);
    let length = dot(n, n).sqrt();
    n.map(|x| x / length)
}
