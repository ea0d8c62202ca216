//! The JSON of captures, fits, twins, keys, workers and evaluations, compared with samples that were
//! recorded before HTTP came from the contract: names, nulls, nested documents, times, statuses and
//! refusals. Ids become numbers in the order in which they appear.
//!
//! ```sh
//! BENDTWIN_BLESS=1 cargo test -p bendtwin-server --test it samples
//! ```

use std::time::Duration;

use bendtwin_proto::{
    v1::{Fault, ModelLoss},
    worker::v1::{FailJobRequest, fail_job_request::End, lease_job_request::Kind},
};
use jiff::Timestamp;
use reqwest::Method;
use serde_json::{Value, json};

use crate::{
    harness::{Server, read},
    twins::twin_file,
    worker::Worker,
};

const SOON: Duration = Duration::from_secs(10);
const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/samples.jsonl");

/// Answers in the order of the calls, one JSON document a line.
struct Samples<'s> {
    server: &'s Server,
    lines: Vec<String>,
    ids: Vec<String>,
}

impl Samples<'_> {
    async fn get(&mut self, path: &str) -> Value {
        self.call(Method::GET, path, None).await
    }

    async fn post(&mut self, path: &str, body: Value) -> Value {
        self.call(Method::POST, path, Some(body)).await
    }

    /// Makes a call and notes its answer.
    async fn call(&mut self, method: Method, path: &str, body: Option<Value>) -> Value {
        let mut request = self.server.http.request(method.clone(), self.server.url(path));
        if let Some(body) = &body {
            request = request.json(body);
        }
        self.note(&format!("{method} {path}"), request).await
    }

    async fn note(&mut self, call: &str, request: reqwest::RequestBuilder) -> Value {
        let response = request.send().await.unwrap();
        let header = |name: &str| {
            response.headers().get(name).map_or(Value::Null, |v| v.to_str().unwrap().into())
        };
        let headers = ["content-type", "location", "cache-control"].map(header);
        let (status, mut body) = read(response).await;
        if headers[0] == "text/event-stream" {
            let lines = body.as_str().unwrap().lines();
            let data = lines.filter_map(|line| line.strip_prefix("data: "));
            body = data.map(|data| serde_json::from_str::<Value>(data).unwrap()).collect();
        }
        let mut line = json!({"call": call, "status": status, "headers": headers, "body": body});
        self.neutral(&mut line);
        self.lines.push(line.to_string());
        body
    }

    /// Replaces what differs from run to run.
    fn neutral(&mut self, value: &mut Value) {
        match value {
            Value::String(text) => *text = self.neutral_text(text),
            Value::Array(entries) => entries.iter_mut().for_each(|entry| self.neutral(entry)),
            Value::Object(fields) => {
                for (name, value) in fields {
                    match name.as_str() {
                        "secret_key" | "request_id" | "next_page_token" => {
                            let is_given = value.as_str().is_some_and(|text| !text.is_empty());
                            *value = format!("given: {is_given}").into();
                        }
                        "run_s" => *value = format!("a number: {}", value.is_f64()).into(),
                        _ => self.neutral(value),
                    }
                }
            }
            _ => {}
        }
    }

    fn neutral_text(&mut self, text: &str) -> String {
        if text.len() > 18
            && text.ends_with('Z')
            && let Ok(time) = text.parse::<Timestamp>()
        {
            assert_eq!(time.to_string(), text, "times are written in one way");
            return "a time".to_owned();
        }
        let mut neutral = String::new();
        let mut rest = text;
        while !rest.is_empty() {
            match rest.get(..36).filter(|head| uuid::Uuid::try_parse(head).is_ok()) {
                Some(id) => {
                    let known = self.ids.iter().position(|other| other == id);
                    let number = known.unwrap_or_else(|| {
                        self.ids.push(id.to_owned());
                        self.ids.len() - 1
                    });
                    neutral.push_str(&format!("{{{number}}}"));
                    rest = &rest[36..];
                }
                None => {
                    let next = rest.chars().next().unwrap();
                    neutral.push(next);
                    rest = &rest[next.len_utf8()..];
                }
            }
        }
        neutral
    }
}

fn name(resource: &Value) -> String {
    resource["name"].as_str().unwrap().to_owned()
}

#[tokio::test]
async fn the_json_of_every_resource_is_what_it_was() {
    let server = Server::start().await;
    let mut samples = Samples { server: &server, lines: Vec::new(), ids: Vec::new() };
    captures_and_fits(&server, &mut samples).await;
    twins(&server, &mut samples).await;
    keys(&mut samples).await;
    refusals(&server, &mut samples).await;
    let made = samples.lines.join("\n") + "\n";
    if std::env::var_os("BENDTWIN_BLESS").is_some() {
        std::fs::write(FILE, &made).unwrap();
    }
    let kept = std::fs::read_to_string(FILE).unwrap();
    for (made, kept) in made.lines().zip(kept.lines()) {
        assert_eq!(made, kept);
    }
    assert_eq!(made.lines().count(), kept.lines().count());
}

