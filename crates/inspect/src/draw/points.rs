//! Pictures of points over time, from one viewpoint: as seen by cameras, and as lifted.

use bendtwin_core::{Environment, Point, Sequence};
use bendtwin_picture::{Canvas, Color, Error, Rect, View};

use super::{FAINT, Figure, HAND};
use crate::{
    picture_inputs::PictureInputs,
    scan::crop::Label,
    vector::{Upright, Vector, add, cross, dot, scaled, to_world, unit, wide},
};

/// Frames that are shown, side by side.
const PANELS: usize = 5;
/// Width of a panel [px].
const PANEL_PX: f32 = 300.0;
/// Distance between panels [px].
const GAP_PX: f32 = 12.0;
/// Points of one camera in one panel.
const MAX_POINTS: usize = 7000;
/// Lifted points in one panel.
const MAX_LIFTED_POINTS: usize = 20_000;
/// Points of one camera in one frame that decide the view.
const MAX_VIEW_POINTS: usize = 300;
/// Smallest distance between lines on the ground [m].
const GRID_M: f64 = 0.05;

/// A coloured point.
struct Dot {
    at: Point,
    color: Color,
    radius: f32,
}

/// The points that all cameras saw, at a few frames.
pub(crate) fn seen(inputs: &PictureInputs) -> Result<Option<Figure>, Error> {
    let mut frames: Vec<usize> =
        inputs.cameras.iter().flat_map(|c| c.crops.iter().map(|s| s.frame)).collect();
    frames.sort_unstable();
    frames.dedup();
    let frames = evenly_taken(&frames);
    let panels: Vec<Vec<Dot>> =
        frames.iter().map(|f| dots_of_cameras(inputs, *f, MAX_POINTS)).collect();
    let Some(png) = strip(&panels, inputs)? else { return Ok(None) };
    let caption = format!(
        "Measured points of object and hand (red) in frames {}, all cameras together, from one viewpoint.",
        list(&frames)
    );
    Ok(Some(Figure { png, caption }))
}

/// The points of a capture, at a few frames.
pub(crate) fn lifted(inputs: &PictureInputs) -> Result<Option<Figure>, Error> {
    let Some(capture) = &inputs.capture else { return Ok(None) };
    let Some(sequence) = capture.sequences.first() else { return Ok(None) };
    let frames: Vec<usize> = (sequence.start_frame()..sequence.frame_count).collect();
    let frames = evenly_taken(&frames);
    let colors = &capture.object.colors;
    let panels: Vec<Vec<Dot>> =
        frames.iter().map(|f| dots_of_points(sequence, colors, *f)).collect();
    let Some(png) = strip(&panels, inputs)? else { return Ok(None) };
    let caption = format!(
        "Tracked points and control points (red) in frames {}: what a fit will see.",
        list(&frames)
    );
    Ok(Some(Figure { png, caption }))
}

fn list(frames: &[usize]) -> String {
    frames.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")
}

fn evenly_taken(frames: &[usize]) -> Vec<usize> {
    let last = frames.len().saturating_sub(1);
    let mut chosen: Vec<usize> =
        (0..PANELS).filter_map(|i| frames.get(i * last / (PANELS - 1)).copied()).collect();
    chosen.dedup();
    chosen
}

fn dots_of_cameras(inputs: &PictureInputs, frame: usize, most: usize) -> Vec<Dot> {
    let mut dots = Vec::new();
    for pictures in &inputs.cameras {
        let Some(crop) = pictures.crops.iter().find(|s| s.frame == frame) else { continue };
        let pose = pictures.camera.pose(frame);
        for surfel in crop.surfels(&pictures.camera, most) {
            let at = to_world(pose, surfel.at).map(|x| x as f32);
            if !at.iter().all(|x| x.is_finite()) {
                continue;
            }
            let [r, g, b] = surfel.color;
            let color = if surfel.label == Label::Manipulator { HAND } else { Color(r, g, b) };
            dots.push(Dot { at, color, radius: 1.5 });
        }
    }
    dots
}

fn dots_of_points(sequence: &Sequence, colors: &[Point], frame: usize) -> Vec<Dot> {
    let shade = |i: usize| match colors.get(i) {
        Some(c) => {
            let [r, g, b] = c.map(|x| (255.0 * x.clamp(0.0, 1.0)) as u8);
            Color(r, g, b)
        }
        None => super::ACCENT,
    };
    let points = sequence.points_at(frame).iter().zip(sequence.visible_at(frame)).enumerate();
    let points = points.step_by(sequence.points_at(frame).len().div_ceil(MAX_LIFTED_POINTS).max(1));
    let mut dots: Vec<Dot> = points
        .filter(|(_, (p, seen))| **seen && p.iter().all(|x| x.is_finite()))
        .map(|(i, (p, _))| Dot { at: *p, color: shade(i), radius: 2.4 })
        .collect();
    let controls = sequence.controls_at(frame).iter().filter(|p| p.iter().all(|x| x.is_finite()));
    dots.extend(controls.map(|p| Dot { at: *p, color: HAND, radius: 3.2 }));
    dots
}

