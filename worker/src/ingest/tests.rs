//! Whole ingest jobs between a server that keeps what it gets and a shell script that stands in for the
//! child.

use std::{
    collections::HashMap,
    os::unix::fs::PermissionsExt as _,
    path::Path,
    pin::Pin,
    sync::{Arc, Mutex},
};

use bendtwin_proto::worker::v1::{
    CompleteFitRequest, CompleteFitResponse, DownloadRequest, DownloadResponse, EndIngestRequest,
    EndIngestResponse, FailJobRequest, FailJobResponse, HeartbeatRequest, HeartbeatResponse,
    IngestWrite, Lease, LeaseJobRequest, LeaseJobResponse, LeasedSupplement, LeaveRequest,
    LeaveResponse, RegisterRequest, RegisterResponse, ReportJobRequest, ReportJobResponse,
    SaveCheckpointRequest, SaveCheckpointResponse,
    end_ingest_request::Part,
    fail_job_request::End,
    worker_link_server::{WorkerLink, WorkerLinkServer},
};
use futures::Stream;
use tonic::{Request as Call, Response, Status, Streaming};

use super::*;
use crate::server_client::ServerClient;

const CAPTURE: &str = "captures/0190a000-0000-7000-8000-000000000001";
/// Writes what every child does.
const REPORT: &str = "printf '{}' > \"$2/report.json\"; printf '<p>' > \"$2/report.html\"; ";

/// Contents that a worker sent, by their parts.
#[derive(Clone, Debug, Default)]
struct Received {
    end: IngestWrite,
    parts: HashMap<&'static str, Vec<u8>>,
    failed: Option<FailJobRequest>,
    /// Names of what was downloaded.
    downloads: Vec<String>,
}

/// A server with contents by name.
#[derive(Clone, Default)]
struct Server {
    contents: HashMap<String, &'static [u8]>,
    received: Arc<Mutex<Received>>,
}

type Answer<T> = Result<Response<T>, Status>;

#[tonic::async_trait]
impl WorkerLink for Server {
    type DownloadStream = Pin<Box<dyn Stream<Item = Result<DownloadResponse, Status>> + Send>>;

    async fn download(&self, request: Call<DownloadRequest>) -> Answer<Self::DownloadStream> {
        let name = request.into_inner().name;
        let content = self.contents.get(&name).ok_or_else(|| Status::not_found(&name))?;
        self.received.lock().unwrap().downloads.push(name);
        let chunk = DownloadResponse { chunk: (*content).into() };
        Ok(Response::new(Box::pin(futures::stream::iter([Ok(chunk)]))))
    }

    async fn end_ingest(
        &self,
        request: Call<Streaming<EndIngestRequest>>,
    ) -> Answer<EndIngestResponse> {
        let mut messages = request.into_inner();
        let mut received = Received::default();
        while let Some(message) = messages.message().await? {
            let (part, chunk) = match message.part.unwrap() {
                Part::Metadata(end) => {
                    received.end = end;
                    continue;
                }
                Part::Observation(chunk) => ("observation", chunk),
                Part::Playback(chunk) => ("playback", chunk),
                Part::Masks(chunk) => ("masks", chunk),
                Part::Report(chunk) => ("report", chunk),
                Part::Page(chunk) => ("page", chunk),
            };
            received.parts.entry(part).or_default().extend(chunk);
        }
        let mut kept = self.received.lock().unwrap();
        received.downloads = std::mem::take(&mut kept.downloads);
        *kept = received;
        Ok(Response::new(EndIngestResponse {}))
    }

    async fn fail_job(&self, request: Call<FailJobRequest>) -> Answer<FailJobResponse> {
        self.received.lock().unwrap().failed = Some(request.into_inner());
        Ok(Response::new(FailJobResponse {}))
    }

    async fn report_job(&self, _: Call<ReportJobRequest>) -> Answer<ReportJobResponse> {
        Ok(Response::new(ReportJobResponse::default()))
    }

    async fn register(&self, _: Call<RegisterRequest>) -> Answer<RegisterResponse> {
        Err(Status::unimplemented("register"))
    }

    async fn heartbeat(&self, _: Call<HeartbeatRequest>) -> Answer<HeartbeatResponse> {
        Err(Status::unimplemented("heartbeat"))
    }

    async fn lease_job(&self, _: Call<LeaseJobRequest>) -> Answer<LeaseJobResponse> {
        Err(Status::unimplemented("lease_job"))
    }

    async fn save_checkpoint(
        &self,
        _: Call<Streaming<SaveCheckpointRequest>>,
    ) -> Answer<SaveCheckpointResponse> {
        Err(Status::unimplemented("save_checkpoint"))
    }

    async fn complete_fit(
        &self,
        _: Call<Streaming<CompleteFitRequest>>,
    ) -> Answer<CompleteFitResponse> {
        Err(Status::unimplemented("complete_fit"))
    }

