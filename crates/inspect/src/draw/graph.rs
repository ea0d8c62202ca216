//! The graph that a fit with default settings would start from, over the first image of each
//! camera.

use std::borrow::Cow;

use bendtwin_core::{
    Capture, Graph, NodeKind, Point, Sequence,
    capture::{HeldPoint, Object},
    settings::FitSettings,
};
use bendtwin_graph::{Connectivity, NodeSample, connect, sample_nodes};
use bendtwin_picture::{Canvas, Color, Error, Photograph, Rect, View};

use super::{ACCENT, Figure, Figures, HAND, enlargement};
use crate::picture_inputs::{CameraPictures, PictureInputs};

/// Width of a picture [px].
const WIDTH: f32 = 640.0;
/// Cameras that are shown.
const MAX_CAMERAS: usize = 3;
/// Most points of a capture that become nodes; more are thinned out, since nobody could tell them apart.
const MAX_POINTS: usize = 6_000;
/// Most springs that are drawn.
const MAX_SPRINGS: usize = 6000;
const SPRING: Color = Color(255, 255, 255);
const INNER: Color = Color(240, 190, 60);
const COMPLETED: Color = Color(150, 120, 220);
/// Free space around the graph in the picture, as a share of its extent.
const BORDER: f32 = 0.25;

/// A picture for each camera; without images, one picture from the side. None without a capture
/// that can be joined.
pub(crate) fn graph(inputs: &PictureInputs) -> Figures {
    let Some(capture) = inputs.capture.as_ref().and_then(thinned) else { return Ok(Vec::new()) };
    let mut settings = FitSettings::default();
    let Ok(sample) = sample_nodes(&capture, &settings.graph, settings.seed) else {
        return Ok(Vec::new());
    };
    settings.graph.radius_m = Some(sample.radius_m(&settings.graph));
    let graph = connect(&sample, &Connectivity::from_settings(&settings.graph, settings.bending));
    let drawing = Drawing { graph: &graph, sample: &sample };
    let with_image = inputs.cameras.iter().enumerate().filter(|(_, w)| w.first_image.is_some());
    let figures: Vec<Option<Figure>> = with_image
        .take(MAX_CAMERAS)
        .map(|(i, pictures)| drawing.over(i, pictures))
        .collect::<Result<_, _>>()?;
    let mut figures: Vec<Figure> = figures.into_iter().flatten().collect();
    if figures.is_empty() {
        figures.extend(drawing.alone(inputs)?);
    }
    Ok(figures)
}

/// The start of a capture's first sequence with at most [`MAX_POINTS`] points, evenly taken. None of a cable
/// of more, whose edges need all of them.
fn thinned(capture: &Capture) -> Option<Cow<'_, Capture>> {
    let object = &capture.object;
    let points = object.point_count + object.completed_surface.len() + object.interior.len();
    let step = points.div_ceil(MAX_POINTS);
    if step <= 1 {
        return Some(Cow::Borrowed(capture));
    }
    let first = capture.sequences.first().filter(|_| object.edges.is_empty())?;
    let frames = first.start_frame() + 1;
    let rows = |width: usize| 0..frames.saturating_mul(width);
    let each = |points: &[Point]| points.iter().step_by(step).copied().collect::<Vec<Point>>();
    let columns = |frame: usize| each(first.points_at(frame));
    let flags = |frame: usize| first.visible_at(frame).iter().step_by(step).copied();
    let sequence = Sequence {
        frame_count: frames,
        points: (0..frames).flat_map(columns).collect(),
        visible: (0..frames).flat_map(flags).collect(),
        controls: first.controls.get(rows(first.control_count()))?.to_vec(),
        start_frames: first.start_frames,
        ..Sequence::default()
    };
    let pins = object.pins.iter().filter(|pin| (pin.point as usize).is_multiple_of(step));
    let pin = |pin: &HeldPoint| HeldPoint { point: pin.point / step as u32, ..*pin };
    let object = Object {
        point_count: object.point_count.div_ceil(step),
        completed_surface: each(&object.completed_surface),
        interior: each(&object.interior),
        rest_points: each(&object.rest_points),
        pins: pins.map(pin).collect(),
        ..Object::default()
    };
    Some(Cow::Owned(Capture {
        name: capture.name.clone(),
        object,
        sequences: vec![sequence],
        fps: capture.fps,
        environment: capture.environment,
        source_to_world: capture.source_to_world,
        others: Vec::new(),
    }))
}

struct Drawing<'a> {
    graph: &'a Graph,
    sample: &'a NodeSample,
}

