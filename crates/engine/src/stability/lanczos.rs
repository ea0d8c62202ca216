//! The largest eigenvalue's vector of `dt² K + 2 dt C` at one dt, by Lanczos iteration.
//!
//! After m applications of the operator the error of the eigenvalue falls like 1/m² at worst, where
//! power iteration has 1/m. Vectors are in f32: the vector's error counts only squared in what
//! [`super`] makes of it.

use super::linear::{Linear, Vector};

/// Relative growth of the largest eigenvalue in a step, below which it has converged.
const TOLERANCE: f64 = 1e-3;
/// Steps below [`TOLERANCE`] that count as convergence.
const PATIENCE: usize = 2;
/// Bisections of the interval in which an eigenvalue lies.
const BISECTIONS: usize = 40;

/// A vector at an endpoint, and a zero for the sake of alignment.
type Lane = [f32; 4];

/// A spring at its first end, as the operator needs it.
#[derive(Clone, Copy, Default)]
struct Bar {
    /// Times the root of what it has along more than across.
    direction: Lane,
    across: f32,
    other: u32,
}

/// A triplet's pattern, times the root of its weight and those of its ends.
struct Hinge {
    ends: [u32; 3],
    pattern: [Lane; 3],
}

/// A rod's pattern, as a triplet's.
struct Twist {
    ends: Vec<u32>,
    pattern: Vec<Lane>,
}

/// `dt² K + 2 dt C`.
pub(super) struct Operator {
    roots: Vec<f32>,
    /// Index of each endpoint's first bar, and the number of bars.
    starts: Vec<u32>,
    bars: Vec<Bar>,
    hinges: Vec<Hinge>,
    twists: Vec<Twist>,
}

