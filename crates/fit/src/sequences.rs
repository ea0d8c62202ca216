//! One loss from those of several sequences. A long rollout now and then comes near a point where the motion
//! branches, and ends far from what was seen however good the parameters are. In a plain mean a few of those weigh more than all
//! others; in a geometric one a sequence that halves its loss counts as much as any other that does.

use bendtwin_core::settings::SequenceMean;

/// In a geometric mean losses count as at least this: what is better is perfect.
const PERFECT: f64 = 1e-12;
/// There a sequence pulls at most so many times harder, or less hard, than one of the mean loss.
const MOST_PULL: f64 = 10.0;

/// The loss of parameters over all sequences; not finite if one is not.
pub(crate) fn mean(kind: SequenceMean, losses: impl IntoIterator<Item = f64>) -> f64 {
    // NaN must not become perfect.
    let logarithm = |loss: f64| if loss < PERFECT { PERFECT.ln() } else { loss.ln() };
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

/// What the gradients of sequences with these losses are multiplied by, so that their mean is that of
/// [`mean`] up to a factor, which is 1 where all losses are alike.
pub(crate) fn pulls(kind: SequenceMean, losses: &[f64]) -> Vec<f64> {
    let middle = match kind {
        SequenceMean::Arithmetic => return vec![1.0; losses.len()],
        SequenceMean::Geometric => mean(kind, losses.iter().copied()),
    };
    let pull = |&loss: &f64| (middle / loss.max(PERFECT)).clamp(1.0 / MOST_PULL, MOST_PULL);
    losses.iter().map(pull).collect()
}

#[cfg(test)]
mod tests;
