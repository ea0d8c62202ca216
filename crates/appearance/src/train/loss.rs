//! The loss of a rendering against a view, and its derivative by the rendering.
//!
//! Means over the pixels that no hand may hide: 0.8 of the absolute difference of colours and 0.2 of
//! 1 - SSIM (Kerbl et al. 2023), the absolute difference of coverage and mask, and that of depth
//! where the camera measured the object's.

use bendtwin_image_metrics::{Image as Compared, Pair, ssim_with_gradient};
use bendtwin_splat::{Image, ImageBar};

use crate::{Error, target::Target};

/// Share of 1 - SSIM in the loss of colours.
const SSIM: f32 = 0.2;
/// Weight of coverage.
const MASK: f32 = 0.3;
/// Weight of depth [1/m].
const DEPTH: f32 = 0.5;
/// Coverage below which a rendering has no depth.
const COVERED: f32 = 0.5;

/// The loss and d loss / d image.
pub(super) fn loss(image: &Image, target: &Target) -> Result<(f64, ImageBar), Error> {
    let count = target.valid.len();
    let mut bar = ImageBar::zeros(count);
    let compare = |e: bendtwin_image_metrics::Error| Error::Compare(e.to_string());
    let [width, height] = target.area.size;
    let rendered = Compared::new(width, height, &image.color).map_err(compare)?;
    let recorded = Compared::new(width, height, &target.colors).map_err(compare)?;
    let pair = Pair::new(rendered, recorded, Some(&target.valid)).map_err(compare)?;
    let (similarity, by_color) = ssim_with_gradient(&pair);
    let each = 1.0 / count as f32;
    let mut sum = 0.0_f64;
    for pixel in (0..count).filter(|p| target.valid[*p]) {
        let (rendered, recorded) = (image.color[pixel], target.colors[pixel]);
        bar.color[pixel] = std::array::from_fn(|channel| {
            let off = rendered[channel] - recorded[channel];
            sum += f64::from((1.0 - SSIM) / 3.0 * off.abs());
            (1.0 - SSIM) / 3.0 * each * sign(off) - SSIM * by_color[pixel][channel]
        });
        let alpha = image.alpha[pixel];
        let off = alpha - f32::from(u8::from(target.object[pixel]));
        sum += f64::from(MASK * off.abs());
        bar.alpha[pixel] = MASK * each * sign(off);
        if target.depth_m[pixel] > 0.0 && alpha > COVERED {
            let depth = image.depth_m[pixel] / alpha;
            let off = depth - target.depth_m[pixel];
            sum += f64::from(DEPTH * off.abs());
            bar.depth_m[pixel] = DEPTH * each * sign(off) / alpha;
            bar.alpha[pixel] -= DEPTH * each * sign(off) * depth / alpha;
        }
    }
    Ok((sum / count as f64 + f64::from(SSIM) * (1.0 - similarity), bar))
}

/// The derivative of the absolute value; 0 at 0.
fn sign(x: f32) -> f32 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

#[cfg(test)]
mod tests;
