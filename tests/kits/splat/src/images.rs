//! Images: against the plain rasteriser, a closed form, and themselves.

use bendtwin_splat::{
    Camera, Gaussians, Rasteriser,
    constants::{BLUR_PX2, MOST_ALPHA},
};

use super::{
    expect::{Outcome, arrays, ensure, is_image},
    reference::Reference,
    scene::{SceneOptions, random_bar, random_camera, random_gaussians},
};

/// Rounding of a pixel's distance from a centre, 1e-5 px, times the slope of a Gaussian, and sums
/// over up to a hundred of them.
const TOLERANCE: f64 = 3e-4;

fn failed(error: impl std::fmt::Display) -> String {
    format!("failed: {error}")
}

pub(super) fn images_are_those_of_a_plain_rasteriser(r: &mut dyn Rasteriser) -> Outcome {
    for seed in 0..6 {
        let options = SceneOptions { count: 20 << seed, ..SceneOptions::default() };
        let gaussians = random_gaussians(seed, &options);
        // Sizes that are no multiples of a tile, and one of a single pixel.
        let (width, height) =
            [(48, 40), (33, 65), (1, 1), (17, 16), (64, 31), (100, 70)][seed as usize];
        let camera = random_camera(seed, width, height);
        let reference = Reference::new(&gaussians, &camera);
        let image = r.render(&gaussians, &camera).map_err(failed)?;
        is_image(&format!("seed {seed}"), &image, &reference, TOLERANCE)?;
        let share = reference.decided_share();
        ensure(seed == 2 || share > 0.5, || format!("seed {seed}: {share} of pixels are decided"))?;
    }
    Ok(())
}

/// A ball of scale s at depth z on the axis: alpha = o k exp(-r² / 2 v) with v = (f s / z)² + blur
/// and k = (f s / z)² / v.
pub(super) fn one_gaussian_has_its_closed_form(r: &mut dyn Rasteriser) -> Outcome {
    let (s, z, f, o) = (0.02_f64, 0.8_f64, 100.0_f64, 0.7_f64);
    let camera = on_axis(41, 31, f as f32);
    let gaussians = Gaussians {
        means_m: vec![[0.0, 0.0, z as f32]],
        scales_m: vec![[s as f32; 3]],
        rotations: vec![[0.1, 0.2, 0.3, 0.4]],
        opacities: vec![o as f32],
        colors: vec![[0.25, 0.5, 1.0]],
    };
    let image = r.render(&gaussians, &camera).map_err(failed)?;
    let sharp = (f * s / z).powi(2);
    let v = sharp + f64::from(BLUR_PX2);
    for (pixel, &got) in image.alpha.iter().enumerate() {
        let (x, y) = ((pixel % 41) as f64 - 20.0, (pixel / 41) as f64 - 15.0);
        let alpha = o * sharp / v * (-(x * x + y * y) / (2.0 * v)).exp();
        let expected = if alpha < 1.0 / 255.0 { 0.0 } else { alpha.min(f64::from(MOST_ALPHA)) };
        // Rounding of exponents up to 5.
        ensure((f64::from(got) - expected).abs() < 3e-6, || {
            format!("alpha of pixel {pixel} is {got}, expected {expected}")
        })?;
        let [red, green, blue] = image.color[pixel].map(f64::from);
        let off = [red - 0.25 * expected, green - 0.5 * expected, blue - expected];
        let depth = f64::from(image.depth_m[pixel]) - z * expected;
        ensure(off.iter().chain([&depth]).all(|x| x.abs() < 3e-6), || {
            format!("colour or depth of pixel {pixel} is off by {off:?}, {depth}")
        })?;
    }
    Ok(())
}

/// A camera at the origin that looks along z.
pub(super) fn on_axis(width: u32, height: u32, focal: f32) -> Camera {
    Camera {
        width,
        height,
        fx: focal,
        fy: focal,
        cx: (width - 1) as f32 / 2.0,
        cy: (height - 1) as f32 / 2.0,
        world_to_camera: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
    }
}

