//! Masks that are missing, empty, inverted, overlapping, or that jump. Whether masks are exchanged needs the other
//! cameras; see the agreement.

use super::{Case, Record, named};
use crate::{
    Finding,
    statistics::{median, share},
    watch::{Glance, Log, patch::Patch},
};

/// An area that changes by this factor from one frame to the next jumps.
const JUMP: f64 = 1.45;
/// Areas below this share of the image are too small for such a judgement.
const SMALL: f64 = 5e-4;
/// A mask that covers more of the image shows the background.
const MOST: f64 = 0.6;
/// Share of the smaller mask that may belong to both.
const OVERLAP: f64 = 0.1;
/// Share of frames without object from which a camera is of little use.
const MANY: f64 = 0.3;

pub(super) fn judge(case: &Case<'_>, record: &mut Record) {
    for (index, log) in case.logs.iter().enumerate() {
        if let Some(report) = record.cameras.get_mut(index) {
            let area = |patch: &Option<Patch>| patch.map(|p| p.area_px);
            report.object_px = log.glances.iter().map(|g| area(&g.object)).collect();
            report.manipulator_px = log.glances.iter().map(|g| area(&g.manipulator)).collect();
        }
    }
    let any = |has: fn(&Glance) -> bool| case.logs.iter().flat_map(|l| &l.glances).any(has);
    if !any(|g| g.color.is_some()) {
        return;
    }
    if !any(|g| g.object.is_some()) {
        let message = "no camera has a mask of the object";
        record.findings.push(Finding::error("MASKS_MISSING", message));
        return;
    }
    if !any(|g| g.object.is_some_and(|p| p.area_px > 0)) {
        let message = "the object's mask is empty in every frame of every camera";
        record.findings.push(Finding::error("OBJECT_NOT_SEEN", message));
    }
    if !any(|g| g.manipulator.is_some_and(|p| p.depth_px > 0)) {
        let message = "no camera sees a hand or gripper: its masks are missing or empty";
        record.findings.push(Finding::warning("MANIPULATOR_NOT_SEEN", message));
    }
    for (index, log) in case.logs.iter().enumerate() {
        empty(case, index, log, record);
        covering(case, index, log, record);
        overlapping(case, index, log, record);
        jumps(case, index, log, record);
    }
}

fn empty(case: &Case<'_>, index: usize, log: &Log, record: &mut Record) {
    let lacks = |g: &Glance| g.color.is_some() && g.object.is_none_or(|p| p.area_px == 0);
    let frames: Vec<usize> =
        log.glances.iter().enumerate().filter(|(_, g)| lacks(g)).map(|(f, _)| f).collect();
    let seen = log.glances.iter().filter(|g| g.color.is_some()).count();
    if !frames.is_empty() {
        let part = share(frames.len(), seen);
        let message = format!(
            "the object's mask of {} is empty or missing in {} of {seen} frames ({:.0} %)",
            named(case.recording, index),
            frames.len(),
            100.0 * part
        );
        let others = case.logs.iter().enumerate().any(|(other, log)| {
            other != index && log.glances.iter().any(|g| g.object.is_some_and(|p| p.area_px > 0))
        });
        record.findings.push(
            Finding::graded(part > MANY && !others, "OBJECT_MASK_EMPTY", message)
                .cameras([index])
                .frames(frames.iter().copied())
                .number("empty_share", part),
        );
    }
    if let Some(report) = record.cameras.get_mut(index) {
        report.empty_masks = frames;
    }
}

fn covering(case: &Case<'_>, index: usize, log: &Log, record: &mut Record) {
    let Some(camera) = case.recording.cameras.get(index) else { return };
    let pixels = (camera.width * camera.height).max(1) as f64;
    type Which = fn(&Glance) -> Option<Patch>;
    let masks: [(&str, Which); 2] = [("object", |g| g.object), ("manipulator", |g| g.manipulator)];
    for (what, which) in masks {
        let covered =
            median(log.glances.iter().filter_map(which).map(|p| p.area_px as f64 / pixels));
        let Some(covered) = covered.filter(|c| *c > MOST) else { continue };
        let message = format!(
            "the {what}'s mask of {} covers {:.0} % of the image",
            named(case.recording, index),
            100.0 * covered
        );
        record.findings.push(
            Finding::error("MASK_COVERS_IMAGE", message)
                .cameras([index])
                .number("covered_share", covered),
        );
    }
}

fn overlapping(case: &Case<'_>, index: usize, log: &Log, record: &mut Record) {
    let part = |g: &Glance| {
        let smaller = g.object?.area_px.min(g.manipulator?.area_px);
        (smaller > 0).then(|| share(g.overlap_px, smaller))
    };
    let Some(part) = median(log.glances.iter().filter_map(part)).filter(|p| *p > OVERLAP) else {
        return;
    };
    let message = format!(
        "{:.0} % of the smaller mask of {} belong to both object and manipulator",
        100.0 * part,
        named(case.recording, index)
    );
    let finding = Finding::warning("MASKS_OVERLAP", message);
    record.findings.push(finding.cameras([index]).number("overlap_share", part));
}

fn jumps(case: &Case<'_>, index: usize, log: &Log, record: &mut Record) {
    let Some(camera) = case.recording.cameras.get(index) else { return };
    let small = SMALL * (camera.width * camera.height) as f64;
    let areas: Vec<Option<f64>> =
        log.glances.iter().map(|g| g.object.map(|p| p.area_px as f64)).collect();
    let mut frames = Vec::new();
    let mut worst = 1.0_f64;
    let pairs = areas.iter().zip(areas.iter().skip(1)).enumerate();
    for (frame, (before, now)) in pairs {
        let (Some(before), Some(now)) = (before, now) else { continue };
        // Empty masks have a finding of their own.
        if before.min(*now) <= 0.0 || before.max(*now) < small {
            continue;
        }
        let ratio = (now / before).max(before / now);
        if ratio > JUMP {
            frames.push(frame + 1);
            worst = worst.max(ratio);
        }
    }
    if !frames.is_empty() {
        let message = format!(
            "the area of the object's mask of {} jumps in {} frame{}, by a factor of up to {worst:.1}",
            named(case.recording, index),
            frames.len(),
            if frames.len() == 1 { "" } else { "s" }
        );
        record.findings.push(
            Finding::warning("MASK_JUMPS", message)
                .cameras([index])
                .frames(frames.iter().copied())
                .number("largest_factor", worst),
        );
    }
    if let Some(report) = record.cameras.get_mut(index) {
        report.mask_jumps = frames;
    }
}
