//! Elastic deformation by observed points, as rigid as possible.
//!
//! After Sorkine and Alexa, "As-rigid-as-possible surface modeling" (2007), on the twin's springs:
//! the sum over springs of k |(x_i - x_j) - (R_i + R_j)/2 (r_i - r_j)|², k = 1 / (give l)², plus the
//! sum over matches of w |Σ_p b_p Σ_i s_pi x_i - y|² / noise². r is the reference, R_i the rotation
//! of the springs around i, s_pi the weights of skin point p. Rotations and positions are solved for
//! in turn, positions by conjugate gradients. Nodes that would enter an obstacle are kept on its
//! surface (an active set: on it they may slide, and leave it where they are pulled away).

use bendtwin_core::{Graph, Skin};
use nalgebra::{Matrix3, Vector3};

use crate::barrier::{Contacts, Outside};

/// Springs count as at least this share of their mean length: short ones would hold like rods.
const LEAST_LENGTH: f64 = 0.5;
/// Deviation with which everything is drawn to where it is, for parts that nothing else holds [m].
const TETHER_M: f64 = 1.0;
/// Points of a skin that a match is between, at most: the corners of a triangle.
pub(crate) const CORNERS: usize = 3;
/// Iterations of conjugate gradients, at most, and the residual at which they end.
const ITERATIONS: usize = 150;
const TOLERANCE: f64 = 1e-5;
/// Solutions of a step, in each of which other nodes may be on surfaces.
const PASSES: usize = 5;

/// A place on the object that should be somewhere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Match {
    /// Points of the skin around the place.
    pub(crate) points: [u32; CORNERS],
    /// Their weights, which sum up to 1; 0 for no point.
    pub(crate) weights: [f64; CORNERS],
    /// The wanted combination of the nodes that carry the points, offsets left out [m].
    pub(crate) target: Vector3<f64>,
    /// 1 / variance [1/m²].
    pub(crate) precision: f64,
}

/// Places on a skin and where they should be.
#[derive(Clone, Debug)]
pub(crate) struct Matches<'a> {
    pub(crate) skin: &'a Skin,
    pub(crate) list: Vec<Match>,
}

impl Match {
    /// The points with their weights.
    pub(crate) fn corners(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let corners = self.points.iter().zip(&self.weights).filter(|(_, w)| **w != 0.0);
        corners.map(|(p, w)| (*p as usize, *w))
    }
}

impl Matches<'_> {
    /// Points of the skin that matches are on.
    fn used(&self) -> Vec<usize> {
        let mut used = vec![false; self.skin.len()];
        for (p, _) in self.list.iter().flat_map(Match::corners) {
            used[p] = true;
        }
        (0..used.len()).filter(|p| used[*p]).collect()
    }
}

/// A spring of the deformation, from a node to an endpoint.
#[derive(Clone, Copy, Debug)]
struct Edge {
    ends: [usize; 2],
    /// 1 / variance at a `give` of 1 [1/m²].
    precision: f64,
}

/// The deformation's springs and reference, for nodes and control points, N + C endpoints.
#[derive(Debug)]
pub(crate) struct Elastic {
    edges: Vec<Edge>,
    /// Reference positions [m], shape [N + C].
    reference: Vec<Vector3<f64>>,
    /// Endpoints that stay where they are, shape [N + C].
    pub(crate) fixed: Vec<bool>,
}

impl Elastic {
    /// The springs of a graph, without those to control points that are loose, with all endpoints at a
    /// reference.
    pub(crate) fn new(
        graph: &Graph,
        reference: Vec<Vector3<f64>>,
        fixed: Vec<bool>,
        loose: &[u32],
    ) -> Self {
        let n = graph.node_count();
        let is_held = |e: u32| {
            (e as usize).checked_sub(n).is_none_or(|c| !loose.iter().any(|l| *l as usize == c))
        };
        let ends = |s: &[u32; 2]| s.map(|e| e as usize);
        let length = |e: [usize; 2]| (reference[e[0]] - reference[e[1]]).norm();
        let count = graph.springs.len().max(1) as f64;
        let mean = graph.springs.iter().map(|s| length(ends(s))).sum::<f64>() / count;
        let least = (LEAST_LENGTH * mean).max(1e-6);
        // A node with many springs is not held more firmly than one of a chain.
        let share = (graph.node_count() as f64 / count).min(1.0);
        let edges = graph
            .springs
            .iter()
            .filter(|s| is_held(s[1]))
            .map(|s| {
                let ends = ends(s);
                Edge { ends, precision: share / length(ends).max(least).powi(2) }
            })
            .collect();
        Self { edges, reference, fixed }
    }

