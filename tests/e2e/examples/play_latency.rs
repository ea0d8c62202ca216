//! Time from an input to the state that has it, over the WebSocket of a play, beside watchers.
//!
//! `cargo run --release -p bendtwin-e2e --example play_latency -- URL TWIN [SECONDS] [WATCHERS] [PID]`
//!
//! Inputs come 60 times a second, as those of a browser; PID is that of the server, whose time and
//! memory are measured.

use std::time::{Duration, Instant};

use bendtwin_harness::play::{Event, Play};
use serde_json::json;

/// Ticks a second of Linux's clock for processes.
const TICKS: f64 = 100.0;

#[tokio::main]
async fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |at: usize, default: f64| {
        arguments.get(at).map_or(default, |text| text.parse().expect("a number"))
    };
    let [url, twin, ..] = &arguments[..] else {
        eprintln!("give the address of a server without a token, and a twin");
        std::process::exit(2);
    };
    let (seconds, watchers, pid) =
        (number(2, 20.0), number(3, 0.0) as usize, number(4, 0.0) as u32);
    let mut play = Play::begin(url, twin, json!({"type": "begin"})).await;
    let path = play.ready["watch"].as_str().unwrap().to_owned();
    for _ in 0..watchers {
        let mut watcher = Play::watch(url, &path).await;
        tokio::spawn(async move { while !matches!(watcher.next().await, Event::Closed) {} });
    }
    let first = play.shown("a state", |_| true).await;
    let from: [f32; 3] = std::array::from_fn(|i| first.grippers[0][i]);
    let before = usage(pid);
    let began = Instant::now();
    // By input, from 1 on.
    let mut sent: Vec<Instant> = Vec::new();
    let (mut seen, mut frames) = (0usize, 0u32);
    let mut times_ms: Vec<f64> = Vec::new();
    let mut ticks = tokio::time::interval(Duration::from_micros(16_667));
    while began.elapsed().as_secs_f64() < seconds {
        tokio::select! {
            _ = ticks.tick() => {
                let phase = began.elapsed().as_secs_f64() * 3.0;
                let target = [from[0] + 0.08 * phase.sin() as f32, from[1], from[2] + 0.05];
                sent.push(Instant::now());
                play.aim(sent.len() as u32, 0, target).await;
            }
            event = play.next() => if let Event::Shown(shown) = event {
                frames += 1;
                // Each input until this one is seen for the first time.
                let until = (shown.input as usize).min(sent.len());
                let new = sent.get(seen..until).unwrap_or_default();
                times_ms.extend(new.iter().map(|at| 1e3 * at.elapsed().as_secs_f64()));
                seen = seen.max(until);
            }
        }
    }
    let elapsed = began.elapsed().as_secs_f64();
    times_ms.sort_by(f64::total_cmp);
    let share = |share: f64| times_ms[((times_ms.len() - 1) as f64 * share) as usize];
    println!(
        "{} nodes, {} inputs, {:.1} states a second: p50 {:.1} ms, p95 {:.1} ms, worst {:.1} ms; at the worker {} ms a frame, {} skipped",
        first.nodes.len(),
        times_ms.len(),
        f64::from(frames) / elapsed,
        share(0.5),
        share(0.95),
        share(1.0),
        play.facts["frame_ms"],
        play.facts["skipped"],
    );
    if let (Some((cpu_before, _)), Some((cpu, resident))) = (before, usage(pid)) {
        println!(
            "{watchers} watchers: the server takes {:.1} % of a core and {resident:.1} MiB",
            100.0 * (cpu - cpu_before) / elapsed
        );
    }
}

/// Processor time [s] and resident memory [MiB] of a process.
fn usage(pid: u32) -> Option<(f64, f64)> {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    let time = |at: usize| fields.get(at).and_then(|text| text.parse::<f64>().ok());
    let pages = fields.get(21)?.parse::<f64>().ok()?;
    Some(((time(11)? + time(12)?) / TICKS, pages * 4096.0 / f64::from(1 << 20)))
}
