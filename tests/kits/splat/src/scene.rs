//! Random Gaussians, cameras and derivatives, by seed.

use bendtwin_splat::{Camera, Gaussians, ImageBar};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Properties of random Gaussians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneOptions {
    /// Number of Gaussians.
    pub count: usize,
    /// Half the side of the cube that they are in [m].
    pub half_side_m: f32,
    /// Least and largest scale [m]; logarithms are uniform.
    pub scales_m: [f32; 2],
    /// Least and largest opacity.
    pub opacities: [f32; 2],
}

impl Default for SceneOptions {
    fn default() -> Self {
        Self { count: 40, half_side_m: 0.12, scales_m: [0.002, 0.03], opacities: [0.1, 0.9] }
    }
}

/// Random Gaussians in a cube about the origin.
pub fn random_gaussians(seed: u64, options: &SceneOptions) -> Gaussians {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut gaussians = Gaussians::default();
    let (half, [low, high]) = (options.half_side_m, options.scales_m);
    let [faint, dense] = options.opacities;
    for _ in 0..options.count {
        gaussians.means_m.push([0; 3].map(|_| half * rng.random_range(-1.0..1.0_f32)));
        let scale = |u: f32| low * (high / low).powf(u);
        gaussians.scales_m.push([0; 3].map(|_| scale(rng.random::<f32>())));
        let length = rng.random_range(0.5..2.0_f32);
        let turn = loop {
            let q = [0; 4].map(|_| rng.random_range(-1.0..1.0_f32));
            let square: f32 = q.iter().map(|x| x * x).sum();
            if (0.01..1.0).contains(&square) {
                break q.map(|x| x * length / square.sqrt());
            }
        };
        gaussians.rotations.push(turn);
        gaussians.opacities.push(faint + (dense - faint) * rng.random::<f32>());
        gaussians.colors.push([0; 3].map(|_| rng.random()));
    }
    gaussians
}

/// A camera about 0.5 m from the origin that looks at it from a random side; with an image of this
/// size, of about 30 degrees.
pub fn random_camera(seed: u64, width: u32, height: u32) -> Camera {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x5eed);
    let (yaw, pitch) = (rng.random_range(-3.0..3.0_f32), rng.random_range(-1.2..1.2_f32));
    let ((sy, cy), (sp, cp)) = (yaw.sin_cos(), pitch.sin_cos());
    let rows = [[cy, 0.0, sy], [sy * sp, cp, -cy * sp], [-sy * cp, sp, cy * cp]];
    let shift = [rng.random_range(-0.02..0.02_f32), rng.random_range(-0.02..0.02), 0.5];
    let mut world_to_camera = [[0.0; 4]; 3];
    for r in 0..3 {
        world_to_camera[r][..3].copy_from_slice(&rows[r]);
        world_to_camera[r][3] = shift[r];
    }
    let focal = 1.8 * width as f32;
    Camera {
        width,
        height,
        fx: focal,
        fy: focal * 1.1,
        cx: 0.5 * width as f32 + rng.random_range(-2.0..2.0_f32),
        cy: 0.5 * height as f32 + rng.random_range(-2.0..2.0_f32),
        world_to_camera,
    }
}

/// Random derivatives by all channels of a camera's image.
pub fn random_bar(seed: u64, camera: &Camera) -> ImageBar {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0xba5);
    let mut bar = ImageBar::zeros(camera.pixel_count());
    for pixel in 0..camera.pixel_count() {
        bar.color[pixel] = [0; 3].map(|_| rng.random_range(-1.0..1.0_f32));
        bar.alpha[pixel] = rng.random_range(-1.0..1.0);
        bar.depth_m[pixel] = rng.random_range(-1.0..1.0);
    }
    bar
}
