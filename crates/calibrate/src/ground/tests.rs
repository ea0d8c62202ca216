use bendtwin_capture::raw::{Pose, Recording};
use bendtwin_synth::{FilmOptions, Scene, film};

use super::*;

fn toy() -> Recording {
    film(Scene::Toy, &FilmOptions { frames: 4, cameras: 3, ..FilmOptions::tiny(5) }).unwrap()
}

fn found(recording: &Recording) -> Ground {
    detect(recording, &CancelToken::default()).unwrap().unwrap()
}

/// The recording in another world.
fn moved(mut recording: Recording, motion: &Pose) -> Recording {
    for pose in recording.cameras.iter_mut().flat_map(|camera| &mut camera.poses) {
        *pose = motion.after(pose);
    }
    recording
}

#[test]
fn the_table_is_found_in_any_world() {
    let ground = found(&toy());
    assert!(ground.normal[2] > 0.9999, "{ground:?}");
    // The made table lies a millimetre below z = 0.
    assert!((ground.offset_m + 0.001).abs() < 0.001, "{ground:?}");
    assert!(ground.share > 0.5, "{ground:?}");
    let turned = Pose {
        rotation: [[0.0, -0.6, 0.8], [1.0, 0.0, 0.0], [0.0, 0.8, 0.6]],
        translation: [0.3, -2.0, 0.7],
    };
    let ground = found(&moved(toy(), &turned));
    assert!(ground.normal[0] > 0.79 && ground.normal[2] > 0.59, "{ground:?}");
}

#[test]
fn levelled_cameras_stand_on_the_ground() {
    let turned = Pose {
        rotation: [[0.0, -0.6, 0.8], [1.0, 0.0, 0.0], [0.0, 0.8, 0.6]],
        translation: [0.3, -2.0, 0.7],
    };
    let mut recording = moved(toy(), &turned);
    let ground = found(&recording);
    level(&recording, &ground, true).apply(&mut recording).unwrap();
    let again = found(&recording);
    assert!(again.normal[2] > 0.99999 && again.offset_m.abs() < 1e-4, "{again:?}");
    assert!(again.center[0].hypot(again.center[1]) < 0.01, "{again:?}");
    let truth = toy();
    for (camera, before) in recording.cameras.iter().zip(&truth.cameras) {
        let [height, true_height] = [camera, before].map(|c| c.pose(0).translation[2]);
        assert!((height - true_height).abs() < 0.003, "{height} {true_height}");
    }
}

#[test]
fn the_same_ground_is_found_every_time() {
    assert_eq!(found(&toy()), found(&toy()));
}

#[test]
fn without_poses_or_depth_there_is_none() {
    let mut recording = toy();
    recording.cameras.iter_mut().for_each(|camera| camera.poses.clear());
    assert_eq!(detect(&recording, &CancelToken::default()).unwrap(), None);
    // One camera is its own world.
    recording.cameras.truncate(1);
    let ground = found(&recording);
    assert!(ground.normal[1] < -0.5 && ground.normal[2] < 0.0, "{ground:?}");
}

#[test]
fn a_normal_is_turned_up_without_a_reflection() {
    for normal in [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.6, 0.0, -0.8], [0.0, -1.0, 0.0]] {
        let rotation = upright(normal);
        let up = turn(&rotation, normal);
        assert!((up[2] - 1.0).abs() < 1e-12, "{up:?}");
        let determinant = dot(rotation[0], cross(rotation[1], rotation[2]));
        assert!((determinant - 1.0).abs() < 1e-12, "{determinant}");
    }
}
