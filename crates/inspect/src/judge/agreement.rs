//! Judge of multi-view consistency: whether the cameras agree; if not, which mistake with the
//! calibration explains it, or which camera is off and by how much.

mod labels;
mod mistakes;

use super::{Assessment, Context, named};
use crate::{
    Code, Finding,
    consistency::{
        ViewSet,
        correction::{Correction, correct},
        depth_scale,
        hypothesis::Hypothesis,
        mistake, views,
    },
    inspection::{Agreement, PairReport},
    statistics::{mean, median},
    thresholds::AgreementThresholds,
};

/// Findings with which cameras cannot agree under any calibration.
const NOT_COMPARABLE: [Code; 3] =
    [Code::DepthInverted, Code::DepthMisaligned, Code::MasksMisaligned];

pub(super) fn judge(context: &Context<'_>, assessment: &mut Assessment) {
    let limits = &context.thresholds.agreement;
    let mut set = ViewSet {
        views: views(&context.recording.cameras, context.scans, &context.thresholds.consistency),
        frames: Vec::new(),
        stride: 1,
        thresholds: &context.thresholds.consistency,
    };
    if set.views.len() < 2 {
        return;
    }
    set.frames = compared_frames(context, &set);
    let declared = Hypothesis::declared(set.views.len());
    let Some(misfit) = set.misfit(&declared) else { return };
    pairs(&set, &declared, assessment);
    if assessment.findings.iter().any(|f| NOT_COMPARABLE.iter().any(|code| code.name() == f.code)) {
        report(context, &set, misfit, &[], assessment);
        return;
    }
    labels::judge(context, &set, &declared, assessment);
    let corrections = corrections(&set, &declared);
    report(context, &set, misfit, &corrections, assessment);
    // Of an object of 20 m, noise and agreement in millimetres mean nothing; but units can be
    // named.
    let size = assessment.scene.object_size_m;
    let has_size = size.is_none_or(|size| context.thresholds.scale.object_size_m.contains(&size));
    let rigid = corrections.iter().flatten().map(|c| c.1).fold(misfit, f64::min);
    set.stride = limits.screening_stride;
    let explanation =
        (misfit > limits.min_suspicious_misfit).then(|| mistake::explain(&set)).flatten();
    set.stride = 1;
    if let Some(found) = explanation
        && found.misfit < limits.max_explained_ratio * misfit
        && found.misfit < limits.max_explained_misfit
        && agrees(&set, &found.hypothesis, limits)
        && found.misfit < limits.max_rigid_ratio * rigid
        && (has_size || found.mistake.is_about_units(set.thresholds))
    {
        assessment.findings.push(mistakes::finding(context, &set, &found, size));
        return;
    }
    if has_size && !judge_depth_scale(context, &set, &declared, misfit, &corrections, assessment) {
        misplaced_cameras(context, &set, misfit, corrections, assessment);
    }
}

/// True if the cameras agree under a hypothesis: a gain alone is not enough, since any change of
/// what is compared may gain something.
fn agrees(set: &ViewSet<'_>, hypothesis: &Hypothesis, limits: &AgreementThresholds) -> bool {
    set.disagreement_m(hypothesis).is_some_and(|m| m < limits.max_disagreement_m)
}

/// The frames with crops in which the object moves least: there, skew does no harm.
fn compared_frames(context: &Context<'_>, set: &ViewSet<'_>) -> Vec<usize> {
    let limits = &context.thresholds.agreement;
    let steps = super::paths::steps(&context.paths.object, context.recording.frame_count);
    let speed = |f: usize| {
        let around = [f, f + 1].into_iter().filter_map(|f| *steps.get(f)?);
        around.fold(0.0, f64::max)
    };
    let mut frames: Vec<usize> =
        set.views.iter().flat_map(|w| w.crops.iter().map(|v| v.crop.frame)).collect();
    frames.sort_unstable();
    let seen_by = |f: usize| frames.iter().filter(|other| **other == f).count();
    let mut shared: Vec<usize> = frames.iter().copied().filter(|f| seen_by(*f) >= 2).collect();
    shared.dedup();
    // Those that most cameras saw first: a camera that dropped a frame should still be compared.
    shared.sort_by(|a, b| {
        seen_by(*b).cmp(&seen_by(*a)).then(speed(*a).total_cmp(&speed(*b))).then(a.cmp(b))
    });
    shared.truncate(limits.compared_frames);
    shared
}