impl Drawing<'_> {
    fn caption(&self) -> String {
        format!(
            "{} nodes (teal: tracked, violet: completed, yellow: inside), {} springs, {} bending triplets, {} control points (red); \
             the topology that a fit starts from",
            self.graph.node_count(),
            self.graph.springs.len(),
            self.graph.triplets.len(),
            self.sample.control_rest.len()
        )
    }

    fn over(&self, index: usize, pictures: &CameraPictures) -> Result<Option<Figure>, Error> {
        let Some((frame, first_image)) = &pictures.first_image else { return Ok(None) };
        let pixel = |p: &Point| {
            pictures.camera.project(*p, *frame).map(|(pixel, _)| pixel.map(|x| x as f32))
        };
        let places: Vec<Option<[f32; 2]>> = self.sample.positions.iter().map(pixel).collect();
        let controls: Vec<Option<[f32; 2]>> = self.sample.control_rest.iter().map(pixel).collect();
        let inside = |p: &&[f32; 2]| {
            (0.0..first_image.width as f32).contains(&p[0])
                && (0.0..first_image.height as f32).contains(&p[1])
        };
        let shown: Vec<[f32; 2]> =
            places.iter().chain(&controls).flatten().filter(inside).copied().collect();
        let Some(area) = crop(&shown, first_image.width, first_image.height) else {
            return Ok(None);
        };
        let [x0, y0, x1, y1] = area;
        let rows = (y0..y1).flat_map(|row| {
            first_image.row(row)[x0..x1].iter().map(|p| p.map(|c| (f32::from(c) * 0.72) as u8))
        });
        let Some(photograph) = Photograph::new(x1 - x0, y1 - y0, rows.collect()) else {
            return Ok(None);
        };
        let scale = enlargement(x1 - x0, WIDTH);
        let extent = |pixels: usize| (scale * pixels as f32).floor().max(1.0);
        let (width, height) = (extent(x1 - x0), extent(y1 - y0));
        let mut canvas = Canvas::new(width, height, Color(0, 0, 0))?;
        canvas.photograph(Rect { x: 0.0, y: 0.0, width, height }, &photograph);
        let place = |p: &Option<[f32; 2]>| {
            p.map(|[x, y]| [(x + 0.5 - x0 as f32) * scale, (y + 0.5 - y0 as f32) * scale])
        };
        let places: Vec<_> = places.iter().map(place).collect();
        let controls: Vec<_> = controls.iter().map(place).collect();
        self.draw(&mut canvas, &places, &controls, SPRING);
        let caption = format!(
            "Camera {index} ({}), frame {frame}: {}.",
            pictures.camera.name,
            self.caption()
        );
        Ok(Some(Figure { png: canvas.to_png()?, caption }))
    }

    fn alone(&self, inputs: &PictureInputs) -> Result<Option<Figure>, Error> {
        let points = self.sample.positions.iter().chain(&self.sample.control_rest).copied();
        let points = points.filter(|p| p.iter().all(|x| x.is_finite())).collect();
        let Some(view) = View::of(points, inputs.environment.gravity) else { return Ok(None) };
        let height = (WIDTH * view.aspect()).clamp(160.0, 640.0);
        let area = Rect { x: 0.0, y: 0.0, width: WIDTH, height };
        let mut canvas = Canvas::transparent(WIDTH, height)?;
        let place = |p: &Point| Some(view.place(*p, area));
        let places: Vec<_> = self.sample.positions.iter().map(place).collect();
        let controls: Vec<_> = self.sample.control_rest.iter().map(place).collect();
        self.draw(&mut canvas, &places, &controls, super::FAINT);
        Ok(Some(Figure { png: canvas.to_png()?, caption: format!("{}.", self.caption()) }))
    }

    fn draw(
        &self,
        canvas: &mut Canvas,
        places: &[Option<[f32; 2]>],
        controls: &[Option<[f32; 2]>],
        spring: Color,
    ) {
        let every = self.graph.springs.len().div_ceil(MAX_SPRINGS).max(1);
        for &[a, b] in self.graph.springs.iter().step_by(every) {
            let end = |i: u32| places.get(i as usize).copied().flatten();
            if let (Some(a), Some(b)) = (end(a), end(b)) {
                canvas.line(a, b, 0.9, spring, 0.38, None);
            }
        }
        // Dense graphs are drawn finer, or nodes would hide the springs.
        let radius = (3.4 * (250.0 / places.len().max(1) as f32).sqrt()).clamp(1.4, 3.4);
        for (place, kind) in places.iter().zip(&self.sample.kinds) {
            let color = match kind {
                NodeKind::Observed => ACCENT,
                NodeKind::Completed => COMPLETED,
                NodeKind::Interior => INNER,
            };
            if let Some(at) = place {
                canvas.disc(*at, radius + 1.1, Color(20, 24, 28), 0.8);
                canvas.disc(*at, radius, color, 1.0);
            }
        }
        for at in controls.iter().flatten() {
            canvas.disc(*at, 3.6, Color(20, 24, 28), 0.8);
            canvas.disc(*at, 2.6, HAND, 1.0);
        }
    }
}

/// The part of an image around points: columns and rows from and to.
fn crop(points: &[[f32; 2]], width: usize, height: usize) -> Option<[usize; 4]> {
    let first = points.first()?;
    let (mut low, mut high) = (*first, *first);
    for p in points {
        low = [low[0].min(p[0]), low[1].min(p[1])];
        high = [high[0].max(p[0]), high[1].max(p[1])];
    }
    let border = BORDER * (high[0] - low[0]).max(high[1] - low[1]).max(20.0);
    let from = |a: usize| (low[a] - border).max(0.0) as usize;
    let to = |a: usize, end: usize| ((high[a] + border).ceil().max(0.0) as usize).min(end);
    let area = [from(0), from(1), to(0, width), to(1, height)];
    (area[0] < area[2] && area[1] < area[3]).then_some(area)
}
