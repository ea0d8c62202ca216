//! The place from which an object is seen.

use bendtwin_core::{
    Point,
    geometry::{Vector, cross, dot, unit, wide},
};

/// Angle of the view above the ground [rad].
const ELEVATION: f64 = 0.45;
/// Directions that are tried around the vertical.
const DIRECTIONS: u32 = 8;
/// Share of the picture that the object fills.
const FILLED: f64 = 0.92;

/// A parallel projection that fills a picture with an object.
#[derive(Clone, Copy, Debug)]
pub(super) struct Camera {
    /// Axes of the picture: to the right, up, and towards the viewer.
    axes: [Vector; 3],
    /// Middle of the object along the first two axes [m].
    middle: [f64; 2],
    /// Pixels per metre.
    scale: f64,
    /// Middle of the picture [pixels].
    centre: [f64; 2],
}

impl Camera {
    /// The camera around points that shows them at their widest; `size` is that of the picture [pixels].
    pub(super) fn around(points: &[Point], size: [usize; 2]) -> Self {
        let directions = (0..DIRECTIONS).map(|k| {
            let azimuth = f64::from(k) * std::f64::consts::TAU / f64::from(DIRECTIONS);
            let axes = axes(azimuth);
            (extent(points, axes[0]), axes)
        });
        // Of directions that are equally good the first is taken.
        let widest = directions.reduce(|best, next| {
            let width = |[low, high]: [f64; 2]| high - low;
            if width(next.0) > width(best.0) * (1.0 + 1e-9) { next } else { best }
        });
        let (across, axes) = widest.unwrap_or(([0.0; 2], axes(0.0)));
        let up = extent(points, axes[1]);
        let size = size.map(|n| n as f64);
        let room = |[low, high]: [f64; 2], pixels: f64| FILLED * pixels / (high - low).max(1e-6);
        Self {
            axes,
            middle: [across, up].map(|[low, high]| (low + high) / 2.0),
            scale: room(across, size[0]).min(room(up, size[1])),
            centre: size.map(|n| n / 2.0),
        }
    }

    /// The place of a point in the picture, and its nearness, in the unit of places.
    pub(super) fn project(&self, point: &Point) -> ([f64; 2], f64) {
        let at = self.axes.map(|axis| dot(axis, wide(*point)));
        let x = self.centre[0] + self.scale * (at[0] - self.middle[0]);
        let y = self.centre[1] - self.scale * (at[1] - self.middle[1]);
        ([x, y], self.scale * at[2])
    }

    /// A direction of the world in the axes of the picture.
    pub(super) fn turned(&self, direction: Vector) -> Vector {
        self.axes.map(|axis| dot(axis, direction))
    }
}

/// Axes of the picture for a viewer at an angle around the vertical.
fn axes(azimuth: f64) -> [Vector; 3] {
    let (sin, cos) = azimuth.sin_cos();
    let towards = [ELEVATION.cos() * cos, ELEVATION.cos() * sin, ELEVATION.sin()];
    let right = unit([-sin, cos, 0.0]).unwrap_or([1.0, 0.0, 0.0]);
    [right, cross(towards, right), towards]
}

/// Least and greatest place of points along an axis [m].
fn extent(points: &[Point], axis: Vector) -> [f64; 2] {
    let places = points.iter().map(|point| dot(axis, wide(*point)));
    let ends = places
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)]);
    if ends[0] <= ends[1] { ends } else { [0.0; 2] }
}
