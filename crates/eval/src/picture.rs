//! A picture of how well a twin predicts: its skin and springs over the observed points at several
//! frames, one row per model, and the error of every frame below.

mod chart;

use bendtwin_core::{Capture, Point, Twin, quality::Predictor};
use bendtwin_picture::{Align, Canvas, Color, Rect, View};

use crate::{
    Error, Trajectory, baselines::standing_still, metrics::Reference, predictor_name,
    surface::Surface,
};

const MARGIN: f32 = 24.0;
const GAP: f32 = 10.0;
const PANEL_WIDTH: f32 = 330.0;
const CHART_HEIGHT: f32 = 250.0;
const HEADER: f32 = 64.0;
const ROW_TITLE: f32 = 34.0;
/// Number of skin points from which they are drawn finer.
const DENSE_POINTS: f32 = 300.0;
/// Most springs drawn.
const MOST_SPRINGS: usize = 4000;
const BACKGROUND: Color = Color(255, 255, 255);
const PANEL: Color = Color(246, 248, 250);
/// Panels of frames that were never shown to the fit.
const FUTURE: Color = Color(255, 247, 232);
const FUTURE_EDGE: Color = Color(230, 159, 0);
const INK: Color = Color(36, 41, 47);
const FAINT: Color = Color(110, 119, 129);
const OBSERVED: Color = Color(40, 44, 52);
const CONTROL: Color = Color(204, 51, 63);
/// A colour for each model; safe for most colour-blind readers.
const MODELS: [Color; 3] = [Color(0, 114, 178), Color(213, 94, 0), Color(0, 158, 115)];

/// A model in the picture.
#[derive(Clone, Copy, Debug)]
pub struct Model<'a> {
    /// Name of the predictor, which titles the row.
    pub name: &'a str,
    /// The twin.
    pub twin: &'a Twin,
    /// Prediction of the sequence that is shown.
    pub trajectory: &'a Trajectory,
}

/// The content of a picture.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// The observed capture.
    pub capture: &'a Capture,
    /// Index of the sequence that is shown.
    pub sequence: usize,
    /// The models, one row each; three at most are drawn.
    pub models: &'a [Model<'a>],
    /// Number of frames shown side by side, 1 to 8.
    pub columns: usize,
}

