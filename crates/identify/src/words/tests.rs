use bendtwin_core::identifiability::{Group, NextRecording, Quantity, Region};

use super::*;

#[test]
fn a_report_reads_as_sentences() {
    let group = |quantity, region, relative_sd| Group {
        quantity,
        region,
        hand: None,
        prior_sd: 0.7,
        relative_sd,
        certainty: Certainty::of(relative_sd),
    };
    let motion = |motion: &str, sd_m| MotionUncertainty {
        motion: motion.into(),
        sd_m,
        prior_sd_m: 0.02,
        shares: vec![0.81, 0.04],
    };
    let mut report = Identifiability {
        regions: vec![Region { name: "free end".into(), center: [0.0; 3], nodes: 3 }],
        groups: vec![group(Quantity::Stiffness, Some(0), 0.9), group(Quantity::Drag, None, 0.1)],
        motions: vec![motion("future", 0.004), motion("shake", 0.008)],
        next: vec![NextRecording {
            motion: "far_shake".into(),
            action: "Hold it at its free end instead, lift it and shake it.".into(),
            sd_m: 0.003,
        }],
        expected_error_m: Some(0.0052),
        ..Identifiability::default()
    };
    assert_eq!(
        summary(&report),
        [
            "Of 2 groups of parameters the recording determines 1, 0 in part, and leaves 1 open.",
            "That leaves the place of a point uncertain by 4.0 mm in the frames after the training \
             frames and 8.0 mm when it is shaken.",
            "With the error in training, which lasts, expect points to be off by 5.2 mm in the frames after \
             the training frames.",
            "Most of it in the frames after the training frames comes from: stiffness, free end (81 %).",
            "Record next: Hold it at its free end instead, lift it and shake it. That would leave 3.0 of \
             6.0 mm.",
        ]
    );
    report.next[0].sd_m = 0.0059;
    assert!(summary(&report)[4].starts_with("None of the motions"));
    assert_eq!(summary(&Identifiability::default()).len(), 1);
}
