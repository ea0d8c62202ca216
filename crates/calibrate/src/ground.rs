//! The ground: the largest plane in the depth of all cameras, without what masks show.
//!
//! Planes through three points are tried at random with a fixed seed (Fischler and Bolles, *Random
//! sample consensus*, 1981); the best is fitted to the points near it.

mod points;

use bendtwin_capture::raw::{Calibration, Recording};
use bendtwin_core::{
    CancelToken, Point,
    geometry::{Vector, add, cross, dot, scaled, sub, turn, unit, wide},
};
use nalgebra::{Matrix3, Vector3};

use crate::{Error, error::check, statistics::median};

/// Planes that are tried.
const TRIALS: usize = 600;
/// Points by which planes are compared; all fit the best one.
const COMPARED: usize = 6_000;
/// Least share of points on a ground that is offered.
const MIN_SHARE: f64 = 0.15;
/// Share of points on a plane from which on it is surely what things lie on.
pub(crate) const LARGE_SHARE: f64 = 0.3;
/// Distance of a point that belongs to a plane, at a metre from its camera [m].
const NEAR_M: f64 = 0.008;
/// Cosine between the plane's normal and a camera's upward axis below which the plane looks like a
/// wall.
const WALL: f64 = 0.2;

/// A plane that things lie on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Unit normal in the recording's world, towards the cameras.
    pub normal: Point,
    /// Distance from the origin along the normal [m].
    pub offset_m: f32,
    /// Share of the points outside the masks that lie on it, 0..=1.
    pub share: f64,
    /// Middle of the points on it [m].
    pub center: Point,
}

/// A point that a camera measured.
#[derive(Clone, Copy, Debug)]
struct Measured {
    at: Vector,
    /// Distance within which it lies on a plane [m].
    near_m: f64,
}

/// The largest plane outside the masks; `None` if no plane has enough of what is seen, or there is
/// no depth.
///
/// # Errors
/// If a frame cannot be read for a reason other than damage, or on cancellation.
pub fn detect(recording: &Recording, cancel: &CancelToken) -> Result<Option<Ground>, Error> {
    let placed = recording.cameras.iter().all(|camera| !camera.poses.is_empty());
    // One camera is its own world.
    if !placed && recording.cameras.len() > 1 {
        return Ok(None);
    }
    let points = points::measured(recording, cancel)?;
    check(cancel)?;
    Ok(largest(recording, &points))
}

/// A calibration with the poses and the ground of another one of the same cameras in the same order: its
/// own lenses, errors and source stay.
pub fn with_poses(mut calibration: Calibration, other: &Calibration) -> Calibration {
    for (camera, other) in calibration.cameras.iter_mut().zip(&other.cameras) {
        camera.pose = other.pose;
    }
    calibration.ground = other.ground;
    calibration
}

/// The recording's calibration in the world in which this ground is z = 0; `centred` puts the origin
/// into the middle of the ground that is seen.
pub fn level(recording: &Recording, ground: &Ground, centred: bool) -> Calibration {
    let normal = wide(ground.normal);
    let rotation = upright(normal);
    let middle = turn(&rotation, wide(ground.center));
    let shift = if centred { [-middle[0], -middle[1]] } else { [0.0; 2] };
    let moved = bendtwin_capture::raw::Pose {
        rotation,
        translation: [shift[0], shift[1], -f64::from(ground.offset_m)],
    };
    let mut calibration = Calibration::of(recording, "ground");
    for camera in &mut calibration.cameras {
        let pose = camera.pose.unwrap_or(bendtwin_capture::raw::Pose::IDENTITY);
        camera.pose = Some(moved.after(&pose));
    }
    calibration.ground = bendtwin_core::Environment::Z_UP.ground;
    calibration
}

