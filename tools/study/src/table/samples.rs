//! Figures as runs gave them: by row, capture and seed.

use std::collections::BTreeMap;

use bendtwin_core::quality::{ErrorSummary, NodeErrors, Score};

use super::{Figure, Figures, Size};
use crate::{
    record::Record,
    suite::{BASELINES, Suite},
};

/// A metric over a span of frames.
pub(crate) struct Column {
    /// Name in JSON.
    pub(crate) key: &'static str,
    /// Name for people.
    pub(crate) heading: &'static str,
    error: fn(&ErrorSummary) -> Option<f64>,
    is_future: bool,
    /// True if it is the error of the nodes and not of the skin.
    at_nodes: bool,
}

macro_rules! column {
    ($key:literal, $heading:literal, $field:ident, $future:literal) => {
        column!($key, $heading, $field, $future, false)
    };
    ($key:literal, $heading:literal, $field:ident, $future:literal, $at_nodes:literal) => {
        Column {
            key: $key,
            heading: $heading,
            error: |e| e.$field,
            is_future: $future,
            at_nodes: $at_nodes,
        }
    };
}

/// All columns, in the table's order.
pub(crate) const COLUMNS: [Column; 14] = [
    column!("cd_l1_train_mm", "CD train", chamfer_l1_m, false),
    column!("cd_l1_future_mm", "CD future", chamfer_l1_m, true),
    column!("cd_l2_train_mm", "CD (L2) train", chamfer_l2_m, false),
    column!("cd_l2_future_mm", "CD (L2) future", chamfer_l2_m, true),
    column!("track_train_mm", "track train", track_m, false),
    column!("track_future_mm", "track future", track_m, true),
    column!("cd_l1_nodes_train_mm", "CD at nodes train", chamfer_l1_m, false, true),
    column!("cd_l1_nodes_future_mm", "CD at nodes future", chamfer_l1_m, true, true),
    column!("track_nodes_train_mm", "track at nodes train", track_m, false, true),
    column!("track_nodes_future_mm", "track at nodes future", track_m, true, true),
    column!("coordinate_train_mm", "coordinate train", coordinate_m, false),
    column!("coordinate_future_mm", "coordinate future", coordinate_m, true),
    column!("padded_rms_train_mm", "padded RMS train", padded_rms_m, false),
    column!("padded_rms_future_mm", "padded RMS future", padded_rms_m, true),
];

/// A value per column [mm].
pub(crate) type Values = [Option<f64>; COLUMNS.len()];

/// The values of one run for a row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sample {
    pub(crate) values: Values,
    /// Size of a configuration's own graph.
    pub(crate) size: Option<Size>,
    pub(crate) fit_s: Option<f64>,
    nodes_digest: Option<String>,
}

impl Sample {
    /// Published figures come without nodes.
    pub(crate) fn is_published(&self) -> bool {
        self.nodes_digest.is_none()
    }
}

/// A row's samples of one capture, by seed. Published figures have one sample, as if of seed 0.
pub(crate) type Seeds = BTreeMap<u64, Sample>;

/// All samples.
#[derive(Debug, Default)]
pub(crate) struct Samples<'a> {
    /// Samples by row and capture.
    rows: BTreeMap<String, BTreeMap<&'a str, Seeds>>,
    /// Published means over captures, by row.
    published_means: BTreeMap<&'a str, Values>,
    published: Vec<&'a str>,
}

