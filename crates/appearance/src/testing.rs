//! A coloured ball that falls, and views of it, for this crate's tests.

use bendtwin_core::{
    Contact, Graph, NodeKind, Params, Point, Skin, Splats, Twin, View, ViewCamera, Views,
    views::Label,
};
use bendtwin_core_kit::twin_of;
use bendtwin_graph::{SurfacePoints, bind_skin};
use bendtwin_splat::{Cpu, Rasteriser};

use crate::{Dressed, Motion, camera, dressed::of_skin};

/// Radius of the ball [m].
const RADIUS_M: f32 = 0.05;
/// Way of the ball in a frame [m].
pub(crate) const FALL_M: f32 = 0.004;
/// Nodes on a grid through the ball, 2 cm apart.
const SIDE: i32 = 2;

/// A ball, what it looks like, its motion, and what two cameras saw of it.
pub(crate) struct Ball {
    pub(crate) twin: Twin,
    pub(crate) colors: Vec<[u8; 3]>,
    pub(crate) splats: Splats,
    /// Positions of nodes, shape [frames, N, 3].
    pub(crate) nodes: Vec<Point>,
    pub(crate) views: Views,
}

/// A motion from frame 0.
pub(crate) fn motion_of(nodes: &[Point], train_frame_count: usize) -> Motion<'_> {
    let node_count = Ball::nodes_at_rest().len();
    Motion { start_frame: 0, node_count, positions: nodes, train_frame_count }
}

impl Ball {
    pub(crate) fn new(frames: u32) -> Self {
        let twin = twin();
        let rest = twin.skin.positions(&twin.graph.rest_positions);
        let colors: Vec<[u8; 3]> = rest.iter().map(color).collect();
        let splats = of_skin(&twin, &colors);
        let at = |frame: u32| {
            let own = twin.graph.rest_positions.iter();
            own.map(move |p| [p[0], p[1], p[2] - FALL_M * frame as f32])
        };
        let nodes: Vec<Point> = (0..frames).flat_map(at).collect();
        let dressed = Dressed::new(&twin.graph, &splats).unwrap();
        let mut views = Views { cameras: vec![seen_from_front(), seen_from_side()] };
        let count = twin.graph.node_count();
        for camera in &mut views.cameras {
            for frame in 0..frames {
                let first = frame as usize * count;
                let gaussians = dressed.at(&nodes[first..first + count]).unwrap();
                let image =
                    Cpu::default().render(&gaussians, &camera::whole(camera, frame)).unwrap();
                let byte = |x: f32| (255.0 * x).round().clamp(0.0, 255.0) as u8;
                let label = |a: &f32| if *a > 0.5 { Label::Object } else { Label::Background };
                let depth = |p: usize| match image.alpha[p] > 0.5 {
                    true => (1e3 * image.depth_m[p] / image.alpha[p]).round() as u16,
                    false => 0,
                };
                camera.views.push(View {
                    frame,
                    corner: [0, 0],
                    size: camera.size,
                    colors: image.color.iter().map(|c| c.map(byte)).collect(),
                    labels: image.alpha.iter().map(label).collect(),
                    depths_mm: (0..image.alpha.len()).map(depth).collect(),
                });
            }
        }
        Self { twin, colors, splats, nodes, views }
    }

    fn nodes_at_rest() -> Vec<Point> {
        let along = || -SIDE..=SIDE;
        let cube = along().flat_map(|x| {
            along().flat_map(move |y| along().map(move |z| [x, y, z].map(|i| 0.02 * i as f32)))
        });
        cube.collect()
    }
}

/// Colours that differ from side to side.
fn color(p: &Point) -> [u8; 3] {
    p.map(|x| (255.0 * (0.5 + 0.45 * (x / RADIUS_M).clamp(-1.0, 1.0))) as u8)
}

fn twin() -> Twin {
    let positions = Ball::nodes_at_rest();
    let n = positions.len();
    let near = |a: usize, b: usize| {
        (0..3).map(|k| (positions[a][k] - positions[b][k]).powi(2)).sum::<f32>() < 0.035 * 0.035
    };
    let pairs = (0..n).flat_map(|a| (a + 1..n).map(move |b| [a, b]));
    let springs: Vec<[u32; 2]> =
        pairs.filter(|[a, b]| near(*a, *b)).map(|pair| pair.map(|i| i as u32)).collect();
    let graph = Graph {
        kinds: vec![NodeKind::Observed; n],
        masses: vec![1.0; n],
        object_ids: vec![0; n],
        observed_points: vec![Graph::NOT_OBSERVED; n],
        rest_positions: positions,
        springs,
        ..Graph::default()
    };
    let skin = bind_skin(&graph, &sphere(600));
    Twin {
        skin: Skin { observed_points: vec![Graph::NOT_OBSERVED; skin.len()], ..skin },
        ..twin_of(graph, Params { contact: Contact::default(), ..Params::default() })
    }
}

/// Points spread evenly over the ball, along a spiral.
fn sphere(count: usize) -> SurfacePoints {
    let point = |i: usize| -> Point {
        let z = 1.0 - (2 * i + 1) as f64 / count as f64;
        let (angle, r) = (2.399_963 * i as f64, (1.0 - z * z).sqrt());
        [r * angle.cos(), r * angle.sin(), z].map(|x| RADIUS_M * x as f32)
    };
    let observed_points = vec![Graph::NOT_OBSERVED; count];
    SurfacePoints { positions: (0..count).map(point).collect(), observed_points }
}

/// A camera 40 cm in front of the ball, along y.
fn seen_from_front() -> ViewCamera {
    camera([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.4]], "front")
}

/// A camera 40 cm beside the ball, along -x.
fn seen_from_side() -> ViewCamera {
    camera([[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [-1.0, 0.0, 0.0, 0.4]], "side")
}

fn camera(pose: [[f64; 4]; 3], name: &str) -> ViewCamera {
    ViewCamera {
        name: name.to_owned(),
        size: [96, 96],
        focal: [220.0, 220.0],
        centre: [47.5, 47.5],
        world_to_camera: vec![pose],
        views: Vec::new(),
    }
}
