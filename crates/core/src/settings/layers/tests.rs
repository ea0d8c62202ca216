use serde_json::json;

use super::*;
use crate::settings::{GradientWindow, Substeps};

#[test]
fn changes_over_the_defaults_give_the_same_settings() {
    let mut one = FitSettings { seed: 3, bending: false, ..FitSettings::default() };
    one.refine.window = GradientWindow::Frames(4);
    one.graph.radius_m = Some(0.031);
    for settings in [FitSettings::default(), FitSettings::phystwin(), one] {
        let mut document = defaults();
        for (path, value) in changes(&settings) {
            let nested = path.rsplit('.').fold(value, |inner, key| json!({ key: inner }));
            merge(&mut document, nested);
        }
        assert_eq!(serde_json::from_value::<FitSettings>(document).unwrap(), settings);
    }
    assert_eq!(changes(&FitSettings::default()), []);
}

#[test]
fn a_later_layer_wins_where_it_speaks() {
    let mut document = defaults();
    merge(&mut document, json!({"substeps": {"fixed": 667}, "refine": {"passes": 9}}));
    merge(&mut document, json!({"refine": {"passes": 5, "window": {"frames": 3}}}));
    merge(&mut document, json!({"refine": {"window": "frame"}}));
    let settings: FitSettings = serde_json::from_value(document).unwrap();
    assert_eq!(settings.substeps, Substeps::Fixed(667));
    assert_eq!((settings.refine.passes, settings.refine.window), (Some(5), GradientWindow::Frame));
}

#[test]
fn every_unknown_field_is_found() {
    let document =
        json!({"graf": 1, "graph": {"radius": 1, "radius_m": 2}, "substeps": {"fixed": 3}});
    assert_eq!(unknown_fields(&document), ["graf", "graph.radius"]);
}

#[test]
fn every_fault_is_reported_with_its_path() {
    let document = json!({
        "graph": {"max_nodes": "many", "radius": 0.1},
        "refine": {"passes": -2, "learning_rate": true},
        "substeps": {"auto": {"safety": "x"}},
        "bending": 1,
        "seed": 4,
    });
    let faults = read::<FitSettings>(document).unwrap_err();
    let starts = [
        "bending: invalid type: integer `1`, expected true or false",
        "graph.max_nodes: invalid type: string \"many\", expected a whole number, 0 or more",
        "graph.radius: unknown field `radius`, expected one of",
        "refine.learning_rate: invalid type: boolean `true`, expected a number",
        "refine.passes: invalid value: integer `-2`, expected a whole number, 0 or more",
        "substeps: invalid type: string \"x\", expected a number",
    ];
    assert_eq!(faults.len(), starts.len(), "{faults:#?}");
    for (fault, start) in faults.iter().zip(starts) {
        assert!(fault.starts_with(start), "{fault}");
    }
}

#[test]
fn settings_are_an_object_and_their_faults_are_bounded() {
    for document in [json!([1, 2]), json!(3), json!(null)] {
        assert_eq!(read::<FitSettings>(document).unwrap_err(), ["they are not a JSON object"]);
    }
    let wrong: Map<_, _> = (0..10_000).map(|i| (format!("x{i}"), json!(1))).collect();
    assert_eq!(read::<FitSettings>(Value::Object(wrong)).unwrap_err().len(), MOST_FAULTS);
    assert_eq!(read::<FitSettings>(json!({})), Ok(FitSettings::default()));
}