    /// Moves endpoints `x` towards the matches, and keeps them outside of obstacles; `give` is the deviation
    /// of a spring by its length.
    pub(crate) fn relax(
        &self,
        x: &mut [Vector3<f64>],
        matches: &Matches<'_>,
        give: f64,
        iterations: usize,
        mut outside: Option<&mut Outside<'_>>,
    ) {
        let scale = 1.0 / (give * give);
        for _ in 0..iterations {
            let rotations = self.rotations(x);
            let mut right = vec![Vector3::zeros(); x.len()];
            for edge in &self.edges {
                let [i, j] = edge.ends;
                let rest = self.reference[i] - self.reference[j];
                let turned = (rotations[i] + rotations[j]) * rest * (0.5 * scale * edge.precision);
                right[i] += turned;
                right[j] -= turned;
            }
            self.step(x, &mut right, matches, scale, outside.as_deref_mut());
        }
    }

    /// The solution, with nodes that meet something on its surface.
    fn step(
        &self,
        x: &mut [Vector3<f64>],
        right: &mut [Vector3<f64>],
        matches: &Matches<'_>,
        scale: f64,
        outside: Option<&mut Outside<'_>>,
    ) {
        let Some(outside) = outside else {
            self.solve(x, right, matches, scale, &Contacts::default());
            return;
        };
        for _ in 0..PASSES {
            outside.contacts.place(x);
            let pull = self.solve(x, &mut right.to_vec(), matches, scale, &outside.contacts);
            let released = outside.contacts.release(&pull);
            if !outside.meet(x) && !released {
                break;
            }
        }
        outside.keep(x);
    }

    /// The smooth field on all endpoints, zero where they are fixed, that fits matches of its
    /// values.
    pub(crate) fn field(&self, matches: &Matches<'_>, give: f64) -> Vec<Vector3<f64>> {
        let mut x = vec![Vector3::zeros(); self.reference.len()];
        let mut right = x.clone();
        let nothing = Contacts::default();
        self.solve(&mut x, &mut right, matches, 1.0 / (give * give), &nothing);
        x
    }

    /// Rotation of the springs around each endpoint since the reference.
    fn rotations(&self, x: &[Vector3<f64>]) -> Vec<Matrix3<f64>> {
        let mut covariance = vec![Matrix3::zeros(); x.len()];
        for edge in &self.edges {
            let [i, j] = edge.ends;
            let rest = self.reference[i] - self.reference[j];
            let both = (x[i] - x[j]) * rest.transpose() * edge.precision;
            covariance[i] += both;
            covariance[j] += both;
        }
        covariance.into_iter().map(nearest_rotation).collect()
    }

