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

/// Clients of gRPC refuse more than 8 KiB of metadata, with another error than the one that was sent.
#[test]
fn long_messages_are_cut_for_grpc() {
    let context = Context { request_id: "r-1".into(), ..Context::default() };
    let faults: Vec<String> =
        (0..100).map(|n| format!("settings.{n}: „unbekannt“ ist keine Einstellung")).collect();
    for text in [faults.join("; "), faults.join("\n"), "ü".repeat(20_000)] {
        let fault = Fault {
            category: Category::InvalidArgument,
            reason: "WORD".into(),
            message: text.clone(),
        };
        let refusal = Refusal::new(fault);
        let document = refusal.document(&context).detail;
        assert!(document.len() <= 16 << 10 && document.len() > 4000, "{}", document.len());
        let status = refusal.into_status(&context);
        let mut sent = axum::http::HeaderMap::new();
        status.add_header(&mut sent).unwrap();
        let size: usize = sent.iter().map(|(name, value)| name.as_str().len() + value.len()).sum();
        assert!(size < 7000, "{size} bytes of metadata");
        let said = status.message();
        assert!(said.ends_with(" more") || said.ends_with(" characters more)"), "{said}");
        if let Some(more) = said.strip_suffix(" more").and_then(|s| s.rsplit(' ').next()) {
            let kept = said.matches("settings.").count();
            assert_eq!(kept + more.parse::<usize>().unwrap(), faults.len(), "{said}");
        }
    }
    let short = Fault { category: Category::NotFound, reason: "WORD".into(), message: "ü".into() };
    assert_eq!(Refusal::new(short).into_status(&context).message(), "ü");
}
