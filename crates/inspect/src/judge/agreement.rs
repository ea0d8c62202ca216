//! Whether the cameras see one world, and if not, which mistake explains it, or which camera is off and by how much.

mod labels;
mod mistakes;

use super::{Case, Record, named};
use crate::{
    Finding,
    agree::{
        Court,
        correct::{Correction, correct},
        scale,
        setup::Setup,
        suspect, witnesses,
    },
    inspection::{Agreement, PairReport},
    statistics::{mean, median},
};

/// Frames in which cameras are compared.
const CALM_FRAMES: usize = 4;
/// From this misfit on, mistakes are suspected.
const SUSPICIOUS: f64 = 0.06;
/// For that, every so many spots are enough.
const RUMOUR: usize = 3;
/// What may remain of the misfit if a mistake explains it, as a share and at all.
const EXPLAINED: [f64; 2] = [0.4, 0.2];
/// A mistake, which is one thing, must explain as much as a rigid correction, which is six numbers.
const AS_GOOD: f64 = 1.15;
/// A camera is off if a correction moves what it sees by so much [m] and leaves so much of the misfit.
const OFF_M: f64 = 0.005;
const CORRECTED: f64 = 0.8;
/// A camera that is so far off spoils a fit [m].
const BAD_M: f64 = 0.025;
/// Cameras that are named one after the other; beyond, nothing can be trusted.
const MOST_BLAMED: usize = 4;
/// Misfit of a pair, and its surfaces' distance [m], that is too much even if no correction is found.
const DISAGREE: f64 = 0.3;
const DISAGREE_M: f64 = 0.012;
/// A depth scale that differs by less is none's fault.
const SCALE: f64 = 0.015;

pub(super) fn judge(case: &Case<'_>, record: &mut Record) {
    let mut court = Court {
        witnesses: witnesses(&case.recording.cameras, case.logs),
        frames: Vec::new(),
        every: 1,
    };
    if court.witnesses.len() < 2 {
        return;
    }
    court.frames = calm_frames(case, &court);
    let declared = Setup::declared(court.witnesses.len());
    let Some(misfit) = court.misfit(&declared) else { return };
    pairs(&court, &declared, record);
    labels::judge(case, &court, &declared, record);
    let corrections = corrections(&court, &declared);
    report(&court, misfit, &corrections, record);
    // Of an object of 20 m, noise and agreement in millimetres mean nothing; but units can be told.
    let size = record.scene.object_size_m;
    let has_size = size.is_none_or(|size| super::scale::OBJECT_M.contains(&size));
    let rigid = corrections.iter().flatten().map(|c| c.1).fold(misfit, f64::min);
    court.every = RUMOUR;
    let explanation = (misfit > SUSPICIOUS).then(|| suspect::explain(&court)).flatten();
    court.every = 1;
    if let Some(found) = explanation
        && found.misfit < EXPLAINED[0] * misfit
        && found.misfit < EXPLAINED[1]
        && found.misfit < AS_GOOD * rigid
        && (has_size || found.mistake.is_about_units())
    {
        record.findings.push(mistakes::tell(case, &court, &found, size));
        return;
    }
    if has_size && !scales(case, &court, &declared, misfit, &corrections, record) {
        off(case, &court, misfit, corrections, record);
    }
}

/// The sketched frames in which the object moves least: there, skew does no harm.
fn calm_frames(case: &Case<'_>, court: &Court<'_>) -> Vec<usize> {
    let steps = super::paths::steps(&case.paths.object, case.recording.frame_count);
    let speed = |f: usize| {
        let around = [f, f + 1].into_iter().filter_map(|f| *steps.get(f)?);
        around.fold(0.0, f64::max)
    };
    let mut frames: Vec<usize> =
        court.witnesses.iter().flat_map(|w| w.views.iter().map(|v| v.sketch.frame)).collect();
    frames.sort_unstable();
    let seen_by = |f: usize| frames.iter().filter(|other| **other == f).count();
    let mut shared: Vec<usize> = frames.iter().copied().filter(|f| seen_by(*f) >= 2).collect();
    shared.dedup();
    // Those that most cameras saw first: a camera that dropped a frame should still be heard.
    shared.sort_by(|a, b| {
        seen_by(*b).cmp(&seen_by(*a)).then(speed(*a).total_cmp(&speed(*b))).then(a.cmp(b))
    });
    shared.truncate(CALM_FRAMES);
    shared
}

