//! Colours of the parts of a scene, as histograms.

use nalgebra::{Matrix3, Vector3};

/// Bins along each of red, green and blue.
const BINS: usize = 16;
/// Weights of a bin and of its neighbours: light changes, and a few clicks do not show every shade.
const BLUR: [f32; 3] = [0.25, 0.5, 0.25];
/// Share of any colour in a part: what was never seen of it is not impossible.
const UNSEEN: f32 = 0.03;

/// Relative frequency of colours.
#[derive(Clone, Debug)]
pub(crate) struct Colors {
    counts: Vec<f32>,
    total: f32,
}

/// Colours with their logarithmic densities, relative to all colours being equally frequent.
#[derive(Clone, Debug)]
pub(crate) struct Densities(Vec<f32>);

/// Bin of a colour.
pub(crate) fn bin(color: [u8; 3]) -> usize {
    let [r, g, b] = color.map(|c| usize::from(c) * BINS / 256);
    (r * BINS + g) * BINS + b
}

impl Default for Colors {
    fn default() -> Self {
        Self { counts: vec![0.0; BINS * BINS * BINS], total: 0.0 }
    }
}

impl Colors {
    pub(crate) fn add(&mut self, bin: usize, weight: f32) {
        self.counts[bin] += weight;
        self.total += weight;
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.total <= 0.0
    }

    /// Sum of all weights.
    pub(crate) fn total(&self) -> f32 {
        self.total
    }

    /// Adds another histogram, scaled to a total.
    pub(crate) fn mix(&mut self, other: &Self, total: f32) {
        if other.is_empty() {
            return;
        }
        let scale = total / other.total;
        self.counts.iter_mut().zip(&other.counts).for_each(|(a, b)| *a += scale * b);
        self.total += total;
    }

    /// Scales the total.
    pub(crate) fn scale(&mut self, by: f32) {
        self.counts.iter_mut().for_each(|c| *c *= by);
        self.total *= by;
    }

    /// Densities of a part that has been seen; all equal if it has not.
    pub(crate) fn densities(&self) -> Densities {
        if self.is_empty() {
            return Densities(vec![0.0; self.counts.len()]);
        }
        let blurred = self.blurred();
        let n = self.counts.len() as f32;
        let seen = (1.0 - UNSEEN) * n / self.total;
        Densities(blurred.iter().map(|c| (UNSEEN + seen * c).ln()).collect())
    }

    /// Share that two parts have in common by mean and spread of their colours alone, 0..=1 (the
    /// Bhattacharyya coefficient of normal distributions).
    pub(crate) fn likeness(&self, other: &Self) -> f32 {
        if self.is_empty() || other.is_empty() {
            return 0.0;
        }
        let ((mean, spread), (other_mean, other_spread)) = (self.moments(), other.moments());
        let both = (spread + other_spread) / 2.0;
        let off = mean - other_mean;
        let Some(inverse) = both.try_inverse() else { return 0.0 };
        let apart = off.dot(&(inverse * off)) / 8.0;
        let sizes = (spread.determinant() * other_spread.determinant()).sqrt();
        let shapes = 0.5 * (both.determinant() / sizes.max(f64::MIN_POSITIVE)).ln();
        (-apart - shapes).exp() as f32
    }

    /// Mean and covariance of the colours, in bins.
    fn moments(&self) -> (Vector3<f64>, Matrix3<f64>) {
        let place =
            |at: usize| Vector3::from([BINS * BINS, BINS, 1].map(|step| (at / step % BINS) as f64));
        let seen = || self.counts.iter().enumerate().filter(|(_, count)| **count > 0.0);
        let total = f64::from(self.total);
        let mean = seen().map(|(at, n)| place(at) * f64::from(*n)).sum::<Vector3<f64>>() / total;
        // A bin is as wide as its colours differ at least.
        let mut spread = Matrix3::identity() / 12.0;
        for (at, count) in seen() {
            let off = place(at) - mean;
            spread += off * off.transpose() * (f64::from(*count) / total);
        }
        (mean, spread)
    }

    fn blurred(&self) -> Vec<f32> {
        let mut values = self.counts.clone();
        for step in [BINS * BINS, BINS, 1] {
            let before = values.clone();
            for (at, value) in values.iter_mut().enumerate() {
                let place = at / step % BINS;
                // The rim keeps what would fall outside.
                let low = if place > 0 { before[at - step] } else { before[at] };
                let high = if place + 1 < BINS { before[at + step] } else { before[at] };
                *value = BLUR[0] * low + BLUR[1] * before[at] + BLUR[2] * high;
            }
        }
        values
    }
}

impl Densities {
    pub(crate) fn of(&self, bin: usize) -> f32 {
        self.0[bin]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_colour_is_likelier_in_its_part() {
        let mut red = Colors::default();
        (0..50).for_each(|k| red.add(bin([200 + k / 5, 40, 40]), 1.0));
        let mut blue = Colors::default();
        (0..50).for_each(|k| blue.add(bin([40, 40, 200 + k / 5]), 1.0));
        let (r, b) = (red.densities(), blue.densities());
        let at = bin([204, 42, 38]);
        assert!(r.of(at) > 3.0 && b.of(at) < -3.0);
        assert!(red.likeness(&blue) < 0.01 && red.likeness(&red) > 0.99);
        assert_eq!(Colors::default().densities().of(at), 0.0);
        let mass: f32 = red.blurred().iter().sum();
        assert!((mass - red.total()).abs() < 1e-2);
    }
}
