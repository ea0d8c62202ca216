//! A suite: captures, configurations, seeds, and comparisons. docs/develop/suites.md specifies the file.

mod figure;
mod parse;
mod selection;

use std::path::{Path, PathBuf};

use bendtwin_core::{
    FitSettings,
    quality::{ErrorSummary, Predictor},
    settings::layers::{merge, read, unknown_fields},
};
use serde::{Deserialize, Serialize};
use serde_json::Value;

pub(crate) use self::figure::MOST_SERIES;
pub use self::{
    figure::{FigureEntry, Series},
    selection::Selection,
};
use crate::Error;

/// A list of captures and the ways in which each of them is fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct Suite {
    /// The file that it was read from.
    pub file: PathBuf,
    /// A title for people.
    pub name: String,
    /// Purpose of the suite.
    pub about: String,
    /// Captures to fit to.
    pub captures: Vec<CaptureEntry>,
    /// Settings that all configurations share, over the defaults.
    pub base: Value,
    /// Configurations of the fits.
    pub configurations: Vec<Configuration>,
    /// Each run is repeated with each of these seeds.
    pub seeds: Vec<u64>,
    /// Rows whose relative differences the table shows.
    pub compare: Vec<Comparison>,
    /// Published figures to stand beside.
    pub references: Vec<Reference>,
    /// The picture of differences over mean degrees, if there is to be one.
    pub figure: Option<FigureEntry>,
}

/// A capture of a suite.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct CaptureEntry {
    /// Name in tables and files.
    pub name: String,
    /// Path, relative to the suite's folder or to the data folder.
    pub path: PathBuf,
    /// Kind of object, by which configurations and the suite's picture group captures.
    #[serde(default)]
    pub group: Option<String>,
    /// Settings for this capture alone; they go over those of the configuration.
    #[serde(default)]
    pub settings: Value,
}

/// A way to fit.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Configuration {
    /// Name in tables and files.
    pub name: String,
    /// Groups of the captures that it is for; all captures if empty.
    #[serde(default)]
    pub groups: Vec<String>,
    /// Changes of the base settings.
    #[serde(default)]
    pub settings: Value,
}

impl Configuration {
    /// True if it is for a capture.
    pub fn is_for(&self, capture: &CaptureEntry) -> bool {
        self.groups.is_empty() || capture.group.as_ref().is_some_and(|g| self.groups.contains(g))
    }
}

/// Two rows of the table, one measured by the other.
///
/// A row is named by its configuration, by its reference, or as `configuration:baseline`, where the
/// baseline is `standing_still`, `last_residual` or `clamp_interpolation`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Comparison {
    /// Row whose errors are compared.
    pub of: String,
    /// Row that they are compared with.
    pub against: String,
}

/// Published figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Name of the method that they belong to.
    pub name: String,
    /// Capture that they belong to; if none, they are means over captures.
    pub capture: Option<String>,
    /// Errors on training frames.
    pub train: ErrorSummary,
    /// Errors on future frames.
    pub future: ErrorSummary,
}

/// A fit of a suite, written `capture/configuration/seed`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct RunId {
    /// Name of the capture.
    pub capture: String,
    /// Name of the configuration.
    pub configuration: String,
    /// The seed.
    pub seed: u64,
}

impl std::fmt::Display for RunId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}/{}", self.capture, self.configuration, self.seed)
    }
}

/// Names in comparisons of what is predicted beside each fit: the mean of its fits, and free baselines.
pub(crate) const BASELINES: [(&str, Predictor); 4] = [
    ("mean_of_fits", Predictor::MeanOfFits),
    ("standing_still", Predictor::StandingStill),
    ("clamp_interpolation", Predictor::ClampInterpolation),
    ("last_residual", Predictor::LastResidual),
];

impl Suite {
    /// Reads and checks a suite.
    ///
    /// # Errors
    /// If it cannot be read, or with everything that is wrong with it.
    pub fn read(file: &Path) -> Result<Self, Error> {
        let text = std::fs::read_to_string(file).map_err(Error::file(file))?;
        parse::parse(file, &text).map_err(|faults| Error::Suite { file: file.to_owned(), faults })
    }

    /// Path of a capture: under the data folder if there is one, by its path or by its file name
    /// alone, otherwise relative to the suite's folder.
    pub fn locate(&self, capture: &CaptureEntry, data: Option<&Path>) -> PathBuf {
        let folder = match data {
            Some(data) => {
                let named = capture.path.file_name().map(|name| data.join(name));
                let full = data.join(&capture.path);
                match named {
                    Some(named) if !full.exists() && named.exists() => return named,
                    _ => return full,
                }
            }
            None => self.file.parent().unwrap_or(Path::new("")),
        };
        folder.join(&capture.path)
    }

    /// The settings of a run.
    ///
    /// # Errors
    /// Everything that is wrong with them; a suite that was read has no such faults.
    pub fn settings(
        &self,
        capture: &CaptureEntry,
        configuration: &Configuration,
        seed: u64,
    ) -> Result<FitSettings, Vec<String>> {
        in_force(&[&self.base, &configuration.settings, &capture.settings], seed)
    }

    /// All runs, the first seed of all captures before the second.
    pub fn runs(&self) -> impl Iterator<Item = (RunId, &CaptureEntry, &Configuration)> {
        self.seeds.iter().flat_map(move |&seed| {
            self.captures.iter().flat_map(move |capture| {
                let configurations = self.configurations.iter().filter(|c| c.is_for(capture));
                configurations.map(move |configuration| {
                    let id = RunId {
                        capture: capture.name.clone(),
                        configuration: configuration.name.clone(),
                        seed,
                    };
                    (id, capture, configuration)
                })
            })
        })
    }
}

/// Settings from layers over the defaults.
fn in_force(layers: &[&Value], seed: u64) -> Result<FitSettings, Vec<String>> {
    let mut document = serde_json::to_value(FitSettings::default()).unwrap_or_default();
    for layer in layers.iter().filter(|layer| !layer.is_null()) {
        merge(&mut document, (*layer).clone());
    }
    let settings: FitSettings = read(document)?;
    let settings = FitSettings { seed, ..settings };
    settings.validate().map(|()| settings)
}

/// Faults of a layer that do not depend on the layers below it.
fn faults_of_layer(layer: &Value) -> Vec<String> {
    if layer.is_null() {
        return Vec::new();
    }
    if !layer.is_object() {
        return vec!["settings are an object".to_owned()];
    }
    let mut faults: Vec<String> =
        unknown_fields(layer).into_iter().map(|f| format!("there is no setting `{f}`")).collect();
    if layer.get("seed").is_some() {
        faults.push("the seed stands in `seeds`, not in settings".to_owned());
    }
    if layer.get("compare_axial").is_some_and(|v| v != &Value::Bool(false)) {
        faults.push("instead of compare_axial, add a configuration with \"bending\": false".into());
    }
    faults
}

#[cfg(test)]
mod tests;
