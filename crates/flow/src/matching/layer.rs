//! A region of an image as a pyramid, without its surroundings.
//!
//! Pixels are kept as colour times coverage and coverage, so that every blur, decimation and
//! interpolation is a normalised convolution: what lies outside the mask has no weight, at any
//! level. A layer covers the region's bounding box only.

use bendtwin_capture::raw::ColorImage;

#[cfg(test)]
mod tests;

/// A pyramid; level `l` has a pixel for every 2^l pixels of the image, the first pixels' centres
/// coincide.
#[derive(Debug)]
pub(crate) struct Layer {
    pub(crate) levels: Vec<Level>,
}

/// A level of the pyramid.
#[derive(Debug)]
pub(crate) struct Level {
    /// Pixels of the image per pixel of this level.
    pub(crate) step: f32,
    /// The image's pixel at which the first pixel lies.
    origin: [f32; 2],
    width: usize,
    height: usize,
    /// Red, green, blue (0 to 1) times coverage, coverage.
    pixels: Vec<[f32; 4]>,
}

/// Least coverage of a sample with a known colour.
const MIN_COVERAGE: f32 = 0.1;

impl Layer {
    /// The part of `color` where `inside` is true, blurred by `smoothing` pixels; `None` if no
    /// pixel is inside.
    pub(crate) fn new(
        color: &ColorImage,
        inside: &[bool],
        smoothing: f64,
        levels: usize,
    ) -> Option<Self> {
        let (left, top, right, bottom) = bounding_box(color.width, inside)?;
        // The corner is a pixel of every level; room for the blur at the rim.
        let grid = 1 << (levels - 1);
        let (left, top) =
            (left.saturating_sub(4) / grid * grid, top.saturating_sub(4) / grid * grid);
        let (width, height) =
            ((right + 5).min(color.width) - left, (bottom + 5).min(color.height) - top);
        let mut pixels = Vec::with_capacity(width * height);
        for row in top..top + height {
            for column in left..left + width {
                let i = row * color.width + column;
                pixels.push(if inside[i] {
                    let [r, g, b] = color.pixels[i].map(|v| f32::from(v) / 255.0);
                    [r, g, b, 1.0]
                } else {
                    [0.0; 4]
                });
            }
        }
        let mut finest =
            Level { step: 1.0, origin: [left as f32, top as f32], width, height, pixels };
        if smoothing > 0.0 {
            finest.blur(&gaussian(smoothing));
        }
        let mut all = vec![finest];
        while all.len() < levels {
            let coarser = all[all.len() - 1].halved();
            all.push(coarser);
        }
        Some(Self { levels: all })
    }
}

impl Level {
    /// Colour at a place of the full image and the coverage there; `None` where the region has no
    /// pixel near.
    #[inline]
    pub(crate) fn sample(&self, at: [f32; 2]) -> Option<([f32; 3], f32)> {
        let x = (at[0] - self.origin[0]) / self.step;
        let y = (at[1] - self.origin[1]) / self.step;
        let within = |v: f32, pixels: usize| v >= 0.0 && v + 1.0 < pixels as f32;
        if !(within(x, self.width) && within(y, self.height)) {
            return None;
        }
        let (column, row) = (x as usize, y as usize);
        let (u, v) = (x - column as f32, y - row as f32);
        let i = row * self.width + column;
        let (upper, lower) =
            (&self.pixels[i..i + 2], &self.pixels[i + self.width..i + self.width + 2]);
        let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
        let mut sum = [0.0; 4];
        for (c, sum) in sum.iter_mut().enumerate() {
            *sum = weights[0] * upper[0][c]
                + weights[1] * upper[1][c]
                + weights[2] * lower[0][c]
                + weights[3] * lower[1][c];
        }
        let coverage = sum[3];
        (coverage > MIN_COVERAGE)
            .then(|| ([sum[0] / coverage, sum[1] / coverage, sum[2] / coverage], coverage))
    }

    /// Half as many columns and rows, after the usual binomial blur.
    fn halved(&self) -> Self {
        let mut blurred = Self { pixels: self.pixels.clone(), ..*self };
        blurred.blur(&[1.0 / 16.0, 0.25, 0.375, 0.25, 1.0 / 16.0]);
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let pixels = (0..height)
            .flat_map(|row| (0..width).map(move |column| (row, column)))
            .map(|(row, column)| blurred.pixels[2 * row * self.width + 2 * column])
            .collect();
        Self { step: self.step * 2.0, origin: self.origin, width, height, pixels }
    }

    /// Separable convolution; beyond the rim there is nothing.
    fn blur(&mut self, kernel: &[f32]) {
        let mut line = Vec::new();
        for row in self.pixels.chunks_mut(self.width) {
            line.clear();
            line.extend_from_slice(row);
            convolve(&line, kernel, row, 0, 1);
        }
        for column in 0..self.width {
            line.clear();
            line.extend((0..self.height).map(|row| self.pixels[row * self.width + column]));
            convolve(&line, kernel, &mut self.pixels, column, self.width);
        }
    }
}

fn convolve(line: &[[f32; 4]], kernel: &[f32], out: &mut [[f32; 4]], first: usize, stride: usize) {
    let half = kernel.len() / 2;
    for i in 0..line.len() {
        let from = i.saturating_sub(half);
        let to = (i + half + 1).min(line.len());
        let mut sum = [0.0; 4];
        for (pixel, weight) in line[from..to].iter().zip(&kernel[from + half - i..]) {
            for c in 0..4 {
                sum[c] += weight * pixel[c];
            }
        }
        out[first + i * stride] = sum;
    }
}

fn gaussian(sigma: f64) -> Vec<f32> {
    let half = (3.0 * sigma).ceil() as i32;
    let weights: Vec<f64> =
        (-half..=half).map(|i| (-0.5 * (f64::from(i) / sigma).powi(2)).exp()).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|w| (w / sum) as f32).collect()
}

/// First and last column and row in which anything is inside.
fn bounding_box(width: usize, inside: &[bool]) -> Option<(usize, usize, usize, usize)> {
    let mut found: Option<(usize, usize, usize, usize)> = None;
    for (row, line) in inside.chunks(width).enumerate() {
        let Some(first) = line.iter().position(|&i| i) else { continue };
        let last = line.iter().rposition(|&i| i).unwrap_or(first);
        let (left, top, right, _) = found.unwrap_or((first, row, last, row));
        found = Some((left.min(first), top, right.max(last), row));
    }
    found
}
