//! The estimate of a fit's memory beside the memory that a fit takes. In a separate process: the
//! system reports only the peak of a whole process.
#![cfg(target_os = "linux")]

use std::sync::Arc;

use bendtwin_core::{
    CancelToken, Capture, Environment, FitSettings, Sequence,
    capture::Object,
    settings::{Substeps, memory::GENERATION_BYTES},
};
use bendtwin_engine::Backend;
use bendtwin_fit::{FitJob, memory};

/// Nodes along an edge of the plate, their distance [m], and frames.
const EDGE: usize = 24;
const SPACING_M: f32 = 0.01;
const FRAMES: usize = 5;

/// A plate that one control point carries along.
fn plate() -> Capture {
    let at = |frame: usize| {
        (0..EDGE * EDGE).map(move |i| {
            let [x, y] = [i % EDGE, i / EDGE].map(|i| i as f32 * SPACING_M);
            [x + 1e-3 * frame as f32, y, 0.5]
        })
    };
    let points: Vec<_> = (0..FRAMES).flat_map(at).collect();
    let controls = (0..FRAMES).filter_map(|frame| at(frame).next()).collect();
    Capture {
        name: "plate".into(),
        fps: 30.0,
        environment: Environment::Z_UP,
        source_to_world: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        object: Object { point_count: EDGE * EDGE, ..Object::default() },
        others: Vec::new(),
        sequences: vec![Sequence {
            name: "carried".into(),
            frame_count: FRAMES,
            train_frame_count: FRAMES - 1,
            visible: vec![true; points.len()],
            motion_valid: vec![true; points.len()],
            points,
            controls,
            truth_tracks: Vec::new(),
            start_frames: 1,
        }],
    }
}

fn settings() -> FitSettings {
    let mut settings = FitSettings::default();
    settings.graph.max_nodes = Some(EDGE * EDGE);
    settings.graph.radius_m = Some(0.05);
    settings.graph.max_neighbours = Some(64);
    settings.graph.max_triplets = 15;
    settings.substeps = Substeps::Auto { safety: 1.1, max: Some(1_000) };
    settings.search.generations = Some(1);
    settings.search.population = Some(48);
    settings.search.starts = Some(3);
    settings.refine.passes = Some(2);
    settings
}

/// The most memory that this process has had [bytes].
fn peak() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    let kib: u64 = line.trim().trim_end_matches("kB").trim().parse().unwrap();
    kib << 10
}

#[test]
fn a_fit_takes_no_more_than_estimated_and_not_far_less() {
    let (capture, settings) = (plate(), settings());
    let backend: Arc<dyn Backend> = bendtwin_engine::cpu_with_threads(2);
    let estimated = memory::check(&capture, None, &settings, &*backend, u64::MAX).unwrap();
    let before = peak();
    let job =
        FitJob { capture: &capture, capture_digest: String::new(), settings, backend, look: None };
    let twin = job.run(None, &mut (), &CancelToken::default()).unwrap().twin;
    assert!(twin.graph.springs.len() > 10_000, "{}", twin.graph.springs.len());
    let taken = peak();
    assert!(taken - before > 32 << 20, "{before} then {taken}: the fit is too small to tell");
    assert!(taken <= estimated, "{taken} bytes were taken, {estimated} estimated");
    assert!(estimated <= 6 * taken, "{taken} bytes were taken, {estimated} estimated");
}

#[test]
fn what_would_take_all_memory_is_refused_before_it_begins() {
    let capture = plate();
    let backend = bendtwin_engine::cpu_with_threads(2);
    let mut greedy = settings();
    greedy.graph.max_neighbours = Some(256);
    greedy.search.starts = Some(64);
    greedy.search.topology = true;
    let most = 1 << 30;
    let refused = memory::check(&capture, None, &greedy, &*backend, most).unwrap_err();
    assert!(refused.needed > most && refused.most == most);
    let starts = refused.advice.iter().find(|(name, _)| *name == "search.starts").unwrap().1;
    greedy.search.starts = Some(starts as u32);
    assert!(memory::check(&capture, None, &greedy, &*backend, most).unwrap() <= most);
    // Neighbours that the radius does not have are not counted.
    let mut generous = settings();
    generous.graph.max_neighbours = Some(256);
    generous.graph.radius_m = Some(0.015);
    let bound = memory::estimate(&capture, None, &generous, &*backend);
    let built = memory::check(&capture, None, &generous, &*backend, bound - 1).unwrap();
    assert!(2 * built < bound, "{built} of {bound}");
    // Nor is a population beyond what is loaded at a time.
    generous.search.population = Some(10_000);
    assert!(memory::estimate(&capture, None, &generous, &*backend) < bound + GENERATION_BYTES);
}
