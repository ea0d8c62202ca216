//! Meshes with known answers, for tests.

use bendtwin_core::Point;

use crate::Mesh;

/// A sphere of unit radius: an octahedron whose faces were divided `depth` times.
pub(crate) fn sphere(depth: usize) -> Mesh {
    let mut mesh = Mesh {
        vertices: vec![
            [1.0, 0.0, 0.0],
            [-1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, -1.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
        ],
        triangles: vec![
            [0, 2, 4],
            [2, 1, 4],
            [1, 3, 4],
            [3, 0, 4],
            [2, 0, 5],
            [1, 2, 5],
            [3, 1, 5],
            [0, 3, 5],
        ],
    };
    for _ in 0..depth {
        let mut finer = Vec::new();
        for &[a, b, c] in &mesh.triangles {
            let mut middle = |a: u32, b: u32| {
                let (p, q) = (mesh.vertices[a as usize], mesh.vertices[b as usize]);
                let sum: Point = std::array::from_fn(|i| p[i] + q[i]);
                let length = sum.iter().map(|x| x * x).sum::<f32>().sqrt();
                mesh.vertices.push(sum.map(|x| x / length));
                mesh.vertices.len() as u32 - 1
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        mesh.triangles = finer;
    }
    mesh
}

/// A box between two corners.
pub(crate) fn cuboid(low: Point, high: Point) -> Mesh {
    let corner = |i: usize| std::array::from_fn(|a| if i >> a & 1 == 0 { low[a] } else { high[a] });
    Mesh {
        vertices: (0..8).map(corner).collect(),
        triangles: vec![
            [0, 2, 1],
            [1, 2, 3],
            [4, 5, 6],
            [5, 7, 6],
            [0, 1, 4],
            [1, 5, 4],
            [2, 6, 3],
            [3, 6, 7],
            [0, 4, 2],
            [2, 4, 6],
            [1, 3, 5],
            [3, 7, 5],
        ],
    }
}

/// Several meshes as one.
pub(crate) fn merged(parts: &[Mesh]) -> Mesh {
    let mut out = Mesh::default();
    for part in parts {
        let first = out.vertices.len() as u32;
        out.vertices.extend(&part.vertices);
        out.triangles.extend(part.triangles.iter().map(|t| t.map(|i| i + first)));
    }
    out
}

/// A body without symmetry: an uneven box with limbs of three lengths.
pub(crate) fn creature() -> Mesh {
    merged(&[
        cuboid([-0.05, -0.03, 0.0], [0.07, 0.035, 0.05]),
        cuboid([0.06, -0.02, 0.02], [0.12, 0.02, 0.065]),
        cuboid([-0.04, 0.03, 0.0], [-0.02, 0.09, 0.02]),
        cuboid([-0.04, -0.07, 0.0], [-0.02, -0.02, 0.02]),
        cuboid([0.03, -0.12, 0.005], [0.055, -0.02, 0.025]),
    ])
}
