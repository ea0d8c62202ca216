use bendtwin_capture::raw::Recording;

use crate::{
    Inspection, Verdict,
    consistency::hypothesis::PoseChange,
    inspect,
    inspect::inspect_with,
    testing::{FRAMES, TestScene, disturbed, filmed, healthy},
    thresholds::Thresholds,
};

fn inspected(scene: TestScene, recording: Recording) -> Inspection {
    inspect(&filmed(scene, recording), &Default::default(), &Default::default(), &mut |_| {})
        .unwrap()
}

/// The finding of a recording with one fault: there is no other that asks for something to be done.
#[track_caller]
fn one(seen: &Inspection, code: &str) -> crate::Finding {
    let findings: Vec<String> = seen
        .findings
        .iter()
        .filter(|f| f.severity != bendtwin_core::Severity::Info)
        .map(|f| format!("{} {}", f.code, f.sentence()))
        .collect();
    assert!(
        findings.iter().all(|t| t.starts_with(code)) && !findings.is_empty(),
        "{code}: {findings:#?}"
    );
    println!("{}", findings.join("\n"));
    seen.findings[0].clone()
}

fn shown(change: impl FnOnce(&mut TestScene)) -> Inspection {
    let (mut scene, recording) = healthy();
    change(&mut scene);
    inspected(scene, recording)
}

fn declared(change: impl FnOnce(&mut Recording)) -> Inspection {
    let (_, mut recording) = healthy();
    change(&mut recording);
    inspect(&recording, &Default::default(), &Default::default(), &mut |_| {}).unwrap()
}

#[test]
fn a_healthy_recording_is_good() {
    let seen = declared(|_| {});
    assert_eq!((seen.verdict, seen.findings.len()), (Verdict::Good, 0), "{:?}", seen.findings);
    let size = seen.scene.object_size_m.unwrap();
    assert!((0.13..0.2).contains(&size), "{size}");
    for camera in &seen.cameras {
        let agreement = camera.agreement.unwrap();
        assert!(agreement.disagreement_mm.unwrap() < 3.0, "{agreement:?}");
        assert!(camera.skew_ms.unwrap().abs() < 15.0);
    }
}

#[test]
fn results_do_not_depend_on_threads() {
    let (_, recording) = healthy();
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let many = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap();
    let look =
        || inspect(&recording, &Default::default(), &Default::default(), &mut |_| {}).unwrap();
    let text = |seen: Inspection| serde_json::to_string(&seen).unwrap();
    assert_eq!(text(alone.install(look)), text(many.install(look)));
}

#[test]
fn dropped_repeated_and_damaged_frames_are_counted() {
    let seen = shown(|s| (1..FRAMES).step_by(4).for_each(|f| s.moments[1][f] = None));
    let found = one(&seen, "FRAMES_DROPPED");
    assert_eq!((found.cameras, found.numbers["missing_frames"]), (vec![1], 9.0));
    assert_eq!(seen.cameras[1].missing_frames.len(), 9);

    let seen = shown(|s| (6..26).step_by(5).for_each(|f| s.moments[2][f] = Some(f as f64 - 1.0)));
    let found = one(&seen, "FRAMES_DUPLICATED");
    assert_eq!((found.cameras, found.frames), (vec![2], vec![6, 11, 16, 21]));

    let seen = shown(|s| s.damaged.push((0, 7)));
    let found = &seen.findings[0];
    assert_eq!((found.code.as_str(), found.frames.as_slice()), ("FRAMES_DAMAGED", &[7][..]));
    assert!(found.message.contains("FILE_DAMAGED"), "{}", found.message);
    assert_eq!(seen.verdict, Verdict::Usable);
}

#[test]
fn one_fault_of_all_cameras_is_one_finding() {
    let seen =
        shown(|s| s.damaged = (0..3).flat_map(|c| (0..FRAMES).map(move |f| (c, f))).collect());
    let found = one(&seen, "FRAMES_DAMAGED");
    assert_eq!(found.cameras, [0, 1, 2]);
    assert!(found.message.ends_with("likewise camera 1 (cam1) and camera 2 (cam2)"), "{found:?}");
    assert!(found.consequences.contains(&"CAMERA_EMPTY".to_owned()), "{found:?}");
}