/// With different depths, which are sorted, not a bit changes.
pub(super) fn the_order_of_the_set_does_not_matter(r: &mut dyn Rasteriser) -> Outcome {
    let gaussians = random_gaussians(5, &SceneOptions { count: 300, ..SceneOptions::default() });
    let camera = random_camera(5, 70, 50);
    let bar = random_bar(5, &camera);
    // 7 and 300 have no common divisor.
    let order: Vec<usize> = (0..300).map(|i| (i * 7 + 3) % 300).collect();
    let shuffled = gaussians.select(&order);
    let image = r.render(&gaussians, &camera).map_err(failed)?;
    let gradients = r.gradients(&gaussians, &camera, &bar).map_err(failed)?;
    let other = r.render(&shuffled, &camera).map_err(failed)?;
    let others = r.gradients(&shuffled, &camera, &bar).map_err(failed)?;
    ensure(image == other, || "another order gives another image".into())?;
    for (to, &from) in order.iter().enumerate() {
        let same = gradients.means_m[from] == others.means_m[to]
            && gradients.scales_m[from] == others.scales_m[to]
            && gradients.rotations[from] == others.rotations[to]
            && gradients.opacities[from] == others.opacities[to]
            && gradients.colors[from] == others.colors[to];
        ensure(same, || format!("Gaussian {from} has other gradients as number {to}"))?;
    }
    Ok(())
}

pub(super) fn crops_are_parts_of_the_whole(r: &mut dyn Rasteriser) -> Outcome {
    let gaussians = random_gaussians(6, &SceneOptions { count: 200, ..SceneOptions::default() });
    let camera = random_camera(6, 90, 70);
    let whole = Reference::new(&gaussians, &camera);
    let image = r.render(&gaussians, &camera).map_err(failed)?;
    for [left, top, width, height] in [[0, 0, 90, 70], [13, 7, 40, 33], [60, 50, 30, 20]] {
        let crop = camera.crop(left, top, width, height);
        let part = r.render(&gaussians, &crop).map_err(failed)?;
        for pixel in 0..crop.pixel_count() {
            let (x, y) = (pixel as u32 % width + left, pixel as u32 / width + top);
            let at = (y * 90 + x) as usize;
            if !whole.is_decided(at) {
                continue;
            }
            let pairs = part.color[pixel].iter().zip(&image.color[at]);
            let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            // A shifted principal point rounds otherwise.
            ensure(f64::from(off) < TOLERANCE, || {
                format!("pixel ({x}, {y}) of the crop at ({left}, {top}) is off by {off}")
            })?;
        }
    }
    Ok(())
}

pub(super) fn repeats_are_identical(r: &mut dyn Rasteriser) -> Outcome {
    let gaussians = random_gaussians(7, &SceneOptions { count: 500, ..SceneOptions::default() });
    let other = random_gaussians(8, &SceneOptions::default());
    let camera = random_camera(7, 80, 60);
    let bar = random_bar(7, &camera);
    let image = r.render(&gaussians, &camera).map_err(failed)?;
    let gradients = r.gradients(&gaussians, &camera, &bar).map_err(failed)?;
    for repeat in 0..3 {
        r.render(&other, &camera).map_err(failed)?;
        let again = r.render(&gaussians, &camera).map_err(failed)?;
        ensure(again == image, || format!("repeat {repeat} gives another image"))?;
        let again = r.gradients(&gaussians, &camera, &bar).map_err(failed)?;
        let differs = arrays(&gradients).into_iter().zip(arrays(&again)).find(|(a, b)| a != b);
        ensure(differs.is_none(), || {
            format!("repeat {repeat} gives other gradients by {}", differs.map_or("", |d| d.0.0))
        })?;
    }
    Ok(())
}
