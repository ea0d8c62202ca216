use bendtwin_core::settings::Substeps;
use serde_json::json;

use super::*;

fn parsed(document: &Value) -> Result<Suite, Vec<String>> {
    parse::parse(Path::new("studies/example.json"), &document.to_string())
}

fn example() -> Value {
    json!({
        "version": 1,
        "captures": [
            {"name": "rope", "path": "cases/rope.zip"},
            {"name": "cable", "path": "cable.npz", "settings": {"refine": {"passes": 4}}}
        ],
        "base": {"substeps": {"fixed": 300}, "refine": {"passes": 9}},
        "configurations": [
            {"name": "axial", "settings": {"bending": false}},
            {"name": "bending", "settings": {"substeps": {"auto": {"safety": 2.0, "max": 90}}}}
        ],
        "seeds": [0, 7],
        "compare": [
            {"of": "bending", "against": "axial"},
            {"of": "bending", "against": "axial:last_residual"},
            {"of": "bending", "against": "Others"}
        ],
        "references": [{"name": "Others", "capture": "rope", "future": {"cd_l1_mm": 5.98}}]
    })
}

#[test]
fn settings_stand_over_one_another() {
    let suite = parsed(&example()).unwrap();
    let of = |capture: usize, configuration: usize| {
        suite.settings(&suite.captures[capture], &suite.configurations[configuration], 7).unwrap()
    };
    let axial = of(0, 0);
    assert_eq!((axial.seed, axial.bending, axial.refine.passes), (7, false, Some(9)));
    assert_eq!(axial.substeps, Substeps::Fixed(300));
    let bending = of(1, 1);
    assert_eq!((bending.bending, bending.refine.passes), (true, Some(4)));
    assert_eq!(bending.substeps, Substeps::Auto { safety: 2.0, max: Some(90) });
    assert_eq!(bending.search, FitSettings::default().search);
}

#[test]
fn runs_go_seed_by_seed() {
    let suite = parsed(&example()).unwrap();
    let names: Vec<String> = suite.runs().map(|(id, ..)| id.to_string()).collect();
    assert_eq!(names.len(), 8);
    assert_eq!(names[..3], ["rope/axial/0", "rope/bending/0", "cable/axial/0"]);
    assert_eq!(names[7], "cable/bending/7");
    assert_eq!(suite.name, "example");
    let reference = suite.references[0].future.chamfer_l1_m.unwrap();
    assert!((reference - 5.98e-3).abs() < 1e-12);
}

#[test]
fn all_faults_are_reported_together() {
    let mut document = example();
    document["colour"] = json!(1);
    document["version"] = json!(2);
    document["seeds"] = json!([1, 1]);
    document["captures"][0]["name"] = json!("../rope");
    document["captures"][1]["file"] = json!("x");
    document["base"] = json!({"graf": 1, "refine": {"passes": 3, "pases": 3}});
    document["configurations"][0]["settings"] = json!({"seed": 3, "compare_axial": true});
    document["compare"][0]["against"] = json!("nobody");
    document["references"][0]["capture"] = json!("nothing");
    document["references"][0]["future"] = json!({"cd_l1_mm": -1.0});
    let faults = parsed(&document).unwrap_err();
    let expected = [
        "`colour`",
        "version is 2",
        "a seed stands twice",
        "`../rope`",
        "`file`",
        "`graf`",
        "`refine.pases`",
        "the seed stands in",
        "compare_axial",
        "`nobody`",
        "`nothing`",
        "errors are positive",
    ];
    for word in expected {
        assert!(faults.iter().any(|f| f.contains(word)), "{word} is not among {faults:#?}");
    }
    assert_eq!(faults.len(), expected.len(), "{faults:#?}");
}

