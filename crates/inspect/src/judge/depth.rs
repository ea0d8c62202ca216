//! Judge of depth over the object: coverage, depth that does not belong to it, numbers that are not
//! finite.

use super::{Assessment, Context, named};
use crate::{
    Code, Finding,
    scan::{CameraScan, FrameStats},
    statistics::{median, share},
};

pub(super) fn judge(context: &Context<'_>, assessment: &mut Assessment) {
    let masked = |l: &CameraScan| l.frames.iter().any(|g| g.object.is_some_and(|p| p.area_px > 0));
    let lifted = |l: &CameraScan| l.frames.iter().any(|g| g.object.is_some_and(|p| p.depth_px > 0));
    if context.scans.iter().any(masked) && !context.scans.iter().any(lifted) {
        let message = "no camera has depth on a single pixel of the object";
        assessment.findings.push(Finding::error(Code::DepthEmpty, message));
        return;
    }
    for (index, scan) in context.scans.iter().enumerate() {
        coverage(context, index, scan, assessment);
        apart(context, index, scan, assessment);
        not_finite(context, index, scan, assessment);
        filled(context, index, scan, assessment);
    }
}

/// Share of the object's pixels that have depth in a frame.
fn covered(frame: &FrameStats) -> Option<f64> {
    let patch = frame.object.filter(|p| p.area_px > 0)?;
    frame.depth.map(|_| share(patch.depth_px, patch.area_px))
}

/// True if a camera measures depth on little of the object.
pub(super) fn is_sparse(context: &Context<'_>, scan: &CameraScan) -> bool {
    let middle = median(scan.frames.iter().filter_map(covered));
    middle.is_some_and(|middle| middle < context.thresholds.depth.good_coverage)
}

fn coverage(context: &Context<'_>, index: usize, scan: &CameraScan, assessment: &mut Assessment) {
    let limits = &context.thresholds.depth;
    let shares: Vec<Option<f64>> = scan.frames.iter().map(covered).collect();
    let middle = median(shares.iter().flatten().copied());
    if let Some(report) = assessment.cameras.get_mut(index) {
        report.coverage = shares;
        report.median_coverage = middle;
    }
    let Some(middle) = middle.filter(|m| *m < limits.good_coverage) else { return };
    let message = format!(
        "{} measures depth on {:.0} % of the object's pixels (at least {:.0} % are good)",
        named(context.recording, index),
        100.0 * middle,
        100.0 * limits.good_coverage
    );
    let finding = Finding::graded(middle < limits.min_coverage, Code::DepthSparse, message);
    assessment.findings.push(finding.cameras([index]).number("median_coverage", middle));
}

fn apart(context: &Context<'_>, index: usize, scan: &CameraScan, assessment: &mut Assessment) {
    let limits = &context.thresholds.depth;
    let shares = scan.frames.iter().filter_map(|g| Some(g.object?.surface?.apart));
    let Some(part) = median(shares).filter(|p| *p > limits.max_apart_share) else { return };
    // A cable that is seen end-on reaches farther in depth than across the image.
    let extent = |scan: &CameraScan| {
        median(scan.frames.iter().filter_map(|g| Some(g.object?.surface?.extent_m)))
    };
    let longest = context.scans.iter().filter_map(extent).fold(0.0, f64::max);
    if extent(scan).is_some_and(|own| longest > limits.end_on_ratio * own) {
        return;
    }
    let message = format!(
        "{:.0} % of the depth on the object in {} lies far before or behind it",
        100.0 * part,
        named(context.recording, index)
    );
    let finding = Finding::warning(Code::MaskShowsBackground, message);
    assessment.findings.push(finding.cameras([index]).number("share_apart", part));
}

fn filled(context: &Context<'_>, index: usize, scan: &CameraScan, assessment: &mut Assessment) {
    let limits = &context.thresholds.depth;
    let part = |g: &FrameStats| {
        let area = g.object.filter(|o| o.area_px > 0)?.area_px;
        g.fill_value_m.map(|_| share(g.filled_px, area))
    };
    let shares: Vec<f64> = scan.frames.iter().filter_map(part).collect();
    let value = scan.frames.iter().find_map(|g| g.fill_value_m);
    let worst = shares.iter().copied().fold(0.0, f64::max);
    let Some(value) = value.filter(|_| worst > limits.max_filled_share) else { return };
    let message = format!(
        "depth of {} is {value:.3} m, to the last digit, in up to {:.0} % of the object's pixels: a number that stands \
         for no depth, which is taken as such here",
        named(context.recording, index),
        100.0 * worst
    );
    let finding = Finding::warning(Code::DepthFilled, message).cameras([index]);
    let finding = finding.number("value_m", f64::from(value)).number("largest_share", worst);
    assessment.findings.push(finding);
}

fn not_finite(context: &Context<'_>, index: usize, scan: &CameraScan, assessment: &mut Assessment) {
    let bad: usize = scan.frames.iter().map(|g| g.bad_depth_px).sum();
    if bad == 0 {
        return;
    }
    let frames = scan.frames.iter().enumerate().filter(|(_, g)| g.bad_depth_px > 0);
    let message = format!(
        "{bad} depths of {} are NaN, infinite or negative",
        named(context.recording, index)
    );
    assessment.findings.push(
        Finding::warning(Code::DepthNotFinite, message)
            .cameras([index])
            .frames(frames.map(|(f, _)| f))
            .number("pixels", bad as f64),
    );
}
