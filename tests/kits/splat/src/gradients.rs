//! Gradients: against central differences of the plain rasteriser, for a loss that is linear in all
//! channels of the image. Pixels where rounding can change a decision have no weight.

use bendtwin_splat::{Camera, Gaussians, Rasteriser};

use super::{
    expect::{Outcome, arrays, ensure, finite_bar},
    images::on_axis,
    reference::{COLOR, NUMBERS, Numbers, OPACITY, ROTATION, Reference, SCALE, SHIFT},
    scene::{SceneOptions, random_bar, random_camera, random_gaussians},
};

/// Error of a whole array relative to its length, from f32's rounding of distances of pixels and of
/// what stands behind a Gaussian.
const TOLERANCE: f64 = 1e-3;

/// Compares gradients of a scene with differences.
fn compare(
    what: &str,
    r: &mut dyn Rasteriser,
    gaussians: &Gaussians,
    camera: &Camera,
    tolerance: f64,
) -> Outcome {
    let reference = Reference::new(gaussians, camera);
    let share = reference.decided_share();
    ensure(share > 0.5, || format!("{what}: {share} of pixels are decided"))?;
    let mut bar = random_bar(17, camera);
    reference.mask(&mut bar);
    let got = r.gradients(gaussians, camera, &bar).map_err(|e| format!("{what}: {e}"))?;
    finite_bar(what, &got)?;
    let expected = reference.differences(&bar);
    let of = |first: usize, end: usize| -> Vec<f64> {
        expected.iter().flat_map(|n: &Numbers| n[first..end].to_vec()).collect()
    };
    let lengths = expected.iter().map(|n| n[SHIFT].hypot(n[SHIFT + 1])).collect();
    let all = [
        of(0, SCALE),
        of(SCALE, ROTATION),
        of(ROTATION, OPACITY),
        of(OPACITY, COLOR),
        of(COLOR, SHIFT),
        lengths,
    ];
    debug_assert_eq!(SHIFT + 2, NUMBERS);
    for ((name, got), expected) in arrays(&got).into_iter().zip(all) {
        ensure(got.len() == expected.len(), || format!("{what}: {} {name}", got.len()))?;
        let norm = |x: &mut dyn Iterator<Item = f64>| x.map(|x| x * x).sum::<f64>().sqrt();
        let size = norm(&mut expected.iter().copied());
        let off =
            norm(&mut got.iter().zip(&expected).map(|(got, expected)| f64::from(*got) - expected));
        let worst = got
            .iter()
            .zip(&expected)
            .enumerate()
            .max_by(|a, b| {
                let off = |(_, (x, y)): &(usize, (&f32, &f64))| (f64::from(**x) - **y).abs();
                off(a).total_cmp(&off(b))
            })
            .map(|(k, (x, y))| format!("number {k} is {x:.6e}, expected {y:.6e}"));
        ensure(off <= tolerance * size.max(1e-6), || {
            format!(
                "{what}: gradients by {name} are off by {:.2e} of {size:.3e}; {}",
                off / size,
                worst.unwrap_or_default()
            )
        })?;
    }
    Ok(())
}

pub(super) fn gradients_match_finite_differences(r: &mut dyn Rasteriser) -> Outcome {
    for seed in 20..24 {
        let gaussians = random_gaussians(seed, &SceneOptions::default());
        let camera = random_camera(seed, 48, 40);
        compare(&format!("seed {seed}"), r, &gaussians, &camera, TOLERANCE)?;
    }
    Ok(())
}

/// Scales in ratios up to 1000. Rows of their projection are nearly parallel, so that some digits
/// of their cross product are gone.
pub(super) fn gradients_of_needles_and_plates(r: &mut dyn Rasteriser) -> Outcome {
    let mut gaussians = random_gaussians(30, &SceneOptions::default());
    for (i, scales) in gaussians.scales_m.iter_mut().enumerate() {
        scales[i % 3] = 3e-5;
        if i % 2 == 0 {
            scales[(i + 1) % 3] = 3e-5 * 10.0_f32.powi(i as i32 % 4);
        }
        scales[(i + 2) % 3] = 0.03;
    }
    compare("needles and plates", r, &gaussians, &random_camera(30, 48, 40), 10.0 * TOLERANCE)
}

/// Pixels that close, with limited opacities.
pub(super) fn gradients_of_an_opaque_pile(r: &mut dyn Rasteriser) -> Outcome {
    let options = SceneOptions {
        count: 200,
        half_side_m: 0.05,
        scales_m: [0.01, 0.05],
        opacities: [0.5, 1.0],
    };
    let gaussians = random_gaussians(31, &options);
    compare("an opaque pile", r, &gaussians, &random_camera(31, 24, 20), 3.0 * TOLERANCE)
}

/// Centres out of the image and beyond the tangent of the linear projection.
pub(super) fn gradients_beside_the_image(r: &mut dyn Rasteriser) -> Outcome {
    let mut gaussians = random_gaussians(
        32,
        &SceneOptions { count: 12, scales_m: [0.1, 0.3], ..SceneOptions::default() },
    );
    for (i, mean) in gaussians.means_m.iter_mut().enumerate() {
        let side = if i % 2 == 0 { 1.0 } else { -1.0 };
        *mean = [side * (0.1 + 0.04 * i as f32), 0.02 * i as f32 - 0.1, 0.2 + 0.01 * i as f32];
    }
    compare("beside the image", r, &gaussians, &on_axis(40, 30, 60.0), TOLERANCE)
}

/// The same bits after a rendering and without one.
pub(super) fn gradients_stand_by_themselves(r: &mut dyn Rasteriser) -> Outcome {
    let failed = |e: bendtwin_splat::Error| e.to_string();
    let gaussians = random_gaussians(33, &SceneOptions::default());
    let other = random_gaussians(34, &SceneOptions::default());
    let camera = random_camera(33, 48, 40);
    let bar = random_bar(33, &camera);
    r.render(&gaussians, &camera).map_err(failed)?;
    let after = r.gradients(&gaussians, &camera, &bar).map_err(failed)?;
    r.render(&other, &camera).map_err(failed)?;
    let alone = r.gradients(&gaussians, &camera, &bar).map_err(failed)?;
    ensure(after == alone, || "gradients differ after a rendering".into())?;
    // Another camera, and one number of a Gaussian, make another rendering.
    let part = camera.crop(1, 1, 40, 30);
    let moved = r.gradients(&gaussians, &part, &random_bar(33, &part)).map_err(failed)?;
    ensure(moved != after, || "another camera gives the same gradients".into())?;
    let mut darker = gaussians.clone();
    darker.opacities.iter_mut().for_each(|o| *o *= 0.5);
    let changed = r.gradients(&darker, &camera, &bar).map_err(failed)?;
    ensure(changed != after, || "other Gaussians give the same gradients".into())
}
