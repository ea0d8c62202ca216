//! The timeline: gaps and faults of every camera as a band, and figures over frames as lines below
//! it.

use super::{
    chart::{Chart, Line},
    markup::escape,
};
use crate::{CameraReport, Inspection, thresholds::Thresholds};

/// Most cells of a band; longer recordings show the worst of several frames in one.
const MAX_CELLS: usize = 400;
/// Width of the drawing, and height of a band and of its row [units of the SVG].
const WIDTH: f64 = 1000.0;
const BAND: f64 = 16.0;
const ROW: f64 = 24.0;
/// Cameras with a band.
const MAX_BANDS: usize = 16;
/// Most lines of a chart.
const MAX_LINES: usize = 6;

pub(super) fn section(seen: &Inspection) -> String {
    let frames = seen.frame_count;
    if frames < 2 || (seen.cameras.is_empty() && seen.observed.is_none()) {
        return String::new();
    }
    let mut parts = bands(seen);
    for chart in charts(seen) {
        parts.push_str(&chart.draw(frames));
    }
    let split = seen.train_frame_count.min(frames);
    let until = if split < frames {
        format!(" Frames from {split} on are held back to see how well the twin predicts.")
    } else {
        String::new()
    };
    format!(
        "<section>\n<h2>Over time</h2>\n<p class=\"hint\">From frame 0 on the left to frame {} on the right.{until}</p>\n{parts}</section>\n",
        frames - 1
    )
}

/// State of a frame, from the best to the worst; a cell shows the worst of its frames.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum State {
    Fine,
    Late,
    Jump,
    Repeated,
    Empty,
    Missing,
}

impl State {
    /// The colour without the page's style, in a mail for example.
    fn color(self) -> &'static str {
        match self {
            Self::Fine => "#b9dccf",
            Self::Late => "#8a6d00",
            Self::Jump => "#0072b2",
            Self::Repeated => "#b26a00",
            Self::Empty => "#cc79a7",
            Self::Missing => "#c02f3a",
        }
    }

    fn class(self) -> &'static str {
        match self {
            Self::Fine => "fine",
            Self::Late => "late",
            Self::Jump => "jump",
            Self::Repeated => "repeated",
            Self::Empty => "empty",
            Self::Missing => "missing",
        }
    }
}

fn states(camera: &CameraReport, frames: usize) -> Vec<State> {
    let mut states = vec![State::Fine; frames];
    for (list, state) in [
        (&camera.late_frames, State::Late),
        (&camera.mask_jumps, State::Jump),
        (&camera.repeated_frames, State::Repeated),
        (&camera.empty_masks, State::Empty),
        (&camera.missing_frames, State::Missing),
    ] {
        for frame in list {
            if let Some(old) = states.get_mut(*frame) {
                *old = state.max(*old);
            }
        }
    }
    states
}

