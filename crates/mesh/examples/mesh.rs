//! Samples of a mesh, and its alignment.
//!
//! ```text
//! cargo run --release -p bendtwin-mesh --example mesh -- FILE [SPACING_M]
//! ```
//!
//! Samples the mesh, then hides what three cameras would not see, moves the rest, and prints how
//! well alignment recovers the pose.

use std::time::Instant;

use bendtwin_core::Point;
use bendtwin_mesh::{Bvh, Limits, Mesh, Similarity, Solid, align, convex_interior, parse};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let path = args.next().ok_or("name a mesh: FILE [SPACING_M]")?;
    let spacing: f32 = args.next().map_or(Ok(0.005), |s| s.parse())?;
    let mesh = parse(&path, &std::fs::read(&path)?, &Limits::default())?;
    println!("{} vertices, {} triangles", mesh.vertices.len(), mesh.triangles.len());
    let start = Instant::now();
    let surface = mesh.sample_surface(spacing, 0)?;
    println!("{} surface points {} m apart, {:.2?}", surface.len(), spacing, start.elapsed());
    let start = Instant::now();
    let interior = mesh.sample_interior(spacing)?;
    println!("{} interior points, {:.2?}", interior.len(), start.elapsed());

    let seen = seen(&mesh, spacing)?;
    let start = Instant::now();
    let filled = convex_interior(&seen, spacing)?;
    let solid = Solid::new(&mesh);
    let within = filled.iter().filter(|p| solid.contains(**p)).count();
    let count = filled.len();
    println!(
        "{count} points fill convex parts of the {} seen, {within} of them truly inside, {:.2?}",
        seen.len(),
        start.elapsed()
    );
    for turn in 0..8 {
        let truth = similarity(turn);
        let observed: Vec<Point> = seen.iter().map(|p| truth.apply(*p)).collect();
        let start = Instant::now();
        let aligned = align(&mesh, &observed)?;
        // From the surface, not from the same vertices: a symmetric body fits in several ways.
        let moved = Bvh::new(&mesh.moved(&truth));
        let distances = mesh.vertices.iter().filter_map(|v| {
            Some(moved.closest(aligned.similarity.apply(*v))?.distance / truth.scale)
        });
        let worst = distances.fold(0.0, f64::max);
        println!(
            "aligned to {} points: the mesh off by up to {:.2} mm, size by {:.2} %, {:.0} % inliers at {:.2} mm rms, {:.2?}",
            observed.len(),
            worst * 1e3,
            (aligned.similarity.scale / truth.scale - 1.0) * 100.0,
            aligned.inlier_share * 100.0,
            aligned.rms_m * 1e3,
            start.elapsed()
        );
    }
    Ok(())
}

/// Surface points that face one of three cameras above.
fn seen(mesh: &Mesh, spacing: f32) -> Result<Vec<Point>, bendtwin_mesh::Error> {
    let bvh = Bvh::new(mesh);
    let [low, high] = mesh.bounds().unwrap_or_default();
    // The sample of the data set has z pointing down; seen from above either way, as meshes are
    // thinnest upwards there.
    let up = if low[2] + high[2] < 0.0 { -1.0 } else { 1.0 };
    let cameras = [-90.0_f64, 30.0, 150.0].map(|degrees| {
        let (s, c) = degrees.to_radians().sin_cos();
        [0.9 * c, 0.9 * s, 0.45 * up]
    });
    let faces = |p: &Point| {
        bvh.closest(*p).is_some_and(|c| {
            cameras.iter().any(|d| (0..3).map(|a| c.normal[a] * d[a]).sum::<f64>() > 0.15)
        })
    };
    Ok(mesh.sample_surface(spacing, 1)?.into_iter().filter(faces).collect())
}

/// A rotation about a skew axis, a size and a place.
fn similarity(turn: usize) -> Similarity {
    let angle = 0.8 * turn as f64;
    let (s, c) = angle.sin_cos();
    let (sx, cx) = (1.3 * angle).sin_cos();
    Similarity {
        rotation: [[c, -s * cx, s * sx], [s, c * cx, -c * sx], [0.0, sx, cx]],
        scale: [1.0, 0.4, 2.5, 0.05][turn % 4],
        translation: [0.3, -0.1, 0.7],
    }
}