async fn captures_and_fits(server: &Server, samples: &mut Samples<'_>) {
    for list in ["captures", "fits", "twins", "workers", "keys", "uploads"] {
        samples.get(&format!("/v1/{list}")).await;
    }
    let upload = server.http.post(server.url("/v1/captures?display_name=a%20rope"));
    let upload = upload.header("content-type", "application/zip").body("an archive");
    let capture = name(&samples.note("POST /v1/captures", upload).await);
    let mut worker = Worker::register_labelled(server, &["big", "lab=2"]).await;
    let worker_name = worker.id.to_string();
    samples.get(&format!("/v1/{worker_name}")).await;
    worker.heartbeat().await.unwrap();

    let settings = json!({"search": {"generations": 3}});
    let requirements = json!({"backend": "cpu", "memory_bytes": 1024, "labels": ["big"]});
    let order = json!({
        "capture": capture, "settings": settings, "priority": 2, "display_name": "a fit",
        "requirements": requirements,
    });
    let fit = name(&samples.post("/v1/fits", order).await);
    let plain = name(&samples.post("/v1/fits", json!({"capture": capture})).await);

    let lease = worker.lease_a(Kind::Ingest, SOON).await.unwrap();
    worker.report(&lease, 0.5).await.unwrap();
    samples.get(&format!("/v1/{capture}")).await;
    samples.get("/v1/workers").await;
    worker.observe(&lease).await.unwrap();
    samples.get(&format!("/v1/{capture}")).await;
    samples.get(&format!("/v1/{capture}/report")).await;

    let lease = worker.lease(SOON).await.unwrap();
    worker.report(&lease, 0.25).await.unwrap();
    let loss = |iteration, loss| ModelLoss {
        stage: "search".into(),
        variant: "bending".into(),
        iteration,
        loss,
        best_loss: Some(0.5),
        error_m: Some(0.008),
    };
    worker.report_losses(&lease, vec![loss(1, Some(0.5)), loss(2, None)]).await.unwrap();
    samples.get(&format!("/v1/{fit}")).await;
    samples.get(&format!("/v1/{worker_name}")).await;
    samples.get(&format!("/v1/{fit}/losses")).await;
    samples.get(&format!("/v1/{fit}/preview")).await;
    worker.complete(&lease, b"a twin").await.unwrap();
    samples.get(&format!("/v1/{fit}")).await;
    let events = server.http.get(server.url(&format!("/v1/{fit}/events")));
    samples.note("GET the events of a fit", events).await;

    samples.post(&format!("/v1/{plain}/cancel"), json!({})).await;
    samples.call(Method::POST, &format!("/v1/{plain}/cancel"), None).await;
    samples.call(Method::DELETE, &format!("/v1/{plain}"), None).await;
    for thing in [&capture, &fit] {
        let change = json!({"note": "left hand", "add_tags": ["wet", "a"], "display_name": "b"});
        samples.call(Method::PATCH, &format!("/v1/{thing}"), Some(change)).await;
        let change = json!({"display_name": null, "remove_tags": ["wet"], "note": ""});
        samples.call(Method::PATCH, &format!("/v1/{thing}"), Some(change)).await;
        samples.call(Method::PATCH, &format!("/v1/{thing}"), Some(json!({}))).await;
    }
    for query in ["page_size=1&order_by=name desc", "state=SUCCEEDED&search=b&tag=a", "state="] {
        samples.get(&format!("/v1/fits?{query}")).await;
    }
    samples.get("/v1/captures?page_size=5&tag=a&owner=&search=").await;

    let again = json!({"settings": {"spacing_m": 0.004}, "requirements": requirements});
    samples.post(&format!("/v1/{capture}/ingest"), again).await;
    let lease = worker.lease_a(Kind::Ingest, SOON).await.unwrap();
    let fault = Fault {
        category: "INVALID_ARGUMENT".into(),
        reason: "NO_CONTROLS".into(),
        message: "the capture has no control points".into(),
    };
    let retried = FailJobRequest { fault: Some(fault.clone()), ..worker.failure(&lease) };
    worker.link.fail_job(retried).await.unwrap();
    samples.get(&format!("/v1/{capture}")).await;
    let lease = worker.lease_a(Kind::Ingest, SOON).await.unwrap();
    let end = End::Failed.into();
    let failed = FailJobRequest { fault: Some(fault), end, ..worker.failure(&lease) };
    worker.link.fail_job(failed).await.unwrap();
    samples.get(&format!("/v1/{capture}")).await;
    samples.post(&format!("/v1/{capture}/ingest"), json!({})).await;
    samples.call(Method::POST, &format!("/v1/{capture}/ingest/cancel"), None).await;
    let events = server.http.get(server.url(&format!("/v1/{capture}/events")));
    samples.note("GET the events of a capture", events).await;
    let supplement = format!("/v1/{capture}/supplements/calibration");
    let document = json!({"format": "bendtwin-calibration", "version": 1, "cameras": []});
    samples.call(Method::PUT, &supplement, Some(document)).await;
    samples.get(&supplement).await;
    samples.get(&format!("/v1/{capture}")).await;
    samples.call(Method::DELETE, &supplement, None).await;
    samples.get(&supplement).await;
    samples.get(&format!("/v1/{capture}/masks")).await;
    samples.call(Method::POST, &format!("/v1/{worker_name}/drain"), None).await;
}

