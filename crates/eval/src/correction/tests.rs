use super::*;
use crate::scene;

fn plan(frames: Vec<usize>) -> CorrectionPlan {
    CorrectionPlan {
        frames,
        horizon: 5,
        shares: vec![0.5, 1.0],
        every: 0,
        velocity_frames: 1,
        carry: 0.0,
        options: CorrectOptions::default(),
    }
}

fn compared(capture: &Capture, plan: &CorrectionPlan) -> Result<Vec<CorrectionScore>, Error> {
    let twin = scene::chain_twin(5);
    corrections(&*bendtwin_engine::cpu(), &twin, capture, plan, &CancelToken::default())
}

/// A chain whose middle wanders off, which nothing tells the twin.
fn wandering() -> Capture {
    let mut capture = scene::chain(5, 20, 20, [0.0; 3]);
    let s = &mut capture.sequences[0];
    for f in 0..20 {
        for p in 1..4 {
            s.points[5 * f + p][2] += 0.001 * f as f32;
        }
    }
    capture
}

#[test]
fn a_corrected_state_predicts_better_and_more_points_correct_more() {
    let scores = compared(&wandering(), &plan(vec![8, 12])).unwrap();
    assert_eq!(scores.len(), 4);
    for score in &scores {
        let (open, corrected) =
            (score.open_loop.track_m.unwrap(), score.corrected.track_m.unwrap());
        assert!(corrected < open, "{score:?}");
        assert!(score.residual_mm[1] < score.residual_mm[0], "{score:?}");
        assert_eq!(score.refused, 0);
    }
    assert!(scores[0].points < scores[1].points);
    // Motion capture has no clean tracks: the points are their own.
    assert!(scores[0].last_residual.track_m.is_some());
}

#[test]
fn a_rest_shape_that_takes_part_keeps_more_of_the_correction() {
    let whole = |carry| {
        let plan = CorrectionPlan { carry, shares: vec![1.0], ..plan(vec![12]) };
        compared(&wandering(), &plan).unwrap()[0].corrected.track_m.unwrap()
    };
    assert!(whole(1.0) < whole(0.0), "{} {}", whole(1.0), whole(0.0));
}

#[test]
fn later_frames_are_not_read() {
    let mut capture = wandering();
    let before = compared(&capture, &plan(vec![8])).unwrap();
    // Frame 14 is beyond the horizon of both.
    let s = &mut capture.sequences[0];
    for p in &mut s.points[5 * 14..] {
        p[0] += 5.0;
    }
    assert_eq!(compared(&capture, &plan(vec![8])).unwrap(), before);
}

#[test]
fn frames_without_others_around_them_are_refused() {
    for frame in [0, 19, 100] {
        let error = compared(&wandering(), &plan(vec![frame])).unwrap_err();
        assert!(error.to_string().contains("none to predict"), "{error}");
    }
}

#[test]
fn what_repeated_corrections_carry_lasts_longer_than_one() {
    let error = |every, carry| {
        let plan = CorrectionPlan { every, carry, shares: vec![1.0], ..plan(vec![12]) };
        compared(&wandering(), &plan).unwrap()[0].corrected.track_m.unwrap()
    };
    let [one, again, carried] = [error(0, 0.0), error(2, 0.0), error(2, 1.0)];
    assert!(carried < again && carried < one, "{one} {again} {carried}");
}

#[test]
fn an_interval_beyond_the_frame_is_one_correction() {
    let scores =
        |every| compared(&wandering(), &CorrectionPlan { every, ..plan(vec![8]) }).unwrap();
    assert_eq!(scores(0), scores(usize::MAX));
    assert_eq!(scores(0), scores(100));
}
