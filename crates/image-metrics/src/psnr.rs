//! Peak signal-to-noise ratio.

use crate::Pair;

/// Mean squared difference of the colours over all pixels and channels, 0 to 1.
pub fn mean_squared_error(pair: &Pair<'_>) -> f64 {
    let colors = pair.image().pixels().iter().zip(pair.reference().pixels());
    let valid = colors.enumerate().filter(|(p, _)| pair.is_valid(*p));
    let squares =
        valid.flat_map(|(_, (a, b))| a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)));
    squares.sum::<f64>() / (3 * pair.pixel_count()) as f64
}

/// Peak signal-to-noise ratio [dB]: -10 log10 of the [`mean_squared_error`]; infinite for equal
/// images. PhysTwin's evaluation takes the mean over a whole image whose background is black.
pub fn psnr(pair: &Pair<'_>) -> f64 {
    -10.0 * mean_squared_error(pair).log10()
}

#[cfg(test)]
mod tests;
