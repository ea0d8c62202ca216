//! Depth over the object: coverage, what does not belong to it, numbers that are none.

use super::{Case, Record, named};
use crate::{
    Finding,
    statistics::{median, share},
    watch::{Glance, Log},
};

/// Share of the object that should have depth.
const GOOD: f64 = 0.6;
/// With less, a camera contributes nothing.
const POOR: f64 = 0.1;
/// Share of a mask's points that may lie far from the rest.
const APART: f64 = 0.12;

pub(super) fn judge(case: &Case<'_>, record: &mut Record) {
    let masked = |l: &Log| l.glances.iter().any(|g| g.object.is_some_and(|p| p.area_px > 0));
    let lifted = |l: &Log| l.glances.iter().any(|g| g.object.is_some_and(|p| p.depth_px > 0));
    if case.logs.iter().any(masked) && !case.logs.iter().any(lifted) {
        let message = "no camera has depth on a single pixel of the object";
        record.findings.push(Finding::error("DEPTH_EMPTY", message));
        return;
    }
    for (index, log) in case.logs.iter().enumerate() {
        coverage(case, index, log, record);
        apart(case, index, log, record);
        not_finite(case, index, log, record);
    }
}

fn coverage(case: &Case<'_>, index: usize, log: &Log, record: &mut Record) {
    let covered = |g: &Glance| {
        let patch = g.object.filter(|p| p.area_px > 0)?;
        g.depth.map(|_| share(patch.depth_px, patch.area_px))
    };
    let shares: Vec<Option<f64>> = log.glances.iter().map(covered).collect();
    let middle = median(shares.iter().flatten().copied());
    if let Some(report) = record.cameras.get_mut(index) {
        report.coverage = shares;
        report.median_coverage = middle;
    }
    let Some(middle) = middle.filter(|m| *m < GOOD) else { return };
    let message = format!(
        "{} measures depth on {:.0} % of the object's pixels (at least {:.0} % are good)",
        named(case.recording, index),
        100.0 * middle,
        100.0 * GOOD
    );
    let finding = Finding::graded(middle < POOR, "DEPTH_SPARSE", message);
    record.findings.push(finding.cameras([index]).number("median_coverage", middle));
}

fn apart(case: &Case<'_>, index: usize, log: &Log, record: &mut Record) {
    let shares = log.glances.iter().filter_map(|g| Some(g.object?.surface?.apart));
    let Some(part) = median(shares).filter(|p| *p > APART) else { return };
    let message = format!(
        "{:.0} % of the depth on the object in {} lies far before or behind it",
        100.0 * part,
        named(case.recording, index)
    );
    let finding = Finding::warning("DEPTH_MISALIGNED", message);
    record.findings.push(finding.cameras([index]).number("share_apart", part));
}

fn not_finite(case: &Case<'_>, index: usize, log: &Log, record: &mut Record) {
    let bad: usize = log.glances.iter().map(|g| g.bad_depth_px).sum();
    if bad == 0 {
        return;
    }
    let frames = log.glances.iter().enumerate().filter(|(_, g)| g.bad_depth_px > 0);
    let message =
        format!("{bad} depths of {} are NaN, infinite or negative", named(case.recording, index));
    record.findings.push(
        Finding::warning("DEPTH_NOT_FINITE", message)
            .cameras([index])
            .frames(frames.map(|(f, _)| f))
            .number("pixels", bad as f64),
    );
}
