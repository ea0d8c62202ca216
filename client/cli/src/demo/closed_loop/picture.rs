//! The picture of a closed loop: the rope on its way to the goal, and the distance over time.

use bendtwin_client::{Point, TwinModel};
use bendtwin_core::geometry::distance;
use bendtwin_picture::{Align, Canvas, Color, Error, Rect, View};

use super::rope::Rope;

const WIDTH: f32 = 900.0;
const MARGIN: f32 = 24.0;
const HEADER: f32 = 56.0;
const CHART: f32 = 200.0;
const BACKGROUND: Color = Color(255, 255, 255);
const PANEL: Color = Color(246, 248, 250);
const INK: Color = Color(36, 41, 47);
const FAINT: Color = Color(110, 119, 129);
const ROPE: Color = Color(0, 114, 178);
const WAY: Color = Color(213, 94, 0);
const GOAL: Color = Color(0, 158, 115);

/// Content of the picture.
pub(super) struct Scene {
    springs: Vec<[u32; 2]>,
    gravity: Point,
    step_s: f64,
    goal: Point,
    /// Nodes after each step [m], and the end of the rope among them.
    shapes: Vec<Vec<Point>>,
    tips: Vec<Point>,
}

impl Scene {
    /// A scene that begins where the rope is.
    pub(super) fn new(model: &TwinModel, rope: &Rope, goal: Point) -> Self {
        let mut scene = Self {
            springs: model.graph.springs.clone(),
            gravity: model.environment.gravity,
            step_s: super::STEP as f64 * model.timing.frame_s(),
            goal,
            shapes: Vec::new(),
            tips: Vec::new(),
        };
        scene.record(rope);
        scene
    }

    /// Adds where the rope is now.
    pub(super) fn record(&mut self, rope: &Rope) {
        self.shapes.push(rope.positions.clone());
        self.tips.push(rope.tip());
    }

    /// Distance of the rope's end to the goal after each step, the start included.
    pub(super) fn distances_mm(&self) -> Vec<f64> {
        self.tips.iter().map(|tip| 1000.0 * f64::from(distance(*tip, self.goal))).collect()
    }

    pub(super) fn nearest_mm(&self) -> f64 {
        self.distances_mm().into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Draws it as a PNG file.
    pub(super) fn to_png(&self) -> Result<Vec<u8>, Error> {
        let shown = self.shapes.iter().flatten().chain([&self.goal]).copied();
        let points: Vec<Point> = shown.filter(|p| p.iter().all(|x| x.is_finite())).collect();
        let empty = || Error::Size { width: 0.0, height: 0.0 };
        let above = View::from_above(&points, self.gravity);
        let side = View::of(points, self.gravity).ok_or_else(empty)?;
        let (mut views, mut y) = (Vec::new(), HEADER);
        // Either view alone hides a distance; without gravity there is no view from above.
        let both = [Some(("from the side", side)), above.map(|view| ("from above", view))];
        for (from, view) in both.into_iter().flatten() {
            let width = WIDTH - 2.0 * MARGIN;
            let height = (width * view.aspect()).clamp(140.0, 400.0);
            views.push((from, view, Rect { x: MARGIN, y, width, height }));
            y += height + MARGIN;
        }
        let chart =
            Rect { x: MARGIN, y: y + 2.0 * MARGIN, width: WIDTH - 2.0 * MARGIN, height: CHART };
        let mut canvas = Canvas::new(WIDTH, chart.y + chart.height + 2.0 * MARGIN, BACKGROUND)?;
        canvas.bold(MARGIN, 18.0, INK, "A rope's end on its way to a goal");
        canvas.text(
            WIDTH - MARGIN,
            20.0,
            FAINT,
            "goal: green   path of the end: orange",
            Align::Right,
        );
        for (from, view, panel) in &views {
            canvas.fill(*panel, PANEL);
            self.draw_rope(&mut canvas, view, *panel);
            canvas.text(panel.x + 6.0, panel.y + 4.0, FAINT, from, Align::Left);
        }
        self.draw_distances(&mut canvas, chart);
        canvas.to_png()
    }

    fn draw_rope(&self, canvas: &mut Canvas, view: &View, panel: Rect) {
        let last = self.shapes.len().saturating_sub(1);
        for (step, shape) in
            self.shapes.iter().enumerate().filter(|(s, _)| s % 4 == 0 || *s == last)
        {
            let alpha =
                if step == last { 0.9 } else { 0.12 + 0.3 * step as f32 / last.max(1) as f32 };
            for [a, b] in &self.springs {
                if let (Some(a), Some(b)) = (shape.get(*a as usize), shape.get(*b as usize)) {
                    let (from, to) = (view.place(*a, panel), view.place(*b, panel));
                    canvas.line(from, to, 1.0, ROPE, 0.5 * alpha, None);
                }
            }
            for node in shape {
                canvas.disc(view.place(*node, panel), 2.5, ROPE, alpha);
            }
        }
        let way: Vec<[f32; 2]> = self.tips.iter().map(|tip| view.place(*tip, panel)).collect();
        canvas.polyline(&way, 2.5, WAY, 0.9, None);
        canvas.disc(view.place(self.goal, panel), 9.0, GOAL, 0.9);
        if let Some(end) = way.last() {
            canvas.disc(*end, 5.0, WAY, 1.0);
        }
    }

    fn draw_distances(&self, canvas: &mut Canvas, area: Rect) {
        let distances = self.distances_mm();
        let most = distances.iter().copied().fold(1.0, f64::max);
        let steps = distances.len().saturating_sub(1).max(1) as f32;
        canvas.text(area.x, area.y - 24.0, INK, "distance to the goal", Align::Left);
        canvas.fill(area, PANEL);
        let at = |(step, mm): (usize, &f64)| {
            let height = area.height * (1.0 - (*mm / most) as f32);
            [area.x + area.width * step as f32 / steps, area.y + height]
        };
        let line: Vec<[f32; 2]> = distances.iter().enumerate().map(at).collect();
        canvas.polyline(&line, 2.5, WAY, 1.0, None);
        let (right, below) = (area.x + area.width, area.y + area.height + 6.0);
        canvas.text(area.x + 6.0, area.y + 4.0, FAINT, &format!("{most:.0} mm"), Align::Left);
        let last = distances.last().copied().unwrap_or_default();
        canvas.text(
            right - 6.0,
            area.y + 4.0,
            INK,
            &format!("{last:.1} mm at the end"),
            Align::Right,
        );
        canvas.text(area.x, below, FAINT, "0 s", Align::Left);
        let end = format!("{:.1} s", self.step_s * f64::from(steps));
        canvas.text(right, below, FAINT, &end, Align::Right);
    }
}
