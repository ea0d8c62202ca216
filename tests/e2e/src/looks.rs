//! The look of a twin of a raw recording: coloured and measured on this machine, and with Gaussians
//! trained through a server.

use bendtwin_core::Twin;

use crate::{
    harness::{
        Setup, TestCluster,
        command::{run_json, run_ok},
    },
    several_recordings::QUICK,
};

/// Films a small toy. Returns its folder.
fn filmed(root: &std::path::Path) -> String {
    let folder = root.join("toy").display().to_string();
    run_ok(&["capture", "make", "toy", &folder, "--raw", "--tiny"]);
    folder
}

fn iou(score: &serde_json::Value) -> f64 {
    score["rendered"]["train"]["iou"].as_f64().unwrap()
}

#[test]
fn a_fit_on_this_machine_colours_its_twin_and_measures_it() {
    let root = tempfile::tempdir().unwrap();
    let folder = filmed(root.path());
    let file = root.path().join("toy.twin").display().to_string();
    let arguments = [&["eval", &folder, "--axial", "--out", &file], &QUICK[..]].concat();
    let fitted = run_json(&arguments);
    let scores = fitted["quality"]["scores"].as_array().unwrap();
    let of = |predictor: &str| scores.iter().find(|s| s["predictor"] == predictor).unwrap();
    assert!(iou(of("bending")) > 0.3 && iou(of("axial")) > 0.3, "{fitted}");
    assert!(of("standing_still")["rendered"].is_null());
    let twin = Twin::decode(&std::fs::read(&file).unwrap()).unwrap();
    let appearance = twin.appearance.unwrap();
    assert_eq!((appearance.skin_colors.len(), appearance.splats), (twin.skin.len(), None));
    // What is measured again is the same, frame by frame.
    let again = run_json(&["eval", &folder, "--twin", &file, "--per-frame"]);
    let rendered = &again["quality"]["scores"][0]["rendered"];
    assert_eq!(rendered["train"], of("bending")["rendered"]["train"]);
    assert!(rendered["per_frame"].as_array().unwrap().len() > 3, "{rendered}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_fit_through_a_server_trains_gaussians() {
    let cluster = TestCluster::start(Setup::default()).await;
    let url = cluster.url();
    let root = tempfile::tempdir().unwrap();
    let folder = filmed(root.path());
    tokio::task::spawn_blocking(move || {
        let capture = run_json(&["--server", &url, "capture", "push", &folder, "--watch"]);
        let capture = capture["name"].as_str().unwrap().to_owned();
        let start = ["--server", &url, "fit", "start", &capture, "--watch"];
        let training = ["--set", "appearance.gaussians=2000", "--set", "appearance.steps=160"];
        let fit = run_json(&[&start, &QUICK[..], &training].concat());
        let twin = fit["twin"].as_str().unwrap().to_owned();
        let file = root.path().join("toy.safetensors").display().to_string();
        run_ok(&["--server", &url, "twin", "export", &twin, &file]);
        let twin = Twin::decode(&std::fs::read(&file).unwrap()).unwrap();
        let rendered = twin.quality.scores[0].rendered.clone().unwrap();
        let splats = twin.appearance.unwrap().splats.unwrap();
        assert_eq!(rendered.gaussians as usize, splats.len());
        assert!(rendered.train.iou.unwrap() > 0.3, "{rendered:?}");
    })
    .await
    .unwrap();
}
