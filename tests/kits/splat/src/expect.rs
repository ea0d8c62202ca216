//! Comparisons whose failures state the expected and the actual values.

use bendtwin_splat::{GaussiansBar, Image};

use super::reference::Reference;

pub(super) type Outcome = Result<(), String>;

/// Fails with `message` unless `ok`.
pub(super) fn ensure(ok: bool, message: impl FnOnce() -> String) -> Outcome {
    if ok { Ok(()) } else { Err(message()) }
}

/// Fails unless all numbers of an image are finite.
pub(super) fn finite_image(what: &str, image: &Image) -> Outcome {
    let numbers = image.color.iter().flatten().chain(&image.alpha).chain(&image.depth_m);
    let ok = numbers.clone().all(|x| x.is_finite());
    ensure(ok, || format!("{what}: the image is not finite"))
}

/// Fails unless all numbers of gradients are finite.
pub(super) fn finite_bar(what: &str, bar: &GaussiansBar) -> Outcome {
    let ok = arrays(bar).iter().all(|(_, x)| x.iter().all(|x| x.is_finite()));
    ensure(ok, || format!("{what}: the gradients are not finite"))
}

/// Fails unless the image is the reference's within `tolerance` at the pixels that are decided.
/// Depths may be off by `tolerance` times the largest depth.
pub(super) fn is_image(what: &str, got: &Image, reference: &Reference, tolerance: f64) -> Outcome {
    let expected = reference.image();
    let far = expected.iter().map(|p| p[4]).fold(1.0, f64::max);
    ensure(got.alpha.len() == expected.len(), || {
        format!("{what}: {} pixels, expected {}", got.alpha.len(), expected.len())
    })?;
    for (i, pixel) in expected.iter().enumerate().filter(|(i, _)| reference.is_decided(*i)) {
        let [r, g, b] = got.color[i];
        let numbers = [r, g, b, got.alpha[i], got.depth_m[i]].map(f64::from);
        for (channel, (x, y)) in numbers.iter().zip(pixel).enumerate() {
            let most = if channel == 4 { tolerance * far } else { tolerance };
            ensure((x - y).abs() <= most, || {
                format!("{what}: channel {channel} of pixel {i} is {x:.7}, expected {y:.7}")
            })?;
        }
    }
    Ok(())
}

/// Names and numbers of the arrays of gradients.
pub(super) fn arrays(bar: &GaussiansBar) -> [(&'static str, Vec<f32>); 6] {
    [
        ("means", bar.means_m.iter().flatten().copied().collect()),
        ("scales", bar.scales_m.iter().flatten().copied().collect()),
        ("rotations", bar.rotations.iter().flatten().copied().collect()),
        ("opacities", bar.opacities.clone()),
        ("colours", bar.colors.iter().flatten().copied().collect()),
        ("screen", bar.screen.clone()),
    ]
}
