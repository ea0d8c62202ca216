use bendtwin_core::quality::{ErrorSummary, Score};

use super::*;

/// A twin with nodes 10 mm apart and 500 mm large.
const SCALE: Scale = Scale { spacing_m: 0.01, size_m: 0.5 };

fn score(predictor: Predictor, future: ErrorSummary) -> Score {
    let train = ErrorSummary { track_m: Some(0.002), ..ErrorSummary::default() };
    Score { predictor, train, future, per_frame: Vec::new(), at_nodes: None, rendered: None }
}

fn tracks(mm: f64) -> ErrorSummary {
    ErrorSummary { track_m: Some(1e-3 * mm), ..ErrorSummary::default() }
}

/// A table of track errors in future frames [mm].
fn table(twin: f64, still: f64, residual: f64) -> Quality {
    let scores = vec![
        score(Predictor::Bending, tracks(twin)),
        score(Predictor::StandingStill, tracks(still)),
        score(Predictor::LastResidual, tracks(residual)),
    ];
    Quality { scores, ..Quality::default() }
}

#[track_caller]
fn is(quality: &Quality, scale: Scale, level: Level, why: &str, next: &str) {
    let found = assess(quality, scale);
    assert_eq!(found.level, level, "{found}");
    assert!(found.why.contains(why), "{found}");
    assert!(found.next.contains(next), "{found}");
}

#[test]
fn a_twin_that_passes_all_comparisons_is_good() {
    is(&table(4.0, 100.0, 5.0), SCALE, Level::Good, "off by 4.0 mm: 25 times nearer", "Use it");
    is(&table(10.0, 100.0, 10.0), SCALE, Level::Good, "less than the 10.0 mm", "Use it");
    // A twin without error is nearer than anything.
    is(
        &table(0.0, 100.0, 0.1),
        SCALE,
        Level::Good,
        "0.0 % of the object's size (500 mm)",
        "Use it",
    );
}

#[test]
fn each_comparison_makes_a_good_twin_fair() {
    is(
        &table(4.0, 18.0, 5.0),
        SCALE,
        Level::Fair,
        "4.50 times nearer than standing",
        "short times",
    );
    let large_nodes = Scale { spacing_m: 0.05, ..SCALE };
    is(&table(20.0, 200.0, 30.0), large_nodes, Level::Fair, "4.0 % of", "`graph.max_nodes`");
    is(&table(12.0, 200.0, 30.0), SCALE, Level::Fair, "more than the 10.0 mm", "more nodes hardly");
    is(&table(20.0, 200.0, 30.0), SCALE, Level::Fair, "4.0 % of", "more nodes hardly");
    is(&table(8.0, 100.0, 4.0), SCALE, Level::Fair, "farther than with its last", "correct its");
}

#[test]
fn a_twin_that_does_not_follow_is_poor() {
    is(&table(4.0, 7.0, 5.0), SCALE, Level::Poor, "1.75 times nearer", "Do not plan");
    is(&table(9.0, 8.0, 10.0), SCALE, Level::Poor, "no nearer than standing still (8.0", "Do not");
    is(&table(60.0, 900.0, 70.0), SCALE, Level::Poor, "12.0 % of", "Do not plan");
    is(&table(f64::NAN, 900.0, 70.0), SCALE, Level::Poor, "NaN", "Do not plan");
}

#[test]
fn a_twin_that_misses_its_own_training_is_not_good() {
    let trained = |mm: f64| {
        let mut quality = table(4.0, 100.0, 5.0);
        quality.scores[0].train = tracks(mm);
        quality
    };
    is(&trained(2.0), SCALE, Level::Good, "2.00 times its error on the frames that it", "Use it");
    is(&trained(18.0), SCALE, Level::Fair, "0.22 times its error on the frames", "misses even");
    is(&trained(40.0), SCALE, Level::Poor, "(40.0 mm)", "misses even");
    let mut untrained = table(4.0, 100.0, 5.0);
    untrained.scores[0].train = ErrorSummary::default();
    assert!(!assess(&untrained, SCALE).why.contains("fitted to"));
}

