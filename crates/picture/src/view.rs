//! An orthographic view that shows most: the object's widest horizontal direction lies across, up
//! stays up, seen slightly from above. Without gravity, the principal axes decide alone.

use bendtwin_core::{
    Point,
    geometry::{cross, dot},
};

use crate::Rect;

/// Elevation of the viewer above the horizon [rad].
const ELEVATION: f32 = 0.3;
/// Free space around the points, as a share of the larger extent.
const BORDER: f32 = 0.08;

type Vector = [f32; 3];

/// An orthographic projection of points in space onto a panel.
#[derive(Clone, Debug)]
pub struct View {
    right: Vector,
    up: Vector,
    /// Middle of the points on the view plane, and their half extents [m].
    centre: [f32; 2],
    half: [f32; 2],
}

impl View {
    /// A view of all the points; `None` without points.
    pub fn of(points: Vec<Point>, gravity: Point) -> Option<Self> {
        Self::from_side(points, gravity, None)
    }

    /// [`View::of`] from the side of `eye`, if there is an up direction.
    pub fn from_side(points: Vec<Point>, gravity: Point, eye: Option<Point>) -> Option<Self> {
        let (mean, spread) = mean_and_spread(&points);
        let (right, up) = match unit(gravity.map(|g| -g)) {
            Some(up) => {
                let mut right = widest(&spread, &[up]);
                let to_eye = eye.map(|e| std::array::from_fn(|a| e[a] - mean[a]));
                if to_eye.is_some_and(|to_eye: Vector| dot(to_eye, cross(right, up)) < 0.0) {
                    right = right.map(|x| -x);
                }
                // The viewer looks along `depth`; raising it tilts what is seen as up.
                let depth = cross(up, right);
                let tilted: Vector =
                    std::array::from_fn(|a| up[a] * ELEVATION.cos() + depth[a] * ELEVATION.sin());
                (right, tilted)
            }
            None => {
                let right = widest(&spread, &[]);
                (right, widest(&spread, &[right]))
            }
        };
        Self::along(&points, right, up)
    }

    /// A view of all the points from straight above, with the widest direction across; `None` if
    /// there are no points, or no up direction.
    pub fn from_above(points: &[Point], gravity: Point) -> Option<Self> {
        let up = unit(gravity.map(|g| -g))?;
        let right = widest(&mean_and_spread(points).1, &[up]);
        Self::along(points, right, cross(up, right))
    }

    fn along(points: &[Point], right: Vector, up: Vector) -> Option<Self> {
        let first = *points.first()?;
        let flat = |p: &Point| [dot(*p, right), dot(*p, up)];
        let (mut low, mut high) = (flat(&first), flat(&first));
        for p in points.iter().map(flat) {
            for a in 0..2 {
                low[a] = low[a].min(p[a]);
                high[a] = high[a].max(p[a]);
            }
        }
        let extent = (high[0] - low[0]).max(high[1] - low[1]).max(1e-3);
        let half = |a: usize| 0.5 * (high[a] - low[a]) + BORDER * extent;
        Some(Self {
            right,
            up,
            centre: [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])],
            half: [half(0), half(1)],
        })
    }

    /// Nearness of a point to the viewer [m]; larger is nearer.
    pub fn nearness(&self, p: Point) -> f32 {
        dot(p, cross(self.right, self.up))
    }

    /// Height over width.
    pub fn aspect(&self) -> f32 {
        self.half[1] / self.half[0]
    }

    /// The place of a point on a panel [px].
    pub fn place(&self, p: Point, panel: Rect) -> [f32; 2] {
        let scale = (0.5 * panel.width / self.half[0]).min(0.5 * panel.height / self.half[1]);
        let (x, y) = (dot(p, self.right) - self.centre[0], dot(p, self.up) - self.centre[1]);
        [panel.x + 0.5 * panel.width + scale * x, panel.y + 0.5 * panel.height - scale * y]
    }
}

/// Mean of points, and the sums of products of their differences from it.
fn mean_and_spread(points: &[Point]) -> (Point, [Vector; 3]) {
    let sum = points.iter().fold([0.0; 3], |s: Vector, p| std::array::from_fn(|a| s[a] + p[a]));
    let mean = sum.map(|x| x / points.len().max(1) as f32);
    let mut spread = [[0.0; 3]; 3];
    for p in points {
        let d: Vector = std::array::from_fn(|a| p[a] - mean[a]);
        for (row, x) in spread.iter_mut().zip(d) {
            row.iter_mut().zip(d).for_each(|(s, y)| *s += x * y);
        }
    }
    (mean, spread)
}

/// The direction of largest spread among those normal to `excluded`, by power iteration; its
/// largest component is positive, so that the view does not flip.
fn widest(spread: &[Vector; 3], excluded: &[Vector]) -> Vector {
    let project = |v: Vector| {
        excluded.iter().fold(v, |v, e| {
            let along = dot(v, *e);
            std::array::from_fn(|a| v[a] - along * e[a])
        })
    };
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(project);
    let usable = axes.into_iter().filter_map(unit);
    let score = |v: &Vector| dot(*v, spread.map(|row| dot(row, *v)));
    let Some(mut v) = usable.max_by(|a, b| score(a).total_cmp(&score(b))) else {
        return [1.0, 0.0, 0.0];
    };
    for _ in 0..100 {
        match unit(project(spread.map(|row| dot(row, v)))) {
            Some(next) => v = next,
            None => break,
        }
    }
    let largest = v.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(1.0);
    if largest < 0.0 { v.map(|x| -x) } else { v }
}

fn unit(v: Vector) -> Option<Vector> {
    let length = dot(v, v).sqrt();
    (length > 1e-12).then(|| v.map(|x| x / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn from_above_heights_are_not_seen_and_sides_are() {
        let points = [[-2.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let gravity = [0.0, 0.0, -9.81];
        let panel = Rect { x: 0.0, y: 0.0, width: 100.0, height: 100.0 };
        let view = View::from_above(&points, gravity).unwrap();
        let [low, high, beside] = [[0.0; 3], points[3], points[2]].map(|p| view.place(p, panel));
        assert_eq!(low, high);
        assert!(beside[1] < low[1] - 1.0, "{beside:?} is not above {low:?}");
        assert!(View::from_above(&points, [0.0; 3]).is_none());
        assert!(View::from_above(&[], gravity).is_none());
    }
}
