//! Time of an image and of gradients on the CPU: medians by the clock, and the shortest time on
//! processors, all threads together. Prints a Markdown table; `RAYON_NUM_THREADS` sets the threads.
//!
//! `cargo bench -p bendtwin-splat`

#[path = "../../engine/benches/substep/clock.rs"]
mod clock;
#[path = "raster/scene.rs"]
mod scene;

use std::{hint::black_box, time::Instant};

use bendtwin_splat::{Camera, Cpu, Gaussians, Rasteriser};

/// Calls over which the median is taken.
const CALLS: usize = 25;

fn main() {
    println!(
        "| Gaussians | image | threads | render, ms | and gradients, ms | render, processor ms | and gradients, processor ms |"
    );
    println!("|---|---|---|---|---|---|---|");
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
    let mut render = || {
        black_box(cpu.render(&next(), camera)).expect("the scene is sound");
    };
    let renders = [median(&mut render), clock::best_of(CALLS, render) * 1e3];
    let mut both = || {
        let gaussians = next();
        black_box(cpu.render(&gaussians, camera)).expect("the scene is sound");
        black_box(cpu.gradients(&gaussians, camera, &bar)).expect("the scene is sound");
    };
    let boths = [median(&mut both), clock::best_of(CALLS, both) * 1e3];
    let (threads, [w, h]) = (rayon::current_num_threads(), [camera.width, camera.height]);
    let [a, b, c, d] = [renders[0], boths[0], renders[1], boths[1]];
    let count = gaussians.len();
    println!("| {count} | {w} x {h} | {threads} | {a:.1} | {b:.1} | {c:.1} | {d:.1} |");
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
