//! Errors of the HTTP side: RFC 9457 problem documents.

use bendtwin_core::Category;
use bendtwin_proto::fault::category_named;
use hyper::StatusCode;
use serde::Deserialize;

use super::http::Response;
use crate::Error;

/// The members of a problem document that are used here.
#[derive(Deserialize)]
struct Document {
    title: String,
    detail: String,
    reason: String,
    #[serde(default)]
    request_id: String,
}

/// The response if it is a success, else the server's error.
pub(crate) async fn success(response: Response) -> Result<Response, Error> {
    let status = response.status;
    if status.is_success() {
        return Ok(response);
    }
    let body = response.bytes().await.unwrap_or_default();
    Err(of(status, &body))
}

fn of(status: StatusCode, body: &[u8]) -> Error {
    match serde_json::from_slice::<Document>(body) {
        Ok(document) => {
            let category = category_named(&document.title).unwrap_or(Category::Internal);
            Error::new(category, &document.reason, document.detail)
                .with_request_id(Some(document.request_id))
        }
        // A proxy's page, for example, or a response to HEAD, which has no body.
        Err(_) => {
            let category = match status.as_u16() {
                502..=504 => Category::Unavailable,
                404 | 410 => Category::NotFound,
                409 | 423 => Category::Aborted,
                429 => Category::ResourceExhausted,
                400..=499 => Category::InvalidArgument,
                _ => Category::Internal,
            };
            Error::new(category, "HTTP_ERROR", format!("the server answered HTTP {status}"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_problem_document_keeps_everything() {
        let body =
            br#"{"type":"urn:bendtwin:error:NO_SUCH_CAPTURE","title":"NOT_FOUND","status":404,
            "detail":"there is no captures/1","reason":"NO_SUCH_CAPTURE","request_id":"abc"}"#;
        let error = of(StatusCode::NOT_FOUND, body);
        assert_eq!(error.category(), Category::NotFound);
        assert_eq!(error.reason(), "NO_SUCH_CAPTURE");
        assert_eq!(error.message(), "there is no captures/1");
        assert_eq!(error.request_id(), Some("abc"));
    }

    #[test]
    fn a_proxy_page_still_says_something() {
        let error = of(StatusCode::BAD_GATEWAY, b"<html>");
        assert!(error.is_transient() && error.message().contains("502"));
    }
}
