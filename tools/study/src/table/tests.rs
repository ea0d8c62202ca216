use std::{path::Path, time::Duration};

use bendtwin_core::{
    Category, Fault, FitSettings, Quality,
    quality::{ErrorSummary, Predictor, Score},
};
use serde_json::{Value, json};

use super::*;
use crate::{
    Folder, PlanOptions, Suite, Verdict, digest,
    record::{Finished, GraphCounts, Losses, Outcome, Record},
};

fn score(predictor: Predictor, train_mm: f64, future_mm: f64) -> Score {
    let errors =
        |mm: f64| ErrorSummary { chamfer_l1_m: Some(1e-3 * mm), ..ErrorSummary::default() };
    Score {
        predictor,
        train: errors(train_mm),
        future: errors(future_mm),
        per_frame: Vec::new(),
        at_nodes: None,
        rendered: None,
    }
}

fn record(suite: &Suite, run: &str, outcome: Outcome) -> Record {
    let (id, capture, configuration) = suite.runs().find(|(id, ..)| id.to_string() == run).unwrap();
    let settings: FitSettings = suite.settings(capture, configuration, id.seed).unwrap();
    Record {
        version: 1,
        digest: digest::of_run("c", &settings, "b"),
        run: id,
        capture_digest: "c".into(),
        settings,
        build: "b".into(),
        backend: "cpu".into(),
        device: "one thread".into(),
        command: String::new(),
        outcome,
    }
}

fn finished(nodes: &str, twin_mm: f64, residual_mm: f64) -> Outcome {
    let scores = vec![
        score(Predictor::Bending, 0.5 * twin_mm, twin_mm),
        score(Predictor::StandingStill, 50.0, 100.0),
        score(Predictor::LastResidual, 1.0, residual_mm),
    ];
    Outcome::Finished(Box::new(Finished {
        graph: GraphCounts {
            nodes: 10,
            surface_nodes: 10,
            springs: 20,
            node_springs: Some(15),
            triplets: 5,
            controls: 1,
            nodes_digest: nodes.into(),
        },
        losses: Losses::default(),
        substeps: 20,
        stable_substeps: 10,
        quality: Quality { scores, ..Quality::default() },
        fit_s: 1.0,
    }))
}

/// A folder with a suite of two captures, two configurations and two seeds, and the table of some
/// results.
fn table(results: &[(&str, Outcome)]) -> Table {
    let document = json!({
        "version": 1,
        "captures": [{"name": "a", "path": "a.zip"}, {"name": "b", "path": "b.zip"}],
        "configurations": [
            {"name": "axial", "settings": {"bending": false}},
            {"name": "bending"},
        ],
        "seeds": [0, 1],
        "compare": [
            {"of": "bending", "against": "axial"},
            {"of": "bending", "against": "axial:last_residual"},
            {"of": "bending", "against": "Others"},
            {"of": "bending", "against": "Theirs"},
        ],
        "references": [
            {"name": "Others", "capture": "a", "future": {"cd_l1_mm": 16.0}},
            {"name": "Theirs", "future": {"cd_l1_mm": 10.0}},
        ]
    });
    table_of(&document, "a/axial/1", results)
}

/// The table with one run without a result selected, so that only its capture is looked for.
fn table_of(document: &Value, selected: &str, results: &[(&str, Outcome)]) -> Table {
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("suite.json");
    std::fs::write(&file, document.to_string()).unwrap();
    for name in ["a.zip", "b.zip"] {
        std::fs::write(place.path().join(name), b"").unwrap();
    }
    let suite = Suite::read(&file).unwrap();
    let folder = Folder::open(&place.path().join("out")).unwrap();
    for (run, outcome) in results {
        folder.write_record(&record(&suite, run, outcome.clone())).unwrap();
    }
    let options = PlanOptions {
        data: None,
        only: vec![selected.parse().unwrap()],
        build: "b".into(),
        any_build: false,
        checkpoint_every: Duration::ZERO,
    };
    let nothing = Fault {
        category: Category::InvalidArgument,
        reason: "EMPTY".into(),
        message: "it is empty".into(),
    };
    let plan = Plan::new(&suite, &folder, options, &|_| Err(nothing.clone())).unwrap();
    let out = Path::new("out").to_owned();
    Table::new(&plan, &Invocation { suite: "suite.json".into(), data: None, out })
}

fn all() -> Vec<(&'static str, Outcome)> {
    let fault = Fault {
        category: bendtwin_core::Category::InvalidArgument,
        reason: "NO".into(),
        message: "it did not".into(),
    };
    vec![
        ("a/axial/0", finished("n0", 20.0, 18.0)),
        ("a/bending/0", finished("n0", 10.0, 9.0)),
        ("a/bending/1", finished("n1", 14.0, 9.0)),
        ("b/axial/0", finished("m", 10.0, 5.0)),
        ("b/axial/1", finished("m", 10.0, 5.0)),
        ("b/bending/0", finished("other", 11.0, 9.0)),
        ("b/bending/1", Outcome::Failed(fault)),
    ]
}