#[test]
fn a_camera_at_a_lower_rate_is_no_fault() {
    let seen = shown(|s| (1..FRAMES).step_by(2).for_each(|f| s.moments[1][f] = None));
    assert_eq!((seen.verdict, seen.has("CAMERA_SLOWER")), (Verdict::Good, true), "{seen:?}");
    let found = seen.findings.iter().find(|f| f.code == "CAMERA_SLOWER").unwrap();
    assert!(found.message.starts_with("camera 1 (cam1) recorded at 15 fps"), "{found:?}");
    // Stored twice, its frames are late by half: that is said, and no more.
    let seen = shown(|s| s.moments[1] = (0..FRAMES).map(|f| Some((f / 2 * 2) as f64)).collect());
    let found = one(&seen, "FRAMES_DUPLICATED");
    assert_eq!((found.cameras.as_slice(), seen.verdict), (&[1][..], Verdict::Usable));
    assert!(found.message.contains("recorded at 15 fps"), "{found:?}");
}

#[test]
fn a_click_that_was_not_followed_and_a_hand_that_was_forgotten() {
    let later = |first: usize| (0..3).flat_map(move |c| (first..FRAMES).map(move |f| (c, f)));
    let seen = shown(|s| s.empty_masks = later(1).collect());
    let found = one(&seen, "MASKS_NOT_FOLLOWED");
    assert!(found.message.contains("one frame alone (frame 0)"), "{found:?}");
    assert!(found.advice.contains("docs/use/cameras.md#masks"), "{found:?}");

    let seen = shown(|s| s.hidden_hand = true);
    let found = one(&seen, "MANIPULATOR_NOT_SEEN");
    assert_eq!(seen.verdict, Verdict::Unusable, "{found:?}");
    assert!(found.message.contains("the object is moved by"), "{found:?}");
}

#[test]
fn frames_that_were_dropped_and_closed_up_are_noticed() {
    // Every third moment is missing in all cameras, without a trace in the description.
    let seen = shown(|s| {
        for camera in &mut s.moments {
            *camera = (0..FRAMES).map(|f| Some((f + f / 3) as f64)).collect();
        }
    });
    one(&seen, "FRAMES_SKIPPED");
}

#[test]
fn late_frames_wrong_rates_and_skewed_times() {
    let times = |late: f64, rate: f64| -> Vec<f64> {
        (0..FRAMES).map(|f| f as f64 / rate + if f == 9 { late } else { 0.0 }).collect()
    };
    let seen = declared(|r| r.cameras.iter_mut().for_each(|c| c.times_s = times(0.03, 30.0)));
    assert_eq!(one(&seen, "FRAMES_LATE").frames, [9]);
    let seen = declared(|r| r.cameras.iter_mut().for_each(|c| c.times_s = times(0.0, 15.0)));
    assert_eq!(one(&seen, "FPS_MISMATCH").numbers["measured_fps"].round(), 15.0);
    let seen = declared(|r| {
        r.cameras.iter_mut().for_each(|c| c.times_s = times(0.0, 30.0));
        r.cameras[0].times_s.iter_mut().for_each(|t| *t += 0.025);
    });
    let found = one(&seen, "CAMERAS_SKEWED");
    assert_eq!((found.cameras, found.numbers["skew_ms"].round()), (vec![0], 25.0));
}

#[test]
fn a_skew_is_found_from_motion_alone() {
    for (camera, skew) in [(2, 6.0), (0, -6.0), (1, 1.5)] {
        let seen = shown(|s| {
            let moments = (0..FRAMES).map(|f| Some(f as f64 - skew));
            s.moments[camera] = moments.collect();
        });
        let found = one(&seen, "CAMERAS_SKEWED");
        let ms = found.numbers["skew_ms"];
        assert_eq!(found.cameras, [camera]);
        assert!((ms - 1e3 * skew / 30.0).abs() < 25.0, "{ms} for {skew} frames");
    }
}

