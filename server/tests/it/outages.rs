//! What is answered while the database is away, whether it refuses connections or hangs.

use std::time::{Duration, Instant};

use bendtwin_harness::Postgres;
use bendtwin_server::{ClientTokenPolicy, DatabaseUrl};
use futures::future::join_all;
use serde_json::{Value, json};

use crate::{
    access::keys::{locked, make},
    harness::{Server, read},
    simulation::rollouts::{request, twin},
    worker::Worker,
};

/// Longest time in which a call is answered during an outage.
const SOON: Duration = Duration::from_secs(6);
/// Longest time in which one is answered that does without the database.
const AT_HAND: Duration = Duration::from_secs(3);
const BACK: Duration = Duration::from_secs(60);

#[tokio::test]
async fn calls_are_answered_soon_while_the_database_refuses_connections() {
    let Some(bench) = Bench::start_or_skip().await else { return };
    // A crash of this PostgreSQL, which commits asynchronously, loses what it did in the last moment.
    bench.postgres.query("checkpoint").await;
    bench.postgres.kill().await;
    bench.check_outage().await;
    bench.postgres.start().await;
    bench.check_return().await;
}

#[tokio::test]
async fn calls_are_answered_soon_while_the_database_hangs() {
    let Some(bench) = Bench::start_or_skip().await else { return };
    bench.postgres.stall().await;
    bench.check_outage().await;
    bench.postgres.resume().await;
    bench.check_return().await;
}

/// A server over PostgreSQL, with a worker that has a twin loaded.
struct Bench {
    server: Server,
    postgres: Postgres,
    twin: String,
    /// A key that the server has seen, and one that it does not know.
    known: String,
    unknown: String,
    _worker: Worker,
}

impl Bench {
    async fn start_or_skip() -> Option<Self> {
        let postgres = Postgres::start_or_skip().await?;
        let url = DatabaseUrl::parse(&postgres.url_with_password("none")).unwrap();
        let mut server = Server::start_with(|o| {
            o.client_token = ClientTokenPolicy::Required;
            o.database_url = Some(url);
            // The fake worker sends no heartbeats.
            o.heartbeat_interval_s = 60.0;
            o.lease_s = 600.0;
        })
        .await;
        let token = server.handle.client_token().unwrap().to_owned();
        let bearer = format!("Bearer {token}").parse().unwrap();
        let headers = [(reqwest::header::AUTHORIZATION, bearer)].into_iter().collect();
        server.http = reqwest::Client::builder().default_headers(headers).build().unwrap();
        let mut worker = Worker::register(&server).await;
        let twin = twin(&server, &mut worker).await;
        let order = json!({"display_name": "robot", "scopes": ["captures:read", "rollouts:run"]});
        let (_, known) = make(&server, order.clone()).await;
        let (_, unknown) = make(&locked().await, order).await;
        let bench = Self { server, postgres, twin, known, unknown, _worker: worker };
        bench.roll_out().await.unwrap();
        assert!(bench.metrics().await.0.contains("bendtwin_store_up 1"));
        assert_eq!(bench.captures(&bench.known).await.0, 200);
        Some(bench)
    }

    /// Status, body and time of a call that needs the database.
    async fn captures(&self, key: &str) -> (u16, Value, Duration) {
        let started = Instant::now();
        let call = reqwest::Client::new().get(self.server.url("/v1/captures")).bearer_auth(key);
        let answer = call.send().await.unwrap();
        let waits = answer.headers().contains_key("retry-after");
        let (status, body) = read(answer).await;
        assert_eq!(waits, status == 503, "{body}");
        (status, body, started.elapsed())
    }

    async fn roll_out(&self) -> Result<(), tonic::Status> {
        let mut request = tonic::Request::new(request(&self.twin, 1));
        let key = format!("Bearer {}", self.known).parse().unwrap();
        request.metadata_mut().insert("authorization", key);
        self.server.rollouts().roll_out(request).await.map(drop)
    }

    async fn metrics(&self) -> (String, Duration) {
        let started = Instant::now();
        let call = reqwest::Client::new().get(self.server.url("/metrics")).bearer_auth(&self.known);
        let answer = call.send().await.unwrap();
        assert_eq!(answer.status(), 200);
        (answer.text().await.unwrap(), started.elapsed())
    }

    async fn check_outage(&self) {
        // What was read a moment ago counts for a second.
        while self.captures(&self.unknown).await.0 == 401 {}
        let noticed = async { while !self.metrics().await.0.contains("bendtwin_store_up 0") {} };
        tokio::time::timeout(SOON, noticed).await.unwrap();
        for round in 0..3 {
            for key in [&self.known, &self.unknown] {
                for (status, body, took) in join_all((0..12).map(|_| self.captures(key))).await {
                    let reason = (status, body["reason"].as_str());
                    assert_eq!(reason, (503, Some("DATABASE_UNAVAILABLE")), "{body}");
                    assert!(took < SOON, "round {round}: {took:?}");
                }
            }
            let started = Instant::now();
            self.roll_out().await.unwrap();
            assert!(started.elapsed() < AT_HAND, "round {round}: {:?}", started.elapsed());
            let (text, took) = self.metrics().await;
            assert!(took < AT_HAND, "round {round}: {took:?}");
            for line in [
                "bendtwin_store_up 0",
                "bendtwin_store_age_seconds ",
                r#"bendtwin_fits{state="succeeded"} 1"#,
                r#"bendtwin_store_errors_total{store="database",operation="read"}"#,
            ] {
                assert!(text.contains(line), "{line} is not in\n{text}");
            }
        }
    }

    async fn check_return(&self) {
        let back = async {
            while self.captures(&self.known).await.0 != 200 {}
            while self.captures(&self.unknown).await.0 != 401 {}
            while !self.metrics().await.0.contains("bendtwin_store_up 1") {}
        };
        tokio::time::timeout(BACK, back).await.unwrap();
    }
}
