//! Upper bounds of the eigenvalues of `dt² K + 2 dt C`, from one pass over the elements: if one is
//! below the criterion, nothing need be estimated.
//!
//! **Coarse**: the largest sum of a row's norms, node by node (Gershgorin), as if all springs lay
//! in one line.
//!
//! **Fine**, at several times the cost: every element is a vector b (a spring's direction at its
//! two ends, a triplet's pattern at its three) with a weight w, and the matrix is the sum of
//! `w b bᵀ`. It has the eigenvalues of the matrix `w_f b_e·b_f` over elements e and f, however b
//! and w are scaled to each other, so none above the largest sum of a row's absolute values
//! (Gershgorin). With g the part of b at one end, Cauchy's inequality bounds the sum of a row
//! without visiting pairs:
//! `Σ_f w_f |g_e·g_f| <= sqrt(Σ_f w_f |g_f| · g_eᵀ (Σ_f w_f g_f g_fᵀ / |g_f|) g_e)`, sums over all
//! f at that end. For springs in all directions that is about 1.7 times less than the sum of their
//! weights. Tension's lateral stiffness, the same in all directions, is bounded node by node and
//! added. So is a rod's: the one eigenvalue of its pattern, at each of its nodes.

use super::linear::{Bar, Hinge, Linear, Vector, dot};

/// The fine bound is seldom less than the coarse one by more than this, and not tried beyond.
const FINENESS: f64 = 2.0;

/// Sums over what meets at an endpoint.
#[derive(Clone, Copy, Default)]
struct Joint {
    /// Σ w |g|.
    weight: f64,
    /// Σ w g gᵀ / |g|: xx, yy, zz, xy, yz, zx.
    moment: [f64; 6],
    /// Row sum of the lateral part.
    lateral: f64,
}

impl Joint {
    /// A part of this length in this direction.
    fn add(&mut self, weight: f64, length: f64, [x, y, z]: Vector) {
        let of = weight * length;
        self.weight += of;
        let parts = [x * x, y * y, z * z, x * y, y * z, z * x];
        self.moment.iter_mut().zip(parts).for_each(|(m, p)| *m += of * p);
    }

    /// Square of the bound of Σ w |g·f| over what meets here, for such a part.
    fn square(&self, length: f64, [x, y, z]: Vector) -> f64 {
        let [xx, yy, zz, xy, yz, zx] = self.moment;
        let moment = xx * x * x + yy * y * y + zz * z * z;
        let mixed = xy * x * y + yz * y * z + zx * z * x;
        length * length * self.weight * not_negative(moment + 2.0 * mixed)
    }
}

/// An element: its weight, and the direction and length of its part at each end.
struct Element<const ENDS: usize> {
    ends: [u32; ENDS],
    directions: [Vector; ENDS],
    lengths: [f64; ENDS],
    weight: f64,
}

impl<const ENDS: usize> Element<ENDS> {
    fn parts(&self) -> impl Iterator<Item = (usize, f64, Vector)> {
        (0..ENDS).map(|e| (self.ends[e] as usize, self.lengths[e], self.directions[e]))
    }

    fn add_to(&self, joints: &mut [Joint]) {
        self.parts().for_each(|(e, length, g)| joints[e].add(self.weight, length, g));
    }

    /// The larger of `most` and the bound of the sum of its row; an element without weight has
    /// none.
    fn larger(&self, joints: &[Joint], most: f64) -> f64 {
        if self.weight == 0.0 {
            return most;
        }
        let mut squares = [0.0; ENDS];
        for (square, (e, length, g)) in squares.iter_mut().zip(self.parts()) {
            *square = joints[e].square(length, g);
        }
        // The sum of roots is at most this, for the price of none.
        if squares.iter().sum::<f64>() * ENDS as f64 <= most * most {
            return most;
        }
        larger(most, squares.iter().map(|s| s.sqrt()).sum())
    }
}

/// Zero for what rounding or a spring without direction made negative; NaN stays.
fn not_negative(x: f64) -> f64 {
    if x < 0.0 { 0.0 } else { x }
}

/// The larger of two; NaN is never lost.
fn larger(most: f64, x: f64) -> f64 {
    if x > most || x.is_nan() { x } else { most }
}

