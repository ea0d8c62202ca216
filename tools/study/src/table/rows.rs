//! The rows: of each capture, and as means over captures.

use std::collections::BTreeSet;

use bendtwin_core::quality::Predictor;
use bendtwin_eval::predictor_name;

use super::{
    Figure, Figures, Kind, Row, Size,
    samples::{Samples, Seeds, baseline_row, figure, figures, over_seeds},
};
use crate::{
    command::Invocation,
    suite::{BASELINES, Suite},
};

/// Rows of captures, and means over captures.
pub(super) fn of(
    suite: &Suite,
    samples: &Samples<'_>,
    invocation: &Invocation,
) -> (Vec<Row>, Vec<Row>) {
    let maker = Maker { suite, samples, invocation };
    let captures = suite.captures.iter();
    let rows = captures.flat_map(|c| maker.rows(Some(&c.name))).collect();
    let means = if suite.captures.len() > 1 { maker.rows(None) } else { Vec::new() };
    (rows, means)
}

struct Maker<'a> {
    suite: &'a Suite,
    samples: &'a Samples<'a>,
    invocation: &'a Invocation,
}

impl Maker<'_> {
    /// Configurations, baselines and published figures of a capture, or as means.
    fn rows(&self, capture: Option<&str>) -> Vec<Row> {
        let names = || self.suite.configurations.iter().map(|c| c.name.as_str());
        let mut rows = Vec::new();
        for name in names() {
            if let Some(row) = self.row(name, name.to_owned(), Kind::Configuration, capture) {
                let command = self.invocation.row_command(capture.unwrap_or("*"), name);
                rows.push(Row { command: Some(command), ..row });
            }
        }
        for (baseline, predictor) in BASELINES {
            let named = names().filter_map(|name| {
                let row = baseline_row(name, baseline);
                Some((name, self.row(&row, String::new(), Kind::Baseline, capture)?))
            });
            rows.extend(self.merged(predictor, named.collect(), capture));
        }
        for name in self.samples.published() {
            let label = format!("{name} (published)");
            rows.extend(self.row(name, label, Kind::Published, capture));
        }
        rows
    }

    /// A baseline's rows: what does not depend on the configuration stands there once. The mean of
    /// fits and the last residual do, for they stand on the fits' own predictions.
    fn merged(
        &self,
        predictor: Predictor,
        rows: Vec<(&str, Row)>,
        capture: Option<&str>,
    ) -> Vec<Row> {
        let depends = matches!(predictor, Predictor::MeanOfFits | Predictor::LastResidual);
        let agree = |a: &Row, b: &Row| !depends && self.samples.agree(&a.row, &b.row, capture);
        let mut groups: Vec<(Vec<&str>, Row)> = Vec::new();
        for (name, row) in rows {
            match groups.iter_mut().find(|(_, kept)| agree(kept, &row)) {
                Some((names, kept)) => {
                    names.push(name);
                    // Runs that failed have no baselines: the row with most values stays.
                    if (row.captures, row.seeds) > (kept.captures, kept.seeds) {
                        *kept = row;
                    }
                }
                None => groups.push((vec![name], row)),
            }
        }
        let alone = groups.len() == 1 && !depends;
        let named = |(names, row): (Vec<&str>, Row)| {
            let what = predictor_name(predictor);
            let label =
                if alone { what.to_owned() } else { format!("{what}, {}", names.join(", ")) };
            Row { label, ..row }
        };
        groups.into_iter().map(named).collect()
    }

    fn row(&self, row: &str, label: String, kind: Kind, capture: Option<&str>) -> Option<Row> {
        let made = |seeds: usize, captures, errors, size, fit_s| Row {
            row: row.to_owned(),
            label: label.clone(),
            kind,
            capture: capture.map(str::to_owned),
            captures,
            seeds,
            size,
            errors,
            fit_s,
            command: None,
        };
        let Some(capture) = capture else {
            if let Some(values) = self.samples.published_mean(row) {
                let known = |i: usize| values[i].map(|mean| Figure { mean, spread: None });
                return Some(made(1, None, figures(known), None, None));
            }
            let all: Vec<&Seeds> = self.samples.captures(row).map(|(_, seeds)| seeds).collect();
            let seeds = all.iter().map(|s| s.len()).max()?;
            let fit_s = mean_of(&all, |s| s.values().filter_map(|s| s.fit_s).collect());
            let size = size(all.iter().flat_map(|s| s.values()).filter_map(|s| s.size).collect());
            return Some(made(seeds, Some(all.len()), over_captures(&all), size, fit_s));
        };
        let seeds = self.samples.seeds(row, capture)?;
        let errors = figures(|i| figure(&over_seeds(seeds, i)));
        let fit_s = figure(&seeds.values().filter_map(|s| s.fit_s).collect::<Vec<_>>());
        let size = size(seeds.values().filter_map(|s| s.size).collect());
        Some(made(seeds.len(), None, errors, size, fit_s))
    }
}

/// Means over captures, column by column, of those captures that have the column. The spread is
/// that of the means that single seeds give, if every capture has every seed.
fn over_captures(all: &[&Seeds]) -> Figures {
    figures(|i| {
        let with: Vec<&&Seeds> = all.iter().filter(|s| !over_seeds(s, i).is_empty()).collect();
        let known = |s: &&&Seeds| -> BTreeSet<u64> {
            s.iter().filter(|(_, x)| x.values[i].is_some()).map(|(seed, _)| *seed).collect()
        };
        let seeds = with.first().map(known)?;
        if with.iter().any(|s| known(s) != seeds) {
            let means: Vec<f64> =
                with.iter().filter_map(|s| Some(figure(&over_seeds(s, i))?.mean)).collect();
            return figure(&means).map(|f| Figure { spread: None, ..f });
        }
        let of_seed = |seed: &u64| {
            let sum: f64 = with.iter().filter_map(|s| s.get(seed)?.values[i]).sum();
            sum / with.len() as f64
        };
        figure(&seeds.iter().map(of_seed).collect::<Vec<_>>())
    })
}

fn mean_of(all: &[&Seeds], values: impl Fn(&Seeds) -> Vec<f64>) -> Option<Figure> {
    let means: Vec<f64> = all.iter().filter_map(|s| Some(figure(&values(s))?.mean)).collect();
    figure(&means).map(|f| Figure { spread: None, ..f })
}

fn size(sizes: Vec<Size>) -> Option<Size> {
    let mean = |of: fn(&Size) -> f64| figure(&sizes.iter().map(of).collect::<Vec<_>>());
    let degrees: Option<Vec<f64>> = sizes.iter().map(|s: &Size| s.degree).collect();
    Some(Size {
        nodes: mean(|s| s.nodes)?.mean,
        springs: mean(|s| s.springs)?.mean,
        triplets: mean(|s| s.triplets)?.mean,
        degree: degrees.and_then(|degrees| Some(figure(&degrees)?.mean)),
    })
}
