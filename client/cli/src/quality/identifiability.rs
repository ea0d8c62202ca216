//! The report of what recordings leave open of a twin, in words and as a table.

use bendtwin_core::{Identifiability, Quality, identifiability::MotionUncertainty};

use crate::table::Table;

/// The report of a quality table in sentences, one a line; none without a report.
pub(crate) fn sentences(quality: &Quality) -> Option<String> {
    let report = quality.identifiability.as_ref()?;
    Some(report.summary.join("\n"))
}

/// The report with a row for each group of parameters, those that matter most first, and the recordings
/// that could be made next; none without a report.
pub(crate) fn details(quality: &Quality) -> Option<String> {
    let report = quality.identifiability.as_ref()?;
    let mut groups: Vec<usize> = (0..report.groups.len()).collect();
    groups.sort_by(|a, b| most(report, *b).total_cmp(&most(report, *a)));
    let heads = ["GROUP".to_owned(), "LEFT".to_owned(), "SO IT IS".to_owned()];
    let motions = report.motions.iter().map(|m| format!("{} (mm)", m.motion));
    let heads: Vec<String> = heads.into_iter().chain(motions).collect();
    let mut table = Table::new(heads.iter().map(String::as_str));
    for g in groups {
        let group = &report.groups[g];
        let left = format!("{:.0} %", 100.0 * group.relative_sd);
        let cells = [report.name(group), left, group.certainty.as_str().to_owned()];
        // By how much less a point would be uncertain if the group were known.
        let of = |m: &MotionUncertainty| {
            let share = m.shares.get(g).copied().unwrap_or_default().clamp(0.0, 1.0);
            format!("{:.1}", 1e3 * m.sd_m * (1.0 - (1.0 - share).sqrt()))
        };
        table.row(cells.into_iter().chain(report.motions.iter().map(of)));
    }
    let mut text = format!("{}\n\n{}", report.summary.join("\n"), table.text());
    let mut next = Table::new(["LEAVES (mm)", "RECORD NEXT"]);
    for recording in &report.next {
        next.row([format!("{:.1}", 1e3 * recording.sd_m), recording.action.clone()]);
    }
    if !report.next.is_empty() {
        text += &format!("\n\n{}", next.text());
    }
    Some(text)
}

/// The largest share of a group in a motion.
fn most(report: &Identifiability, group: usize) -> f64 {
    report.motions.iter().filter_map(|m| m.shares.get(group)).copied().fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use bendtwin_core::identifiability::{
        Certainty, Group, MotionUncertainty, NextRecording, Quantity, Region,
    };

    use super::*;

    #[test]
    fn groups_that_matter_most_come_first_and_recordings_follow() {
        let group = |quantity, region, relative_sd| Group {
            quantity,
            region,
            hand: None,
            prior_sd: 0.7,
            relative_sd,
            certainty: Certainty::of(relative_sd),
        };
        let report = Identifiability {
            summary: vec!["One.".into(), "Two.".into()],
            regions: vec![Region { name: "free end".into(), center: [0.0; 3], nodes: 3 }],
            groups: vec![
                group(Quantity::Drag, None, 0.2),
                group(Quantity::Stiffness, Some(0), 0.9),
            ],
            motions: vec![MotionUncertainty {
                motion: "hang".into(),
                sd_m: 0.004,
                prior_sd_m: 0.02,
                shares: vec![0.0, 0.75],
            }],
            next: vec![NextRecording {
                motion: "shake".into(),
                action: "Shake it.".into(),
                sd_m: 0.0025,
            }],
            ..Identifiability::default()
        };
        let quality = Quality { identifiability: Some(report), ..Quality::default() };
        let text = details(&quality).unwrap();
        assert_eq!(
            text,
            "One.\nTwo.\n\n\
             GROUP                LEFT  SO IT IS      hang (mm)\n\
             stiffness, free end  90 %  undetermined  2.0\n\
             drag                 20 %  determined    0.0\n\n\
             LEAVES (mm)  RECORD NEXT\n\
             2.5          Shake it."
        );
        assert_eq!(sentences(&quality).as_deref(), Some("One.\nTwo."));
        assert_eq!(details(&Quality::default()), None);
    }
}
