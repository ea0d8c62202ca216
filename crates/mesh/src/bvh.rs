//! A tree of boxes over triangles, for the point of a surface that is nearest to another point.

use bendtwin_core::Point;

use crate::{Mesh, Vec3, point, vec3};

/// Most triangles in a leaf.
const MAX_LEAF_TRIANGLES: usize = 4;

/// Triangles sorted into nested boxes. Deterministic, and at most as deep as the logarithm of their
/// number.
#[derive(Clone, Debug)]
pub struct Bvh {
    pub(crate) nodes: Vec<Node>,
    /// Corners in the order of the leaves.
    pub(crate) triangles: Vec<[Vec3; 3]>,
}

/// A box around `first..first + count` of the triangles.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) low: Vec3,
    pub(crate) high: Vec3,
    pub(crate) first: usize,
    pub(crate) count: usize,
    /// The second child; the first is the next node. 0 for a leaf.
    pub(crate) second: usize,
}

/// The nearest point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// Nearest point.
    pub point: Point,
    /// Distance to it.
    pub distance: f64,
    /// Unit normal of its triangle by the order of the corners; zero for a triangle without area.
    pub normal: [f64; 3],
}

impl Bvh {
    /// Sorts a mesh's triangles; those that name a vertex that does not exist are left out.
    pub fn new(mesh: &Mesh) -> Self {
        Self::over(mesh.corners().collect())
    }

    pub(crate) fn over(mut triangles: Vec<[Vec3; 3]>) -> Self {
        let mut nodes = Vec::with_capacity(triangles.len() / 2 + 1);
        if !triangles.is_empty() {
            split(&mut triangles, 0, &mut nodes);
        }
        Self { nodes, triangles }
    }

    /// The point of the surface nearest to `p`; `None` if there are no triangles.
    pub fn closest(&self, p: Point) -> Option<Closest> {
        let (at, square, triangle) = self.nearest(vec3(p))?;
        let [a, b, c] = self.triangles[triangle];
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default();
        Some(Closest { point: point(at), distance: square.sqrt(), normal: normal.into() })
    }

    /// The nearest point, its squared distance, and its triangle.
    pub(crate) fn nearest(&self, p: Vec3) -> Option<(Vec3, f64, usize)> {
        let mut best = None;
        let mut square = f64::INFINITY;
        let mut left = vec![0_usize];
        while let Some(index) = left.pop() {
            let Some(node) = self.nodes.get(index) else { continue };
            if node.square_distance(p) >= square {
                continue;
            }
            if node.second == 0 {
                let range = node.first..node.first + node.count;
                for (t, triangle) in range.clone().zip(&self.triangles[range]) {
                    let q = nearest_on_triangle(p, triangle);
                    let d = (q - p).norm_squared();
                    if d < square {
                        (square, best) = (d, Some((q, d, t)));
                    }
                }
            } else {
                let children = [index + 1, node.second];
                let [a, b] = children.map(|c| self.nodes[c].square_distance(p));
                // The nearer box is opened first: it is pushed last.
                left.extend(if a < b { [children[1], children[0]] } else { children });
            }
        }
        best
    }
}

impl Node {
    fn square_distance(&self, p: Vec3) -> f64 {
        (p - p.sup(&self.low).inf(&self.high)).norm_squared()
    }
}

/// Appends the node of `triangles`, which start at `first` in the whole, and all below it.
fn split(triangles: &mut [[Vec3; 3]], first: usize, nodes: &mut Vec<Node>) {
    let centre = |t: &[Vec3; 3]| (t[0] + t[1] + t[2]) / 3.0;
    let everything = Vec3::repeat(f64::INFINITY);
    let (mut low, mut high) = (everything, -everything);
    let (mut low_centre, mut high_centre) = (everything, -everything);
    for t in triangles.iter() {
        for v in t {
            (low, high) = (low.inf(v), high.sup(v));
        }
        let c = centre(t);
        (low_centre, high_centre) = (low_centre.inf(&c), high_centre.sup(&c));
    }
    let own = nodes.len();
    let count = triangles.len();
    nodes.push(Node { low, high, first, count, second: 0 });
    if count <= MAX_LEAF_TRIANGLES {
        return;
    }
    let axis = (high_centre - low_centre).imax();
    let half = count / 2;
    triangles.select_nth_unstable_by(half, |a, b| centre(a)[axis].total_cmp(&centre(b)[axis]));
    let (left, right) = triangles.split_at_mut(half);
    split(left, first, nodes);
    nodes[own].second = nodes.len();
    split(right, first + half, nodes);
}

/// Nearest point of a triangle by the region in which the point's projection lies (Ericson,
/// Real-Time Collision Detection, 5.1.5).
fn nearest_on_triangle(p: Vec3, &[a, b, c]: &[Vec3; 3]) -> Vec3 {
    let (ab, ac) = (b - a, c - a);
    let (ap, bp, cp) = (p - a, p - b, p - c);
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let whole = va + vb + vc;
    a + ab * (vb / whole) + ac * (vc / whole)
}

#[cfg(test)]
mod tests;
