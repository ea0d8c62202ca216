//! The picture of differences by mean degree: a panel for each group of captures, a line for each
//! series, with intervals; differences of too few runs are left out.

use bendtwin_picture::{Align, Canvas, Color, Rect};

use crate::{Error, Gain, Gains, Verdict, suite::MOST_SERIES};

const MARGIN: f32 = 24.0;
const HEADER: f32 = 84.0;
const FOOTER: f32 = 80.0;
const PANEL_WIDTH: f32 = 380.0;
const PANEL_HEIGHT: f32 = 340.0;
const GAP: f32 = 24.0;
const AXIS_WIDTH: f32 = 64.0;
/// Space for the texts around a single panel.
const LEAST_WIDTH: f32 = 760.0;
const BACKGROUND: Color = Color(255, 255, 255);
const PANEL: Color = Color(246, 248, 250);
const INK: Color = Color(36, 41, 47);
const FAINT: Color = Color(110, 119, 129);
/// A colour for each series; safe for most colour-blind readers.
const SERIES: [Color; MOST_SERIES] = [Color(0, 114, 178), Color(213, 94, 0), Color(0, 158, 115)];
/// Springs that a node of a rigid graph has at least (Maxwell): three a node, each at two of them.
const RIGID_DEGREE: f64 = 6.0;
/// Axes that are smaller than this would make noise look like a difference [%].
const LEAST_PERCENT: f64 = 20.0;

/// Draws the picture as a PNG file.
///
/// # Errors
/// If it cannot be drawn.
pub fn draw_figure(gains: &Gains) -> Result<Vec<u8>, Error> {
    let panels: Vec<&Option<String>> =
        gains.groups.iter().filter(|g| gains.gains.iter().any(|x| x.group == **g)).collect();
    let columns = panels.len().max(1) as f32;
    let width = 2.0 * MARGIN + AXIS_WIDTH + columns * (PANEL_WIDTH + GAP) - GAP;
    let width = width.max(LEAST_WIDTH);
    let height = HEADER + PANEL_HEIGHT + FOOTER;
    let failed = |e: bendtwin_picture::Error| Error::Writing(e.to_string());
    let mut canvas = Canvas::new(width, height, BACKGROUND).map_err(failed)?;
    canvas.bold(MARGIN, 16.0, INK, &gains.title);
    legend(&mut canvas, gains);
    let axes = Axes::of(gains.gains.iter().filter(|g| g.certainty.is_some()));
    let area = |column: usize| Rect {
        x: MARGIN + AXIS_WIDTH + column as f32 * (PANEL_WIDTH + GAP),
        y: HEADER,
        width: PANEL_WIDTH,
        height: PANEL_HEIGHT,
    };
    for (column, group) in panels.iter().enumerate() {
        axes.draw(&mut canvas, area(column), column == 0);
        let name = group.as_deref().unwrap_or("all captures");
        canvas.text(area(column).x + 10.0, HEADER + 8.0, INK, name, Align::Left);
        for (series, color) in gains.series.iter().zip(SERIES) {
            let own =
                |g: &&Gain| g.series == *series && g.group == **group && g.certainty.is_some();
            let own: Vec<&Gain> = gains.gains.iter().filter(own).collect();
            draw_series(&mut canvas, &axes, area(column), &own, color);
        }
    }
    let left = MARGIN + AXIS_WIDTH;
    let below = HEADER + PANEL_HEIGHT + 28.0;
    let axis = "springs that meet at a node (mean degree)";
    canvas.text(left, below, INK, axis, Align::Left);
    let about = "bars: 95 % of draws of captures and seeds; hollow: no difference";
    canvas.text(left, below + 22.0, FAINT, about, Align::Left);
    canvas.to_png().map_err(failed)
}

fn legend(canvas: &mut Canvas, gains: &Gains) {
    let mut x = MARGIN;
    for (name, color) in gains.series.iter().zip(SERIES) {
        canvas.disc([x + 5.0, 60.0], 5.0, color, 1.0);
        canvas.text(x + 16.0, 52.0, FAINT, name, Align::Left);
        x += 40.0 + Canvas::text_width(name);
    }
}

