//! How a command fails: what happened and what to do on stderr, 2 for wrong
//! usage and 1 for everything else.

use std::process::ExitCode;

use bendtwin_core::{Category, Fault, Problem};
use serde_json::json;

/// The command was used wrongly.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(crate) struct Usage(pub(crate) String);

impl Usage {
    /// As an error of a command.
    pub(crate) fn error(message: impl Into<String>) -> anyhow::Error {
        Self(message.into()).into()
    }
}

/// A fault that keeps its category and reason on the way to the user.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(crate) struct Failed(pub(crate) Fault);

/// An error of one of the project's libraries, with its category and reason.
pub(crate) fn failed(error: impl Problem) -> anyhow::Error {
    Failed(error.fault()).into()
}

/// Tells the user; returns the exit code.
pub(crate) fn report(error: &anyhow::Error, json: bool) -> ExitCode {
    let told = Told::of(error);
    if json {
        let document = json!({ "error": {
            "category": told.category,
            "reason": told.reason,
            "message": told.message,
            "request_id": told.request_id,
        }});
        eprintln!("{document}");
    } else {
        eprintln!("error: {}", told.message);
        if let Some(id) = &told.request_id
            && matches!(told.category, Some(Category::Internal | Category::DataLoss))
        {
            eprintln!("       (request {id}: the server's log has the details)");
        }
    }
    ExitCode::from(told.exit_code)
}

/// What a user is told.
struct Told {
    category: Option<Category>,
    reason: Option<String>,
    message: String,
    request_id: Option<String>,
    exit_code: u8,
}

impl Told {
    fn of(error: &anyhow::Error) -> Self {
        let mut told = Self {
            category: None,
            reason: None,
            message: format!("{error:#}"),
            request_id: None,
            exit_code: 1,
        };
        for cause in error.chain() {
            if let Some(error) = cause.downcast_ref::<bendtwin_client::Error>() {
                told.category = Some(error.category());
                told.reason = Some(error.reason().to_owned());
                told.request_id = error.request_id().map(str::to_owned);
            } else if let Some(Failed(fault)) = cause.downcast_ref() {
                told.category = Some(fault.category);
                told.reason = Some(fault.reason.clone());
            } else if cause.is::<Usage>() {
                told.category = Some(Category::InvalidArgument);
                told.reason = Some("USAGE".to_owned());
                told.exit_code = 2;
            }
        }
        told
    }
}

#[cfg(test)]
mod tests {
    use anyhow::Context as _;

    use super::*;

    #[test]
    fn usage_is_two_and_failure_is_one() {
        assert_eq!(Told::of(&Usage::error("no")).exit_code, 2);
        let fault = Fault {
            category: Category::NotFound,
            reason: "NO_SUCH_TWIN".into(),
            message: "there is no such twin".into(),
        };
        let error = Err::<(), _>(Failed(fault)).context("twins/1").unwrap_err();
        let told = Told::of(&error);
        assert_eq!((told.exit_code, told.reason.as_deref()), (1, Some("NO_SUCH_TWIN")));
        assert_eq!(told.message, "twins/1: there is no such twin");
    }
}
