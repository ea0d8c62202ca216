//! Judge of exchanged masks: where two cameras measure one spot, both must give it the same label.

use super::super::{Assessment, Context, named};
use crate::{
    Code, Finding,
    consistency::{ViewSet, hypothesis::Hypothesis},
    statistics::share,
};

pub(super) fn judge(
    context: &Context<'_>,
    set: &ViewSet<'_>,
    hypothesis: &Hypothesis,
    assessment: &mut Assessment,
) {
    let limits = &context.thresholds.labels;
    let n = set.views.len();
    let mut different = vec![vec![None; n]; n];
    for (a, row) in different.iter_mut().enumerate() {
        for (b, entry) in row.iter_mut().enumerate().filter(|(b, _)| *b != a) {
            let labels = set.reproject(a, b, hypothesis).labels;
            let all: usize = labels.iter().flatten().sum();
            *entry = (all >= limits.min_surfels).then(|| share(labels[0][1] + labels[1][0], all));
        }
    }
    let differs = |which: usize, others_too: bool| {
        let known = different[which].iter().enumerate().filter_map(|(b, d)| Some((b, (*d)?)));
        let votes: Vec<bool> = known.map(|(_, d)| d > limits.max_different_share).collect();
        let against = votes.iter().filter(|v| **v).count();
        if others_too { against > 0 } else { 2 * against > votes.len() }
    };
    let mut cameras: Vec<usize> = (0..n).filter(|w| differs(*w, false)).collect();
    if cameras.is_empty() && n == 2 {
        cameras = (0..n).filter(|w| differs(*w, true)).collect();
    }
    let cameras: Vec<usize> = cameras.into_iter().map(|w| set.views[w].index).collect();
    if !cameras.is_empty() {
        let names: Vec<String> = cameras.iter().map(|c| named(context.recording, *c)).collect();
        let which = if n == 2 { "one of " } else { "" };
        let message = format!(
            "{which}{} call{} the hand what the other cameras call the object",
            names.join(" and "),
            if cameras.len() == 1 { "s" } else { "" }
        );
        assessment.findings.push(Finding::error(Code::MasksSwapped, message).cameras(cameras));
        return;
    }
    exchanged_in_all(context, assessment);
}

/// Judges masks that are exchanged in all cameras, which agree with each other: then the hand is
/// larger than the object and lies below it.
fn exchanged_in_all(context: &Context<'_>, assessment: &mut Assessment) {
    let limits = &context.thresholds.labels;
    let (Some(object), Some(hand)) =
        (assessment.scene.object_size_m, assessment.scene.manipulator_size_m)
    else {
        return;
    };
    let lowest = |which: fn(&crate::scan::FrameStats) -> Option<crate::scan::mask::MaskStats>| {
        let first = |scan: &crate::scan::CameraScan| {
            scan.frames.iter().find_map(|g| Some(which(g)?.surface?.low_m))
        };
        crate::statistics::median(context.scans.iter().filter_map(first))
    };
    let (Some(low), Some(hand_low)) = (lowest(|g| g.object), lowest(|g| g.manipulator)) else {
        return;
    };
    if hand > limits.min_size_ratio * object && low > hand_low + limits.min_height_m {
        let message = format!(
            "the hand ({:.0} mm) is larger than the object ({:.0} mm) and lies below it: it seems that the masks are exchanged in \
             all cameras",
            1e3 * hand,
            1e3 * object
        );
        assessment.findings.push(Finding::warning(Code::MasksSwapped, message));
    }
}
