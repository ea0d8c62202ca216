//! 2D tracks: whether they lie on the masks, how many survive, whether they move.

use super::{Case, Record, named, paths::travel};
use crate::{
    Finding,
    inspection::TrackReport,
    statistics::{mean, share},
    watch::{Log, tracked::Tracked},
};

/// Share of visible tracks that should lie on a mask.
const INSIDE: f64 = 0.6;
/// Share of the first frame's tracks that should be seen at the end of the part for fitting.
const SURVIVE: f64 = 0.15;
/// Object travel from which tracks must move [m], and by how much [px].
const TRAVEL_M: f64 = 0.05;
const STILL_PX: f64 = 1.0;
const STILL_WIDTHS: f64 = 0.004;

pub(super) fn judge(case: &Case<'_>, record: &mut Record) {
    if !case.logs.is_empty() && case.logs.iter().all(|log| log.track_count.is_none()) {
        let message = "there are no 2D tracks";
        record.findings.push(Finding::info("TRACKS_MISSING", message));
        return;
    }
    for (index, log) in case.logs.iter().enumerate() {
        let Some(count) = log.track_count else { continue };
        let report = report(log, count);
        lie(case, index, log, &report, record);
        survive(case, index, log, &report, record);
        move_along(case, index, log, record);
        if let Some(camera) = record.cameras.get_mut(index) {
            camera.tracks = Some(report);
        }
    }
}

fn tracked(log: &Log) -> impl Iterator<Item = Tracked> + '_ {
    log.glances.iter().map(|g| g.tracked.unwrap_or_default())
}

fn report(log: &Log, count: usize) -> TrackReport {
    let inside =
        tracked(log).filter(|t| t.compared && t.visible > 0).map(|t| share(t.inside, t.visible));
    TrackReport {
        count,
        visible: tracked(log).map(|t| t.visible).collect(),
        liftable: tracked(log).map(|t| t.with_depth).collect(),
        inside: mean(inside),
    }
}

fn lie(case: &Case<'_>, index: usize, log: &Log, report: &TrackReport, record: &mut Record) {
    let name = named(case.recording, index);
    let bad: usize = tracked(log).map(|t| t.not_finite).sum();
    let visible: usize = tracked(log).map(|t| t.visible).sum();
    if bad > 0 {
        let message =
            format!("{bad} of {visible} visible track points of {name} are NaN or infinite");
        let finding = Finding::graded(2 * bad > visible, "TRACKS_NOT_FINITE", message);
        record.findings.push(finding.cameras([index]).number("points", bad as f64));
    }
    let Some(inside) = report.inside.filter(|i| *i < INSIDE) else { return };
    let transposed = tracked(log)
        .filter(|t| t.compared && t.visible > 0)
        .map(|t| share(t.inside_transposed, t.visible));
    let transposed = mean(transposed).unwrap_or(0.0);
    if transposed > 2.0 * inside && transposed > 0.5 {
        let message = format!(
            "{:.0} % of the tracks of {name} lie on its masks, and {:.0} % if x and y are exchanged",
            100.0 * inside,
            100.0 * transposed
        );
        record.findings.push(
            Finding::error("TRACKS_TRANSPOSED", message)
                .cameras([index])
                .number("inside", inside)
                .number("inside_exchanged", transposed),
        );
        return;
    }
    let message =
        format!("only {:.0} % of the visible tracks of {name} lie on its masks", 100.0 * inside);
    let finding = Finding::warning("TRACKS_OFF_OBJECT", message);
    record.findings.push(finding.cameras([index]).number("inside", inside));
}

fn survive(case: &Case<'_>, index: usize, log: &Log, report: &TrackReport, record: &mut Record) {
    let end = case.recording.train_frame_count.min(log.glances.len());
    let most = report.visible.iter().copied().max().unwrap_or(0);
    // A hand before the lens loses tracks for a moment; what counts is what is left at the end.
    let tail = report.visible.get(end.saturating_sub(5)..end).unwrap_or_default();
    let left = tail.iter().copied().max().unwrap_or(0);
    let part = share(left, most);
    if most == 0 || part < SURVIVE {
        let message = format!(
            "of {} tracks of {}, {left} are visible at the end of the part for fitting",
            report.count,
            named(case.recording, index)
        );
        let finding = Finding::warning("TRACKS_LOST", message);
        record.findings.push(finding.cameras([index]).number("survivors", left as f64));
    }
}

fn move_along(case: &Case<'_>, index: usize, log: &Log, record: &mut Record) {
    let moved = travel(&case.paths.object).unwrap_or(0.0);
    let width = case.recording.cameras.get(index).map_or(0, |c| c.width) as f64;
    let Some(reach) = log.track_reach_px else { return };
    if moved > TRAVEL_M && reach < STILL_PX.max(STILL_WIDTHS * width) {
        let message = format!(
            "the tracks of {} move {reach:.1} px while the object moves {:.0} mm",
            named(case.recording, index),
            1e3 * moved
        );
        let finding = Finding::warning("TRACKS_STILL", message);
        record.findings.push(finding.cameras([index]).number("reach_px", reach));
    }
}
