use bendtwin_synth::{MakeOptions, Scene, make};

use super::*;

#[test]
fn a_tracked_cable_needs_no_chamfer_distance() {
    let capture = make(Scene::Cable, &MakeOptions::tiny(3)).unwrap();
    let settings = FitSettings::default();
    let task = Task::new(&capture, &settings, DeviceKind::Cpu, &CancelToken::default()).unwrap();
    let terms = task.training.iter().flat_map(|t| t.objective.terms.iter());
    let is_track = |t: &WeightedTerm| matches!(t.term, Term::Track { .. });
    assert!(terms.clone().count() > 0 && terms.clone().all(is_track));
    // Every point of a cable is a node.
    assert!(
        task.skin
            .is_nodes(&connect(&task.sample, &Connectivity::from_settings(&settings.graph, false)))
    );
    let pinned: Vec<u32> = task.sample.pins.iter().map(|p| p.node).collect();
    for term in terms {
        let Term::Track { points, .. } = &term.term else { continue };
        assert!(points.iter().all(|n| !pinned.contains(n)), "held nodes cannot be wrong");
    }
}

#[test]
fn the_future_is_never_read() {
    let capture = make(Scene::Rope, &MakeOptions::tiny(3)).unwrap();
    let mut blind = capture.clone();
    let train_frames = blind.sequences[0].train_frame_count;
    let first = train_frames * capture.object.point_count;
    blind.sequences[0].points[first..].fill([9.0; 3]);
    let settings = FitSettings::default();
    let (a, b) = (
        Task::new(&capture, &settings, DeviceKind::Cpu, &CancelToken::default()).unwrap(),
        Task::new(&blind, &settings, DeviceKind::Cpu, &CancelToken::default()).unwrap(),
    );
    assert_eq!(a.training[0].objective, b.training[0].objective);
    assert_eq!(a.training[0].frames, train_frames - 1);
}

#[test]
fn windows_cover_the_whole_once() {
    let capture = make(Scene::Rope, &MakeOptions::tiny(3)).unwrap();
    let settings = FitSettings::default();
    let task = Task::new(&capture, &settings, DeviceKind::Cpu, &CancelToken::default()).unwrap();
    let whole = &task.training[0];
    let mut terms = 0;
    for first in (0..whole.frames).step_by(4) {
        let count = (whole.frames - first).min(4);
        let window = whole.window(first, count);
        assert!(window.terms.iter().all(|t| t.frame >= 1 && t.frame <= count));
        terms += window.terms.len();
    }
    assert_eq!(terms, whole.objective.terms.len());
}

#[test]
fn the_search_takes_fewer_sequences_and_frames() {
    let capture = make(Scene::Cable, &MakeOptions::tiny(3)).unwrap();
    let mut settings = FitSettings::default();
    settings.search.max_sequences = 2;
    settings.search.max_frames = 5;
    settings.loss.acceleration_weight = 0.01;
    let task = Task::new(&capture, &settings, DeviceKind::Cpu, &CancelToken::default()).unwrap();
    let set = task.search_set();
    assert_eq!(set.len(), 2.min(task.training.len()));
    for t in set {
        assert_eq!(t.frames, 5);
        assert!(t.objective.terms.iter().any(|t| t.term == Term::Acceleration));
        assert!(t.objective.terms.is_sorted_by_key(|t| t.frame));
    }
}

#[test]
fn nothing_to_train_on_is_said() {
    let mut capture = make(Scene::Rope, &MakeOptions::tiny(3)).unwrap();
    capture.sequences[0].train_frame_count = 0;
    let error =
        Task::new(&capture, &FitSettings::default(), DeviceKind::Cpu, &CancelToken::default())
            .err()
            .unwrap();
    assert!(matches!(error, Error::Capture(_)), "{error}");
}

/// Settings that are left open depend on the capture; others are obeyed.
#[test]
fn cables_are_fitted_in_their_own_way() {
    let open = FitSettings::default();
    let mut said = open.clone();
    said.search.starts = Some(2);
    said.search.generations = Some(7);
    said.search.gravity = Some(false);
    said.loss.sequences = Some(SequenceMean::Arithmetic);
    let of = |scene, settings: &FitSettings| {
        let capture = make(scene, &MakeOptions::tiny(1)).unwrap();
        let task = Task::new(&capture, settings, DeviceKind::Cpu, &CancelToken::default()).unwrap();
        let rods = task.has_rods(&Connectivity::from_settings(&settings.graph, true));
        (
            task.settings.search.start_count(),
            task.generations(),
            task.searches_gravity(),
            task.sequence_mean(),
            rods,
        )
    };
    assert_eq!(of(Scene::Rope, &open), (2, 12, false, SequenceMean::Arithmetic, false));
    assert_eq!(of(Scene::Cable, &open), (3, 60, true, SequenceMean::Geometric, true));
    assert_eq!(of(Scene::Cable, &said), (2, 7, false, SequenceMean::Arithmetic, true));
    said.graph.twist = false;
    assert!(!of(Scene::Cable, &said).4);
    // With a known mass, gravity is what the scale of forces comes from.
    let mut capture = make(Scene::Cable, &MakeOptions::tiny(1)).unwrap();
    capture.object.mass_kg = Some(0.04);
    let task = Task::new(&capture, &open, DeviceKind::Cpu, &CancelToken::default()).unwrap();
    assert!(!task.searches_gravity());
}

#[test]
fn a_refined_twin_keeps_its_contact() {
    let timing = bendtwin_core::Timing { fps: 30.0, substeps: 1 };
    let mut twin = Twin::new(Default::default(), Default::default(), timing);
    for touches in [false, true] {
        (twin.params.contact.skin, twin.params.contact.within_object) = (touches, touches);
        let given = FitSettings {
            skin_contact: Some(!touches),
            self_contact: !touches,
            ..FitSettings::default()
        };
        let settings = refining(given, &twin);
        assert_eq!((settings.skin_contact, settings.self_contact), (Some(touches), touches));
    }
}