fn pairs(set: &ViewSet<'_>, hypothesis: &Hypothesis, assessment: &mut Assessment) {
    for a in 0..set.views.len() {
        for b in a + 1..set.views.len() {
            let reprojection =
                set.reproject(a, b, hypothesis).both(&set.reproject(b, a, hypothesis));
            let (a, b) = (set.views[a].index, set.views[b].index);
            let mm = |m: Option<f64>| m.map(|m| 1e3 * m);
            let skew_ms =
                assessment.pairs.iter().find(|p| (p.a, p.b) == (a, b)).and_then(|p| p.skew_ms);
            assessment.pairs.retain(|p| (p.a, p.b) != (a, b));
            assessment.pairs.push(PairReport {
                compared: reprojection.differences.len(),
                disagreement_mm: mm(reprojection.disagreement_m()),
                offset_mm: mm(reprojection.offset_m()),
                conflict: reprojection.conflict(),
                misfit: reprojection.misfit(),
                skew_ms,
                ..PairReport::of(a, b)
            });
        }
    }
    assessment.pairs.sort_by_key(|p| (p.a, p.b));
}

impl PairReport {
    /// A pair without known facts yet.
    pub(super) fn of(a: usize, b: usize) -> Self {
        Self {
            a,
            b,
            compared: 0,
            disagreement_mm: None,
            offset_mm: None,
            conflict: 0.0,
            misfit: None,
            skew_ms: None,
        }
    }
}

/// A correction and the misfit that it leaves.
type Corrected = Option<(Correction, f64)>;

fn corrections(set: &ViewSet<'_>, hypothesis: &Hypothesis) -> Vec<Corrected> {
    let one = |which: usize| {
        let correction = correct(set, hypothesis, which)?;
        let moved = hypothesis.with(which, |s| s.moved = Some(correction.motion));
        Some((correction, set.misfit(&moved)?))
    };
    (0..set.views.len()).map(one).collect()
}

fn report(
    context: &Context<'_>,
    set: &ViewSet<'_>,
    misfit: f64,
    corrections: &[Corrected],
    assessment: &mut Assessment,
) {
    let limits = &context.thresholds.agreement;
    for (view, corrected) in set.views.iter().zip(corrections) {
        // A correction that gains nothing is noise along what the surface does not determine.
        let corrected = corrected.filter(|(_, left)| *left < limits.max_corrected_ratio * misfit);
        let of = |has: bool| {
            let own =
                assessment.pairs.iter().filter(|p| (p.a == view.index || p.b == view.index) == has);
            median(own.filter_map(|p| p.disagreement_mm))
        };
        let agreement = Agreement {
            disagreement_mm: of(true),
            others_mm: of(false),
            correction_deg: corrected.map(|(c, _)| c.angle.to_degrees()),
            correction_mm: corrected.map(|(c, _)| 1e3 * c.shift_m),
        };
        if let Some(camera) = assessment.cameras.get_mut(view.index) {
            camera.agreement = Some(agreement);
        }
    }
}

