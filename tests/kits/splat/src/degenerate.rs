//! Degenerate scenes: nothing to see, too much of it, no extent.

use bendtwin_splat::{
    Camera, Gaussians, GaussiansBar, Image, Rasteriser,
    constants::{MOST_ALPHA, NEAR_M},
};

use super::{
    expect::{Outcome, arrays, ensure, finite_bar, finite_image, is_image},
    images::on_axis,
    reference::Reference,
    scene::{SceneOptions, random_bar, random_camera, random_gaussians},
};

/// An image and gradients, finite and of the right sizes.
fn all(
    what: &str,
    r: &mut dyn Rasteriser,
    gaussians: &Gaussians,
    camera: &Camera,
) -> Result<(Image, GaussiansBar), String> {
    let failed = |e: bendtwin_splat::Error| format!("{what}: {e}");
    let image = r.render(gaussians, camera).map_err(failed)?;
    finite_image(what, &image)?;
    let pixels = camera.pixel_count();
    let lengths = [image.color.len(), image.alpha.len(), image.depth_m.len()];
    ensure(lengths == [pixels; 3], || format!("{what}: {lengths:?} pixels, not {pixels}"))?;
    let bar = r.gradients(gaussians, camera, &random_bar(1, camera)).map_err(failed)?;
    finite_bar(what, &bar)?;
    ensure(bar.len() == gaussians.len(), || format!("{what}: {} gradients", bar.len()))?;
    Ok((image, bar))
}

/// Fails unless nothing is seen, and nothing would change that.
fn is_black(what: &str, r: &mut dyn Rasteriser, gaussians: &Gaussians, camera: &Camera) -> Outcome {
    let (image, bar) = all(what, r, gaussians, camera)?;
    ensure(image == Image::black(camera.width, camera.height), || format!("{what}: not black"))?;
    let zero = arrays(&bar).iter().all(|(_, x)| x.iter().all(|x| *x == 0.0));
    ensure(zero, || format!("{what}: the gradients are not zero"))
}

pub(super) fn an_empty_set_is_black(r: &mut dyn Rasteriser) -> Outcome {
    is_black("no Gaussians", r, &Gaussians::default(), &random_camera(1, 40, 30))?;
    is_black("no Gaussians, one pixel", r, &Gaussians::default(), &on_axis(1, 1, 10.0))
}

pub(super) fn nothing_in_view_is_black(r: &mut dyn Rasteriser) -> Outcome {
    let mut gaussians = random_gaussians(40, &SceneOptions::default());
    gaussians.means_m.iter_mut().for_each(|m| m[2] += 1.0);
    for shift in [[20.0, 0.0], [-20.0, 0.0], [0.0, 20.0], [0.0, -20.0]] {
        let mut aside = gaussians.clone();
        aside.means_m.iter_mut().for_each(|m| {
            m[0] += shift[0];
            m[1] += shift[1];
        });
        is_black("beside the image", r, &aside, &on_axis(40, 30, 60.0))?;
    }
    gaussians.opacities.fill(0.003);
    is_black("too faint", r, &gaussians, &on_axis(40, 30, 60.0))
}

pub(super) fn behind_the_camera_is_black(r: &mut dyn Rasteriser) -> Outcome {
    let mut gaussians = random_gaussians(41, &SceneOptions::default());
    gaussians.means_m.iter_mut().for_each(|m| m[2] -= 1.0);
    is_black("behind", r, &gaussians, &on_axis(40, 30, 60.0))?;
    gaussians.means_m.iter_mut().for_each(|m| m[2] = 0.99 * NEAR_M);
    is_black("too near", r, &gaussians, &on_axis(40, 30, 60.0))?;
    gaussians.means_m.iter_mut().for_each(|m| *m = [0.0; 3]);
    is_black("in the camera", r, &gaussians, &on_axis(40, 30, 60.0))
}

