//! Several recordings of one object: a folder of them as one capture, a twin scored on another
//! recording and refined in it, on this machine and through a server.

use std::path::{Path, PathBuf};

use crate::harness::{
    Setup, TestCluster,
    command::{run, run_json, run_ok},
    reference::FIT,
};

/// Makes a small recording of the toy.
fn take(root: &Path, take: u32) -> PathBuf {
    let file = root.join(format!("take{take}.zip"));
    let number = take.to_string();
    run_ok(&["capture", "make", "toy", &text(&file), "--tiny", "--take", &number]);
    file
}

fn text(path: &Path) -> String {
    path.display().to_string()
}

/// A folder with these recordings of one object.
fn folder(root: &Path, takes: &[u32]) -> PathBuf {
    let folder = root.join("toy");
    for &n in takes {
        let archive = std::fs::File::open(take(root, n)).unwrap();
        let inside = folder.join(format!("take{n}"));
        zip::ZipArchive::new(archive).unwrap().extract(inside).unwrap();
    }
    let document = r#"{"format": "bendtwin-recordings", "version": 1}"#;
    std::fs::write(folder.join("recordings.json"), document).unwrap();
    folder
}

/// A name that no twin has.
fn unnamed() -> String {
    "twins/01999999-9999-7999-8999-999999999999".to_owned()
}

/// Settings of a fit that takes seconds.
pub(crate) const QUICK: [&str; 8] = [
    "--set",
    "graph.max_nodes=30",
    "--set",
    "search.generations=1",
    "--set",
    "search.starts=1",
    "--set",
    "refine.passes=2",
];

fn eval(paths: &[&str]) -> serde_json::Value {
    run_json(&[&["eval"], paths, &QUICK].concat())
}

#[test]
fn recordings_are_fitted_scored_and_refined_on_this_machine() {
    let root = tempfile::tempdir().unwrap();
    let folder = text(&folder(root.path(), &[0, 1]));
    let other = text(&take(root.path(), 2));
    let twin = text(&root.path().join("toy.twin"));
    let checked = run_ok(&["capture", "check", &folder]);
    assert!(checked.contains("can be fitted"), "{checked}");

    let fitted = eval(&[&folder, "--out", &twin]);
    let recordings = fitted["quality"]["recordings"].as_array().unwrap();
    assert_eq!(recordings.len(), 2, "{fitted}");
    assert!(recordings[0]["registered"].is_null() && recordings[1]["name"] == "take1");

    let table = run_ok(&["eval", &other, "--twin", &twin]);
    assert!(table.contains("registered within"), "{table}");
    let scored = run_json(&["eval", &other, "--twin", &twin]);
    let own = &scored["quality"]["scores"][0];
    // All frames of a recording that the twin was not fitted to are future ones.
    assert!(own["train"]["track_m"].is_null() && own["future"]["track_m"].is_number(), "{own}");

    let refined = text(&root.path().join("refined.twin"));
    eval(&[&other, "--from", &twin, "--out", &refined]);
    let own = run_json(&["eval", &other, "--twin", &refined]);
    assert!(own["quality"].get("recordings").is_none(), "{own}");

    let bar = text(&root.path().join("cable.zip"));
    run_ok(&["capture", "make", "cable", &bar, "--tiny"]);
    let refused = run(&["eval", &bar, "--twin", &twin]);
    assert!(!refused.status.success());
    let said = String::from_utf8_lossy(&refused.stderr);
    assert!(said.contains("does not fit the capture"), "{said}");
}

#[tokio::test(flavor = "multi_thread")]
async fn recordings_are_fitted_and_evaluated_through_a_server() {
    let server = TestCluster::start(Setup::default()).await;
    let (url, api) = (server.url(), server.api());
    let root = tempfile::tempdir().unwrap();
    let folder = text(&folder(root.path(), &[0, 1]));
    let other = text(&take(root.path(), 2));
    let push = |path: &str| {
        let capture = run_json(&["--server", &url, "capture", "push", path, "--watch"]);
        capture["name"].as_str().unwrap().to_owned()
    };
    let (toy, unseen) = (push(&folder), push(&other));
    let settings = r#"{"graph": {"max_nodes": 30}, "search": {"generations": 1, "starts": 1},
        "refine": {"passes": 2}}"#;
    let fit = api.fit(&toy, settings, 0).await.unwrap();
    let twin = api.succeeded(&fit.name, FIT).await.twin;
    let quality: serde_json::Value =
        serde_json::from_str(&api.get_twin(&twin).await.unwrap().quality_json).unwrap();
    assert_eq!(quality["recordings"][1]["name"], "take1", "{quality}");

    let evaluated = run_json(&["--server", &url, "twin", "evaluate", &twin, &unseen]);
    let recording = &evaluated["quality"]["recordings"][0];
    assert!(recording["registered"]["median_mm"].is_number(), "{evaluated}");
    assert!(evaluated["quality"]["assessment"]["level"].is_string(), "{evaluated}");
    let table = run_ok(&["--server", &url, "twin", "evaluate", &twin, &unseen]);
    assert!(table.contains("Verdict: "), "{table}");
    let started = run_json(&[
        "--server",
        &url,
        "fit",
        "start",
        &unseen,
        "--from",
        &twin,
        "--set",
        "refine.passes=2",
    ]);
    let refined = api.succeeded(started["name"].as_str().unwrap(), FIT).await.twin;
    let own = run_json(&["--server", &url, "twin", "evaluate", &refined, &unseen]);
    assert!(own["quality"].get("recordings").is_none(), "it is its own capture: {own}");
    let nothing = run(&["--server", &url, "fit", "start", &unseen, "--from", &unnamed()]);
    assert!(!nothing.status.success());
    // Its own capture needs no registration of the reference.
    let own = run_json(&["--server", &url, "twin", "evaluate", &twin, &toy]);
    assert_eq!(own["quality"]["scores"][0], quality["scores"][0], "{own}");
}
