//! Lines over frames, as SVG that takes its colours from the page.

use super::markup::escape;

/// Size of the drawing [units of the SVG].
const WIDTH: f64 = 1000.0;
const HEIGHT: f64 = 150.0;
/// Most points of a line; more are thinned out.
const MAX_POINTS: usize = 500;

/// Colours without the page's style, in a mail for example.
const COLORS: [&str; 6] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#8a6d00", "#56708a"];
pub(super) const RULE: &str = "#c4cad1";

/// A line; gaps for missing values.
pub(super) struct Line {
    pub(super) name: String,
    pub(super) values: Vec<Option<f64>>,
}

/// A chart from 0 to the largest value, or to `top` if that is given.
pub(super) struct Chart<'a> {
    pub(super) title: &'a str,
    pub(super) hint: &'a str,
    pub(super) lines: Vec<Line>,
    pub(super) top: Option<f64>,
    /// Formats a value of the axis.
    pub(super) label: fn(f64) -> String,
    /// A level that values should keep to, drawn dashed.
    pub(super) limit: Option<f64>,
}

impl Chart<'_> {
    pub(super) fn draw(&self, frames: usize) -> String {
        let values = self.lines.iter().flat_map(|l| l.values.iter().flatten());
        let largest = values.copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
        let top = self.top.unwrap_or(1.05 * largest.max(self.limit.unwrap_or(0.0)));
        if frames < 2 || top <= 0.0 || self.lines.is_empty() {
            return String::new();
        }
        let across = |frame: usize| WIDTH * frame as f64 / (frames - 1) as f64;
        let up = |value: f64| HEIGHT * (1.0 - (value / top).clamp(0.0, 1.0));
        let mut drawn = String::new();
        for share in [0.0, 0.5, 1.0] {
            let y = HEIGHT * (1.0 - share);
            drawn.push_str(&format!("<line class=\"rule\" stroke=\"{RULE}\" x1=\"0\" x2=\"{WIDTH}\" y1=\"{y}\" y2=\"{y}\"/>"));
        }
        if let Some(limit) = self.limit {
            let y = up(limit);
            drawn.push_str(&format!("<line class=\"limit\" stroke=\"#b26a00\" stroke-dasharray=\"5 5\" x1=\"0\" x2=\"{WIDTH}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>"));
        }
        let step = frames.div_ceil(MAX_POINTS).max(1);
        for (index, line) in self.lines.iter().enumerate() {
            let mut path = String::new();
            let mut pen = 'M';
            for (frame, value) in line.values.iter().enumerate().step_by(step) {
                match value.filter(|v| v.is_finite()) {
                    Some(value) => {
                        path.push_str(&format!("{pen}{:.1} {:.1}", across(frame), up(value)));
                        pen = 'L';
                    }
                    None => pen = 'M',
                }
            }
            let color = index % COLORS.len();
            drawn.push_str(&format!(
                "<path class=\"line c{color}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\" d=\"{path}\"/>",
                COLORS[color]
            ));
        }
        let keys: String = self
            .lines
            .iter()
            .enumerate()
            .map(|(i, l)| format!("<span class=\"key c{}\">{}</span>", i % 6, escape(&l.name)))
            .collect();
        format!(
            "<figure class=\"chart\"><figcaption><b>{}</b> <span class=\"hint\">{}</span>{keys}</figcaption>\
             <div class=\"plot\"><div class=\"axis\"><span>{}</span><span>{}</span><span>{}</span></div>\
             <svg viewBox=\"0 -2 {WIDTH} {}\" preserveAspectRatio=\"none\" role=\"img\" aria-label=\"{}\">{drawn}</svg></div></figure>\n",
            self.title,
            self.hint,
            (self.label)(top),
            (self.label)(0.5 * top),
            (self.label)(0.0),
            HEIGHT + 4.0,
            escape(self.title),
        )
    }
}
