//! Directions in which the parameters of a twin change together, their plausible ranges, and models a
//! step along them.

use std::f64::consts::LN_2;

use bendtwin_core::{Graph, Params, Twin, identifiability::Quantity};

use crate::Regions;

/// Restitution, friction: beyond these they mean nothing.
const MOST_FRICTION: f32 = 2.0;

/// A group of parameters that change together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// Kind of the parameters.
    pub quantity: Quantity,
    /// Their region; none for those of the whole object.
    pub region: Option<usize>,
    /// The hand whose grip it is.
    pub hand: Option<u32>,
}

/// Standard deviation of a direction before anything is recorded: of the logarithm, or of friction and
/// restitution themselves.
///
/// - A factor of two in the stiffness of a region: what the regions of one fit differ by, and fits of
///   one object from several starts.
/// - Three percent of rest length: what a tracker and a completed surface leave open of a shape.
/// - A factor of three in what is found by its order of magnitude: bending, twist, damping, grips.
/// - 0.5 of friction and 0.3 of restitution: where fits of soft objects from several starts leave them.
pub fn prior_sd(quantity: Quantity) -> f64 {
    match quantity {
        Quantity::Stiffness => LN_2,
        Quantity::RestLength => 0.03,
        Quantity::BendStiffness
        | Quantity::Grip
        | Quantity::TwistStiffness
        | Quantity::Dashpot
        | Quantity::BendDamping
        | Quantity::Drag => 3.0_f64.ln(),
        Quantity::GroundFriction => 0.5,
        Quantity::GroundRestitution => 0.3,
    }
}

/// The directions of a twin that is cut into regions: those of each region, then those of the whole.
/// Friction on the ground is left out without ground.
pub fn directions(twin: &Twin, regions: &Regions) -> Vec<Direction> {
    use Quantity::*;
    let graph = &twin.graph;
    let mut of_regions = vec![Stiffness, RestLength];
    let mut of_whole = vec![Dashpot];
    if !graph.triplets.is_empty() {
        of_regions.push(BendStiffness);
        of_whole.push(BendDamping);
    }
    of_whole.push(Drag);
    if !graph.rods.is_empty() {
        of_whole.push(TwistStiffness);
    }
    if twin.environment.ground.is_some() {
        of_whole.extend([GroundFriction, GroundRestitution]);
    }
    let (whole, one) = (None, None);
    let by_region = of_regions.into_iter().flat_map(|quantity| {
        (0..regions.parts.len()).map(move |r| Direction { quantity, region: Some(r), hand: None })
    });
    let hands = twin.hands();
    let n = graph.node_count();
    let held = |hand: u32| graph.springs.iter().any(|s| hand_of(s, n, &hands) == Some(hand));
    let count = hands.iter().max().map_or(0, |h| h + 1);
    let grips = (0..count).filter(|&hand| held(hand));
    let grips = grips.map(|hand| Direction { quantity: Grip, region: whole, hand: Some(hand) });
    let of_whole =
        of_whole.into_iter().map(|quantity| Direction { quantity, region: whole, hand: one });
    by_region.chain(grips).chain(of_whole).collect()
}

/// The hand whose control point a spring joins to a node; none for a spring between nodes.
fn hand_of(spring: &[u32; 2], nodes: usize, hands: &[u32]) -> Option<u32> {
    hands.get((spring[1] as usize).checked_sub(nodes)?).copied()
}

/// Share of a spring between nodes that belongs to a region: half of it by each end.
fn share(spring: &[u32; 2], of_nodes: &[u8], region: usize) -> f64 {
    let own = |end: u32| of_nodes.get(end as usize).is_some_and(|r| usize::from(*r) == region);
    if spring[1] as usize >= of_nodes.len() {
        return 0.0;
    }
    spring.iter().filter(|end| own(**end)).count() as f64 / 2.0
}

/// Factors of the springs' parameters a step along a direction, shape [E].
fn spring_factors(graph: &Graph, of_nodes: &[u8], region: usize, step: f64) -> Vec<f32> {
    let factor = |s: &[u32; 2]| (step * share(s, of_nodes, region)).exp() as f32;
    graph.springs.iter().map(factor).collect()
}

impl Direction {
    /// Parameters a step along the direction, and the step that was made: shorter where a limit is in
    /// the way. `hands` are those of the control points, `of_nodes` the regions of the nodes.
    pub fn apply(
        &self,
        graph: &Graph,
        params: &Params,
        of_nodes: &[u8],
        hands: &[u32],
        step: f64,
    ) -> (Params, f64) {
        let mut p = params.clone();
        let n = graph.node_count();
        let times = |values: &mut [f32], factors: &[f32]| {
            values.iter_mut().zip(factors).for_each(|(x, factor)| *x *= factor);
        };
        let all = |values: &mut [f32]| {
            let factor = step.exp() as f32;
            values.iter_mut().for_each(|x| *x *= factor);
        };
        let within = |x: &mut f32, most: f32| {
            let moved = (f64::from(*x) + step).clamp(0.0, f64::from(most)) as f32;
            f64::from(moved) - f64::from(std::mem::replace(x, moved))
        };
        let region = self.region.unwrap_or_default();
        match self.quantity {
            Quantity::Stiffness => {
                let factors = spring_factors(graph, of_nodes, region, step);
                times(&mut p.spring_stiffness, &factors);
            }
            Quantity::RestLength => {
                let factors = spring_factors(graph, of_nodes, region, step);
                times(&mut p.rest_lengths_m, &factors);
            }
            Quantity::BendStiffness => {
                let factor = step.exp() as f32;
                for (k, &[_, center, _]) in p.bend_stiffness.iter_mut().zip(&graph.triplets) {
                    if of_nodes.get(center as usize).is_some_and(|r| usize::from(*r) == region) {
                        *k *= factor;
                    }
                }
            }
            Quantity::Grip => {
                let factor = step.exp() as f32;
                for (k, spring) in p.spring_stiffness.iter_mut().zip(&graph.springs) {
                    if hand_of(spring, n, hands).is_some_and(|hand| self.hand == Some(hand)) {
                        *k *= factor;
                    }
                }
            }
            Quantity::TwistStiffness => all(&mut p.twist_stiffness),
            Quantity::Dashpot => all(&mut p.spring_dashpot),
            Quantity::BendDamping => all(&mut p.bend_damping),
            Quantity::Drag => p.drag *= step.exp() as f32,
            Quantity::GroundFriction => {
                let made = within(&mut p.contact.ground_friction, MOST_FRICTION);
                return (p, made);
            }
            Quantity::GroundRestitution => {
                let made = within(&mut p.contact.ground_restitution, 1.0);
                return (p, made);
            }
        }
        (p, step)
    }
}

#[cfg(test)]
mod tests;
