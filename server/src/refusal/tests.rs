use bendtwin_core::{Category, Fault};
use bendtwin_proto::fault::{category_named, code};
use tonic::Code;

use super::{Refusal, http_status};
use crate::context::Context;

/// google.rpc.Code's own mapping to HTTP, except for FAILED_PRECONDITION, which it maps to 400:
/// "cancel it first" is a conflict.
#[test]
fn both_transports_say_the_same() {
    for category in Category::ALL {
        let expected = match code(category) {
            Code::InvalidArgument => 400,
            Code::Unauthenticated => 401,
            Code::PermissionDenied => 403,
            Code::NotFound => 404,
            Code::Aborted | Code::AlreadyExists | Code::FailedPrecondition => 409,
            Code::ResourceExhausted => 429,
            Code::Cancelled => 499,
            Code::Unavailable => 503,
            Code::DeadlineExceeded => 504,
            Code::DataLoss | Code::Internal => 500,
            other => panic!("{category:?} became {other:?}"),
        };
        assert_eq!(http_status(category).as_u16(), expected, "{category:?}");
        let name = serde_json::to_value(category).unwrap();
        assert_eq!(category_named(name.as_str().unwrap()), Some(category));
    }
}

#[test]
fn internal_text_stays_inside() {
    let context = Context { request_id: "r-1".into(), ..Context::default() };
    for category in Category::ALL {
        let fault =
            Fault { category, reason: "WORD".into(), message: "secret /path/of/file".into() };
        let status = Refusal::new(fault).into_status(&context);
        let hidden = matches!(category, Category::Internal | Category::DataLoss);
        assert_eq!(status.message().contains("secret"), !hidden, "{category:?}");
        assert!(!hidden || status.message().contains("r-1"));
        assert_eq!(bendtwin_proto::fault::fault(&status).reason, "WORD");
    }
}