async fn twins(server: &Server, samples: &mut Samples<'_>) {
    let mut worker = Worker::register(server).await;
    let upload = server.http.post(server.url("/v1/twins?display_name=toy")).body(twin_file());
    let twin = name(&samples.note("POST /v1/twins", upload).await);
    samples.get(&format!("/v1/{twin}")).await;
    samples.get("/v1/twins?order_by=name&page_size=10").await;
    samples.get(&format!("/v1/{twin}/geometry")).await;
    samples.get(&format!("/v1/{twin}/geometry?tensors=base64")).await;
    let change = json!({"display_name": "other", "tags": ["x"]});
    samples.call(Method::PATCH, &format!("/v1/{twin}"), Some(change)).await;

    let fitted = crate::simulation::rollouts::twin(server, &mut worker).await;
    let (_, shown) = server.get(&format!("/v1/{fitted}")).await;
    samples.get(&format!("/v1/{fitted}")).await;
    let path = format!("/v1/{fitted}/evaluations");
    let capture = &shown["capture"];
    samples.post(&path, json!({"capture": capture})).await;
    samples.post(&path, json!({"capture": capture, "motion": {"sequence": 2}})).await;
    let path = format!("{path}?tensors=base64&timeout_s=20");
    samples.post(&path, json!({"capture": capture, "motion": {}})).await;
    samples.call(Method::DELETE, &format!("/v1/{twin}"), None).await;
}

async fn keys(samples: &mut Samples<'_>) {
    let order = json!({
        "display_name": "a robot", "owner": "ada", "scopes": ["twins:read", "fits:read"],
        "expire_time": "2130-01-31T12:00:00Z", "quotas": {"queued_jobs": 3, "rollouts": null},
    });
    let made = samples.post("/v1/keys", order).await;
    let key = name(&made["key"]);
    samples.post("/v1/keys", json!({"display_name": "b", "scopes": ["admin"]})).await;
    samples.get(&format!("/v1/{key}")).await;
    samples.call(Method::DELETE, &format!("/v1/{key}"), None).await;
    samples.get(&format!("/v1/{key}")).await;
    samples.get("/v1/keys?page_size=1").await;
}

async fn refusals(server: &Server, samples: &mut Samples<'_>) {
    const NOBODY: &str = "0190a000-0000-7000-8000-00000000dead";
    for list in ["captures", "fits", "twins", "workers", "keys"] {
        samples.get(&format!("/v1/{list}/{NOBODY}")).await;
        samples.get(&format!("/v1/{list}/x")).await;
        samples.call(Method::PUT, &format!("/v1/{list}/{NOBODY}"), None).await;
        samples.get(&format!("/v1/{list}?page_size=x")).await;
        samples.get(&format!("/v1/{list}?colour=red")).await;
        samples.get(&format!("/v1/{list}?page_token=x")).await;
    }
    for call in ["captures/x/ingest", "fits", "keys", "twins/x/evaluations"] {
        let path = format!("/v1/{call}");
        for body in [json!({}), json!({"colour": "red"}), json!([])] {
            samples.post(&path, body).await;
        }
        let text = server.http.post(server.url(&path)).header("content-type", "text/plain");
        samples.note(&format!("POST {path} of text"), text.body("{}")).await;
        samples.call(Method::POST, &path, None).await;
    }
    let order = json!({"display_name": "a", "scopes": ["admin"], "expire_time": "soon"});
    samples.post("/v1/keys", order).await;
    let order = json!({"capture": "captures/x", "settings": {"x": 1}, "priority": 2.5});
    samples.post("/v1/fits", order).await;
    samples.get("/v1/fits?state=ENDED").await;
    samples.get("/v1/fits?order_by=size").await;
    let twin = format!("/v1/twins/{NOBODY}");
    samples.call(Method::PATCH, &twin, Some(json!({"size_bytes": 1}))).await;
    samples.call(Method::PATCH, &twin, Some(json!({"tags": [], "add_tags": ["a"]}))).await;
    samples.get(&format!("{twin}?colour=red")).await;
}