/// Judges depth scales; true if a wrong one explains the misfit as well as any rigid correction
/// does, with one number instead of six.
fn judge_depth_scale(
    context: &Context<'_>,
    set: &ViewSet<'_>,
    declared: &Hypothesis,
    misfit: f64,
    corrections: &[Corrected],
    assessment: &mut Assessment,
) -> bool {
    let limits = &context.thresholds.agreement;
    let rigid = corrections.iter().flatten().map(|c| c.1).fold(misfit, f64::min);
    let explains = |left: f64| {
        left < limits.max_corrected_ratio * misfit
            && left < limits.max_rigid_ratio * rigid
            && left < limits.max_scaled_misfit
    };
    let mut best: Option<(Option<usize>, f64, f64)> = None;
    let mut consider = |which: Option<usize>, factor: f64, hypothesis: Hypothesis| {
        let Some(left) = set.misfit(&hypothesis) else { return };
        let is_better = best.is_none_or(|(_, _, other)| left < other);
        let is_off = (factor - 1.0).abs() > limits.max_scale_error;
        if is_off && explains(left) && is_better && agrees(set, &hypothesis, limits) {
            best = Some((which, factor, left));
        }
    };
    if let Some(found) = depth_scale::of_all(set, declared) {
        consider(None, found.factor, declared.with_all(|s| s.depth_scale = found.factor));
    }
    // With two cameras, a factor of one is as good as the inverse of the other.
    if set.views.len() > 2 {
        for which in 0..set.views.len() {
            if let Some(found) = depth_scale::of_one(set, declared, which) {
                let hypothesis = declared.with(which, |s| s.depth_scale = found.factor);
                consider(Some(which), found.factor, hypothesis);
            }
        }
    }
    let Some((which, factor, left)) = best else { return false };
    let is_bad = (factor - 1.0).abs() > limits.bad_scale_error;
    assessment.findings.push(
        match which {
            Some(which) => mistakes::depth_of_one(context, set, which, factor, is_bad),
            None => mistakes::depth_of_all(factor, is_bad),
        }
        .number("misfit_repaired", left),
    );
    true
}

/// Findings of the cameras that are off, one after another, or of the pairs that disagree.
fn misplaced_cameras(
    context: &Context<'_>,
    set: &ViewSet<'_>,
    mut misfit: f64,
    mut found: Vec<Corrected>,
    assessment: &mut Assessment,
) {
    let limits = &context.thresholds.agreement;
    let n = set.views.len();
    let mut hypothesis = Hypothesis::declared(n);
    let mut flagged = Vec::new();
    while flagged.len() + 2 < n.max(3) && flagged.len() < limits.max_flagged {
        let is_off = |c: &Corrected| {
            c.filter(|(c, left)| {
                c.shift_m > limits.min_off_m && *left < limits.max_corrected_ratio * misfit
            })
        };
        let candidates = found.iter().enumerate().filter(|(i, _)| !flagged.contains(i));
        let best = candidates
            .filter_map(|(i, c)| Some((i, is_off(c)?)))
            .min_by(|a, b| a.1.1.total_cmp(&b.1.1));
        let Some((which, (correction, left))) = best else { break };
        if n == 2 {
            assessment.findings.push(two_cameras_disagree(context, set, &correction));
            return;
        }
        assessment.findings.push(misplaced_camera(context, set, which, &correction));
        assessment.corrections.push((set.views[which].index, correction.motion));
        flagged.push(which);
        hypothesis = hypothesis.with(which, |s| s.moved = Some(correction.motion));
        misfit = left;
        found = corrections(set, &hypothesis);
    }
    if flagged.is_empty() && misfit > limits.min_inconsistent_misfit {
        inconsistent_camera(context, set, &hypothesis, misfit, &mut flagged, assessment);
    }
    disagreeing_pairs(context, set, &flagged, assessment);
}

fn misplaced_camera(
    context: &Context<'_>,
    set: &ViewSet<'_>,
    which: usize,
    c: &Correction,
) -> Finding {
    let limits = &context.thresholds.agreement;
    let index = set.views[which].index;
    let message = format!(
        "{} sees the object {:.0} mm away from where the other cameras see it (limit {:.0}); turning it by {:.1} degrees and \
         moving it would correct that",
        named(context.recording, index),
        1e3 * c.shift_m,
        1e3 * limits.min_off_m,
        c.angle.to_degrees()
    );
    Finding::graded(c.shift_m > limits.bad_off_m, Code::CameraOff, message)
        .cameras([index])
        .number("shift_mm", 1e3 * c.shift_m)
        .number("angle_deg", c.angle.to_degrees())
}

