//! Time of the pictures of 64 states, each posed and drawn by one camera: wall-clock time of all, the processor time of
//! one, and pictures a second. Prints a Markdown table; `RAYON_NUM_THREADS` sets the threads.
//!
//! `cargo bench -p bendtwin-render`

#[path = "../../engine/benches/substep/clock.rs"]
mod clock;
#[path = "pictures/scene.rs"]
mod scene;

use std::{hint::black_box, time::Instant};

use bendtwin_core::Point;
use bendtwin_render::{Background, Light, Mesh, Object, Prop, Scene, Wanted, draw};
use bendtwin_splat::{Camera, Carrier, Cpu, Gaussians, Rasteriser};
use rayon::prelude::*;

/// States whose pictures are taken together.
const STATES: usize = 64;
/// Calls over which the median is taken.
const CALLS: usize = 5;
const LIGHT: Light = Light { direction: [0.0, -0.6, 0.8], ambient: 0.5, brightness: 1.0 };

/// The look of the object.
enum Look {
    Surface(Mesh),
    Gaussians(Carrier, Gaussians),
}

fn main() {
    println!(
        "| object | picture | depths and labels | threads | 64 pictures, ms | processor ms of one | pictures/s |"
    );
    println!("|---|---|---|---|---|---|---|");
    let body = scene::Body::new();
    let states: Vec<Vec<Point>> = (0..STATES).map(|k| body.nodes(k)).collect();
    for triangles in [1_000, 5_000, 8_000] {
        let mesh = body.mesh(triangles);
        let name = format!("{} triangles", mesh.triangle_count());
        let look = Look::Surface(mesh);
        for (size, all) in [(96, false), (96, true), (224, false)] {
            row(&name, &look, &states, size, all);
        }
    }
    for count in [5_000, 20_000] {
        let (carrier, gaussians) = body.gaussians(count);
        let look = Look::Gaussians(carrier, gaussians);
        for size in [96, 224] {
            row(&format!("{count} Gaussians"), &look, &states, size, false);
        }
    }
}

fn row(name: &str, look: &Look, states: &[Vec<Point>], size: u32, all: bool) {
    let camera = scene::camera(size);
    let wanted = Wanted { depths: all, labels: all };
    let solids = scene::solids();
    let props = scene::props(&solids);
    let each = |nodes: &Vec<Point>| picture(look, nodes, &camera, &props, wanted);
    let mut together = || {
        let pictures: usize = states.par_iter().map(each).sum();
        black_box(pictures);
    };
    let ms = median(&mut together);
    let processor = clock::best_of(CALLS, together) * 1e3 / STATES as f64;
    let (threads, rate) = (rayon::current_num_threads(), STATES as f64 / ms * 1e3);
    let all = if all { "yes" } else { "no" };
    println!(
        "| {name} | {size} x {size} | {all} | {threads} | {ms:.0} | {processor:.2} | {rate:.0} |"
    );
}

/// Draws a picture; returns its size.
fn picture(
    look: &Look,
    nodes: &[Point],
    camera: &Camera,
    props: &[Prop<'_>],
    wanted: Wanted,
) -> usize {
    let background = Background::Color([214; 3]);
    let drawn = |object: Object<'_>| {
        let scene = Scene { camera, object, props, light: &LIGHT, background };
        draw(&scene, wanted, &|| false).map_or(0, |picture| picture.colors.len())
    };
    match look {
        Look::Surface(mesh) => drawn(Object::Surface(&mesh.at(nodes, &LIGHT))),
        Look::Gaussians(carrier, rest) => {
            let carried = carrier.at(nodes).expect("the nodes are sound");
            let placed = carried.place(rest).expect("all are bound");
            let image = Cpu::default().render(&placed, camera).expect("the scene is sound");
            drawn(Object::Gaussians(&image))
        }
    }
}

/// Median time [ms].
fn median(mut work: impl FnMut()) -> f64 {
    work();
    let mut times: Vec<f64> = (0..CALLS)
        .map(|_| {
            let started = Instant::now();
            work();
            started.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[CALLS / 2]
}
