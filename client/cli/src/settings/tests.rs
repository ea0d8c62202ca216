use bendtwin_core::settings::{GradientWindow, Substeps};

use super::*;

fn with(overrides: &[&str]) -> anyhow::Result<FitSettings> {
    let overrides = overrides.iter().map(|s| (*s).to_owned()).collect();
    SettingsArgs { overrides, ..SettingsArgs::default() }.resolve()
}

#[test]
fn overrides_reach_every_depth() {
    let settings = with(&[
        "seed=7",
        "bending=false",
        "graph.max_nodes=400",
        "graph.triplet_reference=nearest",
        "refine.window={\"frames\": 5}",
        "substeps.fixed=200",
    ])
    .unwrap();
    assert_eq!((settings.seed, settings.bending), (7, false));
    assert_eq!(settings.graph.max_nodes, Some(400));
    assert_eq!(settings.refine.window, GradientWindow::Frames(5));
    assert_eq!(settings.substeps, Substeps::Fixed(200));
    let auto = with(&["substeps.auto.max=900"]).unwrap();
    assert!(matches!(auto.substeps, Substeps::Auto { max: Some(900), .. }));
}

#[test]
fn wrong_overrides_say_what_there_is() {
    let message = |text: &str| {
        let error = with(&[text]).unwrap_err();
        assert!(error.is::<Usage>(), "{text} must be a usage error");
        error.to_string()
    };
    assert!(message("seed").contains("key=value"));
    assert!(message("graph.max_node=4").contains("max_nodes"));
    assert!(message("graph.max_nodes=many").contains("graph.max_nodes: invalid type: string"));
    assert!(message("refine.learning_rate=-1").contains("refine.learning_rate"));
}

#[test]
fn all_faults_are_reported_together() {
    let error = with(&["graph.max_nodes=many", "refine.passes=-2", "graf=1", "seed"]).unwrap_err();
    let message = error.to_string();
    for part in ["graph.max_nodes: ", "refine.passes: ", "no `graf`", "--set seed: write key=value"]
    {
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn a_file_changes_only_what_it_names() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("settings.json");
    std::fs::write(&path, r#"{"substeps": {"fixed": 99}, "refine": {"passes": 3}}"#).unwrap();
    let args = SettingsArgs { settings: Some(path), axial: true, ..SettingsArgs::default() };
    let settings = args.resolve().unwrap();
    assert_eq!(settings.substeps, Substeps::Fixed(99));
    assert_eq!(settings.refine.passes, Some(3));
    assert_eq!(settings.refine.beta1, FitSettings::default().refine.beta1);
    assert!(settings.compare_axial);
}

#[test]
fn effort_and_time_are_words() {
    let args = SettingsArgs {
        effort: Some(effort("draft").unwrap()),
        within: Some(seconds("1.5m").unwrap()),
        ..SettingsArgs::default()
    };
    let settings = args.resolve().unwrap();
    assert_eq!((settings.effort, settings.within_s), (Effort::Draft, Some(90.0)));
    assert_eq!(seconds("60"), Ok(60.0));
    assert_eq!(seconds("2 h"), Ok(7200.0));
    assert!(effort("more").unwrap_err().contains("standard"));
    for wrong in ["", "s", "-3s", "soon", "nan", "1e400"] {
        assert!(seconds(wrong).is_err(), "{wrong}");
    }
}
