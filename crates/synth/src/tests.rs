use bendtwin_core::Sequence;

use super::*;
use bendtwin_capture::{check, digest};

#[test]
fn tiny_scenes_are_usable_and_repeat_exactly() {
    for scene in Scene::ALL {
        let capture = make(scene, &MakeOptions::tiny(7)).unwrap();
        let report = check(&capture);
        assert!(report.findings.is_empty(), "{}: {:?}", scene.name(), report.findings);
        assert_eq!(make(scene, &MakeOptions::tiny(7)).unwrap(), capture);
        let other = make(scene, &MakeOptions::tiny(8)).unwrap();
        assert_ne!(digest(&other), digest(&capture));
    }
}

#[test]
fn the_rope_keeps_moving_after_the_split() {
    let capture = make(Scene::Rope, &MakeOptions::tiny(1)).unwrap();
    let sequence = &capture.sequences[0];
    let (last, split) = (sequence.frame_count - 1, sequence.train_frame_count);
    assert!(split > 2 && split < last);
    let moved = sequence.truth_at(split - 1).iter().zip(sequence.truth_at(last));
    let mean = moved.map(|(a, b)| pose::norm(pose::sub(*a, *b))).sum::<f32>()
        / sequence.truth_count() as f32;
    assert!(mean > 0.05, "mean motion in the future is {mean} m");
}

#[test]
fn bodies_are_hidden_in_part_and_tracks_are_noisy() {
    let capture = make(Scene::Toy, &MakeOptions::tiny(1)).unwrap();
    let sequence = &capture.sequences[0];
    assert!(sequence.visible_at(0).iter().all(|v| *v), "tracks start on what is seen");
    let seen = sequence.visible.iter().filter(|v| **v).count();
    assert!(seen < sequence.visible.len(), "a hand and a body hide nothing");
    assert!(!capture.object.completed_surface.is_empty() && !capture.object.interior.is_empty());
}

#[test]
fn the_cable_has_held_out_sequences_and_pins() {
    let capture = make(Scene::Cable, &MakeOptions::tiny(1)).unwrap();
    assert_eq!(capture.object.pins.len(), 4);
    assert!(capture.sequences.iter().any(Sequence::is_held_out));
    assert!(capture.sequences.iter().any(|s| !s.is_held_out()));
    for sequence in &capture.sequences {
        for frame in 0..sequence.frame_count {
            for pin in &capture.object.pins {
                let point = sequence.points_at(frame)[pin.point as usize];
                assert_eq!(point, sequence.controls_at(frame)[pin.control as usize]);
            }
        }
    }
}

#[test]
fn takes_are_recordings_of_the_same_body() {
    for scene in [Scene::Toy, Scene::Bar] {
        let takes = (0..4).map(|take| {
            let options = MakeOptions { take, ..MakeOptions::tiny(3) };
            make(scene, &options).unwrap()
        });
        let takes: Vec<Capture> = takes.collect();
        for (n, take) in takes.iter().enumerate() {
            let report = check(take);
            assert!(report.findings.is_empty(), "{} {n}: {:?}", scene.name(), report.findings);
            let s = &take.sequences[0];
            let travel = |f: usize| {
                let pairs = s.truth_at(0).iter().zip(s.truth_at(f));
                pairs.map(|(a, b)| pose::norm(pose::sub(*a, *b))).sum::<f32>()
                    / s.truth_count() as f32
            };
            assert!(travel(s.frame_count - 1) > 0.08, "{} {n} hardly moves", scene.name());
            // The same points of the same body, wherever it lies.
            let apart = |c: &Capture| {
                let truth = c.sequences[0].truth_at(0);
                pose::norm(pose::sub(truth[0], truth[5]))
            };
            assert!((apart(take) - apart(&takes[0])).abs() < 1e-5);
        }
        assert_ne!(takes[1].sequences[0].controls, takes[2].sequences[0].controls);
    }
}

/// A body that is held at one end and lifted hangs the farther down the softer it is.
#[test]
fn materials_differ_in_how_they_hang() {
    let hung = |material| {
        let options = MakeOptions { material, ..MakeOptions::tiny(3) };
        let capture = make(Scene::Bar, &options).unwrap();
        let report = check(&capture);
        assert!(report.findings.is_empty(), "{material:?}: {:?}", report.findings);
        let sequence = &capture.sequences[0];
        let last = sequence.truth_at(sequence.frame_count - 1);
        let height = last.iter().map(|p| p[2]).sum::<f32>() / last.len() as f32;
        (capture.name, height)
    };
    let [foam, plush, rubber, cord] = Substance::ALL.map(hung);
    assert_eq!([&foam.0, &plush.0], ["bar", "bar_plush"]);
    let stiffer = cord.1.min(rubber.1);
    assert!(plush.1 < foam.1 && foam.1 < stiffer, "{plush:?} {foam:?} {cord:?} {rubber:?}");
}

#[test]
fn names_are_stable() {
    for substance in Substance::ALL {
        assert_eq!(Substance::from_name(substance.name()), Some(substance));
    }
    assert_eq!(Substance::from_name("stone"), None);
    for scene in Scene::ALL {
        assert_eq!(Scene::from_name(scene.name()), Some(scene));
    }
    assert_eq!(Scene::from_name("cloth"), None);
}