#[test]
fn depth_that_is_sparse_scaled_or_in_other_units() {
    let seen = shown(|s| s.holes = 0.6);
    one(&seen, "DEPTH_SPARSE");
    for (factor, limit) in [(0.9_f32, 0.02), (1.1, 0.02), (10.0, 0.02), (0.001, 0.03)] {
        let seen = shown(|s| s.depth_factor[1] = factor);
        let found = one(&seen, "DEPTH_SCALE");
        let times = found.numbers["depth_factor"] * f64::from(factor);
        assert_eq!(found.cameras, [1]);
        assert!((times - 1.0).abs() < limit, "{factor}: {times}");
    }
    for factor in [1000.0_f32, 0.001] {
        one(&shown(|s| s.depth_factor = vec![factor; 3]), "DEPTH_UNITS");
    }
    one(&shown(|s| s.depth_factor = vec![1.2; 3]), "DEPTH_UNITS");
}

#[test]
fn everything_in_centimetres_is_too_large() {
    let (mut scene, mut recording) = healthy();
    scene.depth_factor = vec![100.0; 3];
    for camera in &mut recording.cameras {
        camera.poses[0] = PoseChange::Units(100.0).apply(&camera.poses[0]);
    }
    one(&inspected(scene, recording), "SCALE_TOO_LARGE");
}

#[test]
fn mistakes_with_poses_are_distinguished() {
    let all = |change: PoseChange| {
        declared(|r| r.cameras.iter_mut().for_each(|c| c.poses[0] = change.apply(&c.poses[0])))
    };
    let alone = |change: PoseChange| {
        declared(|r| r.cameras[2].poses[0] = change.apply(&r.cameras[2].poses[0]))
    };
    for (change, code) in [
        (PoseChange::Inverse, "EXTRINSICS_INVERTED"),
        (PoseChange::OpenGl, "EXTRINSICS_AXES"),
        (PoseChange::Mirrored(1), "EXTRINSICS_MIRRORED"),
        (PoseChange::MirroredPlace(0), "EXTRINSICS_MIRRORED"),
        (PoseChange::Units(100.0), "EXTRINSICS_UNITS"),
    ] {
        one(&all(change), code);
        assert_eq!(one(&alone(change), code).cameras, [2]);
    }
    // A body's axes: its x is the camera's z, its y the camera's -x, its z the camera's -y.
    let seen = declared(|r| {
        for camera in &mut r.cameras {
            let pose = &mut camera.poses[0];
            pose.rotation = pose.rotation.map(|[x, y, z]| [z, -x, -y]);
        }
    });
    assert!(one(&seen, "EXTRINSICS_AXES").message.contains("x forward, y left, z up"));
    let seen = declared(|r| {
        let (a, b) = (r.cameras[0].poses.clone(), r.cameras[2].poses.clone());
        (r.cameras[0].poses, r.cameras[2].poses) = (b, a);
    });
    assert_eq!(one(&seen, "CAMERAS_SWAPPED").cameras, [0, 2]);
    let seen = declared(|r| r.cameras[1].poses = r.cameras[0].poses.clone());
    assert_eq!(one(&seen, "CAMERAS_COINCIDE").cameras, [0, 1]);
    let seen = declared(|r| {
        for camera in &mut r.cameras {
            camera.poses[0].rotation.iter_mut().for_each(|row| row[0] = -row[0]);
        }
    });
    one(&seen, "EXTRINSICS_MIRRORED");
    one(&declared(|r| r.cameras[0].poses[0].translation[1] = f64::NAN), "EXTRINSICS_INVALID");
    one(&declared(|r| r.cameras[0].intrinsics.fx = 0.0), "INTRINSICS_INVALID");
}

/// A camera of half the rate has gaps, which are no loss; only where nothing tells its rate is it
/// refused, once.
#[test]
fn a_camera_of_half_the_rate_is_named_and_used() {
    let seen = shown(|scene| {
        scene.moments[1]
            .iter_mut()
            .enumerate()
            .filter(|(f, _)| f % 2 == 1)
            .for_each(|(_, m)| *m = None);
    });
    assert_ne!(seen.verdict, Verdict::Unusable, "{:?}", seen.findings);
    let codes: Vec<&str> = seen.findings.iter().map(|f| f.code.as_str()).collect();
    assert_eq!(codes, ["CAMERA_SLOWER"], "{:?}", seen.findings);
    assert!(seen.findings[0].message.contains("recorded at 15 fps"), "{:?}", seen.findings);
    let seen = shown(|scene| {
        let moments = &mut scene.moments[1];
        let half = moments.len() / 2;
        let closed: Vec<Option<f64>> = moments.iter().copied().step_by(2).collect();
        moments[..half].copy_from_slice(&closed[..half]);
        moments[half..].fill(None);
    });
    let found = one(&seen, "CAMERA_RATE_UNCLEAR");
    assert!(found.message.contains("one of 15 fps"), "{found:?}");
    assert!(found.advice.contains("\"fps\": [30, 15, 30]"), "{found:?}");
}

