//! Worker processes. Shell scripts stand in for them, which wait for the end of their standard
//! input.

use std::{path::PathBuf, time::Duration};

use bendtwin_proto::v1::worker_service_client::WorkerServiceClient;
use bendtwin_proto::v1::{GetWorkerRequest, ListWorkersRequest};
use bendtwin_proto::worker::v1::{LeaseJobRequest, LeaveRequest, lease_job_request::Kind};
use serde_json::json;

use crate::{harness::Server, worker::Worker};

async fn until<T>(what: &str, mut found: impl FnMut() -> Option<T>) -> T {
    for _ in 0..1000 {
        if let Some(found) = found() {
            return found;
        }
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    panic!("{what} did not come");
}

fn lines(path: &PathBuf) -> Vec<String> {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    text.split_inclusive('\n').filter_map(|l| l.strip_suffix('\n')).map(str::to_owned).collect()
}

fn shell(options: &mut bendtwin_server::Options, script: String) {
    options.workers.count = 1;
    options.workers.program = Some("/bin/sh".into());
    options.workers.args = vec!["-c".into(), script];
    options.workers.min_backoff_s = 0.01;
}

#[tokio::test]
async fn children_are_restarted_with_fresh_tokens() {
    let dir = tempfile::tempdir().unwrap();
    let log = dir.path().join("log");
    let script = format!("echo $BENDTWIN_SERVER $BENDTWIN_WORKER_TOKEN >> {}", log.display());
    let server = Server::start_with(|o| shell(o, script)).await;
    let seen = until("three starts", || Some(lines(&log)).filter(|l| l.len() >= 3)).await;
    let address = format!("http://{}", server.handle.worker_addr());
    let tokens: std::collections::HashSet<&str> =
        seen.iter().map(|l| l.strip_prefix(&format!("{address} ")).unwrap()).collect();
    assert_eq!(tokens.len(), seen.len());
    assert!(tokens.iter().all(|t| t.len() == 64));
    server.handle.shutdown().await;
}

#[tokio::test]
async fn children_learn_what_to_compute_on() {
    let dir = tempfile::tempdir().unwrap();
    let log = dir.path().join("log");
    let script = format!("echo $BENDTWIN_BACKEND $BENDTWIN_DEVICE >> {}; cat", log.display());
    let server = Server::start_with(|o| {
        shell(o, script);
        o.workers.count = 3;
        o.workers.backend = "cuda".to_owned();
        o.workers.devices = vec![4, 6];
    })
    .await;
    let mut seen = until("three starts", || Some(lines(&log)).filter(|l| l.len() >= 3)).await;
    seen.sort();
    assert_eq!(seen, ["cuda 4", "cuda 4", "cuda 6"]);
    server.handle.shutdown().await;
}

#[tokio::test]
async fn children_end_with_the_server_or_are_killed() {
    let dir = tempfile::tempdir().unwrap();
    let log = dir.path().join("log");
    let script = format!("echo up >> {0}; cat; echo down >> {0}", log.display());
    let server = Server::start_with(|o| shell(o, script)).await;
    until("the child", || lines(&log).first().cloned()).await;
    server.handle.shutdown().await;
    assert_eq!(lines(&log), ["up", "down"]);

    // One that does not care about its standard input.
    let log = dir.path().join("stubborn");
    let script = format!("echo $$ >> {}; exec sleep 1000", log.display());
    let server = Server::start_with(|o| {
        shell(o, script);
        o.shutdown_grace_s = 0.1;
    })
    .await;
    let pid = until("the child", || lines(&log).first().cloned()).await;
    server.handle.shutdown().await;
    assert!(!PathBuf::from(format!("/proc/{pid}")).exists());
}

/// Without the program no worker would ever come: the server says so immediately.
#[tokio::test]
async fn a_server_does_not_start_without_the_program_of_its_workers() {
    use bendtwin_core::Problem as _;
    let dir = tempfile::tempdir().unwrap();
    for program in ["/no/such/program", "no-such-program", "/etc/passwd"] {
        let mut options = crate::harness::options(&dir);
        options.workers.count = 1;
        options.workers.program = Some(program.into());
        let refused = bendtwin_server::Service::start(options).await.unwrap_err();
        assert_eq!(refused.reason(), "NO_WORKER_PROGRAM");
        assert!(refused.to_string().contains(program), "{refused}");
    }
}

#[tokio::test]
async fn workers_are_listed() {
    let server = Server::start().await;
    let mut worker = Worker::register(&server).await;
    let (_, list) = server.get("/v1/workers").await;
    assert_eq!(list["workers"][0]["name"], worker.id.to_string());
    assert_eq!(list["workers"][0]["device"], "fake");
    let (status, one) = server.get(&format!("/v1/{}", worker.id)).await;
    assert_eq!((status, &one), (200, &list["workers"][0]));
    let mut workers = WorkerServiceClient::new(server.channel.clone());
    let listed = workers.list_workers(ListWorkersRequest::default()).await.unwrap().into_inner();
    let name = worker.id.to_string();
    let got = workers.get_worker(GetWorkerRequest { name }).await.unwrap().into_inner();
    assert_eq!(listed.workers, [got]);
    // Memory is known once the worker has said so.
    assert_eq!(list["workers"][0]["memory_total_bytes"], json!(null));
    worker.heartbeat().await.unwrap();
    let (_, listed) = server.get(&format!("/v1/{}", worker.id)).await;
    assert_eq!(listed["memory_used_bytes"], json!(3u64 << 30));
    assert_eq!(listed["memory_total_bytes"], json!(80u64 << 30));
    let text = server.http.get(server.url("/metrics")).send().await.unwrap().text().await.unwrap();
    let gauge = format!("bendtwin_device_memory_bytes{{state=\"total\"}} {}", 80u64 << 30);
    assert!(text.contains(&gauge), "{gauge} is not in\n{text}");
    let (_, ready) = server.get("/readyz").await;
    assert_eq!((&ready["workers"], &ready["rollouts"]), (&json!(1), &json!(0)));
}

/// A drained worker gets no more jobs or rollouts, repeated requests change nothing, and its last
/// message removes it from the list with its job.
#[tokio::test]
async fn a_drained_worker_learns_of_it_and_gets_no_more_work() {
    let server = Server::start().await;
    let mut worker = Worker::register(&server).await;
    let fit = server.fit().await;
    let lease = worker.lease(Duration::from_secs(5)).await.unwrap();
    assert_eq!(lease.job, fit);
    server.fit().await;
    let path = format!("/v1/{}/drain", worker.id);
    for _ in 0..2 {
        let (status, drained) = server.post(&path, json!(null)).await;
        assert_eq!((status, &drained["draining"]), (200, &json!(true)), "{drained}");
    }
    assert!(worker.heartbeat().await.unwrap().drain);
    let asked = LeaseJobRequest {
        worker: worker.id.to_string(),
        wait_s: 60.0,
        kind: Kind::Fit.into(),
        brief: false,
    };
    let answer = worker.link.lease_job(asked).await.unwrap().into_inner();
    assert!(answer.drain && answer.lease.is_none(), "{answer:?}");
    let leave = LeaveRequest { worker: worker.id.to_string() };
    worker.link.leave(leave).await.unwrap();
    assert_eq!(server.get("/v1/workers").await.1["workers"], json!([]));
    let (_, got) = server.get(&format!("/v1/{fit}")).await;
    assert_eq!((&got["job"]["state"], &got["job"]["attempts"]), (&json!("QUEUED"), &json!(0)));
    let unknown = format!("/v1/{}/drain", bendtwin_core::ids::WorkerId::generate());
    assert_eq!(server.post(&unknown, json!(null)).await.0, 404);
}
