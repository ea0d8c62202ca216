use std::time::Duration;

use bendtwin_contract::worker_key;
use bendtwin_proto::{
    v1::Fault,
    worker::v1::{
        FailJobRequest, HeartbeatRequest, LeaseJobRequest, fail_job_request::End,
        lease_job_request::Kind,
    },
};
use serde_json::json;
use tonic::Code;

use crate::{
    harness::Server,
    results::{observation, report, twin_file},
    worker::{Made, Worker, link},
};

fn reason(status: &tonic::Status) -> String {
    bendtwin_proto::fault::fault(status).reason
}

/// The whole protocol: lease, download, report, checkpoint, hand back, lease again elsewhere,
/// resume from the checkpoint, complete, complete again.
#[tokio::test]
async fn a_job_goes_from_worker_to_worker_until_it_is_a_twin() {
    let server = Server::start().await;
    let fit = server.fit().await;
    let mut first = Worker::register(&server).await;
    let lease = first.lease(Duration::from_secs(5)).await.unwrap();
    assert_eq!((&lease.job, lease.epoch, lease.has_checkpoint), (&fit, 1, false));
    assert_eq!(first.download(&lease.capture).await.unwrap(), b"an archive");
    assert_eq!(first.download(&fit).await.unwrap_err().code(), Code::NotFound);
    assert!(!first.report(&lease, 0.25).await.unwrap());
    first.checkpoint(&lease, b"old").await.unwrap();
    first.checkpoint(&lease, b"half way").await.unwrap();
    let release = FailJobRequest { end: End::Released.into(), ..first.failure(&lease) };
    first.link.fail_job(release).await.unwrap();

    let mut second = Worker::register(&server).await;
    let again = second.lease(Duration::from_secs(5)).await.unwrap();
    assert_eq!((&again.job, again.epoch, again.has_checkpoint), (&fit, 2, true));
    assert_eq!(second.download(&fit).await.unwrap(), b"half way");
    // The first worker's lease is stale now.
    for status in [
        first.report(&lease, 0.9).await.unwrap_err(),
        first.checkpoint(&lease, b"late").await.unwrap_err(),
        first.complete(&lease, b"late").await.unwrap_err(),
        first.link.fail_job(first.failure(&lease)).await.unwrap_err(),
    ] {
        assert_eq!((status.code(), reason(&status).as_str()), (Code::Aborted, "STALE_LEASE"));
    }
    let twin = second.complete(&again, b"a twin").await.unwrap();
    // The reply was lost, say.
    assert_eq!(second.complete(&again, b"a twin").await.unwrap(), twin);
    assert_eq!(second.complete(&again, b"other").await.unwrap_err().code(), Code::Aborted);

    let (_, got) = server.get(&format!("/v1/{fit}")).await;
    assert_eq!((&got["job"]["state"], &got["twin"]), (&json!("SUCCEEDED"), &json!(twin)));
    assert_eq!((&got["job"]["attempts"], &got["job"]["worker"]), (&json!(1), &json!(null)));
    let (_, got) = server.get(&format!("/v1/{twin}")).await;
    assert_eq!((&got["fit"], &got["display_name"]), (&json!(fit), &json!("rope")));
    assert_eq!((&got["node_count"], &got["quality"]), (&json!(5), &json!({"scores": []})));
    assert_eq!(second.download(&twin).await.unwrap(), twin_file(b"a twin"));
    // Capture, observation, playback, the two forms of its report and twin: no checkpoint is left.
    assert_eq!(server.blob_files(), 6);
}

