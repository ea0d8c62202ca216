//! Time of an image and of gradients on the CPU. Prints a Markdown table; `RAYON_NUM_THREADS` sets
//! the threads.
//!
//! `cargo bench -p bendtwin-splat`

#[path = "raster/scene.rs"]
mod scene;

use std::{hint::black_box, time::Instant};

use bendtwin_splat::{Camera, Cpu, Gaussians, Rasteriser};

/// Calls of which the median counts.
const CALLS: usize = 25;

fn main() {
    println!("| Gaussians | image | threads | render, ms | render and gradients, ms |");
    println!("|---|---|---|---|---|");
    for (count, camera) in [
        (5_000, scene::camera(424, 240)),
        (20_000, scene::camera(424, 240)),
        (20_000, scene::camera(848, 480)),
        (50_000, scene::camera(848, 480)),
    ] {
        row(&scene::body(count, 7), &camera);
    }
}

fn row(gaussians: &Gaussians, camera: &Camera) {
    let bar = scene::bar(camera, 11);
    let mut cpu = Cpu::default();
    let mut changing = gaussians.clone();
    // Other Gaussians each time, so that nothing is kept from the call before.
    let mut next = || {
        changing.colors[0][0] = 1.0 - changing.colors[0][0];
        changing.clone()
    };
    let render = median(|| {
        black_box(cpu.render(&next(), camera)).expect("the scene is sound");
    });
    let both = median(|| {
        let gaussians = next();
        black_box(cpu.render(&gaussians, camera)).expect("the scene is sound");
        black_box(cpu.gradients(&gaussians, camera, &bar)).expect("the scene is sound");
    });
    let (threads, [w, h]) = (rayon::current_num_threads(), [camera.width, camera.height]);
    println!("| {} | {w} x {h} | {threads} | {render:.2} | {both:.2} |", gaussians.len());
}

/// Median time [ms].
fn median(mut work: impl FnMut()) -> f64 {
    work();
    let mut times: Vec<f64> = (0..CALLS)
        .map(|_| {
            let began = Instant::now();
            work();
            began.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[CALLS / 2]
}
