mod scene;

use bendtwin_capture::raw::{Recording, Region};
use bendtwin_core::{CancelToken, Problem};

use self::scene::Scene;
use crate::{CameraTracks, Error, FlowSettings, Guide, Texture, track};

fn settings() -> FlowSettings {
    FlowSettings { max_object_points: 60, ..FlowSettings::default() }
}

fn tracked(recording: &Recording) -> Vec<CameraTracks> {
    track(recording, &settings(), &mut |_, _| {}, &CancelToken::default()).unwrap()
}

/// Distances from where the points of the first camera should be [px], ascending.
fn misses(scene: &Scene, found: &CameraTracks, frame: usize) -> Vec<f64> {
    let camera = &scene.recording().cameras[0];
    let n = found.tracks.count;
    let mut misses: Vec<f64> = (0..found.quality.object_points)
        .filter(|i| found.tracks.visible[frame * n + i])
        .map(|i| {
            let at = found.tracks.points[frame * n + i].map(f64::from);
            let there = scene.moved(camera, found.tracks.points[i].map(f64::from), frame);
            (at[0] - there[0]).hypot(at[1] - there[1])
        })
        .collect();
    misses.sort_by(f64::total_cmp);
    misses
}

/// Most points are tracked to the end, nine of ten of them within `limit`.
fn assert_follows(scene: &Scene, share: f64, limit: f64) {
    let found = &tracked(&scene.recording())[0];
    let misses = misses(scene, found, scene.frames - 1);
    assert!(found.tracks.count > 30, "{}", found.quality.summary);
    let kept = misses.len() as f64 / found.tracks.count as f64;
    assert!(kept >= share, "only {kept:.2} of {} are left", found.tracks.count);
    let ninth = misses[misses.len() * 9 / 10];
    assert!(ninth < limit, "90 % are within {ninth:.3} px, not {limit}");
}

#[test]
fn follows_a_translation_to_a_twentieth_of_a_pixel() {
    // 0.37 px to the right and 0.21 px up per frame.
    let velocity = [0.37 * 0.5 / 150.0, -0.21 * 0.5 / 150.0, 0.0];
    assert_follows(&Scene { velocity, ..Scene::default() }, 0.95, 0.05);
}

#[test]
fn follows_fast_motion() {
    // 6 px per frame from rest.
    let velocity = [6.0 * 0.5 / 150.0, 0.0, 0.0];
    assert_follows(&Scene { velocity, frames: 5, ..Scene::default() }, 0.7, 0.1);
}

#[test]
fn follows_a_turn_in_the_image() {
    assert_follows(&Scene { spin: [0.0, 0.0, 0.15], ..Scene::default() }, 0.7, 0.15);
}

#[test]
fn follows_a_turn_out_of_the_image() {
    // To 48 degrees: patches shrink to two thirds of their width.
    assert_follows(&Scene { spin: [0.0, 0.12, 0.0], ..Scene::default() }, 0.6, 0.2);
}

#[test]
fn follows_an_approach() {
    // From 0.5 m to 0.36 m: patches grow by a third.
    assert_follows(&Scene { velocity: [0.0, 0.0, -0.02], ..Scene::default() }, 0.5, 0.15);
}

#[test]
fn is_indifferent_to_light() {
    let velocity = [0.001, 0.001, 0.0];
    assert_follows(&Scene { velocity, light: [0.6, 0.1], ..Scene::default() }, 0.9, 0.08);
}

#[test]
fn points_behind_a_hand_are_hidden_and_come_back() {
    fn hand(frame: usize) -> std::ops::Range<usize> {
        12 * frame..12 * frame + 20
    }
    let velocity = [0.0005, 0.0, 0.0];
    let scene = Scene { velocity, hand, frames: 12, ..Scene::default() };
    let found = &tracked(&scene.recording())[0];
    let n = found.tracks.count;
    // The object's come first.
    let points = found.quality.object_points;
    let mut hidden = 0;
    for frame in 0..scene.frames {
        for i in 0..points {
            let column = found.tracks.points[frame * n + i][0].round() as usize;
            if found.tracks.visible[frame * n + i] {
                assert!(
                    !hand(frame).contains(&column),
                    "frame {frame}: track {i} is behind the hand"
                );
            } else {
                hidden += 1;
            }
        }
        let misses = misses(&scene, found, frame);
        assert!(misses.last().is_some_and(|&m| m < 0.3), "frame {frame}: {misses:?}");
    }
    assert!(hidden > points / 2, "the hand passed in front of most points");
    let left = misses(&scene, found, scene.frames - 1).len();
    assert!(left * 10 > points * 9, "{left} of {points} are seen when the hand has gone");
}

#[test]
fn a_plain_manipulator_is_followed_by_its_shape() {
    let velocity = [0.003, 0.002, -0.002];
    let scene = Scene { ball: Some([[-0.02, 0.0, 0.38], velocity]), ..Scene::default() };
    let recording = scene.recording();
    let found = &tracked(&recording)[0];
    assert_eq!(found.quality.manipulator_guide, Some(Guide::Shape));
    assert!(found.quality.manipulator_points > 20);
    let n = found.tracks.count;
    let camera = &recording.cameras[0];
    let mut left = 0;
    for i in (0..n).filter(|&i| found.regions[i] == Region::Manipulator) {
        let k = (scene.frames - 1) * n + i;
        if !found.tracks.visible[k] {
            continue;
        }
        left += 1;
        let [start, end] = [i, k].map(|k| found.tracks.points[k].map(f64::from));
        let depth = scene.hit_ball(camera, start, 0).unwrap();
        let mut there = camera.unproject(start, depth, 0);
        for (c, v) in velocity.iter().enumerate() {
            there[c] += (v * (scene.frames - 1) as f64) as f32;
        }
        let (there, _) = camera.project(there, 0).unwrap();
        let miss = (there[0] - end[0]).hypot(there[1] - end[1]);
        assert!(miss < 0.5, "track {i} misses by {miss:.2} px");
    }
    assert!(left > 20, "{left} are left");
}

