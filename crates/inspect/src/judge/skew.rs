//! Judge of skew between cameras, measured from motion: the shift in time that best aligns the
//! paths that two cameras saw. It needs no times, and finds skew that times do not show. Drift is a
//! stronger claim, that the shift changes: both halves and the whole have to agree on it, and time
//! stamps must not contradict it.

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

/// Longest shift that is looked for [frames]: that of the usual frame rates. Each takes a pass over all
/// frames, and a rate that nobody records would make them as many as the frames.
const LONGEST_SHIFT: f64 = 512.0;

pub(super) fn judge(context: &Context<'_>, assessment: &mut Assessment) {
    let recording = context.recording;
    let n = recording.cameras.len().min(COMPARED_CAMERAS);
    let frames = recording.frame_count;
    if n < 2 || !(recording.fps.is_finite() && recording.fps > 0.0) {
        return;
    }
    let frame_ms = 1e3 / recording.fps;
    let filled = Filled::of(context);
    let mut shifts = vec![vec![None; n]; n];
    let mut drifts = vec![vec![None; n]; n];
    for a in 0..n {
        for b in a + 1..n {
            let whole = shift(context, &filled, [a, b], 0..frames).map(|whole| whole.frames);
            let drift = drift(context, &filled, [a, b], whole);
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
        // Of two cameras nobody knows which one is late: they share one finding.
        if n > 2 {
            flag(
                context,
                &[camera],
                ["the others", "the other cameras"],
                [skew, drift],
                assessment,
            );
        }
    }
    if n == 2 {
        let between = |table: &Vec<Vec<Option<f64>>>| *table.first()?.get(1)?;
        let second = named(context.recording, 1);
        let measured = [between(&shifts), between(&drifts)];
        flag(context, &[0, 1], [&second, &second], measured, assessment);
    }
}

/// Growth of the skew between two cameras from the first half to the second [frames]. `None` unless
/// the halves and the whole agree on it, or if the paths differ too little; 0 if the frames' times
/// show none.
fn drift(
    context: &Context<'_>,
    filled: &Filled,
    pair: [usize; 2],
    whole: Option<f64>,
) -> Option<f64> {
    let limits = &context.thresholds.skew;
    let frames = context.recording.frame_count;
    let first = shift(context, filled, pair, 0..frames / 2)?;
    let second = shift(context, filled, pair, frames / 2..frames)?;
    // Half a recording is little to go by: a shift has to explain nearly all of what is left without.
    let is_clear = |half: &Shift| {
        half.frames.abs() < 1.0 || half.remaining < limits.max_remaining_share_of_half
    };
    if !(is_clear(&first) && is_clear(&second)) {
        return None;
    }
    let deviation_m = first.unshifted_m2.max(second.unshifted_m2).sqrt();
    let (first, second) = (first.frames, second.frames);
    let drift = second - first;
    if drift.abs() <= limits.max_drift_frames {
        return Some(drift);
    }
    if deviation_m < limits.min_drift_deviation_m {
        return None;
    }
    let [low, high] = [first.min(second), first.max(second)];
    let slack = limits.max_skew_frames;
    if !(low - slack..=high + slack).contains(&whole?) {
        return None;
    }
    let by_times = drift_by_times(context, pair);
    if by_times.is_some_and(|times| (times - drift).abs() > 0.5 * drift.abs()) {
        return Some(0.0);
    }
    Some(drift)
}

/// The same growth by the times of the frames [frames]; `None` if a camera has none.
fn drift_by_times(context: &Context<'_>, [a, b]: [usize; 2]) -> Option<f64> {
    let [a, b] = [context.recording.cameras.get(a)?, context.recording.cameras.get(b)?];
    let frames = context.recording.frame_count;
    let lag = |between: Range<usize>| {
        let [a, b] = [a.times_s.get(between.clone())?, b.times_s.get(between)?];
        median(a.iter().zip(b).map(|(a, b)| a - b).filter(|lag| lag.is_finite()))
    };
    let grown = lag(frames / 2..frames)? - lag(0..frames / 2)?;
    // A frame that is taken later shows things earlier.
    Some(-grown * context.recording.fps)
}

/// Adds the finding about cameras of which the first drifts from others, or is later than they are. A
/// message calls these differently in the two cases.
fn flag(
    context: &Context<'_>,
    cameras: &[usize],
    [drifts_from, later_than]: [&str; 2],
    [skew, drift]: [Option<f64>; 2],
    assessment: &mut Assessment,
) {
    let limits = &context.thresholds.skew;
    let Some(&first) = cameras.first() else { return };
    let name = named(context.recording, first);
    let of_cameras = |finding: Finding| finding.cameras(cameras.iter().copied());
    if let Some(drift) = drift.filter(|d| d.abs() > limits.max_drift_frames) {
        let drift_ms = drift * (1e3 / context.recording.fps);
        let message = format!(
            "{name} runs {} {drifts_from} by {:.0} ms from the first half to the second: its frames were dropped and closed \
             up, or its clock differs",
            if drift > 0.0 { "behind" } else { "ahead of" },
            drift_ms.abs()
        );
        let finding = of_cameras(Finding::warning(Code::ClocksDrift, message));
        assessment.findings.push(finding.number("drift_ms", drift_ms));
        return;
    }
    let Some(skew) = skew.filter(|s| s.abs() > limits.max_skew_frames) else { return };
    // The frames' times may have shown it already.
    let is_it = |f: &Finding| f.code == Code::CamerasSkewed.name() && f.cameras.contains(&first);
    if assessment.findings.iter().any(is_it) {
        return;
    }
    let skew_ms = skew * 1e3 / context.recording.fps;
    let is_bad = skew.abs() >= limits.bad_skew_frames && skew_ms.abs() >= 1e3 * limits.bad_skew_s;
    let message = format!(
        "{name} shows motion {:.0} ms ({:.1} frames) {} than {later_than}",
        skew_ms.abs(),
        skew.abs(),
        if skew > 0.0 { "later" } else { "earlier" }
    );
    let finding = of_cameras(Finding::graded(is_bad, Code::CamerasSkewed, message));
    assessment.findings.push(finding.number("skew_ms", skew_ms));
}

/// Paths without what is at an image's border, where the middle of what is seen is not that of the
/// thing, and whose short gaps are filled in by straight lines, so that a camera at half the rate of
/// another can be aligned with it.
struct Filled {
    object: Vec<Path>,
    manipulator: Vec<Path>,
}

impl Filled {
    fn of(context: &Context<'_>) -> Self {
        let most = context.thresholds.skew.max_gap_frames;
        let object = context.paths.object.iter().zip(context.scans).map(|(path, scan)| {
            let is_whole = |f: usize| {
                scan.frames.get(f).is_some_and(|g| g.object.is_some_and(|object| !object.at_border))
            };
            let whole: Path =
                path.iter().enumerate().map(|(f, at)| at.filter(|_| is_whole(f))).collect();
            without_gaps(&whole, most)
        });
        // An arm always comes in from outside.
        let manipulator = context.paths.manipulator.iter().map(|path| without_gaps(path, most));
        Self { object: object.collect(), manipulator: manipulator.collect() }
    }
}

/// A path whose gaps of at most `most` frames are filled in.
fn without_gaps(path: &Path, most: usize) -> Path {
    let mut filled = path.clone();
    let known: Vec<(usize, Vector)> =
        path.iter().enumerate().filter_map(|(f, p)| Some((f, (*p)?))).collect();
    for pair in known.windows(2) {
        let &[(from, start), (to, end)] = pair else { continue };
        if to - from - 1 > most {
            continue;
        }
        for (passed, place) in filled[from + 1..to].iter_mut().enumerate() {
            let share = (passed + 1) as f64 / (to - from) as f64;
            *place = Some(add(start, scaled(sub(end, start), share)));
        }
    }
    filled
}

/// The shift in time between two cameras.
struct Shift {
    /// Number of frames by which the first shows things later.
    frames: f64,
    /// Variance between their paths without a shift [m²].
    unshifted_m2: f64,
    /// Share of that variance that remains, 0..=1.
    remaining: f64,
}

/// Shift by which camera `a` shows things later than camera `b`, between two frames.
/// `None` if nothing moves enough, or if the best shift is at the edge of what can be looked for: the
/// true one may lie beyond, and at the edge few frames are compared.
fn shift(
    context: &Context<'_>,
    filled: &Filled,
    [a, b]: [usize; 2],
    between: Range<usize>,
) -> Option<Shift> {
    let limits = &context.thresholds.skew;
    let longest = limits.max_skew_share * between.len() as f64;
    let window = (limits.max_skew_s * context.recording.fps).min(longest).min(LONGEST_SHIFT) as i64;
    let things: Vec<(&Path, &Path)> = [&filled.manipulator, &filled.object]
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
        return Some(Shift { frames: 0.0, unshifted_m2: unshifted, remaining: 1.0 });
    }
    let neighbour = |i: Option<usize>| costs.get(i?).copied().flatten();
    let (left, right) = (neighbour(at.checked_sub(1))?, neighbour(Some(at + 1))?);
    // The vertex of the parabola through the best and its neighbours.
    let bend = left + right - 2.0 * best;
    let part = if bend > 1e-12 { 0.5 * (left - right) / bend } else { 0.0 };
    let remaining = best / unshifted.max(f64::MIN_POSITIVE);
    Some(Shift { frames: whole as f64 + part, unshifted_m2: unshifted, remaining })
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
