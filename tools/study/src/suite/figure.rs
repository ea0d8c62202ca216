//! The picture that a suite asks for: how much nearer one configuration is than another, over the
//! number of springs that meet at a node.

use std::collections::HashSet;

use serde::Deserialize;

use super::{Comparison, Configuration};

/// Most series: one colour each.
pub(crate) const MOST_SERIES: usize = 3;

/// A picture of differences over mean degrees.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FigureEntry {
    /// Title; that of the suite if left out.
    #[serde(default)]
    pub title: Option<String>,
    /// Mean degrees, ascending: runs count to the one that is nearest to theirs by ratio.
    pub degrees: Vec<f64>,
    /// Lines of the picture.
    pub series: Vec<Series>,
}

/// Pairs of configurations that differ in the same way.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Series {
    /// Name in the picture.
    pub name: String,
    /// Pairs of configurations; the degree is that of the twin that the other is compared with.
    pub pairs: Vec<Comparison>,
}

impl FigureEntry {
    /// Everything that is wrong with it.
    pub(super) fn faults(&self, configurations: &[Configuration]) -> Vec<String> {
        let mut faults = Vec::new();
        let ascend = self.degrees.windows(2).all(|pair| pair[0] < pair[1]);
        let positive = self.degrees.iter().all(|degree| degree.is_finite() && *degree > 0.0);
        if self.degrees.is_empty() || !ascend || !positive {
            faults.push("figure.degrees are positive numbers that ascend".to_owned());
        }
        if self.series.is_empty() || self.series.len() > MOST_SERIES {
            faults.push(format!("figure.series has 1 to {MOST_SERIES} entries"));
        }
        let names: HashSet<&str> = self.series.iter().map(|s| s.name.as_str()).collect();
        if names.len() < self.series.len() {
            faults.push("figure: a series stands twice".to_owned());
        }
        for series in &self.series {
            if series.name.is_empty() || series.name.contains(['|', '\n']) {
                faults
                    .push(format!("figure: series `{}`: give it a name without `|`", series.name));
            }
            if series.pairs.is_empty() {
                faults.push(format!("figure: series `{}` has no pairs", series.name));
            }
            let sides = series.pairs.iter().flat_map(|pair| [&pair.of, &pair.against]);
            for side in sides.filter(|side| configurations.iter().all(|c| c.name != **side)) {
                faults.push(format!("figure: there is no configuration `{side}`"));
            }
        }
        faults
    }
}
