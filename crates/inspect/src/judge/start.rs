//! Judge of what lifting needs: the object and its tracks in the first frame and to the end of the
//! frames for fitting, a hand without long gaps, a mesh that can be read. Lifting refuses by the
//! same rules and with the same words.

use bendtwin_core::settings::ingest::ControlSettings;

use super::{Assessment, Context};
use crate::{Code, Finding, scan::FrameStats};

pub(super) fn judge(context: &Context<'_>, assessment: &mut Assessment) {
    if context.scans.is_empty() {
        return;
    }
    object(context, assessment);
    hand(context, assessment);
    mesh(context, assessment);
}

/// Sum over all cameras, for each frame.
fn by_frame(context: &Context<'_>, of: impl Fn(&FrameStats) -> usize) -> Vec<usize> {
    let frames = context.recording.frame_count;
    let sum = |frame| context.scans.iter().filter_map(|s| s.frames.get(frame)).map(&of).sum();
    (0..frames).map(sum).collect()
}

/// Frames for fitting, as far as they exist.
fn train_frames(context: &Context<'_>) -> usize {
    context.recording.train_frame_count.min(context.recording.frame_count)
}

fn object(context: &Context<'_>, assessment: &mut Assessment) {
    let object_px = by_frame(context, |g| g.object.map_or(0, |o| o.depth_px));
    if object_px.iter().all(|px| *px == 0) {
        // That case has separate findings.
        return;
    }
    if object_px.first() == Some(&0) {
        let frame = object_px.iter().position(|px| *px > 0).unwrap_or(0);
        let message = format!(
            "no camera sees the object with depth in frame 0, where its points start; the first that does is in frame {frame}"
        );
        let finding = Finding::error(Code::ObjectNotTracked, message).frames([0]);
        assessment.findings.push(finding);
        return;
    }
    let train = train_frames(context);
    let gone = object_px.iter().rposition(|px| *px > 0).map_or(0, |last| last + 1);
    if gone < train {
        // The cameras' own findings say no more.
        assessment.findings.retain(|f| f.code != Code::ObjectMaskEmpty.name());
        let message = format!(
            "no camera sees the object from frame {gone} on, and {train} frames are for fitting"
        );
        assessment
            .findings
            .push(Finding::error(Code::ObjectMaskEmpty, message).frames(gone..train));
        return;
    }
    tracks(context, assessment);
}

fn tracks(context: &Context<'_>, assessment: &mut Assessment) {
    let least = context.thresholds.start.min_tracks;
    if context.scans.iter().any(|s| s.track_count.is_none_or(|count| count == 0)) {
        // The built-in tracker follows what it finds there.
        let seeds: Vec<usize> = context.scans.iter().filter_map(|s| s.seed_count).collect();
        let own = context.scans.iter().any(|s| s.track_count.is_some_and(|count| count > 0));
        if !own && !seeds.is_empty() && seeds.iter().sum::<usize>() == 0 {
            let message = "there are no tracks, and the object is too plain for the built-in tracker: it finds no spot to \
                           follow in frame 0";
            assessment.findings.push(Finding::error(Code::ObjectNotTracked, message));
        }
        return;
    }
    let on_object = by_frame(context, |g| g.tracked.map_or(0, |t| t.on_object));
    let Some(start) = on_object.first().copied() else { return };
    if start == 0 {
        let message = "no track lies on the object in frame 0";
        assessment.findings.push(Finding::error(Code::ObjectNotTracked, message).frames([0]));
        return;
    }
    let train = train_frames(context);
    let gone = on_object.iter().rposition(|n| *n >= least).map_or(0, |last| last + 1);
    if gone < train {
        let message = format!(
            "fewer than {least} of {start} tracks on the object are seen from frame {gone} on, and {train} frames are for fitting"
        );
        let finding = Finding::error(Code::TracksLost, message).frames(gone..train);
        assessment.findings.push(finding.number("tracks", start as f64));
    }
}

fn hand(context: &Context<'_>, assessment: &mut Assessment) {
    let px = by_frame(context, |g| g.manipulator.map_or(0, |m| m.depth_px));
    let seen: Vec<bool> = px.iter().map(|px| *px >= ControlSettings::MIN_PIXELS).collect();
    let settings = &context.settings.controls;
    let Some(gap) = settings.gap(&seen) else { return };
    let last = gap.end - 1;
    let recorded = |frame: usize| {
        let frames = context.scans.iter().filter_map(|s| s.frames.get(frame));
        frames.into_iter().any(|g| g.color.is_some() && g.depth.is_some())
    };
    let (code, message) = if !gap.clone().any(recorded) {
        let which = if gap.len() == 1 {
            format!("frame {last}")
        } else {
            format!("frames {} to {last}", gap.start)
        };
        let message = format!(
            "no camera has colour and depth in {which}: tracks start in frame 0, and a hand's motion is filled in for up to {} \
             frames",
            settings.max_gap_frames
        );
        (Code::FramesDropped, message)
    } else if gap.start == 0 {
        let message = format!(
            "the hand's masks are empty up to frame {last}: control points start in frame 0, where the hand has to be seen"
        );
        (Code::HandNotTracked, message)
    } else {
        let message = format!(
            "no mask shows the hand from frame {} to {last}, and gaps are filled up to {} frames",
            gap.start, settings.max_gap_frames
        );
        (Code::HandLost, message)
    };
    let (count, from_start) = (gap.len() as f64, gap.start == 0);
    let mut finding = Finding::error(code, message).frames(gap).number("hidden_frames", count);
    if code == Code::FramesDropped {
        // The cameras' own findings say no more.
        assessment.findings.retain(|f| f.code != code.name());
        finding = finding.explains(if from_start { Code::HandNotTracked } else { Code::HandLost });
    }
    assessment.findings.push(finding);
}

fn mesh(context: &Context<'_>, assessment: &mut Assessment) {
    let Some(file) = &context.recording.mesh else { return };
    if !context.settings.completion.mesh {
        return;
    }
    if let Err(error) =
        bendtwin_mesh::parse(&file.name, &file.bytes, &bendtwin_mesh::Limits::default())
    {
        let message = format!("the mesh `{}` cannot be used: {error}", file.name);
        assessment.findings.push(Finding::error(Code::MeshUnusable, message));
    }
}
