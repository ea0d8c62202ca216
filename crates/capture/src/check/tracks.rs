//! Visibility of points: missing numbers, flicker, survival.

use bendtwin_core::{Capture, Sequence};

use super::{Finding, percent};

/// Fewest points that describe a body.
const FEW_POINTS: usize = 20;
/// Share of points below which tracking counts as lost [%].
const LOST_PERCENT: usize = 20;
/// Changes of visibility per point and frame that no occlusion explains [%].
const FLICKER_PERCENT: usize = 20;

pub(super) fn check(capture: &Capture, sequence: &Sequence, findings: &mut Vec<Finding>) {
    let (name, frames) = (&sequence.name, sequence.frame_count);
    let points = capture.object.point_count;
    if points == 0 {
        findings.push(Finding::error(
            "NO_POINTS",
            format!("sequence `{name}` has no tracked points: nothing to fit to"),
        ));
        return;
    }
    if frames == 0 {
        return;
    }
    if !sequence.visible.contains(&true) {
        findings.push(Finding::error(
            "ALL_INVISIBLE",
            format!(
                "no point of sequence `{name}` is visible in any of its {frames} frames: are the visibility flags \
                 inverted?"
            ),
        ));
        return;
    }
    missing_numbers(sequence, points, findings);
    survival(capture, sequence, findings);
    flicker(sequence, points, findings);
}

fn missing_numbers(sequence: &Sequence, points: usize, findings: &mut Vec<Finding>) {
    let name = &sequence.name;
    let seen = sequence.points.iter().zip(&sequence.visible);
    let bad: Vec<usize> = seen
        .enumerate()
        .filter(|(_, (p, v))| **v && !p.iter().all(|x| x.is_finite()))
        .map(|(i, _)| i)
        .collect();
    if let Some(first) = bad.first() {
        findings.push(Finding::error(
            "NAN_VISIBLE_POINTS",
            format!(
                "{} visible points of sequence `{name}` are NaN or infinite, first point {} in frame {}: mark them \
                 invisible",
                bad.len(),
                first % points,
                first / points
            ),
        ));
    }
    let seen = sequence.points.iter().zip(&sequence.visible);
    let at_origin = seen.filter(|(p, v)| **v && p.iter().all(|x| *x == 0.0)).count();
    let visible = sequence.visible.iter().filter(|v| **v).count();
    if percent(at_origin, visible) >= 1 {
        findings.push(Finding::warning(
            "VISIBLE_AT_ORIGIN",
            format!(
                "{at_origin} visible points of sequence `{name}` are exactly at the origin, as missing depth is: \
                 mark them invisible"
            ),
        ));
    }
}

fn survival(capture: &Capture, sequence: &Sequence, findings: &mut Vec<Finding>) {
    let name = &sequence.name;
    let points = capture.object.point_count;
    let counts: Vec<usize> = (0..sequence.frame_count)
        .map(|f| sequence.visible_at(f).iter().filter(|v| **v).count())
        .collect();
    let start = sequence.start_frame();
    if counts.get(start) == Some(&0) {
        findings.push(Finding::error(
            "START_WITHOUT_POINTS",
            format!(
                "frame {start} of sequence `{name}`, from which the twin starts, has no visible point: cut the \
                 frames before the object is seen"
            ),
        ));
    }
    let empty: Vec<usize> =
        counts.iter().enumerate().filter(|(_, n)| **n == 0).map(|(f, _)| f).collect();
    if let Some(first) = empty.first() {
        findings.push(Finding::warning(
            "FRAMES_WITHOUT_POINTS",
            format!(
                "{} of {} frames of sequence `{name}` have no visible point, first frame {first}: they teach \
                 nothing, check the tracker there",
                empty.len(),
                counts.len()
            ),
        ));
    }
    let (worst, fewest) = counts.iter().enumerate().min_by_key(|(_, n)| **n).unwrap_or((0, &0));
    // A cable's few markers are all that there is to see.
    if !capture.object.edges.is_empty() {
        return;
    }
    if points < FEW_POINTS {
        findings.push(Finding::warning(
            "FEW_POINTS",
            format!("there are only {points} tracked points: at least {FEW_POINTS} describe a body, or declare edges"),
        ));
    }
    if percent(*fewest, points) < LOST_PERCENT && *fewest > 0 {
        findings.push(Finding::warning(
            "TRACKS_LOST",
            format!(
                "only {fewest} of {points} points ({} %) are visible in frame {worst} of sequence `{name}`: add a \
                 camera, or keep hands out of the view",
                percent(*fewest, points)
            ),
        ));
    }
}

fn flicker(sequence: &Sequence, points: usize, findings: &mut Vec<Finding>) {
    let before = sequence.visible.iter();
    let after = sequence.visible.iter().skip(points);
    let changes = before.zip(after).filter(|(a, b)| a != b).count();
    let share = percent(changes, points * sequence.frame_count.saturating_sub(1));
    if share >= FLICKER_PERCENT {
        findings.push(Finding::warning(
            "VISIBILITY_FLICKERS",
            format!(
                "a point of sequence `{}` changes between visible and hidden in {share} % of the frames: smooth the \
                 visibility, or raise the tracker's confidence threshold",
                sequence.name
            ),
        ));
    }
}
