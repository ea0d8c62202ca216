//! Scale, ground, and whether the parts of a capture lie where the object is.

use bendtwin_core::{Capture, Point};

use super::{Finding, distance, median, percent, visible_points};

/// Extent of objects that people manipulate [m].
const MAX_EXTENT_M: f32 = 5.0;
const MIN_EXTENT_M: f32 = 0.005;
/// Depth below the ground that noise may give a point [m].
const GROUND_TOLERANCE_M: f32 = 0.02;
/// Largest plausible distance of a true track from the nearest observed point [m].
const TRUTH_TOLERANCE_M: f32 = 0.05;
/// Points that are compared one by one; more are thinned out.
const SAMPLE: usize = 2000;

pub(super) fn check(capture: &Capture, findings: &mut Vec<Finding>) {
    numbers(capture, findings);
    let Some(sequence) = capture.sequences.first() else { return };
    let start = visible_points(sequence, sequence.start_frame());
    let Some(bounds) = Bounds::of(&start) else { return };
    scale(&bounds, findings);
    ground(capture, findings);
    completions(capture, &start, &bounds, findings);
    truth(capture, findings);
}

fn numbers(capture: &Capture, findings: &mut Vec<Finding>) {
    let object = &capture.object;
    for (what, points) in [
        ("completed surface", &object.completed_surface),
        ("interior", &object.interior),
        ("rest shape", &object.rest_points),
    ] {
        let bad = points.iter().filter(|p| !p.iter().all(|x| x.is_finite())).count();
        if bad > 0 {
            findings.push(Finding::error(
                "NAN_OBJECT_POINTS",
                format!(
                    "{bad} of {} points of the {what} are NaN or infinite: remove them",
                    points.len()
                ),
            ));
        }
    }
    let odd = object.colors.iter().flatten().filter(|c| !(0.0..=1.0).contains(*c)).count();
    if odd > 0 {
        findings.push(Finding::warning(
            "COLORS_OUT_OF_RANGE",
            format!("{odd} colour values lie outside 0 to 1: divide 8-bit colours by 255"),
        ));
    }
}

struct Bounds {
    low: Point,
    high: Point,
}

impl Bounds {
    fn of(points: &[Point]) -> Option<Self> {
        let first = points.first()?;
        let mut bounds = Self { low: *first, high: *first };
        for p in points {
            bounds.low = std::array::from_fn(|a| bounds.low[a].min(p[a]));
            bounds.high = std::array::from_fn(|a| bounds.high[a].max(p[a]));
        }
        Some(bounds)
    }

    fn extent(&self) -> f32 {
        (0..3).map(|a| self.high[a] - self.low[a]).fold(0.0, f32::max)
    }

    fn contains(&self, p: &Point, margin: f32) -> bool {
        (0..3).all(|a| p[a] >= self.low[a] - margin && p[a] <= self.high[a] + margin)
    }
}

fn scale(bounds: &Bounds, findings: &mut Vec<Finding>) {
    let extent = bounds.extent();
    if extent > MAX_EXTENT_M {
        let (units, factor) =
            if extent > 100.0 { ("millimetres", 1000.0) } else { ("centimetres", 100.0) };
        findings.push(Finding::error(
            "SCALE_TOO_LARGE",
            format!(
                "the object is {extent:.1} m long: are these {units}? As such it would be {:.2} m; declare the units",
                extent / factor
            ),
        ));
    } else if extent < MIN_EXTENT_M {
        findings.push(Finding::error(
            "SCALE_TOO_SMALL",
            format!(
                "the object is {:.2} mm long: were metres divided once too often, or is only one spot tracked?",
                extent * 1000.0
            ),
        ));
    }
}

fn ground(capture: &Capture, findings: &mut Vec<Finding>) {
    let Some(ground) = capture.environment.ground else { return };
    let depth = |p: &Point| {
        ground.offset_m
            - (p[0] * ground.normal[0] + p[1] * ground.normal[1] + p[2] * ground.normal[2])
    };
    let (mut below, mut seen, mut deepest) = (0, 0, 0.0_f32);
    for sequence in &capture.sequences {
        for (p, _) in sequence.points.iter().zip(&sequence.visible).filter(|(_, v)| **v) {
            seen += 1;
            let d = depth(p);
            if d > GROUND_TOLERANCE_M {
                below += 1;
                deepest = deepest.max(d);
            }
        }
    }
    let share = percent(below, seen);
    if share >= 1 {
        let message = format!(
            "{share} % of the visible points lie more than {:.0} mm below the ground, the deepest {deepest:.2} m: is \
             the up axis or the ground's offset wrong?",
            GROUND_TOLERANCE_M * 1000.0
        );
        findings.push(match share {
            0..25 => Finding::warning("BELOW_GROUND", message),
            _ => Finding::error("BELOW_GROUND", message),
        });
    }
}

/// At most [`SAMPLE`] points, evenly taken.
fn thin(points: &[Point]) -> Vec<Point> {
    points.iter().step_by(points.len().div_ceil(SAMPLE).max(1)).copied().collect()
}

fn nearest(p: &Point, among: &[Point]) -> f32 {
    among.iter().map(|q| distance(p, q)).fold(f32::INFINITY, f32::min)
}

fn completions(capture: &Capture, start: &[Point], bounds: &Bounds, findings: &mut Vec<Finding>) {
    let object = &capture.object;
    let seen = thin(start);
    let surface = thin(&object.completed_surface);
    let margin = 0.5 * bounds.extent();
    let far = surface.iter().filter(|p| nearest(p, &seen) > margin).count();
    if percent(far, surface.len()) >= 10 {
        findings.push(Finding::warning(
            "COMPLETION_FAR",
            format!(
                "{} % of the completed surface lies more than {margin:.2} m from every observed point: align the \
                 shape prior with the first frame",
                percent(far, surface.len())
            ),
        ));
    }
    let mut whole = start.to_vec();
    whole.extend(&object.completed_surface);
    let Some(bounds) = Bounds::of(&whole) else { return };
    let margin = 0.05 * bounds.extent();
    let outside = object.interior.iter().filter(|p| !bounds.contains(p, margin)).count();
    if percent(outside, object.interior.len()) >= 5 {
        findings.push(Finding::warning(
            "INTERIOR_OUTSIDE",
            format!(
                "{outside} of {} interior points lie outside the object's bounding box: fill the shape in the frame \
                 of the first observation",
                object.interior.len()
            ),
        ));
    }
}

fn truth(capture: &Capture, findings: &mut Vec<Finding>) {
    for sequence in capture.sequences.iter().filter(|s| s.truth_count() > 0) {
        let start = sequence.start_frame();
        let known: Vec<Point> = sequence
            .truth_at(start)
            .iter()
            .filter(|p| p.iter().all(|x| x.is_finite()))
            .copied()
            .collect();
        let name = &sequence.name;
        if known.is_empty() {
            findings.push(Finding::warning(
                "TRUTH_UNKNOWN",
                format!("no true track of sequence `{name}` is known in frame {start}: the track metric cannot start"),
            ));
            continue;
        }
        let mut around = visible_points(sequence, start);
        around.extend(&capture.object.completed_surface);
        let around = thin(&around);
        let typical = median(thin(&known).iter().map(|p| nearest(p, &around)).collect());
        if typical > TRUTH_TOLERANCE_M {
            findings.push(Finding::warning(
                "TRUTH_FAR",
                format!(
                    "the true tracks of sequence `{name}` start {:.0} mm from the object (median): are they of this \
                     capture, in its frame and units?",
                    typical * 1000.0
                ),
            ));
        }
    }
}