fn mean(row: &Row) -> f64 {
    row.errors["cd_l1_future_mm"].mean
}

#[test]
fn rows_are_means_over_seeds_and_captures() {
    let table = table(&all());
    let row = |name: &str, capture: &str| {
        let rows =
            table.rows.iter().find(|r| r.row == name && r.capture.as_deref() == Some(capture));
        rows.unwrap()
    };
    let bending = row("bending", "a");
    assert!((mean(bending) - 12.0).abs() < 1e-9);
    let spread = bending.errors["cd_l1_future_mm"].spread.unwrap();
    assert!((spread - 8_f64.sqrt()).abs() < 1e-9);
    assert_eq!((bending.seeds, bending.size.unwrap().nodes), (2, 10.0));
    assert_eq!(
        bending.command.as_deref().unwrap(),
        "cargo lab suite suite.json --out out --only a/bending"
    );
    // Standing still is the same for all and stands there once; last residuals are not.
    let of_a = |label: &str| {
        let rows = table.rows.iter().filter(|r| r.capture.as_deref() == Some("a"));
        rows.filter(|r| r.label == label).count()
    };
    assert_eq!(of_a("standing still"), 1);
    assert_eq!((of_a("last residual, axial"), of_a("last residual, bending")), (1, 1));
    assert_eq!(of_a("Others (published)"), 1);
    let means: Vec<_> = table.means.iter().map(|r| (r.row.as_str(), r.captures)).collect();
    assert_eq!(means[..2], [("axial", Some(2)), ("bending", Some(2))]);
    assert!((mean(&table.means[1]) - 11.5).abs() < 1e-9);
    assert_eq!((table.runs, table.missing, table.failures.len()), (8, 1, 1));
}

#[test]
fn differences_are_between_what_both_have() {
    let table = table(&all());
    let find = |against: &str, capture: Option<&str>| {
        let found = table
            .differences
            .iter()
            .find(|d| d.of == "bending" && d.against == against && d.capture.as_deref() == capture);
        found.unwrap()
    };
    let percent = |against, capture| find(against, capture).percent["cd_l1_future_mm"];
    // Seed 1 of the axial fit of `a` is missing, so seed 0 alone counts there.
    assert!((percent("axial", Some("a")) + 50.0).abs() < 1e-9);
    assert!((percent("axial", Some("b")) - 10.0).abs() < 1e-9);
    assert!((percent("axial", None) - 100.0 * (10.5 - 15.0) / 15.0).abs() < 1e-9);
    assert_eq!(find("axial", None).better["cd_l1_future_mm"], (1, 2));
    assert_eq!(find("axial", Some("a")).same_nodes, Some(true));
    assert_eq!(find("axial", Some("b")).same_nodes, Some(false));
    assert_eq!(find("axial", None).same_nodes, Some(false));
    assert!(
        (percent("axial:last_residual", Some("a")) - 100.0 * (10.0 - 18.0) / 18.0).abs() < 1e-9
    );
    assert!((percent("Others", Some("a")) + 25.0).abs() < 1e-9);
    assert_eq!(find("Others", Some("a")).same_nodes, None);
    // A published mean is set against the mean over all captures.
    assert!((percent("Theirs", None) - 15.0).abs() < 1e-9);
}

#[test]
fn the_table_reads_well() {
    let text = table(&all()).to_markdown();
    assert!(text.contains("| bending  "), "{text}");
    assert!(text.contains("12.00 ± 2.83"), "{text}");
    assert!(text.contains("| bending against axial"), "{text}");
    assert!(text.contains("-50.0") && text.contains("1 of 2"), "{text}");
    assert!(text.contains("`b/bending/1` (NO): it did not"), "{text}");
    assert!(text.contains("1 of 8 runs have no result yet"), "{text}");
    assert!(!text.contains("track train"), "a column that nobody has is left out");
    let widths: Vec<usize> =
        text.lines().filter(|l| l.starts_with("| ")).map(|l| l.chars().count()).collect();
    assert!(widths.windows(2).filter(|w| w[0] != w[1]).count() <= 1, "columns line up");
    let document: Value = serde_json::from_str(&table(&all()).to_json().unwrap()).unwrap();
    assert_eq!(document["rows"][0]["errors"]["cd_l1_future_mm"]["mean"], 20.0);
}

