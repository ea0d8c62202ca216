//! Ingests of captures, each in a separate process, which may die, be killed or run out of memory
//! without harm to anything else.

use std::time::Duration;

use bendtwin_proto::v1::{Capture, GetCaptureRequest, job::State};
use bytes::Bytes;
use flate2::{Compression, write::GzEncoder};
use reqwest::{Method, StatusCode};
use serde_json::{Value, json};

use super::broken_captures::{pack, unpack};
use crate::harness::{
    Api, Setup, TestCluster,
    api::has_ended,
    command::{run, run_json, run_ok},
    process::{kill, signal},
    reference::{FIT, SETTINGS, capture},
    until,
};

/// Longest time for reading a small capture on a busy machine.
const SOON: Duration = Duration::from_secs(120);

#[tokio::test]
async fn a_recording_of_cameras_becomes_a_report_and_a_twin_by_command_line() {
    let server = TestCluster::ordinary().await;
    let (url, recording) = (server.url(), server.path("toy_raw.zip"));
    let (page, observation) = (server.path("report.html"), server.path("observation.zip"));
    let (settings, twin) = (server.path("settings.json"), server.path("toy.twin"));
    let document = server.path("report.json");
    std::fs::write(&settings, SETTINGS).unwrap();
    let (capture, twin) = tokio::task::spawn_blocking(move || {
        let at = ["--server", url.as_str()];
        run_ok(&["capture", "make", "toy", &recording, "--tiny", "--raw"]);
        let pushed = run_json(&[&["capture", "push", &recording, "--watch"], &at[..]].concat());
        let name = pushed["name"].as_str().unwrap().to_owned();
        assert_eq!(pushed["ingest"]["state"], "SUCCEEDED", "{pushed}");
        let files = ["--html", &page, "--document", &document, "--observation", &observation];
        run_ok(&[&["capture", "report", &name], &files[..], &at[..]].concat());
        let report: Value = serde_json::from_slice(&std::fs::read(&document).unwrap()).unwrap();
        assert_eq!(report["verdict"], pushed["verdict"]);
        assert!(report["findings"].is_array(), "{report}");
        let page = std::fs::read_to_string(&page).unwrap();
        assert!(page.contains("<html") && !page.contains("<script"));
        let shown = run_ok(&[&["capture", "show", &name], &at[..]].concat());
        assert!(shown.contains(report["verdict"].as_str().unwrap()), "{shown}");
        // What is fitted is a capture like any other.
        run_ok(&["capture", "check", &observation]);
        let fit = run_json(
            &[&["fit", "start", &name, "--settings", &settings, "--watch"], &at[..]].concat(),
        );
        let fitted = fit["twin"].as_str().unwrap();
        run_ok(&[&["twin", "export", fitted, &twin], &at[..]].concat());
        let file = std::fs::read(&twin).unwrap();
        assert!(bendtwin_core::Twin::decode(&file).unwrap().graph.node_count() > 0);
        (name, fitted.to_owned())
    })
    .await
    .unwrap();
    it_can_be_played(&server, &capture, &twin).await;
}

/// The capture has a playback with images, and the twin a prediction of the same frames.
async fn it_can_be_played(server: &TestCluster, capture: &str, twin: &str) {
    let http = server.http();
    let playback = http.get(&format!("/v1/{capture}/playback")).await.bytes().await.unwrap();
    let length = u32::from_le_bytes(playback[12..16].try_into().unwrap()) as usize;
    let head: Value = serde_json::from_slice(&playback[16..16 + length]).unwrap();
    let sequence = &head["sequences"][0];
    let images = &sequence["cameras"][0]["images"];
    let first = 16 + length + images["bytes"][0].as_u64().unwrap() as usize;
    assert!(playback[first..].starts_with(&[0xff, 0xd8]), "{images}");
    let asked = json!({"capture": capture, "motion": {"sequence": 0}});
    let path = format!("/v1/{twin}/evaluations");
    let answer = http.request(Method::POST, &path).json(&asked).send().await.unwrap();
    let evaluated: Value = answer.json().await.unwrap();
    let motion = &evaluated["motion"];
    assert_eq!(motion["train_frame_count"], sequence["train_frame_count"], "{motion}");
    let frames = sequence["frame_count"].as_u64().unwrap() as usize;
    assert_eq!(motion["positions"].as_array().unwrap().len(), frames);
    assert!(motion["track_m"][frames - 1].as_f64().unwrap() > 0.0);
    let beyond = json!({"capture": capture, "motion": {"sequence": 1}});
    let refused = http.request(Method::POST, &path).json(&beyond).send().await.unwrap();
    assert_eq!(refused.status(), StatusCode::BAD_REQUEST);
}

