//! Commands that make figures again, as a person would type them.

use std::path::{Path, PathBuf};

use bendtwin_core::{FitSettings, settings::layers::changes};
use serde_json::Value;

/// The command that started a suite.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Invocation {
    /// Path of the suite, as typed.
    pub suite: PathBuf,
    /// Path of the data folder, as typed.
    pub data: Option<PathBuf>,
    /// Path of the output folder, as typed.
    pub out: PathBuf,
}

impl Invocation {
    /// The command that makes the whole table.
    pub fn command(&self) -> String {
        let mut words = vec!["cargo lab suite".to_owned(), path(&self.suite)];
        if let Some(data) = &self.data {
            words.push(format!("--data {}", path(data)));
        }
        words.push(format!("--out {}", path(&self.out)));
        words.join(" ")
    }

    /// The command that makes a row: all seeds of a configuration, on a capture or on all (`*`).
    pub(crate) fn row_command(&self, capture: &str, configuration: &str) -> String {
        let only = format!("{capture}/{configuration}");
        format!("{} --only {}", self.command(), quoted(&only))
    }
}

/// The command that makes one run by itself: it has all settings that are not the defaults, the
/// seed among them.
pub(crate) fn of_run(capture: &Path, settings: &FitSettings, backend: &str) -> String {
    let mut words = vec![format!("bendtwin eval {} --backend {backend}", path(capture))];
    for (key, value) in changes(settings) {
        let value = match value {
            Value::String(text) => text,
            value => value.to_string(),
        };
        words.push(format!("--set {}", quoted(&format!("{key}={value}"))));
    }
    words.join(" ")
}

fn path(path: &Path) -> String {
    quoted(&path.display().to_string())
}

/// A word quoted for a shell, if it needs quotes.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use bendtwin_core::settings::Substeps;

    use super::*;

    #[test]
    fn a_command_says_what_is_not_as_usual() {
        let mut settings = FitSettings { seed: 4, bending: false, ..FitSettings::default() };
        settings.substeps = Substeps::Fixed(667);
        settings.refine.passes = Some(7);
        let command = of_run(Path::new("my data/rope.zip"), &settings, "cpu");
        assert_eq!(
            command,
            "bendtwin eval 'my data/rope.zip' --backend cpu --set bending=false --set refine.passes=7 --set seed=4 \
             --set 'substeps={\"fixed\":667}'"
        );
    }

    #[test]
    fn an_invocation_is_recorded_verbatim() {
        let mut invocation =
            Invocation { suite: "studies/a.json".into(), data: None, out: "it's".into() };
        assert_eq!(invocation.command(), r"cargo lab suite studies/a.json --out 'it'\''s'");
        invocation.data = Some("data".into());
        assert!(invocation.command().contains("--data data --out"));
    }
}