/// Points that decide the view: those that cameras saw, so that both strips have one view, or else
/// the lifted ones.
fn scene(inputs: &PictureInputs, panels: &[Vec<Dot>]) -> Vec<Point> {
    let frames: Vec<usize> =
        inputs.cameras.iter().flat_map(|c| c.crops.iter().map(|s| s.frame)).collect();
    let seen =
        frames.iter().flat_map(|f| dots_of_cameras(inputs, *f, MAX_VIEW_POINTS)).map(|d| d.at);
    let seen: Vec<Point> = seen.collect();
    if seen.is_empty() { panels.iter().flatten().map(|d| d.at).collect() } else { seen }
}

fn strip(panels: &[Vec<Dot>], inputs: &PictureInputs) -> Result<Option<Vec<u8>>, Error> {
    let environment = &inputs.environment;
    let eyes: Vec<Vector> = inputs.cameras.iter().map(|c| c.camera.pose(0).translation).collect();
    let eye = scaled(eyes.iter().fold([0.0; 3], |s, e| add(s, *e)), 1.0 / eyes.len().max(1) as f64);
    let eye = (!eyes.is_empty()).then(|| eye.map(|x| x as f32));
    let trimmed = trim(scene(inputs, panels));
    let Some(view) = View::from_side(trimmed.clone(), environment.gravity, eye) else {
        return Ok(None);
    };
    let height = (PANEL_PX * view.aspect()).clamp(120.0, 420.0);
    let count = panels.len() as f32;
    let mut canvas = Canvas::transparent(count * PANEL_PX + (count - 1.0) * GAP_PX, height)?;
    for (i, dots) in panels.iter().enumerate() {
        let area = Rect { x: i as f32 * (PANEL_PX + GAP_PX), y: 0.0, width: PANEL_PX, height };
        let clip = canvas.clip(area);
        for [from, to] in grid(&trimmed, environment) {
            let (from, to) = (view.place(from, area), view.place(to, area));
            canvas.line(from, to, 1.0, FAINT, 0.28, clip.as_ref());
        }
        let mut order: Vec<&Dot> = dots.iter().collect();
        order.sort_by(|a, b| view.nearness(a.at).total_cmp(&view.nearness(b.at)));
        for dot in order {
            let at = view.place(dot.at, area);
            canvas.disc_clipped(at, dot.radius, dot.color, 1.0, clip.as_ref());
        }
    }
    canvas.to_png().map(Some)
}

/// Without the outermost per mille along each axis: one flying pixel would make everything else
/// small.
fn trim(points: Vec<Point>) -> Vec<Point> {
    let bound = |a: usize, share: f64| {
        let mut values: Vec<f64> = points.iter().map(|p| f64::from(p[a])).collect();
        crate::statistics::quantile(&mut values, share).unwrap_or(0.0)
    };
    let low: [f64; 3] = std::array::from_fn(|a| bound(a, 0.002));
    let high: [f64; 3] = std::array::from_fn(|a| bound(a, 0.998));
    let within = |p: &Point| (0..3).all(|a| (low[a]..=high[a]).contains(&f64::from(p[a])));
    points.into_iter().filter(within).collect()
}

/// A net of lines on the ground below the points, if the ground is near.
fn grid(points: &[Point], environment: &Environment) -> Vec<[Point; 2]> {
    let upright = Upright::of(environment);
    let across =
        unit(cross(upright.up, [1.0, 0.0, 0.0])).or(unit(cross(upright.up, [0.0, 1.0, 0.0])));
    let (Some(across), true) = (across, upright.grounded) else { return Vec::new() };
    let along = cross(across, upright.up);
    let range = |axis: Vector| {
        let values = points.iter().map(|p| dot(wide(*p), axis));
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)))
    };
    let ((a0, a1), (b0, b1)) = (range(across), range(along));
    let (low, high) = range(upright.up);
    let extent = (a1 - a0).max(b1 - b0).max(high - low);
    if !(extent.is_finite() && extent > 0.0) || low - upright.offset_m > extent {
        return Vec::new();
    }
    let mut step = GRID_M;
    while extent / step > 12.0 {
        step *= 2.0;
    }
    let floor = |v: f64| (v / step).floor() as i64 - 1;
    let ceil = |v: f64| (v / step).ceil() as i64 + 1;
    let place = |a: f64, b: f64| -> Point {
        let flat = add(scaled(across, a), scaled(along, b));
        add(flat, scaled(upright.up, upright.offset_m)).map(|x| x as f32)
    };
    let (a_low, a_high, b_low, b_high) = (floor(a0), ceil(a1), floor(b0), ceil(b1));
    let at = |i: i64| i as f64 * step;
    let mut lines: Vec<[Point; 2]> =
        (a_low..=a_high).map(|i| [place(at(i), at(b_low)), place(at(i), at(b_high))]).collect();
    lines.extend((b_low..=b_high).map(|i| [place(at(a_low), at(i)), place(at(a_high), at(i))]));
    lines
}