#[test]
fn a_configuration_may_be_for_some_captures() {
    let mut document = example();
    document["captures"][0]["group"] = json!("ropes");
    document["captures"][1]["group"] = json!("cables");
    document["configurations"][0]["groups"] = json!(["cables"]);
    let suite = parsed(&document).unwrap();
    let names: Vec<String> = suite.runs().map(|(id, ..)| id.to_string()).collect();
    assert_eq!(names[..3], ["rope/bending/0", "cable/axial/0", "cable/bending/0"]);
    assert_eq!(names.len(), 6);
    document["configurations"][0]["groups"] = json!(["bodies"]);
    let faults = parsed(&document).unwrap_err();
    assert_eq!(faults, ["configuration `axial`: no capture is of the group `bodies`"]);
}

#[test]
fn a_figure_is_checked() {
    let mut document = example();
    let pair = json!({"of": "bending", "against": "axial"});
    document["figure"] = json!({"degrees": [3, 6.5], "series": [{"name": "one", "pairs": [pair]}]});
    let figure = parsed(&document).unwrap().figure.unwrap();
    assert_eq!((figure.degrees.as_slice(), figure.title), ([3.0, 6.5].as_slice(), None));
    document["figure"]["colour"] = json!(1);
    assert!(parsed(&document).unwrap_err()[0].contains("colour"));
    document["figure"] = json!({"degrees": [6, 3], "series": [
        {"name": "one", "pairs": [{"of": "bending", "against": "axial:last_residual"}]},
        {"name": "one", "pairs": []},
    ]});
    let faults = parsed(&document).unwrap_err();
    for word in ["ascend", "stands twice", "`axial:last_residual`", "no pairs"] {
        assert!(faults.iter().any(|f| f.contains(word)), "{word} is not among {faults:?}");
    }
    assert_eq!(faults.len(), 4, "{faults:?}");
}

#[test]
fn values_are_checked_where_they_come_together() {
    let mut document = example();
    document["configurations"][0]["settings"] = json!({"refine": {"learning_rate": 7.0}});
    document["configurations"][1]["settings"] = json!({"refine": {"passes": "many"}});
    let faults = parsed(&document).unwrap_err();
    assert!(faults.iter().any(|f| f.starts_with("configuration `axial`: refine.learning_rate")));
    assert!(faults.iter().any(|f| f.starts_with("configuration `bending`")), "{faults:?}");
    document = example();
    document["captures"][1]["settings"] = json!({"graph": {"radius_m": -1.0}});
    let faults = parsed(&document).unwrap_err();
    assert!(faults[0].starts_with("capture `cable` under axial: graph.radius_m"), "{faults:?}");
}

#[test]
fn what_is_needed_must_be_there() {
    let faults = parsed(&json!({})).unwrap_err();
    for word in ["version is missing", "no capture", "no configuration"] {
        assert!(faults.iter().any(|f| f.contains(word)), "{faults:?}");
    }
    assert!(parsed(&json!([])).is_err());
    let mut document = example();
    document["captures"][0] = json!({"name": "rope"});
    assert!(parsed(&document).unwrap_err()[0].contains("captures[0]: missing field `path`"));
}

#[test]
fn selections_name_runs() {
    let run = RunId { capture: "rope".into(), configuration: "axial".into(), seed: 7 };
    let hits = |text: &str| text.parse::<Selection>().unwrap().contains(&run);
    assert!(hits("rope") && hits("rope/axial") && hits("*/axial") && hits("rope/axial/7"));
    assert!(!hits("cable") && !hits("rope/bending") && !hits("rope/axial/0"));
    assert!(
        "rope/axial/7/x".parse::<Selection>().is_err() && "rope//7".parse::<Selection>().is_err()
    );
}

#[test]
fn captures_are_found_by_path_or_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let suite = parsed(&example()).unwrap();
    let rope = &suite.captures[0];
    assert_eq!(suite.locate(rope, None), Path::new("studies/cases/rope.zip"));
    std::fs::write(folder.path().join("rope.zip"), b"").unwrap();
    assert_eq!(suite.locate(rope, Some(folder.path())), folder.path().join("rope.zip"));
    std::fs::create_dir(folder.path().join("cases")).unwrap();
    std::fs::write(folder.path().join("cases/rope.zip"), b"").unwrap();
    assert_eq!(suite.locate(rope, Some(folder.path())), folder.path().join("cases/rope.zip"));
}
