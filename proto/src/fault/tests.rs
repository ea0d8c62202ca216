use bendtwin_core::Problem;

use super::*;

const CATEGORIES: [Category; 13] = [
    Category::InvalidArgument,
    Category::NotFound,
    Category::AlreadyExists,
    Category::FailedPrecondition,
    Category::Unauthenticated,
    Category::PermissionDenied,
    Category::ResourceExhausted,
    Category::Aborted,
    Category::DeadlineExceeded,
    Category::Cancelled,
    Category::Unavailable,
    Category::DataLoss,
    Category::Internal,
];

#[test]
fn every_category_survives_both_forms() {
    for c in CATEGORIES {
        assert_eq!(category(code(c)), c);
        assert_eq!(category_named(category_name(c)), Some(c));
        let sent = Fault { category: c, reason: "SOME_REASON".into(), message: "why".into() };
        assert_eq!(fault(&status(&sent)), sent);
        assert_eq!(Fault::from(&v1::Fault::from(&sent)), sent);
    }
}

#[test]
fn a_foreign_status_still_reads() {
    let read = fault(&Status::new(Code::Unimplemented, "no such method"));
    assert_eq!((read.category, read.reason.as_str()), (Category::Internal, "INTERNAL"));
}

#[test]
fn problems_become_faults() {
    let error = bendtwin_core::twin::format::FormatError::Version(9);
    assert_eq!(status(&error.fault()).code(), Code::InvalidArgument);
}
