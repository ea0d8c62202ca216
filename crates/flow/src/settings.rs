//! Settings of the tracker.

use serde::{Deserialize, Serialize};

/// Settings of the built-in tracker. Pixels are those of the full image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FlowSettings {
    /// Most points seeded on the object in each camera.
    pub max_object_points: usize,
    /// Most points seeded on the manipulator in each camera.
    pub max_manipulator_points: usize,
    /// Smallest distance between seeds [px]; larger where the maximum would be exceeded.
    pub min_distance_px: f64,
    /// Side of the square patch that is matched [px], odd.
    pub window_px: usize,
    /// Levels of the image pyramid; motions up to about `window_px · 2^(levels - 2)` between frames
    /// are found.
    pub levels: usize,
    /// Standard deviation of the blur before anything else [px]: hides pixel noise and aliasing.
    pub smoothing_px: f64,
    /// Least root mean square of the gradient in its weakest direction for a seed [grey levels of
    /// 255 per px].
    pub min_texture: f64,
    /// Largest distance of a point from its start, tracked there and back [px].
    pub max_forward_backward_px: f64,
    /// Least correlation between a point's patch and the image.
    pub min_correlation: f64,
    /// Number of neighbours by which the motion of a point's surroundings is known.
    pub neighbours: usize,
    /// Distance within which they are sought at first [m].
    pub neighbour_radius_m: f64,
    /// Largest distance of a point from where its neighbours' rigid motion puts it [m].
    pub max_deviation_m: f64,
    /// A step in depth that separates two surfaces [m].
    pub depth_jump_m: f64,
    /// True if points must agree with the masks and depth of the other cameras.
    pub multi_view: bool,
    /// Largest distance of a point in front of another camera's depth [m].
    pub multi_view_tolerance_m: f64,
}

impl Default for FlowSettings {
    fn default() -> Self {
        Self {
            max_object_points: 600,
            max_manipulator_points: 150,
            min_distance_px: 3.0,
            window_px: 15,
            levels: 4,
            smoothing_px: 0.8,
            min_texture: 1.5,
            max_forward_backward_px: 1.0,
            min_correlation: 0.8,
            neighbours: 16,
            neighbour_radius_m: 0.04,
            max_deviation_m: 0.008,
            depth_jump_m: 0.02,
            multi_view: true,
            multi_view_tolerance_m: 0.015,
        }
    }
}

impl FlowSettings {
    /// All faults together, in words.
    ///
    /// # Errors
    /// One text for each setting that is out of range.
    pub fn validate(&self) -> Result<(), Vec<String>> {
        let mut faults = Vec::new();
        let mut number = |name: &str, value: f64, low: f64, high: f64| {
            if !(low..=high).contains(&value) {
                faults.push(format!("{name} is {value}, it must lie in {low}..={high}"));
            }
        };
        number("max_object_points", self.max_object_points as f64, 1.0, 100_000.0);
        number("max_manipulator_points", self.max_manipulator_points as f64, 0.0, 100_000.0);
        number("min_distance_px", self.min_distance_px, 1.0, 1000.0);
        number("window_px", self.window_px as f64, 5.0, 101.0);
        number("levels", self.levels as f64, 1.0, 8.0);
        number("smoothing_px", self.smoothing_px, 0.0, 10.0);
        number("min_texture", self.min_texture, 0.0, 255.0);
        number("max_forward_backward_px", self.max_forward_backward_px, 0.01, 100.0);
        number("min_correlation", self.min_correlation, 0.0, 1.0);
        number("neighbours", self.neighbours as f64, 4.0, 256.0);
        number("neighbour_radius_m", self.neighbour_radius_m, 1e-4, 10.0);
        number("max_deviation_m", self.max_deviation_m, 1e-4, 10.0);
        number("depth_jump_m", self.depth_jump_m, 1e-4, 10.0);
        number("multi_view_tolerance_m", self.multi_view_tolerance_m, 1e-4, 10.0);
        if self.window_px.is_multiple_of(2) {
            faults.push(format!("window_px is {}, it must be odd", self.window_px));
        }
        if faults.is_empty() { Ok(()) } else { Err(faults) }
    }
}
