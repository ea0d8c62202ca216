//! The fewest cycles that a substep can take on one core, from a hand count of vector instructions.
//!
//! The model of the core is four vector pipes that start one 256-bit operation a cycle each:
//! multiplications, fused multiply-adds, divisions and roots on two of them, additions on the other
//! two, shuffles on any two. Loads are folded into operations where AVX2 can. The count is of what
//! the algorithm needs in any arrangement that evaluates an element once, for blocks of eight
//! elements: no spills, no bounds checks, no addresses, no loop control, no waiting, no misses.
//! Loads (two a cycle), stores (one a cycle) and issue (six a cycle) have been counted too; where
//! they bind instead of the pipes it is said. Each number is `operations`, a cycle takes [`PIPES`]
//! of them.

/// Vector operations a cycle.
const PIPES: f64 = 4.0;
/// Elements a block.
const BLOCK: f64 = 8.0;

/// Eight endpoints' records, x | v, to six coordinates: 14 shuffles in halves, 6 across them.
const TURN_NODES: f64 = 20.0;
/// Eight quads to three coordinates: 4 inserts, 7 shuffles.
const TURN_QUADS: f64 = 11.0;
/// Three coordinates to eight quads added in memory: 8 shuffles, 4 extracts, 8 additions.
const ADD_QUADS: f64 = 20.0;
/// Six coordinates to eight records added in memory: 16 shuffles, 8 permutations, 8 additions.
const ADD_NODES: f64 = 32.0;

/// The owner's state stays in registers: turn; r, w (6); r.r, w.r (6); root, division, its mask
/// (4); stretch, rate, dashpot, 1/l, sum (6); owner's sum (3); force (3); add.
const SPRING: f64 = TURN_NODES + 6.0 + 6.0 + 4.0 + 6.0 + 3.0 + 3.0 + ADD_QUADS;
/// Turn nodes and lambda; r, w, pull (9); r.r, r.pull, r.w (9); root, division, its mask (4); 1/l,
/// s, p, q, F (3), gamma p (2), along (4) (13); r_bar (9); w_bar (3); sums for k, gamma, l0 (3);
/// owner's sums (6); add.
const SPRING_BACK: f64 =
    TURN_NODES + TURN_QUADS + 9.0 + 9.0 + 4.0 + 13.0 + 9.0 + 3.0 + 3.0 + 6.0 + ADD_NODES;

/// Lengths (6), their product's inverse with masks and limits (10), normal and two more cross
/// products (18), |n| (4), u.w (3).
const BEND_GEOMETRY: f64 = 41.0;
/// Choice of the formula (11), 1/m (3), the angle: reduction (12), division and polynomial (8),
/// quadrants (8), sign and difference (3).
const BEND_STATE: f64 = 45.0;
/// Turn both ends; u, w and rates (12); geometry; angle; damping rate (8); moment (10); forces (8);
/// centre's sum (6); add twice.
const TRIPLET: f64 = 2.0 * TURN_NODES
    + 12.0
    + BEND_GEOMETRY
    + 6.0
    + BEND_STATE
    + 2.0
    + 10.0
    + 8.0
    + 6.0
    + 2.0 * ADD_QUADS;
/// Turn nodes and lambda twice; differences (18); geometry; angle; g (8); rate, rho, kappa and
/// products (16); y (12); Hessian's product (74); x_bar (12), v_bar (8), test for the straight
/// limit (1); sums for parameters (5); centre's sums (12); add twice.
const TRIPLET_BACK: f64 = 2.0 * (TURN_NODES + TURN_QUADS + ADD_NODES)
    + 18.0
    + BEND_GEOMETRY
    + BEND_STATE
    + 8.0
    + 16.0
    + 12.0
    + 74.0
    + 21.0
    + 5.0
    + 12.0;

/// Five operations a node, row by row (40); for the ground eight nodes' x and v turned (14), the
/// next position (3), two components along the normal (6), tests (4).
const NODE: f64 = 67.0;
/// Instructions a node backward: five more, and the ground's test.
const NODE_BACK: f64 = 67.0;
/// Eight nodes on tape are 12 stores of 256 bits at one a cycle.
const TAPE: f64 = 12.0 * PIPES;

/// Numbers of the elements that are counted.
#[derive(Clone, Copy)]
pub(crate) struct Elements {
    pub(crate) nodes: usize,
    pub(crate) springs: usize,
    pub(crate) triplets: usize,
}

impl Elements {
    /// Cycles of a substep forward.
    pub(crate) fn forward_cycles(self) -> f64 {
        self.cycles(NODE, SPRING, TRIPLET)
    }

    /// Cycles of a substep of a gradient: forward, forward again with the tape, backward.
    pub(crate) fn gradient_cycles(self) -> f64 {
        let back = self.cycles(NODE_BACK, SPRING_BACK, TRIPLET_BACK);
        2.0 * self.forward_cycles() + self.cycles(TAPE, 0.0, 0.0) + back
    }

    fn cycles(self, node: f64, spring: f64, triplet: f64) -> f64 {
        let operations = self.nodes as f64 * node
            + self.springs as f64 * spring
            + self.triplets as f64 * triplet;
        operations / (BLOCK * PIPES)
    }
}
