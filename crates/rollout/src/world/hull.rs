//! The faces of the convex hull of points, by gift wrapping.
//!
//! A face that is known is a plane that all points lie on or below. Turned about one of its edges
//! until it meets the next point, it becomes the neighbouring face; all points in that plane belong
//! to it, and the convex polygon around them gives its edges in turn. Points in one plane are
//! therefore one face, for any triangulation of them, and the work is bounded by edges
//! times points. Tolerances are relative to the extent; points left out of a face because of
//! them are outside it by no more than that.

use std::collections::{HashSet, VecDeque};

use bendtwin_core::Point;
use bendtwin_engine::world::{Face, MAX_FACES};

/// Share of the extent within which points count as lying in a plane or on a line.
const TOLERANCE: f64 = 1e-5;
/// Share of the extent below which a hull is flat.
const FLAT: f64 = 1e-3;
/// Most planes that are looked at, faces or not.
const MOST_PLANES: usize = 8 * MAX_FACES;

type Vector = [f64; 3];

/// Reason why points have no hull that can be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum Fault {
    /// No volume.
    #[error("lie in one plane, on one line or in one point: a hull needs a volume")]
    Flat,
    /// More faces than a collider has.
    #[error(
        "have a hull of more than {MAX_FACES} faces: thin them out, or use several simpler colliders"
    )]
    TooManyFaces,
}

/// A plane that no point is above.
#[derive(Clone, Copy)]
struct Plane {
    normal: Vector,
    offset: f64,
}

/// Faces of the convex hull of points, in an order that depends on the points alone. The points lie
/// within each of them.
///
/// # Errors
/// If the points have no volume, or their hull too many faces.
pub(crate) fn hull(points: &[Point]) -> Result<Vec<Face>, Fault> {
    let points: Vec<Vector> = points.iter().map(|p| p.map(f64::from)).collect();
    let (origin, extent) = bounds(&points);
    // Relative to the middle, so that precision does not depend on where the shape is.
    let points: Vec<Vector> = points.iter().map(|p| sub(*p, origin)).collect();
    let near = TOLERANCE * extent;
    let first = first_face(&points, near).ok_or(Fault::Flat)?;
    let depth = points.iter().map(|p| first.offset - dot(first.normal, *p));
    if depth.fold(0.0, f64::max) <= FLAT * extent {
        return Err(Fault::Flat);
    }
    let mut faces = vec![first];
    let mut seen = HashSet::from([on(&points, &first, near)]);
    let mut open: VecDeque<Plane> = VecDeque::from([first]);
    while let Some(face) = open.pop_front() {
        for [a, b] in edges(&points, &face, near) {
            let out = unit(cross(sub(b, a), face.normal));
            let Some(next) = turned(&points, &face, a, out, near) else { continue };
            let holders = on(&points, &next, near);
            let is_part = |f: &Plane| holders.iter().all(|i| is_on(f, points[*i], near));
            // Where edges are short, the plane of a face that is known may be found again, tilted: it is no further
            // face, but what is beyond its edges is still to be found.
            let is_known = faces.iter().any(is_part);
            if !seen.insert(holders) {
                continue;
            }
            if !is_known {
                if faces.len() == MAX_FACES {
                    return Err(Fault::TooManyFaces);
                }
                faces.push(next);
            }
            if seen.len() > MOST_PLANES {
                return Err(Fault::TooManyFaces);
            }
            open.push_back(next);
        }
    }
    let face = |f: &Plane| Face {
        normal: f.normal.map(|x| x as f32),
        offset_m: (f.offset + dot(f.normal, origin)) as f32,
    };
    Ok(faces.iter().map(face).collect())
}

/// The lowest point's horizontal plane, turned about two edges until it meets a face.
fn first_face(points: &[Vector], near: f64) -> Option<Plane> {
    let lowest = points.iter().min_by(|a, b| a[2].total_cmp(&b[2])).copied()?;
    let below = Plane { normal: [0.0, 0.0, -1.0], offset: -lowest[2] };
    let side = turned(points, &below, lowest, [1.0, 0.0, 0.0], near)?;
    // An edge of that plane: the lowest point and the one in the plane that is farthest from it.
    let apart = |p: &&Vector| length(sub(**p, lowest));
    let in_plane = points.iter().filter(|p| is_on(&side, **p, near));
    let other = in_plane.max_by(|a, b| apart(a).total_cmp(&apart(b)))?;
    if apart(&other) <= near {
        return None;
    }
    let out = unit(cross(sub(*other, lowest), side.normal));
    turned(points, &side, lowest, out, near)
}

