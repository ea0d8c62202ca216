//! Findings of mistakes with calibrations, in words.

use super::super::{Context, named};
use crate::{
    Code, Finding,
    consistency::{
        ViewSet,
        hypothesis::PoseChange,
        mistake::{Explanation, Mistake},
    },
    thresholds::AgreementThresholds,
};

/// The finding of a mistake that explains the misfit.
pub(super) fn finding(
    context: &Context<'_>,
    set: &ViewSet<'_>,
    found: &Explanation,
    object_size_m: Option<f64>,
) -> Finding {
    let index = |view: usize| set.views.get(view).map_or(view, |w| w.index);
    let finding = match &found.mistake {
        Mistake::All(PoseChange::Units(factor)) => units(context, 1.0 / factor, object_size_m),
        Mistake::Depth(factor) if is_unit(*factor, &context.thresholds.agreement) => {
            units(context, *factor, object_size_m)
        }
        Mistake::Depth(factor) => depth_of_all(*factor, true),
        Mistake::DepthOfOne(which, factor) => depth_of_one(context, set, *which, *factor, true),
        Mistake::All(change) => {
            let (code, fault) = pose_fault(*change);
            let message = format!("the cameras agree if {fault} of every pose is undone");
            Finding::error(code, message)
        }
        Mistake::One(which, change) => {
            let (code, fault) = pose_fault(*change);
            let name = named(context.recording, index(*which));
            let message = format!("{name} agrees with the others if {fault} of its pose is undone");
            Finding::error(code, message).cameras([index(*which)])
        }
        Mistake::Exchanged(order) => {
            let moved = order.iter().enumerate().filter(|(i, o)| i != *o).map(|(i, _)| index(i));
            let cameras: Vec<usize> = moved.collect();
            let parts: Vec<String> = order
                .iter()
                .enumerate()
                .filter(|(i, o)| i != *o)
                .map(|(i, o)| {
                    format!("camera {} with the calibration of camera {}", index(i), index(*o))
                })
                .collect();
            let message = format!("the cameras agree if they are exchanged: {}", parts.join(", "));
            Finding::error(Code::CamerasSwapped, message).cameras(cameras)
        }
    };
    finding.number("misfit_repaired", found.misfit)
}

fn pose_fault(change: PoseChange) -> (Code, &'static str) {
    match change {
        PoseChange::Inverse | PoseChange::None => (Code::ExtrinsicsInverted, "the inversion"),
        PoseChange::RotationInverse => {
            (Code::ExtrinsicsInverted, "the transposition of the rotation")
        }
        PoseChange::OpenGl => (Code::ExtrinsicsAxes, "OpenGL's axes (y up, z towards the viewer)"),
        PoseChange::Body => (Code::ExtrinsicsAxes, "a body's axes (x forward, y left, z up)"),
        PoseChange::InverseOpenGl => {
            (Code::ExtrinsicsInverted, "the inversion, with OpenGL's axes,")
        }
        PoseChange::Mirrored(_) => (Code::ExtrinsicsMirrored, "a mirrored axis"),
        PoseChange::MirroredPlace(_) => {
            (Code::ExtrinsicsMirrored, "the sign of one coordinate of the translation")
        }
        PoseChange::Units(_) => (Code::ExtrinsicsUnits, "the unit of the translation"),
    }
}

/// True for powers of ten, and for inches.
fn is_unit(factor: f64, limits: &AgreementThresholds) -> bool {
    let tolerance = limits.unit_log10_tolerance;
    let power = factor.log10();
    let is_power = power.abs() > limits.min_unit_log10 && (power - power.round()).abs() < tolerance;
    is_power || (power.abs() - 39.37_f64.log10()).abs() < tolerance
}

/// The finding of units that differ between depth and poses: depth times `factor` would suit the
/// poses. The size of the object, which follows from depth alone, decides which of the two is
/// wrong: the one without which it would be less usual.
fn units(context: &Context<'_>, factor: f64, object_size_m: Option<f64>) -> Finding {
    let times = if factor < 1.0 { 1.0 / factor } else { factor };
    let round = if times > 2.0 { format!("{times:.0}") } else { format!("{times:.2}") };
    let (small, large) =
        if factor < 1.0 { ("poses are", "depth") } else { ("depth is", "the poses") };
    let size = object_size_m.unwrap_or(f64::NAN);
    let usual = context.thresholds.scale.usual_object_m;
    let unusual = |size: f64| (size / usual).log10().abs();
    // NaN is not usual.
    let depth_is_right = unusual(size) <= unusual(size * factor);
    let (code, message) = if depth_is_right {
        let message = format!(
            "the cameras agree if {small} {round} times as large compared with {large}; by depth the object is \
             {size:.3} m large, as it may be, so that the poses are in other units"
        );
        (Code::ExtrinsicsUnits, message)
    } else {
        let message = format!(
            "the cameras agree if {small} {round} times as large compared with {large}; by depth the object is \
             {size:.3} m large, and {:.3} m if depth is in other units",
            size * factor
        );
        (Code::DepthUnits, message)
    };
    Finding::error(code, message).number("depth_factor", factor).number("object_size_m", size)
}

pub(super) fn depth_of_all(factor: f64, is_bad: bool) -> Finding {
    let message = format!(
        "the cameras agree if all depth is multiplied by {factor:.3}: it is {}",
        too(factor)
    );
    Finding::graded(is_bad, Code::DepthUnits, message).number("depth_factor", factor)
}

pub(super) fn depth_of_one(
    context: &Context<'_>,
    set: &ViewSet<'_>,
    which: usize,
    factor: f64,
    is_bad: bool,
) -> Finding {
    let index = set.views.get(which).map_or(which, |w| w.index);
    let message = format!(
        "{} agrees with the others if its depth is multiplied by {factor:.3}: it is {}",
        named(context.recording, index),
        too(factor)
    );
    Finding::graded(is_bad, Code::DepthScale, message)
        .cameras([index])
        .number("depth_factor", factor)
}

fn too(factor: f64) -> String {
    if factor < 1.0 {
        format!("{:.3} times too large", 1.0 / factor)
    } else {
        format!("{factor:.3} times too small")
    }
}
