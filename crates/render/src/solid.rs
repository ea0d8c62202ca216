//! Rigid shapes, found ray by ray: their outlines and depths are exact.

use bendtwin_core::{
    Point,
    geometry::{Vector, add, dot, length, scaled, sub, wide},
};

use crate::{
    light::Light,
    picture::{NEAR_M, View},
    raster::{Raster, SAMPLES, Window},
};

/// Distance of a face from the camera below which it counts as passing through it [m].
const LEAST_M: f64 = 1e-6;

/// A rigid shape, in its own coordinates.
#[derive(Clone, Debug)]
pub enum Solid {
    /// All within a radius of a line from one point to another [m]; a ball if they are the same.
    Round {
        /// An end of the line.
        from: Point,
        /// The other end.
        to: Point,
        /// Radius [m].
        radius_m: f32,
    },
    /// All below each of some faces, within a box [m].
    Convex {
        /// The faces.
        faces: Vec<Face>,
        /// Lowest and highest corner of a box around it.
        bounds: [Point; 2],
    },
}

/// A half space: all points below a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Unit normal, which points out.
    pub normal: Point,
    /// Place of the plane along the normal [m].
    pub offset_m: f32,
}

/// A rigid motion from a shape's coordinates to the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Rotation, row-major, shape [3, 3].
    pub rotation: [Vector; 3],
    /// Place of the shape's origin [m].
    pub position: Vector,
}

/// A rigid thing in a picture.
#[derive(Clone, Debug)]
pub struct Prop<'a> {
    /// Shape.
    pub solid: &'a Solid,
    /// Pose in the world.
    pub pose: Pose,
    /// Colour (sRGB).
    pub color: [u8; 3],
}

impl Default for Pose {
    fn default() -> Self {
        let rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Self { rotation, position: [0.0; 3] }
    }
}

impl Pose {
    /// From x, y, z [m] and a quaternion x, y, z, w of any length above 0.
    pub fn new([x, y, z, qx, qy, qz, qw]: [f32; 7]) -> Self {
        let q = [qx, qy, qz, qw].map(f64::from);
        let square: f64 = q.iter().map(|x| x * x).sum();
        let s = 2.0 / square.max(f64::MIN_POSITIVE);
        let [i, j, k, r] = q;
        let rotation = [
            [1.0 - s * (j * j + k * k), s * (i * j - k * r), s * (i * k + j * r)],
            [s * (i * j + k * r), 1.0 - s * (i * i + k * k), s * (j * k - i * r)],
            [s * (i * k - j * r), s * (j * k + i * r), 1.0 - s * (i * i + j * j)],
        ];
        Self { rotation, position: [x, y, z].map(f64::from) }
    }

    /// A direction in the world.
    fn turned(&self, direction: Vector) -> Vector {
        self.rotation.map(|row| dot(row, direction))
    }

    /// A point in the world.
    fn placed(&self, point: Point) -> Vector {
        add(self.turned(wide(point)), self.position)
    }

    /// The motion from the world to this pose's coordinates, as a camera's, row-major, shape [3, 4].
    pub fn world_to_camera(&self) -> [[f32; 4]; 3] {
        let column = |a: usize| [0, 1, 2].map(|b: usize| self.rotation[b][a]);
        [0, 1, 2].map(|a| {
            let axis = column(a);
            let [x, y, z] = axis;
            [x, y, z, -dot(axis, self.position)].map(|x| x as f32)
        })
    }
}

impl Solid {
    /// Draws the part in a band, with a colour as light.
    pub(crate) fn draw(
        &self,
        pose: &Pose,
        color: [f32; 3],
        light: &Light,
        view: &View,
        raster: &mut Raster,
        label: u8,
    ) {
        match self {
            Self::Round { from, to, radius_m } => {
                let ends = [from, to].map(|end| view.seen_wide(pose.placed(*end)));
                let round = Round::new(ends, f64::from(*radius_m));
                let Some(window) = round.window(view, raster) else { return };
                raster.fill(window, label, |x, y| {
                    let (depth, normal) = round.met(view.ray(x, y))?;
                    let normal = view.in_world(normal).map(|x| x as f32);
                    Some(((1.0 / depth) as f32, scaled(color, light.on(normal))))
                });
            }
            Self::Convex { faces, bounds } => {
                let Some(window) = convex_window(*bounds, pose, view, raster) else { return };
                let Some(sides) = Sides::new(faces, pose, color, light, view) else { return };
                raster.fill(window, label, |x, y| sides.met(x as f32, y as f32));
            }
        }
    }
}

