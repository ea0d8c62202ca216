//! Judge of motion and contact: whether anything moves, how fast, whether motion jumps, whether the hand touches the object.

use super::{
    Assessment, Context, named,
    paths::{Path, step, steps, travel},
};
use crate::{
    Finding,
    statistics::{median, share},
};

/// What moves less stands still [m].
const STILL_M: f64 = 0.008;
/// Tracks that move less stand still [px].
const STILL_PX: f64 = 3.0;
/// A mask whose area changes by less does not change its shape.
const SAME_AREA: f64 = 1.15;
/// A hand that never comes nearer does not touch [m].
const CONTACT_M: f64 = 0.06;
/// Motion from frame to frame that blurs and loses tracks: metres, and widths of the image.
const FAST_M: f64 = 0.08;
const FAST_WIDTHS: f64 = 0.06;
/// So many fast frames are no chance.
const FAST_FRAMES: usize = 3;
/// A step so much longer than those around it skips a frame.
const SKIP: f64 = 1.65;
/// Steps below this are noise [m].
const SKIP_M: f64 = 0.006;
/// Share of moving frames that skip, and least number.
const SKIPS: f64 = 0.1;
const SKIPS_COUNT: usize = 3;

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
    contact(assessment);
}

fn first_image(
    context: &Context<'_>,
    object: Option<f64>,
    hand: Option<f64>,
    assessment: &mut Assessment,
) {
    let Some(object) = object.filter(|m| *m < STILL_M) else { return };
    // An object that bends in place moves its rim and its tracks.
    let tracks = context.scans.iter().filter_map(|l| l.track_reach_px).max_by(f64::total_cmp);
    let areas = context.scans.iter().filter_map(|scan| {
        let areas = scan.frames.iter().filter_map(|g| Some(g.object?.area_px as f64));
        let mut areas: Vec<f64> = areas.filter(|a| *a > 0.0).collect();
        let high = crate::statistics::quantile(&mut areas, 0.95)?;
        Some(high / crate::statistics::quantile(&mut areas, 0.05)?)
    });
    let changes = median(areas).is_some_and(|ratio| ratio > SAME_AREA);
    if changes || tracks.is_some_and(|px| px > STILL_PX) {
        return;
    }
    let finding = match hand.filter(|m| *m >= STILL_M) {
        Some(hand) => Finding::warning(
            "OBJECT_STILL",
            format!(
                "the object moves {:.1} mm while the hand moves {:.0} mm",
                1e3 * object,
                1e3 * hand
            ),
        ),
        None => Finding::error(
            "NOTHING_MOVES",
            format!(
                "nothing moves more than {:.1} mm in the whole recording",
                1e3 * object.max(hand.unwrap_or(0.0))
            ),
        ),
    };
    assessment.findings.push(finding.number("object_travel_mm", 1e3 * object));
}

fn fast(context: &Context<'_>, by_frame: &[Option<f64>], assessment: &mut Assessment) {
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
        let fast = moved.is_some_and(|m| m > FAST_M) || widths.is_some_and(|w| w > FAST_WIDTHS);
        fast.then_some(frame)
    };
    let frames: Vec<usize> = by_frame.iter().enumerate().filter_map(is_fast).collect();
    if frames.len() < FAST_FRAMES {
        return;
    }
    let fastest = by_frame.iter().flatten().copied().fold(0.0, f64::max);
    let message = format!(
        "the object moves up to {:.0} mm from one frame to the next, and too far in {} frames: images blur and tracks are lost",
        1e3 * fastest,
        frames.len()
    );
    assessment.findings.push(
        Finding::warning("MOTION_TOO_FAST", message)
            .frames(frames)
            .number("largest_step_mm", 1e3 * fastest),
    );
}

fn skips(context: &Context<'_>, index: usize, path: &Path, assessment: &mut Assessment) {
    let mut moving = 0;
    let mut skipped = Vec::new();
    for frame in 2..path.len().saturating_sub(2) {
        let Some(own) = step(path, frame) else { continue };
        let around = [frame - 2, frame - 1, frame + 1, frame + 2];
        let Some(usual) = median(around.into_iter().filter_map(|f| step(path, f))) else {
            continue;
        };
        if usual > 0.6 * SKIP_M {
            moving += 1;
            if own > SKIP_M && own > SKIP * usual {
                skipped.push(frame);
            }
        }
    }
    let part = share(skipped.len(), moving);
    if skipped.len() >= SKIPS_COUNT && part > SKIPS {
        let message = format!(
            "in {}, the object jumps ahead in {} of the {moving} frames in which it moves: frames were dropped and the others \
             numbered without gaps",
            named(context.recording, index),
            skipped.len()
        );
        assessment.findings.push(
            Finding::warning("FRAMES_SKIPPED", message)
                .cameras([index])
                .frames(skipped)
                .number("skipped_share", part),
        );
    }
}

fn contact(assessment: &mut Assessment) {
    let gaps = &assessment.scene.gap_m;
    let Some(nearest) = gaps.iter().flatten().copied().min_by(f64::total_cmp) else { return };
    if nearest > CONTACT_M {
        let message = format!(
            "the hand never comes nearer to the object than {:.0} mm (limit {:.0})",
            1e3 * nearest,
            1e3 * CONTACT_M
        );
        let finding = Finding::error("NO_CONTACT", message);
        assessment.findings.push(finding.number("nearest_mm", 1e3 * nearest));
    }
}
