//! Judge of timing: dropped, repeated, frozen and late frames; times against the frame rate. A camera
//! that gives every second frame records at half the rate, and drops none: see [`rhythm`].

mod closed_up;
mod rhythm;

use bendtwin_capture::raw::Camera;

use self::rhythm::Rhythm;
use super::{Assessment, Context, named};
use crate::{
    Code, Finding,
    scan::{CameraScan, FrameStats},
    statistics::{median, share},
};

pub(super) fn judge(context: &Context<'_>, assessment: &mut Assessment) {
    let same = repeats(context.scans);
    let pauses = pauses(&same, context.thresholds.timing.min_pause_frames);
    for (index, scan) in context.scans.iter().enumerate() {
        missing(context, index, scan, assessment);
        repeated(context, index, &same, &pauses, assessment);
        frozen_depth(context, index, scan, assessment);
        frozen_color(context, index, scan, assessment);
    }
    for (index, camera) in context.recording.cameras.iter().enumerate() {
        late(context, index, camera, assessment);
    }
    skew_by_times(context, assessment);
}

fn missing(context: &Context<'_>, index: usize, scan: &CameraScan, assessment: &mut Assessment) {
    let limits = &context.thresholds.timing;
    let lacks = |g: &FrameStats| g.color.is_none() || g.depth.is_none();
    let missing: Vec<usize> =
        scan.frames.iter().enumerate().filter(|(_, g)| lacks(g)).map(|(f, _)| f).collect();
    let rhythm = slower(context, index, scan, assessment);
    let is_due = |frame: &usize| rhythm.as_ref().is_none_or(|rhythm| rhythm.is_due(*frame));
    // Files that exist but are damaged have a separate finding.
    let damaged = |frame: &usize| scan.is_damaged(*frame);
    let frames: Vec<usize> = missing.iter().copied().filter(|f| is_due(f) && !damaged(f)).collect();
    let all = scan.frames.len();
    if let Some(finding) = closed_up::judge(context, index) {
        assessment.findings.push(finding);
    } else if !frames.is_empty() && frames.len() < all {
        let part = share(frames.len(), all);
        let ends = frames.len() >= limits.min_cut_frames
            && frames.iter().rev().zip((0..all).rev()).all(|(f, end)| *f == end);
        let message = if ends {
            format!(
                "{} ends at frame {}: the last {} of {all} frames are missing",
                named(context.recording, index),
                frames.first().copied().unwrap_or(0),
                frames.len()
            )
        } else {
            format!(
                "{} lacks colour or depth in {} of {all} frames ({:.0} %)",
                named(context.recording, index),
                frames.len(),
                100.0 * part
            )
        };
        assessment.findings.push(
            Finding::graded(part > limits.max_lost_share, Code::FramesDropped, message)
                .cameras([index])
                .frames(frames.iter().copied())
                .number("missing_share", part)
                .number("missing_frames", frames.len() as f64),
        );
    }
    if let Some(report) = assessment.cameras.get_mut(index) {
        report.missing_frames = missing;
    }
}

/// The rhythm of a camera that records at a lower rate than the recording has, with its finding.
fn slower(
    context: &Context<'_>,
    index: usize,
    scan: &CameraScan,
    assessment: &mut Assessment,
) -> Option<Rhythm> {
    // Colour without depth is no frame that was never taken.
    let is_there = |g: &FrameStats| g.color.is_some() || g.depth.is_some();
    let there: Vec<bool> = scan.frames.iter().map(is_there).collect();
    let fps = context.recording.fps;
    let declared = || {
        let own = context.recording.cameras.get(index)?.fps?;
        Rhythm::declared(&there, fps, own)
    };
    let rhythm = Rhythm::of(&there, fps, &context.thresholds.timing).or_else(declared)?;
    let name = named(context.recording, index);
    let message = format!(
        "{name} recorded at {} fps, the recording has {fps}: it is left out where it has no frame",
        rhythm.fps
    );
    assessment.findings.push(
        Finding::info(Code::CameraSlower, message)
            .cameras([index])
            .number("camera_fps", rhythm.fps)
            .number("declared_fps", fps),
    );
    Some(rhythm)
}

/// Repeats: true where a camera shows the same in a frame as in the one before, `None` where it lacks
/// one of both, shape [camera][T].
fn repeats(scans: &[CameraScan]) -> Vec<Vec<Option<bool>>> {
    let same = |(before, now): (&FrameStats, &FrameStats)| {
        let color = before.color? == now.color?;
        let depth = now.depth.is_none() || before.depth == now.depth;
        Some(color && depth)
    };
    let one = |scan: &CameraScan| {
        let pairs = scan.frames.iter().zip(scan.frames.iter().skip(1));
        std::iter::once(Some(false)).chain(pairs.map(same)).take(scan.frames.len()).collect()
    };
    scans.iter().map(one).collect()
}