    /// Conjugate gradients for the positions of endpoints that are not fixed, starting at the
    /// current ones, those in contact on their planes. Returns the pull on the latter, empty
    /// without contacts.
    fn solve(
        &self,
        x: &mut [Vector3<f64>],
        right: &mut [Vector3<f64>],
        matches: &Matches<'_>,
        scale: f64,
        contacts: &Contacts,
    ) -> Vec<Vector3<f64>> {
        let tether = 1.0 / (TETHER_M * TETHER_M);
        let mut diagonal = vec![tether; x.len()];
        for edge in &self.edges {
            edge.ends.iter().for_each(|&e| diagonal[e] += scale * edge.precision);
        }
        let Matches { skin, list } = matches;
        let used = matches.used();
        // The pull on each point of the skin and the matches' precision there.
        let mut pulls = vec![Vector3::zeros(); skin.len()];
        let mut loads = vec![0.0; skin.len()];
        for m in list {
            for (p, b) in m.corners() {
                pulls[p] += m.target * (m.precision * b);
                loads[p] += m.precision * b;
            }
        }
        for &p in &used {
            for (n, w) in skin.weights_of(p) {
                let (n, w) = (n as usize, f64::from(w));
                right[n] += pulls[p] * w;
                diagonal[n] += loads[p] * w * w;
            }
        }
        for (b, x) in right.iter_mut().zip(&*x) {
            *b += x * tether;
        }
        let free = |e: usize| !self.fixed[e];
        let mut carried = pulls.clone();
        let mut apply = |v: &[Vector3<f64>], out: &mut [Vector3<f64>]| {
            for (o, v) in out.iter_mut().zip(v) {
                *o = v * tether;
            }
            for edge in &self.edges {
                let [i, j] = edge.ends;
                let d = (v[i] - v[j]) * (scale * edge.precision);
                out[i] += d;
                out[j] -= d;
            }
            for &p in &used {
                let weights = skin.weights_of(p);
                carried[p] = weights.map(|(n, w)| v[n as usize] * f64::from(w)).sum();
                pulls[p] = Vector3::zeros();
            }
            for m in list {
                let place: Vector3<f64> = m.corners().map(|(p, b)| carried[p] * b).sum();
                m.corners().for_each(|(p, b)| pulls[p] += place * (m.precision * b));
            }
            for &p in &used {
                for (n, w) in skin.weights_of(p) {
                    out[n as usize] += pulls[p] * f64::from(w);
                }
            }
        };
        // What is fixed acts on the rest through the residual alone: its direction stays zero.
        let bind = |v: &mut [Vector3<f64>]| {
            for (e, v) in v.iter_mut().enumerate() {
                if !free(e) {
                    *v = Vector3::zeros();
                }
            }
            contacts.project(v);
        };
        let mut product = vec![Vector3::zeros(); x.len()];
        apply(x, &mut product);
        let mut r: Vec<Vector3<f64>> = right.iter().zip(&product).map(|(b, p)| b - p).collect();
        bind(&mut r);
        let precondition = |r: &[Vector3<f64>], z: &mut [Vector3<f64>]| {
            for ((z, r), d) in z.iter_mut().zip(r).zip(&diagonal) {
                *z = r / *d;
            }
        };
        let mut z = r.clone();
        precondition(&r, &mut z);
        let mut direction = z.clone();
        let mut rho = dot(&r, &z);
        let goal = TOLERANCE * TOLERANCE * rho;
        for _ in 0..ITERATIONS {
            if !(rho > goal && rho > 1e-18) {
                break;
            }
            apply(&direction, &mut product);
            bind(&mut product);
            let curvature = dot(&direction, &product);
            if !(curvature.is_finite() && curvature > 0.0) {
                break;
            }
            let step = rho / curvature;
            for e in 0..x.len() {
                x[e] += direction[e] * step;
                r[e] -= product[e] * step;
            }
            precondition(&r, &mut z);
            let next = dot(&r, &z);
            let ratio = next / rho;
            rho = next;
            for (d, z) in direction.iter_mut().zip(&z) {
                *d = z + *d * ratio;
            }
        }
        if contacts.is_empty() {
            return Vec::new();
        }
        apply(x, &mut product);
        right.iter().zip(&product).map(|(b, p)| b - p).collect()
    }
}

fn dot(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}

/// The rotation nearest to a covariance; none where it has no direction.
fn nearest_rotation(covariance: Matrix3<f64>) -> Matrix3<f64> {
    let norm = covariance.norm();
    if !(norm.is_finite() && norm > 0.0) {
        return Matrix3::identity();
    }
    // A trace of the identity decides what springs in a line or a plane leave open.
    let matrix = covariance / norm + Matrix3::identity() * 1e-9;
    let Some(svd) = matrix.try_svd(true, true, 1e-12, 100) else { return Matrix3::identity() };
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return Matrix3::identity() };
    let mut sign = Matrix3::identity();
    if (u * v_t).determinant() < 0.0 {
        sign[(2, 2)] = -1.0;
    }
    let rotation = u * sign * v_t;
    if rotation.iter().all(|r| r.is_finite()) { rotation } else { Matrix3::identity() }
}

#[cfg(test)]
mod tests;