impl<'a> Samples<'a> {
    pub(crate) fn new(suite: &'a Suite, records: &[&'a Record]) -> Self {
        let mut samples = Self::default();
        for record in records {
            let Some(finished) = record.finished() else { continue };
            let (run, quality) = (&record.run, &finished.quality);
            let size = Size {
                nodes: finished.graph.nodes as f64,
                springs: finished.graph.springs as f64,
                triplets: finished.graph.triplets as f64,
                degree: finished.graph.mean_degree(),
            };
            let digest = Some(finished.graph.nodes_digest.clone());
            let mut add = |row: String, sample| {
                let captures = samples.rows.entry(row).or_default();
                captures.entry(run.capture.as_str()).or_default().insert(run.seed, sample);
            };
            if let Some(own) = quality.scores.first() {
                let sample = Sample {
                    values: values(&own.train, &own.future, own.at_nodes),
                    size: Some(size),
                    fit_s: Some(finished.fit_s),
                    nodes_digest: digest.clone(),
                };
                add(run.configuration.clone(), sample);
            }
            for (name, predictor) in BASELINES {
                let Some(Score { train, future, at_nodes, .. }) = quality.score(predictor) else {
                    continue;
                };
                let values = values(train, future, *at_nodes);
                let sample =
                    Sample { values, size: None, fit_s: None, nodes_digest: digest.clone() };
                add(baseline_row(&run.configuration, name), sample);
            }
        }
        for reference in &suite.references {
            let values = values(&reference.train, &reference.future, None);
            if !samples.published.contains(&reference.name.as_str()) {
                samples.published.push(&reference.name);
            }
            match &reference.capture {
                Some(capture) => {
                    let sample = Sample { values, size: None, fit_s: None, nodes_digest: None };
                    let captures = samples.rows.entry(reference.name.clone()).or_default();
                    captures.entry(capture).or_default().insert(0, sample);
                }
                None => drop(samples.published_means.insert(&reference.name, values)),
            }
        }
        samples
    }

    /// Names of published rows, in the suite's order.
    pub(crate) fn published(&self) -> &[&'a str] {
        &self.published
    }

    pub(crate) fn seeds(&self, row: &str, capture: &str) -> Option<&Seeds> {
        self.rows.get(row)?.get(capture)
    }

    /// Captures of a row with their samples.
    pub(crate) fn captures(&self, row: &str) -> impl Iterator<Item = (&'a str, &Seeds)> {
        self.rows.get(row).into_iter().flatten().map(|(capture, seeds)| (*capture, seeds))
    }

    pub(crate) fn published_mean(&self, row: &str) -> Option<&Values> {
        self.published_means.get(row)
    }

    /// True if two rows agree wherever both have values: on a capture, or on all.
    pub(crate) fn agree(&self, one: &str, other: &str, capture: Option<&str>) -> bool {
        let mut pairs = self
            .captures(one)
            .filter(|(name, _)| capture.is_none_or(|c| c == *name))
            .filter_map(|(name, seeds)| Some((seeds, self.seeds(other, name)?)))
            .flat_map(|(a, b)| a.iter().filter_map(|(seed, x)| Some((x, b.get(seed)?))))
            .peekable();
        pairs.peek().is_some() && pairs.all(|(a, b)| a.values == b.values)
    }

    /// True if two rows have the same nodes on a capture; none if one of them has no nodes.
    pub(crate) fn same_nodes(&self, one: &str, other: &str, capture: &str) -> Option<bool> {
        let (one, other) = (self.seeds(one, capture)?, self.seeds(other, capture)?);
        let pairs = one.iter().filter_map(|(seed, a)| Some((a, other.get(seed)?)));
        let digests =
            pairs.map(|(a, b)| Some(a.nodes_digest.as_ref()? == b.nodes_digest.as_ref()?));
        digests
            .collect::<Option<Vec<bool>>>()
            .filter(|d| !d.is_empty())
            .map(|d| d.iter().all(|x| *x))
    }
}

/// The name of a baseline's row.
pub(crate) fn baseline_row(configuration: &str, baseline: &str) -> String {
    format!("{configuration}:{baseline}")
}

fn values(train: &ErrorSummary, future: &ErrorSummary, at_nodes: Option<NodeErrors>) -> Values {
    std::array::from_fn(|i| {
        let column = &COLUMNS[i];
        let errors = match (column.at_nodes, &at_nodes) {
            (false, _) => Some([train, future]),
            (true, Some(nodes)) => Some([&nodes.train, &nodes.future]),
            (true, None) => None,
        };
        (column.error)(errors?[usize::from(column.is_future)]).map(|m| 1e3 * m)
    })
}

impl Sample {
    /// Error of future frames by which a predictor is judged [mm]: of tracks, else of coordinates,
    /// else the Chamfer distance, all at the skin.
    pub(crate) fn headline(&self) -> Option<(&'static str, f64)> {
        let keys = ["track_future_mm", "coordinate_future_mm", "cd_l1_future_mm"];
        keys.into_iter().find_map(|key| {
            let column = COLUMNS.iter().position(|c| c.key == key)?;
            Some((key, self.values[column]?))
        })
    }
}

/// Mean and, of several, the standard deviation; none of no values.
pub(crate) fn figure(values: &[f64]) -> Option<Figure> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let square: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
    let spread = (values.len() > 1).then(|| (square / (n - 1.0)).sqrt());
    (!values.is_empty()).then_some(Figure { mean, spread })
}

/// A figure for each column that has values.
pub(crate) fn figures(of: impl Fn(usize) -> Option<Figure>) -> Figures {
    (0..COLUMNS.len()).filter_map(|i| Some((COLUMNS[i].key, of(i)?))).collect()
}

/// The values of a column over seeds.
pub(crate) fn over_seeds(seeds: &Seeds, column: usize) -> Vec<f64> {
    seeds.values().filter_map(|s| s.values[column]).collect()
}