/// True for each frame in a pause: a still scene without noise looks like repeated frames in all
/// cameras, but counts as a pause if it lasts or if it is the beginning or the end. A camera without
/// images there says nothing.
fn pauses(same: &[Vec<Option<bool>>], min_pause_frames: usize) -> Vec<bool> {
    let frames = same.iter().map(Vec::len).max().unwrap_or(0);
    let is_still =
        |f: usize| same.iter().all(|camera| camera.get(f).is_some_and(|s| *s != Some(false)));
    let still: Vec<bool> = (0..frames).map(is_still).collect();
    let mut first = 0;
    let mut pauses = Vec::with_capacity(frames);
    for run in still.chunk_by(|a, b| a == b) {
        let end = first + run.len();
        let is_pause = run[0] && (first <= 1 || end == frames || run.len() >= min_pause_frames);
        pauses.extend(std::iter::repeat_n(is_pause, run.len()));
        first = end;
    }
    pauses
}

fn repeated(
    context: &Context<'_>,
    index: usize,
    same: &[Vec<Option<bool>>],
    pauses: &[bool],
    assessment: &mut Assessment,
) {
    let limits = &context.thresholds.timing;
    let Some(own) = same.get(index) else { return };
    let frames: Vec<usize> = own
        .iter()
        .zip(pauses)
        .enumerate()
        .filter(|(_, (repeats, is_pause))| **repeats == Some(true) && !**is_pause)
        .map(|(f, _)| f)
        .collect();
    if frames.len() > limits.max_repeats {
        let part = share(frames.len(), own.len());
        let name = named(context.recording, index);
        let (count, all) = (frames.len(), own.len());
        let fresh: Vec<bool> = own.iter().map(|repeats| *repeats != Some(true)).collect();
        let rhythm = Rhythm::of(&fresh, context.recording.fps, limits);
        let message = match &rhythm {
            Some(Rhythm { fps, .. }) => format!(
                "{name} recorded at {fps} fps: {count} of its {all} frames repeat the frame before"
            ),
            None => format!(
                "{count} of {all} frames of {name} ({:.0} %) repeat the frame before",
                100.0 * part
            ),
        };
        // Of a slower camera every frame is there, and most of the repeats are nearly right.
        let is_error = part > limits.max_lost_share && rhythm.is_none();
        assessment.findings.push(
            Finding::graded(is_error, Code::FramesDuplicated, message)
                .cameras([index])
                .frames(frames.iter().copied())
                .number("repeated_share", part)
                .number("repeated_frames", frames.len() as f64),
        );
    }
    if let Some(report) = assessment.cameras.get_mut(index) {
        report.repeated_frames = frames;
    }
}

/// Depth that stays while colour changes.
fn frozen_depth(
    context: &Context<'_>,
    index: usize,
    scan: &CameraScan,
    assessment: &mut Assessment,
) {
    // Depth that is empty everywhere is missing, not frozen.
    let has_depth =
        |g: &FrameStats| [g.object, g.manipulator].into_iter().flatten().any(|m| m.depth_px > 0);
    let is_frozen =
        |a: &FrameStats, b: &FrameStats| has_depth(b) && a.depth == b.depth && a.color != b.color;
    let words = ["depth", "colour"];
    let found = frozen(context, index, scan, Code::DepthFrozen, words, is_frozen);
    assessment.findings.extend(found);
}

/// Colour that stays while depth changes.
fn frozen_color(
    context: &Context<'_>,
    index: usize,
    scan: &CameraScan,
    assessment: &mut Assessment,
) {
    let is_frozen = |a: &FrameStats, b: &FrameStats| {
        b.color.is_some() && a.color == b.color && a.depth != b.depth
    };
    let words = ["colour", "depth"];
    let found = frozen(context, index, scan, Code::ColorFrozen, words, is_frozen);
    assessment.findings.extend(found);
}

