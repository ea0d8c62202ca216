use super::*;

fn quality() -> Quality {
    let error = |cd: f64| ErrorSummary { chamfer_l1_m: Some(cd), ..ErrorSummary::default() };
    let score = |predictor, train, future| Score {
        predictor,
        train,
        future,
        per_frame: vec![],
        at_nodes: None,
    };
    Quality {
        scores: vec![
            score(Predictor::Bending, error(0.00512), error(0.0061)),
            score(Predictor::LastResidual, ErrorSummary::default(), error(0.15)),
        ],
        warnings: vec!["the rope is short".into()],
        fast: None,
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
fn nothing_is_an_empty_table() {
    assert_eq!(format_table(&Quality::default(), TableStyle::Plain), "mm\n");
}
