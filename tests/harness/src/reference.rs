//! A small capture, and its twin by an undisturbed fit, made once for all tests.

use std::time::{Duration, Instant};

use bytes::Bytes;
use tokio::sync::OnceCell;

use crate::{Isolation, Setup, TestCluster, command::run_ok};

/// Longest time for a small fit, even if it is disturbed often.
pub const FIT: Duration = Duration::from_secs(300);

/// A fit of seconds, with all stages and enough steps for disturbances.
pub const SETTINGS: &str = r#"{
    "seed": 11,
    "graph": {"max_nodes": 40},
    "search": {"starts": 1, "generations": 12, "population": 8},
    "refine": {"passes": 24}
}"#;

/// A fit that never ends by itself within a test.
pub const ENDLESS: &str = r#"{
    "graph": {"max_nodes": 40},
    "search": {"starts": 1, "generations": 10000, "population": 8}
}"#;

/// Result of an undisturbed fit of the capture.
#[derive(Clone, Debug)]
pub struct Reference {
    /// BLAKE3 of the twin file.
    pub digest: String,
    /// The twin file.
    pub file: Bytes,
}

/// The archive of a small capture: a rope of a few dozen points.
pub async fn capture() -> Bytes {
    static CAPTURE: OnceCell<Bytes> = OnceCell::const_new();
    let make = async || {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rope.zip");
        tokio::task::spawn_blocking(move || {
            run_ok(&["capture", "make", "rope", path.to_str().unwrap()]);
            Bytes::from(std::fs::read(&path).unwrap())
        })
        .await
        .unwrap()
    };
    CAPTURE.get_or_init(make).await.clone()
}

/// The twin of [`capture`] under [`SETTINGS`].
pub async fn reference() -> Reference {
    static REFERENCE: OnceCell<Reference> = OnceCell::const_new();
    REFERENCE.get_or_init(|| undisturbed(SETTINGS)).await.clone()
}

/// Fits [`capture`] without disturbances.
pub async fn undisturbed(settings: &str) -> Reference {
    // The caller may hold a slot already.
    let server =
        TestCluster::start(Setup { isolation: Isolation::Nested, ..Setup::default() }).await;
    let api = server.api();
    let capture = api.upload(&capture().await, "").await.unwrap();
    let started = Instant::now();
    let fit = api.fit(&capture.name, settings, 0).await.unwrap();
    let fit = api.succeeded(&fit.name, FIT).await;
    println!("an undisturbed fit took {:.1} s", started.elapsed().as_secs_f64());
    let twin = api.get_twin(&fit.twin).await.unwrap();
    Reference { digest: twin.digest, file: api.export(&twin.name).await.unwrap() }
}