/// The finding about frames in which one kind of image is that of the frame before, while the other
/// kind changes; none if they are few.
fn frozen(
    context: &Context<'_>,
    index: usize,
    scan: &CameraScan,
    code: Code,
    [still, moving]: [&'static str; 2],
    is_frozen: impl Fn(&FrameStats, &FrameStats) -> bool,
) -> Option<Finding> {
    let limits = &context.thresholds.timing;
    let pairs = scan.frames.iter().zip(scan.frames.iter().skip(1)).enumerate();
    let frozen: Vec<usize> =
        pairs.filter(|(_, (a, b))| is_frozen(a, b)).map(|(f, _)| f + 1).collect();
    let part = share(frozen.len(), scan.frames.len());
    if part <= limits.max_unfrozen_share || frozen.len() <= limits.max_unfrozen_frames {
        return None;
    }
    let message = format!(
        "{still} of {} does not change in {} of {} frames, while {moving} does",
        named(context.recording, index),
        frozen.len(),
        scan.frames.len()
    );
    let finding = Finding::graded(part > limits.max_lost_share, code, message)
        .cameras([index])
        .frames(frozen)
        .number("frozen_share", part);
    Some(finding)
}

fn late(context: &Context<'_>, index: usize, camera: &Camera, assessment: &mut Assessment) {
    let limits = &context.thresholds.timing;
    let fps = context.recording.fps;
    let known: Vec<(usize, f64)> =
        camera.times_s.iter().copied().enumerate().filter(|(_, t)| t.is_finite()).collect();
    let (Some(first), Some(last)) = (known.first(), known.last()) else { return };
    if !(fps.is_finite() && fps > 0.0) || last.0 <= first.0 {
        return;
    }
    let name = named(context.recording, index);
    let interval = median(known.windows(2).filter_map(|w| match w {
        [a, b] => Some((b.1 - a.1) / (b.0 - a.0).max(1) as f64),
        _ => None,
    }));
    let measured = 1.0 / interval.unwrap_or(f64::NAN);
    if (measured / fps - 1.0).abs() > limits.max_rate_error || measured.is_nan() {
        let message = format!(
            "by its times, {name} records {measured:.2} frames per second; {fps} are declared"
        );
        assessment.findings.push(
            Finding::warning(Code::FpsMismatch, message)
                .cameras([index])
                .number("measured_fps", measured)
                .number("declared_fps", fps),
        );
    }
    let nominal = interval.unwrap_or(1.0 / fps);
    let late: Vec<usize> = known
        .windows(2)
        .filter_map(|w| match w {
            [a, b] => {
                (b.1 - a.1 > limits.late_intervals * nominal * (b.0 - a.0) as f64).then_some(b.0)
            }
            _ => None,
        })
        .collect();
    if !late.is_empty() {
        let message = format!(
            "{} of {} frames of {name} come later than {:.1} frame times after the one before",
            late.len(),
            known.len(),
            limits.late_intervals
        );
        assessment.findings.push(
            Finding::warning(Code::FramesLate, message)
                .cameras([index])
                .frames(late.iter().copied())
                .number("late_share", share(late.len(), known.len())),
        );
    }
    if let Some(report) = assessment.cameras.get_mut(index) {
        report.late_frames = late;
    }
}

fn skew_by_times(context: &Context<'_>, assessment: &mut Assessment) {
    let limits = &context.thresholds.timing;
    let cameras = &context.recording.cameras;
    let time = |c: &Camera, f: usize| c.times_s.get(f).copied().filter(|t| t.is_finite());
    if cameras.iter().filter(|c| !c.times_s.is_empty()).count() < 2 {
        return;
    }
    // Enough frames for a median; a recording of hours has the same skew.
    let step = context.recording.frame_count.div_ceil(2000).max(1);
    let frames = || (0..context.recording.frame_count).step_by(step);
    let middles: Vec<Option<f64>> =
        frames().map(|f| median(cameras.iter().filter_map(|c| time(c, f)))).collect();
    for (index, camera) in cameras.iter().enumerate() {
        let offsets =
            frames().zip(&middles).filter_map(|(f, middle)| Some(time(camera, f)? - (*middle)?));
        let Some(skew) = median(offsets) else { continue };
        let skew_ms = 1e3 * skew;
        if let Some(report) = assessment.cameras.get_mut(index) {
            report.skew_by_times_ms = Some(skew_ms);
        }
        if skew.abs() * context.recording.fps > limits.max_skew_frames {
            let name = named(context.recording, index);
            let order = if skew > 0.0 { "after" } else { "before" };
            let message = format!(
                "by its times, {name} takes its frames {:.0} ms {order} the others",
                skew_ms.abs()
            );
            assessment.findings.push(
                Finding::graded(
                    skew.abs() * context.recording.fps > limits.bad_skew_frames,
                    Code::CamerasSkewed,
                    message,
                )
                .cameras([index])
                .number("skew_ms", skew_ms),
            );
        }
    }
}

#[cfg(test)]
mod tests;