    async fn leave(&self, _: Call<LeaveRequest>) -> Answer<LeaveResponse> {
        Err(Status::unimplemented("leave"))
    }
}

fn digest(content: &[u8]) -> String {
    blake3::hash(content).to_hex().to_string()
}

/// A job whose capture has both supplements and masks of the ingest before.
fn lease(settings: &str) -> Lease {
    let supplement = |kind: &str, content: &[u8]| LeasedSupplement {
        kind: kind.to_owned(),
        digest: digest(content),
    };
    Lease {
        job: "ingests/0190a000-0000-7000-8000-000000000002".to_owned(),
        epoch: 1,
        capture: CAPTURE.to_owned(),
        capture_digest: digest(b"archive"),
        settings_json: settings.to_owned(),
        supplements: vec![supplement("masks", b"added "), supplement("calibration", b"poses ")],
        masks_digest: digest(b"before"),
        ..Lease::default()
    }
}

/// Runs a job with a script as its child; its argument, the folder, is in `$2`.
async fn run(lease: Lease, script: &str) -> Received {
    run_for(lease, script, Duration::from_secs(60)).await
}

/// The same with a time for brief jobs.
async fn run_for(lease: Lease, script: &str, longest: Duration) -> Received {
    let contents: [(&str, &'static [u8]); 4] = [
        ("", b"archive"),
        ("/supplements/masks", b"added "),
        ("/supplements/calibration", b"poses "),
        ("/masks", b"before"),
    ];
    let contents = contents.map(|(part, content)| (format!("{CAPTURE}{part}"), content));
    let server = Server { contents: contents.into(), ..Server::default() };
    let received = server.received.clone();
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let url = format!("http://{}", listener.local_addr().unwrap());
    let incoming = tokio_stream::wrappers::TcpListenerStream::new(listener);
    let serving = tonic::transport::Server::builder()
        .add_service(WorkerLinkServer::new(server))
        .serve_with_incoming(incoming);
    let serving = tokio::spawn(serving);
    let dir = tempfile::tempdir().unwrap();
    let program = program(dir.path(), script);
    let ingests = Ingests {
        dir: dir.path().to_owned(),
        program,
        memory_bytes: 1 << 30,
        time: Duration::from_secs(60),
        sandbox: Sandbox::BestEffort,
        delivery_timeout: Duration::from_secs(60),
        taken: watch::Sender::new(false),
    };
    let client = ServerClient::new(&[url], "token", "key", None).unwrap();
    let job = LeasedJob::new(client, "workers/0190a000-0000-7000-8000-000000000003", lease);
    if job.is_brief() {
        let brief = BriefIngests { first: ingests, time: longest };
        brief.execute(job, &CancellationToken::new()).await;
    } else {
        ingests.execute(job, &CancellationToken::new()).await;
        assert!(!*ingests.taken.borrow(), "the seat is free");
    }
    serving.abort();
    let received = received.lock().unwrap();
    received.clone()
}

fn program(dir: &Path, script: &str) -> PathBuf {
    let program = dir.join("child");
    std::fs::write(&program, format!("#!/bin/sh\n{REPORT}{script}\n")).unwrap();
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o700)).unwrap();
    program
}

const STROKES: &str =
    r#"{"until": "masks", "strokes": [{"part": "object", "camera": 0, "points": [[1, 2]]}]}"#;

#[tokio::test]
async fn a_child_gets_what_was_added_and_its_masks_are_delivered() {
    let script = r#"cd "$2"; cat capture.zip > playback
        cat supplement-masks supplement-calibration masks-before.zip > masks.zip
        echo '{"masked":{"verdict":"usable"}}'"#;
    let Received { end, parts, failed, .. } = run(lease(STROKES), script).await;
    assert_eq!(failed, None);
    assert!(end.masks_only && end.fault.is_none() && end.observation_digest.is_empty());
    assert_eq!(end.verdict, "usable");
    let expected: [(&str, &[u8]); 4] = [
        ("playback", b"archive"),
        ("masks", b"added poses before"),
        ("report", b"{}"),
        ("page", b"<p>"),
    ];
    assert_eq!(parts, expected.map(|(part, content)| (part, content.to_vec())).into());
    assert_eq!(
        [end.playback_digest, end.masks_digest],
        [digest(b"archive"), digest(b"added poses before")]
    );
}

#[tokio::test]
async fn without_strokes_earlier_masks_are_not_fetched() {
    let script = r#"cd "$2"; test -e masks-before.zip && exit 3
        printf seen > observation.zip; printf played > playback
        echo '{"observed":{"verdict":"good"}}'"#;
    let received = run(lease("{}"), script).await;
    let Received { end, parts, downloads, .. } = received;
    assert!(!end.masks_only && end.masks_digest.is_empty(), "{end:?}");
    assert_eq!(end.observation_digest, digest(b"seen"));
    assert_eq!((parts["observation"].as_slice(), parts.len()), (&b"seen"[..], 4));
    assert!(
        !downloads.iter().any(|name| name.ends_with("/masks") && !name.contains("supplements"))
    );
    assert_eq!(downloads.len(), 3, "{downloads:?}");
}

