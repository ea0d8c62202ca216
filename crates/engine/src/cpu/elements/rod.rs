//! Rods that twist between a clamp and another one, or a branch, and the adjoint of their forces.
//! Clamps may open and close from frame to frame ([`span`]).
//!
//! A rod has one twist, the same all along it: an isotropic rod's torsion evens out much faster
//! than it moves (the quasi-static material frame of discrete elastic rods, Bergou et al. 2008,
//! 2010). Only its ends hold its frame. Clamps carry it by parallel transport; so what twists a rod
//! between two of them is how the frame that is parallel along it turns, which its shape alone
//! decides. A branch is part of the junction where it begins, so its direction is the frame there
//! ([`arm`]). With e and g the edges before and after a node j, their turn
//! `kb = 2 e x g / (|e||g| + e.g)` and `a_j = kb / (2|e|)`, `c_j = -kb / (2|g|)`:
//!
//! ```text
//! d twist / dt = sum over inner nodes j of  a_j . (v_(j-1) - v_j) + c_j . (v_(j+1) - v_j) = grad . v
//! torque = k (twist - rest) + damping · d twist / dt,      force = -torque · grad
//! ```
//!
//! With only a share w of the rod between the clamps that hold, the sum is over the inner nodes there,
//! and divided by w: see [`span`].
//!
//! A substep first moves the twist with the velocities that led to where the nodes are, then takes
//! the torque from it. That is semi-implicit Euler for twist and velocities together; the other
//! order would feed energy in.
//!
//! **Degenerate**: a node with an edge that has no length, or where the rod folds back on itself
//! (1 + cosine below [`MIN_FOLD`]), or where a branch hardly leaves its line, neither turns the
//! frame nor feels the torque in that substep.

mod arm;
mod span;

use std::{ops::Range, sync::Arc};

use self::{
    arm::Arm,
    span::{Path, Paths},
};
use crate::{
    constants::{MIN_EDGE_M, MIN_FOLD, MIN_SINE_SQUARED},
    cpu::arithmetic::{Index, LANES, Machine, Node, Pack, Pack3, Quad, Real, v3},
};

/// Inner nodes of a rod with their neighbours along it; a lane without one names one node three
/// times, which has no edges and so does nothing.
#[derive(Clone, Debug)]
pub(crate) struct RodBlock {
    before: Index,
    at: Index,
    after: Index,
    /// True if the next node is that of a branch.
    is_arm: bool,
}

pub(crate) use self::span::{Holder, Span};

/// A rod and its parameters.
#[derive(Clone, Debug)]
pub(crate) struct Rod<T> {
    first: u32,
    end: u32,
    /// [N m/rad]
    pub(crate) stiffness: T,
    /// [N m s/rad]
    pub(crate) damping: T,
    /// [rad]
    pub(crate) rest_twist: T,
    /// Inverse of the share of the rod that clamps twist now.
    pub(crate) inverse_share: T,
}

impl<T> Rod<T> {
    #[inline(always)]
    fn blocks(&self) -> Range<usize> {
        self.first as usize..self.end as usize
    }
}

/// All rods, in the graph's order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rods<T> {
    pub(crate) rods: Vec<Rod<T>>,
    blocks: Vec<RodBlock>,
    /// In the graph.
    paths: Paths,
}

impl<T: Real> Rods<T> {
    /// Rods along these paths; `has_arm` is true if the last node is that of a branch, `shares` gives
    /// the share of the rod's length at each inner node, `parameters` stiffness, damping and rest
    /// twist of each.
    pub(crate) fn new(
        paths: &[Vec<u32>],
        has_arm: impl Fn(&[u32]) -> bool,
        shares: impl Fn(&[u32]) -> Vec<f32>,
        parameters: impl Fn(usize) -> [T; 3],
    ) -> Self {
        let described = paths.iter().map(|nodes| Path {
            nodes: nodes.clone(),
            has_arm: has_arm(nodes),
            shares: shares(nodes),
        });
        let paths: Paths = Arc::new(described.collect());
        let mut this = Self { paths: paths.clone(), ..Self::default() };
        for (r, path) in paths.iter().enumerate() {
            let [stiffness, damping, rest_twist] = parameters(r);
            let rod =
                Rod { first: 0, end: 0, stiffness, damping, rest_twist, inverse_share: T::ONE };
            this.add(&path.nodes, path.has_arm, rod);
        }
        this
    }

