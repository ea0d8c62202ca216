//! Faults on the wire: a [`Fault`] as a message, and as a gRPC status whose
//! `ErrorInfo` detail carries the reason. Both ends of a call use this table.

use std::borrow::Cow;

use bendtwin_core::{Category, Fault};
use tonic::{Code, Status};
use tonic_types::{ErrorDetails, StatusExt as _};

use crate::v1;

/// `domain` of every `ErrorInfo`.
pub const ERROR_DOMAIN: &str = "bendtwin";

/// The gRPC code of a category.
pub fn code(category: Category) -> Code {
    match category {
        Category::InvalidArgument => Code::InvalidArgument,
        Category::NotFound => Code::NotFound,
        Category::AlreadyExists => Code::AlreadyExists,
        Category::FailedPrecondition => Code::FailedPrecondition,
        Category::Unauthenticated => Code::Unauthenticated,
        Category::PermissionDenied => Code::PermissionDenied,
        Category::ResourceExhausted => Code::ResourceExhausted,
        Category::Aborted => Code::Aborted,
        Category::DeadlineExceeded => Code::DeadlineExceeded,
        Category::Cancelled => Code::Cancelled,
        Category::Unavailable => Code::Unavailable,
        Category::DataLoss => Code::DataLoss,
        Category::Internal => Code::Internal,
    }
}

/// The category of a gRPC code; codes that this project does not send count as internal.
pub fn category(code: Code) -> Category {
    match code {
        Code::InvalidArgument | Code::OutOfRange => Category::InvalidArgument,
        Code::NotFound => Category::NotFound,
        Code::AlreadyExists => Category::AlreadyExists,
        Code::FailedPrecondition => Category::FailedPrecondition,
        Code::Unauthenticated => Category::Unauthenticated,
        Code::PermissionDenied => Category::PermissionDenied,
        Code::ResourceExhausted => Category::ResourceExhausted,
        Code::Aborted => Category::Aborted,
        Code::DeadlineExceeded => Category::DeadlineExceeded,
        Code::Cancelled => Category::Cancelled,
        Code::Unavailable => Category::Unavailable,
        Code::DataLoss => Category::DataLoss,
        Code::Ok | Code::Unknown | Code::Unimplemented | Code::Internal => Category::Internal,
    }
}

/// The category's name in messages and in problem documents.
pub fn category_name(category: Category) -> &'static str {
    match category {
        Category::InvalidArgument => "INVALID_ARGUMENT",
        Category::NotFound => "NOT_FOUND",
        Category::AlreadyExists => "ALREADY_EXISTS",
        Category::FailedPrecondition => "FAILED_PRECONDITION",
        Category::Unauthenticated => "UNAUTHENTICATED",
        Category::PermissionDenied => "PERMISSION_DENIED",
        Category::ResourceExhausted => "RESOURCE_EXHAUSTED",
        Category::Aborted => "ABORTED",
        Category::DeadlineExceeded => "DEADLINE_EXCEEDED",
        Category::Cancelled => "CANCELLED",
        Category::Unavailable => "UNAVAILABLE",
        Category::DataLoss => "DATA_LOSS",
        Category::Internal => "INTERNAL",
    }
}

/// The category of that name, if it is one.
pub fn category_named(name: &str) -> Option<Category> {
    Some(match name {
        "INVALID_ARGUMENT" => Category::InvalidArgument,
        "NOT_FOUND" => Category::NotFound,
        "ALREADY_EXISTS" => Category::AlreadyExists,
        "FAILED_PRECONDITION" => Category::FailedPrecondition,
        "UNAUTHENTICATED" => Category::Unauthenticated,
        "PERMISSION_DENIED" => Category::PermissionDenied,
        "RESOURCE_EXHAUSTED" => Category::ResourceExhausted,
        "ABORTED" => Category::Aborted,
        "DEADLINE_EXCEEDED" => Category::DeadlineExceeded,
        "CANCELLED" => Category::Cancelled,
        "UNAVAILABLE" => Category::Unavailable,
        "DATA_LOSS" => Category::DataLoss,
        "INTERNAL" => Category::Internal,
        _ => return None,
    })
}

impl From<&Fault> for v1::Fault {
    fn from(fault: &Fault) -> Self {
        Self {
            category: category_name(fault.category).to_owned(),
            reason: fault.reason.clone(),
            message: fault.message.clone(),
        }
    }
}

/// A category that this build does not know counts as internal.
impl From<&v1::Fault> for Fault {
    fn from(fault: &v1::Fault) -> Self {
        Self {
            category: category_named(&fault.category).unwrap_or(Category::Internal),
            reason: fault.reason.clone(),
            message: fault.message.clone(),
        }
    }
}

/// Longest message of a status [bytes]. It is sent twice, once with three bytes for each that is not
/// ASCII and once in base64, and clients refuse more than 8 KiB of metadata.
const MOST_MESSAGE: usize = 1400;
/// Signs between the entries of lists in messages.
const SEPARATORS: [&str; 3] = ["\n", "; ", ", "];

/// A status that carries the fault, with a bounded message.
pub fn status(fault: &Fault) -> Status {
    status_with(fault, ErrorDetails::with_error_info(&fault.reason, ERROR_DOMAIN, []))
}

/// [`status`] with details beside the reason.
pub fn status_with(fault: &Fault, details: ErrorDetails) -> Status {
    let message = shortened(&fault.message, MOST_MESSAGE);
    Status::with_error_details(code(fault.category), message, details)
}

/// A text of at most this many bytes. Of a list, the entries that are left out are counted.
pub fn shortened(text: &str, most: usize) -> Cow<'_, str> {
    if text.len() <= most {
        return text.into();
    }
    // Room for the remark.
    let kept = &text[..text.floor_char_boundary(most.saturating_sub(32))];
    for separator in SEPARATORS {
        // Not for the first entry of a list, or for a list in the beginning of a long sentence.
        if let Some(end) = kept.rfind(separator).filter(|end| *end > kept.len() / 2) {
            let more = text[end..].matches(separator).count();
            return format!("{}{separator}and {more} more", &kept[..end]).into();
        }
    }
    format!("{kept}… ({} characters more)", text[kept.len()..].chars().count()).into()
}

/// The fault that a status carries. A status without `ErrorInfo` did not come
/// from this project's code: its code's name serves as the reason.
pub fn fault(status: &Status) -> Fault {
    let category = category(status.code());
    let reason = status.get_details_error_info().map(|info| info.reason);
    Fault {
        category,
        reason: reason.unwrap_or_else(|| category_name(category).to_owned()),
        message: status.message().to_owned(),
    }
}

#[cfg(test)]
mod tests;
