//! Reads captures with more and more points, frames and files up to the limits, and prints how long each takes,
//! report and playback included. Where four times as many take more than six times as long, a step
//! grows faster than n log n, and the line says so.
//!
//!     cargo run --release -p bendtwin-hostile --example crowds

use std::time::Instant;

use bendtwin_capture::Limits;
use bendtwin_core::{CancelToken, settings::ingest::IngestSettings};
use bendtwin_hostile::crowds::CROWDS;
use bendtwin_ingest::{Input, Played, ingest, write_playback};

/// Times below this are made up of other things than points [s].
const SHORT_S: f64 = 0.1;
/// Growth of the time from which a line is marked: that of n log n, and noise.
const STEEP: f64 = 6.0;

fn main() {
    let folder = tempfile::tempdir().expect("there is room for a folder");
    let settings = IngestSettings::default();
    println!("{:<40} {:>9} {:>10} {:>8}", "crowd", "n", "bytes", "s");
    for crowd in CROWDS {
        let mut before: Option<f64> = None;
        for n in [crowd.most / 64, crowd.most / 16, crowd.most / 4, crowd.most] {
            let archive = (crowd.make)(n);
            let path = folder.path().join("crowd.zip");
            std::fs::write(&path, &archive).expect("there is room for a capture");
            let start = Instant::now();
            let cancel = CancelToken::default();
            let input = Input::new(&path, "crowd");
            let read = ingest(input, &settings, &Limits::default(), &mut (), &cancel)
                .expect("nothing asks it to stop");
            let page = read.report.to_html();
            if let Ok(Some(capture)) = &read.capture {
                let playback = folder.path().join("playback");
                let played = Played {
                    name: "crowd",
                    capture: Some(capture),
                    recorded: &read.recorded,
                    doubt: &[],
                };
                write_playback(played, &playback, &mut |_| ())
                    .expect("there is room for a playback");
                std::fs::remove_file(playback).expect("it was written");
            }
            let took = start.elapsed().as_secs_f64();
            let is_steep = before.is_some_and(|before| before > SHORT_S && took > STEEP * before);
            let end = match &read.capture {
                Ok(_) => "read".to_owned(),
                Err(fault) => fault.reason.clone(),
            };
            println!(
                "{:<40} {n:>9} {:>10} {took:>8.2} {end}{}",
                crowd.what,
                archive.len(),
                if is_steep { ": STEEP" } else { "" }
            );
            assert!(!page.is_empty());
            before = Some(took);
        }
    }
}
