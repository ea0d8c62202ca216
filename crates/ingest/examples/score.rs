//! Lifts a raw recording and says how near its tracks are to the clean ones; for a capture that is lifted already, says that
//! of it. `cargo run --release -p bendtwin-ingest --example score -- PATH [--observation OUT.zip] [--settings JSON]`

use std::{path::PathBuf, time::Instant};

use bendtwin_capture::{Limits, raw, write_bundle_file};
use bendtwin_core::{Capture, settings::ingest::IngestSettings};
use bendtwin_ingest::{CancelToken, Observer, ObserverError, Progress, ingest, score};

type Failure = Box<dyn std::error::Error>;

/// What the command line asks for.
#[derive(Default)]
struct Request {
    path: PathBuf,
    lifted: bool,
    observation: Option<PathBuf>,
    settings: IngestSettings,
}

/// Says how far it is.
struct Console;

impl Observer for Console {
    fn progress(&mut self, progress: Progress) {
        eprint!("\r{:?} {:.0} %   ", progress.step, 100.0 * progress.fraction);
    }

    fn checkpoint(&mut self, _checkpoint: Vec<u8>) -> Result<(), ObserverError> {
        Ok(())
    }
}

fn main() -> Result<(), Failure> {
    let request = request()?;
    let limits = Limits::default();
    let capture = if request.lifted {
        bendtwin_capture::read(&request.path, &limits)?
    } else {
        let recording = raw::open(&request.path, &limits)?;
        let start = Instant::now();
        let lifted =
            ingest(&recording, &request.settings, None, &mut Console, &CancelToken::default())?;
        eprintln!("\nlifted in {:.1} s", start.elapsed().as_secs_f64());
        println!("{}", serde_json::to_string_pretty(&lifted.evidence)?);
        lifted.capture
    };
    told(&capture)?;
    if let Some(out) = &request.observation {
        write_bundle_file(&capture, out)?;
    }
    Ok(())
}

fn told(capture: &Capture) -> Result<(), Failure> {
    println!(
        "{} tracked points, {} completed on the surface, {} inside, {} control points",
        capture.object.point_count,
        capture.object.completed_surface.len(),
        capture.object.interior.len(),
        capture.sequences.first().map_or(0, |s| s.control_count())
    );
    match capture.sequences.first().and_then(score) {
        Some(score) => println!("{}", serde_json::to_string_pretty(&score)?),
        None => println!("there are no clean tracks to compare with"),
    }
    Ok(())
}

fn request() -> Result<Request, Failure> {
    let mut request = Request::default();
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--lifted" => request.lifted = true,
            "--observation" => request.observation = Some(value()?.into()),
            "--settings" => request.settings = serde_json::from_str(&value()?)?,
            _ => request.path = argument.into(),
        }
    }
    Ok(request)
}
