//! Gaussians of a file on a twin: brought to its rest shape, cropped to its skin, and carried by its
//! nodes.

use bendtwin_core::{
    Point, Twin,
    twin::appearance::{MOST_SPLATS, Splats},
};
use bendtwin_graph::{SurfacePoints, bind_points};
use bendtwin_mesh::{Mesh, Similarity, align};
use bendtwin_splat::Gaussians;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion};

use super::Error;

/// Largest distance of a Gaussian from the skin, in mean distances of neighbouring skin points.
const MOST_SPACINGS: f32 = 3.0;
/// Largest deviation from a rotation of a matrix that is given, relative to its scale.
const TOLERANCE: f64 = 1e-3;
/// Opacity below which a Gaussian does not count for the alignment.
const SEEN_OPACITY: f32 = 0.3;
/// Most Gaussians that take part in the alignment.
const MOST_ALIGNED: usize = 20_000;

/// Gaussians on a twin.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// Splats of the twin.
    pub splats: Splats,
    /// Gaussians that were too far from the skin.
    pub dropped: usize,
    /// From the file's axes and unit to those of the twin.
    pub similarity: Similarity,
}

/// Places Gaussians on a twin, by a similarity that is given or found. Gaussians further from the
/// skin than three of its spacings are dropped.
///
/// # Errors
/// If no alignment is found, nothing is near the twin or too much is.
pub fn place(
    gaussians: &Gaussians,
    twin: &Twin,
    by: Option<Similarity>,
) -> Result<Placement, Error> {
    let nodes = &twin.graph.rest_positions;
    let skin = if twin.skin.is_empty() { nodes.clone() } else { twin.skin.positions(nodes) };
    let similarity = match by {
        Some(similarity) => similarity,
        None => align(&patches(gaussians), &skin).map_err(Error::NotAligned)?.similarity,
    };
    let positions: Vec<Point> = gaussians.means_m.iter().map(|p| similarity.apply(*p)).collect();
    let (near, within_m) = near_skin(&positions, &skin);
    if near.is_empty() {
        return Err(Error::Elsewhere { within_mm: 1e3 * within_m });
    }
    if near.len() > MOST_SPLATS {
        return Err(Error::TooMany { count: near.len() as u64, limit: MOST_SPLATS });
    }
    let kept = gaussians.select(&near);
    let turn = quaternion_of(&similarity);
    let rotate = |q: &[f32; 4]| {
        let own = UnitQuaternion::from_quaternion(Quaternion::from(*q).cast::<f64>());
        let turned = turn * own;
        let [x, y, z, w] = *turned.coords.as_ref();
        [x as f32, y as f32, z as f32, w as f32]
    };
    let points = SurfacePoints {
        positions: near.iter().map(|g| positions[*g]).collect(),
        observed_points: vec![u32::MAX; near.len()],
    };
    let splats = Splats {
        carriers: bind_points(&twin.graph, nodes, &points),
        scales_m: kept
            .scales_m
            .iter()
            .map(|s| s.map(|v| (f64::from(v) * similarity.scale) as f32))
            .collect(),
        rotations: kept.rotations.iter().map(rotate).collect(),
        opacities: kept.opacities,
        colors: kept.colors,
    };
    Ok(Placement { splats, dropped: gaussians.len() - near.len(), similarity })
}

/// Similarity of a matrix, row-major; its last row is 0, 0, 0, 1.
///
/// # Errors
/// If it is not a rotation with one positive scale and a translation.
pub fn similarity_of(matrix: [[f64; 4]; 4]) -> Result<Similarity, Error> {
    let linear = Matrix3::from_fn(|i, j| matrix[i][j]);
    let scale = linear.determinant().cbrt();
    let rotation = linear / scale;
    let deviation = (rotation * rotation.transpose() - Matrix3::identity()).norm();
    let is_finite = matrix.iter().flatten().all(|v| v.is_finite());
    if !(is_finite && scale > 0.0 && deviation < TOLERANCE && matrix[3] == [0.0, 0.0, 0.0, 1.0]) {
        return Err(Error::Transform);
    }
    Ok(Similarity {
        rotation: std::array::from_fn(|i| std::array::from_fn(|j| rotation[(i, j)])),
        scale,
        translation: std::array::from_fn(|i| matrix[i][3]),
    })
}

/// A small triangle for each of the Gaussians that can be seen, so that they can be aligned as a
/// surface is.
fn patches(gaussians: &Gaussians) -> Mesh {
    let seen: Vec<usize> =
        (0..gaussians.len()).filter(|g| gaussians.opacities[*g] >= SEEN_OPACITY).collect();
    let step = seen.len().div_ceil(MOST_ALIGNED).max(1);
    let chosen: Vec<usize> = seen.into_iter().step_by(step).collect();
    // All of one size: a large Gaussian says no more about a place than a small one.
    let mut sizes: Vec<f32> =
        chosen.iter().map(|g| gaussians.scales_m[*g].iter().copied().fold(0.0, f32::max)).collect();
    sizes.sort_by(f32::total_cmp);
    let size = sizes.get(sizes.len() / 2).copied().unwrap_or(1.0);
    let mut mesh = Mesh { vertices: Vec::new(), triangles: Vec::new() };
    for (index, &g) in (0u32..).zip(&chosen) {
        let scales = gaussians.scales_m[g];
        let thinnest = (0..3).min_by(|a, b| scales[*a].total_cmp(&scales[*b])).unwrap_or(2);
        let turn = UnitQuaternion::from_quaternion(Quaternion::from(gaussians.rotations[g]));
        let axis = |k: usize| turn * nalgebra::Vector3::ith(k % 3, size);
        let (u, v) = (axis(thinnest + 1), axis(thinnest + 2));
        let mean = nalgebra::Vector3::from(gaussians.means_m[g]);
        for corner in [mean + u, mean - u * 0.5 + v, mean - u * 0.5 - v] {
            mesh.vertices.push(corner.into());
        }
        mesh.triangles.push([3 * index, 3 * index + 1, 3 * index + 2]);
    }
    mesh
}

/// Indices of points near the skin, and the distance up to which they are [m].
fn near_skin(points: &[Point], skin: &[Point]) -> (Vec<usize>, f32) {
    let (Ok(tree), Some(two)) =
        (ImmutableKdTree::new_from_slice(skin), std::num::NonZero::new(skin.len().min(2)))
    else {
        return (Vec::new(), 0.0);
    };
    let distance = |p: &Point, n| {
        let found = tree.query(p).nearest_n::<SquaredEuclidean<f32>>(n).execute();
        found.last().map_or(f32::INFINITY, |n| n.distance.sqrt())
    };
    let spacing = skin.iter().map(|p| distance(p, two)).sum::<f32>() / skin.len() as f32;
    let within = MOST_SPACINGS * spacing;
    let one = std::num::NonZero::<usize>::MIN;
    let near = (0..points.len()).filter(|i| distance(&points[*i], one) <= within);
    (near.collect(), within)
}

fn quaternion_of(similarity: &Similarity) -> UnitQuaternion<f64> {
    let matrix = Matrix3::from_fn(|i, j| similarity.rotation[i][j]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix))
}

#[cfg(test)]
mod tests;
