//! No owner blocks the others: fits make way, end when they run too long or stand still, and have a
//! priority only as far as their key allows.

use std::time::{Duration, Instant};

use bendtwin_proto::worker::v1::{FailJobRequest, Lease, ReportJobResponse, fail_job_request::End};
use bendtwin_server::{ClientTokenPolicy, Options};
use serde_json::{Value, json};

use crate::{
    access::keys::make,
    harness::{Server, read},
    worker::Worker,
};

const DEADLINE: Duration = Duration::from_secs(30);

/// A server that asks for keys.
async fn locked(change: impl FnOnce(&mut Options)) -> Server {
    Server::start_with(|options| {
        options.client_token = ClientTokenPolicy::Required;
        change(options);
    })
    .await
}

async fn post(server: &Server, key: &str, path: &str, body: Value) -> (u16, Value) {
    let request = server.http.post(server.url(path)).bearer_auth(key).json(&body);
    read(request.send().await.unwrap()).await
}

async fn get(server: &Server, key: &str, path: &str) -> Value {
    read(server.http.get(server.url(path)).bearer_auth(key).send().await.unwrap()).await.1
}

/// The key of a person, with these quotas.
async fn key(server: &Server, name: &str, quotas: Value) -> String {
    let scopes = ["captures:write", "captures:read", "fits:write", "fits:read"];
    make(server, json!({"display_name": name, "scopes": scopes, "quotas": quotas})).await.1
}

/// A new capture; returns its name.
async fn capture(server: &Server, key: &str) -> String {
    let request = server.http.post(server.url("/v1/captures?display_name=rope")).bearer_auth(key);
    let request = request.header("content-type", "application/zip").body("an archive");
    let (status, capture) = read(request.send().await.unwrap()).await;
    assert_eq!(status, 201, "{capture}");
    capture["name"].as_str().unwrap().to_owned()
}