#[test]
fn a_table_without_unseen_frames_is_unknown() {
    let mut quality = table(4.0, 100.0, 5.0);
    quality.scores.iter_mut().for_each(|s| s.future = ErrorSummary::default());
    is(&quality, SCALE, Level::Unknown, "saw the twin is off by 2.0 mm", "out of training");
    is(&Quality::default(), SCALE, Level::Unknown, "was not scored", "bendtwin eval");
}

#[test]
fn comparisons_without_data_are_left_out() {
    let mut quality = table(4.0, 100.0, 5.0);
    quality.scores.truncate(1);
    is(&quality, SCALE, Level::Good, "0.8 % of the object's size", "Use it");
    quality.scores[0].train = ErrorSummary::default();
    is(&quality, Scale::default(), Level::Unknown, "off by 4.0 mm.", "nothing to compare");
    is(&table(4.0, 7.0, 5.0), Scale::default(), Level::Poor, "1.75 times", "Do not plan");
    assert_eq!(Scale::of_nodes(&[], &[]), Scale::default());
}

#[test]
fn baselines_are_compared_by_the_same_measure() {
    let mut quality = table(4.0, 100.0, 5.0);
    let own = ErrorSummary { chamfer_l1_m: Some(0.004), ..ErrorSummary::default() };
    quality.scores[0].future = own;
    quality.scores[1].future.chamfer_l1_m = Some(0.005);
    is(&quality, SCALE, Level::Poor, "1.25 times nearer than standing still", "Do not plan");
}

#[test]
fn the_axial_fit_is_mentioned_without_deciding() {
    let mut quality = table(4.0, 100.0, 5.0);
    quality.scores.insert(1, score(Predictor::Axial, tracks(2.0)));
    is(&quality, SCALE, Level::Good, "2.00 times farther than without bending", "Use it");
    quality.scores[1].future = tracks(12.0);
    is(&quality, SCALE, Level::Good, "3.00 times nearer than without bending", "Use it");
}

/// The rope of the tutorial: 6.8 mm with bending, 6.3 without.
#[test]
fn what_seeds_differ_by_is_no_difference() {
    for axial_mm in [6.3, 7.4] {
        let mut quality = table(6.8, 100.0, 8.0);
        quality.scores.insert(1, score(Predictor::Axial, tracks(axial_mm)));
        let why = format!("no difference from a fit without bending ({axial_mm:.1} mm)");
        is(&quality, SCALE, Level::Good, &why, "Use it");
    }
    assert!(!differ([1.0, 1.15]) && differ([1.0, 1.16]) && differ([1.16, 1.0]));
    assert!(!differ([0.0, 0.0]) && differ([0.0, 1e-9]) && differ([f64::NAN, 1.0]));
}

#[test]
fn sizes_are_those_of_the_nodes() {
    let nodes: Vec<Point> =
        (0..1000).map(|i| [i % 10, i / 10 % 10, i / 100].map(|x| 0.02 * x as f32)).collect();
    let scale = Scale::of_nodes(&nodes, &[]);
    assert!((scale.size_m - 0.18 * 3.0_f64.sqrt()).abs() < 1e-6, "{scale:?}");
    assert!((0.02..0.025).contains(&scale.spacing_m), "{scale:?}");
}

/// The sixth neighbour of a cable's node is far along it.
#[test]
fn the_nodes_of_a_cable_are_as_far_apart_as_they_follow_one_another() {
    let nodes: Vec<Point> = (0..9).map(|i| [0.0866 * i as f32, 0.0, 0.0]).collect();
    let rods = [(0..9).collect::<Vec<u32>>()];
    let scale = Scale::of_nodes(&nodes, &rods);
    assert!((scale.spacing_m - 0.0866).abs() < 1e-6, "{scale:?}");
    assert!(Scale::of_nodes(&nodes, &[]).spacing_m > 0.3);
    // Rods of a reply that does not fit its nodes.
    assert!(Scale::of_nodes(&nodes, &[vec![7, 8, 9]]).spacing_m < 0.1);
}

#[test]
fn the_paragraph_begins_with_the_level() {
    let text = assess(&table(4.0, 100.0, 5.0), SCALE).to_string();
    assert!(text.starts_with("Verdict: good. On frames"), "{text}");
}