/// Both axes, which all panels share: degrees by ratio, percent evenly.
struct Axes {
    degrees: [f64; 2],
    percent: [f64; 2],
}

impl Axes {
    fn of<'a>(gains: impl Iterator<Item = &'a Gain> + Clone) -> Self {
        let degrees = || gains.clone().map(|g| g.mean_degree).chain([RIGID_DEGREE]);
        let ends = gains.clone().flat_map(|g| {
            let interval = g.certainty.map(|c| c.interval);
            interval.into_iter().flatten().chain([g.percent])
        });
        let ends: Vec<f64> = ends.collect();
        let low = ends.iter().copied().fold(-LEAST_PERCENT, f64::min);
        let high = ends.iter().copied().fold(LEAST_PERCENT, f64::max).min(100.0);
        let room = 0.06 * (high - low);
        Self {
            degrees: [
                0.85 * degrees().fold(f64::INFINITY, f64::min),
                1.18 * degrees().fold(0.0, f64::max),
            ],
            percent: [low - room, high + room],
        }
    }

    fn x(&self, area: Rect, degree: f64) -> f32 {
        let [low, high] = self.degrees.map(f64::ln);
        area.x + area.width * ((degree.ln() - low) / (high - low)) as f32
    }

    fn y(&self, area: Rect, percent: f64) -> f32 {
        let [low, high] = self.percent;
        let share = (percent.clamp(low, high) - low) / (high - low);
        area.y + area.height * (1.0 - share as f32)
    }

    fn draw(&self, canvas: &mut Canvas, area: Rect, is_first: bool) {
        canvas.fill(area, PANEL);
        let right = area.x + area.width;
        let step = if self.percent[1] - self.percent[0] > 120.0 { 20.0 } else { 10.0 };
        let steps = |percent: f64| (percent / step) as i32;
        for index in steps(self.percent[0])..=steps(self.percent[1]) {
            let percent = step * f64::from(index);
            let y = self.y(area, percent);
            let (weight, alpha) = if index == 0 { (1.6, 0.9) } else { (0.8, 0.3) };
            canvas.line([area.x, y], [right, y], weight, FAINT, alpha, None);
            if is_first {
                let sign = if percent > 0.0 { "+" } else { "" };
                let label = format!("{sign}{percent:.0} %");
                canvas.text(area.x - 8.0, y - 8.0, FAINT, &label, Align::Right);
            }
        }
        for degree in [2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 20.0, 30.0] {
            if degree > self.degrees[0] && degree < self.degrees[1] {
                let x = self.x(area, degree);
                let (weight, alpha) = if degree == RIGID_DEGREE { (1.6, 0.6) } else { (0.8, 0.2) };
                canvas.line([x, area.y], [x, area.y + area.height], weight, FAINT, alpha, None);
                let label = format!("{degree:.0}");
                let half = 0.5 * Canvas::text_width(&label);
                canvas.text(x - half, area.y + area.height + 6.0, FAINT, &label, Align::Left);
            }
        }
        let x = self.x(area, RIGID_DEGREE) + 6.0;
        canvas.text(x, area.y + area.height - 22.0, FAINT, "rigid from here", Align::Left);
    }
}

fn draw_series(canvas: &mut Canvas, axes: &Axes, area: Rect, gains: &[&Gain], color: Color) {
    let clip = canvas.clip(area);
    let at = |g: &Gain| [axes.x(area, g.mean_degree), axes.y(area, g.percent)];
    let line: Vec<[f32; 2]> = gains.iter().map(|g| at(g)).collect();
    canvas.polyline(&line, 2.0, color, 0.5, clip.as_ref());
    for gain in gains {
        let [x, y] = at(gain);
        if let Some(certainty) = gain.certainty {
            let [low, high] = certainty.interval.map(|p| axes.y(area, p));
            canvas.line([x, low], [x, high], 2.0, color, 0.9, clip.as_ref());
        }
        canvas.disc_clipped([x, y], 6.0, color, 1.0, clip.as_ref());
        if gain.certainty.is_none_or(|c| c.verdict == Verdict::NoDifference) {
            canvas.disc_clipped([x, y], 3.8, PANEL, 1.0, clip.as_ref());
        }
    }
}