fn bands(seen: &Inspection) -> String {
    if seen.cameras.is_empty() {
        return String::new();
    }
    let frames = seen.frame_count;
    let per_cell = frames.div_ceil(MAX_CELLS).max(1);
    let cells = frames.div_ceil(per_cell);
    let cell = WIDTH / cells as f64;
    let mut used = [State::Late, State::Jump, State::Repeated, State::Empty, State::Missing]
        .map(|s| (s, false));
    let mut drawn = String::new();
    for (row, camera) in seen.cameras.iter().take(MAX_BANDS).enumerate() {
        let y = ROW * row as f64;
        drawn.push_str(&format!("<rect class=\"fine\" fill=\"{}\" x=\"0\" y=\"{y}\" width=\"{WIDTH}\" height=\"{BAND}\" rx=\"3\"/>", State::Fine.color()));
        for (i, part) in states(camera, frames).chunks(per_cell).enumerate() {
            let worst = part.iter().copied().max().unwrap_or(State::Fine);
            if worst != State::Fine {
                used.iter_mut().filter(|(s, _)| *s == worst).for_each(|u| u.1 = true);
                drawn.push_str(&format!(
                    "<rect class=\"{}\" fill=\"{}\" x=\"{:.1}\" y=\"{y}\" width=\"{:.1}\" height=\"{BAND}\"><title>camera {row}, frame {}: {}</title></rect>",
                    worst.class(),
                    worst.color(),
                    cell * i as f64,
                    cell.max(1.5),
                    i * per_cell,
                    worst.class()
                ));
            }
        }
    }
    let rows = seen.cameras.len().min(MAX_BANDS);
    let split = WIDTH * seen.train_frame_count.min(frames) as f64 / frames as f64;
    let height = ROW * rows as f64 - (ROW - BAND);
    drawn.push_str(&format!("<line class=\"split\" stroke=\"#1c2127\" stroke-dasharray=\"3 3\" x1=\"{split:.1}\" x2=\"{split:.1}\" y1=\"-3\" y2=\"{}\"/>", height + 3.0));
    let names: String = seen
        .cameras
        .iter()
        .take(MAX_BANDS)
        .enumerate()
        .map(|(i, c)| format!("<span>{i} {}</span>", escape(&c.name)))
        .collect();
    let keys: String = used
        .iter()
        .filter(|(_, used)| *used)
        .map(|(s, _)| format!("<span class=\"state {0}\">{0}</span>", s.class()))
        .collect();
    let keys = if keys.is_empty() {
        "<span class=\"hint\">no gap, no repeat, no jump</span>".to_owned()
    } else {
        keys
    };
    format!(
        "<figure class=\"bands\"><figcaption><b>Frames</b> {keys}</figcaption><div class=\"plot\"><div class=\"names\">{names}</div>\
         <svg viewBox=\"0 -4 {WIDTH} {}\" preserveAspectRatio=\"none\" style=\"height:{}px\" role=\"img\" aria-label=\"Frames of each camera\">{drawn}</svg></div></figure>\n",
        height + 8.0,
        height + 8.0
    )
}

fn charts(seen: &Inspection) -> Vec<Chart<'static>> {
    let percent = |v: f64| format!("{:.0} %", 100.0 * v);
    let number = |v: f64| format!("{v:.0}");
    let cameras = || seen.cameras.iter().take(MAX_LINES).enumerate();
    let name = |i: usize, c: &CameraReport| format!("{i} {}", c.name);
    let limits = Thresholds::default();
    let mut charts = Vec::new();
    let mut add = |title, hint, lines: Vec<Line>, top, label: fn(f64) -> String, limit| {
        let lines: Vec<Line> =
            lines.into_iter().filter(|l| l.values.iter().any(Option::is_some)).collect();
        charts.push(Chart { title, hint, lines, top, label, limit });
    };
    let lines = cameras().map(|(i, c)| Line { name: name(i, c), values: c.coverage.clone() });
    add(
        "Depth coverage",
        "share of the object's pixels with depth",
        lines.collect(),
        Some(1.0),
        percent,
        Some(limits.depth.good_coverage),
    );
    let area = |values: &[Option<usize>]| values.iter().map(|v| v.map(|n| n as f64)).collect();
    let lines = cameras().map(|(i, c)| Line { name: name(i, c), values: area(&c.object_px) });
    add("Area of the object", "pixels of its mask", lines.collect(), None, number, None);
    let lines = cameras().filter_map(|(i, c)| {
        let values = c.tracks.as_ref()?.liftable.iter().map(|n| Some(*n as f64)).collect();
        Some(Line { name: name(i, c), values })
    });
    add(
        "Tracks that can be lifted",
        "visible, on a mask, with depth",
        lines.collect(),
        None,
        number,
        None,
    );
    if let Some(observed) = &seen.observed {
        let line = |name: &str, values: &[usize]| Line {
            name: name.to_owned(),
            values: values.iter().map(|n| Some(*n as f64)).collect(),
        };
        let lines = vec![
            line("visible", &observed.visible),
            line("motion trusted", &observed.motion_valid),
        ];
        add(
            "Survival",
            "tracked points in space",
            lines,
            Some(observed.point_count as f64),
            number,
            None,
        );
    }
    let gaps = seen.scene.gap_m.iter().map(|g| g.map(|m| 1e3 * m)).collect();
    let lines = vec![Line { name: "nearest".to_owned(), values: gaps }];
    add(
        "Hand to object",
        "smallest distance",
        lines,
        None,
        |v| format!("{v:.0} mm"),
        Some(1e3 * limits.motion.max_gap_m),
    );
    charts
}
