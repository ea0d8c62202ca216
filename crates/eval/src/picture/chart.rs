//! The error of every frame, as lines over time, with the future set apart.

use bendtwin_picture::{Align, Canvas, Color, Rect};

use super::{FAINT, FUTURE, FUTURE_EDGE, INK, PANEL};

const LEFT: f32 = 56.0;
const BOTTOM: f32 = 26.0;
const TOP: f32 = 34.0;
/// The axis ends at this multiple of the largest error of a model; reference lines may leave the
/// chart.
const HEADROOM: f64 = 1.25;

/// A line of a chart.
pub(super) struct Line<'a> {
    pub(super) name: &'a str,
    pub(super) color: Color,
    /// Values by frame; NaN for frames without one.
    pub(super) values: Vec<f64>,
    /// Shown for comparison only: the axis does not stretch for it.
    pub(super) is_reference: bool,
}

/// Lines over frames.
pub(super) struct Chart<'a> {
    pub(super) title: &'a str,
    pub(super) lines: &'a [Line<'a>],
    /// Frame of the first value.
    pub(super) first_frame: usize,
    /// First frame that the fit never saw.
    pub(super) future_from: usize,
    pub(super) fps: f64,
}

impl Chart<'_> {
    pub(super) fn draw(&self, canvas: &mut Canvas, area: Rect) {
        let plot = Rect {
            x: area.x + LEFT,
            y: area.y + TOP,
            width: area.width - LEFT,
            height: area.height - TOP - BOTTOM,
        };
        canvas.fill(plot, PANEL);
        canvas.text(area.x, area.y + 4.0, INK, self.title, Align::Left);
        let mut x = area.x + area.width;
        for line in self.lines.iter().rev() {
            x -= Canvas::text_width(line.name);
            canvas.text(x, area.y + 4.0, FAINT, line.name, Align::Left);
            x -= 30.0;
            let y = area.y + 12.0;
            canvas.line([x, y], [x + 22.0, y], 3.0, line.color, 1.0, None);
            x -= 18.0;
        }

        let frames = self.lines.iter().map(|l| l.values.len()).max().unwrap_or(0);
        let last = self.first_frame + frames.saturating_sub(1);
        let across = |frame: usize| {
            let share = (frame - self.first_frame.min(frame)) as f32
                / frames.saturating_sub(1).max(1) as f32;
            plot.x + share.min(1.0) * plot.width
        };
        if self.future_from <= last {
            let from = across(self.future_from.max(self.first_frame));
            let future = Rect { x: from, width: plot.x + plot.width - from, ..plot };
            canvas.fill(future, FUTURE);
            canvas.line([from, plot.y], [from, plot.y + plot.height], 1.5, FUTURE_EDGE, 1.0, None);
            canvas.text(from + 8.0, plot.y + 6.0, FAINT, "future", Align::Left);
        }

        let top = self.top();
        let up = |value: f64| plot.y + plot.height * (1.0 - (value / top) as f32);
        let step = tick(top);
        let mut value = 0.0;
        while value <= top * 1.0001 {
            let y = up(value);
            canvas.line([plot.x, y], [plot.x + plot.width, y], 0.8, FAINT, 0.3, None);
            let label = if step < 1.0 { format!("{value:.1}") } else { format!("{value:.0}") };
            canvas.text(plot.x - 8.0, y - 8.0, FAINT, &label, Align::Right);
            value += step;
        }
        for (frame, align) in [(self.first_frame, Align::Left), (last, Align::Right)] {
            let label = format!("{:.2} s", frame as f64 / self.fps);
            canvas.text(across(frame), plot.y + plot.height + 6.0, FAINT, &label, align);
        }
        let clip = canvas.clip(plot);
        for line in self.lines {
            let width = if line.is_reference { 1.5 } else { 2.5 };
            // A gap in the values is a gap in the line.
            for part in parts(&line.values) {
                let points: Vec<[f32; 2]> = part
                    .iter()
                    .map(|&(i, v)| [across(self.first_frame + i), up(v.min(10.0 * top))])
                    .collect();
                canvas.polyline(&points, width, line.color, 0.95, clip.as_ref());
            }
        }
    }

    fn top(&self) -> f64 {
        let largest = |reference: bool| {
            let lines = self.lines.iter().filter(|l| l.is_reference == reference);
            lines.flat_map(|l| &l.values).copied().filter(|v| v.is_finite()).fold(0.0, f64::max)
        };
        let top = HEADROOM * if largest(false) > 0.0 { largest(false) } else { largest(true) };
        if top > 0.0 { top } else { 1.0 }
    }
}

/// Consecutive finite values with their indices.
fn parts(values: &[f64]) -> Vec<Vec<(usize, f64)>> {
    let mut parts = vec![Vec::new()];
    for (i, &v) in values.iter().enumerate() {
        match parts.last_mut() {
            Some(part) if v.is_finite() => part.push((i, v)),
            _ => parts.push(Vec::new()),
        }
    }
    parts.retain(|p| !p.is_empty());
    parts
}

/// A round step that divides the axis into three to seven parts.
fn tick(top: f64) -> f64 {
    let raw = top / 5.0;
    let decade = 10_f64.powf(raw.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|s| s * decade);
    steps.into_iter().find(|s| *s >= raw).unwrap_or(raw)
}
