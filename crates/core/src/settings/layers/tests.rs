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