/// Results of a suite of two groups, whose figure has two series.
fn gains(results: &[(&str, Outcome)]) -> Table {
    let capture = |name: &str, group: &str| json!({"name": name, "path": format!("{name}.zip"), "group": group});
    let document = json!({
        "version": 1,
        "captures": [capture("a", "ropes"), capture("b", "ropes")],
        "configurations": [
            {"name": "axial", "groups": ["ropes"], "settings": {"bending": false}},
            {"name": "bending"},
            {"name": "arm", "settings": {"graph": {"triplet_reference": "nearest"}}},
        ],
        "seeds": [0, 1, 2],
        "compare": [
            {"of": "bending", "against": "axial"},
            {"of": "arm", "against": "axial"},
        ],
        "figure": {"degrees": [2, 4, 8], "series": [
            {"name": "opposite", "pairs": [{"of": "bending", "against": "axial"}]},
            {"name": "one arm", "pairs": [{"of": "arm", "against": "axial"}]},
        ]}
    });
    table_of(&document, "a/axial/2", results)
}

fn of_gains() -> Vec<(&'static str, Outcome)> {
    vec![
        ("a/axial/0", finished("n0", 20.0, 18.0)),
        ("a/axial/1", finished("n1", 22.0, 18.0)),
        ("b/axial/0", finished("m0", 10.0, 5.0)),
        ("b/axial/1", finished("m1", 10.0, 5.0)),
        ("a/bending/0", finished("n0", 10.0, 9.0)),
        ("a/bending/1", finished("n1", 11.0, 9.0)),
        ("b/bending/0", finished("m0", 5.0, 9.0)),
        ("b/bending/1", finished("m1", 5.5, 9.0)),
        ("a/arm/0", finished("n0", 22.0, 18.0)),
        ("a/arm/1", finished("n1", 20.0, 18.0)),
        ("b/arm/0", finished("m0", 9.0, 5.0)),
        ("b/arm/1", finished("m1", 11.0, 5.0)),
    ]
}

#[test]
fn gains_are_graded() {
    let table = gains(&of_gains());
    let gains = table.gains.as_ref().unwrap();
    assert_eq!(gains.groups, [Some("ropes".to_owned())]);
    assert_eq!(gains.series, ["opposite", "one arm"]);
    // Fifteen springs between ten nodes: three at each, which is nearer to 4 than to 2 by ratio.
    let [opposite, arm] = &gains.gains[..] else { panic!("{gains:?}") };
    assert_eq!((opposite.degree, opposite.mean_degree), (4.0, 3.0));
    assert_eq!((opposite.captures, opposite.pairs), (2, 4));
    let expected = 100.0 * ((0.25 * (0.5_f64.powi(3) * 0.55).ln()).exp() - 1.0);
    assert!((opposite.percent - expected).abs() < 1e-9, "{opposite:?}");
    assert_eq!(opposite.certainty.unwrap().verdict, Verdict::Lower);
    assert_eq!(arm.certainty.unwrap().verdict, Verdict::NoDifference);
    let text = table.to_markdown();
    let line = |start: &str| {
        let found = text.lines().find(|line| line.starts_with(start));
        found.unwrap_or_else(|| panic!("no {start} in {text}")).to_owned()
    };
    assert!(line("| opposite").contains("| ropes"), "{text}");
    assert!(line("| one arm").contains("no difference"), "{text}");
    let png = crate::draw_figure(gains).unwrap();
    assert_eq!(png[1..4], *b"PNG");
    // With a degree of 3, neither 2 nor 8 has a point.
    assert_eq!(gains.gains.len(), 2);
}

#[test]
fn an_insignificant_difference_of_means_is_named() {
    let table = gains(&of_gains());
    let mean = |of: &str| {
        let found = table.differences.iter().find(|d| d.of == of && d.capture.is_none());
        found.unwrap().certainty["cd_l1_future_mm"]
    };
    assert_eq!(mean("bending").verdict, Verdict::Lower);
    assert!(mean("bending").interval[1] < -40.0);
    assert_eq!(mean("arm").verdict, Verdict::NoDifference);
    let text = table.to_markdown();
    let rows: Vec<&str> = text.lines().filter(|l| l.starts_with("| arm against axial")).collect();
    assert!(rows.iter().any(|l| l.contains("mean") && l.contains("no difference")), "{text}");
    let single = table.differences.iter().filter(|d| d.capture.is_some());
    assert!(single.clone().count() == 4 && single.into_iter().all(|d| d.certainty.is_empty()));
}

#[test]
fn a_figure_of_nothing_can_be_drawn() {
    let table = gains(&[]);
    let gains = table.gains.unwrap();
    assert!(gains.gains.is_empty());
    assert_eq!(crate::draw_figure(&gains).unwrap()[1..4], *b"PNG");
}

#[test]
fn a_table_of_nothing_is_a_table() {
    let table = table(&[]);
    assert_eq!((table.rows.len(), table.missing), (1, 8));
    assert!(table.to_markdown().contains("8 of 8 runs"));
}
