//! Fits a capture and prints its quality table, without a server:
//!
//! ```sh
//! cargo run --release -p bendtwin-fit --example fit_capture -- made:rope
//! cargo run --release -p bendtwin-fit --example fit_capture -- capture.zip settings.json picture.png
//! ```
//!
//! `made:rope` and the other made scenes are generated; anything else is a path. Settings not named
//! in the file keep their defaults; without a file (or with `-`), the axial-only model is fitted
//! beside the twin.

use std::{path::Path, time::Instant};

use bendtwin_capture::{Limits, digest};
use bendtwin_core::{
    CancelToken, Capture, FitSettings, Observer, Progress, Stage, Twin, quality::Predictor,
};
use bendtwin_eval::{
    TableStyle, Trajectory, format_table,
    picture::{Model, Picture},
    predict, predictor_name,
};
use bendtwin_fit::{FitJob, Outcome};
use bendtwin_synth::{MakeOptions, Scene, make};

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let mut arguments = std::env::args().skip(1);
    let source = arguments.next().ok_or("usage: fit_capture CAPTURE [SETTINGS.json]")?;
    let settings = match arguments.next() {
        Some(path) if path != "-" => serde_json::from_slice(&std::fs::read(path)?)?,
        _ => FitSettings { compare_axial: true, ..FitSettings::default() },
    };
    let capture = load(&source)?;
    let capture_digest = digest(&capture);
    let backend = bendtwin_engine::cpu();
    let job = FitJob { capture: &capture, capture_digest, settings, backend, look: None };
    let began = Instant::now();
    let outcome = job.run(None, &mut Printer(began), &CancelToken::default())?;
    let graph = &outcome.twin.graph;
    println!(
        "{} nodes, {} springs, {} triplets, {} substeps a frame, {:.1} s",
        graph.node_count(),
        graph.springs.len(),
        graph.triplets.len(),
        outcome.twin.timing.substeps,
        began.elapsed().as_secs_f64()
    );
    print!("{}", format_table(&outcome.twin.quality, TableStyle::Plain));
    if let Some(path) = arguments.next() {
        std::fs::write(path, picture(&capture, &outcome)?)?;
    }
    Ok(())
}

fn load(source: &str) -> Result<Capture, Failure> {
    match source.strip_prefix("made:") {
        Some(name) => {
            let scene = Scene::from_name(name)
                .ok_or_else(|| format!("made: {}", Scene::ALL.map(Scene::name).join(", ")))?;
            Ok(make(scene, &MakeOptions::full(0))?)
        }
        None => Ok(bendtwin_capture::read(Path::new(source), &Limits::default())?),
    }
}

/// The last sequence, as the twin and the axial-only model predict it.
fn picture(capture: &Capture, outcome: &Outcome) -> Result<Vec<u8>, Failure> {
    let backend = bendtwin_engine::cpu();
    let sequence = capture.sequences.len() - 1;
    let twins =
        [(Predictor::Bending, Some(&outcome.twin)), (Predictor::Axial, outcome.axial.as_ref())];
    let mut shown: Vec<(Predictor, &Twin, Trajectory)> = Vec::new();
    for (predictor, twin) in twins {
        let Some(twin) = twin else { continue };
        let all = predict(&*backend, twin, capture, &CancelToken::default())?;
        shown.extend(all.into_iter().nth(sequence).map(|t| (predictor, twin, t)));
    }
    let models: Vec<Model<'_>> = shown
        .iter()
        .map(|(predictor, twin, trajectory)| Model {
            name: predictor_name(*predictor),
            twin,
            trajectory,
        })
        .collect();
    Ok(Picture { capture, sequence, models: &models, columns: 4 }.to_png()?)
}

/// Prints every iteration.
struct Printer(Instant);

impl Observer<Progress> for Printer {
    fn progress(&mut self, p: Progress) {
        let number = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.4e}"));
        if p.stage == Stage::Evaluate {
            return;
        }
        println!(
            "{:6.1} s {:7} {:?} {}/{} loss {} best {} {}",
            self.0.elapsed().as_secs_f64(),
            p.variant,
            p.stage,
            p.iteration,
            p.iterations,
            number(p.loss),
            number(p.best_loss),
            p.note.unwrap_or_default()
        );
    }
}