/// A capsule or a ball, in the axes of the camera.
struct Round {
    ends: [Vector; 2],
    radius_m: f64,
    axis: Vector,
    /// Square of the length of the axis [m²].
    square: f64,
}

impl Round {
    fn new(ends: [Vector; 2], radius_m: f64) -> Self {
        let axis = sub(ends[1], ends[0]);
        Self { ends, radius_m, axis, square: dot(axis, axis) }
    }

    /// The nearest point of the axis.
    fn nearest(&self, point: Vector) -> Vector {
        let share = dot(sub(point, self.ends[0]), self.axis) / self.square.max(f64::MIN_POSITIVE);
        add(self.ends[0], scaled(self.axis, share.clamp(0.0, 1.0)))
    }

    /// Where it may be in a band; `None` if nothing of it is seen, or the camera is inside.
    fn window(&self, view: &View, raster: &Raster) -> Option<Window> {
        if length(self.nearest([0.0; 3])) <= self.radius_m {
            return None;
        }
        let near = f64::from(NEAR_M);
        if self.ends.iter().all(|end| end[2] + self.radius_m < near) {
            return None;
        }
        if self.ends.iter().any(|end| end[2] - self.radius_m < near) {
            return Some(raster.window());
        }
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for end in &self.ends {
            for axis in 0..2 {
                // The lines through the camera that touch the ball, in the plane of this axis and the depth.
                let (x, z) = (end[axis], end[2]);
                let square = self.radius_m * self.radius_m;
                let reach = self.radius_m * (x * x + z * z - square).max(0.0).sqrt();
                for slope in [x * z - reach, x * z + reach].map(|s| s / (z * z - square)) {
                    low[axis] = low[axis].min(slope);
                    high[axis] = high[axis].max(slope);
                }
            }
        }
        Some(raster.between(view.columns([low[0], high[0]]), view.rows([low[1], high[1]])))
    }

    /// Depth [m] and normal where a ray with the depth 1 first meets it.
    fn met(&self, ray: Vector) -> Option<(f64, Vector)> {
        // The entry into a union of convex parts that is convex is the first of their entries.
        let [a, b] = self.ends;
        let balls = [self.ball(a, ray), if self.square > 0.0 { self.ball(b, ray) } else { None }];
        let entries = balls.into_iter().chain([self.cylinder(ray)]).flatten();
        let depth = entries.reduce(f64::min).filter(|depth| *depth >= f64::from(NEAR_M))?;
        let point = scaled(ray, depth);
        let normal = scaled(sub(point, self.nearest(point)), 1.0 / self.radius_m);
        Some((depth, normal))
    }

    fn ball(&self, center: Vector, ray: Vector) -> Option<f64> {
        let (a, b) = (dot(ray, ray), dot(ray, center));
        let c = dot(center, center) - self.radius_m * self.radius_m;
        let square = b * b - a * c;
        (square >= 0.0).then(|| (b - square.sqrt()) / a)
    }

    /// Where a ray enters the cylinder around the axis, between its ends.
    fn cylinder(&self, ray: Vector) -> Option<f64> {
        let (along, start) = (dot(self.axis, ray), dot(self.axis, self.ends[0]));
        let a = self.square * dot(ray, ray) - along * along;
        let b = self.square * dot(ray, self.ends[0]) - start * along;
        let c = self.square * dot(self.ends[0], self.ends[0])
            - start * start
            - self.square * self.radius_m * self.radius_m;
        let square = b * b - a * c;
        // A ray along the axis enters at an end.
        if square < 0.0 || a <= 1e-12 * self.square * dot(ray, ray) {
            return None;
        }
        let depth = (b - square.sqrt()) / a;
        (0.0..=self.square).contains(&(depth * along - start)).then_some(depth)
    }
}