#[tokio::test]
async fn cancellation_and_failure_reach_the_user() {
    let server = Server::start().await;
    let (cancelled, failed) = (server.fit().await, server.fit().await);
    let mut worker = Worker::register(&server).await;
    let lease = worker.lease(Duration::ZERO).await.unwrap();
    assert_eq!(lease.job, cancelled);
    server.post(&format!("/v1/{cancelled}/cancel"), json!(null)).await;
    assert!(worker.report(&lease, 0.1).await.unwrap());
    let end = FailJobRequest { end: End::Cancelled.into(), ..worker.failure(&lease) };
    worker.link.fail_job(end).await.unwrap();
    assert_eq!(server.get(&format!("/v1/{cancelled}")).await.1["job"]["state"], "CANCELLED");

    let lease = worker.lease(Duration::ZERO).await.unwrap();
    let fault = Fault {
        category: "INVALID_ARGUMENT".into(),
        reason: "NO_CONTROLS".into(),
        message: "the capture has no control points: say who moves it".into(),
    };
    let end = FailJobRequest {
        fault: Some(fault.clone()),
        end: End::FailedForGood.into(),
        ..worker.failure(&lease)
    };
    worker.link.fail_job(end).await.unwrap();
    let (_, fit) = server.get(&format!("/v1/{failed}")).await;
    assert_eq!(fit["job"]["state"], "FAILED");
    assert_eq!(fit["job"]["fault"]["reason"], fault.reason);
    assert_eq!(fit["job"]["fault"]["message"], fault.message);
}

