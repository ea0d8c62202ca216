//! Findings about masks: parts that look alike, and where the result is doubtful.

use std::collections::BTreeSet;

use bendtwin_core::Finding;

use crate::{
    looks::Looks,
    part::{BACKGROUND, HAND, OBJECT},
};

/// Share of colours in common from which two parts look alike. Made recordings with parts of
/// different colours have at most 0.3, those with one colour for both from 0.5.
const ALIKE: f32 = 0.45;
/// Doubt from which an image is doubtful.
const DOUBTFUL: f32 = 0.25;
/// Share of a camera's images that may be doubtful without a finding.
const FEW: f64 = 0.05;

const GUIDE: &str = "docs/use/cameras.md#masks";

/// Parts that look alike in the first labelled frame. `touching` says whether object and
/// hand touch, `on_table` whether the object lies on the table.
pub(crate) fn alike(looks: &Looks, has_hand: bool, touching: bool, on_table: bool) -> Vec<Finding> {
    let mut findings = Vec::new();
    if has_hand {
        let common = f64::from(looks.likeness(OBJECT, HAND));
        if common > f64::from(ALIKE) && touching {
            let message = format!(
                "object and hand look alike and touch: {:.0} % of their colours are the same, so that their border is a guess",
                100.0 * common
            );
            let advice = format!(
                "record with a glove of another colour, mark both near their border in more frames, or bring masks of another \
                 tool ({GUIDE})"
            );
            findings.push(
                Finding { advice, ..Finding::warning("MASKS_INSEPARABLE", message) }
                    .number("common_colours", common),
            );
        }
    } else {
        let message = "no stroke marks a hand or gripper".to_owned();
        let advice = format!("click on what moves the object ({GUIDE})");
        findings.push(Finding { advice, ..Finding::warning("HAND_NOT_MARKED", message) });
    }
    let common = f64::from(looks.likeness(OBJECT, BACKGROUND));
    if common > f64::from(ALIKE) && on_table {
        let message = format!(
            "the object looks like the table on which it lies: {:.0} % of their colours are the same, so that its rim \
             there is a guess",
            100.0 * common
        );
        let advice = format!(
            "record on a table of another colour, or lay a cloth under the object ({GUIDE})"
        );
        findings.push(
            Finding { advice, ..Finding::warning("OBJECT_LIKE_TABLE", message) }
                .number("common_colours", common),
        );
    }
    findings
}

/// Images whose masks are doubtful.
pub(crate) fn doubtful(names: &[String], doubt: &[Vec<Option<f32>>]) -> Option<Finding> {
    let mut cameras = Vec::new();
    let mut frames = BTreeSet::new();
    for (camera, doubt) in doubt.iter().enumerate() {
        let bad: Vec<usize> =
            (0..doubt.len()).filter(|t| doubt[*t].is_some_and(|d| d > DOUBTFUL)).collect();
        let known = doubt.iter().flatten().count();
        if bad.len() as f64 > FEW * known as f64 {
            cameras.push((camera, bad.len(), known));
            frames.extend(bad);
        }
    }
    let each: Vec<String> = cameras
        .iter()
        .map(|(camera, bad, known)| format!("{} in {bad} of {known} frames", names[*camera]))
        .collect();
    let message = format!("masks are doubtful of camera {}", each.join(", "));
    let advice = format!("look at these frames and mark what is wrong ({GUIDE})");
    let finding = Finding { advice, ..Finding::warning("MASKS_DOUBTFUL", message) };
    let finding = finding.cameras(cameras.iter().map(|(camera, ..)| *camera)).frames(frames);
    (!cameras.is_empty()).then_some(finding)
}

/// Frames in which no camera shows the object, or a hand that was marked.
pub(crate) fn lost(what: &str, code: &str, seen: &[bool]) -> Option<Finding> {
    let lost: Vec<usize> = (0..seen.len()).filter(|t| !seen[*t]).collect();
    let (first, last) = (lost.first()?, lost.last()?);
    let message =
        format!("no camera shows the {what} in {} frames from {first} to {last}", lost.len());
    let advice = format!("if it is there, mark it in one of these frames ({GUIDE})");
    Some(Finding { advice, ..Finding::warning(code, message) }.frames(lost.iter().copied()))
}
