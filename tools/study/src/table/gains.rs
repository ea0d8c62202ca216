//! Differences between pairs of configurations by the mean degree of their graphs: how many springs
//! meet at a node decides whether axial springs alone hold a shape.

use std::collections::BTreeMap;

use serde::Serialize;

use super::samples::Samples;
use crate::{
    bootstrap::{self, Certainty, Pairs},
    suite::{FigureEntry, Suite},
};

/// Differences by mean degree.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gains {
    /// Title of the picture.
    pub title: String,
    /// Names of the series, in the suite's order.
    pub series: Vec<String>,
    /// Groups of captures, in the suite's order; none for captures without one.
    pub groups: Vec<Option<String>>,
    /// Differences by series, group and degree; none where there are no runs.
    pub gains: Vec<Gain>,
}

/// The difference of a series on the captures of a group, over graphs of about the same degree.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gain {
    /// Series of the suite's figure.
    pub series: String,
    /// Group of the captures.
    pub group: Option<String>,
    /// Degree of the suite's figure that the graphs are nearest to.
    pub degree: f64,
    /// Their mean degree, over captures.
    pub mean_degree: f64,
    /// Number of captures.
    pub captures: usize,
    /// Number of pairs of runs.
    pub pairs: usize,
    /// Errors of the first against those of the second [%]: by the geometric mean over captures of
    /// their ratio, so that no capture counts more than another. Negative is better.
    pub percent: f64,
    /// Certainty; none of fewer than three pairs.
    pub certainty: Option<Certainty>,
}

/// Logarithms of both errors by capture, and degrees.
#[derive(Default)]
struct Bin<'a> {
    pairs: BTreeMap<&'a str, Pairs<'a>>,
    degrees: BTreeMap<&'a str, Vec<f64>>,
}

pub(super) fn of(suite: &Suite, figure: &FigureEntry, samples: &Samples<'_>) -> Gains {
    let mut groups: Vec<Option<String>> = Vec::new();
    for capture in &suite.captures {
        if !groups.contains(&capture.group) {
            groups.push(capture.group.clone());
        }
    }
    let mut gains = Vec::new();
    for series in &figure.series {
        for group in &groups {
            let mut bins: Vec<Bin<'_>> = figure.degrees.iter().map(|_| Bin::default()).collect();
            for capture in suite.captures.iter().filter(|c| c.group == *group) {
                for pair in &series.pairs {
                    let rows = [&pair.of, &pair.against];
                    let [Some(of), Some(against)] = rows.map(|r| samples.seeds(r, &capture.name))
                    else {
                        continue;
                    };
                    for (seed, other) in against {
                        let degree = other.size.and_then(|size| size.degree);
                        let errors = of.get(seed).and_then(|own| {
                            let ((key, own), (other_key, other)) =
                                (own.headline()?, other.headline()?);
                            (key == other_key && own > 0.0 && other > 0.0).then_some([own, other])
                        });
                        let (Some(degree), Some(errors)) = (degree, errors) else { continue };
                        let bin = &mut bins[nearest(&figure.degrees, degree)];
                        let key = (*seed, pair.against.as_str());
                        let logarithms = errors.map(f64::ln);
                        bin.pairs.entry(&capture.name).or_default().insert(key, logarithms);
                        bin.degrees.entry(&capture.name).or_default().push(degree);
                    }
                }
            }
            gains.extend(bins.iter().zip(&figure.degrees).filter_map(|(bin, degree)| {
                let captures: Vec<Pairs<'_>> = bin.pairs.values().cloned().collect();
                let means = bin.degrees.values().map(|d| mean(d));
                Some(Gain {
                    series: series.name.clone(),
                    group: group.clone(),
                    degree: *degree,
                    mean_degree: mean(&means.collect::<Vec<_>>()),
                    captures: captures.len(),
                    pairs: captures.iter().map(BTreeMap::len).sum(),
                    percent: bootstrap::difference(&captures, percent)?,
                    certainty: bootstrap::certainty(&captures, percent),
                })
            }));
        }
    }
    let title = figure.title.clone().unwrap_or_else(|| suite.name.clone());
    Gains { title, series: figure.series.iter().map(|s| s.name.clone()).collect(), groups, gains }
}

/// Difference [%] between two errors, by their logarithms.
fn percent([of, against]: [f64; 2]) -> f64 {
    100.0 * ((of - against).exp() - 1.0)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Index of the degree that is nearest by ratio.
fn nearest(degrees: &[f64], degree: f64) -> usize {
    let off = |i: &usize| (degrees[*i] / degree).ln().abs();
    (0..degrees.len()).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0)
}
