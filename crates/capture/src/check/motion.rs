//! Motion of points: teleports, duplicated and dropped frames, stillness.

use bendtwin_core::{Capture, Sequence};

use super::{Finding, distance, median, percent};

/// No hand moves a soft object faster [m/s].
const MAX_SPEED_M_S: f32 = 15.0;
/// A jump of all points counts from here [m] ...
const JUMP_M: f32 = 0.01;
/// ... if it is this many times the motion before and after, ...
const JUMP_FACTOR: f32 = 3.0;
/// ... not in the median alone, but for this share of the points that move so far: what swings or
/// shakes is fast here and there, and a missing frame concerns all.
const JUMPING_SHARE: f32 = 0.8;
/// An object that moves less teaches nothing [m].
const STILL_M: f32 = 0.005;

pub(super) fn check(capture: &Capture, sequence: &Sequence, findings: &mut Vec<Finding>) {
    let frames = sequence.frame_count;
    if frames < 2 {
        return;
    }
    teleports(capture, sequence, findings);
    let steps: Vec<f32> = (1..frames).map(|f| step(sequence, f)).collect();
    dropped(sequence, &steps, findings);
    let moved = farthest(sequence);
    if moved < STILL_M {
        findings.push(Finding::warning(
            "OBJECT_STILL",
            format!(
                "no point of sequence `{}` moves more than {:.1} mm: move the object, a twin learns from motion",
                sequence.name,
                moved * 1000.0
            ),
        ));
        return;
    }
    duplicated(sequence, findings);
}

/// Visible in this frame and the previous: (before, now).
fn seen_twice(
    sequence: &Sequence,
    frame: usize,
) -> impl Iterator<Item = (&bendtwin_core::Point, &bendtwin_core::Point)> {
    let flags = sequence.visible_at(frame - 1).iter().zip(sequence.visible_at(frame));
    let points = sequence.points_at(frame - 1).iter().zip(sequence.points_at(frame));
    points.zip(flags).filter(|(_, (a, b))| **a && **b).map(|(p, _)| p)
}

/// Median displacement since the previous frame [m].
fn step(sequence: &Sequence, frame: usize) -> f32 {
    median(seen_twice(sequence, frame).map(|(a, b)| distance(a, b)).collect())
}

fn teleports(capture: &Capture, sequence: &Sequence, findings: &mut Vec<Finding>) {
    let limit = MAX_SPEED_M_S / capture.fps as f32;
    let (mut jumps, mut motions, mut fastest, mut first) = (0, 0, 0.0_f32, None);
    for frame in 1..sequence.frame_count {
        for (a, b) in seen_twice(sequence, frame) {
            motions += 1;
            let d = distance(a, b);
            if d > limit {
                jumps += 1;
                first.get_or_insert(frame);
                fastest = fastest.max(d);
            }
        }
    }
    if let Some(first) = first {
        let speed = fastest * capture.fps as f32;
        findings.push(Finding::warning(
            "POINTS_TELEPORT",
            format!(
                "{jumps} motions of sequence `{}` ({} %) are faster than {MAX_SPEED_M_S} m/s, up to {speed:.0} m/s, \
                 first in frame {first}: the tracker jumped, or the frame rate is wrong; mark those motions invalid",
                sequence.name,
                percent(jumps, motions)
            ),
        ));
    }
}

fn dropped(sequence: &Sequence, steps: &[f32], findings: &mut Vec<Finding>) {
    let is_jump = |w: &[f32]| w[1] > JUMP_M && w[1] > JUMP_FACTOR * w[0].max(w[2]);
    let by_median = steps.windows(3).enumerate().filter(|(_, w)| is_jump(w)).map(|(i, _)| i + 2);
    let jumps: Vec<usize> = by_median.filter(|frame| jumps_together(sequence, *frame)).collect();
    if let Some(first) = jumps.first() {
        let again = match jumps.len() - 1 {
            0 => String::new(),
            1 => " (and once more)".to_owned(),
            n => format!(" (and {n} more times)"),
        };
        findings.push(Finding::warning(
            "FRAMES_DROPPED",
            format!(
                "all points of sequence `{}` jump by {:.0} mm at frame {first}{again} while they move \
                 slowly before and after: frames are missing there, cut the recording or fill the gap",
                sequence.name,
                steps.get(first - 1).copied().unwrap_or(0.0) * 1000.0,
            ),
        ));
    }
}

/// True if the points that move far into a frame move little before and after, each by itself.
fn jumps_together(sequence: &Sequence, frame: usize) -> bool {
    let path = |point: usize| -> Option<[f32; 3]> {
        let at = |f: usize| {
            let seen = *sequence.visible_at(f).get(point)?;
            sequence.points_at(f).get(point).filter(|_| seen)
        };
        let [a, b, c, d] = [at(frame - 2)?, at(frame - 1)?, at(frame)?, at(frame + 1)?];
        Some([distance(a, b), distance(b, c), distance(c, d)])
    };
    let points = sequence.points_at(frame).len();
    let moving: Vec<[f32; 3]> = (0..points).filter_map(path).filter(|s| s[1] > JUMP_M).collect();
    let jumping = moving.iter().filter(|s| s[1] > JUMP_FACTOR * s[0].max(s[2])).count();
    !moving.is_empty() && jumping as f32 >= JUMPING_SHARE * moving.len() as f32
}

fn duplicated(sequence: &Sequence, findings: &mut Vec<Finding>) {
    let same = |frame: usize| {
        let (before, now) = (sequence.points_at(frame - 1), sequence.points_at(frame));
        let bits = |p: &bendtwin_core::Point| p.map(f32::to_bits);
        sequence.visible_at(frame).contains(&true)
            && before.iter().zip(now).all(|(a, b)| bits(a) == bits(b))
    };
    let frames: Vec<usize> = (1..sequence.frame_count).filter(|f| same(*f)).collect();
    if let Some(first) = frames.first() {
        findings.push(Finding::warning(
            "FRAMES_DUPLICATED",
            format!(
                "{} frames of sequence `{}` repeat the previous frame exactly, first frame {first}: the camera \
                 stuttered, remove them or correct the frame rate",
                frames.len(),
                sequence.name
            ),
        ));
    }
}

/// Farthest that any point gets from where it was first seen [m].
fn farthest(sequence: &Sequence) -> f32 {
    let points = sequence.points_at(0).len();
    let mut first: Vec<Option<bendtwin_core::Point>> = vec![None; points];
    let mut farthest = 0.0_f32;
    for frame in 0..sequence.frame_count {
        let seen = sequence.points_at(frame).iter().zip(sequence.visible_at(frame));
        for ((p, visible), first) in seen.zip(&mut first) {
            if *visible {
                farthest = farthest.max(distance(p, first.get_or_insert(*p)));
            }
        }
    }
    farthest
}