#[test]
fn a_camera_that_is_off_is_named_with_its_correction() {
    for (camera, degrees, shift) in
        [(2, 1.0, [0.0; 3]), (0, 0.0, [0.012, 0.0, 0.0]), (1, 5.0, [0.0; 3])]
    {
        let seen = declared(|r| {
            let pose = &mut r.cameras[camera].poses[0];
            *pose = disturbed(pose, degrees, shift);
        });
        let found = one(&seen, "CAMERA_OFF");
        assert_eq!(found.cameras, [camera]);
        let shift = 1e3 * shift[0] + degrees.to_radians() * 620.0;
        let shift_mm = found.numbers["shift_mm"];
        assert!((shift_mm - shift).abs() < 0.3 * shift, "{shift_mm} mm for {shift} mm");
    }
}

#[test]
fn the_correction_of_a_camera_that_is_off_ends_the_finding() {
    let (scene, mut recording) = healthy();
    let pose = &mut recording.cameras[2].poses[0];
    *pose = disturbed(pose, 2.0, [0.01, 0.0, 0.0]);
    let mut recording = filmed(scene, recording);
    let look = |recording: &Recording| {
        inspect(recording, &Default::default(), &Default::default(), &mut |_| {}).unwrap()
    };
    let before = look(&recording);
    assert!(before.has("CAMERA_OFF"));
    let correction = before.correction(&recording).unwrap();
    assert_eq!(correction.cameras[0].pose, recording.cameras[0].poses.first().copied());
    correction.apply(&mut recording).unwrap();
    let after = look(&recording);
    assert!(!after.has("CAMERA_OFF") && !after.has("CAMERAS_DISAGREE"), "{:?}", after.findings);
    assert!(after.correction(&recording).is_none());
}

#[test]
fn two_cameras_that_disagree_are_both_named() {
    let (mut scene, mut recording) = healthy();
    scene.moments.truncate(2);
    recording.cameras.truncate(2);
    let pose = &mut recording.cameras[1].poses[0];
    *pose = disturbed(pose, 2.0, [0.0; 3]);
    assert_eq!(one(&inspected(scene, recording), "CAMERAS_DISAGREE").cameras, [0, 1]);
}

#[test]
fn masks_that_are_empty_or_exchanged() {
    let seen = shown(|s| s.empty_masks.extend([(1, 4), (1, 5)]));
    assert_eq!(one(&seen, "OBJECT_MASK_EMPTY").frames, [4, 5]);
    let every = |cameras: std::ops::Range<usize>| {
        cameras.flat_map(|c| (0..FRAMES).map(move |f| (c, f))).collect::<Vec<_>>()
    };
    one(&shown(|s| s.empty_masks = every(0..3)), "OBJECT_NOT_SEEN");
    let seen = shown(|s| s.exchanged_masks.push(2));
    assert_eq!(one(&seen, "MASKS_SWAPPED").cameras, [2]);
    let seen = shown(|s| s.exchanged_masks.extend([0, 1, 2]));
    one(&seen, "MASKS_SWAPPED");
}

#[test]
fn tracks_that_are_exchanged_or_missing() {
    one(&shown(|s| s.tracks = Some(true)), "TRACKS_TRANSPOSED");
    let seen = shown(|s| s.tracks = None);
    assert_eq!((seen.verdict, seen.has("TRACKS_MISSING")), (Verdict::Good, true));
}