/// Reports until an answer, or a refusal, is as wanted.
async fn reported<T>(
    worker: &mut Worker,
    lease: &Lease,
    wanted: impl Fn(Result<ReportJobResponse, tonic::Status>) -> Option<T>,
) -> T {
    let began = Instant::now();
    loop {
        if let Some(found) = wanted(worker.report_answered(lease, 0.25).await) {
            return found;
        }
        assert!(began.elapsed() < DEADLINE, "no such answer");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
}

fn is_stale(answer: Result<ReportJobResponse, tonic::Status>) -> Option<()> {
    let refused = answer.err()?;
    assert_eq!(bendtwin_proto::fault::fault(&refused).reason, "STALE_LEASE");
    Some(())
}

#[tokio::test]
async fn a_fit_makes_way_for_another_owner_and_resumes() {
    let server = locked(|options| options.queue.slice_s = 0.2).await;
    let mut worker = Worker::register(&server).await;
    let (ada, bob) = (key(&server, "ada", json!({})).await, key(&server, "bob", json!({})).await);
    let capture = capture(&server, &ada).await;
    let fit = async |key: &str| {
        let (status, fit) = post(&server, key, "/v1/fits", json!({"capture": capture})).await;
        assert_eq!(status, 202, "{fit}");
        fit["name"].as_str().unwrap().to_owned()
    };
    let long = fit(&ada).await;
    fit(&ada).await;
    let lease = worker.lease(Duration::ZERO).await.unwrap();
    assert_eq!(lease.job, long);
    worker.checkpoint(&lease, b"half way").await.unwrap();
    let ran = async || get(&server, &ada, &format!("/v1/{long}")).await["job"]["run_s"].as_f64();
    let began = Instant::now();
    while ran().await.unwrap() < 0.5 {
        // Her own fits are no reason.
        let answer = worker.report_answered(&lease, 0.1).await.unwrap();
        assert_eq!(answer.make_way_within_s, None);
        assert!(began.elapsed() < DEADLINE, "its time does not pass");
    }
    let short = fit(&bob).await;
    let within = reported(&mut worker, &lease, |answer| answer.unwrap().make_way_within_s).await;
    assert!((0.0..=0.2).contains(&within), "{within}");
    let release = FailJobRequest { end: End::Released.into(), ..worker.failure(&lease) };
    worker.link.fail_job(release).await.unwrap();

    let lease = worker.lease(Duration::ZERO).await.unwrap();
    assert_eq!(lease.job, short);
    worker.complete(&lease, b"a twin").await.unwrap();
    let lease = worker.lease(Duration::ZERO).await.unwrap();
    assert_eq!((lease.job.as_str(), lease.has_checkpoint), (long.as_str(), true));
    assert_eq!(get(&server, &ada, &format!("/v1/{long}")).await["job"]["attempts"], 1);
}

#[tokio::test]
async fn a_fit_that_runs_too_long_fails_with_the_reason() {
    let server = locked(|options| options.queue.fit_run_s = 100.0).await;
    let mut worker = Worker::register(&server).await;
    let ada = key(&server, "ada", json!({"fit_run_s": 1})).await;
    let capture = capture(&server, &ada).await;
    let body = json!({"capture": capture, "settings": {"within_s": 2.0}});
    let (status, problem) = post(&server, &ada, "/v1/fits", body).await;
    assert_eq!(status, 400);
    assert!(problem["detail"].as_str().unwrap().contains("1 s"), "{problem}");
    let body = json!({"capture": capture, "settings": {"within_s": 1.0}});
    let (status, fit) = post(&server, &ada, "/v1/fits", body).await;
    assert_eq!(status, 202, "{fit}");
    let lease = worker.lease(Duration::ZERO).await.unwrap();
    reported(&mut worker, &lease, is_stale).await;
    let fit = get(&server, &ada, &format!("/v1/{}", lease.job)).await;
    assert_eq!((&fit["job"]["state"], &fit["job"]["worker"]), (&json!("FAILED"), &Value::Null));
    assert_eq!(fit["job"]["fault"]["reason"], "FIT_TOO_LONG");
    let message = fit["job"]["fault"]["message"].as_str().unwrap();
    assert!(message.contains("its key") && message.contains("within_s"), "{message}");
    assert!(fit["job"]["run_s"].as_f64().unwrap() > 1.0, "{fit}");
}

#[tokio::test]
async fn a_job_that_stands_still_is_taken_from_its_worker() {
    let server = Server::start_with(|options| options.queue.stall_s = 1.0).await;
    let fit = server.fit().await;
    let mut worker = Worker::register(&server).await;
    // The first attempt has progress.
    for attempt in 1..=4 {
        let lease = worker.lease(Duration::ZERO).await.unwrap();
        assert_eq!((lease.job.as_str(), lease.epoch), (fit.as_str(), attempt));
        reported(&mut worker, &lease, is_stale).await;
        let (_, fit) = server.get(&format!("/v1/{fit}")).await;
        let job = &fit["job"];
        let (state, fault) = match attempt {
            4 => ("FAILED", &job["fault"]),
            _ => ("QUEUED", &job["attempt_faults"][0]),
        };
        assert_eq!((&job["state"], &fault["reason"]), (&json!(state), &json!("JOB_STALLED")));
    }
}

#[tokio::test]
async fn a_key_bounds_the_priority_of_fits() {
    let server = locked(|_| ()).await;
    let mut worker = Worker::register(&server).await;
    let token = server.handle.client_token().unwrap().to_owned();
    let capture = capture(&server, &token).await;
    let fit = async |key: &str, priority: i32| {
        post(&server, key, "/v1/fits", json!({"capture": capture, "priority": priority})).await
    };
    let plain = key(&server, "plain", json!({})).await;
    let urgent = key(&server, "urgent", json!({"priority": 50})).await;
    let admin = json!({"display_name": "admin", "scopes": ["admin", "fits:write"]});
    let admin = make(&server, admin).await.1;
    for (key, most) in [(&plain, 0), (&urgent, 50), (&admin, 100), (&token, 100)] {
        for allowed in [-100, 0, most] {
            assert_eq!(fit(key, allowed).await.0, 202, "{most}");
        }
        let (status, problem) = fit(key, most + 1).await;
        if most == 100 {
            assert_eq!((status, &problem["reason"]), (400, &json!("INVALID_FIELD")));
        } else {
            assert_eq!((status, &problem["reason"]), (403, &json!("PRIORITY_TOO_HIGH")));
            assert!(problem["detail"].as_str().unwrap().contains("--max-priority"), "{problem}");
        }
    }
    // The highest is first, even if it was queued last.
    let lease = worker.lease(Duration::ZERO).await.unwrap();
    assert_eq!(get(&server, &token, &format!("/v1/{}", lease.job)).await["priority"], 100);
}

#[tokio::test]
async fn bounds_of_a_key_are_checked_and_shown() {
    let server = locked(|_| ()).await;
    let token = server.handle.client_token().unwrap().to_owned();
    let order = |scope: &str, quotas: Value| json!({"display_name": "a", "scopes": [scope], "quotas": quotas});
    for (quotas, field) in [
        (json!({"running_jobs": 0}), "quotas.running_jobs"),
        (json!({"fit_run_s": 0}), "quotas.fit_run_s"),
        (json!({"priority": 101}), "quotas.priority"),
    ] {
        let (status, problem) =
            post(&server, &token, "/v1/keys", order("fits:write", quotas)).await;
        assert_eq!(status, 400);
        assert!(problem["detail"].as_str().unwrap().contains(field), "{problem}");
    }
    for (scope, quotas, shown) in [
        ("fits:write", json!({"running_jobs": 2, "fit_run_s": 60}), json!([2, 60, 0])),
        ("fits:write", json!({"priority": 7}), json!([null, null, 7])),
        ("admin", json!({}), json!([null, null, 100])),
    ] {
        let (name, _) = make(&server, order(scope, quotas)).await;
        let quotas = get(&server, &token, &format!("/v1/{name}")).await["quotas"].clone();
        let found = json!([quotas["running_jobs"], quotas["fit_run_s"], quotas["priority"]]);
        assert_eq!(found, shown);
    }
}
