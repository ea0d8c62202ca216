//! Results of a suite: a row for each capture and configuration, the free baselines and published
//! figures, means over captures, relative differences, and their dependence on the mean degree of
//! graphs. All errors in millimetres.

mod compare;
mod gains;
mod markdown;
mod rows;
mod samples;

use std::collections::BTreeMap;

use serde::Serialize;

pub use self::gains::{Gain, Gains};
pub(crate) use self::samples::Samples;
use crate::{Certainty, Error, Plan, command::Invocation, suite::RunId};

/// Version of `table.json`.
const VERSION: u32 = 1;

/// The table of a suite.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Table {
    /// Version of this format.
    pub version: u32,
    /// The suite's title.
    pub suite: String,
    /// Purpose of the suite.
    pub about: String,
    /// The command that makes the table.
    pub command: String,
    /// The software that made its figures.
    pub builds: Vec<String>,
    /// Backends and devices that computed the runs.
    pub devices: Vec<String>,
    /// Runs of the suite.
    pub runs: usize,
    /// Runs that have no result yet.
    pub missing: usize,
    /// Rows of each capture, in the suite's order.
    pub rows: Vec<Row>,
    /// Means over captures; empty if there is one capture.
    pub means: Vec<Row>,
    /// Differences between rows that the suite compares.
    pub differences: Vec<Difference>,
    /// Differences by the mean degree of graphs, if the suite asks for them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gains: Option<Gains>,
    /// Runs that failed.
    pub failures: Vec<Failure>,
}

/// The kind of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Twins of a configuration.
    Configuration,
    /// A free baseline.
    Baseline,
    /// Published by others.
    Published,
}

/// A mean, and how far what it is the mean of strays from it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// The mean.
    pub mean: f64,
    /// Standard deviation over seeds, if there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spread: Option<f64>,
}

/// Figures by metric and span, for example `cd_l1_future_mm`.
pub type Figures = BTreeMap<&'static str, Figure>;

/// A row of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Name in comparisons.
    pub row: String,
    /// Name for people.
    pub label: String,
    /// Kind of the row.
    pub kind: Kind,
    /// Capture; if none, the row is a mean over captures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub capture: Option<String>,
    /// Number of captures in the mean.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub captures: Option<usize>,
    /// Number of seeds.
    pub seeds: usize,
    /// Size of the twins: means over seeds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<Size>,
    /// Errors, means over seeds [mm].
    pub errors: Figures,
    /// Time of a fit with its evaluation [s].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fit_s: Option<Figure>,
    /// The command that makes the row again.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub command: Option<String>,
}

/// The size of twins.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Size {
    /// Nodes.
    pub nodes: f64,
    /// Axial springs.
    pub springs: f64,
    /// Bending triplets.
    pub triplets: f64,
    /// Springs that meet at a node, those to control points apart; none in results of earlier
    /// versions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub degree: Option<f64>,
}

/// Relative difference of the errors of one row from those of another.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Row whose errors are compared.
    pub of: String,
    /// Row that they are relative to.
    pub against: String,
    /// Capture; if none, the means over the captures that both rows have.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub capture: Option<String>,
    /// True if both have the same nodes; none if one of them has no nodes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub same_nodes: Option<bool>,
    /// Relative differences by metric and span [%]; negative is better.
    pub percent: BTreeMap<&'static str, f64>,
    /// Number of captures on which it is better, and of captures compared; empty for a single
    /// capture.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub better: BTreeMap<&'static str, (usize, usize)>,
    /// Certainty of the differences of means, over the captures and seeds that both rows have
    /// [%]; empty for a single capture.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub certainty: BTreeMap<&'static str, Certainty>,
}

/// A run that failed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Failure {
    /// Id of the run.
    pub run: RunId,
    /// Stable reason.
    pub reason: String,
    /// Description of the error for people.
    pub message: String,
}

impl Table {
    /// The table of the results that hold.
    pub fn new(plan: &Plan<'_>, invocation: &Invocation) -> Self {
        let (suite, records) = (plan.suite, plan.records());
        let samples = Samples::new(suite, &records);
        let unique = |texts: Vec<String>| {
            let mut texts = texts;
            texts.sort();
            texts.dedup();
            texts
        };
        let runs = suite.runs().count();
        let finished = records.iter().filter(|r| r.finished().is_some());
        let (builds, devices) = finished
            .map(|r| (r.build.clone(), format!("{}: {}", r.backend, r.device)))
            .unzip::<_, _, Vec<_>, Vec<_>>();
        let failures = plan.failures().into_iter().map(|(run, fault)| Failure {
            run: run.clone(),
            reason: fault.reason.clone(),
            message: fault.message.clone(),
        });
        let (rows, means) = rows::of(suite, &samples, invocation);
        Self {
            version: VERSION,
            suite: suite.name.clone(),
            about: suite.about.clone(),
            command: invocation.command(),
            builds: unique(builds),
            devices: unique(devices),
            runs,
            missing: runs - records.len(),
            rows,
            means,
            differences: compare::all(suite, &samples),
            gains: suite.figure.as_ref().map(|figure| gains::of(suite, figure, &samples)),
            failures: failures.collect(),
        }
    }

    /// The table for people.
    pub fn to_markdown(&self) -> String {
        markdown::write(self)
    }

    /// The table for programs: `table.json`.
    ///
    /// # Errors
    /// If a figure cannot be written.
    pub fn to_json(&self) -> Result<String, Error> {
        let json = serde_json::to_string_pretty(self);
        json.map(|text| text + "\n").map_err(|e| Error::Writing(e.to_string()))
    }
}

#[cfg(test)]
mod tests;
