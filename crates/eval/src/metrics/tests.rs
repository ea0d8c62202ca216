use super::*;
use crate::{baselines::standing_still, scene};

/// The inner points of a chain that is lifted by 3 cm a frame stay behind.
fn errors(frames: usize, train: usize) -> PredictorErrors {
    let capture = scene::chain(4, frames, train, [0.0, 0.0, 0.03]);
    let (graph, sequence) = (scene::chain_graph(4), &capture.sequences[0]);
    let start = sequence.points_at(0);
    let mut errors = PredictorErrors::default();
    let reference = Reference::new(&capture, sequence, &Surface::of_nodes(&graph), start);
    errors.add(&reference, &standing_still(&graph, sequence, start));
    errors
}

fn close(a: Option<f64>, b: f64) -> bool {
    a.is_some_and(|a| (a - b).abs() < 1e-6)
}

#[test]
fn a_sequence_is_split_into_training_and_future() {
    // Two of four points are wrong by 3 cm times the frame. Frames 1 and 2 train, 3 and 4 are the
    // future.
    let errors = errors(5, 3);
    let (train, future) = (errors.train.summary(), errors.future.summary());
    assert!(close(train.track_m, 0.5 * 0.03 * 1.5), "{train:?}");
    assert!(close(future.track_m, 0.5 * 0.03 * 3.5), "{future:?}");
    // Split, so the coordinate sum is divided by the frames that it has.
    assert!(close(train.coordinate_m, 0.5 * 0.01 * 1.5), "{train:?}");
    assert_eq!(errors.per_frame().len(), 4);
    assert!(close(errors.per_frame()[3].track_m, 0.5 * 0.12));
}

#[test]
fn a_whole_sequence_counts_as_in_deforms_metric() {
    // Summed over predicted frames 1..=4, divided by all 5.
    let errors = errors(5, 0);
    assert_eq!(errors.train.summary(), ErrorSummary::default());
    let future = errors.future.summary();
    assert!(close(future.coordinate_m, 0.5 * 0.01 * (1.0 + 2.0 + 3.0 + 4.0) / 5.0), "{future:?}");
    assert!(close(future.track_m, 0.5 * 0.03 * 2.5));
}

#[test]
fn branches_are_filled_up_to_the_longest_as_in_defts_metric() {
    // Trunk 0 to 3, whose ends are points 0 and 3; point 4 hangs on point 1. Held are 0 and 4.
    let mut capture = scene::chain(5, 5, 0, [0.0, 0.0, 0.03]);
    capture.object.edges[3] = [1, 4];
    let (graph, sequence) = (scene::chain_graph(5), &capture.sequences[0]);
    let start = sequence.points_at(0);
    let mut errors = PredictorErrors::default();
    let reference = Reference::new(&capture, sequence, &Surface::of_nodes(&graph), start);
    errors.add(&reference, &standing_still(&graph, sequence, start));
    // Two branches of four places: point 1 counts in both of them, 2 and 3 once, two places are
    // filling.
    let of_frame = |f: f64| 4.0 * (0.03 * f).powi(2) / (3.0 * 8.0);
    assert!(close(errors.per_frame()[1].padded_rms_m, of_frame(2.0).sqrt()));
    let mean = (1..5).map(|f| of_frame(f64::from(f))).sum::<f64>() / 5.0;
    assert!(close(errors.future.summary().padded_rms_m, mean.sqrt()));
    let chain = scene::chain(5, 5, 0, [0.0, 0.0, 0.03]);
    let of_chain = Reference::new(&chain, &chain.sequences[0], &Surface::of_nodes(&graph), start);
    assert_eq!(of_chain.measure(1, start).padded_rms_m, None);
}

#[test]
fn tracks_belong_to_the_surface_node_nearest_at_the_start() {
    let mut capture = scene::chain(3, 2, 2, [0.0; 3]);
    capture.object.edges.clear();
    capture.object.pins.clear();
    // One track beside node 1, one unknown at the start, one that gets lost.
    let sequence = &mut capture.sequences[0];
    let nan = [f32::NAN; 3];
    let near = [0.11, 0.0, 1.0];
    sequence.truth_tracks = vec![near, nan, near, [0.11, 0.02, 1.0], near, nan];
    let graph = scene::chain_graph(3);
    let start = capture.sequences[0].points_at(0);
    let reference =
        Reference::new(&capture, &capture.sequences[0], &Surface::of_nodes(&graph), start);
    let error = reference.measure(1, start);
    assert!(close(error.track_m, f64::hypot(0.01, 0.02)), "{error:?}");
    assert_eq!(error.coordinate_m, None);
}

#[test]
fn hidden_points_and_interior_nodes_do_not_count() {
    let mut capture = scene::chain(3, 2, 2, [0.0, 0.0, 0.01]);
    capture.object.pins.clear();
    capture.object.edges.clear();
    let mut graph = scene::chain_graph(3);
    graph.kinds[2] = bendtwin_core::NodeKind::Interior;
    capture.sequences[0].visible = vec![true, true, true, false, false, true];
    let sequence = &capture.sequences[0];
    let start = sequence.points_at(0);
    let error =
        Reference::new(&capture, sequence, &Surface::of_nodes(&graph), start).measure(1, start);
    // Point 2 has moved up by a centimetre; its own node is interior, node 1 is 10 cm away.
    assert!(close(error.chamfer_l1_m, 0.11), "{error:?}");
    assert!(close(error.chamfer_l2_m, f64::hypot(0.1, 0.01)), "{error:?}");
}