#[test]
fn what_jpeg_leaves_of_a_plain_manipulator_is_no_texture() {
    let ball = Some([[-0.02, 0.0, 0.2], [0.002, 0.001, 0.0]]);
    let scene = Scene { ball, blocks: 8.0, ..Scene::default() };
    let found = &tracked(&scene.recording())[0].quality;
    let texture = found.manipulator_texture.unwrap();
    assert!((2.0..8.0).contains(&texture), "{texture}");
    assert_eq!(found.manipulator_guide, Some(Guide::Shape), "{found:?}");
}

#[test]
fn a_lack_of_texture_is_reported() {
    let found = &tracked(&Scene { contrast: 0.0, ..Scene::default() }.recording())[0];
    assert_eq!(found.tracks.count, 0);
    assert_eq!(found.quality.verdict, Texture::None);
    assert!(found.quality.summary.contains("no texture"), "{}", found.quality.summary);
    assert_eq!(found.quality.object_texture, Some(0.0));
}

#[test]
fn texture_is_graded() {
    let verdict = |contrast| {
        let scene = Scene { contrast, velocity: [0.001, 0.0, 0.0], ..Scene::default() };
        tracked(&scene.recording())[0].quality.verdict
    };
    assert_eq!(verdict(1.0), Texture::Good);
    assert_eq!(verdict(0.2), Texture::Fair);
    assert!(matches!(verdict(0.03), Texture::Poor | Texture::None));
}

#[test]
fn missing_frames_are_bridged() {
    let velocity = [0.002, 0.0, 0.0];
    let scene = Scene { velocity, missing: vec![0, 3, 4], ..Scene::default() };
    let found = &tracked(&scene.recording())[0];
    assert_eq!(found.quality.object_survivors[0], 0);
    assert_eq!(found.quality.object_survivors[3], 0);
    assert!(found.quality.object_survivors[1] > 30);
    assert!(found.quality.object_survivors[7] > 30);
    assert_eq!(found.tracks.visible.len(), scene.frames * found.tracks.count);
}

#[test]
fn nothing_recorded_gives_nothing() {
    let scene = Scene { missing: (0..8).collect(), ..Scene::default() };
    let found = &tracked(&scene.recording())[0];
    assert_eq!(found.tracks.count, 0);
    assert_eq!(found.quality.object_survivors, vec![0; 8]);
}

#[test]
fn cameras_agree_with_each_other() {
    let velocity = [0.001, 0.0, 0.0];
    let others = vec![[0.05, 0.0, 0.0]];
    let scene = Scene { velocity, others, ..Scene::default() };
    let found = tracked(&scene.recording());
    assert!(found.iter().all(|c| c.quality.object_survivors[7] > 30));
    assert!(found.iter().all(|c| c.quality.contradicted_by.is_empty()));
}

#[test]
fn a_camera_that_stands_elsewhere_is_named_and_excluded() {
    let others = vec![[0.05, 0.0, 0.0]];
    let mut recording = Scene { others, ..Scene::default() }.recording();
    recording.cameras[1].poses[0].translation[1] += 0.08;
    let quality = &tracked(&recording)[0].quality;
    assert_eq!(quality.contradicted_by, [1]);
    assert!(quality.summary.contains("disagrees with camera 1"), "{}", quality.summary);
    assert!(quality.object_survivors[7] > 30);
}

#[test]
fn does_not_depend_on_the_number_of_threads() {
    let scene =
        Scene { spin: [0.02, 0.05, 0.03], velocity: [0.002, 0.001, 0.0], ..Scene::default() };
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| tracked(&scene.recording()))
    };
    assert!(with(1) == with(3));
}

#[test]
fn reports_progress_and_stops_when_asked() {
    let cancel = CancelToken::default();
    let mut frames = Vec::new();
    let mut progress = |done, all| {
        frames.push((done, all));
        if done == 2 {
            cancel.cancel();
        }
    };
    let stopped = track(&Scene::default().recording(), &settings(), &mut progress, &cancel);
    assert!(matches!(stopped, Err(Error::Cancelled)));
    assert_eq!(frames, [(1, 8), (2, 8)]);
}

#[test]
fn refuses_images_of_another_size() {
    let mut recording = Scene::default().recording();
    recording.cameras[0].width += 1;
    let refused =
        track(&recording, &settings(), &mut |_, _| {}, &CancelToken::default()).unwrap_err();
    assert_eq!(refused.reason(), "IMAGE_SIZE_MISMATCH");
    assert!(refused.to_string().contains("`camera 0`, frame 0"), "{refused}");
}

#[test]
fn refuses_settings_that_make_no_sense() {
    let settings = FlowSettings { window_px: 8, levels: 0, min_texture: f64::NAN, ..settings() };
    let faults = settings.validate().unwrap_err();
    assert_eq!(faults.len(), 3, "{faults:?}");
    let recording = Scene::default().recording();
    let refused = track(&recording, &settings, &mut |_, _| {}, &CancelToken::default());
    assert!(matches!(refused, Err(Error::Settings(_))));
}
