//! Selection of runs of a suite: `capture/configuration/seed`, with `*` for all; parts left out at
//! the end stand for all, too.

use std::str::FromStr;

use super::RunId;

/// A pattern of run names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Selection {
    text: String,
    parts: Vec<String>,
}

impl Selection {
    /// True if it selects a run.
    pub fn contains(&self, id: &RunId) -> bool {
        let names = [&id.capture, &id.configuration, &id.seed.to_string()];
        self.parts.iter().zip(names).all(|(part, name)| part == "*" || part == name)
    }
}

impl FromStr for Selection {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parts: Vec<String> = text.split('/').map(str::to_owned).collect();
        if parts.len() > 3 || parts.iter().any(String::is_empty) {
            return Err(format!("`{text}`: write capture/configuration/seed; `*` stands for all"));
        }
        Ok(Self { text: text.to_owned(), parts })
    }
}

impl std::fmt::Display for Selection {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.text)
    }
}
