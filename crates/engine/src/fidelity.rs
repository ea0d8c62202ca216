//! The fast variant of a model: the same model with fewer substeps, softened where it must be.
//!
//! **Softening.** A model can have fewer substeps than its stiffest mode allows only if that mode
//! is softened. An element by itself has a stiffness κ [1/s²] and a damping ζ [1/s], both per mass:
//! for a spring `κ = w k / l0` and `ζ = w γ` with `w = 1/m_i + 1/m_j`; for a triplet `κ = w kθ` and
//! `ζ = w c_b` with `w = 1/(m_i lu²) + 1/(m_k lw²) + (1/lu + 1/lw)²/m_j` and lu, lw the lengths of
//! its arms at rest; for a rod the same with `w = sum |g|²/m` over its nodes, with the gradient g
//! of its twist where it is stiff (see `stability.rs`). Pinned nodes and control points weigh
//! infinitely much. With a rate limit λ, stiffness is scaled so that `dt² κ <= λ` and damping so
//! that `2 dt ζ <= λ`; most elements are unchanged. A model is stable where the same expressions
//! of all elements together stay below 4 (see `stability.rs`), so λ lies below 4 too.
//!
//! A softened model is another model: its deviation has to be measured.

use bendtwin_core::{FastVariant, Point};

use crate::{
    Model,
    cpu::{check, elements::turned_pattern},
    enough_substeps,
};

/// Rate limits that are considered: an element alone is unstable above 4; where even the lower
/// end is unstable, nearly every element would have to be softened.
const LIMITS: std::ops::Range<f64> = 0.02..4.0;
/// The rate limit is found up to this factor.
const PRECISION: f64 = 1.05;

/// The difference of a fast variant from its model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reduction {
    /// Substeps per frame.
    pub substeps: u32,
    /// Rate limit λ of every element; `None` leaves parameters unchanged.
    pub rate_limit: Option<f64>,
}

impl From<&FastVariant> for Reduction {
    fn from(fast: &FastVariant) -> Self {
        Self { substeps: fast.substeps, rate_limit: fast.rate_limit }
    }
}

impl Reduction {
    /// The least reduction with which a model is stable at this many substeps, according to the
    /// estimate; none if too much would have to be softened, or the model is contradictory.
    pub fn to(model: &Model, substeps: u32) -> Option<Self> {
        let is_stable = |rate_limit| {
            let reduced = Self { substeps, rate_limit }.apply(model);
            enough_substeps(&reduced, substeps).is_ok()
        };
        if substeps == 0 || check::unstepped_model(model).is_err() {
            return None;
        }
        if is_stable(None) {
            return Some(Self { substeps, rate_limit: None });
        }
        let (mut low, mut high) = (LIMITS.start, LIMITS.end);
        if !is_stable(Some(low)) {
            return None;
        }
        while high > low * PRECISION {
            let middle = (low * high).sqrt();
            if is_stable(Some(middle)) { low = middle } else { high = middle }
        }
        Some(Self { substeps, rate_limit: Some(low) })
    }

    /// The variant of a model. Its indices must exist, as a twin's and a loaded model's do.
    pub fn apply(&self, model: &Model) -> Model {
        let mut out = model.clone();
        out.timing.substeps = self.substeps.max(1);
        let Some(limit) = self.rate_limit else { return out };
        let dt = out.timing.dt_s();
        let inverse_masses = inverse_masses(model);
        let of = |e: u32| inverse_masses.get(e as usize).copied().unwrap_or_default();
        let (graph, params) = (&model.graph, &mut out.params);
        let springs = params.spring_stiffness.iter_mut().zip(&mut params.spring_dashpot);
        for ((&[i, j], rest), (k, dashpot)) in
            graph.springs.iter().zip(&params.rest_lengths_m).zip(springs)
        {
            let weight = of(i) + of(j);
            // Without a rest length a spring has no stiffness.
            if *rest > 0.0 {
                limit_rate(k, dt * dt * weight / f64::from(*rest), limit);
            }
            limit_rate(dashpot, 2.0 * dt * weight, limit);
        }
        let triplets = params.bend_stiffness.iter_mut().zip(&mut params.bend_damping);
        for (&[i, j, k], (stiffness, damping)) in graph.triplets.iter().zip(triplets) {
            let [a, b, c] = [i, j, k].map(|e| graph.rest_endpoint(e));
            let (u, w) = (distance(a, b), distance(c, b));
            if u.min(w) > 0.0 {
                let centre = (1.0 / u + 1.0 / w).powi(2);
                let weight = of(i) / (u * u) + of(k) / (w * w) + of(j) * centre;
                limit_rate(stiffness, dt * dt * weight, limit);
                limit_rate(damping, 2.0 * dt * weight, limit);
            }
        }
        let rods = params.twist_stiffness.iter_mut().zip(&mut params.twist_damping);
        for (rod, (stiffness, damping)) in graph.rods.iter().zip(rods) {
            let points: Vec<_> =
                rod.iter().map(|&e| graph.rest_endpoint(e).map(f64::from)).collect();
            let parts = rod.iter().zip(turned_pattern(&points, graph.has_arm(rod)));
            let weight: f64 =
                parts.map(|(&e, g)| of(e) * g.iter().map(|x| x * x).sum::<f64>()).sum();
            limit_rate(stiffness, dt * dt * weight, limit);
            limit_rate(damping, 2.0 * dt * weight, limit);
        }
        out
    }
}

/// Scales a parameter down until its rate, `per_unit` times itself, is within the limit.
fn limit_rate(parameter: &mut f32, per_unit: f64, limit: f64) {
    let rate = f64::from(*parameter) * per_unit;
    if rate > limit {
        *parameter = (f64::from(*parameter) * (limit / rate)) as f32;
    }
}

/// Per endpoint [1/mass]; zero where it is prescribed.
fn inverse_masses(model: &Model) -> Vec<f64> {
    let graph = &model.graph;
    let mut out: Vec<f64> = graph.masses.iter().map(|m| f64::from(*m).recip()).collect();
    for pin in &graph.pins {
        if let Some(inverse) = out.get_mut(pin.node as usize) {
            *inverse = 0.0;
        }
    }
    out.resize(graph.node_count() + graph.control_count(), 0.0);
    out
}

fn distance(a: Point, b: Point) -> f64 {
    a.iter().zip(b).map(|(x, y)| f64::from(x - y).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests;