/// An archive is recognized by its content, in any way of sending it; of a folder the command sends
/// the files that are read.
#[tokio::test]
async fn tar_archives_and_folders_are_read_as_zip_is() {
    let server = TestCluster::ordinary().await;
    let api = server.api();
    let (url, case, packed) = (server.url(), server.path("toy"), server.path("toy.tgz"));
    let (archive, pushed) = tokio::task::spawn_blocking(move || {
        run_ok(&["capture", "make", "toy", &case, "--tiny", "--raw"]);
        let mut tar = tar::Builder::new(GzEncoder::new(Vec::new(), Compression::fast()));
        tar.append_dir_all("different_types/toy", &case).unwrap();
        let archive = tar.into_inner().unwrap().finish().unwrap();
        std::fs::write(&packed, &archive).unwrap();
        let clouds = std::path::Path::new(&case).join("pcd");
        std::fs::create_dir(&clouds).unwrap();
        std::fs::write(clouds.join("0.npz"), vec![7; 16 << 20]).unwrap();
        let push = |path: &str| run_json(&["capture", "push", path, "--watch", "--server", &url]);
        (archive, [push(&packed), push(&case)])
    })
    .await
    .unwrap();
    for pushed in &pushed {
        assert_eq!(pushed["ingest"]["state"], "SUCCEEDED", "{pushed}");
    }
    let sizes = pushed.map(|pushed| pushed["size_bytes"].as_u64().unwrap());
    assert!(sizes.iter().all(|size| *size < 8 << 20), "{sizes:?}");
    let stored = api.upload_as(&Bytes::from(archive), "by gRPC", "tar").await.unwrap();
    let ingest = ingested(&api, &stored.name).await.ingest.unwrap();
    assert_eq!(ingest.state(), State::Succeeded, "{ingest:?}");
}

#[tokio::test]
async fn killed_readers_and_workers_are_survived() {
    let server = TestCluster::ordinary().await;
    let api = server.api();
    let archive = long(&server, "300").await;
    let stored = api.upload(&archive, "").await.unwrap();
    let fit = api.fit(&stored.name, SETTINGS, 0).await.unwrap();
    let reader = reader_pid(&server).await;
    kill(reader);
    until("the worker to notice", SOON, async || {
        let ingest = get_capture(&api, &stored.name).await?.ingest?;
        ingest.attempt_faults.iter().any(|f| f.reason == "INGEST_CRASHED").then_some(())
    })
    .await;
    let second = reader_pid(&server).await;
    assert_ne!(second, reader);
    server.kill_workers();
    // It notices its worker's end by itself.
    until("the reader to end with its worker", SOON, async || {
        (!server.reader_pids().contains(&second)).then_some(())
    })
    .await;
    let ended = ingested(&api, &stored.name).await;
    let ingest = ended.ingest.unwrap();
    assert_eq!(ingest.state(), State::Succeeded, "{ingest:?}");
    let reasons: Vec<_> = ingest.attempt_faults.iter().map(|f| f.reason.as_str()).collect();
    assert_eq!(reasons, ["INGEST_CRASHED", "WORKER_LOST"]);
    api.succeeded(&fit.name, FIT).await;
}

/// A stopped reader holds the first seat and another one the second: captures that come later are read
/// nevertheless.
#[tokio::test]
async fn captures_that_take_long_let_small_ones_pass() {
    let setup = Setup { worker_args: &["--ingest-brief-s", "15"], ..Setup::default() };
    let server = TestCluster::start(setup).await;
    let api = server.api();
    let (small, long) = (capture().await, long(&server, "60").await);
    let stop_next = async |before: &[u32]| {
        until("another capture to be read", SOON, async || {
            let new = server.reader_pids().into_iter().find(|pid| !before.contains(pid))?;
            signal(new, "STOP");
            Some(new)
        })
        .await
    };
    let state = async |name: &str| {
        let ingest = get_capture(&api, name).await.and_then(|c| c.ingest).unwrap();
        (ingest.state(), ingest.attempts)
    };
    let first = api.upload(&long, "first").await.unwrap();
    let first_reader = stop_next(&[]).await;
    let second = api.upload(&long, "second").await.unwrap();
    let second_reader = stop_next(&[first_reader]).await;
    let third = api.upload(&small, "third").await.unwrap();
    let third = ingested(&api, &third.name).await.ingest.unwrap();
    assert_eq!((third.state(), third.attempts), (State::Succeeded, 1), "{third:?}");
    assert_eq!(state(&first.name).await, (State::Running, 1));
    // Handed back, and not begun again beside the first.
    assert_eq!(state(&second.name).await, (State::Queued, 0));
    until("the second reader to end", SOON, async || {
        (!server.reader_pids().contains(&second_reader)).then_some(())
    })
    .await;
    signal(first_reader, "CONT");
    for name in [&first.name, &second.name] {
        let ingest = ingested(&api, name).await.ingest.unwrap();
        assert_eq!((ingest.state(), ingest.attempts), (State::Succeeded, 1), "{ingest:?}");
    }
}

