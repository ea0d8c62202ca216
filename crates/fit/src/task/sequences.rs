//! Mean loss of several sequences. A long rollout occasionally comes near a bifurcation of the
//! motion, and ends far from what was observed however good the parameters are. In an arithmetic
//! mean a few of those outweigh all others; in a geometric one every sequence that halves its loss
//! counts equally.

use bendtwin_core::settings::SequenceMean;

/// Least loss that a geometric mean distinguishes; smaller ones count as this.
const MIN_LOSS: f64 = 1e-12;
/// Largest factor by which a geometric mean scales a gradient; the smallest is its inverse.
const MAX_SCALE: f64 = 10.0;

/// The loss of parameters over all sequences; not finite if one is not.
pub(crate) fn mean(kind: SequenceMean, losses: impl IntoIterator<Item = f64>) -> f64 {
    // NaN must not become the least loss.
    let logarithm = |loss: f64| if loss < MIN_LOSS { MIN_LOSS.ln() } else { loss.ln() };
    let (mut sum, mut count) = (0.0, 0_usize);
    for loss in losses {
        sum += match kind {
            SequenceMean::Arithmetic => loss,
            SequenceMean::Geometric => logarithm(loss),
        };
        count += 1;
    }
    let mean = sum / count as f64;
    match kind {
        SequenceMean::Arithmetic => mean,
        SequenceMean::Geometric => mean.exp(),
    }
}

/// Factors for the gradients of sequences with these losses. The mean of the scaled gradients is
/// the gradient of [`mean`] up to a common factor, which is 1 where all losses are equal.
pub(crate) fn gradient_scales(kind: SequenceMean, losses: &[f64]) -> Vec<f64> {
    let middle = match kind {
        SequenceMean::Arithmetic => return vec![1.0; losses.len()],
        SequenceMean::Geometric => mean(kind, losses.iter().copied()),
    };
    let scale = |&loss: &f64| (middle / loss.max(MIN_LOSS)).clamp(1.0 / MAX_SCALE, MAX_SCALE);
    losses.iter().map(scale).collect()
}

#[cfg(test)]
mod tests;
