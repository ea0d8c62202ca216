//! Errors of commands: the message with the action to take on stderr; exit code 2 for wrong usage,
//! 1 for everything else.

use std::process::ExitCode;

use bendtwin_core::{Category, Fault, Problem};
use serde_json::json;

/// The command was used wrongly.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Usage(pub String);

impl Usage {
    /// The usage error as an error of a command.
    pub fn error(message: impl Into<String>) -> anyhow::Error {
        Self(message.into()).into()
    }
}

/// A fault that keeps its category and reason on the way to the user.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Failed(pub Fault);

/// A fault that a report on the terminal has already shown; only scripts see it again.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Shown(pub Fault);

/// An error whose message was shown.
pub fn shown(error: impl Problem) -> anyhow::Error {
    Shown(error.fault()).into()
}

/// An error of one of the project's libraries, with its category and reason.
pub fn failed(error: impl Problem) -> anyhow::Error {
    Failed(error.fault()).into()
}

/// Prints the error; returns the exit code.
pub fn report(error: &anyhow::Error, json: bool) -> ExitCode {
    let report = ErrorReport::of(error);
    if json {
        let document = json!({ "error": {
            "category": report.category,
            "reason": report.reason,
            "message": report.message,
            "request_id": report.request_id,
        }});
        eprintln!("{document}");
    } else if !error.is::<Shown>() {
        eprintln!("error: {}", report.message);
        if let Some(id) = &report.request_id
            && matches!(report.category, Some(Category::Internal | Category::DataLoss))
        {
            eprintln!("       (request {id}: the server's log has the details)");
        }
    }
    ExitCode::from(report.exit_code)
}

/// Error in the form in which a user sees it.
struct ErrorReport {
    category: Option<Category>,
    reason: Option<String>,
    message: String,
    request_id: Option<String>,
    exit_code: u8,
}

impl ErrorReport {
    fn of(error: &anyhow::Error) -> Self {
        let mut report = Self {
            category: None,
            reason: None,
            message: format!("{error:#}"),
            request_id: None,
            exit_code: 1,
        };
        for cause in error.chain() {
            if let Some(error) = cause.downcast_ref::<bendtwin_client::Error>() {
                report.category = Some(error.category());
                report.reason = Some(error.reason().to_owned());
                report.request_id = error.request_id().map(str::to_owned);
            } else if let Some(fault) = fault_of(cause) {
                report.category = Some(fault.category);
                report.reason = Some(fault.reason.clone());
            } else if cause.is::<Usage>() {
                report.category = Some(Category::InvalidArgument);
                report.reason = Some("USAGE".to_owned());
                report.exit_code = 2;
            }
        }
        report
    }
}

/// The fault that an error keeps.
fn fault_of<'a>(error: &'a (dyn std::error::Error + 'static)) -> Option<&'a Fault> {
    let failed = error.downcast_ref().map(|Failed(fault)| fault);
    failed.or_else(|| error.downcast_ref().map(|Shown(fault)| fault))
}

#[cfg(test)]
mod tests {
    use anyhow::Context as _;

    use super::*;

    #[test]
    fn usage_is_two_and_failure_is_one() {
        assert_eq!(ErrorReport::of(&Usage::error("no")).exit_code, 2);
        let fault = Fault {
            category: Category::NotFound,
            reason: "NO_SUCH_TWIN".into(),
            message: "there is no such twin".into(),
        };
        let error = Err::<(), _>(Failed(fault)).context("twins/1").unwrap_err();
        let report = ErrorReport::of(&error);
        assert_eq!((report.exit_code, report.reason.as_deref()), (1, Some("NO_SUCH_TWIN")));
        assert_eq!(report.message, "twins/1: there is no such twin");
    }
}
