//! The hand: present, finite, near the object, moving.

use bendtwin_core::{Capture, Point, Sequence};

use super::{Finding, distance, visible_points};

/// A hand that never comes nearer does not touch the object [m].
const FAR_M: f32 = 0.1;
/// Pairs of points that are compared; longer recordings are checked in fewer frames, and where one frame has
/// more, by fewer points.
const MAX_PAIRS: usize = 500_000_000;
/// A hand that moves less holds still [m].
const STILL_M: f32 = 0.005;
/// No hand is faster [m/s].
const MAX_SPEED_M_S: f32 = 10.0;
/// A held point may wander by this against its control point [m].
const PIN_DRIFT_M: f32 = 0.02;

pub(super) fn check(capture: &Capture, findings: &mut Vec<Finding>) {
    let controls = capture.sequences.first().map_or(0, Sequence::control_count);
    if controls == 0 {
        findings.push(Finding::warning(
            "NO_CONTROLS",
            "there are no control points, so nothing but gravity moves the twin: add the hand's or gripper's points"
                .to_owned(),
        ));
        return;
    }
    let mut moved = 0.0_f32;
    for sequence in &capture.sequences {
        let bad = sequence.controls.iter().position(|p| !p.iter().all(|x| x.is_finite()));
        if let Some(first) = bad {
            findings.push(Finding::error(
                "NAN_CONTROLS",
                format!(
                    "control point {} of sequence `{}` is NaN or infinite in frame {}: every control point needs a \
                     position in every frame, interpolate it",
                    first % controls,
                    sequence.name,
                    first / controls
                ),
            ));
            return;
        }
        let start = sequence.controls.get(..controls).unwrap_or_default();
        let rows = sequence.controls.chunks_exact(controls);
        let reach = rows.flat_map(|row| row.iter().zip(start)).map(|(p, s)| distance(p, s));
        moved = moved.max(reach.fold(0.0, f32::max));
        jumps(capture, sequence, findings);
        pins(capture, sequence, findings);
        far(sequence, findings);
    }
    if moved < STILL_M {
        findings.push(Finding::warning(
            "CONTROLS_STILL",
            format!(
                "no control point moves more than {:.1} mm: is the hand's track frozen?",
                moved * 1000.0
            ),
        ));
    }
}

fn far(sequence: &Sequence, findings: &mut Vec<Finding>) {
    let mut nearest = f32::INFINITY;
    let pairs = sequence.points.len().saturating_mul(sequence.control_count());
    let stride = pairs.div_ceil(MAX_PAIRS).max(1);
    for frame in (0..sequence.frame_count).step_by(stride) {
        let points = visible_points(sequence, frame);
        let controls = sequence.controls_at(frame);
        let every = points.len().saturating_mul(controls.len()).div_ceil(MAX_PAIRS).max(1);
        for control in controls {
            let some = points.iter().step_by(every);
            nearest = some.map(|p| distance(control, p)).fold(nearest, f32::min);
        }
        if nearest <= FAR_M {
            return;
        }
    }
    if nearest.is_finite() {
        findings.push(Finding::error(
            "CONTROLS_FAR",
            format!(
                "the control points of sequence `{}` never come nearer than {nearest:.2} m to a visible point (limit \
                 {FAR_M}): are hand and object in the same frame and units?",
                sequence.name
            ),
        ));
    }
}

fn jumps(capture: &Capture, sequence: &Sequence, findings: &mut Vec<Finding>) {
    let controls = sequence.control_count();
    let before = sequence.controls.iter();
    let after = sequence.controls.iter().skip(controls);
    let fps = capture.fps as f32;
    let mut speeds = before.zip(after).map(|(a, b)| distance(a, b) * fps).enumerate();
    if let Some((at, speed)) = speeds.find(|(_, speed)| *speed > MAX_SPEED_M_S) {
        findings.push(Finding::warning(
            "CONTROLS_JUMP",
            format!(
                "control point {} of sequence `{}` moves at {speed:.0} m/s into frame {} (limit {MAX_SPEED_M_S}): \
                 smooth the hand's track",
                at % controls,
                sequence.name,
                at / controls + 1
            ),
        ));
    }
}

fn pins(capture: &Capture, sequence: &Sequence, findings: &mut Vec<Finding>) {
    let start = sequence.start_frame();
    let offset = |frame: usize, point: u32, control: u32| -> Option<Point> {
        let seen = *sequence.visible_at(frame).get(point as usize)?;
        let (p, c) = (
            sequence.points_at(frame).get(point as usize)?,
            sequence.controls_at(frame).get(control as usize)?,
        );
        seen.then(|| std::array::from_fn(|a| p[a] - c[a]))
    };
    for pin in &capture.object.pins {
        let Some(rest) = offset(start, pin.point, pin.control) else { continue };
        let drift = (start..sequence.frame_count)
            .filter_map(|f| offset(f, pin.point, pin.control))
            .map(|o| distance(&o, &rest))
            .fold(0.0, f32::max);
        if drift > PIN_DRIFT_M {
            findings.push(Finding::warning(
                "PIN_SLIPS",
                format!(
                    "point {} of sequence `{}` moves {:.0} mm against control point {} that holds it: does it slip? \
                     Then do not pin it",
                    pin.point,
                    sequence.name,
                    drift * 1000.0,
                    pin.control
                ),
            ));
        }
    }
}