fn pairs(court: &Court<'_>, setup: &Setup, record: &mut Record) {
    for a in 0..court.witnesses.len() {
        for b in a + 1..court.witnesses.len() {
            let meeting = court.hear(a, b, setup).both(&court.hear(b, a, setup));
            let (a, b) = (court.witnesses[a].index, court.witnesses[b].index);
            let mm = |m: Option<f64>| m.map(|m| 1e3 * m);
            let skew_ms =
                record.pairs.iter().find(|p| (p.a, p.b) == (a, b)).and_then(|p| p.skew_ms);
            record.pairs.retain(|p| (p.a, p.b) != (a, b));
            record.pairs.push(PairReport {
                compared: meeting.differences.len(),
                disagreement_mm: mm(meeting.disagreement_m()),
                offset_mm: mm(meeting.offset_m()),
                conflict: meeting.conflict(),
                misfit: meeting.misfit(),
                skew_ms,
                ..PairReport::of(a, b)
            });
        }
    }
    record.pairs.sort_by_key(|p| (p.a, p.b));
}

impl PairReport {
    /// A pair of which nothing is known yet.
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

fn corrections(court: &Court<'_>, setup: &Setup) -> Vec<Corrected> {
    let one = |which: usize| {
        let correction = correct(court, setup, which)?;
        let moved = setup.with(which, |s| s.moved = Some(correction.motion));
        Some((correction, court.misfit(&moved)?))
    };
    (0..court.witnesses.len()).map(one).collect()
}

fn report(court: &Court<'_>, misfit: f64, corrections: &[Corrected], record: &mut Record) {
    for (witness, corrected) in court.witnesses.iter().zip(corrections) {
        // A correction that gains nothing is noise along what the surface does not determine.
        let corrected = corrected.filter(|(_, left)| *left < CORRECTED * misfit);
        let of = |has: bool| {
            let own = record
                .pairs
                .iter()
                .filter(|p| (p.a == witness.index || p.b == witness.index) == has);
            median(own.filter_map(|p| p.disagreement_mm))
        };
        let agreement = Agreement {
            disagreement_mm: of(true),
            others_mm: of(false),
            correction_deg: corrected.map(|(c, _)| c.angle.to_degrees()),
            correction_mm: corrected.map(|(c, _)| 1e3 * c.shift_m),
        };
        if let Some(camera) = record.cameras.get_mut(witness.index) {
            camera.agreement = Some(agreement);
        }
    }
}

/// Whether a wrong depth scale explains the misfit as well as any rigid correction does, with one number instead of six.
fn scales(
    case: &Case<'_>,
    court: &Court<'_>,
    declared: &Setup,
    misfit: f64,
    corrections: &[Corrected],
    record: &mut Record,
) -> bool {
    let rigid = corrections.iter().flatten().map(|c| c.1).fold(misfit, f64::min);
    let explains = |left: f64| left < CORRECTED * misfit && left < AS_GOOD * rigid;
    let mut best: Option<(Option<usize>, f64, f64)> = None;
    let mut consider = |which: Option<usize>, factor: f64, setup: Setup| {
        let Some(left) = court.misfit(&setup) else { return };
        let is_better = best.is_none_or(|(_, _, other)| left < other);
        if (factor - 1.0).abs() > SCALE && explains(left) && is_better {
            best = Some((which, factor, left));
        }
    };
    if let Some(found) = scale::of_all(court, declared) {
        consider(None, found.factor, declared.with_all(|s| s.depth_scale = found.factor));
    }
    // With two cameras, a factor of one is as good as the inverse of the other.
    if court.witnesses.len() > 2 {
        for which in 0..court.witnesses.len() {
            if let Some(found) = scale::of_one(court, declared, which) {
                let setup = declared.with(which, |s| s.depth_scale = found.factor);
                consider(Some(which), found.factor, setup);
            }
        }
    }
    let Some((which, factor, _)) = best else { return false };
    let is_bad = (factor - 1.0).abs() > 0.04;
    record.findings.push(match which {
        Some(which) => mistakes::depth_of_one(case, court, which, factor, is_bad),
        None => mistakes::depth_of_all(factor, is_bad),
    });
    true
}

/// Names the cameras that are off, one after the other, or the pairs that disagree.
fn off(
    case: &Case<'_>,
    court: &Court<'_>,
    mut misfit: f64,
    mut found: Vec<Corrected>,
    record: &mut Record,
) {
    let n = court.witnesses.len();
    let mut setup = Setup::declared(n);
    let mut blamed = Vec::new();
    while blamed.len() + 2 < n.max(3) && blamed.len() < MOST_BLAMED {
        let is_off =
            |c: &Corrected| c.filter(|(c, left)| c.shift_m > OFF_M && *left < CORRECTED * misfit);
        let candidates = found.iter().enumerate().filter(|(i, _)| !blamed.contains(i));
        let best = candidates
            .filter_map(|(i, c)| Some((i, is_off(c)?)))
            .min_by(|a, b| a.1.1.total_cmp(&b.1.1));
        let Some((which, (correction, left))) = best else { break };
        if n == 2 {
            record.findings.push(two_disagree(case, court, &correction));
            return;
        }
        record.findings.push(one_is_off(case, court, which, &correction));
        blamed.push(which);
        setup = setup.with(which, |s| s.moved = Some(correction.motion));
        misfit = left;
        found = corrections(court, &setup);
    }
    if blamed.is_empty() && misfit > 0.5 * DISAGREE {
        odd_one_out(case, court, &setup, misfit, &mut blamed, record);
    }
    disagreeing_pairs(case, court, &blamed, record);
}

fn one_is_off(case: &Case<'_>, court: &Court<'_>, which: usize, c: &Correction) -> Finding {
    let index = court.witnesses[which].index;
    let message = format!(
        "{} sees the object {:.0} mm away from where the other cameras see it (limit {:.0}); turning it by {:.1} degrees and \
         moving it would correct that",
        named(case.recording, index),
        1e3 * c.shift_m,
        1e3 * OFF_M,
        c.angle.to_degrees()
    );
    Finding::graded(c.shift_m > BAD_M, "CAMERA_OFF", message)
        .cameras([index])
        .number("shift_mm", 1e3 * c.shift_m)
        .number("angle_deg", c.angle.to_degrees())
}

fn two_disagree(case: &Case<'_>, court: &Court<'_>, c: &Correction) -> Finding {
    let [a, b] = [0, 1].map(|i| court.witnesses.get(i).map_or(i, |w| w.index));
    let message = format!(
        "{} and {} see the object {:.0} mm apart (limit {:.0}); with two cameras nothing tells which one is off",
        named(case.recording, a),
        named(case.recording, b),
        1e3 * c.shift_m,
        1e3 * OFF_M
    );
    Finding::graded(c.shift_m > BAD_M, "CAMERAS_DISAGREE", message)
        .cameras([a, b])
        .number("shift_mm", 1e3 * c.shift_m)
}

/// A camera without which the others agree is off, even if it is too far off to be corrected.
fn odd_one_out(
    case: &Case<'_>,
    court: &Court<'_>,
    setup: &Setup,
    misfit: f64,
    blamed: &mut Vec<usize>,
    record: &mut Record,
) {
    if court.witnesses.len() < 3 {
        return;
    }
    let without = |which: usize| court.misfit_of(setup, |a, b| a != which && b != which);
    let best = (0..court.witnesses.len())
        .filter_map(|which| Some((which, without(which)?)))
        .min_by(|a, b| a.1.total_cmp(&b.1));
    let Some((which, left)) = best.filter(|(_, left)| *left < 0.35 * misfit) else { return };
    let index = court.witnesses[which].index;
    let message = format!(
        "{} contradicts the other cameras in {:.0} % of what it sees, and without it they agree",
        named(case.recording, index),
        100.0 * court.misfit_of(setup, |a, b| a == which || b == which).unwrap_or(misfit)
    );
    record.findings.push(
        Finding::error("CAMERA_OFF", message)
            .cameras([index])
            .number("misfit", misfit)
            .number("misfit_without", left),
    );
    blamed.push(which);
}

fn disagreeing_pairs(case: &Case<'_>, court: &Court<'_>, blamed: &[usize], record: &mut Record) {
    let blamed: Vec<usize> =
        blamed.iter().filter_map(|w| court.witnesses.get(*w)).map(|w| w.index).collect();
    let bad = |p: &&PairReport| {
        let apart = p.disagreement_mm.is_some_and(|mm| mm > 1e3 * DISAGREE_M) && p.compared > 50;
        (apart || p.misfit.is_some_and(|m| m > DISAGREE))
            && !blamed.contains(&p.a)
            && !blamed.contains(&p.b)
    };
    let pairs: Vec<PairReport> = record.pairs.iter().filter(bad).copied().collect();
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
        named(case.recording, worst.a),
        named(case.recording, worst.b),
        100.0 * worst.conflict
    );
    let misfit = mean(pairs.iter().filter_map(|p| p.misfit)).unwrap_or(0.0);
    record.findings.push(
        Finding::graded(misfit > DISAGREE, "CAMERAS_DISAGREE", message)
            .cameras(cameras)
            .number("conflict", worst.conflict)
            .number("disagreement_mm", worst.disagreement_mm.unwrap_or(f64::NAN)),
    );
}
