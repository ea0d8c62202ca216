use bendtwin_capture::raw::{Distortion, Gripper, Pad, Pose};
use bendtwin_core::{ObserverError, Problem, settings::ingest::IngestSettings};

use super::*;
use crate::{
    rigid::distance,
    score,
    testing::{TestScene, hand_middle, place, point},
};

fn run(scene: TestScene) -> Result<Observation, Error> {
    let recording = scene.recording();
    lift(&recording, &IngestSettings::default(), None, &mut (), &CancelToken::default())
}

/// An observer that keeps checkpoints, and fails after a given number.
struct CheckpointRecorder {
    kept: Vec<Vec<u8>>,
    most: usize,
    fractions: Vec<f64>,
}

impl CheckpointRecorder {
    fn new(most: usize) -> Self {
        Self { kept: Vec::new(), most, fractions: Vec::new() }
    }
}

impl Observer<Progress> for CheckpointRecorder {
    fn progress(&mut self, progress: Progress) {
        self.fractions.push(progress.fraction);
    }

    fn checkpoint(&mut self, checkpoint: Vec<u8>) -> Result<(), ObserverError> {
        if self.kept.len() == self.most {
            return Err("enough".into());
        }
        self.kept.push(checkpoint);
        Ok(())
    }
}

#[test]
fn a_ball_is_lifted_to_where_it_is() {
    let observation = run(TestScene::default()).unwrap();
    let sequence = &observation.capture.sequences[0];
    let score = score(sequence).unwrap();
    assert!(score.points > 400, "{score:?}");
    // Half a millimetre of rounding, and no point of the ball lies exactly where a clean track is.
    let surface: Vec<f64> = (0..sequence.frame_count)
        .flat_map(|f| {
            let middle = point(place(f, nalgebra::Vector3::zeros()));
            let pairs = sequence.points_at(f).iter().zip(sequence.visible_at(f));
            pairs
                .filter(|(_, v)| **v)
                .map(move |(p, _)| (distance(*p, middle) - crate::testing::BALL_M).abs())
                .collect::<Vec<_>>()
        })
        .collect();
    let mean = surface.iter().sum::<f64>() / surface.len() as f64;
    assert!(mean < 5e-4, "{mean}");
    let turned = (0..sequence.frame_count).map(|f| sequence.motion_valid_at(f));
    assert!(turned.skip(1).all(|v| v.iter().filter(|v| **v).count() > 300));
    bendtwin_capture::validate(&observation.capture).unwrap();
    assert_eq!(observation.capture.object.colors[0], [200.0 / 255.0, 100.0 / 255.0, 50.0 / 255.0]);
}

#[test]
fn the_hand_becomes_control_points_that_move_as_it_does() {
    let observation = run(TestScene::default()).unwrap();
    let sequence = &observation.capture.sequences[0];
    assert_eq!(sequence.control_count(), 30);
    let hand = &observation.evidence.hands[0];
    assert!(hand.rigid && hand.residual_m < 1e-3, "{hand:?}");
    for frame in 0..sequence.frame_count {
        let middle = point(place(frame, hand_middle()));
        for p in sequence.controls_at(frame) {
            let off = (distance(*p, middle) - crate::testing::HAND_M).abs();
            assert!(off < 2e-3, "{off}");
        }
    }
}

#[test]
fn a_camera_of_half_the_rate_helps_with_the_frames_that_it_has() {
    let frames = TestScene::default().frames;
    let missing: Vec<(usize, usize)> = (0..frames).filter(|f| f % 2 == 1).map(|f| (1, f)).collect();
    let whole = score(&run(TestScene::default()).unwrap().capture.sequences[0]).unwrap();
    let observation = run(TestScene { missing: missing.clone(), ..TestScene::default() }).unwrap();
    assert_eq!(observation.evidence.cameras[1].missing_frames, missing.len());
    let sequence = &observation.capture.sequences[0];
    let half = score(sequence).unwrap();
    // What only this camera sees is known in every second frame.
    assert!(half.points > whole.points * 3 / 4, "{half:?} {whole:?}");
    bendtwin_capture::validate(&observation.capture).unwrap();
    assert_eq!(sequence.frame_count, frames);
}

#[test]
fn distortion_moving_cameras_and_missing_frames_are_taken_into_account() {
    let wide = Distortion::BrownConrady([-0.2, 0.05, 1e-3, -1e-3, 0.0, 0.0, 0.0, 0.0]);
    let fisheye = Distortion::KannalaBrandt([0.05, -0.01, 0.0, 0.0]);
    for scene in [
        TestScene { distortion: wide, frames: 3, ..TestScene::default() },
        TestScene { distortion: fisheye, frames: 3, ..TestScene::default() },
        TestScene { moving: true, frames: 6, ..TestScene::default() },
        TestScene { missing: vec![(0, 3), (1, 3), (1, 4)], ..TestScene::default() },
        TestScene { cameras: 1, ..TestScene::default() },
        TestScene { cameras: 4, frames: 4, ..TestScene::default() },
    ] {
        let observation = run(scene.clone()).unwrap();
        let sequence = &observation.capture.sequences[0];
        let score = score(sequence).unwrap();
        assert!(score.points > 200, "{scene:?}: {score:?}");
        for frame in 0..sequence.frame_count {
            let middle = point(place(frame, nalgebra::Vector3::zeros()));
            let seen = sequence.points_at(frame).iter().zip(sequence.visible_at(frame));
            for (p, _) in seen.filter(|(_, v)| **v) {
                let off = (distance(*p, middle) - crate::testing::BALL_M).abs();
                assert!(off < 4e-3, "{scene:?} frame {frame}: {off}");
            }
        }
        let missing = observation.evidence.cameras.iter().map(|c| c.missing_frames).sum::<usize>();
        assert_eq!(missing, scene.missing.len());
    }
}

