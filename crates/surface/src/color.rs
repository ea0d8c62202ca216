//! Colours of vertices from those of the skin.

use bendtwin_core::Point;
use bendtwin_near::PointTree;

/// Skin points that a vertex has its colour from.
const NEAREST: usize = 4;
/// Square of the distance below which a skin point is the vertex [m²].
const SAME_M2: f64 = 1e-8;

/// The colour of each vertex: the mean of its nearest skin points, nearer ones counting more. Empty if the
/// skin has no colours.
pub(crate) fn of_vertices(vertices: &[Point], skin: &[Point], colors: &[[u8; 3]]) -> Vec<[u8; 3]> {
    if colors.len() != skin.len() {
        return Vec::new();
    }
    let tree = PointTree::new(skin.iter().copied());
    let of_vertex = |vertex: &Point| {
        let near = tree.within(*vertex, f64::INFINITY, NEAREST);
        let (mut sum, mut total) = ([0.0; 3], 0.0);
        for found in near {
            let weight = 1.0 / (found.square + SAME_M2);
            let color = colors[found.number as usize];
            sum = std::array::from_fn(|a| sum[a] + weight * f64::from(color[a]));
            total += weight;
        }
        sum.map(|channel| (channel / total).round() as u8)
    };
    vertices.iter().map(of_vertex).collect()
}
