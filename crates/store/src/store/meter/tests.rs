use std::sync::Mutex;

use super::*;

/// A receiver that keeps all of it.
#[derive(Debug, Default)]
struct Kept(Mutex<Vec<Call>>);

impl Observer for Kept {
    fn called(&self, call: Call) {
        self.0.lock().unwrap().push(call);
    }
}

#[tokio::test]
async fn faults_of_the_part_are_told_from_refused_requests() {
    let kept = Arc::new(Kept::default());
    let meter = Meter::new(Part::Content, Some(kept.clone()));
    assert!(!meter.answered_within(Duration::from_secs(3600)), "nothing was asked yet");
    let missing = object_store::Error::NotFound { path: "x".to_owned(), source: "none".into() };
    let results = [
        (Ok(()), false),
        (Err(Error::ObjectsUnavailable), true),
        (Err(Error::DatabaseUnavailable), true),
        (Err(Error::DiskFull), true),
        (Err(Error::Database(sqlx::Error::RowNotFound)), false),
        (Err(Error::Objects(missing)), false),
        (Err(Error::NotFound { name: "captures/x".to_owned() }), false),
    ];
    let failed: Vec<bool> = results.iter().map(|(_, failed)| *failed).collect();
    for (result, _) in results {
        meter.measure("read", async { result }).await.ok();
    }
    let calls = kept.0.lock().unwrap();
    assert_eq!(calls.iter().map(|call| call.failed).collect::<Vec<_>>(), failed);
    assert!(calls.iter().all(|call| call.part == Part::Content && call.operation == "read"));
    assert!(meter.answered_within(Duration::from_secs(3600)));
}

/// What a store does reaches its observer by a few words.
#[tokio::test]
async fn a_store_is_observed() {
    let folder = tempfile::tempdir().unwrap();
    let kept = Arc::new(Kept::default());
    let options = crate::Options {
        observer: Some(kept.clone()),
        ..crate::Options::new(folder.path().join("data"))
    };
    let store = crate::Store::open(options).await.unwrap();
    store.probe_write().await.unwrap();
    store.ping().await.unwrap();
    let mut words: Vec<(&str, &str)> = {
        let calls = kept.0.lock().unwrap();
        assert!(calls.iter().all(|call| !call.failed), "{calls:?}");
        calls.iter().map(|call| (call.part.as_str(), call.operation)).collect()
    };
    words.sort_unstable();
    words.dedup();
    for word in [
        ("content", "list"),
        ("content", "write"),
        ("database", "begin"),
        ("database", "commit"),
        ("database", "read"),
        ("database", "write"),
    ] {
        assert!(words.contains(&word), "{word:?} is not in {words:?}");
    }
    store.close().await;
}
