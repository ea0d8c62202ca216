//! A ring of 200 nodes that waves, in a surface or in Gaussians, on a table with a ball.

use bendtwin_core::{Graph, NodeKind, Point, Skin, Surface};
use bendtwin_render::{Face, Mesh, Pose, Prop, Solid};
use bendtwin_splat::{Camera, Carrier, Gaussians};

const NODES: usize = 200;
/// Nodes that carry a vertex or a Gaussian.
const CARRIERS: usize = 16;
/// Radii of the ring, and of its section [m].
const RING: [f32; 2] = [0.16, 0.05];

/// The ring at rest.
pub(crate) struct Body {
    rest: Vec<Point>,
}

impl Body {
    pub(crate) fn new() -> Self {
        let golden = 0.618_034_f32;
        let node = |k: usize| on_ring(k as f32 / NODES as f32, (k as f32 * golden).fract());
        Self { rest: (0..NODES).map(node).collect() }
    }

    /// Nodes of a state [m].
    pub(crate) fn nodes(&self, state: usize) -> Vec<Point> {
        let wave = |p: &Point| {
            let height = 0.02 * (20.0 * p[0] + state as f32).sin();
            [p[0] + 0.002 * state as f32, p[1], p[2] + height]
        };
        self.rest.iter().map(wave).collect()
    }

    /// A closed surface with about this number of triangles.
    pub(crate) fn mesh(&self, triangles: usize) -> Mesh {
        let n = (triangles as f32 / 8.0).sqrt().round() as u32;
        let (long, short) = (4 * n, n);
        let places: Vec<Point> = (0..long * short)
            .map(|k| on_ring((k / short) as f32 / long as f32, (k % short) as f32 / short as f32))
            .collect();
        let at = |i: u32, j: u32| i % long * short + j % short;
        let quads = (0..long).flat_map(|i| (0..short).map(move |j| (i, j)));
        let triangles = quads
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect();
        let colors: Vec<[u8; 3]> = places.iter().map(|p| [200, (900.0 * p[2]) as u8, 40]).collect();
        let carriers = self.carriers(&places);
        Mesh::new(Surface { carriers, triangles, ..Surface::default() }, &colors)
    }

    /// Gaussians on the surface.
    pub(crate) fn gaussians(&self, count: usize) -> (Carrier, Gaussians) {
        let golden = 0.618_034_f32;
        let places: Vec<Point> = (0..count)
            .map(|k| on_ring(k as f32 / count as f32, (k as f32 * golden).fract()))
            .collect();
        let graph = Graph {
            rest_positions: self.rest.clone(),
            kinds: vec![NodeKind::Observed; NODES],
            masses: vec![0.001; NODES],
            object_ids: vec![0; NODES],
            observed_points: vec![Graph::NOT_OBSERVED; NODES],
            springs: (1..NODES as u32).map(|k| [k - 1, k]).collect(),
            ..Graph::default()
        };
        let carrier = Carrier::new(&graph, &self.carriers(&places)).expect("the graph is sound");
        let size = 0.6 / (count as f32).sqrt() * 0.4;
        let rest = Gaussians {
            means_m: places,
            scales_m: vec![[size, size, 0.3 * size]; count],
            rotations: vec![[0.0, 0.0, 0.0, 1.0]; count],
            opacities: vec![0.8; count],
            colors: vec![[0.8, 0.5, 0.2]; count],
        };
        (carrier, rest)
    }

    /// Points that their nearest nodes carry.
    fn carriers(&self, places: &[Point]) -> Skin {
        let mut skin = Skin::default();
        for place in places {
            let square =
                |node: &Point| -> f32 { (0..3).map(|a| (node[a] - place[a]).powi(2)).sum() };
            let mut near: Vec<(f32, u32)> = self.rest.iter().map(square).zip(0..).collect();
            near.sort_by(|a, b| a.0.total_cmp(&b.0));
            let weights: Vec<f32> =
                near[..CARRIERS].iter().map(|(d, _)| 1.0 / (d + 1e-5)).collect();
            let total: f32 = weights.iter().sum();
            let shares = near.iter().zip(&weights).map(|((_, node), w)| (*node, w / total));
            let shares: Vec<(u32, f32)> = shares.collect();
            // Along the axes of a frame, as in a twin: the offset itself does not matter here.
            let frame = [near[0].1, near[1].1, near[2].1];
            skin.push(Graph::NOT_OBSERVED, &shares, frame, [0.001; 3]);
        }
        skin
    }
}

/// A place on the ring by its two angles, in turns [m].
fn on_ring(around: f32, section: f32) -> Point {
    let (a, b) = (std::f32::consts::TAU * around, std::f32::consts::TAU * section);
    let reach = RING[0] + RING[1] * b.cos();
    [reach * a.cos(), reach * a.sin(), 0.1 + RING[1] * b.sin()]
}

/// A camera that sees the ring from in front and above.
pub(crate) fn camera(size: u32) -> Camera {
    let middle = (size - 1) as f32 / 2.0;
    // Turned down by 30 degrees from the direction of y.
    let angle = (-120.0_f32).to_radians() / 2.0;
    let pose = Pose::new([0.05, -0.45, 0.38, angle.sin(), 0.0, 0.0, angle.cos()]);
    Camera {
        width: size,
        height: size,
        fx: size as f32,
        fy: size as f32,
        cx: middle,
        cy: middle,
        world_to_camera: pose.world_to_camera(),
    }
}

/// A table and a ball.
pub(crate) fn solids() -> [Solid; 2] {
    let (low, high) = ([-0.5, -0.5, -0.05], [0.5, 0.5, 0.0]);
    let face = |axis: usize, sign: f32, offset_m: f32| {
        let mut normal = [0.0; 3];
        normal[axis] = sign;
        Face { normal, offset_m }
    };
    let faces = (0..3).flat_map(|i| [face(i, -1.0, -low[i]), face(i, 1.0, high[i])]).collect();
    let at = [0.05, 0.0, 0.1];
    [
        Solid::Convex { faces, bounds: [low, high] },
        Solid::Round { from: at, to: at, radius_m: 0.06 },
    ]
}

/// The table and the ball in their colours.
pub(crate) fn props(solids: &[Solid; 2]) -> Vec<Prop<'_>> {
    let colored = solids.iter().zip([[120, 90, 70], [40, 90, 200]]);
    colored.map(|(solid, color)| Prop { solid, pose: Pose::default(), color }).collect()
}
