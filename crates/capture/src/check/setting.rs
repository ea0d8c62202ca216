//! Frame rate, length, split, gravity.

use bendtwin_core::{Capture, Environment, FRAME_RATES};

use super::Finding;

const MIN_FPS: f64 = 1.0;
const MAX_FPS: f64 = 1000.0;
/// Gravity between the Moon's and far beyond any lab's [m/s²].
const GRAVITY: std::ops::RangeInclusive<f32> = 1.0..=30.0;
/// Cosine of the angle by which gravity may miss the ground's normal: 30 degrees.
const MAX_TILT_COS: f32 = 0.866;

pub(super) fn check(capture: &Capture, findings: &mut Vec<Finding>) {
    frame_rate(capture.fps, findings);
    gravity(&capture.environment, findings);
    for sequence in &capture.sequences {
        let (name, frames) = (&sequence.name, sequence.frame_count);
        match frames {
            0 => findings.push(Finding::error(
                "NO_FRAMES",
                format!("sequence `{name}` has no frames: record at least two"),
            )),
            1 => findings.push(Finding::error(
                "ONE_FRAME",
                format!("sequence `{name}` has one frame, so nothing moves: record at least two"),
            )),
            _ => {}
        }
    }
    let train: usize = capture.sequences.iter().map(|s| s.train_frame_count).max().unwrap_or(0);
    if train < 2 {
        findings.push(Finding::error(
            "SPLIT_EMPTY",
            format!("the longest part for fitting has {train} frames: move the split so that it has at least two"),
        ));
    }
    if capture.sequences.iter().all(|s| s.train_frame_count >= s.frame_count) {
        findings.push(Finding::warning(
            "NO_FUTURE",
            "all frames are for fitting, so nothing says how well the twin predicts: keep the last 30 % or a \
             sequence back"
                .to_owned(),
        ));
    }
}

fn frame_rate(fps: f64, findings: &mut Vec<Finding>) {
    if !FRAME_RATES.contains(&fps) {
        findings.push(Finding::error(
            "FPS_INVALID",
            format!("the frame rate is {fps} fps: give the camera's frames per second"),
        ));
    } else if !(MIN_FPS..=MAX_FPS).contains(&fps) {
        findings.push(Finding::warning(
            "FPS_IMPLAUSIBLE",
            format!(
                "the frame rate is {fps} fps, outside {MIN_FPS} to {MAX_FPS}: is it a frame time (then give its \
                 inverse), or milliseconds?"
            ),
        ));
    }
}

pub(super) fn gravity(environment: &Environment, findings: &mut Vec<Finding>) {
    let gravity = environment.gravity;
    let size = gravity.iter().map(|x| x * x).sum::<f32>().sqrt();
    if !size.is_finite() {
        findings.push(Finding::error(
            "GRAVITY_INVALID",
            format!("gravity is {gravity:?}, which is not finite: give it in m/s²"),
        ));
        return;
    }
    if size == 0.0 {
        findings.push(Finding::warning(
            "GRAVITY_MISSING",
            "gravity is zero, so the twin will not hang or fall: give about 9.81 m/s² downwards"
                .to_owned(),
        ));
        return;
    }
    if !GRAVITY.contains(&size) {
        findings.push(Finding::warning(
            "GRAVITY_IMPLAUSIBLE",
            format!("gravity is {size} m/s²: about 9.81 is usual, is it in other units?"),
        ));
    }
    let up = environment.ground.map_or([0.0, 0.0, 1.0], |g| g.normal);
    let down = -(gravity[0] * up[0] + gravity[1] * up[1] + gravity[2] * up[2]) / size;
    if down < MAX_TILT_COS {
        let degrees = down.clamp(-1.0, 1.0).acos().to_degrees();
        findings.push(Finding::error(
            "GRAVITY_DIRECTION",
            format!(
                "gravity points {degrees:.0} degrees away from straight down onto the ground: is the up axis right?"
            ),
        ));
    }
}