    /// Adds a rod along these nodes.
    fn add(&mut self, nodes: &[u32], has_arm: bool, rod: Rod<T>) {
        let first = self.blocks.len() as u32;
        let inner: Vec<&[u32]> = nodes.windows(3).collect();
        let (turns, arm) = inner.split_at(inner.len().saturating_sub(usize::from(has_arm)));
        let parts = turns.chunks(LANES).map(|part| (part, false));
        self.blocks.extend(parts.chain(arm.chunks(LANES).map(|part| (part, true))).map(
            |(inner, is_arm)| {
                let lane = |place: usize| {
                    // Lanes that fill up: the last node, three times.
                    let filler = inner.last().map_or(0, |w| w[1]);
                    std::array::from_fn(|l| inner.get(l).map_or(filler, |w| w[place]))
                };
                RodBlock { before: lane(0), at: lane(1), after: lane(2), is_arm }
            },
        ));
        self.rods.push(Rod { first, end: self.blocks.len() as u32, ..rod });
    }
}

/// d loss / d (stiffness, damping, rest twist) of a rod.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RodGradient<T> {
    pub(crate) stiffness: T,
    pub(crate) damping: T,
    pub(crate) rest_twist: T,
}

impl<T: Real> RodGradient<T> {
    pub(crate) const ZERO: Self =
        Self { stiffness: T::ZERO, damping: T::ZERO, rest_twist: T::ZERO };
}

/// The edges at a block's inner nodes.
struct Edges<P: Pack> {
    /// Before and after.
    e: Pack3<P>,
    g: Pack3<P>,
    /// Their lengths, at least [`MIN_EDGE_M`].
    lengths: [P; 2],
    /// Both have a direction.
    is_armed: P::Mask,
}

impl<P: Pack> Edges<P> {
    #[inline(always)]
    fn new<T: Real, M: Machine<T, Pack = P>>(m: M, x: &Triple<P>) -> Self {
        let (e, g) = (v3::neg(x.before), x.after);
        let least = m.splat(T::from_f64(MIN_EDGE_M));
        let lengths = [v3::dot(e, e).sqrt(), v3::dot(g, g).sqrt()];
        let is_armed = lengths[0].above(least) & lengths[1].above(least);
        Self { e, g, lengths: lengths.map(|l| l.at_least(least)), is_armed }
    }
}

/// The turn at a block's inner nodes.
#[derive(Clone, Copy)]
struct Turn<P: Pack> {
    /// Edges before and after.
    e: Pack3<P>,
    g: Pack3<P>,
    /// Their lengths, and the inverses of these; inverses are zero where degenerate.
    lengths: [P; 2],
    inverse_lengths: [P; 2],
    /// 1 / (|e||g| + e.g); zero where degenerate.
    inverse_fold: P,
    /// Derivative of the twist by the node before and by the node after; that by the node itself is
    /// minus their sum. Zero where degenerate.
    a: Pack3<P>,
    c: Pack3<P>,
}

impl<P: Pack> Turn<P> {
    #[inline(always)]
    fn new<T: Real, M: Machine<T, Pack = P>>(m: M, x: &Triple<P>) -> Self {
        let Edges { e, g, lengths: [e_length, g_length], is_armed } = Edges::new(m, x);
        let both = e_length * g_length;
        let fold = both + v3::dot(e, g);
        let least_fold = both * m.splat(T::from_f64(MIN_FOLD));
        let is_regular = is_armed & fold.above(least_fold);
        let fold = fold.at_least(least_fold);
        // One division for all three; the product is at least 1e-26.
        let inverse = (m.splat(T::ONE) / (fold * both)).only_if(is_regular);
        let n = v3::cross(e, g);
        let unfolded = inverse * fold;
        Self {
            a: v3::scale(n, inverse * g_length),
            c: v3::scale(n, -(inverse * e_length)),
            e,
            g,
            lengths: [e_length, g_length],
            inverse_lengths: [unfolded * g_length, unfolded * e_length],
            inverse_fold: inverse * both,
        }
    }

