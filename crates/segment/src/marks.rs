//! Strokes as pixels of views: which pixels were marked, in which frame and camera, and what could not
//! be used.

use std::collections::{BTreeMap, BTreeSet};

use bendtwin_capture::raw::Recording;
use bendtwin_core::{Finding, settings::ingest::Stroke};

use crate::{
    part,
    view::{Lens, View, color_square},
};

/// Pixels that one stroke visits at most; beyond, only the middle of its brush counts.
const MOST_VISITS: usize = 2_000_000;
/// Pixels of a brush whose depth differs by more from that of its middle lie on something else [m].
const SAME_SURFACE_M: f32 = 0.01;
/// Largest difference of the colours of a brush's pixels from that of its middle, of 255.
const SAME_COLOR: f32 = 90.0;

/// What was marked in one image.
#[derive(Clone, Debug)]
pub(crate) struct Mark {
    pub(crate) part: usize,
    pub(crate) camera: usize,
    /// Middles of the brush: pixels of the view.
    pub(crate) middles: Vec<usize>,
    /// Radius of the brush in pixels of the view.
    radius: f64,
    /// Index of the stroke.
    stroke: usize,
}

/// Marks by their frames.
pub(crate) type Marks = BTreeMap<usize, Vec<Mark>>;

/// The marks that lie in images, and findings about strokes that do not.
pub(crate) fn place(
    recording: &Recording,
    lenses: &[Lens<'_>],
    strokes: &[Stroke],
) -> (Marks, Vec<Finding>) {
    let mut marks = Marks::new();
    let mut findings = Vec::new();
    for (index, stroke) in strokes.iter().enumerate() {
        let (camera, frame) = (stroke.camera as usize, stroke.frame as usize);
        let Some(lens) = lenses.get(camera).filter(|_| frame < recording.frame_count) else {
            let there = format!(
                "stroke {} marks camera {camera} in frame {frame}, but there are {} cameras and {} frames",
                index + 1,
                lenses.len(),
                recording.frame_count
            );
            findings.push(outside(there));
            continue;
        };
        let middles = middles(lens, stroke);
        if middles.is_empty() {
            let [width, height] = [lens.camera.width, lens.camera.height];
            let name = &lens.camera.name;
            let there = format!(
                "stroke {} lies outside of the {width} x {height} pixels of camera {name}",
                index + 1
            );
            findings.push(outside(there).cameras([camera]).frames([frame]));
            continue;
        }
        let radius = stroke.radius_px / lens.stride as f64;
        let part = part::index(stroke.part);
        marks.entry(frame).or_default().push(Mark { part, camera, middles, radius, stroke: index });
    }
    (marks, findings)
}

fn outside(message: String) -> Finding {
    let advice =
        "give pixels as column and row, counted from 0 (docs/use/cameras.md#masks)".to_owned();
    Finding { advice, ..Finding::warning("STROKE_OUTSIDE", message) }
}

/// Pixels along a stroke, each once: a long one that goes to and fro has no more of them than its image.
fn middles(lens: &Lens<'_>, stroke: &Stroke) -> Vec<usize> {
    let mut pixels = BTreeSet::new();
    let mut visit = |[x, y]: [f64; 2]| {
        let inside = |v: f64, size: usize| v.is_finite() && v >= -0.5 && v < size as f64 - 0.5;
        if inside(x, lens.camera.width) && inside(y, lens.camera.height) {
            let [column, row] = [x, y].map(|v| v.round().max(0.0) as usize / lens.stride);
            pixels.insert(row * lens.width + column);
        }
    };
    let step = stroke.radius_px.max(1.0);
    for (k, point) in stroke.points.iter().enumerate() {
        if let Some(before) = k.checked_sub(1).and_then(|k| stroke.points.get(k)) {
            let far = (point[0] - before[0]).hypot(point[1] - before[1]);
            let count = (far / step).clamp(1.0, 4096.0) as usize;
            for s in 1..count {
                let t = s as f64 / count as f64;
                visit([
                    before[0] + t * (point[0] - before[0]),
                    before[1] + t * (point[1] - before[1]),
                ]);
            }
        }
        visit(*point);
    }
    pixels.into_iter().collect()
}

impl Mark {
    /// Pixels under the brush that show the same surface as its middle, which counts always.
    pub(crate) fn pixels(&self, lens: &Lens<'_>, view: &View) -> Vec<usize> {
        let reach = self.radius.ceil().max(0.0) as usize;
        let mut pixels = self.middles.clone();
        let mut visits = 0;
        for middle in &self.middles {
            let (column, row) = (middle % lens.width, middle / lens.width);
            visits += (2 * reach + 1) * (2 * reach + 1);
            if visits > MOST_VISITS {
                break;
            }
            let (depth, color) = (view.depths[*middle], view.colors[*middle]);
            for y in row.saturating_sub(reach)..(row + reach + 1).min(lens.height) {
                for x in column.saturating_sub(reach)..(column + reach + 1).min(lens.width) {
                    let off = (x as f64 - column as f64).hypot(y as f64 - row as f64);
                    let at = y * lens.width + x;
                    let z = view.depths[at];
                    let is_same = (depth == 0.0 || z == 0.0 || (z - depth).abs() < SAME_SURFACE_M)
                        && color_square(view.colors[at], color) < SAME_COLOR * SAME_COLOR;
                    if off <= self.radius && is_same {
                        pixels.push(at);
                    }
                }
            }
        }
        pixels.sort_unstable();
        pixels.dedup();
        pixels
    }

    /// The finding about a mark without any measured depth.
    pub(crate) fn without_depth(&self, lens: &Lens<'_>, frame: usize) -> Finding {
        let message = format!(
            "stroke {} in camera {} meets no measured depth, so that the other cameras do not know where it lies",
            self.stroke + 1,
            lens.camera.name
        );
        let advice =
            "mark a place with depth, away from the rim (docs/use/cameras.md#masks)".to_owned();
        Finding { advice, ..Finding::warning("STROKE_WITHOUT_DEPTH", message) }
            .cameras([self.camera])
            .frames([frame])
    }
}
