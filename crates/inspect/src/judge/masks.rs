//! Judge of masks that are missing, empty, inverted, overlapping, or that jump. Exchanged masks
//! need the other cameras: see `agreement::labels`.

use super::{Assessment, Context, named, paths::Path};
use crate::{
    Code, Finding,
    scan::{CameraScan, FrameStats, mask::MaskStats},
    statistics::{mean, median, share},
    vector::{Vector, distance, pixel_of, to_camera},
};

pub(super) fn judge(context: &Context<'_>, assessment: &mut Assessment) {
    for (index, scan) in context.scans.iter().enumerate() {
        if let Some(report) = assessment.cameras.get_mut(index) {
            let area = |patch: &Option<MaskStats>| patch.map(|p| p.area_px);
            report.object_px = scan.frames.iter().map(|g| area(&g.object)).collect();
            report.manipulator_px = scan.frames.iter().map(|g| area(&g.manipulator)).collect();
        }
    }
    let any = |has: fn(&FrameStats) -> bool| context.scans.iter().flat_map(|l| &l.frames).any(has);
    if !any(|g| g.color.is_some()) {
        return;
    }
    if !any(|g| g.object.is_some()) {
        let message = "no camera has a mask of the object";
        assessment.findings.push(Finding::error(Code::MasksMissing, message));
        return;
    }
    if let Some(finding) = not_followed(context) {
        assessment.findings.push(finding);
        return;
    }
    if !any(|g| g.object.is_some_and(|p| p.area_px > 0)) {
        let message = "the object's mask is empty in every frame of every camera";
        assessment.findings.push(Finding::error(Code::ObjectNotSeen, message));
    }
    forgotten(context, assessment);
    for (index, scan) in context.scans.iter().enumerate() {
        empty(context, index, scan, assessment);
        covering(context, index, scan, assessment);
        overlapping(context, index, scan, assessment);
        jumps(context, index, scan, assessment);
    }
    exchanged(context, assessment);
}

/// The finding that only a few images have masks, as clicks give them: the others have none at all, or
/// all but one frame have empty ones.
fn not_followed(context: &Context<'_>) -> Option<Finding> {
    let limits = &context.thresholds.masks;
    let has_mask = |g: &&FrameStats| g.object.is_some() || g.manipulator.is_some();
    let count = |scan: &CameraScan| scan.frames.iter().filter(has_mask).count();
    let most = context.scans.iter().map(count).max()?;
    let seen = |scan: &CameraScan| scan.frames.iter().filter(|g| g.color.is_some()).count();
    let images = context.scans.iter().map(seen).max()?;
    let shows = |g: &FrameStats| g.object.is_some_and(|p| p.area_px > 0);
    let frames = 0..context.recording.frame_count;
    let shown =
        frames.filter(|f| context.scans.iter().any(|s| s.frames.get(*f).is_some_and(shows)));
    let is_one = images >= limits.min_followed_frames && shown.take(2).count() == 1;
    if most == 0 || (share(most, images) > limits.min_masked_share && !is_one) {
        return None;
    }
    let first =
        context.scans.iter().filter_map(|scan| scan.frames.iter().position(|g| has_mask(&g)));
    let first = first.min().unwrap_or_default();
    let message = match most {
        _ if is_one => {
            format!("each camera has masks of one frame alone (frame {first}), of {images} images")
        }
        _ => format!(
            "each camera has masks of at most {most} of {images} images, from frame {first} on"
        ),
    };
    Some(Finding::error(Code::MasksNotFollowed, message).number("images", most as f64))
}

/// The hand is not seen. An object that is lifted or pushed by nothing cannot be fitted; one that
/// falls or swings can.
fn forgotten(context: &Context<'_>, assessment: &mut Assessment) {
    // Grippers whose poses were recorded need no masks.
    if !context.recording.grippers.is_empty() {
        return;
    }
    let hands = || context.scans.iter().flat_map(|l| &l.frames).filter_map(|g| g.manipulator);
    if hands().any(|hand| hand.depth_px > 0) {
        return;
    }
    let why = if hands().next().is_none() {
        "no camera has a mask of a hand or gripper"
    } else if hands().all(|hand| hand.area_px == 0) {
        "the masks of the hand or gripper are empty in every frame of every camera"
    } else {
        "no mask of a hand or gripper has a pixel with depth"
    };
    let limits = &context.thresholds.masks;
    let carried = carried_m(context).filter(|m| *m > limits.carried_m);
    let but = carried.map_or(String::new(), |metres| {
        format!(", but the object is moved by {:.0} mm", 1e3 * metres)
    });
    let message = format!("{why}{but}");
    let finding = Finding::graded(carried.is_some(), Code::ManipulatorNotSeen, message);
    assessment.findings.push(finding.number("carried_mm", 1e3 * carried.unwrap_or(f64::NAN)));
}