    /// Adjoint of (a, c): what it makes of the positions of the nodes before and after.
    #[inline(always)]
    fn back(&self, bar: &Triple<P>) -> Triple<P> {
        let [e_length, g_length] = self.lengths;
        let [inverse_e, inverse_g] = self.inverse_lengths;
        let (by_a, by_c) = (v3::dot(self.a, bar.before), v3::dot(self.c, bar.after));
        // a = n / (fold |e|), c = -n / (fold |g|), n = e x g, fold = |e||g| + e.g
        let n_bar = v3::sub_scaled(
            v3::scale(bar.before, self.inverse_fold * inverse_e),
            self.inverse_fold * inverse_g,
            bar.after,
        );
        let fold_bar = -((by_a + by_c) * self.inverse_fold);
        let e_stretch = (fold_bar * g_length - by_a * inverse_e) * inverse_e;
        let g_stretch = (fold_bar * e_length - by_c * inverse_g) * inverse_g;
        let e_bar = v3::add_scaled(
            v3::add_scaled(v3::cross(self.g, n_bar), fold_bar, self.g),
            e_stretch,
            self.e,
        );
        let g_bar = v3::add_scaled(
            v3::add_scaled(v3::cross(n_bar, self.e), fold_bar, self.e),
            g_stretch,
            self.g,
        );
        Triple { before: v3::neg(e_bar), after: g_bar }
    }
}

/// The change of the frame at a block's inner nodes.
#[derive(Clone, Copy)]
enum Joint<P: Pack> {
    /// The frame is transported in parallel.
    Turn(Turn<P>),
    /// A branch holds it.
    Arm(Arm<P>),
}

impl<P: Pack> Joint<P> {
    #[inline(always)]
    fn new<T: Real, M: Machine<T, Pack = P>>(m: M, is_arm: bool, x: &Triple<P>) -> Self {
        if is_arm { Self::Arm(Arm::new(m, x)) } else { Self::Turn(Turn::new(m, x)) }
    }

    /// Derivative of the twist by the nodes before and after.
    #[inline(always)]
    fn gradient(&self) -> Triple<P> {
        match self {
            Self::Turn(turn) => Triple { before: turn.a, after: turn.c },
            Self::Arm(arm) => Triple { before: arm.a, after: arm.c },
        }
    }

    /// grad . y
    #[inline(always)]
    fn along(&self, y: &Triple<P>) -> P {
        let g = self.gradient();
        v3::dot(g.before, y.before) + v3::dot(g.after, y.after)
    }

    /// Adjoint of the gradient: what it makes of the positions of the nodes before and after.
    #[inline(always)]
    fn back(&self, bar: &Triple<P>) -> Triple<P> {
        match self {
            Self::Turn(turn) => turn.back(bar),
            Self::Arm(arm) => arm.back(bar),
        }
    }
}

/// Turn that a rod counts as having at least at every node where its stiffness is estimated [rad].
const TURN_RAD: f64 = std::f64::consts::FRAC_PI_3;

/// Sine of the angle between a rod's last edge and its branch that counts where its stiffness is
/// estimated, at most.
const ARM_SINE: f64 = 0.5;

