//! Paired differences between two rows, and how certain they are: captures are drawn with
//! replacement, and of each capture its runs, as a study of other bodies with other seeds would have
//! had them.

use std::collections::BTreeMap;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

/// Draws of captures and runs.
const RESAMPLES: usize = 2000;
/// Share of the draws on either side of the interval.
const TAIL: f64 = 0.025;
/// Fewer pairs than this have no interval.
const LEAST_PAIRS: usize = 3;

/// Values of two rows on the runs of one capture, by seed and name of the pair.
pub(crate) type Pairs<'a> = BTreeMap<(u64, &'a str), [f64; 2]>;

/// The result of a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The first is lower.
    Lower,
    /// The first is higher.
    Higher,
    /// Neither: the interval contains zero, or seeds alone differ by that.
    NoDifference,
}

/// A difference, and its certainty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Certainty {
    /// Ends of the interval that has 95 % of the draws.
    pub interval: [f64; 2],
    /// Standard deviation of the differences that single seeds give; none of a single seed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seeds_differ: Option<f64>,
    /// The result.
    pub verdict: Verdict,
}

/// The difference that `statistic` makes of two means over captures, of the means over their runs.
pub(crate) fn difference(
    captures: &[Pairs<'_>],
    statistic: impl Fn([f64; 2]) -> f64,
) -> Option<f64> {
    let means: Vec<[f64; 2]> = captures.iter().filter_map(|c| mean(c.values().copied())).collect();
    mean(means.into_iter()).map(statistic)
}

/// The certainty of [`difference`]; none of fewer than three pairs. The same pairs have the same.
pub(crate) fn certainty(
    captures: &[Pairs<'_>],
    statistic: impl Fn([f64; 2]) -> f64,
) -> Option<Certainty> {
    let runs: Vec<Vec<[f64; 2]>> = captures
        .iter()
        .map(|c| c.values().copied().collect())
        .filter(|c: &Vec<_>| !c.is_empty())
        .collect();
    if runs.iter().map(Vec::len).sum::<usize>() < LEAST_PAIRS {
        return None;
    }
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let mut draws: Vec<f64> = Vec::with_capacity(RESAMPLES);
    for _ in 0..RESAMPLES {
        let captures = (0..runs.len()).filter_map(|_| {
            let of = &runs[rng.random_range(0..runs.len())];
            mean((0..of.len()).map(|_| of[rng.random_range(0..of.len())]))
        });
        let captures: Vec<[f64; 2]> = captures.collect();
        draws.extend(mean(captures.into_iter()).map(&statistic));
    }
    draws.sort_by(f64::total_cmp);
    let at = |share: f64| draws.get((share * (draws.len().max(1) - 1) as f64).round() as usize);
    let interval = [*at(TAIL)?, *at(1.0 - TAIL)?];
    let value = difference(captures, &statistic)?;
    let seeds_differ = between_seeds(captures, &statistic);
    Some(Certainty { interval, seeds_differ, verdict: verdict(value, interval, seeds_differ) })
}

fn verdict(value: f64, [low, high]: [f64; 2], seeds_differ: Option<f64>) -> Verdict {
    let within_seeds = seeds_differ.is_some_and(|seeds| value.abs() < seeds);
    match () {
        () if within_seeds || !(low > 0.0 || high < 0.0) => Verdict::NoDifference,
        () if value < 0.0 => Verdict::Lower,
        () => Verdict::Higher,
    }
}

/// Standard deviation of the differences that single seeds give, over the captures that they have.
fn between_seeds(captures: &[Pairs<'_>], statistic: impl Fn([f64; 2]) -> f64) -> Option<f64> {
    let mut seeds: Vec<u64> =
        captures.iter().flat_map(|c| c.keys().map(|(seed, _)| *seed)).collect();
    seeds.sort_unstable();
    seeds.dedup();
    let of_seed = |seed: u64| -> Vec<Pairs<'_>> {
        let own = |c: &Pairs<'_>| c.iter().any(|((s, _), _)| *s == seed);
        let kept = captures.iter().filter(|c| own(c)).map(|c| {
            let runs = c.iter().filter(|((s, _), _)| *s == seed);
            runs.map(|(key, pair)| (*key, *pair)).collect()
        });
        kept.collect()
    };
    let values: Vec<f64> =
        seeds.iter().filter_map(|seed| difference(&of_seed(*seed), &statistic)).collect();
    let n = values.len() as f64;
    let middle = values.iter().sum::<f64>() / n;
    let square: f64 = values.iter().map(|x| (x - middle).powi(2)).sum();
    (values.len() > 1).then(|| (square / (n - 1.0)).sqrt())
}

fn mean(pairs: impl Iterator<Item = [f64; 2]>) -> Option<[f64; 2]> {
    let (sum, n) = pairs.fold(([0.0; 2], 0.0), |([a, b], n), [x, y]| ([a + x, b + y], n + 1.0));
    (n > 0.0).then(|| sum.map(|x| x / n))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn percent([of, against]: [f64; 2]) -> f64 {
        100.0 * (of - against) / against
    }

    /// Captures that each have the seeds 0 to 4.
    fn captures(count: usize, pair: impl Fn(usize, u64) -> [f64; 2]) -> Vec<Pairs<'static>> {
        (0..count).map(|c| (0..5).map(|seed| ((seed, ""), pair(c, seed))).collect()).collect()
    }

    #[test]
    fn a_large_difference_is_one() {
        let found = captures(8, |c, seed| [7.0 + 0.1 * seed as f64, 10.0 + 0.2 * c as f64]);
        let Certainty { interval: [low, high], seeds_differ, verdict } =
            certainty(&found, percent).unwrap();
        assert_eq!(verdict, Verdict::Lower);
        let value = difference(&found, percent).unwrap();
        assert!(low < value && value < high && high < -25.0, "{low} {value} {high}");
        assert!((0.5..3.0).contains(&seeds_differ.unwrap()));
        let turned: Vec<Pairs<'_>> = found
            .iter()
            .map(|c| c.iter().map(|(key, [a, b])| (*key, [*b, *a])).collect())
            .collect();
        assert_eq!(certainty(&turned, percent).unwrap().verdict, Verdict::Higher);
        assert_eq!(certainty(&found, percent), certainty(&found, percent));
    }

    #[test]
    fn captures_that_disagree_show_no_difference() {
        let found = captures(6, |c, _| if c % 2 == 0 { [8.0, 10.0] } else { [12.0, 10.5] });
        let Certainty { interval: [low, high], verdict, .. } = certainty(&found, percent).unwrap();
        assert!(low < 0.0 && high > 0.0);
        assert_eq!(verdict, Verdict::NoDifference);
    }

    /// A capture whose runs all gain, but by less than seeds differ by.
    #[test]
    fn what_seeds_differ_by_is_no_difference() {
        let found = captures(1, |_, seed| [10.0 - [0.1, 0.1, 0.1, 0.1, 4.0][seed as usize], 10.0]);
        let Certainty { interval, seeds_differ, verdict } = certainty(&found, percent).unwrap();
        assert!(interval[1] < 0.0, "{interval:?}");
        assert!(seeds_differ.unwrap() > 10.0);
        assert_eq!(verdict, Verdict::NoDifference);
    }

    #[test]
    fn two_runs_have_no_interval() {
        let mut found = captures(1, |_, _| [5.0, 10.0]);
        found[0].retain(|(seed, _), _| *seed < 2);
        assert_eq!(certainty(&found, percent), None);
        assert_eq!(difference(&found, percent), Some(-50.0));
        assert_eq!((certainty(&[], percent), difference(&[], percent)), (None, None));
    }
}
