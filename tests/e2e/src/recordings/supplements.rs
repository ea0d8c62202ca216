//! Files that are added to captures after their upload.

use bendtwin_proto::v1::CancelIngestRequest;
use reqwest::Method;
use serde_json::{Value, json};

use crate::harness::{
    Setup, TestCluster,
    command::{run, run_json, run_ok},
    reference::capture,
};

/// A server without workers, and a capture whose ingest has been cancelled.
async fn idle() -> (TestCluster, String) {
    let server = TestCluster::start(Setup { own_workers: 0, ..Setup::default() }).await;
    let name = server.api().upload(&capture().await, "").await.unwrap().name;
    let cancel = CancelIngestRequest { name: name.clone() };
    server.api().captures().cancel_ingest(cancel).await.unwrap();
    (server, name)
}

#[tokio::test]
async fn acknowledged_supplements_survive_kill_9() {
    let (mut server, name) = idle().await;
    let path = format!("/v1/{name}/supplements/masks");
    for round in 0..5 {
        let masks = vec![round; 300_000];
        let added = server.http().request(Method::PUT, &path).body(masks.clone());
        assert_eq!(added.send().await.unwrap().status(), 200);
        server.kill();
        server.start_again().await;
        let kept = server.http().get(&path).await.bytes().await.unwrap();
        assert!(kept == masks, "round {round}");
    }
    let removed = server.http().request(Method::DELETE, &path).send().await.unwrap();
    assert_eq!(removed.status(), 204);
    server.kill();
    server.start_again().await;
    assert_eq!(server.http().request(Method::GET, &path).send().await.unwrap().status(), 404);
}

#[tokio::test]
async fn masks_and_a_calibration_are_added_and_clicks_made_by_command_line() {
    let (server, name) = idle().await;
    let (url, case) = (server.url(), server.path("case"));
    let (calibration, other) = (server.path("calibration.json"), server.path("camchain.yaml"));
    let (masks, kept) = (server.path("masks.zip"), server.path("kept.zip"));
    std::fs::create_dir_all(format!("{case}/mask/0/object")).unwrap();
    std::fs::write(format!("{case}/mask/0/object/0.png"), "png").unwrap();
    std::fs::write(format!("{case}/metadata.json"), "{}").unwrap();
    let document = json!({"format": "bendtwin-calibration", "version": 1, "cameras": []});
    std::fs::write(&calibration, document.to_string()).unwrap();
    std::fs::write(&other, "cam0: {}").unwrap();
    let of_server = server.http().get(&format!("/v1/{name}/supplements/masks")).await;
    assert_eq!(of_server.status(), 404);
    let capture = name.clone();
    tokio::task::spawn_blocking(move || {
        let at = ["--server", url.as_str()];
        let added = ["capture", "add", &capture, "--masks", &case, "--calibration", &calibration];
        let added = run_json(&[&added[..], &at].concat());
        let kinds = added["supplements"].as_array().unwrap().iter().map(|s| s["kind"].clone());
        assert_eq!(kinds.collect::<Value>(), json!(["masks", "calibration"]));
        let shown = run_ok(&[&["capture", "show", &capture], &at[..]].concat());
        assert!(shown.contains("added    masks"), "{shown}");
        for (wrong, said) in [
            (vec!["capture", "add", &capture], "--masks"),
            (vec!["capture", "add", &capture, "--calibration", &other], "capture calibrate"),
            (vec!["capture", "masks", &capture, "--out", &masks], "no masks"),
            (vec!["capture", "ingest", &capture, "--object", "120,88"], "0:120,88"),
            (vec!["capture", "ingest", &capture, "--object", "0:1,2", "--cancel"], "--cancel"),
        ] {
            let refused = run(&[&wrong[..], &at].concat());
            assert!(!refused.status.success());
            let text = String::from_utf8_lossy(&refused.stderr).into_owned();
            assert!(text.contains(said), "{wrong:?}: {text}");
        }
        run_ok(&[&["capture", "remove", &capture, "calibration"], &at[..]].concat());

        let ingest = |args: &[&str]| {
            let asked = run_json(&[&["capture", "ingest", &capture], args, &at].concat());
            run_ok(&[&["capture", "ingest", &capture, "--cancel"], &at[..]].concat());
            asked["ingest"]["settings"].clone()
        };
        let marked = ingest(&["--until", "masks", "--object", "0:120,88", "--hand", "1@3:7,9"]);
        assert_eq!(marked["until"], "masks");
        assert_eq!(marked["strokes"][1]["frame"], 3, "{marked}");
        let corrected = ingest(&["--keep", "--until", "points", "--background", "0:1,2"]);
        assert_eq!(corrected["until"], "points");
        assert_eq!(corrected["strokes"].as_array().unwrap().len(), 3);
        assert_eq!(ingest(&[])["strokes"], json!([]), "without --keep it begins anew");
    })
    .await
    .unwrap();
    // An archive with the masks alone.
    let sent = server.http().get(&format!("/v1/{name}/supplements/masks")).await;
    std::fs::write(&kept, sent.bytes().await.unwrap()).unwrap();
    let mut archive = zip::ZipArchive::new(std::fs::File::open(&kept).unwrap()).unwrap();
    assert_eq!(archive.len(), 1);
    assert_eq!(archive.by_index(0).unwrap().name().unwrap(), "mask/0/object/0.png");
}
