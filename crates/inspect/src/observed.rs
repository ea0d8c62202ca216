//! Inspection of a capture whose points were lifted elsewhere: checked, and measured as far as
//! points allow.

use bendtwin_capture::check;
use bendtwin_core::{Capture, Point, Sequence};

use crate::{
    inspection::{Inspection, ObservedReport, Scene},
    picture_inputs::PictureInputs,
    statistics::median,
    vector::{Upright, Vector, add, distance, scaled, wide},
};

/// Points and control points of a frame whose distances are taken.
const MAX_POINTS: usize = 400;
/// Distances between points and control points that are taken: beyond a recording of some minutes, of
/// fewer points.
const MAX_PAIRS: usize = 2_000_000_000;

/// Inspects an observed capture. Its findings are those of [`bendtwin_capture::check()`].
pub fn inspect_observed(capture: &Capture) -> Inspection {
    let sequence = capture.sequences.first();
    let mut inspection = Inspection {
        fps: Some(capture.fps).filter(|fps| fps.is_finite()),
        frame_count: sequence.map_or(0, |s| s.frame_count),
        train_frame_count: sequence.map_or(0, |s| s.train_frame_count),
        scene: scene(capture),
        observed: observed(capture),
        picture_inputs: PictureInputs {
            environment: capture.environment,
            cameras: Vec::new(),
            capture: is_whole(capture).then(|| capture.clone()),
        },
        ..Inspection::unread(&capture.name)
    };
    inspection.add(check(capture).findings);
    inspection
}

/// True if the arrays have the lengths that they should have; if not, a check says so and nothing
/// is measured.
pub(crate) fn is_whole(capture: &Capture) -> bool {
    bendtwin_capture::validate(capture).is_ok()
}

/// Measurements of a capture's points.
pub(crate) fn observed(capture: &Capture) -> Option<ObservedReport> {
    let sequence = capture.sequences.first().filter(|_| is_whole(capture))?;
    let count = |of: &dyn Fn(usize) -> usize| (0..sequence.frame_count).map(of).collect();
    let start = seen(sequence, sequence.start_frame());
    let bound = |pick: fn(f32, f32) -> f32| {
        let corner = |a: Point, b: &Point| std::array::from_fn(|i| pick(a[i], b[i]));
        start.first().map(|first| start.iter().fold(*first, corner))
    };
    Some(ObservedReport {
        point_count: capture.object.point_count,
        control_count: sequence.control_count(),
        visible: count(&|f| sequence.visible_at(f).iter().filter(|v| **v).count()),
        motion_valid: count(&|f| sequence.motion_valid_at(f).iter().filter(|v| **v).count()),
        completed_count: capture.object.completed_surface.len(),
        interior_count: capture.object.interior.len(),
        low: bound(f32::min),
        high: bound(f32::max),
    })
}

fn seen(sequence: &Sequence, frame: usize) -> Vec<Point> {
    if frame >= sequence.frame_count {
        return Vec::new();
    }
    let points = sequence.points_at(frame).iter().zip(sequence.visible_at(frame));
    points.filter(|(p, v)| **v && p.iter().all(|x| x.is_finite())).map(|(p, _)| *p).collect()
}

fn scene(capture: &Capture) -> Scene {
    let Some(sequence) = capture.sequences.first().filter(|_| is_whole(capture)) else {
        return Scene::default();
    };
    let upright = Upright::of(&capture.environment);
    let frames = 0..sequence.frame_count;
    let most = MAX_POINTS.min((MAX_PAIRS / sequence.frame_count.max(1)).isqrt());
    let thin = |points: &[Point]| thin(points, most);
    let clouds: Vec<Vec<Vector>> = frames.map(|f| thin(&seen(sequence, f))).collect();
    let middles: Vec<Option<Vector>> = clouds.iter().map(|c| middle(c)).collect();
    let controls: Vec<Vec<Vector>> =
        (0..sequence.frame_count).map(|f| thin(sequence.controls_at(f))).collect();
    let hands: Vec<Option<Vector>> = controls.iter().map(|c| middle(c)).collect();
    let travel = |path: &[Option<Vector>]| {
        let start = path.iter().flatten().next()?;
        path.iter().flatten().map(|p| distance(*p, *start)).max_by(f64::total_cmp)
    };
    let steps = middles.windows(2).filter_map(|w| match w {
        [Some(a), Some(b)] => Some(distance(*a, *b) * capture.fps),
        _ => None,
    });
    let nearest = |(points, controls): (&Vec<Vector>, &Vec<Vector>)| {
        let one = |c: &Vector| points.iter().map(|p| distance(*p, *c)).min_by(f64::total_cmp);
        controls.iter().filter_map(one).min_by(f64::total_cmp)
    };
    let heights = clouds.iter().flatten().map(|p| upright.height(*p));
    let extent = |cloud: &Vec<Vector>| {
        let range = |a: usize| {
            let values = cloud.iter().map(|p| p[a]);
            let (low, high) =
                values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
            high - low
        };
        (0..3).map(range).fold(0.0, f64::max)
    };
    Scene {
        object_size_m: median(clouds.iter().filter(|c| !c.is_empty()).map(extent)),
        manipulator_size_m: None,
        lowest_m: heights.min_by(f64::total_cmp).filter(|_| upright.grounded),
        travel_m: travel(&middles),
        manipulator_travel_m: travel(&hands),
        fastest_m_s: steps.max_by(f64::total_cmp).filter(|s| s.is_finite()),
        gap_m: clouds.iter().zip(&controls).map(nearest).collect(),
    }
}

/// At most `most` of the points, evenly taken.
fn thin(points: &[Point], most: usize) -> Vec<Vector> {
    let step = points.len().div_ceil(most.max(1)).max(1);
    let finite = points.iter().step_by(step).filter(|p| p.iter().all(|x| x.is_finite()));
    finite.map(|p| wide(*p)).collect()
}

fn middle(points: &[Vector]) -> Option<Vector> {
    let sum = points.iter().fold([0.0; 3], |s, p| add(s, *p));
    (!points.is_empty()).then(|| scaled(sum, 1.0 / points.len() as f64))
}