/// How far an object is moved in ways that gravity does not explain: along the ground, or up from
/// where it was at first [m].
fn carried_m(context: &Context<'_>) -> Option<f64> {
    let upright = context.upright;
    median(context.paths.object.iter().filter_map(|path| {
        let start = *path.iter().flatten().next()?;
        let carried = |at: &Vector| {
            let rise = upright.height(*at) - upright.height(start);
            let aside = (distance(*at, start).powi(2) - rise.powi(2)).max(0.0).sqrt();
            aside.max(rise)
        };
        path.iter().flatten().map(carried).max_by(f64::total_cmp)
    }))
}

/// Judges labels that are exchanged from some frame on: object and hand jump to each other's place.
fn exchanged(context: &Context<'_>, assessment: &mut Assessment) {
    let limits = &context.thresholds.masks;
    let mut found: Vec<(usize, usize)> = Vec::new();
    for (index, scan) in context.scans.iter().enumerate() {
        let Some(camera) = context.recording.cameras.get(index) else { continue };
        let least_px = limits.min_exchange_widths * camera.width as f64;
        let middles = |g: &FrameStats| {
            let shown = |m: Option<MaskStats>| m.filter(|m| m.area_px > 0).map(|m| m.middle_px);
            Some([shown(g.object)?, shown(g.manipulator)?])
        };
        let apart = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
        let pairs = scan.frames.iter().zip(scan.frames.iter().skip(1)).enumerate();
        for (frame, (before, now)) in pairs {
            let (Some(before), Some(now)) = (middles(before), middles(now)) else { continue };
            let kept = apart(before[0], now[0]) + apart(before[1], now[1]);
            let crossed = apart(before[0], now[1]) + apart(before[1], now[0]);
            if kept > least_px && crossed < limits.max_exchange_ratio * kept {
                found.push((index, frame + 1));
            }
        }
    }
    let Some((_, first)) = found.iter().min_by_key(|(_, frame)| *frame).copied() else { return };
    let mut cameras: Vec<usize> = found.iter().map(|(camera, _)| *camera).collect();
    cameras.dedup();
    let names: Vec<String> = cameras.iter().map(|c| named(context.recording, *c)).collect();
    let message = format!(
        "in {}, the masks of object and hand change places from frame {first} on: their numbers are exchanged",
        names.join(", ")
    );
    let frames = found.iter().map(|(_, frame)| *frame);
    let finding = Finding::error(Code::MasksSwapped, message).cameras(cameras).frames(frames);
    assessment.findings.push(finding);
}

fn empty(context: &Context<'_>, index: usize, scan: &CameraScan, assessment: &mut Assessment) {
    let limits = &context.thresholds.masks;
    let lacks = |g: &FrameStats| g.color.is_some() && g.object.is_none_or(|p| p.area_px == 0);
    let frames: Vec<usize> =
        scan.frames.iter().enumerate().filter(|(_, g)| lacks(g)).map(|(f, _)| f).collect();
    let seen = scan.frames.iter().filter(|g| g.color.is_some()).count();
    let (outside, frames): (Vec<usize>, Vec<usize>) =
        frames.into_iter().partition(|frame| is_out_of_view(context, index, *frame));
    if !outside.is_empty() {
        let message = format!(
            "the object is out of view of {} in {} of {seen} frames",
            named(context.recording, index),
            outside.len()
        );
        assessment.findings.push(
            Finding::info(Code::ObjectOutOfView, message)
                .cameras([index])
                .frames(outside.iter().copied())
                .number("outside_share", share(outside.len(), seen)),
        );
    }
    if !frames.is_empty() {
        let part = share(frames.len(), seen);
        let message = format!(
            "the object's mask of {} is empty or missing in {} of {seen} frames ({:.0} %)",
            named(context.recording, index),
            frames.len(),
            100.0 * part
        );
        let others = context.scans.iter().enumerate().any(|(other, scan)| {
            other != index && scan.frames.iter().any(|g| g.object.is_some_and(|p| p.area_px > 0))
        });
        assessment.findings.push(
            Finding::graded(
                part > limits.max_empty_share && !others,
                Code::ObjectMaskEmpty,
                message,
            )
            .cameras([index])
            .frames(frames.iter().copied())
            .number("empty_share", part),
        );
    }
    if let Some(report) = assessment.cameras.get_mut(index) {
        report.empty_masks = frames;
    }
}

/// True if the other cameras see the object where this one does not look.
fn is_out_of_view(context: &Context<'_>, index: usize, frame: usize) -> bool {
    let Some(camera) = context.recording.cameras.get(index) else { return false };
    let seen = |other: usize, path: &Path| {
        let at = if other == index { None } else { *path.get(frame)? }?;
        Some(at)
    };
    let places: Vec<Vector> =
        context.paths.object.iter().enumerate().filter_map(|(i, path)| seen(i, path)).collect();
    let margin = context.thresholds.masks.view_margin;
    let is_outside = |at: &Vector| {
        pixel_of(camera, to_camera(camera.pose(frame), *at)).is_none_or(|[x, y]| {
            let (width, height) = (camera.width as f64, camera.height as f64);
            let inside = |at: f64, size: f64| at > margin * size && at < (1.0 - margin) * size;
            !(inside(x, width) && inside(y, height))
        })
    };
    !places.is_empty() && places.iter().all(is_outside)
}

