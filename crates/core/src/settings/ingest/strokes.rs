//! Strokes: what a person marks in the images of a recording, from which masks are made.

use serde::{Deserialize, Serialize};

/// Most strokes of a recording.
const MAX_STROKES: usize = 1_000;
/// Most points of a stroke.
const MAX_POINTS: usize = 4_096;
/// Largest radius of a brush [px].
const MAX_RADIUS_PX: f64 = 200.0;
/// Larger than any column or row of an image.
const MAX_COORDINATE: f64 = 65_536.0;

/// Stage of an ingest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Masks, to be looked at and corrected; there is no observation then.
    Masks,
    /// Tracked points, which fits work on.
    #[default]
    Points,
}

/// Part of a scene that a stroke marks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Part {
    /// The soft object.
    Object,
    /// A hand or gripper.
    Hand,
    /// Neither: the table, or what was taken for object or hand by mistake.
    Background,
}

/// Stroke of a brush in one image. A click is a stroke with one point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stroke {
    /// The part that is there.
    pub part: Part,
    /// Index of the camera.
    pub camera: u32,
    /// Frame of the image.
    #[serde(default)]
    pub frame: u32,
    /// Pixels as x (column), y (row); the centre of the first pixel is (0, 0). At least one.
    pub points: Vec<[f64; 2]>,
    /// Radius of the brush [px].
    #[serde(default = "default_radius")]
    pub radius_px: f64,
}

fn default_radius() -> f64 {
    4.0
}

impl Stroke {
    /// A click in frame 0.
    pub fn click(part: Part, camera: u32, x: f64, y: f64) -> Self {
        Self { part, camera, frame: 0, points: vec![[x, y]], radius_px: default_radius() }
    }
}

/// Adds the faults of strokes.
pub(super) fn add_faults(strokes: &[Stroke], faults: &mut Vec<String>) {
    if strokes.len() > MAX_STROKES {
        faults.push(format!("strokes has {}: at most {MAX_STROKES}", strokes.len()));
        return;
    }
    for (index, stroke) in strokes.iter().enumerate() {
        let name = format!("strokes[{index}]");
        if stroke.points.is_empty() || stroke.points.len() > MAX_POINTS {
            let count = stroke.points.len();
            faults.push(format!("{name}.points has {count}: it must have 1 to {MAX_POINTS}"));
        }
        let inside = |x: &f64| (0.0..=MAX_COORDINATE).contains(x);
        if let Some(point) = stroke.points.iter().find(|point| !point.iter().all(inside)) {
            faults.push(format!("{name}.points has {point:?}, which no image has"));
        }
        if !(0.5..=MAX_RADIUS_PX).contains(&stroke.radius_px) {
            let radius = stroke.radius_px;
            faults.push(format!(
                "{name}.radius_px is {radius}: it must lie in 0.5..={MAX_RADIUS_PX}"
            ));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(strokes: &[Stroke]) -> Vec<String> {
        let mut faults = Vec::new();
        add_faults(strokes, &mut faults);
        faults
    }

    #[test]
    fn a_click_is_a_stroke_and_short_in_json() {
        let click = Stroke::click(Part::Hand, 1, 120.0, 88.0);
        assert!(faults(std::slice::from_ref(&click)).is_empty());
        let short = r#"{"part": "hand", "camera": 1, "points": [[120, 88]]}"#;
        assert_eq!(serde_json::from_str::<Stroke>(short).unwrap(), click);
    }

    #[test]
    fn impossible_strokes_are_refused() {
        let click = Stroke::click(Part::Object, 0, 1.0, 1.0);
        let none = Stroke { points: Vec::new(), ..click };
        let outside = Stroke { points: vec![[-1.0, 0.0], [f64::NAN, 0.0]], ..click };
        let wide = Stroke { radius_px: f64::INFINITY, ..click.clone() };
        assert_eq!(faults(&[none, outside, wide]).len(), 3);
        assert_eq!(faults(&vec![click; MAX_STROKES + 1]).len(), 1);
    }
}
