//! An object as training has it: Gaussians about the surface of an ellipsoid, which covers about
//! 100 x 120 pixels of a 424 x 240 image.

use bendtwin_splat::{Camera, Gaussians, ImageBar};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A camera 0.6 m before the object.
pub(super) fn camera(width: u32, height: u32) -> Camera {
    let focal = 215.0 * width as f32 / 424.0;
    Camera {
        width,
        height,
        fx: focal,
        fy: focal,
        cx: (width - 1) as f32 / 2.0,
        cy: (height - 1) as f32 / 2.0,
        world_to_camera: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.6]],
    }
}

/// A body of `count` Gaussians, about as large as their distances.
pub(super) fn body(count: usize, seed: u64) -> Gaussians {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let radii = [0.14_f32, 0.167, 0.1];
    let spacing = (3.5 * radii[0] * radii[1] * 4.0 / count as f32).sqrt();
    let mut gaussians = Gaussians::default();
    for _ in 0..count {
        let mut direction = [0.0_f32; 3].map(|_| rng.random_range(-1.0..1.0_f32));
        let length = direction.iter().map(|x| x * x).sum::<f32>().sqrt().max(1e-3);
        direction = direction.map(|x| x / length);
        let depth = 1.0 - 0.05 * rng.random::<f32>();
        gaussians.means_m.push([0, 1, 2].map(|k| direction[k] * radii[k] * depth));
        let scale = spacing * 0.6;
        gaussians.scales_m.push([0; 3].map(|_| scale * rng.random_range(0.4..1.6_f32)));
        gaussians.rotations.push([0; 4].map(|_| rng.random_range(0.1..1.0_f32)));
        gaussians.opacities.push(rng.random_range(0.2..0.95));
        gaussians.colors.push([0; 3].map(|_| rng.random()));
    }
    gaussians
}

/// d loss / d image at random.
pub(super) fn bar(camera: &Camera, seed: u64) -> ImageBar {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut bar = ImageBar::zeros(camera.pixel_count());
    for pixel in 0..camera.pixel_count() {
        bar.color[pixel] = [0; 3].map(|_| rng.random_range(-1.0..1.0_f32));
        bar.alpha[pixel] = rng.random_range(-1.0..1.0);
        bar.depth_m[pixel] = rng.random_range(-1.0..1.0);
    }
    bar
}
