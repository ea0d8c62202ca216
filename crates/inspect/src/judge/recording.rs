//! Judge of the recording as a whole: length, frame rate, split, damaged files, number of cameras.

use super::{Assessment, Context, named};
use crate::{Code, Finding, scan::COMPARED_CAMERAS, thresholds::RecordingThresholds};

pub(super) fn judge(context: &Context<'_>, assessment: &mut Assessment) {
    let recording = context.recording;
    let limits = &context.thresholds.recording;
    let findings = &mut assessment.findings;
    length(recording.frame_count, recording.train_frame_count, limits, findings);
    frame_rate(recording.fps, limits, findings);
    for (index, scan) in context.scans.iter().enumerate() {
        if let Some(report) = assessment.cameras.get_mut(index) {
            report.damaged_files = scan.damaged_file_count;
        }
        damage(context, index, scan, findings);
        let usable = scan.frames.iter().any(|g| g.color.is_some() && g.depth.is_some());
        if !usable && recording.frame_count > 0 {
            let name = named(recording, index);
            let message = format!("{name} has no frame with both colour and depth");
            findings.push(Finding::error(Code::CameraEmpty, message).cameras([index]));
        }
    }
    let count = recording.cameras.len();
    if count == 0 {
        findings.push(Finding::error(Code::NoFrames, "the recording has no cameras"));
    }
    if count == 1 {
        let message = "there is one camera, so half of the object is never seen";
        findings.push(Finding::info(Code::SingleCamera, message));
    }
    if count > COMPARED_CAMERAS {
        let message =
            format!("there are {count} cameras; only the first {COMPARED_CAMERAS} are compared");
        let finding = Finding::warning(Code::TooManyCameras, message);
        findings.push(finding.number("cameras", count as f64));
    }
}

fn length(frames: usize, train: usize, limits: &RecordingThresholds, findings: &mut Vec<Finding>) {
    match frames {
        0 => findings.push(Finding::error(Code::NoFrames, "the recording has no frames")),
        1 => findings
            .push(Finding::error(Code::OneFrame, "the recording has one frame, so nothing moves")),
        2.. if frames < limits.min_frames => findings.push(
            Finding::warning(
                Code::FewFrames,
                format!(
                    "the recording has {frames} frames, too few to tell stiffness from damping"
                ),
            )
            .number("frames", frames as f64),
        ),
        _ => {}
    }
    if train < 2 && frames > 1 {
        let message = format!("only {train} of {frames} frames are for fitting");
        findings.push(Finding::error(Code::SplitEmpty, message).number("frames", train as f64));
    }
}

fn frame_rate(fps: f64, limits: &RecordingThresholds, findings: &mut Vec<Finding>) {
    if !(fps.is_finite() && fps > 0.0) {
        findings.push(Finding::error(Code::FpsInvalid, format!("the frame rate is {fps} fps")));
    } else if !limits.usual_fps.contains(&fps) {
        let message = format!("the frame rate is {fps} fps");
        findings.push(Finding::warning(Code::FpsImplausible, message).number("fps", fps));
    }
}

fn damage(
    context: &Context<'_>,
    index: usize,
    scan: &crate::scan::CameraScan,
    findings: &mut Vec<Finding>,
) {
    let Some(first) = scan.damaged_files.first() else { return };
    let limits = &context.thresholds.recording;
    let files = scan.damaged_file_count;
    let frames = context.recording.frame_count;
    let message = format!(
        "{files} file{} of {} cannot be read; the first ({}): {}",
        if files == 1 { "" } else { "s" },
        named(context.recording, index),
        first.reason,
        first.message
    );
    let finding =
        Finding::graded(limits.max_damaged_one_in * files > frames, Code::FramesDamaged, message);
    findings.push(
        finding
            .cameras([index])
            .frames(scan.damaged_files.iter().map(|d| d.frame))
            .number("files", files as f64),
    );
}
