//! The largest stable substep of a model, estimated before anything is simulated.
//!
//! **Criterion.** Linearised at rest, a substep is `v' = v - dt M⁻¹(K x + C v)`, `x' = x + dt v'`.
//! For an eigenvector z of that map, `k = z*Kz` and `c = z*Cz` (mass-normalised, both real and not
//! negative) give `mu² - (2 - c dt - k dt²) mu + (1 - c dt) = 0`, whose roots lie within the unit
//! circle if and only if `dt² k + 2 dt c <= 4`. So the step is stable if the largest eigenvalue of
//! `dt² K + 2 dt C` is at most 4; without damping that is the familiar `dt <= 2 / omega`.
//!
//! **Method.** Lanczos iteration on `dt² K + 2 dt C` finds its stiffest mode, which sets dt to the
//! root of the criterion for that mode, and again from there until dt stays. Every mode's dt is too
//! large if anything, so the estimate approaches from above, hence [`MARGIN`]. Springs count with
//! their tension's lateral stiffness, straight triplets in both directions across; a compressed
//! spring's negative stiffness is left out. Rods count as bent to and fro by 60 degrees at every
//! node that is straighter at rest, and as twisted once around: at rest they often have no
//! stiffness. Drag is stabilizing and contact is no linear force: neither counts.
//!
//! **Shortcut.** A bound that costs a fraction of an estimate often proves that a given number of
//! substeps is enough; see `bound`.

mod bound;
mod lanczos;
mod linear;

use self::{
    lanczos::Operator,
    linear::{Linear, Vector, dot, largest_dt},
};
use crate::{Model, cpu::check};

/// The step kept back, as the iteration may not have converged and the rest shape is not the worst.
const MARGIN: f64 = 0.96;
/// Applications of the operator at one dt, at most: their vectors are kept.
const STEPS: usize = 16;
/// Most dts that are tried.
const ROUNDS: usize = 4;
/// Relative change of dt from one to the next at which it has converged.
const TOLERANCE: f64 = 1e-3;

/// The number of substeps that a model needs, and the node that requires them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StableSubsteps {
    /// Fewest stable substeps a frame.
    pub needed: u32,
    /// Node with the largest share in the stiffest mode; 0 without nodes.
    pub stiffest_node: usize,
    /// Largest stable substep [s]; infinite if nothing is stiff.
    pub dt_s: f64,
}

/// The result for a model without anything stiff.
const NOT_STIFF: StableSubsteps =
    StableSubsteps { needed: 1, stiffest_node: 0, dt_s: f64::INFINITY };

/// Estimates the substeps that a model needs; its current number is ignored. Costs about as much as
/// some tens of substeps. A model that contradicts itself, which loading refuses, needs one.
pub fn stable_substeps(model: &Model) -> StableSubsteps {
    match check::unstepped_model(model) {
        Ok(()) => estimate(model, &Linear::new(model)),
        Err(_) => NOT_STIFF,
    }
}

/// Checks that this many substeps a frame are at least those of [`stable_substeps`], which are only
/// computed if a bound does not prove it. A contradictory model needs one.
///
/// # Errors
/// The substeps that the model needs, if they are more.
pub fn enough_substeps(model: &Model, substeps: u32) -> Result<(), StableSubsteps> {
    let needs = match check::unstepped_model(model) {
        Ok(()) => {
            let system = Linear::new(model);
            // The step that must be stable for this number of substeps to be enough.
            let dt_s = model.timing.frame_s() / (f64::from(substeps) * MARGIN);
            if bound::is_below(&system, dt_s, 4.0) {
                return Ok(());
            }
            estimate(model, &system)
        }
        Err(_) => NOT_STIFF,
    };
    if needs.needed <= substeps { Ok(()) } else { Err(needs) }
}

fn estimate(model: &Model, system: &Linear) -> StableSubsteps {
    let (mut mode, guess) = system.start();
    let dt = converge(system, &mut mode, guess);
    let share = |v: &Vector| dot(*v, *v);
    let shares = mode[..model.graph.node_count()].iter().map(share).enumerate();
    let dt_s = dt * MARGIN;
    let steps = (model.timing.frame_s() / dt_s).ceil();
    StableSubsteps {
        // A saturating cast: infinitely many substeps are u32::MAX.
        needed: (steps as u32).max(1),
        stiffest_node: shares.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(i, _)| i),
        dt_s,
    }
}

/// Turns a vector into the stiffest mode; its largest stable step [s].
fn converge(system: &Linear, mode: &mut Vec<Vector>, guess: f64) -> f64 {
    if !guess.is_finite() {
        // Nothing is stiff.
        return f64::INFINITY;
    }
    let mut dt = guess;
    for _ in 0..ROUNDS {
        *mode = Operator::new(system, dt).stiffest(mode, STEPS);
        let (k, c) = system.quotients(mode);
        let next = largest_dt(k, c);
        if !next.is_finite() {
            // Nothing is stiff after all, or so stiff that it overflows.
            return if k > 0.0 || k.is_nan() || c.is_nan() { 0.0 } else { f64::INFINITY };
        }
        let calm = (dt - next).abs() < TOLERANCE * next;
        dt = next;
        if calm {
            break;
        }
    }
    dt
}

#[cfg(test)]
mod tests;
