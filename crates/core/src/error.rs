//! Categories of errors, independent of any transport. Every error of the project has a
//! [`Category`] and a stable reason; only the server turns a category into an HTTP status or a gRPC
//! code.

use std::time::Duration;

pub use bendtwin_problem_derive::Problem;
use serde::{Deserialize, Serialize};

/// The kind of an error, independent of HTTP and gRPC.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Category {
    /// The request, capture or settings are wrong; sending them again will not help.
    InvalidArgument,
    /// The named resource does not exist.
    NotFound,
    /// The resource exists already, with other content.
    AlreadyExists,
    /// The request is fine but the system is not in the state that it needs.
    FailedPrecondition,
    /// No or unknown credentials.
    Unauthenticated,
    /// Known credentials without the right.
    PermissionDenied,
    /// A quota, queue or memory limit is reached; retry later or ask for less.
    ResourceExhausted,
    /// A concurrent change won (for example, the lease is stale).
    Aborted,
    /// The caller's deadline passed.
    DeadlineExceeded,
    /// The caller or a user cancelled the work.
    Cancelled,
    /// A process that is needed cannot be reached at the moment.
    Unavailable,
    /// Acknowledged data is missing or damaged.
    DataLoss,
    /// A defect of this software.
    Internal,
}

impl Category {
    /// All of them, in the order above.
    pub const ALL: [Self; 13] = [
        Self::InvalidArgument,
        Self::NotFound,
        Self::AlreadyExists,
        Self::FailedPrecondition,
        Self::Unauthenticated,
        Self::PermissionDenied,
        Self::ResourceExhausted,
        Self::Aborted,
        Self::DeadlineExceeded,
        Self::Cancelled,
        Self::Unavailable,
        Self::DataLoss,
        Self::Internal,
    ];
}

/// Facts about an error that programs act on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Facts {
    /// The kind of the error.
    pub category: Category,
    /// A stable UPPER_SNAKE_CASE word for programs to branch on.
    pub reason: &'static str,
    /// Delay after which another attempt makes sense, if it does.
    pub retry_after: Option<Duration>,
}

/// Implemented by every error of the project, by a derive that reads the facts beside the message of
/// each variant.
pub trait Problem: std::error::Error {
    /// Category, reason and delay.
    fn facts(&self) -> Facts;

    /// The kind of the error.
    fn category(&self) -> Category {
        self.facts().category
    }

    /// A stable UPPER_SNAKE_CASE word for programs to branch on.
    fn reason(&self) -> &'static str {
        self.facts().reason
    }

    /// Delay after which another attempt makes sense, if it does.
    fn retry_after(&self) -> Option<Duration> {
        self.facts().retry_after
    }

    /// The portable form, which a failed job keeps and a client receives.
    fn fault(&self) -> Fault {
        Fault::of(self)
    }
}

impl<P: Problem> Problem for Box<P> {
    fn facts(&self) -> Facts {
        (**self).facts()
    }

    fn fault(&self) -> Fault {
        (**self).fault()
    }
}

/// An error at rest: category, reason and message, as stored with a failed job
/// and as sent over the wire.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fault {
    /// The kind of the error.
    pub category: Category,
    /// Stable UPPER_SNAKE_CASE word.
    pub reason: String,
    /// Description of the error for people, and what to do about it.
    pub message: String,
}

impl Fault {
    /// Category, reason and message of a problem.
    pub fn of(problem: &(impl Problem + ?Sized)) -> Self {
        Self {
            category: problem.category(),
            reason: problem.reason().to_owned(),
            message: problem.to_string(),
        }
    }
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Fault {}

/// Message of a caught panic.
pub fn panic_text(panic: &(dyn std::any::Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}

#[cfg(test)]
mod tests;