pub(super) fn one_huge_gaussian_fills_the_image(r: &mut dyn Rasteriser) -> Outcome {
    let mut gaussians = random_gaussians(42, &SceneOptions { count: 1, ..SceneOptions::default() });
    gaussians.means_m[0] = [0.0, 0.0, 1.0];
    for (opacity, alpha) in [(0.5, 0.5), (1.0, MOST_ALPHA)] {
        gaussians.scales_m[0] = [100.0; 3];
        gaussians.opacities[0] = opacity;
        let camera = on_axis(150, 90, 100.0);
        let (image, _) = all("a huge Gaussian", r, &gaussians, &camera)?;
        // 1 % of a deviation from the centre at most.
        let off = image.alpha.iter().map(|a| (a - alpha).abs()).fold(0.0, f32::max);
        ensure(off < 1e-4, || format!("alpha of a huge Gaussian is off by {off}"))?;
    }
    Ok(())
}

/// Equal depths, so that ties go by index.
pub(super) fn thousands_in_one_pixel(r: &mut dyn Rasteriser) -> Outcome {
    let options = SceneOptions {
        count: 5_000,
        half_side_m: 0.0,
        scales_m: [0.001, 0.003],
        opacities: [0.01, 0.4],
    };
    let mut gaussians = random_gaussians(43, &options);
    gaussians.means_m.fill([0.001, 0.002, 1.0]);
    for faint in [1.0, 0.02] {
        gaussians.opacities.iter_mut().for_each(|o| *o = (*o * faint).max(0.005));
        let camera = on_axis(9, 7, 400.0);
        let (image, _) = all("a pile", r, &gaussians, &camera)?;
        // Rounding of sums over hundreds of Gaussians.
        is_image("a pile", &image, &Reference::new(&gaussians, &camera), 1e-3)?;
    }
    Ok(())
}

pub(super) fn degenerate_scales_stay_exact(r: &mut dyn Rasteriser) -> Outcome {
    let camera = random_camera(44, 48, 40);
    let thin = [[1e-6, 1e-6, 1e-6], [3e-5, 3e-5, 0.03], [0.03, 3e-5, 0.03], [1e-6, 0.01, 0.02]];
    for scales in thin {
        let mut gaussians = random_gaussians(
            44,
            &SceneOptions { opacities: [0.9, 1.0], ..SceneOptions::default() },
        );
        gaussians.scales_m.fill(scales);
        let what = format!("scales {scales:?}");
        let (image, _) = all(&what, r, &gaussians, &camera)?;
        is_image(&what, &image, &Reference::new(&gaussians, &camera), 1e-3)?;
    }
    let mut gaussians = random_gaussians(45, &SceneOptions::default());
    gaussians.scales_m.fill([f32::MIN_POSITIVE; 3]);
    is_black("no extent", r, &gaussians, &camera)
}

/// The largest numbers that are allowed, in every combination of places.
pub(super) fn absurd_numbers_stay_finite(r: &mut dyn Rasteriser) -> Outcome {
    let mut gaussians =
        random_gaussians(46, &SceneOptions { count: 64, ..SceneOptions::default() });
    for i in 0..64 {
        let size = |bit: usize, small: f32| if i & bit > 0 { 1e6 } else { small };
        gaussians.means_m[i] = [size(1, 0.1), -size(2, 0.1), size(4, 0.06)];
        gaussians.scales_m[i] = [size(8, 1e-20), size(16, 1e-3), size(32, 1e3)];
        gaussians.colors[i] = [size(1, -1e6), 0.0, 1.0];
        gaussians.rotations[i] = gaussians.rotations[i].map(|x| x * 0.4 * size(2, 1e-4));
    }
    for focal in [1e-3, 100.0, 1e6] {
        let mut camera = on_axis(40, 30, focal);
        let (image, _) = all("absurd numbers", r, &gaussians, &camera)?;
        let most = image.alpha.iter().copied().fold(0.0, f32::max);
        ensure(most <= 1.0, || format!("alpha is {most}"))?;
        camera.cx = 1e6;
        camera.cy = -1e6;
        all("absurd numbers, absurd principal point", r, &gaussians, &camera)?;
    }
    Ok(())
}
