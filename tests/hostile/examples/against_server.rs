//! Sends hostile files to a real server and prints what became of it: deaths of processes, peak of
//! its memory, the slowest file. `tests/hostile/run` builds and runs it.
//!
//! One file at a time, so that each time belongs to one file: of ten files, seven are captures,
//! which are waited for until their ingest has ended, two are twins and one is a rollout request.

use std::{
    collections::{BTreeMap, BTreeSet},
    process::ExitCode,
    time::{Duration, Instant},
};

use bendtwin_harness::{Setup, TestCluster, cluster::START, http::Http, until};
use bendtwin_hostile::{Hostile, captures, rollouts, samples, twin_files, twins};
use reqwest::{Method, StatusCode};

/// Most memory of the server at any time.
const MOST_BYTES: u64 = 128 << 20;
/// Longest time for one file, from its first byte to the end of its ingest.
const LONGEST: Duration = Duration::from_secs(30);
/// Time after which a file is given up.
const GIVEN_UP: Duration = Duration::from_secs(120);

#[tokio::main]
async fn main() -> ExitCode {
    let (mut files, mut seed) = (500_usize, 0_u64);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let value = arguments.next().and_then(|value| value.parse().ok());
        match (argument.as_str(), value) {
            ("--files", Some(value)) => files = value as usize,
            ("--seed", Some(value)) => seed = value,
            _ => {
                eprintln!("usage: tests/hostile/run [--files N] [--seed N]");
                return ExitCode::FAILURE;
            }
        }
    }
    let summary = send(files, seed).await;
    print!("{}", summary.text());
    if summary.is_good() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Results of all files.
#[derive(Default)]
struct Summary {
    files: usize,
    seed: u64,
    /// The server and its workers.
    deaths: usize,
    /// Readers of captures that ended without a word.
    crashed: Vec<String>,
    /// Files without an end.
    lost: Vec<String>,
    peak_bytes: u64,
    /// Memory at the beginning and at the end.
    resident_bytes: [u64; 2],
    times: Vec<(Duration, String)>,
    /// Number of files by their outcome.
    outcomes: BTreeMap<String, usize>,
}

async fn send(files: usize, seed: u64) -> Summary {
    let mut server = TestCluster::start(Setup::default()).await;
    let http = server.http();
    let twin = import(&http, twin_files::encoded(&samples::twin())).await;
    let twin = twin.expect("the valid twin is imported");
    let memory = |field| status_bytes(server.pid(), field).unwrap_or_default();
    let mut summary = Summary { files, seed, ..Summary::default() };
    summary.resident_bytes[0] = memory("VmRSS:");
    let mut workers: BTreeSet<u32> = server.worker_pids().into_iter().collect();
    let (mut captures, mut twins, mut rollouts) = (captures(seed), twins(seed), rollouts(seed));
    for index in 0..files {
        let start = Instant::now();
        let (file, outcome) = match index % 10 {
            3 | 7 => {
                let file = twins.next().expect("there is no last one");
                let outcome = import(&http, file.bytes.clone()).await;
                (file, outcome.map_or_else(|reason| reason, |_| "imported".to_owned()))
            }
            9 => {
                let file = rollouts.next().expect("there is no last one");
                let outcome = roll_out(&http, &twin, &file).await;
                (file, outcome)
            }
            _ => {
                let file = captures.next().expect("there is no last one");
                let outcome = ingest(&http, &file).await;
                (file, outcome)
            }
        };
        summary.times.push((start.elapsed(), file.name.clone()));
        let name = format!("{} ({})", file.name, file.what);
        match outcome.as_str() {
            "INGEST_CRASHED" | "INGEST_OUT_OF_MEMORY" => {
                summary.crashed.push(format!("{name}: {outcome}"));
            }
            "no end" | "no answer" => summary.lost.push(format!("{name}: {outcome}")),
            _ => {}
        }
        *summary.outcomes.entry(outcome).or_default() += 1;
        summary.peak_bytes = summary.peak_bytes.max(memory("VmHWM:"));
        // A worker that died has been replaced by one of another id.
        let alive: BTreeSet<u32> = server.worker_pids().into_iter().collect();
        if !workers.is_subset(&alive) {
            summary.deaths += workers.difference(&alive).count();
            eprintln!("a worker ended: {name}");
            workers = until("a new worker", START, async || {
                Some(server.worker_pids()).filter(|pids| !pids.is_empty())
            })
            .await
            .into_iter()
            .collect();
        }
        if index % 50 == 49 {
            eprintln!("{} of {files} files", index + 1);
        }
    }
    summary.resident_bytes[1] = memory("VmRSS:");
    if !server.is_alive() {
        summary.deaths += 1;
        eprintln!("the server ended");
    }
    summary
}

