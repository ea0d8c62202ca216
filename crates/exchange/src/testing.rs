//! A small twin, its motion, and a mesh around it.

use std::io::Cursor;

use bendtwin_core::{Graph, NodeKind, Params, Pin, Point, Skin, Surface, Timing, Twin};
use bendtwin_mesh::Mesh;

use crate::{Format, Motion, Scene, encode};

/// Five nodes of two objects, the first of them pinned to one of two control points.
pub(crate) fn twin() -> Twin {
    let rest_positions: Vec<Point> =
        vec![[0.0, 0.0, 0.5], [0.1, 0.0, 0.5], [0.1, 0.1, 0.5], [0.0, 0.1, 0.6], [0.5, 0.5, 0.25]];
    let n = rest_positions.len();
    let graph = Graph {
        rest_positions,
        kinds: [vec![NodeKind::Observed; 3], vec![NodeKind::Completed, NodeKind::Interior]]
            .concat(),
        masses: vec![1.0, 2.0, 1.0, 1.0, 0.5],
        object_ids: vec![3, 3, 3, 3, 8],
        observed_points: vec![Graph::NOT_OBSERVED; n],
        control_rest: vec![[0.0, 0.0, 0.55], [0.0, 0.1, 0.65]],
        springs: vec![[0, 1], [1, 2], [2, 3], [0, 3], [3, 6], [0, 5]],
        triplets: vec![[0, 1, 2], [6, 3, 2]],
        pins: vec![Pin { node: 0, control: 0, offset_m: [0.0, 0.0, -0.05] }],
        rods: Vec::new(),
    };
    let mut skin = Skin::default();
    skin.push(0, &[(0, 0.5), (1, 0.5)], [Skin::NO_FRAME; 3], [0.0, 0.0, 0.01]);
    skin.push(1, &[(2, 1.0)], [0, 1, 2], [0.0, 0.0, 0.02]);
    let params = Params {
        spring_stiffness: vec![1000.0, 900.0, 800.0, 700.0, 600.0, 500.0],
        spring_dashpot: vec![1.0; 6],
        rest_lengths_m: vec![0.1, 0.1, 0.14, 0.14, 0.05, 0.05],
        bend_stiffness: vec![0.1, 0.2],
        bend_damping: vec![0.01, 0.02],
        rest_angles_rad: vec![1.5, 1.2],
        drag: 2.0,
        ..Params::default()
    };
    Twin {
        skin,
        mass_kg: Some(0.55),
        ..Twin::new(graph, params, Timing { fps: 30.0, substeps: 100 })
    }
}

/// Three frames in which everything falls and turns a little.
pub(crate) fn motion(twin: &Twin) -> Motion {
    let moved = |points: &[Point]| -> Vec<Point> {
        let frames = (1..=3).map(|f| f as f32);
        frames
            .flat_map(|f| {
                points.iter().map(move |p| [p[0] + 0.01 * f * p[1], p[1], p[2] - 0.02 * f])
            })
            .collect()
    };
    Motion {
        times_s: (1..=3).map(|f| f64::from(f) / 30.0).collect(),
        nodes: moved(&twin.graph.rest_positions),
        controls: moved(&twin.graph.control_rest),
    }
}

/// A tetrahedron near the nodes.
pub(crate) fn mesh() -> Mesh {
    Mesh {
        vertices: vec![[0.02, 0.0, 0.48], [0.09, 0.02, 0.5], [0.05, 0.08, 0.5], [0.03, 0.05, 0.58]],
        triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    }
}

/// The content of a file.
pub(crate) fn encoded(scene: &Scene<'_>, format: Format) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    encode(scene, format, &mut out).unwrap();
    out.into_inner()
}

/// The same twin with a coloured surface: a tetrahedron on its nodes.
pub(crate) fn with_surface() -> Twin {
    let surface = Surface {
        carriers: Skin::at_nodes(&[0, 1, 2, 3]),
        triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
        colors: vec![[255, 0, 0], [0, 188, 0], [0, 0, 0], [255, 255, 255]],
        tubes: Vec::new(),
    };
    Twin { surface: Some(surface), ..twin() }
}
