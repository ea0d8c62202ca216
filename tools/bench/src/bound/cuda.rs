//! NVIDIA GPUs: warp instructions, four schedulers a multiprocessor, one instruction each a clock.

use super::{Instructions, IssueBound};

/// A half-spring: a spring seen from one node. Position and velocity of the node itself stay in
/// registers.
///
/// 3 loads of 128 bit (the spring's record; position and velocity of the other end), 1 to turn the
/// record's index into an address, 6 differences, 3 for the squared length, 1 reciprocal root, 1
/// length, 1 stretch, 1 elastic force, 3 for w . r, 1 times the inverse length, 1 dashpot on top, 1
/// magnitude, 3 sums of force: 26.
const HALF_SPRING: f64 = 26.0;

/// A half-spring of the adjoint, beside which the forward substep runs once more.
///
/// A load (the other end's adjoint of force) and 3 differences on top of forward's 3 loads,
/// address and 6 differences: 14. Length again 5. Direction 3, p 3, q 3, stretch and force 3,
/// damped 1, along 4, r_bar 3 x 3, w_bar 3, sums of the adjoint of position and velocity 6, three
/// parameter gradients 6: 41.
const HALF_SPRING_ADJOINT: f64 = 14.0 + 5.0 + 41.0;

/// A triplet, evaluated once.
///
/// 1 record and 6 loads of 128 bit, 3 addresses, 12 differences, 9 for the squares and the cosine,
/// 2 reciprocals, 6 for u x w, 3 for its square, 2 for the sine and its inverse, 4 to detect
/// collinear ones, 12 for the two crosses, 6 scalings, 18 for the angle, 6 for the rate, 6 for the
/// magnitude, 6 products, 9 sums of force and 3 stores: 114.
const TRIPLET: f64 = 114.0;

/// A node: 2 loads, 4 for force into velocity with gravity, 3 for drag, 4 for the height above
/// ground and its rate, 6 to decide whether it is reached within the substep, 3 for the step, 2
/// stores: 24.
const NODE: f64 = 24.0;

/// A node of the adjoint: the counts of [`NODE`] again, and the sums into drag.
const NODE_ADJOINT: f64 = 30.0;

/// Threads a warp.
const LANES: f64 = 32.0;
/// Warp instructions a clock and multiprocessor.
const ISSUE: f64 = 4.0;

/// Multiprocessors and highest clock [Hz] of the GPUs whose names contain a word.
const DEVICES: [(&str, f64, f64); 3] =
    [("H200", 132.0, 1.98e9), ("H100 PCIe", 114.0, 1.755e9), ("H100", 132.0, 1.98e9)];

/// The bound of a device of that name, if it is known.
pub(super) fn bound(name: &str) -> Option<IssueBound> {
    let &(word, multiprocessors, clock_hz) = DEVICES.iter().find(|d| name.contains(d.0))?;
    let instructions = |spring, node| Instructions { spring, triplet: TRIPLET, node };
    Some(IssueBound {
        forward: instructions(HALF_SPRING, NODE),
        gradient: instructions(HALF_SPRING + HALF_SPRING_ADJOINT, NODE + NODE_ADJOINT),
        both_ends: true,
        lanes: LANES,
        per_second: multiprocessors * ISSUE * clock_hz,
        how: format!(
            "{word}: {multiprocessors} multiprocessors at {:.2} GHz, {ISSUE} warp instructions a clock \
             each; every spring evaluated from both ends, {HALF_SPRING} warp instructions per {LANES} \
             half-springs, {TRIPLET} per {LANES} triplets, {NODE} per {LANES} nodes; gradient: \
             {HALF_SPRING_ADJOINT} more per {LANES} half-springs and {NODE_ADJOINT} per {LANES} nodes, \
             triplets not counted; every batch against the whole device",
            clock_hz / 1e9
        ),
    })
}
