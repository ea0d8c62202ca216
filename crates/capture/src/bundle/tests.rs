use std::io::Cursor;

use bendtwin_core::{Capture, Plane};
use bendtwin_synth::{MakeOptions, Scene, make};

use super::*;
use crate::{Limits, digest, read::read_bytes};

fn round_trip(capture: &Capture) -> Capture {
    let bytes = write_bundle(capture, Cursor::new(Vec::new())).unwrap().into_inner();
    read_bytes("upload", &bytes, &Limits::default()).unwrap()
}

#[test]
fn captures_survive_the_bundle_unchanged() {
    for scene in Scene::ALL {
        let capture = make(scene, &MakeOptions::tiny(3)).unwrap();
        let back = round_trip(&capture);
        assert_eq!(back, capture);
        assert_eq!(digest(&back), digest(&capture));
    }
}

#[test]
fn nothing_is_lost_where_nothing_is_default() {
    let mut capture = make(Scene::Rope, &MakeOptions::tiny(3)).unwrap();
    capture.environment.ground = Some(Plane { normal: [0.0, 0.6, 0.8], offset_m: -0.25 });
    capture.environment.gravity = [0.0, -1.0, -9.5];
    capture.source_to_world = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
    capture.fps = 29.97;
    capture.object.rest_points = capture.sequences[0].points_at(0).to_vec();
    let sequence = &mut capture.sequences[0];
    sequence.start_frames = 2;
    sequence.motion_valid[50] = !sequence.motion_valid[50];
    assert_eq!(round_trip(&capture), capture);
    capture.environment.ground = None;
    assert_eq!(round_trip(&capture), capture);
}

#[test]
fn equal_captures_give_equal_bytes() {
    let capture = make(Scene::Cable, &MakeOptions::tiny(3)).unwrap();
    let write = || write_bundle(&capture, Cursor::new(Vec::new())).unwrap().into_inner();
    assert_eq!(write(), write());
}

#[test]
fn other_units_and_axes_are_converted() {
    let capture = make(Scene::Rope, &MakeOptions::tiny(3)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    // The same recording in millimetres with y up: x, y, z of the world are x, -z, y of the source.
    let mut source = capture.clone();
    let turn = |p: &mut [f32; 3]| *p = [p[0] * 1000.0, p[2] * 1000.0, -p[1] * 1000.0];
    source.object.completed_surface.iter_mut().for_each(turn);
    source.object.interior.iter_mut().for_each(turn);
    let sequence = &mut source.sequences[0];
    for points in [&mut sequence.points, &mut sequence.controls, &mut sequence.truth_tracks] {
        points.iter_mut().for_each(turn);
    }
    let path = folder.path().join("c.zip");
    write_bundle_file(&source, &path).unwrap();
    let mut files = crate::check::testing::unpack(&std::fs::read(&path).unwrap());
    files.insert(
        "capture.json".into(),
        br#"{"format": "bendtwin-capture", "version": 1, "units": "mm", "up_axis": "+y",
            "handedness": "right", "fps": 30, "ground": {"normal": [0, 2, 0], "offset": 0},
            "sequences": [{"train_frame_count": 17}]}"#
            .to_vec(),
    );
    let back = read_bytes("c", &crate::check::testing::pack(&files), &Limits::default()).unwrap();
    assert_eq!(back.environment, capture.environment);
    for (a, b) in back.sequences[0].points.iter().zip(&capture.sequences[0].points) {
        assert!((0..3).all(|i| (a[i] - b[i]).abs() < 1e-6));
    }
}