/// Gradient of the twist by each node of a rod at `points` [rad/m] where it is stiff: every bend at
/// least [`TURN_RAD`], in pairs to either side, since bends two nodes apart pull at the node
/// between them with opposite signs. All across the line from end to end. (A straight rod resists
/// nothing until it is bent.) A branch at its end counts as standing [`ARM_SINE`] away from the
/// line, unless it is even nearer to it.
pub(crate) fn turned_pattern(points: &[[f64; 3]], has_arm: bool) -> Vec<[f64; 3]> {
    let mut pattern = vec![[0.0; 3]; points.len()];
    let least = 2.0 * (0.5 * TURN_RAD).tan();
    let normal = across(points);
    let length = |a: &[f64; 3], b: &[f64; 3]| {
        a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt().max(MIN_EDGE_M)
    };
    for (j, x) in points.windows(3).enumerate() {
        let (e, g) = (length(&x[0], &x[1]), length(&x[1], &x[2]));
        let chord = length(&x[0], &x[2]);
        let cosine = ((chord * chord - e * e - g * g) / (2.0 * e * g)).clamp(-1.0, 1.0);
        let turn = 2.0 * ((1.0 - cosine) / (1.0 + cosine).max(MIN_FOLD)).sqrt();
        let side = if j % 4 < 2 { 1.0 } else { -1.0 };
        let [a, c] = if has_arm && j + 3 == points.len() {
            let sine = (1.0 - cosine * cosine).clamp(MIN_SINE_SQUARED, ARM_SINE * ARM_SINE).sqrt();
            [side * (1.0 - sine * sine).sqrt() / (sine * e), side / (sine * g)]
        } else {
            [e, g].map(|l| side * turn.max(least) / (2.0 * l))
        };
        for d in 0..3 {
            pattern[j][d] += a * normal[d];
            pattern[j + 1][d] -= (a - c) * normal[d];
            pattern[j + 2][d] -= c * normal[d];
        }
    }
    pattern
}

/// A direction across the line from the first to the last point.
fn across(points: &[[f64; 3]]) -> [f64; 3] {
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return [0.0; 3] };
    let line: [f64; 3] = std::array::from_fn(|c| last[c] - first[c]);
    // Square to the two larger coordinates' direction.
    let normal = if line[2].abs() > line[0].abs().max(line[1].abs()) {
        [0.0, -line[2], line[1]]
    } else {
        [-line[1], line[0], 0.0]
    };
    let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > MIN_EDGE_M { normal.map(|x| x / length) } else { [0.0, 0.0, 1.0] }
}

/// Values at the previous and the next node relative to the node between them.
#[derive(Clone, Copy)]
struct Triple<P: Pack> {
    before: Pack3<P>,
    after: Pack3<P>,
}

impl<P: Pack> Triple<P> {
    #[inline(always)]
    fn of(before: Pack3<P>, at: Pack3<P>, after: Pack3<P>) -> Self {
        Self { before: v3::sub(before, at), after: v3::sub(after, at) }
    }

    /// p self + q other
    #[inline(always)]
    fn mix(&self, p: P, q: P, other: &Self) -> Self {
        let mix = |s, o| v3::add_scaled(v3::scale(s, p), q, o);
        Self { before: mix(self.before, other.before), after: mix(self.after, other.after) }
    }

    /// s self
    #[inline(always)]
    fn scaled(&self, s: P) -> Self {
        Self { before: v3::scale(self.before, s), after: v3::scale(self.after, s) }
    }

    /// The share of the node between them of a quantity that sums to zero over the three.
    #[inline(always)]
    fn rest(&self) -> Pack3<P> {
        v3::neg(v3::add(self.before, self.after))
    }
}

/// The joints of a block and the velocities there.
#[inline(always)]
fn reach<T: Real, M: Machine<T>>(
    m: M,
    b: &RodBlock,
    nodes: &[Node<T>],
) -> (Joint<M::Pack>, Triple<M::Pack>) {
    let (x_before, v_before) = m.gather(nodes, &b.before);
    let (x, v) = m.gather(nodes, &b.at);
    let (x_after, v_after) = m.gather(nodes, &b.after);
    let joint = Joint::new(m, b.is_arm, &Triple::of(x_before, x, x_after));
    (joint, Triple::of(v_before, v, v_after))
}

/// The sum of a pack's lanes, always in the same order.
#[inline(always)]
fn total<T: Real, M: Machine<T>>(m: M, pack: M::Pack) -> T {
    m.store(pack).into_iter().fold(T::ZERO, |sum, x| sum + x)
}