impl Operator {
    pub(super) fn new(system: &Linear, dt: f64) -> Self {
        let mut starts = vec![0_u32; system.roots.len() + 1];
        for b in &system.bars {
            starts[b.ends[0] as usize + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut next = starts.clone();
        let mut bars = vec![Bar::default(); system.bars.len()];
        for b in &system.bars {
            let across = dt * dt * b.across;
            // Never negative: across exceeds along only where there is no direction.
            let more = (dt * dt * b.along + 2.0 * dt * b.damping - across).max(0.0).sqrt();
            let place = &mut next[b.ends[0] as usize];
            bars[*place as usize] =
                Bar { direction: lane(b.direction, more), across: across as f32, other: b.ends[1] };
            *place += 1;
        }
        let hinge = |h: &super::linear::Hinge| {
            let weight = (dt * dt * h.stiffness + 2.0 * dt * h.damping).sqrt();
            let pattern = std::array::from_fn(|e| {
                lane(h.pattern[e], weight * system.roots[h.ends[e] as usize])
            });
            Hinge { ends: h.ends, pattern }
        };
        let hinges = system.hinges.iter().map(hinge).collect();
        let twist = |t: &super::linear::Twist| {
            let weight = (dt * dt * t.stiffness + 2.0 * dt * t.damping).sqrt();
            let parts = t.ends.iter().zip(&t.pattern);
            let pattern = parts.map(|(&e, &g)| lane(g, weight * system.roots[e as usize]));
            Twist { ends: t.ends.clone(), pattern: pattern.collect() }
        };
        let twists = system.twists.iter().map(twist).collect();
        let roots = system.roots.iter().map(|&r| r as f32).collect();
        Self { roots, starts, bars, hinges, twists }
    }

    /// Writes the operator times `v` into `out`; `moved` is scratch space.
    fn apply(&self, v: &[Lane], moved: &mut [Lane], out: &mut [Lane]) {
        for ((m, o), (v, root)) in moved.iter_mut().zip(&mut *out).zip(v.iter().zip(&self.roots)) {
            (*m, *o) = (v.map(|x| root * x), [0.0; 4]);
        }
        for (i, range) in self.starts.windows(2).enumerate() {
            let own = moved[i];
            let mut sum = [0.0; 4];
            for b in &self.bars[range[0] as usize..range[1] as usize] {
                let far = moved[b.other as usize];
                let r: Lane = std::array::from_fn(|c| far[c] - own[c]);
                let along = product(&r, &b.direction);
                let end = &mut out[b.other as usize];
                for c in 0..4 {
                    let f = b.across * r[c] + along * b.direction[c];
                    sum[c] += f;
                    end[c] += f;
                }
            }
            for c in 0..4 {
                out[i][c] -= sum[c];
            }
        }
        for (o, root) in out.iter_mut().zip(&self.roots) {
            *o = o.map(|x| root * x);
        }
        for h in &self.hinges {
            project(&h.ends, &h.pattern, v, out);
        }
        for t in &self.twists {
            project(&t.ends, &t.pattern, v, out);
        }
    }

    /// The best approximation of the stiffest mode after at most `steps` applications, beginning at
    /// `start`.
    pub(super) fn stiffest(&self, start: &[Vector], steps: usize) -> Vec<Vector> {
        let length = start.iter().flatten().map(|x| x * x).sum::<f64>().sqrt();
        if !(length > 0.0 && length.is_finite()) {
            return start.to_vec();
        }
        let first = start.iter().map(|&v| lane(v, length.recip()));
        let mut basis: Vec<Vec<Lane>> = vec![first.collect()];
        let mut moved = vec![[0.0; 4]; start.len()];
        let (mut diagonal, mut beside) = (Vec::new(), Vec::new());
        let (mut largest, mut calm) = (0.0, 0);
        for step in 0..steps {
            let mut next = vec![[0.0; 4]; start.len()];
            self.apply(&basis[step], &mut moved, &mut next);
            let alpha = inner(&next, &basis[step]);
            if !alpha.is_finite() {
                break;
            }
            subtract(&mut next, alpha, &basis[step]);
            if let (Some(beta), Some(before)) = (beside.last(), step.checked_sub(1)) {
                subtract(&mut next, *beta, &basis[before]);
            }
            diagonal.push(alpha);
            let theta = largest_eigenvalue(&diagonal, &beside);
            calm = if theta - largest < TOLERANCE * theta { calm + 1 } else { 0 };
            largest = theta;
            let beta = inner(&next, &next).sqrt();
            // The second condition: no vector leads out of the space that was seen, but for
            // rounding.
            if calm >= PATIENCE || beta.is_nan() || beta <= 1e-5 * theta {
                break;
            }
            beside.push(beta);
            let scale = beta.recip() as f32;
            next.iter_mut().flatten().for_each(|x| *x *= scale);
            basis.push(next);
        }
        if diagonal.is_empty() {
            return start.to_vec();
        }
        let weights = eigenvector(&diagonal, &beside, largest);
        let mut mode = vec![[0.0; 3]; start.len()];
        for (weight, vector) in weights.iter().zip(&basis) {
            for (m, v) in mode.iter_mut().zip(vector) {
                *m = std::array::from_fn(|c| m[c] + weight * f64::from(v[c]));
            }
        }
        mode
    }
}

/// Adds a pattern times what a vector has of it.
fn project(ends: &[u32], pattern: &[Lane], v: &[Lane], out: &mut [Lane]) {
    let parts = ends.iter().zip(pattern);
    let share: f32 = parts.map(|(e, p)| product(&v[*e as usize], p)).sum();
    for (e, p) in ends.iter().zip(pattern) {
        let end = &mut out[*e as usize];
        for c in 0..4 {
            end[c] += share * p[c];
        }
    }
}

fn lane(vector: Vector, scale: f64) -> Lane {
    let [x, y, z] = vector.map(|x| (x * scale) as f32);
    [x, y, z, 0.0]
}

fn product(a: &Lane, b: &Lane) -> f32 {
    let parts: Lane = std::array::from_fn(|c| a[c] * b[c]);
    (parts[0] + parts[2]) + (parts[1] + parts[3])
}

fn inner(a: &[Lane], b: &[Lane]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(product(a, b))).sum()
}

fn subtract(from: &mut [Lane], factor: f64, vector: &[Lane]) {
    let factor = factor as f32;
    for (f, v) in from.iter_mut().zip(vector) {
        *f = std::array::from_fn(|c| f[c] - factor * v[c]);
    }
}

/// Largest eigenvalue of the symmetric tridiagonal matrix with the given diagonal and off-diagonal.
fn largest_eigenvalue(diagonal: &[f64], beside: &[f64]) -> f64 {
    let most = |values: &[f64]| values.iter().fold(f64::NEG_INFINITY, |m, x| m.max(*x));
    let mut low = most(diagonal);
    let mut high = low + 2.0 * most(beside).max(0.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if is_above(diagonal, beside, middle) { high = middle } else { low = middle }
    }
    high
}

/// True if a number is above all eigenvalues: every pivot of the matrix less that number is
/// negative.
fn is_above(diagonal: &[f64], beside: &[f64], x: f64) -> bool {
    let mut pivot = -1.0;
    for (i, d) in diagonal.iter().enumerate() {
        let b = i.checked_sub(1).map_or(0.0, |before| beside[before]);
        pivot = d - x - b * b / pivot;
        if pivot >= 0.0 {
            return false;
        }
    }
    true
}

/// The eigenvector of the largest eigenvalue, by two inverse iterations from just above it, where
/// the matrix is definite and elimination needs no pivoting. The off-diagonal entries are positive,
/// so that vector is positive, too, and ones are a valid start.
fn eigenvector(diagonal: &[f64], beside: &[f64], largest: f64) -> Vec<f64> {
    let shift = largest + (1e-9 * largest.abs()).max(f64::MIN_POSITIVE);
    let n = diagonal.len();
    let mut x = vec![1.0; n];
    for _ in 0..2 {
        let mut pivots = vec![0.0; n];
        for i in 0..n {
            let (b, before) = match i.checked_sub(1) {
                Some(before) => (beside[before] / pivots[before], before),
                None => (0.0, 0),
            };
            pivots[i] = diagonal[i] - shift - if i > 0 { b * beside[before] } else { 0.0 };
            x[i] -= b * x[before];
        }
        for i in (0..n).rev() {
            let after = if i + 1 < n { beside[i] * x[i + 1] } else { 0.0 };
            x[i] = (x[i] - after) / pivots[i];
        }
        let length = x.iter().map(|x| x * x).sum::<f64>().sqrt();
        x.iter_mut().for_each(|x| *x /= length);
    }
    x
}

#[cfg(test)]
mod tests;
