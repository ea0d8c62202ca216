//! Hostile files, from the generator of `tests/hostile`: captures, twins and rollout requests.

use std::{
    sync::{Mutex, PoisonError},
    time::{Duration, Instant},
};

use bendtwin_hostile::{Hostile, captures, rollouts, twins};
use reqwest::StatusCode;
use serde_json::Value;
use tokio::time::sleep;

use super::{STRANGER, http};
use crate::{honest::Refusal, run::Run};

/// Longest time for the ingest of a hostile capture.
const INGEST: Duration = Duration::from_secs(120);

type Source = Mutex<Box<dyn Iterator<Item = Hostile> + Send>>;

/// The files of a seed.
pub(super) struct Files {
    captures: Source,
    twins: Source,
    rollouts: Source,
}

impl Files {
    pub(super) fn new(seed: u64) -> Self {
        Self {
            captures: Mutex::new(Box::new(captures(seed))),
            twins: Mutex::new(Box::new(twins(seed))),
            rollouts: Mutex::new(Box::new(rollouts(seed))),
        }
    }
}

fn next(source: &Source) -> Option<Hostile> {
    source.lock().unwrap_or_else(PoisonError::into_inner).next()
}

/// Sends the next file: of three, two are captures.
pub(super) async fn send_file(run: &Run, number: u64, files: &Files) -> anyhow::Result<()> {
    let (path, content_type, file) = match number % 6 {
        2 => (
            "/v1/twins?display_name=hostile".to_owned(),
            "application/octet-stream",
            next(&files.twins),
        ),
        5 => (format!("/v1/{}/rollouts", run.twin()), "application/json", next(&files.rollouts)),
        _ => (
            "/v1/captures?display_name=hostile".to_owned(),
            "application/zip",
            next(&files.captures),
        ),
    };
    let Some(file) = file else { return Ok(()) };
    let (what, began) = (format!("{} ({})", file.name, file.what), Instant::now());
    run.tally.log(format_args!("hostile: {what}"));
    let url = format!("{}{path}", run.system.url());
    let digest = blake3::hash(&file.bytes).to_hex().to_string();
    let request = http(STRANGER)?.post(url).header("content-type", content_type);
    let reply = request.body(file.bytes).send().await?;
    let status = reply.status();
    let body: Value = reply.json().await.unwrap_or_default();
    run.tally.count("faults: hostile files");
    run.tally.took("hostile files: longest wait for an answer", began.elapsed());
    if status == StatusCode::INTERNAL_SERVER_ERROR {
        run.tally
            .broken("no hostile file is answered with a defect", format_args!("{what}: {body}"));
    }
    let Some(name) = body["name"].as_str().filter(|_| status.is_success()) else { return Ok(()) };
    run.tally.count("hostile files: taken");
    if name.starts_with("twins/") {
        run.ledger.twin(name, &digest, true);
    } else {
        run.ledger.capture(name, &digest, true);
        ended(run, name, &what).await;
    }
    run.delete(name, false).await;
    Ok(())
}

/// Waits for the end of an ingest.
async fn ended(run: &Run, name: &str, what: &str) {
    let (api, began) = (run.http(), Instant::now());
    let path = format!("/v1/{name}");
    while began.elapsed() < INGEST {
        let capture = run.insist("a look at a capture", async || {
            let (_, body) = crate::honest::send(api.request(reqwest::Method::GET, &path)).await?;
            crate::load::json(&body)
        });
        let state = match capture.await {
            Some(Ok(capture)) => capture["ingest"]["state"].as_str().unwrap_or_default().to_owned(),
            Some(Err(Refusal::Final(reason, text))) => {
                run.tally
                    .broken("what was acknowledged is there", format_args!("{reason}: {text}"));
                return;
            }
            _ => return,
        };
        if !matches!(state.as_str(), "QUEUED" | "RUNNING") {
            run.tally.took("hostile files: longest until the ingest had ended", began.elapsed());
            return;
        }
        sleep(Duration::from_millis(200)).await;
    }
    run.tally
        .broken("the ingest of a hostile file ends", format_args!("{what}: not within {INGEST:?}"));
}
