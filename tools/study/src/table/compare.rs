//! Relative differences between rows: capture by capture, and of the means over the captures that
//! both rows have.

use std::collections::BTreeMap;

use super::{
    Difference,
    samples::{COLUMNS, Samples, Seeds},
};
use crate::{
    Certainty,
    bootstrap::{self, Pairs},
    suite::{Comparison, Suite},
};

/// All that the suite compares.
pub(super) fn all(suite: &Suite, samples: &Samples<'_>) -> Vec<Difference> {
    suite.compare.iter().flat_map(|c| differences(c, suite, samples)).collect()
}

fn differences(c: &Comparison, suite: &Suite, samples: &Samples<'_>) -> Vec<Difference> {
    let made = |capture: Option<&str>, same_nodes, percent| Difference {
        of: c.of.clone(),
        against: c.against.clone(),
        capture: capture.map(str::to_owned),
        same_nodes,
        percent,
        better: BTreeMap::new(),
        certainty: BTreeMap::new(),
    };
    let mut rows = Vec::new();
    // By column: the values of both on each capture, and by seed.
    let mut pairs: [Vec<(f64, f64)>; COLUMNS.len()] = Default::default();
    let mut runs: [Vec<Pairs<'_>>; COLUMNS.len()] = Default::default();
    let mut nodes = Vec::new();
    for capture in suite.captures.iter().map(|capture| capture.name.as_str()) {
        let (of, against) = (samples.seeds(&c.of, capture), samples.seeds(&c.against, capture));
        let (Some(of), Some(against)) = (of, against) else { continue };
        let mut percents = BTreeMap::new();
        for (i, column) in COLUMNS.iter().enumerate() {
            let Some(pair) = both(of, against, i) else { continue };
            percents.insert(column.key, percent(pair));
            pairs[i].push(pair);
            runs[i].push(by_seed(of, against, i));
        }
        if percents.is_empty() {
            continue;
        }
        let same = samples.same_nodes(&c.of, &c.against, capture);
        nodes.push(same);
        rows.push(made(Some(capture), same, percents));
    }
    if suite.captures.len() > 1 {
        let (mut percents, mut better) = (BTreeMap::new(), BTreeMap::new());
        let mut certainty: BTreeMap<&str, Certainty> = BTreeMap::new();
        for (i, column) in COLUMNS.iter().enumerate() {
            let pair = match published(c, samples, i) {
                Some(pair) => Some(pair),
                None => mean(&pairs[i]),
            };
            if let Some(pair) = pair {
                percents.insert(column.key, percent(pair));
                let found = bootstrap::certainty(&runs[i], |[of, against]| percent((of, against)));
                certainty.extend(found.map(|found| (column.key, found)));
            }
            if !pairs[i].is_empty() {
                let wins = pairs[i].iter().filter(|(of, against)| of < against).count();
                better.insert(column.key, (wins, pairs[i].len()));
            }
        }
        if !percents.is_empty() {
            let same = nodes.into_iter().collect::<Option<Vec<bool>>>().filter(|n| !n.is_empty());
            let all = made(None, same.map(|n| n.iter().all(|x| *x)), percents);
            rows.push(Difference { better, certainty, ..all });
        }
    }
    rows
}

/// The means of both on a capture, over the seeds that both have; published figures have no seeds.
fn both(of: &Seeds, against: &Seeds, column: usize) -> Option<(f64, f64)> {
    if is_published(of) || is_published(against) {
        let all = |seeds: &Seeds| mean_of(seeds.values().filter_map(|s| s.values[column]));
        return Some((all(of)?, all(against)?));
    }
    let pairs: Vec<(f64, f64)> =
        by_seed(of, against, column).into_values().map(|[of, against]| (of, against)).collect();
    mean(&pairs)
}

/// The values of both on a capture, by the seeds that both have; none where one is published.
fn by_seed(of: &Seeds, against: &Seeds, column: usize) -> Pairs<'static> {
    if is_published(of) || is_published(against) {
        return Pairs::new();
    }
    let pair = |(seed, a): (&u64, &super::samples::Sample)| {
        Some(((*seed, ""), [a.values[column]?, against.get(seed)?.values[column]?]))
    };
    of.iter().filter_map(pair).collect()
}

fn is_published(seeds: &Seeds) -> bool {
    seeds.values().all(|s| s.is_published())
}

/// Values of a comparison with a published mean: that mean, and the other's own mean over captures.
fn published(c: &Comparison, samples: &Samples<'_>, column: usize) -> Option<(f64, f64)> {
    if [&c.of, &c.against].iter().all(|row| samples.published_mean(row).is_none()) {
        return None;
    }
    let value = |row: &str| match samples.published_mean(row) {
        Some(values) => values[column],
        None => mean_of(
            samples
                .captures(row)
                .filter_map(|(_, seeds)| mean_of(seeds.values().filter_map(|s| s.values[column]))),
        ),
    };
    Some((value(&c.of)?, value(&c.against)?))
}

fn mean(pairs: &[(f64, f64)]) -> Option<(f64, f64)> {
    Some((mean_of(pairs.iter().map(|p| p.0))?, mean_of(pairs.iter().map(|p| p.1))?))
}

fn mean_of(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, n) = values.fold((0.0, 0_usize), |(sum, n), x| (sum + x, n + 1));
    (n > 0).then(|| sum / n as f64)
}

fn percent((of, against): (f64, f64)) -> f64 {
    if against > 0.0 { 100.0 * (of - against) / against } else { 0.0 }
}