#[test]
fn a_track_that_slips_is_found_out() {
    let scene = TestScene { slipping: Some((10, 1.5)), ..TestScene::default() };
    let observation = run(scene).unwrap();
    let evidence = &observation.evidence.tracks;
    assert!(evidence.unconfirmed > 0.008 && evidence.drifted > 0.02, "{evidence:?}");
    let straight = run(TestScene::default()).unwrap().evidence.tracks;
    assert!(straight.unconfirmed < 0.005 && straight.drifted < 0.002, "{straight:?}");
}

#[test]
fn lifting_resumes_from_any_checkpoint_to_the_same_observation() {
    let scene = || TestScene { frames: 40, ..TestScene::default() }.recording();
    let settings = IngestSettings::default();
    let cancel = CancelToken::default();
    let mut recorder = CheckpointRecorder::new(usize::MAX);
    let whole = lift(&scene(), &settings, None, &mut recorder, &cancel).unwrap();
    assert!(recorder.kept.len() > 1);
    assert!(recorder.fractions.is_sorted());
    assert_eq!(recorder.fractions.last(), Some(&1.0));
    for most in [0, 1] {
        let mut stopped = CheckpointRecorder::new(most);
        let error = lift(&scene(), &settings, None, &mut stopped, &cancel).unwrap_err();
        assert_eq!(error.reason(), "CHECKPOINT_NOT_KEPT");
        let from = stopped.kept.last().map(Vec::as_slice);
        assert_eq!(lift(&scene(), &settings, from, &mut (), &cancel).unwrap(), whole);
    }
    let last = recorder.kept.last().unwrap();
    let other = IngestSettings { spacing_m: 0.004, ..settings.clone() };
    let error = lift(&scene(), &other, Some(last), &mut (), &cancel).unwrap_err();
    assert_eq!(error.reason(), "CHECKPOINT_OF_ANOTHER_INGEST");
    let error = lift(&scene(), &settings, Some(&last[..40]), &mut (), &cancel).unwrap_err();
    assert_eq!(error.reason(), "CHECKPOINT_UNREADABLE");
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(TestScene { frames: 20, ..TestScene::default() }).unwrap())
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn errors_name_what_cannot_be_lifted() {
    let reason = |scene: TestScene| run(scene).unwrap_err().reason();
    assert_eq!(reason(TestScene { masks: false, ..TestScene::default() }), "OBJECT_NOT_SEEN");
    let none = (0..12).flat_map(|f| [(0, f), (1, f)]).collect();
    assert_eq!(reason(TestScene { missing: none, ..TestScene::default() }), "OBJECT_NOT_SEEN");
    assert_eq!(
        reason(TestScene { missing: vec![(0, 0), (1, 0)], ..TestScene::default() }),
        "OBJECT_NOT_TRACKED"
    );

    let long = TestScene { hand_unmasked: 4..10, ..TestScene::default() };
    let error = run(long).unwrap_err();
    assert_eq!(error.reason(), "HAND_LOST");
    assert!(error.to_string().contains("from frame 4 to 9"), "{error}");
    let late = TestScene { hand_unmasked: 0..1, ..TestScene::default() };
    assert_eq!(reason(late), "HAND_NOT_TRACKED");
    let lost = (4..12).flat_map(|f| [(0, f), (1, f)]).collect();
    assert_eq!(reason(TestScene { missing: lost, ..TestScene::default() }), "OBJECT_MASK_EMPTY");
    let stopped = CancelToken::default();
    stopped.cancel();
    let recording = TestScene::default().recording();
    let error = lift(&recording, &IngestSettings::default(), None, &mut (), &stopped).unwrap_err();
    assert_eq!(error.reason(), "CANCELLED");
}

#[test]
fn short_gaps_of_the_hand_are_filled_and_a_missing_hand_is_reported() {
    let observation = run(TestScene { hand_hidden: 4..8, ..TestScene::default() }).unwrap();
    let hand = &observation.evidence.hands[0];
    assert_eq!(hand.filled_frames, 4);
    let sequence = &observation.capture.sequences[0];
    let middle = point(place(6, hand_middle()));
    for p in sequence.controls_at(6) {
        assert!((distance(*p, middle) - crate::testing::HAND_M).abs() < 2e-3);
    }
    let alone = run(TestScene { hand: false, ..TestScene::default() }).unwrap();
    assert_eq!(alone.capture.sequences[0].control_count(), 0);
    assert!(alone.evidence.findings.iter().any(|f| f.code == "NO_HAND"));
}

