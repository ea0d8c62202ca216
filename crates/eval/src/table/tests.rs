use bendtwin_core::quality::{CameraScore, NodeErrors, RegistrationScore, RenderedScore};

use super::*;

fn quality() -> Quality {
    let error = |cd: f64| ErrorSummary { chamfer_l1_m: Some(cd), ..ErrorSummary::default() };
    let score = |predictor, train, future| Score {
        predictor,
        train,
        future,
        per_frame: vec![],
        at_nodes: None,
        rendered: None,
    };
    Quality {
        scores: vec![
            score(Predictor::Bending, error(0.00512), error(0.0061)),
            score(Predictor::LastResidual, ErrorSummary::default(), error(0.15)),
        ],
        warnings: vec!["the rope is short".into()],
        ..Quality::default()
    }
}

#[test]
fn plain_text_lines_up() {
    let expected = "\
mm              CD train  CD future
twin (bending)      5.12       6.10
last residual          -     150.00
warning: the rope is short
";
    assert_eq!(format_table(&quality(), TableStyle::Plain), expected);
}

#[test]
fn markdown_is_a_table() {
    let expected = "\
| mm             | CD train | CD future |
| -------------- | -------: | --------: |
| twin (bending) |     5.12 |      6.10 |
| last residual  |        - |    150.00 |

> the rope is short
";
    assert_eq!(format_table(&quality(), TableStyle::Markdown), expected);
}

#[test]
fn a_mean_of_fits_says_of_how_many() {
    let mut quality = quality();
    quality.scores[1].predictor = Predictor::MeanOfFits;
    let text = format_table(&quality, TableStyle::Plain);
    assert!(text.contains("\nmean of fits  "), "{text}");
    quality.spread = Some(SpreadScore { fits: 4, ..SpreadScore::default() });
    let text = format_table(&quality, TableStyle::Plain);
    assert!(text.contains("\nmean of 4 fits  "), "{text}");
}

#[test]
fn the_choice_of_a_start_is_explained() {
    let losses = vec![Some(3.2e-5), None, Some(1.5e-5)];
    let choice = Choice { start: 2, held_back_frames: 14, losses };
    let quality = Quality { choice: Some(choice), ..quality() };
    let plain = format_table(&quality, TableStyle::Plain);
    let expected = "kept start 3 of 3, which had the lowest loss over the last 14 training frames, \
                    which no start had seen then (3.20e-5, none, 1.50e-5)\nwarning: ";
    assert!(plain.contains(expected), "{plain}");
}

#[test]
fn errors_at_nodes_have_separate_columns() {
    let mut quality = quality();
    quality.warnings.clear();
    let future =
        ErrorSummary { chamfer_l1_m: Some(0.012), track_m: Some(0.009), ..ErrorSummary::default() };
    quality.scores[0].at_nodes = Some(NodeErrors { future, ..NodeErrors::default() });
    let expected = "\
mm              CD train  CD future  CD at nodes future  track at nodes future
twin (bending)      5.12       6.10               12.00                   9.00
last residual          -     150.00                   -                      -
";
    assert_eq!(format_table(&quality, TableStyle::Plain), expected);
}

#[test]
fn nothing_is_an_empty_table() {
    assert_eq!(format_table(&Quality::default(), TableStyle::Plain), "mm\n");
}

#[test]
fn several_recordings_have_a_separate_table() {
    let error = |cd: f64| ErrorSummary { chamfer_l1_m: Some(cd), ..ErrorSummary::default() };
    let registered = RegistrationScore { median_mm: 1.25, p95_mm: 3.0, explained: 0.9 };
    let recording = |name: &str, registered, train, future| RecordingScore {
        name: name.into(),
        registered,
        train,
        future,
    };
    let quality = Quality {
        recordings: vec![
            recording("lift", None, error(0.004), error(0.006)),
            recording("drag", Some(registered), ErrorSummary::default(), error(0.008)),
        ],
        ..quality()
    };
    let text = format_table(&quality, TableStyle::Plain);
    let expected = "\
mm, by recording  registered within  CD train  CD future
lift                              -      4.00       6.00
drag                           1.25         -       8.00
warning: the rope is short
";
    assert!(text.ends_with(expected), "{text}");
}

#[test]
fn renderings_have_a_separate_table() {
    let likeness =
        |iou: f64| Likeness { iou: Some(iou), psnr_db: Some(30.0), ..Likeness::default() };
    let camera = |name: &str, held_out| CameraScore {
        name: name.into(),
        held_out,
        train: likeness(0.8),
        future: likeness(0.7),
    };
    let mut quality = quality();
    quality.scores.truncate(1);
    quality.warnings.clear();
    quality.scores[0].rendered = Some(RenderedScore {
        gaussians: 9,
        train: likeness(0.9),
        future: Likeness { iou: Some(0.6), ..Likeness::default() },
        cameras: vec![camera("left", false), camera("top", true)],
        per_frame: Vec::new(),
    });
    let expected = "\
mm              CD train  CD future
twin (bending)      5.12       6.10

renderings             IoU train  IoU future  PSNR [dB] train  PSNR [dB] future
twin (bending)             0.900       0.600            30.00                 -
camera left                0.800       0.700            30.00             30.00
camera top (held out)      0.800       0.700            30.00             30.00
";
    assert_eq!(format_table(&quality, TableStyle::Plain), expected);
}
