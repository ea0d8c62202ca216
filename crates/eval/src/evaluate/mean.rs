//! The mean prediction of a twin and its members in one sequence.

use bendtwin_core::{Sequence, twin::Mean};

use crate::Trajectory;

/// The mean of the predictions of a twin and of its members, with their weights, the twin's first. A
/// fit that diverged has no part in it, of which a warning tells; if all did, the mean is that of where
/// they stopped.
pub(super) fn mean_of_fits(
    sequence: &Sequence,
    own: &Trajectory,
    members: &[&Trajectory],
    weights: &[f64],
) -> (Trajectory, Option<String>) {
    let fits = || std::iter::once(own).chain(members.iter().copied()).zip(weights);
    let lost = fits().filter(|(fit, _)| fit.diverged.is_some()).count();
    let count = fits().count();
    let mut mean = Mean::default();
    for (fit, weight) in fits().filter(|(fit, _)| fit.diverged.is_none() || lost == count) {
        mean.add(*weight, &fit.positions);
    }
    let mut trajectory = own.clone();
    trajectory.positions = mean.points();
    let warning = (lost > 0).then(|| match lost == count {
        true => format!("all {count} fits diverged in sequence `{}`", sequence.name),
        false => format!(
            "the mean of the fits leaves out {lost} of {count} in sequence `{}`, where they diverged",
            sequence.name
        ),
    });
    (trajectory, warning)
}