#[test]
fn a_hand_whose_tracks_are_lost_is_followed_by_its_shape() {
    let observation = run(TestScene { hand_hidden: 4..12, ..TestScene::default() }).unwrap();
    assert!(observation.evidence.hands[0].by_shape, "{:?}", observation.evidence.hands);
    let sequence = &observation.capture.sequences[0];
    let middle = point(place(11, hand_middle()));
    for p in sequence.controls_at(11) {
        let off = (distance(*p, middle) - crate::testing::HAND_M).abs();
        assert!(off < 3e-3, "{off}");
    }
}

#[test]
fn recordings_that_contradict_themselves_are_refused() {
    let refused = |change: fn(&mut bendtwin_capture::raw::Recording)| {
        let mut recording = TestScene::default().recording();
        change(&mut recording);
        let settings = IngestSettings::default();
        let error = lift(&recording, &settings, None, &mut (), &CancelToken::default());
        assert_eq!(error.unwrap_err().reason(), "RECORDING_INCONSISTENT");
    };
    refused(|r| r.cameras.clear());
    refused(|r| r.frame_count = 0);
    refused(|r| r.frame_count = 5);
    refused(|r| r.fps = f64::NAN);
    refused(|r| r.cameras[0].width = 0);
    refused(|r| r.cameras[0].width = usize::MAX);
    refused(|r| r.cameras[0].intrinsics.fx = 0.0);
    refused(|r| r.cameras[1].poses.clear());
    refused(|r| r.cameras[1].poses[0].translation[0] = f64::INFINITY);
    refused(|r| _ = r.truth_tracks.pop());
    refused(|r| r.cameras[0].height += 1);
}

#[test]
fn a_hand_without_tracks_is_followed_by_its_shape() {
    let observation = run(TestScene { hand_hidden: 0..12, ..TestScene::default() }).unwrap();
    let sequence = &observation.capture.sequences[0];
    assert!(observation.evidence.hands[0].by_shape);
    for frame in 0..sequence.frame_count {
        let middle = point(place(frame, hand_middle()));
        for p in sequence.controls_at(frame) {
            let off = (distance(*p, middle) - crate::testing::HAND_M).abs();
            assert!(off < 3e-3, "{off}");
        }
    }
}

#[test]
fn without_tracks_the_built_in_tracker_makes_them_once() {
    let scene = || TestScene { tracked: false, frames: 5, ..TestScene::default() }.recording();
    let (settings, cancel) = (IngestSettings::default(), CancelToken::default());
    let mut recorder = CheckpointRecorder::new(usize::MAX);
    let whole = lift(&scene(), &settings, None, &mut recorder, &cancel).unwrap();
    assert!(recorder.fractions.is_sorted());
    assert!(whole.evidence.cameras.iter().all(|c| c.tracker.is_some() && c.tracks > 50));
    let sequence = &whole.capture.sequences[0];
    assert!(whole.capture.object.point_count > 100);
    for frame in 0..sequence.frame_count {
        let middle = point(place(frame, nalgebra::Vector3::zeros()));
        let seen = sequence.points_at(frame).iter().zip(sequence.visible_at(frame));
        for (p, _) in seen.filter(|(_, v)| **v) {
            assert!((distance(*p, middle) - crate::testing::BALL_M).abs() < 4e-3);
        }
    }
    let from = recorder.kept.first().map(Vec::as_slice);
    let mut again = CheckpointRecorder::new(usize::MAX);
    assert_eq!(lift(&scene(), &settings, from, &mut again, &cancel).unwrap(), whole);
    assert!(again.fractions[0] > TRACKED, "what was tracked is not tracked again");
}

#[test]
fn a_gripper_stands_in_for_masks_of_a_hand() {
    let mut recording = TestScene { hand: false, ..TestScene::default() }.recording();
    let pose = |frame: usize| {
        let middle = point(place(frame, hand_middle()));
        Some(Pose { translation: middle.map(f64::from), ..Pose::IDENTITY })
    };
    let pad = Pad { length_m: 0.02, breadth_m: 0.02 };
    let poses = (0..recording.frame_count).map(pose).collect();
    recording.grippers = vec![Gripper { name: "right".into(), poses, widths_m: Vec::new(), pad }];
    let settings = IngestSettings::default();
    let made = lift(&recording, &settings, None, &mut (), &CancelToken::default()).unwrap();
    let sequence = &made.capture.sequences[0];
    assert!(sequence.control_count() > 0);
    // They move with the gripper.
    let controls = sequence.control_count();
    let last = sequence.frame_count - 1;
    let [from, to] = [0, last].map(|f| point(place(f, hand_middle())));
    for control in 0..controls {
        let [start, end] = [0, last].map(|frame| sequence.controls[frame * controls + control]);
        for axis in 0..3 {
            let moved = (end[axis] - start[axis]) - (to[axis] - from[axis]);
            assert!(moved.abs() < 1e-3, "{control}: {moved}");
        }
    }
}
