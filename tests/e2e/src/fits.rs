//! The life of fit jobs for their owner: created once, ordered by priority, cancelled immediately,
//! taken over when a worker dies, watched.

use std::time::Duration;

use bendtwin_proto::v1::{
    CreateFitRequest, DeleteCaptureRequest, DeleteFitRequest, Fit, GetFitLossesRequest,
    WatchFitRequest, job::State,
};
use tonic::Code;

use crate::harness::{
    Setup, TestCluster,
    api::{fraction, has_ended, worker},
    command::run_ok,
    reference::{ENDLESS, FIT, SETTINGS, capture, reference},
    within,
};

/// A fit of well under a second.
const SHORT: &str =
    r#"{"graph": {"max_nodes": 20}, "search": {"generations": 1}, "refine": {"passes": 1}}"#;
const STATE: Duration = Duration::from_secs(60);

fn running(fit: &Fit) -> bool {
    fit.state() == State::Running && fraction(fit) > 0.0
}

#[tokio::test]
async fn creating_twice_with_one_request_id_is_creating_once() {
    let mut server = TestCluster::start(Setup { own_workers: 0, ..Setup::default() }).await;
    let api = server.api();
    let archive = capture().await;
    let capture = api.upload(&archive, "once").await.unwrap();
    assert_eq!(api.upload(&archive, "once").await.unwrap().name, capture.name);

    let request = CreateFitRequest {
        capture: capture.name.clone(),
        settings_json: SHORT.to_owned(),
        priority: 3,
        request_id: "once".to_owned(),
        ..CreateFitRequest::default()
    };
    let first = api.fits().create_fit(request.clone()).await.unwrap().into_inner();
    server.kill();
    server.start_again().await;
    let again = api.fits().create_fit(request.clone()).await.unwrap().into_inner();
    assert_eq!(first.name, again.name);
    assert_eq!(api.list_fits().await.unwrap().len(), 1);
    assert_eq!(api.list_captures().await.unwrap().len(), 1);

    let other = CreateFitRequest { priority: 4, ..request };
    let refused = api.fits().create_fit(other).await.unwrap_err();
    assert_eq!(refused.code(), Code::AlreadyExists, "{}", refused.message());
}

#[tokio::test]
async fn higher_priorities_run_first_and_equal_ones_in_order() {
    let mut server = TestCluster::start(Setup { own_workers: 0, ..Setup::default() }).await;
    let api = server.api();
    let capture = api.upload(&capture().await, "").await.unwrap();
    let mut fits = Vec::new();
    for priority in [0, -5, 7, 0] {
        fits.push(api.fit(&capture.name, SHORT, priority).await.unwrap().name);
    }
    server.start_worker().await;
    let mut started = Vec::new();
    for name in &fits {
        let fit = api.succeeded(name, FIT).await;
        let time = fit.job.unwrap().start_time.unwrap();
        started.push(((time.seconds, time.nanos), name.clone()));
    }
    started.sort();
    let order: Vec<_> = started.into_iter().map(|(_, name)| name).collect();
    assert_eq!(order, [2, 0, 3, 1].map(|i| fits[i].clone()));
}

#[tokio::test]
async fn a_running_fit_is_cancelled() {
    let server = TestCluster::start(Setup::default()).await;
    let api = server.api();
    let capture = api.upload(&capture().await, "").await.unwrap();
    let fit = api.fit(&capture.name, ENDLESS, 0).await.unwrap();
    api.fit_when(&fit.name, "running", STATE, running).await;
    let refused =
        api.fits().delete_fit(DeleteFitRequest { name: fit.name.clone(), purge: false }).await;
    assert_eq!(refused.unwrap_err().code(), Code::FailedPrecondition);
    let refused = api
        .captures()
        .delete_capture(DeleteCaptureRequest { name: capture.name, purge: false })
        .await;
    assert_eq!(refused.unwrap_err().code(), Code::FailedPrecondition);

    api.cancel(&fit.name).await.unwrap();
    let fit = api.fit_when(&fit.name, "cancelled", STATE, has_ended).await;
    assert_eq!(fit.state(), State::Cancelled, "{:?}", fit.job);
    assert_eq!(api.cancel(&fit.name).await.unwrap().state(), State::Cancelled);
    api.fits().delete_fit(DeleteFitRequest { name: fit.name.clone(), purge: false }).await.unwrap();
    assert_eq!(api.get_fit(&fit.name).await.unwrap_err().code(), Code::NotFound);
}

