//! Exchanged masks: where two cameras measure one spot, both must call it the same.

use super::super::{Case, Record, named};
use crate::{
    Finding,
    agree::{Court, setup::Setup},
    statistics::share,
};

/// Spots that a verdict needs.
const LEAST: usize = 40;
/// Share of spots that two cameras may call differently.
const DIFFERENT: f64 = 0.5;
/// A hand so much larger than the object that it carries is the object.
const LARGER: f64 = 1.6;
/// By so much the object's lowest point is higher than the hand's, at least [m].
const HIGHER_M: f64 = 0.02;

pub(super) fn judge(case: &Case<'_>, court: &Court<'_>, setup: &Setup, record: &mut Record) {
    let n = court.witnesses.len();
    let mut different = vec![vec![None; n]; n];
    for (a, row) in different.iter_mut().enumerate() {
        for (b, entry) in row.iter_mut().enumerate().filter(|(b, _)| *b != a) {
            let labels = court.hear(a, b, setup).labels;
            let all: usize = labels.iter().flatten().sum();
            *entry = (all >= LEAST).then(|| share(labels[0][1] + labels[1][0], all));
        }
    }
    let odd = |which: usize, others_too: bool| {
        let known = different[which].iter().enumerate().filter_map(|(b, d)| Some((b, (*d)?)));
        let votes: Vec<bool> = known.map(|(_, d)| d > DIFFERENT).collect();
        let against = votes.iter().filter(|v| **v).count();
        if others_too { against > 0 } else { 2 * against > votes.len() }
    };
    let mut cameras: Vec<usize> = (0..n).filter(|w| odd(*w, false)).collect();
    if cameras.is_empty() && n == 2 {
        cameras = (0..n).filter(|w| odd(*w, true)).collect();
    }
    let cameras: Vec<usize> = cameras.into_iter().map(|w| court.witnesses[w].index).collect();
    if !cameras.is_empty() {
        let names: Vec<String> = cameras.iter().map(|c| named(case.recording, *c)).collect();
        let which = if n == 2 { "one of " } else { "" };
        let message = format!(
            "{which}{} call{} the hand what the other cameras call the object",
            names.join(" and "),
            if cameras.len() == 1 { "s" } else { "" }
        );
        record.findings.push(Finding::error("MASKS_SWAPPED", message).cameras(cameras));
        return;
    }
    everywhere(case, record);
}

/// If all cameras exchange the masks they agree; but then a large limp thing carries a small one from below.
fn everywhere(case: &Case<'_>, record: &mut Record) {
    let (Some(object), Some(hand)) = (record.scene.object_size_m, record.scene.manipulator_size_m)
    else {
        return;
    };
    let lowest = |which: fn(&crate::watch::Glance) -> Option<crate::watch::patch::Patch>| {
        let first = |log: &crate::watch::Log| {
            log.glances.iter().find_map(|g| Some(which(g)?.surface?.low_m))
        };
        crate::statistics::median(case.logs.iter().filter_map(first))
    };
    let (Some(low), Some(hand_low)) = (lowest(|g| g.object), lowest(|g| g.manipulator)) else {
        return;
    };
    if hand > LARGER * object && low > hand_low + HIGHER_M {
        let message = format!(
            "the hand ({:.0} mm) is larger than the object ({:.0} mm) and lies below it: it seems that the masks are exchanged in \
             all cameras",
            1e3 * hand,
            1e3 * object
        );
        record.findings.push(Finding::warning("MASKS_SWAPPED", message));
    }
}
