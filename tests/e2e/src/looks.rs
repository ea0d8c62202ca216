//! The look of a twin of a raw recording: coloured and measured on this machine, and with Gaussians
//! trained through a server.

use bendtwin_core::Twin;

use crate::{
    harness::{
        Setup, TestCluster,
        command::{run_json, run_ok},
    },
    recordings::several_recordings::QUICK,
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
    let videos = root.path().join("videos");
    let into = videos.display().to_string();
    let pairs = root.path().join("pairs").display().to_string();
    let options = ["eval", &folder, "--axial", "--out", &file, "--video", &into, "--pairs", &pairs];
    let fitted = run_json(&[&options[..], &QUICK[..]].concat());
    let scores = fitted["quality"]["scores"].as_array().unwrap();
    let of = |predictor: &str| scores.iter().find(|s| s["predictor"] == predictor).unwrap();
    assert!(iou(of("bending")) > 0.3 && iou(of("axial")) > 0.3, "{fitted}");
    assert!(of("standing_still")["rendered"].is_null());
    let twin = Twin::decode(&std::fs::read(&file).unwrap()).unwrap();
    let appearance = twin.appearance.unwrap();
    assert_eq!((appearance.skin_colors.len(), appearance.splats), (twin.skin.len(), None));
    for name in ["camera0.png", "camera1.png", "camera0-axial.png", "camera1-axial.png"] {
        let bytes = std::fs::read(videos.join(name)).unwrap();
        // An animated PNG says how many frames it has.
        assert!(bytes.windows(4).any(|w| w == b"acTL"), "{name}");
    }
    assert_eq!(fitted["videos"].as_array().unwrap().len(), 4);
    let names = |part: &str| {
        let all = std::fs::read_dir(&pairs).unwrap().map(|e| e.unwrap().file_name());
        all.filter(|name| name.to_str().unwrap().starts_with(part)).count()
    };
    assert!(names("camera0-training-0") > 3 && names("camera1-axial-future-0") > 0, "{pairs}");
    // What is measured again is the same, frame by frame.
    let again = run_json(&["eval", &folder, "--twin", &file, "--per-frame"]);
    let rendered = &again["quality"]["scores"][0]["rendered"];
    assert_eq!(rendered["train"], of("bending")["rendered"]["train"]);
    assert!(rendered["per_frame"].as_array().unwrap().len() > 3, "{rendered}");
}

#[test]
fn a_twin_is_rendered_into_another_recording_of_its_object() {
    let root = tempfile::tempdir().unwrap();
    let folder = filmed(root.path());
    let file = root.path().join("toy.twin").display().to_string();
    run_ok(&[&["eval", &folder, "--out", &file], &QUICK[..]].concat());
    let other = root.path().join("other").display().to_string();
    run_ok(&["capture", "make", "toy", &other, "--raw", "--tiny", "--seed", "1"]);
    let scored = run_json(&["eval", &other, "--twin", &file]);
    assert!(scored["quality"]["recordings"][0]["registered"].is_object(), "{scored}");
    let own = &scored["quality"]["scores"][0];
    assert!(iou(own) > 0.3, "{own}");
    assert_eq!(own["rendered"]["cameras"].as_array().unwrap().len(), 2);
}

#[test]
fn a_frame_is_exported_for_trainers_of_gaussians() {
    let root = tempfile::tempdir().unwrap();
    let folder = filmed(root.path());
    let scan = root.path().join("scan");
    let written = run_json(&["capture", "export", &folder, &scan.display().to_string()]);
    assert_eq!(written["images"], 2);
    let text = std::fs::read_to_string(scan.join("transforms.json")).unwrap();
    let document: serde_json::Value = serde_json::from_str(&text).unwrap();
    for frame in document["frames"].as_array().unwrap() {
        for part in ["file_path", "mask_path", "depth_file_path"] {
            assert!(scan.join(frame[part].as_str().unwrap()).is_file(), "{frame}");
        }
    }
    assert!(scan.join(document["ply_file_path"].as_str().unwrap()).is_file());
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
