//! Judge of calibrations: whether intrinsics and poses are possible at all, each for itself.

use bendtwin_capture::raw::{Camera, Pose};

use super::{Assessment, Context, named};
use crate::{
    Code, Finding,
    thresholds::CalibrationThresholds,
    vector::{cross, dot, length},
};

pub(super) fn judge(context: &Context<'_>, assessment: &mut Assessment) {
    let recording = context.recording;
    let limits = &context.thresholds.calibration;
    for (index, camera) in recording.cameras.iter().enumerate() {
        let name = named(recording, index);
        assessment.findings.extend(intrinsics(camera, &name, limits).map(|f| f.cameras([index])));
        assessment.findings.extend(poses(camera, &name, limits).map(|f| f.cameras([index])));
    }
    assessment.findings.extend(uncalibrated(context));
    coinciding(context, assessment);
}

/// The finding for cameras without a pose, all together.
fn uncalibrated(context: &Context<'_>) -> Option<Finding> {
    let cameras = &context.recording.cameras;
    let without: Vec<usize> =
        (0..cameras.len()).filter(|&index| cameras[index].poses.is_empty()).collect();
    let message = match without.as_slice() {
        [] => return None,
        // It is no fault of single cameras.
        all if all.len() == cameras.len() => {
            let message = "the recording has no poses of its cameras";
            return Some(Finding::error(Code::NotCalibrated, message));
        }
        [one] => format!("{} has no pose", named(context.recording, *one)),
        some => format!("{} of {} cameras have no pose", some.len(), cameras.len()),
    };
    Some(Finding::error(Code::NotCalibrated, message).cameras(without))
}

fn intrinsics(camera: &Camera, name: &str, limits: &CalibrationThresholds) -> Option<Finding> {
    let i = &camera.intrinsics;
    let numbers = [i.fx, i.fy, i.cx, i.cy];
    if !numbers.iter().all(|x| x.is_finite()) || i.fx <= 0.0 || i.fy <= 0.0 {
        let message = format!(
            "{name} has focal lengths {} and {} and its principal point at ({}, {})",
            i.fx, i.fy, i.cx, i.cy
        );
        return Some(Finding::error(Code::IntrinsicsInvalid, message));
    }
    let (width, height) = (camera.width as f64, camera.height as f64);
    let plausible = limits.focal_widths.contains(&(i.fx / width))
        && limits.focal_ratio.contains(&(i.fx / i.fy))
        && limits.principal_share.contains(&(i.cx / width))
        && limits.principal_share.contains(&(i.cy / height));
    if plausible {
        return None;
    }
    let factor = 0.5 * (i.cx / (0.5 * width) + i.cy / (0.5 * height));
    let hint = if !limits.unscaled_principal.contains(&factor) {
        format!(" (do they belong to images {factor:.2} times as large?)")
    } else {
        String::new()
    };
    let message = format!(
        "{name} has a focal length of {:.0} x {:.0} px and its principal point at ({:.0}, {:.0}) in images of {} x {}{hint}",
        i.fx, i.fy, i.cx, i.cy, camera.width, camera.height
    );
    let finding = Finding::warning(Code::IntrinsicsImplausible, message);
    Some(finding.number("fx_px", i.fx).number("cx_px", i.cx).number("cy_px", i.cy))
}

fn poses(camera: &Camera, name: &str, limits: &CalibrationThresholds) -> Option<Finding> {
    let finite =
        |p: &Pose| p.rotation.iter().flatten().chain(&p.translation).all(|x| x.is_finite());
    if !camera.poses.iter().all(finite) {
        let message = format!("{name} has a pose with NaN or infinite numbers");
        return Some(Finding::error(Code::ExtrinsicsInvalid, message));
    }
    for (frame, pose) in camera.poses.iter().enumerate() {
        let [a, b, c] = pose.rotation;
        let skewed = [dot(a, b), dot(b, c), dot(a, c)]
            .iter()
            .any(|d| d.abs() > limits.max_rotation_error)
            || [a, b, c].iter().any(|row| (length(*row) - 1.0).abs() > limits.max_rotation_error);
        if skewed {
            let scale = length(a);
            let message =
                format!("the pose of {name} has rows of length {scale:.3} or not at right angles");
            return Some(Finding::error(Code::ExtrinsicsInvalid, message).frames([frame]));
        }
        if dot(cross(a, b), c) < 0.0 {
            let message =
                format!("the rotation of {name} is a mirror image (its determinant is -1)");
            return Some(Finding::error(Code::ExtrinsicsMirrored, message).frames([frame]));
        }
    }
    None
}

fn coinciding(context: &Context<'_>, assessment: &mut Assessment) {
    let limits = &context.thresholds.calibration;
    let cameras = &context.recording.cameras;
    for (b, second) in cameras.iter().enumerate() {
        let Some(pose) = second.poses.first() else { continue };
        let same = |first: &Camera| {
            first.poses.first().is_some_and(|other| {
                let apart = |(x, y): (&f64, &f64)| (x - y).abs() < limits.max_same_pose;
                let numbers = |p: &Pose| {
                    p.rotation.iter().flatten().chain(&p.translation).copied().collect::<Vec<_>>()
                };
                numbers(pose).iter().zip(&numbers(other)).all(apart)
            })
        };
        if let Some(a) = cameras.iter().take(b).position(same) {
            let (first, second) = (named(context.recording, a), named(context.recording, b));
            let message = format!("{first} and {second} stand at exactly the same place");
            assessment
                .findings
                .push(Finding::error(Code::CamerasCoincide, message).cameras([a, b]));
            // A copied calibration of many cameras is one finding.
            return;
        }
    }
}