fn two_cameras_disagree(context: &Context<'_>, set: &ViewSet<'_>, c: &Correction) -> Finding {
    let limits = &context.thresholds.agreement;
    let [a, b] = [0, 1].map(|i| set.views.get(i).map_or(i, |w| w.index));
    let message = format!(
        "{} and {} see the object {:.0} mm apart (limit {:.0}); with two cameras nothing tells which one is off",
        named(context.recording, a),
        named(context.recording, b),
        1e3 * c.shift_m,
        1e3 * limits.min_off_m
    );
    Finding::graded(c.shift_m > limits.bad_off_m, Code::CamerasDisagree, message)
        .cameras([a, b])
        .number("shift_mm", 1e3 * c.shift_m)
}

/// Finding of a camera without which the others agree: it is off, even if it is too far off to be
/// corrected.
fn inconsistent_camera(
    context: &Context<'_>,
    set: &ViewSet<'_>,
    hypothesis: &Hypothesis,
    misfit: f64,
    flagged: &mut Vec<usize>,
    assessment: &mut Assessment,
) {
    if set.views.len() < 3 {
        return;
    }
    let without = |which: usize| set.misfit_of(hypothesis, |a, b| a != which && b != which);
    let best = (0..set.views.len())
        .filter_map(|which| Some((which, without(which)?)))
        .min_by(|a, b| a.1.total_cmp(&b.1));
    let Some((which, left)) =
        best.filter(|(_, left)| *left < context.thresholds.agreement.max_without_ratio * misfit)
    else {
        return;
    };
    let index = set.views[which].index;
    let message = format!(
        "{} contradicts the other cameras in {:.0} % of what it sees, and without it they agree",
        named(context.recording, index),
        100.0 * set.misfit_of(hypothesis, |a, b| a == which || b == which).unwrap_or(misfit)
    );
    assessment.findings.push(
        Finding::error(Code::CameraOff, message)
            .cameras([index])
            .number("misfit", misfit)
            .number("misfit_without", left),
    );
    flagged.push(which);
}

fn disagreeing_pairs(
    context: &Context<'_>,
    set: &ViewSet<'_>,
    flagged: &[usize],
    assessment: &mut Assessment,
) {
    let limits = &context.thresholds.agreement;
    let flagged: Vec<usize> =
        flagged.iter().filter_map(|w| set.views.get(*w)).map(|w| w.index).collect();
    let bad = |p: &&PairReport| {
        let apart = p.disagreement_mm.is_some_and(|mm| mm > 1e3 * limits.max_disagreement_m)
            && p.compared >= limits.min_compared;
        (apart || p.misfit.is_some_and(|m| m > limits.max_misfit))
            && !flagged.contains(&p.a)
            && !flagged.contains(&p.b)
    };
    let pairs: Vec<PairReport> = assessment.pairs.iter().filter(bad).copied().collect();
    let Some(worst) =
        pairs.iter().max_by(|x, y| x.misfit.unwrap_or(0.0).total_cmp(&y.misfit.unwrap_or(0.0)))
    else {
        return;
    };
    let mut cameras: Vec<usize> = pairs.iter().flat_map(|p| [p.a, p.b]).collect();
    cameras.sort_unstable();
    cameras.dedup();
    let distance = worst
        .disagreement_mm
        .map_or(String::new(), |mm| format!(" and measure it {mm:.0} mm apart"));
    let message = format!(
        "{} and {} contradict each other in {:.0} % of what they see of the object{distance}",
        named(context.recording, worst.a),
        named(context.recording, worst.b),
        100.0 * worst.conflict
    );
    let misfit = mean(pairs.iter().filter_map(|p| p.misfit)).unwrap_or(0.0);
    assessment.findings.push(
        Finding::graded(misfit > limits.max_misfit, Code::CamerasDisagree, message)
            .cameras(cameras)
            .number("conflict", worst.conflict)
            .number("disagreement_mm", worst.disagreement_mm.unwrap_or(f64::NAN)),
    );
}
