//! One loss from those of several sequences: their geometric mean. A long rollout now and then comes near a
//! point where the motion branches, and ends far from what was seen however good the parameters are. In a plain mean a few of
//! those drown what all others say; in a geometric one a sequence that halves its loss counts as much as any other
//! that does. One sequence alone is its own mean.

/// Losses count as at least this: what is better is perfect.
const PERFECT: f64 = 1e-12;
/// A sequence pulls at most so many times harder, or less hard, than one of the mean loss.
const MOST_PULL: f64 = 10.0;

/// The loss of parameters over all sequences; not finite if one is not.
pub(crate) fn mean(losses: impl IntoIterator<Item = f64>) -> f64 {
    // NaN must not become perfect.
    let at_least = |loss: f64| if loss < PERFECT { PERFECT } else { loss };
    match &losses.into_iter().map(at_least).collect::<Vec<_>>()[..] {
        // Exactly, not by way of its logarithm.
        [one] => *one,
        [] => f64::NAN,
        several => (several.iter().map(|l| l.ln()).sum::<f64>() / several.len() as f64).exp(),
    }
}

/// What the gradients of sequences with these losses are multiplied by, so that their mean is that of
/// [`mean`] up to a factor, which is 1 where all losses are alike.
pub(crate) fn pulls(losses: &[f64]) -> Vec<f64> {
    let middle = mean(losses.iter().copied());
    let pull = |&loss: &f64| (middle / loss.max(PERFECT)).clamp(1.0 / MOST_PULL, MOST_PULL);
    losses.iter().map(pull).collect()
}

#[cfg(test)]
mod tests;
