//! Vectors of space, in single and in double precision.

use std::{
    cmp::Ordering,
    ops::{Add, Mul, Sub},
};

use nalgebra::Vector3;

use crate::Point;

/// A vector in double precision.
pub type Vector = [f64; 3];

/// A real number: f32 or f64.
pub trait Scalar:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + 'static
{
    /// Square root.
    fn sqrt(self) -> Self;
    /// Total order, NaN last.
    fn total_cmp(&self, other: &Self) -> Ordering;
}

impl Scalar for f32 {
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    fn total_cmp(&self, other: &Self) -> Ordering {
        self.total_cmp(other)
    }
}

impl Scalar for f64 {
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    fn total_cmp(&self, other: &Self) -> Ordering {
        self.total_cmp(other)
    }
}

/// `a + b`.
#[inline]
pub fn add<T: Scalar>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `a - b`.
#[inline]
pub fn sub<T: Scalar>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a · by`, for a number `by`.
#[inline]
pub fn scaled<T: Scalar>(a: [T; 3], by: T) -> [T; 3] {
    a.map(|x| x * by)
}

/// Dot product.
#[inline]
pub fn dot<T: Scalar>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Cross product.
#[inline]
pub fn cross<T: Scalar>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Euclidean length.
#[inline]
pub fn length<T: Scalar>(a: [T; 3]) -> T {
    dot(a, a).sqrt()
}

/// Euclidean distance.
#[inline]
pub fn distance<T: Scalar>(a: [T; 3], b: [T; 3]) -> T {
    length(sub(a, b))
}

/// Euclidean distance of two points, computed in double precision.
#[inline]
pub fn point_distance(a: Point, b: Point) -> f64 {
    distance(wide(a), wide(b))
}

/// A vector of length 1; `None` for one without direction.
#[inline]
pub fn unit(a: Vector) -> Option<Vector> {
    let n = length(a);
    (n.is_finite() && n > 1e-12).then(|| scaled(a, 1.0 / n))
}

/// Lowest and highest coordinates of points; `None` without points.
pub fn bounds(points: &[Point]) -> Option<[Point; 2]> {
    let first = *points.first()?;
    Some(points.iter().fold([first; 2], |[low, high], p| {
        [std::array::from_fn(|a| low[a].min(p[a])), std::array::from_fn(|a| high[a].max(p[a]))]
    }))
}

/// A point in double precision.
#[inline]
pub fn wide(p: Point) -> Vector {
    p.map(f64::from)
}

/// A point as a column in double precision.
#[inline]
pub fn vector3(p: Point) -> Vector3<f64> {
    Vector3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]))
}

/// A column as a point, rounded to single precision.
#[inline]
pub fn point(v: Vector3<f64>) -> Point {
    [v.x as f32, v.y as f32, v.z as f32]
}

/// `rotation · p`, for a row-major matrix.
#[inline]
pub fn turn(rotation: &[[f64; 3]; 3], p: Vector) -> Vector {
    std::array::from_fn(|i| dot(rotation[i], p))
}

/// `rotationᵀ · p`, for a row-major matrix.
#[inline]
pub fn turn_back(rotation: &[[f64; 3]; 3], p: Vector) -> Vector {
    std::array::from_fn(|j| (0..3).map(|i| rotation[i][j] * p[i]).sum())
}
