//! Fit settings from a file and from `--set key=value`, checked before they are sent.

use std::path::PathBuf;

use anyhow::Context as _;
use bendtwin_core::{FitSettings, settings::layers::merge};
use clap::Args;
use serde_json::Value;

use crate::failure::Usage;

/// Sources of settings; later ones take precedence.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct SettingsArgs {
    /// JSON file with settings (docs/settings.md)
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
    /// One setting, for example `graph.max_nodes=400`; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
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
        for text in &self.overrides {
            let (key, given) = text.split_once('=').ok_or_else(|| {
                Usage::error(format!(
                    "--set {text}: write key=value, for example `graph.max_nodes=400`"
                ))
            })?;
            set(&mut value, key.trim(), parse(given.trim()))?;
        }
        let mut settings: FitSettings =
            serde_json::from_value(value).map_err(|e| Usage::error(format!("settings: {e}")))?;
        settings.compare_axial |= self.axial;
        match settings.validate() {
            Ok(()) => Ok(settings),
            Err(faults) => Err(Usage::error(format!("settings: {}", faults.join("; ")))),
        }
    }
}

/// The text as JSON if it is valid JSON, else as a string.
fn parse(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|_| Value::String(text.to_owned()))
}

/// Sets a field by its path; an unknown name is refused with a list of the known ones.
fn set(root: &mut Value, key: &str, value: Value) -> anyhow::Result<()> {
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
            Usage::error(format!("--set {key}: there is no `{part}`; there is {known}"))
        })?;
    }
    *at = value;
    Ok(())
}

#[cfg(test)]
mod tests;
