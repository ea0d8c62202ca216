//! A square of an image around a point, cut out to be found again.

use super::layer::Level;

/// The pixels around a point.
#[derive(Clone, Debug)]
pub(crate) struct Patch {
    /// The pixels of the window that show the point's region.
    pub(crate) samples: Vec<Sample>,
    /// Share of the window that they make up by weight, 0 to 1.
    pub(crate) support: f32,
}

/// A pixel of a patch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    /// From the point to the pixel, in pixels of the full image.
    pub(crate) offset: [f32; 2],
    /// Red, green, blue, 0 to 1.
    pub(crate) color: [f32; 3],
    /// Change of each channel per pixel of the full image to the right and downwards.
    pub(crate) gradient: [[f32; 3]; 2],
    /// Pixels near the point count more.
    pub(crate) weight: f32,
}

impl Patch {
    /// A window of `side` x `side` of a level's pixels, centred at a place of the full image.
    pub(crate) fn cut(level: &Level, at: [f64; 2], side: usize) -> Self {
        let half = (side / 2) as i32;
        let grid = (side + 2) as i32;
        let offset = |i: i32| (i - half - 1) as f32 * level.step;
        let at = at.map(|v| v as f32);
        let pixels: Vec<_> = (0..grid * grid)
            .map(|i| level.sample([at[0] + offset(i % grid), at[1] + offset(i / grid)]))
            .collect();
        // At the window's rim the weight has fallen to 0.2.
        let spread = 2.0 * 1.6 / (half * half).max(1) as f32;
        let mut samples = Vec::with_capacity(side * side);
        let (mut found, mut possible) = (0.0, 0.0);
        for row in 1..grid - 1 {
            for column in 1..grid - 1 {
                let i = (row * grid + column) as usize;
                let (x, y) = ((column - half - 1) as f32, (row - half - 1) as f32);
                let weight = (-0.5 * spread * (x * x + y * y)).exp();
                possible += weight;
                let (above, below) = (i - grid as usize, i + grid as usize);
                let (Some(here), Some(left), Some(right), Some(up), Some(down)) =
                    (pixels[i], pixels[i - 1], pixels[i + 1], pixels[above], pixels[below])
                else {
                    continue;
                };
                let weight = weight * here.1;
                let slope = |a: [f32; 3], b: [f32; 3]| {
                    std::array::from_fn(|c| (b[c] - a[c]) / (2.0 * level.step))
                };
                found += weight;
                samples.push(Sample {
                    offset: [x * level.step, y * level.step],
                    color: here.0,
                    gradient: [slope(left.0, right.0), slope(up.0, down.0)],
                    weight,
                });
            }
        }
        Self { samples, support: found / possible }
    }

    /// Root mean square of the gradient in the direction in which it is weakest, per pixel, summed
    /// over channels: how well the patch can be located.
    pub(crate) fn texture(&self) -> f32 {
        let (mut xx, mut xy, mut yy, mut weights) = (0.0, 0.0, 0.0, 0.0);
        for sample in &self.samples {
            let [x, y] = &sample.gradient;
            for c in 0..3 {
                xx += sample.weight * x[c] * x[c];
                xy += sample.weight * x[c] * y[c];
                yy += sample.weight * y[c] * y[c];
            }
            weights += sample.weight;
        }
        if weights <= 0.0 {
            return 0.0;
        }
        (smallest_eigenvalue(xx, xy, yy).max(0.0) / weights).sqrt()
    }
}

/// Smallest eigenvalue of the symmetric matrix [[xx, xy], [xy, yy]].
pub(crate) fn smallest_eigenvalue(xx: f32, xy: f32, yy: f32) -> f32 {
    0.5 * (xx + yy) - (0.25 * (xx - yy) * (xx - yy) + xy * xy).sqrt()
}