#[test]
fn scenes_without_motion_contact_or_the_right_way_up() {
    one(&shown(|s| s.travel = 0.0), "NOTHING_MOVES");
    one(&shown(|s| s.standoff_m = 0.15), "NO_CONTACT");
    let seen = shown(|s| {
        s.travel = 2.0;
        s.moments.iter_mut().for_each(|c| *c = (0..FRAMES).map(|f| Some(3.2 * f as f64)).collect());
    });
    one(&seen, "MOTION_TOO_FAST");
    let seen = declared(|r| {
        r.environment.gravity = [0.0, 0.0, 9.81];
        if let Some(ground) = &mut r.environment.ground {
            ground.normal = [0.0, 0.0, -1.0];
        }
    });
    one(&seen, "UP_AXIS_WRONG");
    let seen = declared(|r| {
        if let Some(ground) = &mut r.environment.ground {
            ground.offset_m = 0.1;
        }
    });
    one(&seen, "BELOW_GROUND");
}

#[test]
fn one_frame_and_none() {
    one(&declared(|r| r.frame_count = 1), "ONE_FRAME");
    one(&declared(|r| r.frame_count = 0), "NO_FRAMES");
    one(&declared(|r| r.fps = f64::NAN), "FPS_INVALID");
    one(&declared(|r| r.train_frame_count = 1), "SPLIT_EMPTY");
    let seen = declared(|r| r.frame_count = usize::MAX);
    one(&seen, "RECORDING_TOO_LONG");
    one(&declared(|r| r.cameras.clear()), "NO_FRAMES");
    one(&declared(|r| r.cameras[1].poses.clear()), "NOT_CALIBRATED");
}

#[test]
fn an_inspection_can_be_cancelled() {
    let (_, recording) = healthy();
    let cancel = bendtwin_core::CancelToken::default();
    let stop = cancel.clone();
    let error =
        inspect(&recording, &Default::default(), &cancel, &mut |_| stop.cancel()).unwrap_err();
    assert!(matches!(error, crate::Error::Cancelled));
}

#[test]
fn thresholds_decide() {
    let (mut scene, recording) = healthy();
    scene.holes = 0.3;
    let recording = filmed(scene, recording);
    let is_sparse = |good_coverage: f64| {
        let mut thresholds = Thresholds::default();
        thresholds.depth.good_coverage = good_coverage;
        let cancel = Default::default();
        let seen = inspect_with(&recording, &Default::default(), &thresholds, &cancel, &mut |_| {})
            .unwrap();
        seen.has("DEPTH_SPARSE")
    };
    assert!(!is_sparse(0.6) && is_sparse(0.8));
}

#[test]
fn gaps_of_the_hand_are_reported_as_in_lifting() {
    use bendtwin_core::settings::ingest::{ControlSettings, IngestSettings};
    let (mut scene, recording) = healthy();
    // A frame that no camera has is a gap of the hand, too.
    scene.moments.iter_mut().for_each(|camera| camera[10..20].fill(None));
    let recording = filmed(scene, recording);
    let cancel = Default::default();
    let of = |max_gap_frames: u32| {
        let controls = ControlSettings { max_gap_frames, ..ControlSettings::default() };
        let settings = IngestSettings { controls, ..IngestSettings::default() };
        inspect(&recording, &settings, &cancel, &mut |_| {}).unwrap()
    };
    let strict = of(5);
    assert_eq!(
        (strict.verdict, strict.findings[0].code.as_str()),
        (Verdict::Unusable, "FRAMES_DROPPED")
    );
    assert_eq!(strict.findings[0].consequences, ["HAND_LOST"]);
    assert_eq!(of(10).verdict, Verdict::Usable);
}

#[test]
fn an_object_a_metre_and_a_half_large_is_doubted_with_its_hand() {
    let (mut scene, mut recording) = healthy();
    scene.depth_factor = vec![10.0; 3];
    for camera in &mut recording.cameras {
        camera.poses[0] = PoseChange::Units(10.0).apply(&camera.poses[0]);
    }
    recording.environment.ground = None;
    // Of a hand of 0.7 m nothing is doubted.
    let seen = inspected(scene, recording);
    assert!((1.2..2.5).contains(&seen.scene.object_size_m.unwrap()), "{:?}", seen.scene);
    assert_eq!(seen.has("SCALE_TOO_LARGE"), seen.scene.manipulator_size_m.unwrap() > 0.8);
}
