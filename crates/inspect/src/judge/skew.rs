//! Judge of skew between cameras, measured from motion: the shift in time that best aligns the
//! paths that two cameras saw. It needs no times, and finds skew that times do not show.

use std::ops::Range;

use super::{Assessment, Context, named, paths::Path};
use crate::{
    Code, Finding,
    inspection::PairReport,
    scan::COMPARED_CAMERAS,
    statistics::{mean, median},
    thresholds::SkewThresholds,
    vector::{Vector, add, distance, scaled, sub},
};

pub(super) fn judge(context: &Context<'_>, assessment: &mut Assessment) {
    let limits = &context.thresholds.skew;
    let recording = context.recording;
    let n = recording.cameras.len().min(COMPARED_CAMERAS);
    let frames = recording.frame_count;
    if n < 2 || !(recording.fps.is_finite() && recording.fps > 0.0) {
        return;
    }
    let frame_ms = 1e3 / recording.fps;
    let window =
        (limits.max_skew_s * recording.fps).min(limits.max_skew_share * frames as f64) as i64;
    let mut shifts = vec![vec![None; n]; n];
    let mut drifts = vec![vec![None; n]; n];
    for a in 0..n {
        for b in a + 1..n {
            let between = |from, to| shift(context, [a, b], from..to, window);
            let whole = between(0, frames);
            let drift = between(0, frames / 2)
                .zip(between(frames / 2, frames))
                .map(|(first, second)| second - first);
            let set = |table: &mut Vec<Vec<Option<f64>>>, value: Option<f64>| {
                table[a][b] = value;
                table[b][a] = value.map(|v| -v);
            };
            set(&mut shifts, whole);
            set(&mut drifts, drift);
            assessment
                .pairs
                .push(PairReport { skew_ms: whole.map(|s| s * frame_ms), ..PairReport::of(a, b) });
        }
    }
    for camera in 0..n {
        let against_others = |table: &Vec<Vec<Option<f64>>>| {
            let known: Vec<f64> = table[camera].iter().flatten().copied().collect();
            // Its own zero counts too, so that of three cameras the one that differs is flagged.
            (!known.is_empty()).then(|| median(known.into_iter().chain([0.0])).unwrap_or(0.0))
        };
        let (skew, drift) = (against_others(&shifts), against_others(&drifts));
        if let Some(report) = assessment.cameras.get_mut(camera) {
            report.skew_ms = skew.map(|s| s * frame_ms);
            report.drift_ms = drift.map(|d| d * frame_ms);
        }
        flag(context, camera, skew, drift, assessment);
    }
}

fn flag(
    context: &Context<'_>,
    camera: usize,
    skew: Option<f64>,
    drift: Option<f64>,
    assessment: &mut Assessment,
) {
    let limits = &context.thresholds.skew;
    let name = named(context.recording, camera);
    let frame_ms = 1e3 / context.recording.fps;
    if let Some(drift) = drift.filter(|d| d.abs() > limits.max_drift_frames) {
        let message = format!(
            "{name} runs {} the others by {:.0} ms from the first half to the second: its frames were dropped and closed up, \
             or its clock differs",
            if drift > 0.0 { "behind" } else { "ahead of" },
            drift.abs() * frame_ms
        );
        let finding = Finding::warning(Code::ClocksDrift, message);
        assessment.findings.push(finding.cameras([camera]).number("drift_ms", drift * frame_ms));
        return;
    }
    let Some(skew) = skew.filter(|s| s.abs() > limits.max_skew_frames) else { return };
    let is_known = assessment
        .findings
        .iter()
        .any(|f| f.code == Code::CamerasSkewed.name() && f.cameras == [camera]);
    if is_known {
        return;
    }
    let is_bad =
        skew.abs() >= limits.bad_skew_frames && skew.abs() * frame_ms >= 1e3 * limits.bad_skew_s;
    let message = format!(
        "{name} shows motion {:.0} ms ({:.1} frames) {} than the other cameras",
        skew.abs() * frame_ms,
        skew.abs(),
        if skew > 0.0 { "later" } else { "earlier" }
    );
    assessment.findings.push(
        Finding::graded(is_bad, Code::CamerasSkewed, message)
            .cameras([camera])
            .number("skew_ms", skew * frame_ms),
    );
}

/// Number of frames by which camera `a` shows things later than camera `b`, between two frames.
/// `None` if nothing moves enough.
fn shift(
    context: &Context<'_>,
    [a, b]: [usize; 2],
    between: Range<usize>,
    window: i64,
) -> Option<f64> {
    let limits = &context.thresholds.skew;
    let paths = &context.paths;
    let things: Vec<(&Path, &Path)> = [&paths.manipulator, &paths.object]
        .into_iter()
        .filter_map(|all| Some((all.get(a)?, all.get(b)?)))
        .filter(|(first, second)| moves(first, &between, limits) && moves(second, &between, limits))
        .collect();
    if things.is_empty() {
        return None;
    }
    let cost = |shift: i64| {
        mean(
            things
                .iter()
                .filter_map(|(first, second)| scatter(first, second, &between, shift, limits)),
        )
    };
    let costs: Vec<Option<f64>> = (-window..=window).map(cost).collect();
    let (at, best) = costs
        .iter()
        .enumerate()
        .filter_map(|(i, c)| Some((i, (*c)?)))
        .min_by(|x, y| x.1.total_cmp(&y.1))?;
    let unshifted = cost(0)?;
    let whole = at as i64 - window;
    if whole != 0 && best > limits.max_remaining_share * unshifted {
        return Some(0.0);
    }
    // The vertex of the parabola through the best and its neighbours.
    let neighbour = |i: Option<usize>| costs.get(i?).copied().flatten();
    let part = match (neighbour(at.checked_sub(1)), neighbour(Some(at + 1))) {
        (Some(left), Some(right)) if left + right - 2.0 * best > 1e-12 => {
            0.5 * (left - right) / (left + right - 2.0 * best)
        }
        _ => 0.0,
    };
    Some(whole as f64 + part)
}

/// True if a path moves enough to be aligned.
fn moves(path: &Path, between: &Range<usize>, limits: &SkewThresholds) -> bool {
    let points: Vec<Vector> =
        path.iter().take(between.end).skip(between.start).flatten().copied().collect();
    let count = points.len() as f64;
    let middle = scaled(points.iter().fold([0.0; 3], |s, p| add(s, *p)), 1.0 / count.max(1.0));
    let square = mean(points.iter().map(|p| distance(*p, middle).powi(2)));
    points.len() >= limits.min_shared_frames
        && square.is_some_and(|s| s.sqrt() > limits.min_motion_m)
}

/// Variance of the distance between two paths of which the first is read later [m²]. A constant
/// offset does not count: cameras see different sides of a thing.
fn scatter(
    first: &Path,
    second: &Path,
    between: &Range<usize>,
    shift: i64,
    limits: &SkewThresholds,
) -> Option<f64> {
    let difference = |frame: usize| {
        let other = usize::try_from(frame as i64 + shift).ok().filter(|f| between.contains(f))?;
        Some(sub((*first.get(other)?)?, (*second.get(frame)?)?))
    };
    let differences: Vec<Vector> = between.clone().filter_map(difference).collect();
    if differences.len() < limits.min_shared_frames {
        return None;
    }
    let sum = differences.iter().fold([0.0; 3], |s, d| add(s, *d));
    let middle = scaled(sum, 1.0 / differences.len() as f64);
    mean(differences.iter().map(|d| distance(*d, middle).powi(2)))
}
