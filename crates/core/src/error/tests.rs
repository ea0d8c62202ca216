use std::io;

use super::*;

#[derive(Debug, thiserror::Error, Problem)]
#[problem(Internal, "BROKEN")]
enum Cause {
    #[error("it broke")]
    Broken,
    #[error("wait for it")]
    #[problem(Unavailable, "NOT_YET", retry = Duration::from_secs(3))]
    NotYet,
}

#[derive(Debug, thiserror::Error, Problem)]
enum Error {
    #[error("{path}: {source}")]
    #[problem(NotFound, "FILE_MISSING", if source.kind() == io::ErrorKind::NotFound)]
    #[problem(Internal, "FILE_FAILED", retry = path.is_empty().then_some(Duration::ZERO))]
    File { path: String, source: io::Error },
    #[error(transparent)]
    Cause(#[from] Cause),
    #[error("recording {name}: {error}")]
    #[problem(transparent)]
    Recording { name: String, error: Box<Cause> },
    #[error("another process says: {0}")]
    #[problem(_0.category, "FOREIGN", fault = _0.clone())]
    Foreign(Fault),
    #[error("{0} of {1}")]
    #[problem(Aborted, "PAIR", if *_1 == 2)]
    #[problem(Cancelled, "PAIR")]
    Pair(u8, u8),
}

#[derive(Debug, thiserror::Error, Problem)]
#[error("nothing")]
#[problem(DataLoss, "NOTHING")]
struct Nothing;

#[derive(Debug, thiserror::Error, Problem)]
#[error(transparent)]
struct Wrapped<P: Problem + 'static>(P);

/// Category, reason and delay [s].
fn facts(error: &impl Problem) -> (Category, &'static str, Option<u64>) {
    let Facts { category, reason, retry_after } = error.facts();
    (category, reason, retry_after.map(|delay| delay.as_secs()))
}

#[test]
fn a_variant_has_what_stands_beside_it_or_beside_its_type() {
    assert_eq!(facts(&Cause::Broken), (Category::Internal, "BROKEN", None));
    assert_eq!(facts(&Cause::NotYet), (Category::Unavailable, "NOT_YET", Some(3)));
    assert_eq!(facts(&Nothing), (Category::DataLoss, "NOTHING", None));
}

#[test]
fn conditions_choose_in_their_order() {
    let file = |kind, path: &str| Error::File { path: path.into(), source: io::Error::from(kind) };
    let missing = file(io::ErrorKind::NotFound, "");
    assert_eq!(facts(&missing), (Category::NotFound, "FILE_MISSING", None));
    let failed = |path| file(io::ErrorKind::Other, path);
    assert_eq!(facts(&failed("a")), (Category::Internal, "FILE_FAILED", None));
    assert_eq!(facts(&failed("")), (Category::Internal, "FILE_FAILED", Some(0)));
    assert_eq!(Error::Pair(1, 2).category(), Category::Aborted);
    assert_eq!(Error::Pair(2, 1).category(), Category::Cancelled);
}

#[test]
fn a_transparent_error_has_the_facts_of_its_cause() {
    let wait = (Category::Unavailable, "NOT_YET", Some(3));
    assert_eq!(facts(&Error::from(Cause::NotYet)), wait);
    let recording = Error::Recording { name: "a".into(), error: Box::new(Cause::NotYet) };
    assert_eq!(facts(&recording), wait);
    assert_eq!(recording.fault().message, "recording a: wait for it");
    assert_eq!(facts(&Wrapped(Cause::NotYet)), wait);
}

#[test]
fn a_fault_of_another_process_is_passed_on() {
    let fault = Fault {
        category: Category::Aborted,
        reason: "LEASE_LOST".into(),
        message: "the lease is lost".into(),
    };
    let foreign = Error::Foreign(fault.clone());
    assert_eq!(facts(&foreign), (Category::Aborted, "FOREIGN", None));
    assert_eq!(foreign.fault(), fault);
    let of = Fault::of(&foreign);
    assert_eq!(of.message, "another process says: the lease is lost");
    assert_eq!(of.reason, "FOREIGN");
}