/// Uploads a capture and waits for the end of its ingest; the outcome in a word.
async fn ingest(http: &Http, file: &Hostile) -> String {
    let request = http
        .request(Method::POST, "/v1/captures")
        .header("content-type", "application/octet-stream")
        .body(file.bytes.clone());
    let capture = match answer(request).await {
        Ok((StatusCode::CREATED, capture)) => capture,
        Ok((_, problem)) => return reason(&problem),
        Err(outcome) => return outcome,
    };
    let path = format!("/v1/{}", capture["name"].as_str().unwrap_or_default());
    let end = Instant::now() + GIVEN_UP;
    while Instant::now() < end {
        if let Ok((StatusCode::OK, capture)) = answer(http.request(Method::GET, &path)).await {
            let ingest = &capture["ingest"];
            match ingest["state"].as_str() {
                Some("SUCCEEDED") => return "read".to_owned(),
                Some("FAILED" | "CANCELLED") => return reason(&ingest["fault"]),
                _ => {}
            }
        }
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    "no end".to_owned()
}

/// Imports a twin: its name, or the reason for which it is refused.
async fn import(http: &Http, bytes: Vec<u8>) -> Result<String, String> {
    let request = http
        .request(Method::POST, "/v1/twins")
        .header("content-type", "application/octet-stream")
        .body(bytes);
    match answer(request).await? {
        (StatusCode::CREATED, twin) => Ok(twin["name"].as_str().unwrap_or_default().to_owned()),
        (_, problem) => Err(reason(&problem)),
    }
}

async fn roll_out(http: &Http, twin: &str, file: &Hostile) -> String {
    let request = http
        .request(Method::POST, &format!("/v1/{twin}/rollouts"))
        .header("content-type", "application/json")
        .body(file.bytes.clone());
    match answer(request).await {
        Ok((StatusCode::OK, _)) => "rolled out".to_owned(),
        Ok((_, problem)) => reason(&problem),
        Err(outcome) => outcome,
    }
}

type Request = reqwest::RequestBuilder;

async fn answer(request: Request) -> Result<(StatusCode, serde_json::Value), String> {
    let reply = request.send().await.map_err(|_| "no answer".to_owned())?;
    let status = reply.status();
    Ok((status, reply.json().await.unwrap_or_default()))
}

/// The reason of a fault.
fn reason(fault: &serde_json::Value) -> String {
    fault["reason"].as_str().unwrap_or("no reason").to_owned()
}

/// A field of a process's status.
fn status_bytes(pid: u32, field: &str) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
    let line = status.lines().find(|line| line.starts_with(field))?;
    let kilobytes: u64 = line.split_ascii_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024)
}

impl Summary {
    fn is_good(&self) -> bool {
        let fast = self.times.iter().all(|(time, _)| *time <= LONGEST);
        let alive = self.deaths == 0 && self.crashed.is_empty() && self.lost.is_empty();
        alive && fast && self.peak_bytes < MOST_BYTES
    }

    fn text(&self) -> String {
        let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
        let mut times = self.times.clone();
        times.sort();
        let (slowest, name) = times.last().cloned().unwrap_or_default();
        let median = times.get(times.len() / 2).map_or(Duration::ZERO, |(time, _)| *time);
        let [first, last] = self.resident_bytes.map(mib);
        let mut text = format!(
            "files: {} (seed {})\ndeaths of server and workers: {}\nreaders that crashed: {}\n\
             files without an end: {}\nserver: {first:.0} MiB, then {last:.0} MiB, {:.0} MiB at its peak\n\
             time of a file: median {:.2} s, at most {:.2} s ({name})\noutcomes:\n",
            self.files,
            self.seed,
            self.deaths,
            self.crashed.len(),
            self.lost.len(),
            mib(self.peak_bytes),
            median.as_secs_f64(),
            slowest.as_secs_f64(),
        );
        for line in self.crashed.iter().chain(&self.lost) {
            text.push_str(&format!("  ! {line}\n"));
        }
        for (outcome, count) in &self.outcomes {
            text.push_str(&format!("  {count:4} {outcome}\n"));
        }
        text.push_str(if self.is_good() { "good\n" } else { "NOT GOOD\n" });
        text
    }
}
