//! Samples of a motion in the order of time, and what lies between them.

/// Time from the nearest sample beyond which a motion is unknown [ns].
const REACH_NS: i64 = 500_000_000;

/// Samples around a time, and where it lies between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::raw) struct Around {
    /// Index of the last sample before, or of the first one of all.
    pub(in crate::raw) before: usize,
    /// Index of the first sample after, or of the last one of all.
    pub(in crate::raw) after: usize,
    /// Share of the way from one to the other, 0..=1.
    pub(in crate::raw) share: f64,
    /// Time to the nearer one [ns].
    pub(in crate::raw) off_ns: i64,
}

impl Around {
    /// Index of the nearer sample, of the earlier one if both are as near.
    pub(in crate::raw) fn nearest(&self) -> usize {
        if self.share > 0.5 { self.after } else { self.before }
    }
}

/// Samples around a time [ns] at which they say how something moves; `None` if the nearest is too far
/// from it for that. As for [`around`], times must ascend.
pub(in crate::raw) fn nearby<S>(
    samples: &[S],
    ns_of: impl Fn(&S) -> i64,
    ns: i64,
) -> Option<Around> {
    around(samples, ns_of, ns).filter(|found| found.off_ns <= REACH_NS)
}

/// Samples around a time [ns], which `ns_of` gives of each and which must ascend; `None` if there are
/// no samples.
pub(in crate::raw) fn around<S>(
    samples: &[S],
    ns_of: impl Fn(&S) -> i64,
    ns: i64,
) -> Option<Around> {
    let last = samples.len().checked_sub(1)?;
    let next = samples.partition_point(|sample| ns_of(sample) < ns);
    let (before, after) = (next.saturating_sub(1), next.min(last));
    let [from, to] = [before, after].map(|i| ns_of(&samples[i]));
    let span = to.saturating_sub(from);
    let share =
        if span > 0 { (ns.saturating_sub(from) as f64 / span as f64).clamp(0.0, 1.0) } else { 0.0 };
    let off = |other: i64| ns.saturating_sub(other).saturating_abs();
    Some(Around { before, after, share, off_ns: off(from).min(off(to)) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_between_samples_have_both_and_others_the_nearest() {
        let at = |ns: i64| {
            around(&[10, 20, 40], |ns| *ns, ns).map(|a| (a.before, a.after, a.share, a.off_ns))
        };
        assert_eq!(at(25), Some((1, 2, 0.25, 5)));
        assert_eq!(at(10), Some((0, 0, 0.0, 0)));
        assert_eq!(at(-5), Some((0, 0, 0.0, 15)));
        assert_eq!(at(41), Some((2, 2, 0.0, 1)));
        assert_eq!(at(i64::MIN).map(|a| a.3), Some(i64::MAX));
        assert_eq!(around(&[], |ns: &i64| *ns, 0), None);
        let nearest = |ns: i64| around(&[10, 20, 40], |ns| *ns, ns).unwrap().nearest();
        assert_eq!([-5, 15, 16, 30, 31, 50].map(nearest), [0, 0, 1, 1, 2, 2]);
        let near = |ns: i64| nearby(&[0, 3 * REACH_NS], |ns| *ns, ns).is_some();
        assert_eq!(
            [-REACH_NS, REACH_NS, REACH_NS + 1, 2 * REACH_NS].map(near),
            [true, true, false, true]
        );
    }
}
