//! Judge of sizes, heights and the up axis.

use super::{Assessment, Context};
use crate::{
    Finding,
    scan::{
        FrameStats,
        mask::{MaskStats, Surface},
    },
    statistics::median,
    vector::{dot, wide},
};

/// Sizes of things that hands move [m].
pub(super) const OBJECT_M: std::ops::RangeInclusive<f64> = 0.01..=3.0;
/// So much lower than the ground, the object is not by noise [m].
const BELOW_M: f64 = 0.02;
/// Share of points below the ground that is no noise, and that makes the ground useless.
const BELOW: [f64; 2] = [0.02, 0.3];
/// An object that never comes nearer does not need the ground [m].
const ABOVE_M: f64 = 0.5;

pub(super) fn judge(context: &Context<'_>, assessment: &mut Assessment) {
    let object = size(context, |g| g.object.as_ref());
    let hand = size(context, |g| g.manipulator.as_ref());
    assessment.scene.object_size_m = object;
    assessment.scene.manipulator_size_m = hand;
    if let Some(size) = object {
        sizes(size, hand, assessment);
    }
    heights(context, assessment);
}

fn surfaces<'a>(
    context: &'a Context<'_>,
    which: fn(&FrameStats) -> Option<&MaskStats>,
) -> impl Iterator<Item = Surface> + 'a {
    context.scans.iter().flat_map(|scan| &scan.frames).filter_map(move |g| which(g)?.surface)
}

/// The median extent of a thing over frames and cameras [m].
fn size(context: &Context<'_>, which: fn(&FrameStats) -> Option<&MaskStats>) -> Option<f64> {
    median(surfaces(context, which).map(|s| s.extent_m))
}

fn sizes(size: f64, hand: Option<f64>, assessment: &mut Assessment) {
    let and_hand = match hand {
        Some(hand) if hand > 1.0 => format!(", the hand {hand:.1} m"),
        Some(hand) => format!(", the hand {:.1} mm", 1e3 * hand),
        None => String::new(),
    };
    let (code, message) = if size > *OBJECT_M.end() {
        ("SCALE_TOO_LARGE", format!("the object is {size:.1} m large{and_hand}"))
    } else if size < *OBJECT_M.start() {
        ("SCALE_TOO_SMALL", format!("the object is {:.2} mm large{and_hand}", 1e3 * size))
    } else {
        return;
    };
    let finding = Finding::error(code, message).number("object_size_m", size);
    assessment.findings.push(finding.number("manipulator_size_m", hand.unwrap_or(f64::NAN)));
}

fn heights(context: &Context<'_>, assessment: &mut Assessment) {
    let upright = context.upright;
    if !upright.grounded {
        return;
    }
    let object = |g: &FrameStats| g.object.and_then(|p| p.surface);
    let frames = context.recording.frame_count;
    // A frame's lowest point by the median of its cameras, since one flying pixel is no ground.
    let low = (0..frames).filter_map(|f| {
        median(context.scans.iter().filter_map(|scan| Some(object(scan.frames.get(f)?)?.low_m)))
    });
    let Some(lowest) = low.min_by(f64::total_cmp) else { return };
    assessment.scene.lowest_m = Some(lowest);
    let below = median(surfaces(context, |g| g.object.as_ref()).map(|s| s.below)).unwrap_or(0.0);
    let highest = median(surfaces(context, |g| g.object.as_ref()).map(|s| s.high_m)).unwrap_or(0.0);

    let cameras: Vec<_> =
        context.recording.cameras.iter().filter(|c| !c.poses.is_empty()).collect();
    let under = cameras.iter().filter(|c| upright.height(c.pose(0).translation) < 0.0).count();
    // Where images are upright, down in the image is down in the world.
    let down = median(cameras.iter().map(|c| -dot(c.pose(0).rotation.map(|r| r[1]), upright.up)));
    let upside_down = down.is_some_and(|d| d < -0.2);
    if (under == cameras.len() && highest < BELOW_M) || (upside_down && below > BELOW[1]) {
        let message = format!(
            "{under} of {} cameras stand below the ground, and {:.0} % of the object lie below it: the world is upside down",
            cameras.len(),
            100.0 * below
        );
        assessment
            .findings
            .push(Finding::error("UP_AXIS_WRONG", message).number("share_below", below));
        return;
    }
    let gravity = wide(context.recording.environment.gravity);
    let along = dot(gravity, upright.up);
    if along > 0.0 {
        let message = "gravity points away from the ground";
        assessment.findings.push(Finding::error("UP_AXIS_WRONG", message));
        return;
    }
    let worst = surfaces(context, |g| g.object.as_ref()).map(|s| s.below).max_by(f64::total_cmp);
    if below > BELOW[0] || (lowest < -2.0 * BELOW_M && worst.is_some_and(|w| w > 0.1)) {
        let message = format!(
            "{:.0} % of the object's points lie more than {:.0} mm below the ground, the lowest at {:.0} mm",
            100.0 * below,
            1e3 * BELOW_M,
            1e3 * lowest
        );
        assessment.findings.push(
            Finding::graded(below > BELOW[1], "BELOW_GROUND", message)
                .number("share_below", below)
                .number("lowest_mm", 1e3 * lowest),
        );
    } else if lowest > ABOVE_M {
        let message = format!("the object never comes nearer to the ground than {lowest:.2} m");
        let finding = Finding::info("OBJECT_ABOVE_GROUND", message);
        assessment.findings.push(finding.number("lowest_m", lowest));
    }
}