/// Moves every rod's twist and adds its forces; `twists` has shape [R], in [rad]. Clamps that turn
/// about the rod's ends add their `rolls` [rad/s] to its rate, shape [R], or empty.
#[inline(always)]
pub(crate) fn rod_forces<T: Real, M: Machine<T>>(
    m: M,
    rods: &Rods<T>,
    dt: T,
    nodes: &[Node<T>],
    (twists, rolls): (&mut [T], &[T]),
    forces: &mut [Quad<T>],
) {
    for (r, (rod, twist)) in rods.rods.iter().zip(twists).enumerate() {
        let blocks = &rods.blocks[rod.blocks()];
        let mut sum = m.splat(T::ZERO);
        for b in blocks {
            let (joint, v) = reach(m, b, nodes);
            sum = sum + joint.along(&v);
        }
        let mut rate = total(m, sum);
        if let Some(&roll) = rolls.get(r) {
            rate += roll;
        }
        let rate = rate * rod.inverse_share;
        *twist += rate * dt;
        let torque = rod.stiffness * (*twist - rod.rest_twist) + rod.damping * rate;
        let push = m.splat(-torque);
        for b in blocks {
            let force = reach(m, b, nodes).0.gradient().scaled(push);
            m.scatter_add(forces, &b.before, force.before);
            m.scatter_add(forces, &b.at, force.rest());
            m.scatter_add(forces, &b.after, force.after);
        }
    }
}

/// Adjoint of [`rod_forces`]: given d loss / d force in `lambda`, adds d loss / d (position,
/// velocity) to `adjoint` and d loss / d parameters to `gradients`, and turns d loss / d twist
/// after the substep in `twist_bar` into that before it. `twists` are those before the substep;
/// d loss / d `rolls` is added to `roll_bar`, where there are any.
///
/// With torque_bar = -grad . lambda, twist_bar += k torque_bar and rate_bar = dt twist_bar +
/// damping torque_bar: `v_bar = rate_bar grad`, and the adjoint of grad is
/// `rate_bar v - torque lambda`.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
pub(crate) fn rod_adjoint<T: Real, M: Machine<T>>(
    m: M,
    rods: &Rods<T>,
    dt: T,
    nodes: &[Node<T>],
    (twists, rolls): (&[T], &[T]),
    lambda: &[Quad<T>],
    adjoint: &mut [Node<T>],
    (twist_bar, roll_bar): (&mut [T], &mut [T]),
    gradients: &mut [RodGradient<T>],
) {
    let each = rods.rods.iter().zip(twists).zip(twist_bar).zip(gradients);
    for (r, (((rod, &before), twist_bar), gradient)) in each.enumerate() {
        let blocks = &rods.blocks[rod.blocks()];
        let pull_of = |b: &RodBlock| {
            let [before, at, after] =
                [&b.before, &b.at, &b.after].map(|index| m.gather_quads(lambda, index));
            Triple::of(before, at, after)
        };
        let mut sums = [m.splat(T::ZERO); 2];
        for b in blocks {
            let (joint, v) = reach(m, b, nodes);
            sums = [sums[0] + joint.along(&v), sums[1] + joint.along(&pull_of(b))];
        }
        let [mut rate, pull] = sums.map(|sum| total(m, sum));
        if let Some(&roll) = rolls.get(r) {
            rate += roll;
        }
        let rate = rate * rod.inverse_share;
        let deviation = before + rate * dt - rod.rest_twist;
        let torque = rod.stiffness * deviation + rod.damping * rate;
        gradient.stiffness -= pull * deviation;
        gradient.damping -= pull * rate;
        gradient.rest_twist += pull * rod.stiffness;
        *twist_bar -= pull * rod.stiffness;
        let rate_bar = (dt * *twist_bar - rod.damping * pull) * rod.inverse_share;
        if let Some(roll_bar) = roll_bar.get_mut(r) {
            *roll_bar += rate_bar;
        }
        let (rate_bar, push) = (m.splat(rate_bar), m.splat(-torque));
        for b in blocks {
            let (joint, v) = reach(m, b, nodes);
            let x = joint.back(&v.mix(rate_bar, push, &pull_of(b)));
            let v = joint.gradient().scaled(rate_bar);
            m.scatter_add_nodes(adjoint, &b.before, x.before, v.before);
            m.scatter_add_nodes(adjoint, &b.at, x.rest(), v.rest());
            m.scatter_add_nodes(adjoint, &b.after, x.after, v.after);
        }
    }
}

#[cfg(test)]
mod tests;
