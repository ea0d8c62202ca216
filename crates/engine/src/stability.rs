//! The largest stable substep of a model, estimated before anything is simulated.
//!
//! **Criterion.** Linearised at rest, a substep is `v' = v - dt M⁻¹(K x + C v)`, `x' = x + dt v'`. For
//! an eigenvector z of that map, `k = z*Kz` and `c = z*Cz` (mass-normalised, both real and not negative)
//! give `mu² - (2 - c dt - k dt²) mu + (1 - c dt) = 0`, whose roots lie within the unit circle if and
//! only if `dt² k + 2 dt c <= 4`. So the step is stable if the largest eigenvalue of `dt² K + 2 dt C` is at
//! most 4; without damping that is the familiar `dt <= 2 / omega`.
//!
//! **Method.** Power iteration on `dt² K + 2 dt C`, where each step sets dt to the root of the criterion
//! for the current vector. The estimate approaches from above, hence [`MARGIN`]. Springs count with their
//! tension's lateral stiffness, straight triplets in both directions across; a compressed spring's negative
//! stiffness is left out. Drag only helps and contact is no linear force: neither counts.

use crate::{
    Model,
    cpu::{bend, check},
};

/// The step kept back, as the iteration may not have converged and the rest shape is not the worst.
const MARGIN: f64 = 0.96;

/// When the iteration ends.
#[derive(Clone, Copy)]
struct Effort {
    /// Steps at most.
    iterations: usize,
    /// Relative change of dt at which it has converged.
    tolerance: f64,
    /// For so many steps.
    patience: usize,
}

const EFFORT: Effort = Effort { iterations: 100, tolerance: 1e-3, patience: 8 };

/// How finely a model's frames must be divided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StableSubsteps {
    /// Fewest stable substeps a frame.
    pub needed: u32,
    /// Node with the largest share in the stiffest mode; 0 if there is none.
    pub stiffest_node: usize,
    /// Largest stable substep [s]; infinite if nothing is stiff.
    pub dt_s: f64,
}

/// Estimates the substeps that a model needs; its own substeps are not looked at. Costs about as much
/// as a hundred substeps at most. A model that contradicts itself, which loading refuses, needs one.
pub fn stable_substeps(model: &Model) -> StableSubsteps {
    estimate(model, EFFORT)
}

fn estimate(model: &Model, effort: Effort) -> StableSubsteps {
    let mut out = StableSubsteps { needed: 1, stiffest_node: 0, dt_s: f64::INFINITY };
    if check::unstepped_model(model).is_err() {
        return out;
    }
    let system = Linear::new(model);
    let (mut dt, mut calm) = (f64::INFINITY, 0);
    let mut mode = system.start();
    for _ in 0..effort.iterations {
        let (stiff, damp) = system.apply(&mode);
        let (k, c) = (inner(&mode, &stiff), inner(&mode, &damp));
        let next = largest_dt(k, c);
        if !next.is_finite() {
            // Nothing is stiff, or so stiff that it overflows.
            dt = if k > 0.0 || k.is_nan() || c.is_nan() { 0.0 } else { f64::INFINITY };
            break;
        }
        calm = if (dt - next).abs() < effort.tolerance * next { calm + 1 } else { 0 };
        dt = next;
        for ((m, s), d) in mode.iter_mut().zip(stiff).zip(damp) {
            *m = std::array::from_fn(|x| dt * dt * s[x] + 2.0 * dt * d[x]);
        }
        let norm = inner(&mode, &mode).sqrt();
        if norm > 0.0 {
            mode.iter_mut().flatten().for_each(|x| *x /= norm);
        }
        if calm >= effort.patience {
            break;
        }
    }
    out.dt_s = dt * MARGIN;
    let steps = (model.timing.frame_s() / out.dt_s).ceil();
    // A saturating cast: infinitely many substeps are u32::MAX.
    out.needed = (steps as u32).max(1);
    let share = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>();
    let shares = mode[..model.graph.node_count()].iter().map(share).enumerate();
    out.stiffest_node = shares.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(i, _)| i);
    out
}

type Vector = [f64; 3];

fn inner(a: &[Vector], b: &[Vector]) -> f64 {
    a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| x * y).sum()
}

