//! Three recordings of an object against one: the error of their twins on a fourth that neither saw.
//!
//! `cargo run --release -p bendtwin-fit --example recordings -- [scene] [nodes] [seeds]`: a scene of
//! `bendtwin capture make` (toy), the number of nodes (60) and how many seeds of noise to repeat it
//! with (2).

use std::{sync::Arc, time::Instant};

use bendtwin_capture::digest;
use bendtwin_core::{CancelToken, Capture, FitSettings, Quality, quality::Predictor};
use bendtwin_engine::Backend;
use bendtwin_fit::FitJob;
use bendtwin_synth::{MakeOptions, Scene, make};

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, default| arguments.get(i).map_or(Ok(default), |a| a.parse::<usize>());
    let name = arguments.first().map_or("toy", String::as_str);
    let scene = Scene::from_name(name).ok_or("there is no such scene")?;
    let (nodes, seeds) = (number(1, 60)?, number(2, 2)?);
    let backend: Arc<dyn Backend> = bendtwin_engine::cpu();
    let (mut one, mut three) = (0.0, 0.0);
    println!("mm on the fourth recording: track, Chamfer distance; standing still; time");
    for seed in 0..seeds as u64 {
        let takes: Vec<Capture> = (0..4).map(|n| take(scene, seed, n)).collect::<Result<_, _>>()?;
        let unseen = &takes[3];
        for count in [1, 3] {
            let began = Instant::now();
            let quality = fit(&takes[..count], unseen, nodes, seed, &backend)?;
            let own = quality.scores.first().ok_or("the twin was not scored")?.future;
            let still = quality.score(Predictor::StandingStill).and_then(|s| s.future.track_m);
            let track_m = own.track_m.ok_or("the recording has no true tracks")?;
            println!(
                "seed {seed}, {count} recordings: {:6.2} {:6.2} {:6.1} {:5.0} s",
                1e3 * track_m,
                1e3 * own.chamfer_l1_m.unwrap_or(f64::NAN),
                1e3 * still.unwrap_or(f64::NAN),
                began.elapsed().as_secs_f64()
            );
            *(if count == 1 { &mut one } else { &mut three }) += track_m / seeds as f64;
        }
    }
    println!("mean track error: {:.2} mm of one, {:.2} mm of three", 1e3 * one, 1e3 * three);
    println!("three recordings predict it {:.0} % better", 100.0 * (1.0 - three / one));
    Ok(())
}

/// A recording, all of which may be fitted.
fn take(scene: Scene, seed: u64, take: u32) -> Result<Capture, Failure> {
    let options = MakeOptions { take, ..MakeOptions::full(10 * seed + u64::from(take)) };
    let mut capture = make(scene, &options)?;
    capture.name = format!("take {take}");
    capture.sequences.iter_mut().for_each(|s| s.train_frame_count = s.frame_count);
    Ok(capture)
}

/// The quality table, on another recording, of a twin that was fitted to these.
fn fit(
    recordings: &[Capture],
    unseen: &Capture,
    nodes: usize,
    seed: u64,
    backend: &Arc<dyn Backend>,
) -> Result<Quality, Failure> {
    let (reference, others) = recordings.split_first().ok_or("there is no recording")?;
    let capture = Capture { others: others.to_vec(), ..reference.clone() };
    let mut settings = FitSettings { seed, compare_axial: false, ..FitSettings::default() };
    settings.graph.max_nodes = Some(nodes);
    settings.search.starts = Some(1);
    let job = FitJob {
        capture: &capture,
        capture_digest: digest(&capture),
        settings,
        backend: backend.clone(),
        look: None,
    };
    let twin = job.run(None, &mut (), &CancelToken::default())?.twin;
    let options = bendtwin_eval::EvaluateOptions::default();
    Ok(bendtwin_eval::evaluate(&**backend, &twin, unseen, &options, &CancelToken::default())?)
}
