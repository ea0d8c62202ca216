//! Fit settings from a file and from `--set key=value`, checked before they are sent.

use std::path::PathBuf;

use anyhow::Context as _;
use bendtwin_core::{
    FitSettings,
    settings::{
        Effort,
        layers::{self, merge},
    },
};
use clap::Args;
use serde_json::Value;

use crate::failure::Usage;

/// Sources of settings; later ones take precedence.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct SettingsArgs {
    /// JSON file with settings (docs/use/settings.md)
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
    /// Setting, for example `graph.max_nodes=400`; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Preset of the settings that are left open: draft, standard or best
    #[arg(long, value_name = "EFFORT", value_parser = effort)]
    effort: Option<Effort>,
    /// Time that the fit may take, for example 60s, 5m or 1h
    #[arg(long, value_name = "TIME", value_parser = seconds)]
    within: Option<f64>,
    /// Start from PhysTwin's scheme as published instead of the defaults
    #[arg(long)]
    phystwin: bool,
    /// Also fit the same nodes without bending, for comparison
    #[arg(long)]
    axial: bool,
}

impl SettingsArgs {
    /// The settings in force.
    pub(crate) fn resolve(&self) -> anyhow::Result<FitSettings> {
        let base = if self.phystwin { FitSettings::phystwin() } else { FitSettings::default() };
        let mut value = serde_json::to_value(&base)?;
        if let Some(path) = &self.settings {
            let text = std::fs::read_to_string(path)
                .with_context(|| format!("cannot read the settings {}", path.display()))?;
            let file: Value = serde_json::from_str(&text)
                .map_err(|e| Usage::error(format!("{}: {e}", path.display())))?;
            merge(&mut value, file);
        }
        let mut faults = Vec::new();
        for text in &self.overrides {
            let applied = match text.split_once('=') {
                Some((key, given)) => set(&mut value, key.trim(), parse(given.trim())),
                None => Err("write key=value, for example `graph.max_nodes=400`".to_owned()),
            };
            faults.extend(applied.err().map(|fault| format!("--set {text}: {fault}")));
        }
        let read = layers::read::<FitSettings>(value);
        faults.extend(read.as_ref().err().into_iter().flatten().cloned());
        let (Ok(mut settings), true) = (read, faults.is_empty()) else {
            return Err(Usage::error(format!("settings: {}", faults.join("; "))));
        };
        settings.compare_axial |= self.axial;
        settings.effort = self.effort.unwrap_or(settings.effort);
        settings.within_s = self.within.or(settings.within_s);
        match settings.validate() {
            Ok(()) => Ok(settings),
            Err(faults) => Err(Usage::error(format!("settings: {}", faults.join("; ")))),
        }
    }
}

/// An effort by its name.
fn effort(text: &str) -> Result<Effort, String> {
    serde_json::from_value(Value::String(text.to_owned()))
        .map_err(|_| "use draft, standard or best".to_owned())
}

/// A time in seconds, minutes or hours [s]; without a unit, in seconds.
fn seconds(text: &str) -> Result<f64, String> {
    let units = [("s", 1.0), ("m", 60.0), ("h", 3600.0)];
    let unit = units.iter().find_map(|(unit, s)| Some((text.strip_suffix(unit)?, *s)));
    let (number, unit_s) = unit.unwrap_or((text, 1.0));
    let time = number.trim().parse::<f64>().ok().map(|n| n * unit_s);
    time.filter(|s| s.is_finite() && *s > 0.0).ok_or_else(|| "write 60s, 5m or 1h".to_owned())
}

/// The text as JSON if it is valid JSON, else as a string.
fn parse(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|_| Value::String(text.to_owned()))
}

/// Sets a field by its path; an unknown name is refused with a list of the known ones.
fn set(root: &mut Value, key: &str, value: Value) -> Result<(), String> {
    // `substeps` is either {"auto": {...}} or {"fixed": n}: naming the other one switches.
    if let Some(variant) = key.strip_prefix("substeps.")
        && !variant.contains('.')
    {
        root["substeps"] = serde_json::json!({ variant: value });
        return Ok(());
    }
    let mut at = root;
    for part in key.split('.') {
        let known = match at {
            Value::Object(fields) => fields.keys().cloned().collect::<Vec<_>>(),
            _ => Vec::new(),
        };
        at = at.get_mut(part).ok_or_else(|| {
            let known = if known.is_empty() { "nothing".to_owned() } else { known.join(", ") };
            format!("there is no `{part}`; there is {known}")
        })?;
    }
    *at = value;
    Ok(())
}

#[cfg(test)]
mod tests;