/// Largest stable step of a single mode of so much stiffness and damping.
fn largest_dt(k: f64, c: f64) -> f64 {
    4.0 / (c + (c * c + 4.0 * k).sqrt())
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Stiffness and damping of a spring for a relative displacement.
struct Bar {
    ends: [usize; 2],
    /// Zero if all directions are alike.
    direction: Vector,
    along: f64,
    across: f64,
    damping: f64,
}

/// Stiffness and damping of a triplet for one pattern of displacement.
struct Hinge {
    ends: [usize; 3],
    pattern: [Vector; 3],
    stiffness: f64,
    damping: f64,
}

/// The linearised, mass-normalised model.
struct Linear {
    /// 1/sqrt(m) of every endpoint; zero where it is prescribed.
    roots: Vec<f64>,
    bars: Vec<Bar>,
    hinges: Vec<Hinge>,
}

impl Linear {
    fn new(model: &Model) -> Self {
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
        let bars = graph.springs.iter().enumerate().map(|(s, &[a, b])| {
            let [k, rest, damping] =
                [&params.spring_stiffness, &params.rest_lengths_m, &params.spring_dashpot]
                    .map(|v| f64::from(v[s]));
            bar([a as usize, b as usize], arm(a, b), k, rest, damping)
        });
        let mut hinges = Vec::new();
        for (t, &[i, j, k]) in graph.triplets.iter().enumerate() {
            let [stiffness, damping, rest] =
                [&params.bend_stiffness, &params.bend_damping, &params.rest_angles_rad]
                    .map(|v| f64::from(v[t]));
            let ends = [i as usize, j as usize, k as usize];
            for pattern in bend_patterns(arm(j, i), arm(j, k), bend::rest_bend(rest)) {
                hinges.push(Hinge { ends, pattern, stiffness, damping });
            }
        }
        Self { bars: bars.collect(), roots, hinges }
    }

    /// An arbitrary but always equal vector with a share in every mode, the larger the stiffer a
    /// node is by itself, so that a single stiff spot in a large soft body is found at once.
    fn start(&self) -> Vec<Vector> {
        let mut alone = vec![(0.0, 0.0); self.roots.len()];
        for b in &self.bars {
            for e in b.ends {
                alone[e].0 += b.along.max(b.across) * self.roots[e].powi(2);
                alone[e].1 += b.damping * self.roots[e].powi(2);
            }
        }
        for h in &self.hinges {
            for (&e, g) in h.ends.iter().zip(h.pattern) {
                let square = dot(g, g) * self.roots[e].powi(2);
                alone[e].0 += h.stiffness * square;
                alone[e].1 += h.damping * square;
            }
        }
        let rates: Vec<f64> = alone.iter().map(|&(k, c)| largest_dt(k, c).recip()).collect();
        let most = rates.iter().fold(f64::MIN_POSITIVE, |m, r| m.max(*r));
        let mut bits = 0x9e37_79b9_7f4a_7c15_u64;
        let mut next = || {
            bits ^= bits << 13;
            bits ^= bits >> 7;
            bits ^= bits << 17;
            (bits >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let mut v: Vec<Vector> = Vec::with_capacity(rates.len());
        for (&root, rate) in self.roots.iter().zip(rates) {
            let share = if root > 0.0 { (rate / most).powi(4).clamp(1e-4, 1.0) } else { 0.0 };
            v.push([next(), next(), next()].map(|x| share * x));
        }
        let norm = inner(&v, &v).sqrt();
        if norm > 0.0 {
            v.iter_mut().flatten().for_each(|x| *x /= norm);
        }
        v
    }

    /// K v and C v.
    fn apply(&self, v: &[Vector]) -> (Vec<Vector>, Vec<Vector>) {
        let mut stiff = vec![[0.0; 3]; v.len()];
        let mut damp = vec![[0.0; 3]; v.len()];
        for b in &self.bars {
            let [i, j] = b.ends;
            let (ri, rj) = (self.roots[i], self.roots[j]);
            let r: Vector = std::array::from_fn(|c| rj * v[j][c] - ri * v[i][c]);
            let along = dot(r, b.direction);
            for c in 0..3 {
                let part = along * b.direction[c];
                let (f, g) = (b.along * part + b.across * (r[c] - part), b.damping * part);
                stiff[i][c] -= ri * f;
                stiff[j][c] += rj * f;
                damp[i][c] -= ri * g;
                damp[j][c] += rj * g;
            }
        }
        for h in &self.hinges {
            let bent: f64 =
                (0..3).map(|e| self.roots[h.ends[e]] * dot(h.pattern[e], v[h.ends[e]])).sum();
            for e in 0..3 {
                let node = h.ends[e];
                for c in 0..3 {
                    let part = self.roots[node] * bent * h.pattern[e][c];
                    stiff[node][c] += h.stiffness * part;
                    damp[node][c] += h.damping * part;
                }
            }
        }
        (stiff, damp)
    }
}

fn bar(ends: [usize; 2], r: Vector, k: f64, rest: f64, damping: f64) -> Bar {
    let length = dot(r, r).sqrt();
    let along = if rest > 0.0 { k / rest } else { 0.0 };
    if length < 1e-9 {
        // It may turn into any direction.
        return Bar { ends, direction: [0.0; 3], along, across: along.max(damping), damping };
    }
    let across = (along * (length - rest) / length).max(0.0);
    Bar { ends, direction: r.map(|x| x / length), along, across, damping }
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
    let collinear = sine < bend::MIN_SINE;
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

#[cfg(test)]
mod tests;
