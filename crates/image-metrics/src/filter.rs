//! Separable filters: one kernel along rows, another along columns.

use rayon::prelude::*;

use crate::planes::Plane;

/// Rows that a thread takes at a time.
const BAND: usize = 16;

/// Values beyond the border of a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Border {
    /// Zero.
    Zero,
    /// The nearest value of the plane.
    Nearest,
}

/// Plane after a correlation with `along_x` in each row and `along_y` in each column. Both have an
/// odd length and their centre in the middle:
/// out[y, x] = sum over i, j of along_y[j] along_x[i] in[y + j - r_y, x + i - r_x].
pub(crate) fn separable(plane: &Plane, along_x: &[f32], along_y: &[f32], border: Border) -> Plane {
    columns(&rows(plane, along_x, border), along_y, border)
}

fn rows(plane: &Plane, kernel: &[f32], border: Border) -> Plane {
    let (width, radius) = (plane.width, kernel.len() / 2);
    let mut values = vec![0.0; plane.values.len()];
    let bands = plane.values.par_chunks(BAND * width).zip(values.par_chunks_mut(BAND * width));
    bands.for_each(|(from, to)| {
        let mut padded = vec![0.0; width + 2 * radius];
        for (row, out) in from.chunks_exact(width).zip(to.chunks_exact_mut(width)) {
            if border == Border::Nearest {
                padded[..radius].fill(row[0]);
                padded[radius + width..].fill(row[width - 1]);
            }
            padded[radius..radius + width].copy_from_slice(row);
            for (i, weight) in kernel.iter().enumerate() {
                add_scaled(out, &padded[i..i + width], *weight);
            }
        }
    });
    Plane { values, ..*plane }
}

fn columns(plane: &Plane, kernel: &[f32], border: Border) -> Plane {
    let (width, height) = (plane.width, plane.height);
    let radius = kernel.len() / 2;
    let mut values = vec![0.0; plane.values.len()];
    let rows = values.par_chunks_exact_mut(width).with_min_len(BAND).enumerate();
    rows.for_each(|(y, out)| {
        for (j, weight) in kernel.iter().enumerate() {
            let from = match (border, (y + j).checked_sub(radius)) {
                (_, Some(from)) if from < height => from,
                (Border::Zero, _) => continue,
                (Border::Nearest, None) => 0,
                (Border::Nearest, Some(_)) => height - 1,
            };
            add_scaled(out, &plane.values[from * width..][..width], *weight);
        }
    });
    Plane { values, ..*plane }
}

fn add_scaled(sum: &mut [f32], values: &[f32], weight: f32) {
    for (sum, value) in sum.iter_mut().zip(values) {
        *sum += weight * value;
    }
}

/// Gaussian kernel exp(-x² / (2 σ²)) of 2 `radius` + 1 values whose sum is 1; σ in pixels.
pub(crate) fn gaussian(sigma: f64, radius: usize) -> Vec<f32> {
    let mut values = sampled(radius, |x| (-x * x / (2.0 * sigma * sigma)).exp());
    let sum: f64 = values.iter().sum();
    values.iter_mut().for_each(|v| *v /= sum);
    values.into_iter().map(|v| v as f32).collect()
}

/// Function at the whole numbers from -`radius` to `radius`.
pub(crate) fn sampled(radius: usize, value: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..=2 * radius).map(|i| value(i as f64 - radius as f64)).collect()
}

#[cfg(test)]
mod tests;