#[tokio::test]
async fn a_queued_fit_is_cancelled_immediately() {
    let server = TestCluster::start(Setup { own_workers: 0, ..Setup::default() }).await;
    let api = server.api();
    let capture = api.upload(&capture().await, "").await.unwrap();
    let fit = api.fit(&capture.name, SETTINGS, 0).await.unwrap();
    assert_eq!(fit.state(), State::Queued);
    assert_eq!(api.cancel(&fit.name).await.unwrap().state(), State::Cancelled);
}

#[tokio::test]
async fn another_worker_takes_over_from_a_dead_one() {
    let setup = Setup { own_workers: 0, ..Setup::default() };
    let mut server = TestCluster::start(setup).await;
    let api = server.api();
    let capture = api.upload(&capture().await, "").await.unwrap();
    let fit = api.fit(&capture.name, SETTINGS, 0).await.unwrap();
    let first = server.start_worker().await.name;
    api.fit_when(&fit.name, "run by the first worker", STATE, |f| worker(f) == first).await;
    let second = server.start_worker().await.name;
    server.kill_own_worker();
    api.fit_when(&fit.name, "run by the second worker", STATE, |f| worker(f) == second).await;
    let fit = api.succeeded(&fit.name, FIT).await;
    assert_eq!(fit.job.unwrap().attempts, 2);
    // Its losses are those of an undisturbed fit: each iteration once.
    let request = GetFitLossesRequest { name: fit.name };
    let curves = api.fits().get_fit_losses(request).await.unwrap().into_inner().curves;
    let all: Vec<_> = curves.into_iter().map(|c| (c.stage, c.iterations)).collect();
    let expected = [("search", 12), ("refine", 24)].map(|(s, n)| (s.to_owned(), (1..=n).collect()));
    assert_eq!(all, expected);
}

#[tokio::test]
async fn a_fit_through_the_server_is_the_fit_of_eval_byte_for_byte() {
    let place = tempfile::tempdir().unwrap();
    let path = |name: &str| place.path().join(name).to_str().unwrap().to_owned();
    let [archive, settings, twin] = ["rope.zip", "settings.json", "rope.twin"].map(path);
    std::fs::write(&archive, capture().await).unwrap();
    std::fs::write(&settings, SETTINGS).unwrap();
    let file = twin.clone();
    let eval = move || {
        run_ok(&["eval", &archive, "--settings", &settings, "--backend", "cpu", "--out", &file])
    };
    tokio::task::spawn_blocking(eval).await.unwrap();
    let read = |bytes: &[u8]| bendtwin_core::Twin::decode(bytes).unwrap();
    let (mut here, there) = (read(&std::fs::read(&twin).unwrap()), read(&reference().await.file));
    // On a server a capture is called what its owner calls it.
    here.provenance.capture_name.clone_from(&there.provenance.capture_name);
    assert!(here.encode().unwrap() == reference().await.file, "the twins differ");
}

#[tokio::test]
async fn watching_shows_every_stage_and_resumes_after_a_revision() {
    let server = TestCluster::ordinary().await;
    let api = server.api();
    let capture = api.upload(&capture().await, "").await.unwrap();
    let fit = api.fit(&capture.name, SETTINGS, 0).await.unwrap();
    let seen = watch(&server, &fit.name, 0).await;
    assert!(seen.is_sorted_by(|a, b| revision(a) < revision(b)), "revisions grow");
    assert!(seen.iter().any(running), "progress was shown");
    let fractions: Vec<_> = seen.iter().map(fraction).collect();
    assert!(fractions.is_sorted(), "{fractions:?}");
    let last = seen.last().unwrap();
    assert_eq!(last.state(), State::Succeeded);
    // A client that has seen everything but the end gets the end.
    let rest = watch(&server, &fit.name, revision(last) - 1).await;
    assert_eq!(rest.len(), 1);
    assert_eq!(revision(&rest[0]), revision(last));
}

fn revision(fit: &Fit) -> u64 {
    fit.job.as_ref().unwrap().revision
}

async fn watch(server: &TestCluster, name: &str, after_revision: u64) -> Vec<Fit> {
    let request = WatchFitRequest { name: name.to_owned(), after_revision };
    let mut changes = server.api().fits().watch_fit(request).await.unwrap().into_inner();
    let mut seen = Vec::new();
    within("a watched fit", FIT, async {
        while let Some(fit) = changes.message().await.unwrap() {
            seen.push(fit);
        }
    })
    .await;
    seen
}
