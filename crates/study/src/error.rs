//! Why a suite cannot be run. A run that fails is no error of its suite: its record says why.

use std::path::{Path, PathBuf};

use bendtwin_core::{Category, Problem};

/// Why a suite cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The suite contradicts itself, or names what does not exist.
    #[error("{}: {}", file.display(), faults.join("; "))]
    Suite {
        /// The suite's file.
        file: PathBuf,
        /// Everything that is wrong, one sentence each.
        faults: Vec<String>,
    },
    /// `--only` names nothing.
    #[error("{0}")]
    Selection(String),
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// Which one.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Someone asked to stop while captures were read.
    #[error("stopped while captures were read: the same command begins anew")]
    Cancelled,
    /// Another process fills the folder.
    #[error(
        "{}: another process works in this folder: wait for it, or choose another one", .0.display()
    )]
    Busy(PathBuf),
    /// A result could not be written as JSON, or a picture as PNG.
    #[error("{0}")]
    Writing(String),
}

impl Error {
    pub(crate) fn file(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::File { path, source }
    }
}

impl Problem for Error {
    fn category(&self) -> Category {
        match self {
            Self::Suite { .. } | Self::Selection(_) => Category::InvalidArgument,
            Self::File { source, .. } if source.kind() == std::io::ErrorKind::NotFound => {
                Category::NotFound
            }
            Self::Cancelled => Category::Cancelled,
            Self::Busy(_) => Category::FailedPrecondition,
            Self::File { .. } | Self::Writing(_) => Category::Internal,
        }
    }

    fn reason(&self) -> &'static str {
        match self {
            Self::Suite { .. } => "INVALID_SUITE",
            Self::Selection(_) => "NO_SUCH_RUN",
            Self::File { .. } => "STUDY_FILE",
            Self::Cancelled => "CANCELLED",
            Self::Busy(_) => "STUDY_FOLDER_BUSY",
            Self::Writing(_) => "STUDY_NOT_WRITTEN",
        }
    }
}
