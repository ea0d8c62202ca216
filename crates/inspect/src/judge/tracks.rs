//! Judge of 2D tracks: whether they lie on the masks, how many survive, whether they move.

use super::{Assessment, Context, named, paths::travel};
use crate::{
    Code, Finding,
    inspection::TrackReport,
    scan::{CameraScan, tracks::TrackCounts},
    statistics::{mean, share},
};

pub(super) fn judge(context: &Context<'_>, assessment: &mut Assessment) {
    if !context.scans.is_empty() && context.scans.iter().all(|scan| scan.track_count.is_none()) {
        let message = "there are no 2D tracks";
        assessment.findings.push(Finding::info(Code::TracksMissing, message));
        return;
    }
    for (index, scan) in context.scans.iter().enumerate() {
        let Some(count) = scan.track_count else { continue };
        let report = report(scan, count);
        on_masks(context, index, scan, &report, assessment);
        survival(context, index, scan, &report, assessment);
        if report.inside.is_none_or(|inside| inside > 0.0) {
            motion(context, index, scan, assessment);
        }
        if let Some(camera) = assessment.cameras.get_mut(index) {
            camera.tracks = Some(report);
        }
    }
}

fn tracked(scan: &CameraScan) -> impl Iterator<Item = TrackCounts> + '_ {
    scan.frames.iter().map(|g| g.tracked.unwrap_or_default())
}

fn report(scan: &CameraScan, count: usize) -> TrackReport {
    let inside =
        tracked(scan).filter(|t| t.compared && t.visible > 0).map(|t| share(t.inside, t.visible));
    TrackReport {
        count,
        visible: tracked(scan).map(|t| t.visible).collect(),
        liftable: tracked(scan).map(|t| t.with_depth).collect(),
        inside: mean(inside),
    }
}

fn on_masks(
    context: &Context<'_>,
    index: usize,
    scan: &CameraScan,
    report: &TrackReport,
    assessment: &mut Assessment,
) {
    let limits = &context.thresholds.tracks;
    let name = named(context.recording, index);
    let bad: usize = tracked(scan).map(|t| t.not_finite).sum();
    let visible: usize = tracked(scan).map(|t| t.visible).sum();
    if bad > 0 {
        let message =
            format!("{bad} of {visible} visible track points of {name} are NaN or infinite");
        let finding = Finding::graded(
            bad as f64 > limits.max_not_finite_share * visible as f64,
            Code::TracksNotFinite,
            message,
        );
        assessment.findings.push(finding.cameras([index]).number("points", bad as f64));
    }
    let Some(inside) = report.inside.filter(|i| *i < limits.min_inside_share) else { return };
    let transposed = tracked(scan)
        .filter(|t| t.compared && t.visible > 0)
        .map(|t| share(t.inside_transposed, t.visible));
    let transposed = mean(transposed).unwrap_or(0.0);
    if transposed > limits.transposed_ratio * inside && transposed > limits.min_transposed_share {
        let message = format!(
            "{:.0} % of the tracks of {name} lie on its masks, and {:.0} % if x and y are exchanged",
            100.0 * inside,
            100.0 * transposed
        );
        assessment.findings.push(
            Finding::error(Code::TracksTransposed, message)
                .cameras([index])
                .number("inside", inside)
                .number("inside_exchanged", transposed),
        );
        return;
    }
    let message =
        format!("only {:.0} % of the visible tracks of {name} lie on its masks", 100.0 * inside);
    let finding = Finding::warning(Code::TracksOffObject, message);
    assessment.findings.push(finding.cameras([index]).number("inside", inside));
}

fn survival(
    context: &Context<'_>,
    index: usize,
    scan: &CameraScan,
    report: &TrackReport,
    assessment: &mut Assessment,
) {
    if assessment.findings.iter().any(|f| f.code == Code::TracksLost.name() && f.cameras.is_empty())
    {
        // All of them are lost.
        return;
    }
    let limits = &context.thresholds.tracks;
    let end = context.recording.train_frame_count.min(scan.frames.len());
    let most = report.visible.iter().copied().max().unwrap_or(0);
    // A hand before the lens loses tracks for a moment; what counts is what is left at the end.
    let tail = report.visible.get(end.saturating_sub(limits.end_frames)..end).unwrap_or_default();
    let left = tail.iter().copied().max().unwrap_or(0);
    let part = share(left, most);
    if most == 0 || part < limits.min_survival_share {
        let message = format!(
            "of {} tracks of {}, {left} are visible at the end of the part for fitting",
            report.count,
            named(context.recording, index)
        );
        let finding = Finding::warning(Code::TracksLost, message);
        assessment.findings.push(finding.cameras([index]).number("survivors", left as f64));
    }
}

fn motion(context: &Context<'_>, index: usize, scan: &CameraScan, assessment: &mut Assessment) {
    let limits = &context.thresholds.tracks;
    let moved = travel(&context.paths.object).unwrap_or(0.0);
    let width = context.recording.cameras.get(index).map_or(0, |c| c.width) as f64;
    let Some(reach) = scan.track_reach_px else { return };
    if moved > limits.min_travel_m && reach < limits.still_px.max(limits.still_widths * width) {
        let message = format!(
            "the tracks of {} move {reach:.1} px while the object moves {:.0} mm",
            named(context.recording, index),
            1e3 * moved
        );
        let finding = Finding::warning(Code::TracksStill, message);
        assessment.findings.push(finding.cameras([index]).number("reach_px", reach));
    }
}