#[tokio::test]
async fn a_silent_worker_loses_its_job_and_is_forgotten() {
    let server = Server::start_with(|o| {
        // Long enough for the heir to be heard on a machine that is busy with other things.
        o.lease_s = 4.0;
        o.heartbeat_interval_s = 1.0;
    })
    .await;
    let fit = server.fit().await;
    let mut silent = Worker::register(&server).await;
    silent.lease(Duration::ZERO).await.unwrap();
    let mut heir = Worker::register(&server).await;
    let (mut link, worker) = (heir.link.clone(), heir.id.to_string());
    tokio::spawn(async move {
        let heartbeat =
            || HeartbeatRequest { worker: worker.clone(), ..HeartbeatRequest::default() };
        while link.heartbeat(heartbeat()).await.is_ok() {
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    });
    // Waits for as long as the lease takes to run out.
    let lease = heir.lease(Duration::from_secs(60)).await.unwrap();
    assert_eq!((&lease.job, lease.epoch), (&fit, 2));
    let (_, got) = server.get(&format!("/v1/{fit}")).await;
    assert_eq!(got["job"]["attempt_faults"][0]["reason"], "WORKER_LOST");
    let unknown = silent.heartbeat().await.unwrap_err();
    assert_eq!((unknown.code(), reason(&unknown).as_str()), (Code::NotFound, "WORKER_UNKNOWN"));
}

/// Server and worker stand still for longer than a lease, as on a machine that was suspended: this
/// test has one thread, which stops both.
#[tokio::test]
async fn a_standstill_ends_no_lease_and_forgets_no_worker() {
    let server = Server::start_with(|o| {
        // The worker has this long to be heard after the standstill.
        o.lease_s = 3.0;
        o.heartbeat_interval_s = 1.0;
    })
    .await;
    server.fit().await;
    let mut worker = Worker::register(&server).await;
    let lease = worker.lease(Duration::ZERO).await.unwrap();
    worker.report(&lease, 0.1).await.unwrap();
    std::thread::sleep(Duration::from_millis(7000));
    // The server goes first.
    tokio::time::sleep(Duration::from_millis(60)).await;
    let (_, ready) = server.get("/readyz").await;
    assert_eq!(ready["ready"], true, "{ready}");
    worker.heartbeat().await.unwrap();
    worker.report(&lease, 0.5).await.unwrap();
    worker.complete(&lease, b"a twin").await.unwrap();
}

/// The worker asks for a checkpoint that is gone: the job has none any more.
#[tokio::test]
async fn a_lost_checkpoint_is_reported_and_forgotten() {
    let server = Server::start().await;
    let fit = server.fit().await;
    let mut worker = Worker::register(&server).await;
    let lease = worker.lease(Duration::ZERO).await.unwrap();
    worker.checkpoint(&lease, b"half way").await.unwrap();
    let release = FailJobRequest { end: End::Released.into(), ..worker.failure(&lease) };
    worker.link.fail_job(release.clone()).await.unwrap();
    let digest = blake3::hash(b"half way").to_hex().to_string();
    let lease = worker.lease(Duration::ZERO).await.unwrap();
    assert_eq!((lease.has_checkpoint, &lease.checkpoint_digest), (true, &digest));
    assert!(server.lose_blob(&digest));
    assert_eq!(worker.download(&fit).await.unwrap_err().code(), Code::DataLoss);
    let release = FailJobRequest { epoch: lease.epoch, ..release };
    worker.link.fail_job(release).await.unwrap();
    let lease = worker.lease(Duration::ZERO).await.unwrap();
    assert_eq!((lease.has_checkpoint, lease.checkpoint_digest.as_str()), (false, ""));
    worker.complete(&lease, b"a twin").await.unwrap();
}

#[tokio::test]
async fn the_link_is_for_token_holders() {
    let server = Server::start().await;
    let (key, id) = worker_key::generate();
    let id = id.to_string();
    let mut plain = bendtwin_proto::worker::v1::worker_link_client::WorkerLinkClient::new(
        server.channel.clone(),
    );
    for token in [None, Some("Bearer wrong"), Some("Bearer "), Some("a-token-of-the-tests")] {
        let mut request = tonic::Request::new(HeartbeatRequest {
            worker: id.clone(),
            ..HeartbeatRequest::default()
        });
        if let Some(token) = token {
            request.metadata_mut().insert("authorization", token.parse().unwrap());
        }
        let status = plain.heartbeat(request).await.unwrap_err();
        assert_eq!(status.code(), Code::Unauthenticated, "{token:?}");
    }
    let mut link = link(&server, &key);
    for wait_s in [-1.0, f64::NAN, f64::INFINITY] {
        let request =
            LeaseJobRequest { worker: id.clone(), wait_s, kind: Kind::Fit.into(), brief: false };
        assert_eq!(link.lease_job(request).await.unwrap_err().code(), Code::InvalidArgument);
    }
    let request =
        LeaseJobRequest { worker: id.clone(), wait_s: 0.0, kind: Kind::Fit.into(), brief: false };
    assert_eq!(reason(&link.lease_job(request).await.unwrap_err()), "WORKER_UNKNOWN");
    let request = LeaseJobRequest { worker: id, wait_s: 0.0, kind: 7, brief: false };
    assert_eq!(link.lease_job(request).await.unwrap_err().code(), Code::InvalidArgument);
}

/// A worker started by others outlives the server and continues its job.
#[tokio::test]
async fn workers_of_others_outlive_the_server() {
    let server = Server::start().await;
    let fit = server.fit().await;
    let mut worker = Worker::register(&server).await;
    let lease = worker.lease(Duration::ZERO).await.unwrap();
    worker.checkpoint(&lease, b"half way").await.unwrap();
    let Server { dir, handle, .. } = server;
    handle.shutdown().await;

    let options = crate::harness::options(&dir);
    let handle = bendtwin_server::Service::start(options).await.unwrap();
    let url = format!("http://{}", handle.local_addr());
    let channel = tonic::transport::Endpoint::from_shared(url).unwrap().connect_lazy();
    let server = Server { dir, handle, http: reqwest::Client::new(), channel };
    worker.turn_to(&server);
    worker.heartbeat().await.unwrap();
    worker.report(&lease, 0.5).await.unwrap();
    worker.complete(&lease, b"a twin").await.unwrap();
    assert_eq!(server.get(&format!("/v1/{fit}")).await.1["job"]["state"], "SUCCEEDED");
}

/// A worker with a token knows the names and epochs of others' jobs, which are no secrets.
#[tokio::test]
async fn a_worker_acts_for_itself_alone() {
    let server = Server::start().await;
    let fit = server.fit().await;
    let mut worker = Worker::register(&server).await;
    let mut rogue = Worker::register(&server).await;
    let lease = worker.lease(Duration::ZERO).await.unwrap();
    worker.checkpoint(&lease, b"half way").await.unwrap();

    // Under its own name it has no such lease.
    for status in [
        rogue.report(&lease, 0.9).await.unwrap_err(),
        rogue.checkpoint(&lease, b"junk").await.unwrap_err(),
        rogue.complete(&lease, b"junk").await.unwrap_err(),
        rogue.link.fail_job(rogue.failure(&lease)).await.unwrap_err(),
    ] {
        assert_eq!((status.code(), reason(&status).as_str()), (Code::Aborted, "STALE_LEASE"));
    }
    for content in [lease.capture.clone(), fit.clone()] {
        let status = rogue.download(&content).await.unwrap_err();
        let seen = (status.code(), reason(&status));
        assert_eq!(seen, (Code::PermissionDenied, "CONTENT_NOT_LEASED".to_owned()), "{content}");
    }
    // Under the name of the other it lacks the key.
    let itself = std::mem::replace(&mut rogue.id, worker.id);
    for status in [
        rogue.heartbeat().await.unwrap_err(),
        rogue.report(&lease, 0.9).await.unwrap_err(),
        rogue.checkpoint(&lease, b"junk").await.unwrap_err(),
        rogue.complete(&lease, b"junk").await.unwrap_err(),
        rogue.observe(&lease).await.unwrap_err(),
        rogue.link.fail_job(rogue.failure(&lease)).await.unwrap_err(),
        rogue.register_again().await.unwrap_err(),
    ] {
        let seen = (status.code(), reason(&status));
        assert_eq!(seen, (Code::PermissionDenied, "WORKER_KEY_MISMATCH".to_owned()));
    }
    rogue.id = itself;
    rogue.heartbeat().await.unwrap();

    assert_eq!(worker.download(&fit).await.unwrap(), b"half way");
    let twin = worker.complete(&lease, b"a twin").await.unwrap();
    // Any worker may get a rollout of it, from a frame of its capture.
    assert_eq!(rogue.download(&twin).await.unwrap(), twin_file(b"a twin"));
    let seen = format!("{}/observation", lease.capture);
    assert_eq!(rogue.download(&seen).await.unwrap(), observation(b"seen"));
    assert_eq!(server.get(&format!("/v1/{fit}")).await.1["job"]["state"], "SUCCEEDED");
}

/// A result that cannot be what it should be is refused, and nothing of it stays.
#[tokio::test]
async fn junk_does_not_become_a_twin() {
    let server = Server::start().await;
    let fit = server.fit().await;
    let mut worker = Worker::register(&server).await;
    let lease = worker.lease(Duration::ZERO).await.unwrap();
    let files = server.blob_files();
    let mut damaged = twin_file(b"a twin");
    damaged.truncate(damaged.len() - 1);
    for junk in [b"junk".to_vec(), Vec::new(), damaged] {
        let status = worker.send_twin(&lease, junk).await.unwrap_err();
        let seen = (status.code(), reason(&status));
        assert_eq!(seen, (Code::InvalidArgument, "INVALID_TWIN_FILE".to_owned()));
    }
    // Valid, but different from the worker's description.
    let other = crate::twins::twin_file();
    let status = worker.send_twin(&lease, other).await.unwrap_err();
    assert_eq!(reason(&status), "RESULT_UNSOUND");
    assert_eq!(server.get(&format!("/v1/{fit}")).await.1["job"]["state"], "RUNNING");
    for _ in 0..500 {
        if server.blob_files() == files {
            break;
        }
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    assert_eq!(server.blob_files(), files);
    worker.complete(&lease, b"a twin").await.unwrap();
}

#[tokio::test]
async fn junk_does_not_become_an_observation_or_a_report() {
    let server = Server::start().await;
    let capture = server.capture().await;
    let mut worker = Worker::register(&server).await;
    let lease = worker.lease_a(Kind::Ingest, Duration::ZERO).await.unwrap();
    let good = || (Some(observation(b"seen")), report("good"));
    let other_format = report("good").replace("bendtwin-capture-report", "other");
    for (seen, said) in [
        (Some(b"junk".to_vec()), good().1),
        (Some(Vec::new()), good().1),
        (good().0, "junk".to_owned()),
        (good().0, "{}".to_owned()),
        (good().0, other_format),
        (good().0, report("usable")),
    ] {
        let status = worker.send_ingest(&lease, seen, said, "good", None).await.unwrap_err();
        let seen = (status.code(), reason(&status));
        assert_eq!(seen, (Code::InvalidArgument, "RESULT_UNSOUND".to_owned()));
    }
    assert_eq!(server.get(&format!("/v1/{capture}")).await.1["ingest"]["state"], "RUNNING");
    let (seen, said) = good();
    let sound = Made { observation: seen.clone(), ..Made::default() };
    for junk in [
        Made { playback: Some(b"BENDPLA".to_vec()), ..sound.clone() },
        Made { masks: Some(b"PK".to_vec()), ..sound },
    ] {
        let status = worker.send_made(&lease, junk, report("good"), "good").await.unwrap_err();
        assert_eq!(reason(&status), "RESULT_UNSOUND");
    }
    worker.send_ingest(&lease, seen, said, "good", None).await.unwrap();
}
