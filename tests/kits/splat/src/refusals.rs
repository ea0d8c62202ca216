//! Wrong input: an immediate error that names the fault.

use bendtwin_splat::{Camera, Error, Gaussians, ImageBar, Rasteriser};

use super::{
    expect::{Outcome, ensure},
    images::on_axis,
    scene::{SceneOptions, random_bar, random_gaussians},
};

/// Fails unless both calls are refused with an error that has this text.
fn refused(
    what: &str,
    r: &mut dyn Rasteriser,
    gaussians: &Gaussians,
    camera: &Camera,
    text: &str,
) -> Outcome {
    let bar = ImageBar::zeros(camera.pixel_count().min(1 << 20));
    let errors =
        [r.render(gaussians, camera).map(|_| ()), r.gradients(gaussians, camera, &bar).map(|_| ())];
    for result in errors {
        let error = result.err().ok_or_else(|| format!("{what} was accepted"))?.to_string();
        ensure(error.contains(text), || format!("{what}: {error:?} does not say {text:?}"))?;
    }
    Ok(())
}

pub(super) fn wrong_gaussians_are_refused(r: &mut dyn Rasteriser) -> Outcome {
    let camera = on_axis(20, 10, 20.0);
    let sound = random_gaussians(50, &SceneOptions::default());
    for x in [f32::NAN, f32::INFINITY, -f32::INFINITY, f32::MAX] {
        let mut wrong = sound.clone();
        wrong.means_m[7][0] = x;
        refused("a mean", r, &wrong, &camera, "Gaussian 7 has a mean")?;
        let mut wrong = sound.clone();
        wrong.scales_m[39][2] = x;
        refused("a scale", r, &wrong, &camera, "Gaussian 39 has a scale")?;
        let mut wrong = sound.clone();
        wrong.rotations[0][3] = x;
        refused("a rotation", r, &wrong, &camera, "Gaussian 0 has a quaternion")?;
        let mut wrong = sound.clone();
        wrong.opacities[1] = x;
        refused("an opacity", r, &wrong, &camera, "Gaussian 1 has opacity")?;
        let mut wrong = sound.clone();
        wrong.colors[2][1] = x;
        refused("a colour", r, &wrong, &camera, "Gaussian 2 has a colour")?;
    }
    let mut wrong = sound.clone();
    wrong.scales_m[3][1] = 0.0;
    refused("a scale of zero", r, &wrong, &camera, "Gaussian 3 has a scale")?;
    let mut wrong = sound.clone();
    wrong.rotations[4] = [0.0; 4];
    refused("a rotation of zero", r, &wrong, &camera, "Gaussian 4 has a quaternion")?;
    let mut wrong = sound;
    wrong.opacities.pop();
    refused("a missing opacity", r, &wrong, &camera, "39 opacities")
}

pub(super) fn wrong_cameras_are_refused(r: &mut dyn Rasteriser) -> Outcome {
    let gaussians = random_gaussians(51, &SceneOptions::default());
    let sound = on_axis(20, 10, 20.0);
    let cases: [(&str, Camera); 8] = [
        ("width", Camera { width: 0, ..sound }),
        ("height", Camera { height: u32::MAX, ..sound }),
        ("pixels", Camera { width: 16_384, height: 16_384, ..sound }),
        ("fx", Camera { fx: 0.0, ..sound }),
        ("fy", Camera { fy: f32::NAN, ..sound }),
        ("cx", Camera { cx: f32::INFINITY, ..sound }),
        ("cy", Camera { cy: 1e9, ..sound }),
        ("world_to_camera", Camera { world_to_camera: [[1.0; 4]; 3], ..sound }),
    ];
    for (name, camera) in cases {
        refused(name, r, &gaussians, &camera, name)?;
    }
    Ok(())
}

pub(super) fn wrong_derivatives_are_refused(r: &mut dyn Rasteriser) -> Outcome {
    let gaussians = random_gaussians(52, &SceneOptions::default());
    let camera = on_axis(20, 10, 20.0);
    let mut short = random_bar(52, &camera);
    short.depth_m.pop();
    let mut infinite = random_bar(52, &camera);
    infinite.alpha[13] = f32::INFINITY;
    for (bar, text) in [(short, "199 derivatives by depth"), (infinite, "alpha of pixel 13")] {
        let error = r.gradients(&gaussians, &camera, &bar).err().map(|e| e.to_string());
        ensure(error.as_ref().is_some_and(|e| e.contains(text)), || {
            format!("{error:?} does not say {text:?}")
        })?;
    }
    Ok(())
}

/// Three hundred Gaussians, each over all 65,536 tiles.
pub(super) fn too_much_work_is_refused(r: &mut dyn Rasteriser) -> Outcome {
    let mut gaussians =
        random_gaussians(53, &SceneOptions { count: 300, ..SceneOptions::default() });
    for (scales, mean) in gaussians.scales_m.iter_mut().zip(&mut gaussians.means_m) {
        *scales = [100.0; 3];
        *mean = [0.0, 0.0, 1.0];
    }
    let camera = on_axis(4_096, 4_096, 1_000.0);
    match r.render(&gaussians, &camera) {
        Err(Error::TooMany { .. } | Error::OutOfMemory { .. }) => Ok(()),
        other => Err(format!("expected a refusal, came {:?}", other.map(|_| "an image"))),
    }
}
