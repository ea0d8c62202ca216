//! Cuts of a batch, all by one rule: a run of instances takes as many whole rounds as its bound
//! allows, and at least one ([`next_run`]). There are three, each inside the one before:
//!
//! | cut | bound | order |
//! |---|---|---|
//! | parts, the messages of a reply | the number of instances that the server asks for | the request's |
//! | batches, prepared together | memory of their dense controls and gradients | the request's |
//! | slices, the tasks of the device | estimated work (a fit's have no bound where it pauses by itself); a round has an instance for each of the device's lanes | by work, largest first |
//!
//! A backend may cut a slice once more, by what fits its memory.
//!
//! Instances are independent, so a cut changes no result on the CPU, by not a single bit. On a GPU
//! the number of instances that are simulated together decides how they are laid out, and with that
//! the order of sums: the last bits of a result may differ between two cuts. There the cuts of a
//! rollout depend on the request, the twin, the device and the size of the worker's memory alone,
//! never on time or on other work, so the same request gives the same bits; a streamed reply and
//! one in a single part may differ in the last bits, and so may the arrays of the best few, which
//! are simulated once more, from the costs that they were chosen by.

use std::ops::Range;

/// Dense controls and gradients of the instances prepared together, at most [bytes].
const PREPARED_BYTES: u64 = 512 << 20;

/// Number of items that the next run takes of those that are left: whole rounds while `fits` says
/// so of each further round, and one round at least. `fits` sees every round once, in order, the
/// first included.
pub fn next_run(left: usize, round: usize, mut fits: impl FnMut(Range<usize>) -> bool) -> usize {
    let round = round.max(1);
    let mut taken = round.min(left);
    fits(0..taken);
    while taken < left {
        let next = (taken + round).min(left);
        if !fits(taken..next) {
            break;
        }
        taken = next;
    }
    taken
}

/// Runs of at most `most` instances, in order.
pub fn runs(of: Range<usize>, most: usize) -> impl Iterator<Item = Range<usize>> {
    let mut start = of.start;
    std::iter::from_fn(move || {
        let left = of.end.saturating_sub(start);
        let run = start..start + next_run(left, 1, |taken| taken.end <= most);
        start = run.end;
        (left > 0).then_some(run)
    })
}

/// Number of instances that may be prepared together, given the bytes of each.
pub fn prepared(bytes: u64) -> usize {
    usize::try_from(PREPARED_BYTES / bytes.max(1)).unwrap_or(usize::MAX).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_cover_everything_in_order() {
        let of = |range, most| runs(range, most).collect::<Vec<_>>();
        assert_eq!(of(0..9, 4), [0..4, 4..8, 8..9]);
        assert_eq!(of(3..5, 4), vec![Range { start: 3, end: 5 }]);
        assert_eq!(of(0..2, 0), [0..1, 1..2]);
        assert!(of(5..5, 3).is_empty());
    }

    #[test]
    fn a_run_takes_whole_rounds_within_its_bound_and_one_at_least() {
        let budget = |most: usize| move |taken: Range<usize>| taken.end <= most;
        assert_eq!(next_run(10, 4, budget(0)), 4);
        assert_eq!(next_run(10, 4, budget(9)), 8);
        assert_eq!(next_run(10, 4, budget(10)), 10);
        assert_eq!(next_run(3, 4, budget(100)), 3);
        assert_eq!(next_run(0, 4, budget(100)), 0);
    }

    #[test]
    fn at_least_one_instance_is_prepared() {
        assert_eq!(prepared(u64::MAX), 1);
        assert_eq!(prepared(PREPARED_BYTES / 3), 3);
        assert!(prepared(0) > 1 << 20);
    }
}
