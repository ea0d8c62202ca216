//! A report in sentences.

use bendtwin_core::{
    Identifiability,
    identifiability::{Certainty, MotionUncertainty},
};

/// Groups that are named.
const NAMED: usize = 3;
/// Part of a motion's variance from which on a group is named.
const LEAST_SHARE: f64 = 0.1;
/// Gain from which on a recording is worth making.
const LEAST_GAIN: f64 = 0.05;

/// The sentences of a report, from its numbers.
pub(crate) fn summary(report: &Identifiability) -> Vec<String> {
    let mut sentences = vec![determined(report)];
    sentences.extend(millimetres(report));
    sentences.extend(expected(report));
    sentences.extend(behind(report));
    sentences.extend(next(report));
    sentences
}

fn determined(report: &Identifiability) -> String {
    let count = |c: Certainty| report.groups.iter().filter(|g| g.certainty == c).count();
    format!(
        "Of {} groups of parameters the recording determines {}, {} in part, and leaves {} open.",
        report.groups.len(),
        count(Certainty::Determined),
        count(Certainty::Partly),
        count(Certainty::Undetermined),
    )
}

/// A motion as it follows "a point is uncertain by 3.1 mm".
fn during(motion: &str) -> &'static str {
    match motion {
        "future" => "in the frames after the training frames",
        "hang" => "hanging",
        "shake" => "when it is shaken",
        _ => "when it is pushed",
    }
}

fn millimetres(report: &Identifiability) -> Option<String> {
    let of = |m: &MotionUncertainty| format!("{:.1} mm {}", 1e3 * m.sd_m, during(&m.motion));
    let motions: Vec<String> = report.motions.iter().map(of).collect();
    let (last, first) = motions.split_last()?;
    let all = match first {
        [] => last.clone(),
        _ => format!("{} and {last}", first.join(", ")),
    };
    Some(format!("That leaves the place of a point uncertain by {all}."))
}

fn expected(report: &Identifiability) -> Option<String> {
    let error_m = report.expected_error_m?;
    Some(format!(
        "With the error in training, which lasts, expect points to be off by {:.1} mm {}.",
        1e3 * error_m,
        during("future")
    ))
}

/// The groups that are behind the millimetres of the first motion.
fn behind(report: &Identifiability) -> Option<String> {
    let motion = report.motions.first()?;
    let mut by_share: Vec<(usize, f64)> = motion.shares.iter().copied().enumerate().collect();
    by_share.sort_by(|a, b| b.1.total_cmp(&a.1));
    let named = by_share.into_iter().filter(|(_, share)| *share >= LEAST_SHARE).take(NAMED);
    let named: Vec<String> = named
        .filter_map(|(g, share)| {
            let group = report.groups.get(g)?;
            Some(format!("{} ({:.0} %)", report.name(group), 100.0 * share))
        })
        .collect();
    let of = during(&motion.motion);
    (!named.is_empty()).then(|| format!("Most of it {of} comes from: {}.", named.join("; ")))
}

fn next(report: &Identifiability) -> Option<String> {
    let best = report.next.first()?;
    let now = report.sd_m();
    let worth = best.sd_m < (1.0 - LEAST_GAIN) * now;
    Some(match worth {
        true => format!(
            "Record next: {} That would leave {:.1} of {:.1} mm.",
            best.action,
            1e3 * best.sd_m,
            1e3 * now
        ),
        false => "None of the motions that were tried would tell much more.".to_owned(),
    })
}

#[cfg(test)]
mod tests;