/// A plane that no point is above, turned about the line through its point `a` that is perpendicular
/// to `out` until it meets a point that is not on the line. It falls on the side to which `out`, a
/// unit vector in the plane, points.
fn turned(points: &[Vector], plane: &Plane, a: Vector, out: Vector, near: f64) -> Option<Plane> {
    let normal = plane.normal;
    let angles = points.iter().filter_map(|p| {
        let d = sub(*p, a);
        // What counts as in the plane is in it: an end of an edge that the tolerance lets lie below
        // the plane, and so beside the line, would else be met by a plane that holds that edge alone.
        // The angle of -0 would be -pi.
        let below = if is_on(plane, *p, near) { 0.0 } else { -dot(d, normal) };
        let ahead = dot(d, out);
        (ahead.hypot(below) > near).then(|| below.atan2(ahead))
    });
    let angle = angles.min_by(f64::total_cmp)?;
    let normal = unit(std::array::from_fn(|i| normal[i] * angle.cos() + out[i] * angle.sin()));
    // All points are within it, those that the tolerance left out too.
    let offset = points.iter().map(|p| dot(normal, *p)).fold(f64::MIN, f64::max);
    Some(Plane { normal, offset })
}

/// The points that count as in a plane that no point is above, ascending.
fn on(points: &[Vector], plane: &Plane, near: f64) -> Vec<usize> {
    (0..points.len()).filter(|i| is_on(plane, points[*i], near)).collect()
}

/// True if a point counts as in a plane that no point is above.
fn is_on(plane: &Plane, p: Vector, near: f64) -> bool {
    plane.offset - dot(plane.normal, p) <= 2.0 * near
}

/// Edges of a face, anticlockwise seen from outside: the convex polygon around the points in its
/// plane. None if these are fewer than three, or on a line.
fn edges(points: &[Vector], face: &Plane, near: f64) -> Vec<[Vector; 2]> {
    let u = unit(perpendicular(face.normal));
    let v = cross(face.normal, u);
    // In the plane, with the point that each belongs to.
    let mut flat: Vec<([f64; 2], Vector)> = points
        .iter()
        .filter(|p| is_on(face, **p, near))
        .map(|p| ([dot(*p, u), dot(*p, v)], *p))
        .collect();
    flat.sort_by(|(a, _), (b, _)| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    // Two chains from the least to the greatest point, each turning left (Andrew's algorithm).
    let chain = |of: &mut dyn Iterator<Item = &([f64; 2], Vector)>| {
        let mut chain: Vec<([f64; 2], Vector)> = Vec::new();
        for next in of {
            while let [.., a, b] = &chain[..]
                && is_straight_or_right(a.0, b.0, next.0, near)
            {
                chain.pop();
            }
            chain.push(*next);
        }
        chain.pop();
        chain
    };
    let mut around = chain(&mut flat.iter());
    around.extend(chain(&mut flat.iter().rev()));
    if around.len() < 3 {
        return Vec::new();
    }
    let corner = |i: usize| around[i % around.len()].1;
    (0..around.len()).map(|i| [corner(i), corner(i + 1)]).collect()
}

/// True if `b` is right of the way from `a` to `c`, or nearer to it than the tolerance.
fn is_straight_or_right(a: [f64; 2], b: [f64; 2], c: [f64; 2], near: f64) -> bool {
    let (ac, ab) = ([c[0] - a[0], c[1] - a[1]], [b[0] - a[0], b[1] - a[1]]);
    let area = ab[0] * ac[1] - ab[1] * ac[0];
    area <= near * ac[0].hypot(ac[1])
}

/// Middle and largest side of the box around points.
fn bounds(points: &[Vector]) -> (Vector, f64) {
    let fold = |axis: usize, start: f64, f: fn(f64, f64) -> f64| {
        points.iter().map(|p| p[axis]).fold(start, f)
    };
    let low: Vector = std::array::from_fn(|i| fold(i, f64::MAX, f64::min));
    let high: Vector = std::array::from_fn(|i| fold(i, f64::MIN, f64::max));
    let middle = std::array::from_fn(|i| f64::midpoint(low[i], high[i]));
    (middle, sub(high, low).into_iter().fold(0.0, f64::max))
}

/// A vector perpendicular to a unit vector.
fn perpendicular(n: Vector) -> Vector {
    let least = if n[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    cross(n, least)
}

fn sub(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|i| a[i] - b[i])
}

fn dot(a: Vector, b: Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

fn unit(a: Vector) -> Vector {
    let length = length(a).max(f64::MIN_POSITIVE);
    a.map(|x| x / length)
}

#[cfg(test)]
mod tests;