impl Picture<'_> {
    /// Draws the picture as a PNG file.
    ///
    /// # Errors
    /// If there is no such sequence, the models do not fit it, or there is nothing to draw.
    pub fn to_png(&self) -> Result<Vec<u8>, Error> {
        crate::check_capture(self.capture)?;
        let sequence = self
            .capture
            .sequences
            .get(self.sequence)
            .ok_or_else(|| Error::Picture(format!("there is no sequence {}", self.sequence)))?;
        let models = &self.models[..self.models.len().min(MODELS.len())];
        for m in models {
            let whole = m.trajectory.at(sequence.frame_count - 1).is_some();
            if !whole || m.trajectory.node_count != m.twin.graph.node_count() {
                return Err(Error::Picture("a prediction does not belong to its twin".into()));
            }
        }
        let frames = shown_frames(sequence, self.columns.clamp(1, 8));
        if frames.iter().all(|&f| observed(sequence, f).next().is_none()) {
            return Err(Error::Picture("no point is visible in the frames to show".into()));
        }
        let shown =
            |&f: &usize| observed(sequence, f).chain(sequence.controls_at(f).iter().copied());
        let points = frames.iter().flat_map(shown).filter(crate::distance::is_finite);
        let view = View::of(points.collect(), self.capture.environment.gravity)
            .ok_or_else(|| Error::Picture("there is nothing to show".into()))?;

        let panel_height = (PANEL_WIDTH * view.aspect()).clamp(110.0, 360.0);
        let columns = frames.len() as f32;
        let width = 2.0 * MARGIN + columns * PANEL_WIDTH + (columns - 1.0) * GAP;
        let row_height = ROW_TITLE + panel_height + GAP;
        let rows = models.len() as f32;
        let height = HEADER + rows * row_height + CHART_HEIGHT + 2.0 * MARGIN;
        let mut canvas = Canvas::new(width, height, BACKGROUND)?;

        self.draw_header(&mut canvas, width);
        for (index, model) in models.iter().enumerate() {
            let top = HEADER + index as f32 * row_height;
            canvas.bold(MARGIN, top + 8.0, MODELS[index], model.name);
            for (column, &frame) in frames.iter().enumerate() {
                let panel = Rect {
                    x: MARGIN + column as f32 * (PANEL_WIDTH + GAP),
                    y: top + ROW_TITLE,
                    width: PANEL_WIDTH,
                    height: panel_height,
                };
                self.draw_panel(&mut canvas, &view, panel, model, MODELS[index], frame);
            }
        }
        let chart = Rect {
            x: MARGIN,
            y: HEADER + rows * row_height + MARGIN,
            width: width - 2.0 * MARGIN,
            height: CHART_HEIGHT,
        };
        self.draw_chart(&mut canvas, chart, models);
        Ok(canvas.to_png()?)
    }

    fn draw_header(&self, canvas: &mut Canvas, width: f32) {
        let title = format!("{}: predicted against observed", self.capture.name);
        canvas.bold(MARGIN, 18.0, INK, &title);
        let (right, y) = (width - MARGIN, 18.0);
        let legend = [(OBSERVED, "observed"), (CONTROL, "hand"), (FUTURE_EDGE, "future frames")];
        let mut x = right;
        for (color, label) in legend.iter().rev() {
            x -= Canvas::text_width(label);
            canvas.text(x, y, FAINT, label, Align::Left);
            x -= 12.0;
            canvas.disc([x, y + 8.0], 5.0, *color, 1.0);
            x -= 22.0;
        }
    }

    fn draw_panel(
        &self,
        canvas: &mut Canvas,
        view: &View,
        panel: Rect,
        model: &Model<'_>,
        color: Color,
        frame: usize,
    ) {
        let sequence = &self.capture.sequences[self.sequence];
        let is_future = frame >= sequence.train_frame_count;
        canvas.fill(panel, if is_future { FUTURE } else { PANEL });
        let clip = canvas.clip(panel);
        let Some(nodes) = model.trajectory.at(frame) else { return };
        let graph = &model.twin.graph;
        let at = |p: Point| view.place(p, panel);
        // A dense skin would hide what was observed: it is drawn finer, and below.
        let skin = model.twin.skin.positions(nodes);
        let fineness = (DENSE_POINTS / skin.len().max(1) as f32).sqrt().clamp(0.3, 1.0);
        let every = graph.springs.len().div_ceil(MOST_SPRINGS).max(1);
        for &[a, b] in graph.springs.iter().step_by(every) {
            if let (Some(a), Some(b)) = (nodes.get(a as usize), nodes.get(b as usize)) {
                canvas.line(at(*a), at(*b), 0.8, color, 0.28, clip.as_ref());
            }
        }
        let draw_observed = |canvas: &mut Canvas| {
            for p in observed(sequence, frame) {
                canvas.disc_clipped(at(p), 2.2, OBSERVED, 0.55, clip.as_ref());
            }
        };
        if fineness == 1.0 {
            draw_observed(canvas);
        }
        for p in &skin {
            canvas.disc_clipped(at(*p), 2.6 * fineness, color, 0.95 * fineness, clip.as_ref());
        }
        if fineness < 1.0 {
            draw_observed(canvas);
        }
        for p in sequence.controls_at(frame) {
            canvas.disc_clipped(at(*p), 2.2, CONTROL, 0.8, clip.as_ref());
        }
        let label = format!("{:.2} s", frame as f64 / self.capture.fps);
        let (x, y) = (panel.x + 8.0, panel.y + panel.height - 22.0);
        canvas.text(x, y, FAINT, &label, Align::Left);
        if is_future {
            canvas.frame(panel, FUTURE_EDGE);
        }
    }

    fn draw_chart(&self, canvas: &mut Canvas, area: Rect, models: &[Model<'_>]) {
        let sequence = &self.capture.sequences[self.sequence];
        let first = sequence.start_frame() + 1;
        let mut lines = Vec::new();
        let mut is_track = true;
        for (index, model) in models.iter().enumerate() {
            let twin = model.twin;
            let Some(nodes) = model.trajectory.at(sequence.start_frame()) else { continue };
            let points = Surface::of_skin(&twin.graph, &twin.skin);
            let start = twin.skin.positions(nodes);
            let reference = Reference::new(self.capture, sequence, &points, &start);
            let errors = |t: &Trajectory| {
                let at = |f| t.at(f).map(|nodes| twin.skin.positions(nodes));
                let measure = |f| at(f).map(|points| reference.measure(f, &points));
                (first..sequence.frame_count).filter_map(measure).collect::<Vec<_>>()
            };
            let own = errors(model.trajectory);
            is_track &= own.iter().any(|e| e.track_m.is_some());
            lines.push((model.name, MODELS[index], own));
            if index + 1 == models.len() {
                let still = standing_still(&twin.graph, sequence, nodes);
                let name = predictor_name(Predictor::StandingStill);
                lines.push((name, FAINT, errors(&still)));
            }
        }
        let value = |e: &bendtwin_core::quality::ErrorSummary| {
            1e3 * if is_track { e.track_m } else { e.chamfer_l1_m }.unwrap_or(f64::NAN)
        };
        let lines = lines
            .iter()
            .map(|(name, color, errors)| chart::Line {
                name,
                color: *color,
                values: errors.iter().map(value).collect(),
                is_reference: *name == predictor_name(Predictor::StandingStill),
            })
            .collect::<Vec<_>>();
        let chart = chart::Chart {
            title: if is_track { "track error [mm]" } else { "Chamfer distance [mm]" },
            lines: &lines,
            first_frame: first,
            future_from: sequence.train_frame_count,
            fps: self.capture.fps,
        };
        chart.draw(canvas, area);
    }
}

/// Frames to show: spread over training and future, the last of each among them.
fn shown_frames(sequence: &bendtwin_core::Sequence, columns: usize) -> Vec<usize> {
    let (start, end) = (sequence.start_frame(), sequence.frame_count - 1);
    let split = sequence.train_frame_count.clamp(start, end + 1);
    let is_split = split > start + 1 && split <= end;
    let spread = |from: usize, to: usize, n: usize| {
        (1..=n).map(move |i| from + ((to - from) * i) / n).collect::<Vec<_>>()
    };
    let mut frames = if is_split && columns >= 2 {
        let future = columns.div_ceil(2);
        let mut frames = spread(start, split - 1, columns - future);
        frames.extend(spread(split - 1, end, future));
        frames
    } else {
        spread(start, end, columns)
    };
    frames.dedup();
    frames
}

fn observed(sequence: &bendtwin_core::Sequence, frame: usize) -> impl Iterator<Item = Point> + '_ {
    let pairs = sequence.points_at(frame).iter().zip(sequence.visible_at(frame));
    pairs.filter(|(p, seen)| **seen && crate::distance::is_finite(p)).map(|(p, _)| *p)
}

#[cfg(test)]
mod tests;
