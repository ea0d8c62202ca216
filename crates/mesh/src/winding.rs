//! Inside or outside: whether a point lies inside a mesh, by its generalised winding number: the
//! solid angle that the surface covers as seen from the point, over 4π. Unlike rays it gives
//! sensible answers for meshes with holes and for those that intersect themselves (Jacobson et al.
//! 2013); far parts of the surface count as one dipole each (Barill et al. 2018).

use std::f64::consts::PI;

use bendtwin_core::Point;

use crate::{Bvh, Mesh, Vec3, bvh::Node, orient::oriented, vec3};

/// Distance from which a part counts as a dipole [radii of the part]; the error is then below 2 %
/// of the part's angle.
const DIPOLE_DISTANCE: f64 = 2.3;

/// A mesh with an inside.
#[derive(Clone, Debug)]
pub struct Solid {
    bvh: Bvh,
    /// A dipole for each node of the tree.
    dipoles: Vec<Dipole>,
}

/// A part of the surface as seen from afar.
#[derive(Clone, Copy, Debug)]
struct Dipole {
    centre: Vec3,
    /// Sum of normals times areas.
    moment: Vec3,
    square_reach: f64,
}

impl Solid {
    /// Prepares a mesh. Triangles are turned first so that every piece faces outwards.
    pub fn new(mesh: &Mesh) -> Self {
        let bvh = Bvh::over(oriented(mesh));
        let dipoles = bvh.nodes.iter().map(|node| dipole(&bvh, node)).collect();
        Self { bvh, dipoles }
    }

    /// The surface, turned to face outwards.
    pub fn surface(&self) -> &Bvh {
        &self.bvh
    }

    /// The winding number of a point: 1 inside, 0 outside, between them near holes.
    pub fn winding_number(&self, p: Point) -> f64 {
        self.counted_winding_number(p).0
    }

    /// The winding number, and the number of parts of the surface that were visited for it: a few hundred,
    /// unless very many triangles lie around the point at the same distance.
    pub(crate) fn counted_winding_number(&self, p: Point) -> (f64, u64) {
        let p = vec3(p);
        let mut angle = 0.0;
        let mut visited = 0;
        let mut left = vec![0_usize];
        while let Some(index) = left.pop() {
            visited += 1;
            let (Some(node), Some(dipole)) = (self.bvh.nodes.get(index), self.dipoles.get(index))
            else {
                continue;
            };
            let to_part = dipole.centre - p;
            let square = to_part.norm_squared();
            if square > dipole.square_reach {
                angle += dipole.moment.dot(&to_part) / (square * square.sqrt());
            } else if node.second == 0 {
                let triangles = &self.bvh.triangles[node.first..node.first + node.count];
                angle += triangles.iter().map(|t| solid_angle(p, t)).sum::<f64>();
            } else {
                left.extend([node.second, index + 1]);
            }
        }
        (angle / (4.0 * PI), visited)
    }

    /// True if a point lies inside.
    pub fn contains(&self, p: Point) -> bool {
        is_inside(self.winding_number(p))
    }
}

/// True for the winding number of a point inside.
pub(crate) fn is_inside(winding_number: f64) -> bool {
    winding_number > 0.5
}

fn dipole(bvh: &Bvh, node: &Node) -> Dipole {
    let (mut moment, mut weighted, mut area) = (Vec3::zeros(), Vec3::zeros(), 0.0);
    let triangles = &bvh.triangles[node.first..node.first + node.count];
    for [a, b, c] in triangles {
        let n = (b - a).cross(&(c - a)) / 2.0;
        moment += n;
        weighted += (a + b + c) / 3.0 * n.norm();
        area += n.norm();
    }
    let centre = if area > 0.0 { weighted / area } else { (node.low + node.high) / 2.0 };
    let radius =
        triangles.iter().flatten().map(|v| (v - centre).norm_squared()).fold(0.0, f64::max);
    Dipole { centre, moment, square_reach: DIPOLE_DISTANCE * DIPOLE_DISTANCE * radius }
}

/// Solid angle of a triangle: `tan(Ω/2) = a·(b×c) / (|a||b||c| + (a·b)|c| + (b·c)|a| + (c·a)|b|)`
/// with corners relative to the point (van Oosterom and Strackee 1983).
fn solid_angle(p: Vec3, triangle: &[Vec3; 3]) -> f64 {
    let [a, b, c] = triangle.map(|v| v - p);
    let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
    let down = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
    2.0 * a.dot(&b.cross(&c)).atan2(down)
}

#[cfg(test)]
mod tests;