#[tokio::test]
async fn a_refused_recording_is_shown_and_one_that_was_cut_short_is_not() {
    let refused = r#"cd "$2"; printf images > playback
        echo '{"refused":{"verdict":"unusable","fault":{"category":"INVALID_ARGUMENT","reason":"NOT_CALIBRATED","message":"m"}}}'"#;
    let Received { end, parts, .. } = run(lease("{}"), refused).await;
    assert_eq!(end.fault.unwrap().reason, "NOT_CALIBRATED");
    assert_eq!((parts["playback"].as_slice(), parts.len()), (&b"images"[..], 3));
    // A link would lead the worker to its own files.
    let linked = refused.replace("printf images > playback", "ln -s /etc/hostname playback");
    let Received { end, failed, .. } = run(lease("{}"), &linked).await;
    assert_eq!((end, failed.unwrap().fault.unwrap().reason), {
        (IngestWrite::default(), "INGEST_RESULT_LOST".to_owned())
    });
    let exceeded = r#"cd "$2"; printf half > playback; printf half > masks.zip
        echo memory allocation of 9 bytes failed >&2; kill -ABRT $$"#;
    let Received { end, parts, .. } = run(lease(STROKES), exceeded).await;
    assert_eq!(end.fault.unwrap().reason, "INGEST_OUT_OF_MEMORY");
    let mut parts: Vec<_> = parts.into_keys().collect();
    parts.sort_unstable();
    assert_eq!(parts, ["page", "report"]);
}

#[tokio::test]
async fn a_supplement_that_a_worker_does_not_know_is_not_left_out() {
    let mut newer = lease("{}");
    newer.supplements.push(LeasedSupplement { kind: "mesh".to_owned(), digest: String::new() });
    let received = run(newer, "exit 0").await;
    assert_eq!(received.failed.unwrap().fault.unwrap().reason, "SUPPLEMENT_UNKNOWN");
}

/// How the attempt at a brief job ended.
async fn end_of_brief(script: &str, longest: Duration) -> Received {
    run_for(Lease { brief: true, ..lease("{}") }, script, longest).await
}

#[tokio::test]
async fn a_brief_ingest_that_takes_long_is_handed_back() {
    let ended = |received: &Received| received.failed.as_ref().map(|failed| failed.end());
    let soon = Duration::from_millis(200);
    // Nothing is delivered, and the child ends.
    let long = end_of_brief("exec sleep 600", soon).await;
    assert_eq!((ended(&long), long.end), (Some(End::Outgrown), IngestWrite::default()));
    // The second seat has less memory than the first.
    let large = r#"cd "$2"; echo memory allocation of 9 bytes failed >&2; kill -ABRT $$"#;
    let large = end_of_brief(large, Duration::from_secs(60)).await;
    assert_eq!((ended(&large), large.end), (Some(End::Outgrown), IngestWrite::default()));
    let refused = r#"cd "$2"
        echo '{"refused":{"verdict":"unusable","fault":{"category":"RESOURCE_EXHAUSTED","reason":"TOO_LARGE","message":"m"}}}'"#;
    let refused = end_of_brief(refused, Duration::from_secs(60)).await;
    assert_eq!(ended(&refused), Some(End::Outgrown));
    // What ends in time ends as usual.
    let brief = r#"cd "$2"; grep -q '"memory_bytes":268435456' request.json || exit 3
        echo '{"refused":{"verdict":"unusable","fault":{"category":"INVALID_ARGUMENT","reason":"NOT_CALIBRATED","message":"m"}}}'"#;
    let brief = end_of_brief(brief, Duration::from_secs(60)).await;
    assert_eq!((ended(&brief), brief.end.fault.unwrap().reason), (None, "NOT_CALIBRATED".into()));
}

#[tokio::test]
async fn the_second_seat_is_open_while_the_first_is_taken() {
    let first = Ingests {
        dir: PathBuf::new(),
        program: PathBuf::new(),
        memory_bytes: 0,
        time: Duration::ZERO,
        sandbox: Sandbox::BestEffort,
        delivery_timeout: Duration::ZERO,
        taken: watch::Sender::new(false),
    };
    let brief = BriefIngests { first: first.clone(), time: Duration::ZERO };
    let mut open = std::pin::pin!(brief.until_open());
    assert!(futures::poll!(open.as_mut()).is_pending());
    first.taken.send_replace(true);
    open.await;
    drop(Taken(&first.taken));
    assert!(futures::poll!(std::pin::pin!(brief.until_open())).is_pending());
}