/// The rotation that turns a unit vector to z by the shortest way.
fn upright(normal: Vector) -> [[f64; 3]; 3] {
    let [x, y, z] = normal;
    if z < -0.999_999 {
        return [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
    }
    let k = 1.0 / (1.0 + z);
    [[1.0 - x * x * k, -x * y * k, -x], [-x * y * k, 1.0 - y * y * k, -y], [x, y, z]]
}

fn largest(recording: &Recording, points: &[Measured]) -> Option<Ground> {
    if points.len() < 100 {
        return None;
    }
    let step = points.len().div_ceil(COMPARED);
    let compared: Vec<Measured> = points.iter().step_by(step).copied().collect();
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let mut best: Option<(f64, Vector, f64)> = None;
    for _ in 0..TRIALS {
        let [a, b, c] = [0; 3].map(|_| compared[random.below(compared.len())].at);
        let Some(normal) = unit(cross(sub(b, a), sub(c, a))) else { continue };
        let normal = towards_cameras(recording, normal, dot(normal, a));
        let offset = dot(normal, a);
        let on = count(&compared, normal, offset) as f64 * plausibility(recording, normal);
        if best.is_none_or(|(most, _, _)| on > most) {
            best = Some((on, normal, offset));
        }
    }
    let (_, mut normal, mut offset) = best?;
    let mut center = [0.0; 3];
    for _ in 0..5 {
        let on: Vec<Vector> =
            points.iter().filter(|p| p.is_on(normal, offset)).map(|p| p.at).collect();
        let (fitted, middle) = fit(&on)?;
        normal = towards_cameras(recording, fitted, dot(fitted, middle));
        (offset, center) = (dot(normal, middle), middle);
    }
    let share = count(points, normal, offset) as f64 / points.len() as f64;
    if share < MIN_SHARE || plausibility(recording, normal) < 1.0 {
        return None;
    }
    let narrow = |v: Vector| v.map(|x| x as f32);
    let ground =
        Ground { normal: narrow(normal), offset_m: offset as f32, share, center: narrow(center) };
    Some(ground)
}

impl Measured {
    fn is_on(&self, normal: Vector, offset: f64) -> bool {
        (dot(normal, self.at) - offset).abs() < self.near_m
    }
}

fn count(points: &[Measured], normal: Vector, offset: f64) -> usize {
    points.iter().filter(|p| p.is_on(normal, offset)).count()
}

/// The normal on whose side most cameras stand.
fn towards_cameras(recording: &Recording, normal: Vector, offset: f64) -> Vector {
    let above =
        recording.cameras.iter().filter(|camera| dot(normal, camera.pose(0).translation) > offset);
    if 2 * above.count() >= recording.cameras.len() { normal } else { scaled(normal, -1.0) }
}

/// 1 for what may be a table, less for a wall: cameras stand upright or on their heads, or look
/// straight down.
fn plausibility(recording: &Recording, normal: Vector) -> f64 {
    let along = |axis: usize| {
        let own = recording
            .cameras
            .iter()
            .map(|camera| dot(normal, camera.pose(0).rotation.map(|row| row[axis])).abs());
        median(own).unwrap_or_default()
    };
    let sideways = along(0);
    if along(1) > WALL || along(2) > 0.9 && sideways < WALL { 1.0 } else { 0.3 }
}

/// The plane of least squares: its normal and the middle of the points.
fn fit(points: &[Vector]) -> Option<(Vector, Vector)> {
    if points.len() < 3 {
        return None;
    }
    let sum = points.iter().fold([0.0; 3], |sum, p| add(sum, *p));
    let middle = scaled(sum, 1.0 / points.len() as f64);
    let mut spread = Matrix3::zeros();
    for p in points {
        let d = Vector3::from(sub(*p, middle));
        spread += d * d.transpose();
    }
    let eigen = spread.symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    let normal: Vector = eigen.eigenvectors.column(least).into_owned().into();
    Some((unit(normal)?, middle))
}

/// Xorshift of Marsaglia (2003): the same planes are tried every time.
struct Random(u64);

impl Random {
    fn below(&mut self, count: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % count.max(1) as u64) as usize
    }
}

#[cfg(test)]
mod tests;
