//! The place of a twin that a command reads: the server, or a file.

use std::{
    path::{Path, PathBuf},
    str::FromStr,
};

use anyhow::Context as _;
use bendtwin_client::TwinId;

use crate::global::Global;

/// The place of a twin.
#[derive(Clone, Debug)]
pub(super) enum Source {
    Server(TwinId),
    File(PathBuf),
}

impl Source {
    /// Name and content of the twin.
    pub(super) async fn read(&self, global: &Global) -> anyhow::Result<(String, Vec<u8>)> {
        match self {
            Self::Server(id) => {
                Ok((id.to_string(), global.connect().await?.twins().export(*id).await?))
            }
            Self::File(path) => {
                let read = std::fs::read(path);
                let content = read.with_context(|| format!("cannot read {}", path.display()))?;
                Ok((super::stem(path), content))
            }
        }
    }

    /// Name of the twin for people; the id of a twin without a name.
    pub(super) async fn title(&self, global: &Global) -> anyhow::Result<String> {
        match self {
            Self::Server(id) => {
                let name = global.connect().await?.twins().get(*id).await?.display_name;
                Ok(if name.is_empty() { id.to_string() } else { name })
            }
            Self::File(path) => Ok(super::stem(path)),
        }
    }
}

impl FromStr for Source {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if Path::new(text).is_file() {
            return Ok(Self::File(text.into()));
        }
        let id = text.parse().map(Self::Server);
        id.map_err(|e| format!("{e}, nor is there a file of this name"))
    }
}
