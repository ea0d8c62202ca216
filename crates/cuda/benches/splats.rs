//! Time of images of Gaussians and of gradients on a device: medians of 200 calls with other
//! Gaussians each time, copies to the device included. Prints a Markdown table.
//!
//! `cargo bench -p bendtwin-cuda --bench splats`

#[path = "../../splat/benches/raster/scene.rs"]
mod scene;

use std::{hint::black_box, time::Instant};

use bendtwin_cuda::{CudaRasteriser, Options};
use bendtwin_splat::{Camera, Gaussians, Rasteriser};

/// Calls over which the median is taken.
const CALLS: usize = 200;

fn main() {
    let mut device = match CudaRasteriser::new(&Options::default()) {
        Ok(device) => device,
        Err(error) => {
            println!("SKIPPED: {error}");
            return;
        }
    };
    println!("{}\n", device.name());
    println!(
        "| Gaussians | image | draw, ms | draw and copy back, ms | gradients of it, ms | draw and gradients, ms |"
    );
    println!("|---|---|---|---|---|---|");
    for (count, camera) in [
        (5_000, scene::camera(424, 240)),
        (20_000, scene::camera(424, 240)),
        (20_000, scene::camera(848, 480)),
        (50_000, scene::camera(848, 480)),
        (200_000, scene::camera(848, 480)),
    ] {
        row(&mut device, &scene::body(count, 7), &camera);
    }
}

fn row(device: &mut CudaRasteriser, gaussians: &Gaussians, camera: &Camera) {
    let bar = scene::bar(camera, 11);
    // Two sets in turn, so that nothing is kept from the call before.
    let mut sets = [gaussians.clone(), gaussians.clone()];
    sets[1].colors[0][0] = 1.0 - sets[1].colors[0][0];
    let sets = &sets;
    let draw = median(|k| device.draw(&sets[k % 2], camera).expect("the scene is sound"));
    let copied = median(|k| {
        black_box(device.render(&sets[k % 2], camera)).expect("the scene is sound");
    });
    let gradients = median(|_| {
        // The last rendering, which is kept.
        black_box(device.gradients(&sets[0], camera, &bar)).expect("the scene is sound");
    });
    let both = median(|k| {
        black_box(device.gradients(&sets[k % 2], camera, &bar)).expect("the scene is sound");
    });
    let (count, [w, h]) = (gaussians.len(), [camera.width, camera.height]);
    println!("| {count} | {w} x {h} | {draw:.2} | {copied:.2} | {gradients:.2} | {both:.2} |");
}

/// Median time [ms] of work, which receives the index of its call.
fn median(mut work: impl FnMut(usize)) -> f64 {
    (0..4).for_each(&mut work);
    let mut times: Vec<f64> = (0..CALLS)
        .map(|k| {
            let began = Instant::now();
            work(k);
            began.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[CALLS / 2]
}