#[tokio::test]
async fn a_capture_beyond_the_memory_fails_alone() {
    let setup = Setup { worker_args: &["--ingest-memory-mib", "64"], ..Setup::default() };
    let server = TestCluster::start(setup).await;
    let api = server.api();
    let workers = server.worker_pids();
    let large = api.upload(&large(&capture().await, 2000, 1000), "").await.unwrap();
    let fit = api.fit(&large.name, SETTINGS, 0).await.unwrap();
    let ingest = ingested(&api, &large.name).await.ingest.unwrap();
    let fault = ingest.fault.clone().unwrap_or_default();
    assert_eq!(ingest.state(), State::Failed, "{ingest:?}");
    assert_eq!((fault.reason.as_str(), ingest.attempts), ("INGEST_OUT_OF_MEMORY", 1));
    assert!(fault.message.contains("--ingest-memory-mib"), "{fault:?}");
    let fit = api.fit_when(&fit.name, "over", SOON, has_ended).await;
    assert_eq!((fit.state(), fit.job.unwrap().fault), (State::Failed, Some(fault)));
    // There is a report all the same.
    let report = server.http().get_json(&format!("/v1/{}/report", large.name)).await;
    assert_eq!(report["verdict"], "unusable");
    assert!(report.to_string().contains("INGEST_OUT_OF_MEMORY"), "{report}");
    // The worker is the same one, and reads the next capture.
    let small = api.upload(&capture().await, "").await.unwrap();
    assert_eq!(ingested(&api, &small.name).await.ingest.unwrap().state(), State::Succeeded);
    assert_eq!(server.worker_pids(), workers);
}

#[tokio::test]
async fn an_ingest_is_stopped_run_again_and_watched() {
    let server = TestCluster::ordinary().await;
    let (api, http) = (server.api(), server.http());
    let stored = api.upload(&capture().await, "").await.unwrap();
    let (path, first) = (format!("/v1/{}", stored.name), ingested(&api, &stored.name).await);
    let page = http.get(&format!("{path}/report.html")).await;
    assert!(page.headers()["content-security-policy"].to_str().unwrap().contains("sandbox"));
    let wrong = json!({"settings": {"spacing_m": -1.0}});
    let ask = async |body: &Value| {
        http.request(Method::POST, &format!("{path}/ingest")).json(body).send().await.unwrap()
    };
    assert_eq!(ask(&wrong).await.status(), StatusCode::BAD_REQUEST);
    assert_eq!(ask(&json!({})).await.status(), StatusCode::ACCEPTED);
    let again = ingested(&api, &stored.name).await;
    let revision = |c: &Capture| c.ingest.as_ref().map_or(0, |i| i.revision);
    assert!(revision(&again) > revision(&first));
    let (url, name) = (server.url(), stored.name.clone());
    tokio::task::spawn_blocking(move || {
        let at = ["--server", url.as_str()];
        run_ok(&[&["capture", "ingest", &name, "--watch"], &at[..]].concat());
        let none =
            run(&[&["capture", "ingest", &name, "--settings", "none.json"], &at[..]].concat());
        assert!(!none.status.success());
    })
    .await
    .unwrap();
}

/// A recording of cameras of that many frames, whose reading is long enough to be met at it.
async fn long(server: &TestCluster, frames: &'static str) -> Bytes {
    let path = server.path("raw.zip");
    let make = path.clone();
    tokio::task::spawn_blocking(move || {
        run_ok(&["capture", "make", "toy", &make, "--tiny", "--raw", "--frames", frames]);
    })
    .await
    .unwrap();
    Bytes::from(std::fs::read(&path).unwrap())
}

/// The capture with that many frames and points, all coordinates zero.
fn large(small: &Bytes, frames: usize, points: usize) -> Bytes {
    let mut files = unpack(small);
    files.retain(|name, _| name == "capture.json" || name.ends_with("control_points.npy"));
    let zeros = |width: usize| {
        let shape = format!("({frames}, {width}, 3)");
        let fields = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}");
        let header = format!("{fields:<117}\n");
        let length = u16::try_from(header.len()).unwrap().to_le_bytes();
        let zeros = vec![0; 12 * frames * width];
        [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), &zeros].concat()
    };
    for content in files.iter_mut().filter(|(name, _)| name.ends_with(".npy")).map(|(_, c)| c) {
        *content = zeros(1);
    }
    files.insert("object_points.npy".to_owned(), zeros(points));
    pack(&files)
}

/// Id of the process that reads a capture at the moment.
async fn reader_pid(server: &TestCluster) -> u32 {
    until("a capture to be read", SOON, async || server.reader_pids().first().copied()).await
}

async fn get_capture(api: &Api, name: &str) -> Option<Capture> {
    let request = GetCaptureRequest { name: name.to_owned() };
    Some(api.captures().get_capture(request).await.ok()?.into_inner())
}

/// A capture once its ingest has ended.
async fn ingested(api: &Api, name: &str) -> Capture {
    until(&format!("{name} to be read"), SOON, async || {
        let capture = get_capture(api, name).await?;
        let state = capture.ingest.as_ref()?.state();
        (!matches!(state, State::Queued | State::Running)).then_some(capture)
    })
    .await
}