/// Where a box may be in a band; `None` if it is behind the camera.
fn convex_window(
    [low, high]: [Point; 2],
    pose: &Pose,
    view: &View,
    raster: &Raster,
) -> Option<Window> {
    let corner = |k: usize| {
        let axis = |a: usize| if k >> a & 1 == 0 { low[a] } else { high[a] };
        view.seen_wide(pose.placed([axis(0), axis(1), axis(2)]))
    };
    let corners: [Vector; 8] = std::array::from_fn(corner);
    let near = f64::from(NEAR_M);
    if corners.iter().all(|at| at[2] < near) {
        return None;
    }
    if corners.iter().any(|at| at[2] < near) {
        return Some(raster.window());
    }
    let ends = |axis: usize| {
        let slopes = corners.iter().map(|at| at[axis] / at[2]);
        slopes.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], x| [l.min(x), h.max(x)])
    };
    Some(raster.between(view.columns(ends(0)), view.rows(ends(1))))
}

/// The faces of a convex shape as a camera sees them. Along a ray, the inverse depth at which a plane is met is
/// linear in the picture. The shape is entered at the last of the planes that face the camera, which is the least
/// inverse depth, unless it has been left before through one of the others.
struct Sides {
    /// Inverse depth [1/m] at the first sample, and its steps by column and row, with the light of the face.
    front: Vec<([f32; 3], [f32; 3])>,
    back: Vec<[f32; 3]>,
}

impl Sides {
    /// `None` if the camera is inside.
    fn new(
        faces: &[Face],
        pose: &Pose,
        color: [f32; 3],
        light: &Light,
        view: &View,
    ) -> Option<Self> {
        let (mut front, mut back) = (Vec::new(), Vec::new());
        for face in faces {
            let normal = pose.turned(wide(face.normal));
            let offset = f64::from(face.offset_m) + dot(normal, pose.position);
            let (seen, offset) = view.plane(normal, offset);
            let is_front = offset < 0.0;
            let offset = offset.abs().max(LEAST_M).copysign(offset);
            let inverse = view.linear(scaled(seen, 1.0 / offset)).map(|x| x as f32);
            if is_front {
                let lit = scaled(color, light.on(normal.map(|x| x as f32)));
                front.push((inverse, lit));
            } else {
                back.push(inverse);
            }
        }
        (!front.is_empty()).then_some(Self { front, back })
    }

    /// Inverse depth and light at a sample.
    fn met(&self, x: f32, y: f32) -> Option<(f32, [f32; 3])> {
        let at = |[first, by_x, by_y]: &[f32; 3]| first + by_x * x + by_y * y;
        let (mut entry, mut light) = (f32::INFINITY, [0.0; 3]);
        for (inverse, lit) in &self.front {
            let inverse = at(inverse);
            if inverse < entry {
                (entry, light) = (inverse, *lit);
            }
        }
        let is_seen = entry > 0.0 && entry <= 1.0 / NEAR_M;
        (is_seen && self.back.iter().all(|inverse| at(inverse) <= entry)).then_some((entry, light))
    }
}

impl View {
    /// The ray through a sample, with the depth 1, in the axes of the camera.
    fn ray(&self, x: usize, y: usize) -> Vector {
        [self.left + self.step[0] * x as f64, self.top + self.step[1] * y as f64, 1.0]
    }

    /// A quantity n · ray as a function of column and row: its value at the first sample, and its steps.
    fn linear(&self, n: Vector) -> Vector {
        [n[0] * self.left + n[1] * self.top + n[2], n[0] * self.step[0], n[1] * self.step[1]]
    }

    /// Places in the picture [samples] of slopes x / z.
    fn columns(&self, slopes: [f64; 2]) -> [f32; 2] {
        slopes.map(|slope| ((slope - self.left) / self.step[0] + 0.5) as f32)
    }

    fn rows(&self, slopes: [f64; 2]) -> [f32; 2] {
        slopes.map(|slope| ((slope - self.top) / self.step[1] + 0.5) as f32)
    }
}

const _: () = assert!(SAMPLES == 2, "the view places two samples along each side of a pixel");
