//! Malformed requests: each is refused with a client error, and the process survives.

mod fields;
mod grpc;
mod http;
mod rollouts;

use bendtwin_proto::v1::Twin;
use bytes::Bytes;

use crate::harness::{TestCluster, reference::reference};

/// Names that are invalid, or of nothing that exists.
fn bad_names(collection: &str) -> Vec<String> {
    const NONE: &str = "0190a000-0000-7000-8000-00000000dead";
    let other = if collection == "twins" { "fits" } else { "twins" };
    let mut names = vec![
        String::new(),
        "x".to_owned(),
        collection.to_owned(),
        format!("{collection}/"),
        format!("{collection}/not-a-uuid"),
        format!("{collection}/{NONE}"),
        format!("{other}/{NONE}"),
        format!("{collection}/{NONE}/more"),
        format!(" {collection}/{NONE}"),
        format!("{collection}/{}", NONE.replace('a', "g")),
        format!("{collection}/{}", &NONE[..20]),
        "../../etc/passwd".to_owned(),
        format!("{collection}/\u{0}"),
        format!("{collection}/\u{1f4a5}\u{202e}"),
        format!("{collection}/'; drop table jobs; --"),
    ];
    names.push(format!("{collection}/{}", "a".repeat(10_000)));
    names
}

/// A cluster with a twin, for requests that are almost valid.
struct Fixture {
    server: TestCluster,
    twin: Twin,
    file: Bytes,
}

impl Fixture {
    async fn new() -> Self {
        let file = reference().await.file;
        let server = TestCluster::ordinary().await;
        let twin = server.api().import(&file).await.unwrap();
        Self { server, twin, file }
    }

    /// Fails the test unless every request was refused and the cluster is unchanged.
    async fn still_stands(mut self, requests: usize, wrong: &[String]) {
        assert!(
            wrong.is_empty(),
            "{} of {requests} not refused as they should be:\n{}",
            wrong.len(),
            wrong.join("\n")
        );
        assert!(self.server.is_alive(), "the server died");
        assert!(self.server.http().is_ready().await, "the server is not ready any more");
        let api = self.server.api();
        assert_eq!(api.list_captures().await.unwrap(), []);
        assert_eq!(api.list_fits().await.unwrap(), []);
        assert_eq!(api.list_twins().await.unwrap().len(), 1);
        let rest = crate::rollouts::rest_controls(&self.file);
        let reply = api.roll_out(crate::rollouts::request(&self.twin, &rest)).await.unwrap();
        assert!(reply.costs.is_some());
        let log = self.server.log();
        assert!(!log.contains("panicked"), "something panicked:\n{log}");
        println!("{requests} requests refused");
    }
}
