//! Lifts a raw recording and says how near its tracks are to the clean ones:
//! `cargo run --release -p bendtwin-lift --example score -- RECORDING [--observation OUT.zip]
//! [--settings JSON]`
//!
//! With `--lifted` the path is a capture that is lifted already. With `--judged-by CAPTURE` what is
//! written has only the start and the control points of the recording, and what the capture
//! observed after that: `bendtwin eval OUT.zip --twin TWIN` then scores a twin of the one on what
//! the other saw. With `--film` a scene is filmed by 3 cameras of 848 x 480 over 100 frames and
//! written to the path, to be timed.

use std::{path::PathBuf, time::Instant};

use bendtwin_capture::{Limits, raw, write_bundle_file};
use bendtwin_core::{CancelToken, Capture, Observer, settings::ingest::IngestSettings};
use bendtwin_lift::{Progress, lift, score};
use bendtwin_synth::{FilmOptions, Scene, film};

type Failure = Box<dyn std::error::Error>;

/// The request of the command line.
#[derive(Default)]
struct Request {
    path: PathBuf,
    lifted: bool,
    film: bool,
    observation: Option<PathBuf>,
    judge: Option<PathBuf>,
    settings: IngestSettings,
}

/// Says how far it is.
struct Console;

impl Observer<Progress> for Console {
    fn progress(&mut self, progress: Progress) {
        eprint!("\r{:?} {:.0} %   ", progress.step, 100.0 * progress.fraction);
    }
}

fn main() -> Result<(), Failure> {
    let request = request()?;
    let limits = Limits::default();
    if request.film {
        let options = FilmOptions { frames: 100, size: [848, 480], ..FilmOptions::full(0) };
        return Ok(raw::write_bundle(&film(Scene::Toy, &options)?, &request.path)?);
    }
    let capture = if request.lifted {
        bendtwin_capture::read(&request.path, &limits)?
    } else {
        let recording = raw::open(&request.path, &limits)?;
        let start = Instant::now();
        let lifted =
            lift(&recording, &request.settings, None, &mut Console, &CancelToken::default())?;
        eprintln!("\nlifted in {:.1} s", start.elapsed().as_secs_f64());
        println!("{}", serde_json::to_string_pretty(&lifted.evidence)?);
        lifted.capture
    };
    print_score(&capture)?;
    let capture = match &request.judge {
        Some(path) => judged_by(capture, &bendtwin_capture::read(path, &limits)?)?,
        None => capture,
    };
    if let Some(out) = &request.observation {
        write_bundle_file(&capture, out)?;
    }
    Ok(())
}

/// The start and the control points of one capture, with what another one observed later: a twin of
/// the first is scored on it by what the second saw.
fn judged_by(mut own: Capture, other: &Capture) -> Result<Capture, Failure> {
    let (sequence, judge) = match (&mut own.sequences[..], &other.sequences[..]) {
        ([a], [b]) if a.frame_count == b.frame_count => (a, b),
        _ => return Err("both captures need one sequence, of the same length".into()),
    };
    let (mut points, mut visible) = (Vec::new(), Vec::new());
    for frame in 0..judge.frame_count {
        points.extend_from_slice(sequence.points_at(frame));
        points.extend_from_slice(judge.points_at(frame));
        visible.extend(sequence.visible_at(frame).iter().map(|v| *v && frame == 0));
        visible.extend(judge.visible_at(frame).iter().map(|v| *v && frame > 0));
    }
    sequence.motion_valid = vec![false; points.len()];
    (sequence.points, sequence.visible) = (points, visible);
    own.object.point_count += other.object.point_count;
    own.object.colors.clear();
    Ok(own)
}

fn print_score(capture: &Capture) -> Result<(), Failure> {
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
            "--film" => request.film = true,
            "--lifted" => request.lifted = true,
            "--observation" => request.observation = Some(value()?.into()),
            "--judged-by" => request.judge = Some(value()?.into()),
            "--settings" => request.settings = serde_json::from_str(&value()?)?,
            _ => request.path = argument.into(),
        }
    }
    Ok(request)
}