/// True if a bound proves that no eigenvalue of `dt² K + 2 dt C` is larger than `limit`.
pub(super) fn is_below(system: &Linear, dt: f64, limit: f64) -> bool {
    let coarse = coarse(system, dt);
    coarse <= limit || coarse <= limit * FINENESS && fine(system, dt) <= limit
}

/// No eigenvalue of `dt² K + 2 dt C` is larger than this; NaN if numbers overflow.
fn coarse(system: &Linear, dt: f64) -> f64 {
    let rate = |stiffness: f64, damping: f64| dt * dt * stiffness + 2.0 * dt * damping;
    let root = |e: u32| system.roots[e as usize];
    let mut rows = vec![0.0; system.roots.len()];
    for b in &system.bars {
        let weight = rate(b.along.max(b.across), b.damping);
        let [i, j] = b.ends.map(root);
        rows[b.ends[0] as usize] += weight * i * (i + j);
        rows[b.ends[1] as usize] += weight * j * (i + j);
    }
    for h in &system.hinges {
        let weight = rate(h.stiffness, h.damping);
        let mut lengths = h.pattern.map(|g| dot(g, g).sqrt());
        lengths.iter_mut().zip(h.ends).for_each(|(l, e)| *l *= root(e));
        let sum: f64 = lengths.iter().sum();
        for (e, length) in h.ends.into_iter().zip(lengths) {
            rows[e as usize] += weight * length * sum;
        }
    }
    add_twists(system, rate, &mut rows);
    rows.into_iter().fold(0.0, larger)
}

/// A sharper bound than [`coarse`].
fn fine(system: &Linear, dt: f64) -> f64 {
    let rate = |stiffness: f64, damping: f64| dt * dt * stiffness + 2.0 * dt * damping;
    let root = |e: u32| system.roots[e as usize];
    let bar = |b: &Bar| {
        // Which way a part points makes no difference.
        let (directions, lengths) = ([b.direction; 2], b.ends.map(root));
        let weight = not_negative(rate(b.along, b.damping) - rate(b.across, 0.0));
        Element { ends: b.ends, directions, lengths, weight }
    };
    let hinge = |h: &Hinge| {
        // As long as a spring's, for rows of long vectors with small weights would count too much.
        let square = 0.5 * h.pattern.iter().map(|&g| dot(g, g)).sum::<f64>();
        let lengths = h.pattern.map(|g| dot(g, g).sqrt());
        let unit = |e: usize| h.pattern[e].map(|x| x / lengths[e].max(f64::MIN_POSITIVE));
        let directions = std::array::from_fn(unit);
        let scale = square.max(f64::MIN_POSITIVE).sqrt().recip();
        let lengths = std::array::from_fn(|e| lengths[e] * scale * root(h.ends[e]));
        let weight = rate(h.stiffness, h.damping) * square;
        Element { ends: h.ends, directions, lengths, weight }
    };
    let bars = || system.bars.iter().map(bar);
    let hinges = || system.hinges.iter().map(hinge);
    let mut joints = vec![Joint::default(); system.roots.len()];
    bars().for_each(|e| e.add_to(&mut joints));
    hinges().for_each(|e| e.add_to(&mut joints));
    for b in system.bars.iter().filter(|b| b.across > 0.0) {
        let [i, j] = b.ends;
        for (e, other) in [(i, j), (j, i)] {
            joints[e as usize].lateral += rate(b.across, 0.0) * root(e) * (root(e) + root(other));
        }
    }
    let mut rows: Vec<f64> = joints.iter().map(|j| j.lateral).collect();
    add_twists(system, rate, &mut rows);
    let most = bars().fold(0.0, |most, e| e.larger(&joints, most));
    let most = hinges().fold(most, |most, e| e.larger(&joints, most));
    most + rows.into_iter().fold(0.0, larger)
}

/// Adds what no eigenvalue of a rod's part exceeds to each of its nodes.
fn add_twists(system: &Linear, rate: impl Fn(f64, f64) -> f64, rows: &mut [f64]) {
    for t in &system.twists {
        let most = rate(t.stiffness, t.damping) * t.square(&system.roots);
        t.ends.iter().for_each(|&e| rows[e as usize] += most);
    }
}

/// Both bounds, for tests of how near the truth they are.
#[cfg(test)]
pub(super) fn of(system: &Linear, dt: f64) -> [f64; 2] {
    [coarse(system, dt), fine(system, dt)]
}

#[cfg(test)]
mod tests;
