//! Judge of sizes, heights and the up axis.

use super::{Assessment, Context};
use crate::{
    Code, Finding,
    scan::{
        FrameStats,
        mask::{MaskStats, Surface},
    },
    statistics::{mean, median},
    thresholds::ScaleThresholds,
    vector::dot,
};

pub(super) fn judge(context: &Context<'_>, assessment: &mut Assessment) {
    let object = size(context, |g| g.object.as_ref());
    let hand = size(context, |g| g.manipulator.as_ref());
    assessment.scene.object_size_m = object;
    assessment.scene.manipulator_size_m = hand;
    if let Some(size) = object {
        sizes(size, hand, &context.thresholds.scale, assessment);
    }
    assessment.findings.extend(bendtwin_capture::check_gravity(&context.recording.environment));
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

fn sizes(size: f64, hand: Option<f64>, limits: &ScaleThresholds, assessment: &mut Assessment) {
    let and_hand = match hand {
        Some(hand) if hand > 1.0 => format!(", the hand {hand:.1} m"),
        Some(hand) => format!(", the hand {:.1} mm", 1e3 * hand),
        None => String::new(),
    };
    let hand_is_large = hand.is_none_or(|hand| hand > limits.large_manipulator_m);
    let (code, message) = if size > *limits.object_size_m.end() {
        (Code::ScaleTooLarge, format!("the object is {size:.1} m large{and_hand}"))
    } else if size > limits.large_object_m && hand_is_large {
        let message = format!(
            "the object is {size:.1} m large{and_hand}: is depth in tenths of a millimetre, and the object {:.2} m large?",
            0.1 * size
        );
        assessment.findings.push(
            Finding::warning(Code::ScaleTooLarge, message)
                .number("object_size_m", size)
                .number("manipulator_size_m", hand.unwrap_or(f64::NAN)),
        );
        return;
    } else if size < *limits.object_size_m.start() {
        (Code::ScaleTooSmall, format!("the object is {:.2} mm large{and_hand}", 1e3 * size))
    } else {
        return;
    };
    let finding = Finding::error(code, message).number("object_size_m", size);
    assessment.findings.push(finding.number("manipulator_size_m", hand.unwrap_or(f64::NAN)));
}

fn heights(context: &Context<'_>, assessment: &mut Assessment) {
    let limits = &context.thresholds.scale;
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
    // Of all points in all frames, as the lifted points will be counted.
    let all_below = mean(surfaces(context, |g| g.object.as_ref()).map(|s| s.below)).unwrap_or(0.0);
    let highest = median(surfaces(context, |g| g.object.as_ref()).map(|s| s.high_m)).unwrap_or(0.0);

    let cameras: Vec<_> =
        context.recording.cameras.iter().filter(|c| !c.poses.is_empty()).collect();
    let under = cameras.iter().filter(|c| upright.height(c.pose(0).translation) < 0.0).count();
    // Where images are upright, down in the image is down in the world.
    let down = median(cameras.iter().map(|c| -dot(c.pose(0).rotation.map(|r| r[1]), upright.up)));
    let upside_down = down.is_some_and(|d| d < limits.upside_down_cosine);
    if (under == cameras.len() && highest < limits.below_m)
        || (upside_down && below > limits.bad_below_share)
    {
        let message = format!(
            "{under} of {} cameras stand below the ground, and {:.0} % of the object lie below it: the world is upside down",
            cameras.len(),
            100.0 * below
        );
        assessment
            .findings
            .push(Finding::error(Code::UpAxisWrong, message).number("share_below", below));
        return;
    }
    let worst = surfaces(context, |g| g.object.as_ref()).map(|s| s.below).max_by(f64::total_cmp);
    if below > limits.max_below_share
        || (lowest < -limits.deep_below_m && worst.is_some_and(|w| w > limits.deep_below_share))
    {
        let message = format!(
            "{:.0} % of the object's points lie more than {:.0} mm below the ground, the lowest at {:.0} mm",
            100.0 * all_below,
            1e3 * limits.below_m,
            1e3 * lowest
        );
        assessment.findings.push(
            Finding::graded(all_below > limits.bad_below_share, Code::BelowGround, message)
                .number("share_below", below)
                .number("lowest_mm", 1e3 * lowest),
        );
    } else if lowest > limits.max_height_m {
        let message = format!("the object never comes nearer to the ground than {lowest:.2} m");
        let finding = Finding::info(Code::ObjectAboveGround, message);
        assessment.findings.push(finding.number("lowest_m", lowest));
    }
}
