//! Structural similarity, and its gradient for training.

mod window;

use rayon::prelude::*;

use self::window::{C1, C2, Moments, smooth};
use crate::{
    Pair,
    planes::{PIECE, Plane, channels},
};

/// Structural similarity, -1 to 1, of Wang et al., "Image quality assessment: from error visibility
/// to structural similarity" (2004): the mean over pixels and channels of
///
/// ```text
/// (2 μx μy + C1) (2 σxy + C2) / ((μx² + μy² + C1) (σx² + σy² + C2))
/// ```
///
/// with C1 = 0.01² and C2 = 0.03² for colours from 0 to 1, and means, variances and the covariance
/// in a Gaussian window of 11 x 11 pixels with σ = 1.5. Beyond the border of the images is black, as
/// in PhysTwin's evaluation, so that the result has a value at every pixel.
pub fn ssim(pair: &Pair<'_>) -> f64 {
    Reference::new(pair).ssim(pair)
}

/// [`ssim`], and its gradient with respect to the colours of the pair's image, shape
/// [height, width, 3]; zero at pixels that do not count.
pub fn ssim_with_gradient(pair: &Pair<'_>) -> (f64, Vec<[f32; 3]>) {
    Reference::new(pair).ssim_with_gradient(pair)
}

/// The parts of [`ssim`] that depend on the reference alone, for many images that are compared
/// with one reference and one mask.
pub struct Reference {
    channels: [(Plane, Moments); 3],
}

impl Reference {
    /// Reference of a pair and its mask.
    pub fn new(pair: &Pair<'_>) -> Self {
        let planes = channels(pair, pair.reference());
        let channels = planes.map(|plane| {
            let moments = Moments::of(&plane);
            (plane, moments)
        });
        Self { channels }
    }

    /// [`ssim`] of a pair with this reference.
    pub fn ssim(&self, pair: &Pair<'_>) -> f64 {
        let planes = channels(pair, pair.image());
        let work: Vec<_> = planes.iter().zip(&self.channels).collect();
        let sums: Vec<f64> =
            work.into_par_iter().map(|(x, (y, of_y))| Similarity::new(x, y, of_y).sum()).collect();
        sums.iter().sum::<f64>() / (3 * pair.pixel_count()) as f64
    }

    /// [`ssim_with_gradient`] of a pair with this reference. The order of sums does not depend on
    /// the number of threads.
    pub fn ssim_with_gradient(&self, pair: &Pair<'_>) -> (f64, Vec<[f32; 3]>) {
        let planes = channels(pair, pair.image());
        let work: Vec<_> = planes.iter().zip(&self.channels).collect();
        let parts: Vec<(f64, Plane)> = work
            .into_par_iter()
            .map(|(x, (y, of_y))| {
                let locals = Similarity::new(x, y, of_y).locals();
                let sum = locals.iter().map(|l| f64::from(l.value)).sum();
                (sum, gradient(&locals, x, y))
            })
            .collect();
        let count = 3 * pair.pixel_count();
        let sum: f64 = parts.iter().map(|(sum, _)| sum).sum();
        let scale = 1.0 / count as f32;
        let pixels = (0..pair.pixel_count()).into_par_iter().with_min_len(PIECE);
        let gradient = pixels.map(|p| {
            if pair.is_valid(p) {
                std::array::from_fn(|c| scale * parts[c].1.values[p])
            } else {
                [0.0; 3]
            }
        });
        (sum / count as f64, gradient.collect())
    }
}

/// Windowed moments of one channel of two images.
struct Similarity<'a> {
    of_x: Moments,
    of_y: &'a Moments,
    /// Windowed mean of x y.
    product: Plane,
}

/// The similarity at one pixel, and its derivatives by the moments that depend on x: its mean, the
/// mean of its squares, and the mean of x y.
struct Local {
    value: f32,
    by_mean: f32,
    by_square: f32,
    by_product: f32,
}

impl<'a> Similarity<'a> {
    fn new(x: &Plane, y: &Plane, of_y: &'a Moments) -> Self {
        Self { of_x: Moments::of(x), of_y, product: smooth(&x.zip(y, |x, y| x * y)) }
    }

    fn at(&self, p: usize) -> Local {
        let (mx, my) = (self.of_x.mean.values[p], self.of_y.mean.values[p]);
        let covariance = self.product.values[p] - mx * my;
        let variances = self.of_x.square.values[p] - mx * mx + self.of_y.square.values[p] - my * my;
        let (a1, a2) = (2.0 * mx * my + C1, 2.0 * covariance + C2);
        let (b1, b2) = (mx * mx + my * my + C1, variances + C2);
        let over = 1.0 / (b1 * b2);
        let value = a1 * a2 * over;
        let (by_a1, by_a2) = (a2 * over, a1 * over);
        let (by_b1, by_b2) = (-value / b1, -value / b2);
        Local {
            value,
            by_mean: 2.0 * (my * (by_a1 - by_a2) + mx * (by_b1 - by_b2)),
            by_square: by_b2,
            by_product: 2.0 * by_a2,
        }
    }

    fn locals(&self) -> Vec<Local> {
        let pixels = (0..self.product.values.len()).into_par_iter().with_min_len(PIECE);
        pixels.map(|p| self.at(p)).collect()
    }

    fn sum(&self) -> f64 {
        (0..self.product.values.len()).map(|p| f64::from(self.at(p).value)).sum()
    }
}

/// Derivative of the sum over all pixels by each value of x. The window is symmetric and black lies
/// beyond the border, so the adjoint of a filter is the filter.
fn gradient(locals: &[Local], x: &Plane, y: &Plane) -> Plane {
    let (width, height) = (x.width, x.height);
    let smoothed = |part: fn(&Local) -> f32| {
        smooth(&Plane::from_fn(width, height, |p| part(&locals[p]))).values
    };
    let by_mean = smoothed(|l| l.by_mean);
    let by_square = smoothed(|l| l.by_square);
    let by_product = smoothed(|l| l.by_product);
    Plane::from_fn(width, height, |p| {
        by_mean[p] + 2.0 * x.values[p] * by_square[p] + y.values[p] * by_product[p]
    })
}

#[cfg(test)]
mod tests;