fn covering(context: &Context<'_>, index: usize, scan: &CameraScan, assessment: &mut Assessment) {
    let limits = &context.thresholds.masks;
    let Some(camera) = context.recording.cameras.get(index) else { return };
    let pixels = (camera.width * camera.height).max(1) as f64;
    type Which = fn(&FrameStats) -> Option<MaskStats>;
    let masks: [(&str, Which); 2] = [("object", |g| g.object), ("manipulator", |g| g.manipulator)];
    for (what, which) in masks {
        let covered =
            median(scan.frames.iter().filter_map(which).map(|p| p.area_px as f64 / pixels));
        let Some(covered) = covered.filter(|c| *c > limits.max_covered_share) else { continue };
        let message = format!(
            "the {what}'s mask of {} covers {:.0} % of the image",
            named(context.recording, index),
            100.0 * covered
        );
        assessment.findings.push(
            Finding::error(Code::MaskCoversImage, message)
                .cameras([index])
                .number("covered_share", covered),
        );
    }
}

fn overlapping(
    context: &Context<'_>,
    index: usize,
    scan: &CameraScan,
    assessment: &mut Assessment,
) {
    let limits = &context.thresholds.masks;
    let part = |g: &FrameStats| {
        let smaller = g.object?.area_px.min(g.manipulator?.area_px);
        (smaller > 0).then(|| share(g.overlap_px, smaller))
    };
    let Some(part) =
        median(scan.frames.iter().filter_map(part)).filter(|p| *p > limits.max_overlap_share)
    else {
        return;
    };
    let message = format!(
        "{:.0} % of the smaller mask of {} belong to both object and manipulator",
        100.0 * part,
        named(context.recording, index)
    );
    let finding = Finding::warning(Code::MasksOverlap, message);
    assessment.findings.push(finding.cameras([index]).number("overlap_share", part));
}

fn jumps(context: &Context<'_>, index: usize, scan: &CameraScan, assessment: &mut Assessment) {
    let limits = &context.thresholds.masks;
    let Some(camera) = context.recording.cameras.get(index) else { return };
    let small = limits.min_area_share * (camera.width * camera.height) as f64;
    // Empty masks have a separate finding.
    let shown: Vec<Option<(f64, bool)>> = scan
        .frames
        .iter()
        .map(|g| g.object.filter(|o| o.area_px > 0).map(|o| (o.area_px as f64, o.at_border)))
        .collect();
    let areas: Vec<Option<f64>> = shown.iter().map(|s| s.map(|(area, _)| area)).collect();
    // How much the area grows from one frame to the next. The smaller one at the border is that of an
    // object that leaves the view.
    let growth = |frame: usize| {
        let (before, now) = ((*shown.get(frame.checked_sub(1)?)?)?, (*shown.get(frame)?)?);
        let smaller = if before.0 < now.0 { before } else { now };
        (!smaller.1).then(|| now.0.ln() - before.0.ln())
    };
    let mut frames = Vec::new();
    let mut worst = 1.0_f64;
    for frame in 1..areas.len() {
        let Some(own) = growth(frame) else { continue };
        let larger = areas[frame - 1].unwrap_or(0.0).max(areas[frame].unwrap_or(0.0));
        // What turns fast changes its area for several frames, one way until it shows its edge and back
        // after that. A mask that flickers changes to and fro, and a single bad one once.
        let steady = mean([frame - 1, frame + 1].into_iter().filter_map(growth)).unwrap_or(0.0);
        let [before, after] = [[frame.saturating_sub(2), frame - 1], [frame + 1, frame + 2]];
        let way = |sides: [usize; 2]| mean(sides.into_iter().filter_map(growth)).unwrap_or(0.0);
        let one_way = way(before).abs().max(way(after).abs());
        let sizes = before.into_iter().chain(after).filter_map(growth).map(f64::abs);
        let turning = one_way.min(median(sizes).unwrap_or(0.0)).min(limits.max_turn_ratio.ln());
        let jumps = (own.abs() - turning).min((own - steady).abs());
        if larger >= small && jumps > limits.max_area_ratio.ln() {
            frames.push(frame);
            worst = worst.max(own.abs().exp());
        }
    }
    if !frames.is_empty() {
        let message = format!(
            "the area of the object's mask of {} jumps in {} frame{}, by a factor of up to {worst:.1}",
            named(context.recording, index),
            frames.len(),
            if frames.len() == 1 { "" } else { "s" }
        );
        assessment.findings.push(
            Finding::warning(Code::MaskJumps, message)
                .cameras([index])
                .frames(frames.iter().copied())
                .number("largest_factor", worst),
        );
    }
    if let Some(report) = assessment.cameras.get_mut(index) {
        report.mask_jumps = frames;
    }
}
