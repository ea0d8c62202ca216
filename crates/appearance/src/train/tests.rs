use bendtwin_splat::Cpu;

use super::*;
use crate::{
    Dressed, Scene, score,
    testing::{Ball, motion_of},
};

fn options(steps: u32) -> TrainingOptions {
    TrainingOptions {
        gaussians: 900,
        steps,
        isotropic: false,
        max_frames: 0,
        held_out: Vec::new(),
        seed: 5,
    }
}

fn training<'a>(ball: &'a Ball, options: TrainingOptions) -> Training<'a> {
    // Colours are to be learned.
    let grey = vec![[128; 3]; ball.colors.len()];
    Training::new(&ball.twin, motion_of(&ball.nodes, 3), &ball.views, &grey, options).unwrap()
}

fn psnr_db(ball: &Ball, splats: &Splats) -> f64 {
    let dressed = Dressed::new(&ball.twin.graph, splats).unwrap();
    let motion = motion_of(&ball.nodes, 3);
    let scene = Scene { dressed: &dressed, motion, views: &ball.views, held_out: &[] };
    let scored = score(&scene, &mut Cpu::default(), false, &mut || true).unwrap().unwrap();
    scored.future.psnr_db.unwrap()
}

#[test]
fn colours_are_learned_along_the_motion() {
    let ball = Ball::new(4);
    let mut training = training(&ball, options(320));
    let before = psnr_db(&ball, &training.splats());
    let mut rasteriser = Cpu::default();
    let mut counts = Vec::new();
    while !training.is_done() {
        counts.push(training.step(&mut rasteriser).unwrap().gaussians);
    }
    let splats = training.splats();
    assert_eq!(splats.check(ball.twin.graph.node_count()), Ok(()));
    // The fourth frame was not trained on.
    let after = psnr_db(&ball, &splats);
    assert!(after > before + 8.0 && after > 28.0, "{before} dB, then {after} dB");
    assert!(counts.last() > counts.first(), "Gaussians were split: {counts:?}");
    assert!(counts.iter().all(|count| *count <= 900));
}

#[test]
fn an_interrupted_training_ends_in_the_same_gaussians() {
    let ball = Ball::new(3);
    let mut rasteriser = Cpu::default();
    let mut whole = training(&ball, options(200));
    let mut checkpoint = Vec::new();
    while !whole.is_done() {
        if whole.step(&mut rasteriser).unwrap().done == 170 {
            checkpoint = whole.checkpoint().unwrap();
        }
    }
    let mut resumed = training(&ball, options(200));
    resumed.restore(&checkpoint).unwrap();
    while !resumed.is_done() {
        resumed.step(&mut rasteriser).unwrap();
    }
    assert_eq!(resumed.splats(), whole.splats());
    checkpoint.truncate(checkpoint.len() / 2);
    assert!(matches!(resumed.restore(&checkpoint), Err(Error::Checkpoint(_))));
    let mut fewer = training(&ball, TrainingOptions { steps: 100, ..options(200) });
    assert!(fewer.restore(&whole.checkpoint().unwrap()).is_err());
}

#[test]
fn round_gaussians_stay_round() {
    let ball = Ball::new(3);
    let mut training = training(&ball, TrainingOptions { isotropic: true, ..options(160) });
    while !training.is_done() {
        training.step(&mut Cpu::default()).unwrap();
    }
    assert!(training.splats().scales_m.iter().all(|s| s[0] == s[1] && s[1] == s[2]));
}

#[test]
fn without_a_view_that_may_be_used_there_is_no_training() {
    let ball = Ball::new(2);
    let held_out = TrainingOptions { held_out: vec![0, 1], ..options(10) };
    let motion = motion_of(&ball.nodes, 2);
    let refused = Training::new(&ball.twin, motion, &ball.views, &ball.colors, held_out);
    assert_eq!(refused.err(), Some(Error::NoViews));
}
