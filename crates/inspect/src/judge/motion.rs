//! Judge of motion and contact: whether anything moves, how fast, whether motion jumps, whether the
//! hand touches the object.

use super::{
    Assessment, Context, named,
    paths::{Path, step, steps, travel},
};
use crate::{
    Code, Finding,
    statistics::{median, share},
    vector::{add, length, sub},
};

pub(super) fn judge(context: &Context<'_>, assessment: &mut Assessment) {
    let frames = context.recording.frame_count;
    let object = travel(&context.paths.object);
    let hand = travel(&context.paths.manipulator);
    assessment.scene.travel_m = object;
    assessment.scene.manipulator_travel_m = hand;
    let by_frame = steps(&context.paths.object, frames);
    let fps = context.recording.fps;
    let fastest = by_frame.iter().flatten().copied().max_by(f64::total_cmp);
    assessment.scene.fastest_m_s = fastest.map(|s| s * fps).filter(|s| s.is_finite());
    assessment.scene.gap_m = (0..frames)
        .map(|f| {
            let gaps = context.scans.iter().filter_map(|scan| scan.frames.get(f)?.gap_m);
            gaps.min_by(f64::total_cmp)
        })
        .collect();
    first_image(context, object, hand, assessment);
    fast(context, &by_frame, assessment);
    for (index, path) in context.paths.object.iter().enumerate() {
        skips(context, index, path, assessment);
    }
    contact(context.thresholds.motion.max_gap_m, assessment);
}

fn first_image(
    context: &Context<'_>,
    object: Option<f64>,
    hand: Option<f64>,
    assessment: &mut Assessment,
) {
    let limits = &context.thresholds.motion;
    let Some(object) = object.filter(|m| *m < limits.still_m) else { return };
    // An object that bends in place moves its rim and its tracks.
    let tracks = context.scans.iter().filter_map(|l| l.track_reach_px).max_by(f64::total_cmp);
    let areas = context.scans.iter().filter_map(|scan| {
        let areas = scan.frames.iter().filter_map(|g| Some(g.object?.area_px as f64));
        let mut areas: Vec<f64> = areas.filter(|a| *a > 0.0).collect();
        let high = crate::statistics::quantile(&mut areas, 0.95)?;
        Some(high / crate::statistics::quantile(&mut areas, 0.05)?)
    });
    let changes = median(areas).is_some_and(|ratio| ratio > limits.same_area_ratio);
    if changes || tracks.is_some_and(|px| px > limits.still_px) {
        return;
    }
    let finding = match hand.filter(|m| *m >= limits.still_m) {
        Some(hand) => Finding::warning(
            Code::ObjectStill,
            format!(
                "the object moves {:.1} mm while the hand moves {:.0} mm",
                1e3 * object,
                1e3 * hand
            ),
        ),
        None => Finding::error(
            Code::NothingMoves,
            format!(
                "nothing moves more than {:.1} mm in the whole recording",
                1e3 * object.max(hand.unwrap_or(0.0))
            ),
        ),
    };
    assessment.findings.push(finding.number("object_travel_mm", 1e3 * object));
}

fn fast(context: &Context<'_>, by_frame: &[Option<f64>], assessment: &mut Assessment) {
    let limits = &context.thresholds.motion;
    let pixels = |frame: usize| {
        let one = |(camera, scan): (&bendtwin_capture::raw::Camera, &crate::scan::CameraScan)| {
            let middle = |f: usize| {
                scan.frames.get(f)?.object.filter(|p| p.area_px > 0).map(|p| p.middle_px)
            };
            let (a, b) = (middle(frame.checked_sub(1)?)?, middle(frame)?);
            Some((a[0] - b[0]).hypot(a[1] - b[1]) / camera.width.max(1) as f64)
        };
        median(context.recording.cameras.iter().zip(context.scans).filter_map(one))
    };
    let is_fast = |(frame, moved): (usize, &Option<f64>)| {
        let widths = pixels(frame);
        let fast = moved.is_some_and(|m| m > limits.fast_m)
            || widths.is_some_and(|w| w > limits.fast_widths);
        fast.then_some(frame)
    };
    let frames: Vec<usize> = by_frame.iter().enumerate().filter_map(is_fast).collect();
    if frames.len() < limits.min_fast_frames {
        return;
    }
    let fastest = by_frame.iter().flatten().copied().fold(0.0, f64::max);
    let message = format!(
        "the object moves up to {:.0} mm from one frame to the next, and too far in {} frames: images blur and tracks are lost",
        1e3 * fastest,
        frames.len()
    );
    assessment.findings.push(
        Finding::warning(Code::MotionTooFast, message)
            .frames(frames)
            .number("largest_step_mm", 1e3 * fastest),
    );
}

fn skips(context: &Context<'_>, index: usize, path: &Path, assessment: &mut Assessment) {
    let limits = &context.thresholds.motion;
    let mut moving = 0;
    let mut skipped = Vec::new();
    for frame in 2..path.len().saturating_sub(2) {
        let Some(own) = step(path, frame) else { continue };
        let around = [frame - 2, frame - 1, frame + 1, frame + 2];
        let Some(usual) = median(around.into_iter().filter_map(|f| step(path, f))) else {
            continue;
        };
        // An object that stuck to the ground jumps, too, when it comes loose, after shorter steps.
        let beside: Vec<f64> =
            [frame - 1, frame + 1].into_iter().filter_map(|f| step(path, f)).collect();
        let shortest = beside.iter().copied().fold(f64::INFINITY, f64::min);
        let longest = beside.iter().copied().fold(0.0, f64::max);
        let is_steady = shortest > limits.steady_ratio * usual && own > limits.skip_ratio * longest;
        if usual > limits.moving_ratio * limits.skip_m {
            moving += 1;
            let is_long = own > limits.skip_m && own > limits.skip_ratio * usual;
            if is_steady && is_long && keeps_way(path, frame) {
                skipped.push(frame);
            }
        }
    }
    let part = share(skipped.len(), moving);
    if skipped.len() >= limits.min_skips && part > limits.min_skip_share {
        let message = format!(
            "in {}, the object jumps ahead in {} of the {moving} frames in which it moves: frames were dropped and the others \
             numbered without gaps",
            named(context.recording, index),
            skipped.len()
        );
        assessment.findings.push(
            Finding::warning(Code::FramesSkipped, message)
                .cameras([index])
                .frames(skipped)
                .number("skipped_share", part),
        );
    }
}

/// True if a long step leads where the steps before and after it lead: a missing frame does not bend the
/// way, noise does.
fn keeps_way(path: &Path, frame: usize) -> bool {
    let way = |from: usize, to: usize| {
        let at = |f: usize| path.get(f).copied().flatten();
        Some(sub(at(to)?, at(from)?))
    };
    let around = way(frame - 2, frame - 1).zip(way(frame, frame + 1));
    let Some(((before, after), own)) = around.zip(way(frame - 1, frame)) else { return true };
    length(sub(own, add(before, after))) < 0.5 * length(own)
}

fn contact(max_gap_m: f64, assessment: &mut Assessment) {
    let gaps = &assessment.scene.gap_m;
    let Some(nearest) = gaps.iter().flatten().copied().min_by(f64::total_cmp) else { return };
    if nearest > max_gap_m {
        let message = format!(
            "the hand never comes nearer to the object than {:.0} mm (limit {:.0})",
            1e3 * nearest,
            1e3 * max_gap_m
        );
        let finding = Finding::error(Code::NoContact, message);
        assessment.findings.push(finding.number("nearest_mm", 1e3 * nearest));
    }
}
