//! The first commands of a new user: make a capture, push it, fit it, roll the twin out.

use serde_json::Value;

use crate::harness::{
    TestCluster,
    command::{run, run_json, run_ok},
};

#[tokio::test]
async fn from_capture_to_rollout_by_command_line() {
    let server = TestCluster::ordinary().await;
    let (url, capture, twin_file) =
        (server.url(), server.path("rope.zip"), server.path("rope.twin"));
    let settings = server.path("settings.json");
    std::fs::write(&settings, crate::harness::reference::SETTINGS).unwrap();

    tokio::task::spawn_blocking(move || {
        let at = ["--server", url.as_str()];
        run_ok(&["capture", "make", "rope", &capture]);
        let check = run_ok(&["capture", "check", &capture]);
        assert!(!check.is_empty(), "a check says something");

        let pushed = run_json(&[&["capture", "push", &capture], &at[..]].concat());
        let name = text(&pushed, "name");
        let listed = run_json(&[&["capture", "list"], &at[..]].concat());
        assert!(listed.to_string().contains(&name), "{listed}");

        let fit = run_json(
            &[&["fit", "start", &name, "--settings", &settings, "--watch"], &at[..]].concat(),
        );
        let twin = text(&fit, "twin");
        let shown = run_json(&[&["twin", "show", &twin], &at[..]].concat());
        assert!(shown.to_string().contains("standing_still"), "no quality table: {shown}");
        run_ok(&[&["twin", "export", &twin, &twin_file], &at[..]].concat());
        let file = std::fs::read(&twin_file).unwrap();
        assert!(bendtwin_core::Twin::decode(&file).unwrap().graph.node_count() > 0);

        let rollout = run_json(&[&["rollout", &twin], &at[..]].concat());
        assert!(rollout.is_object() || rollout.is_array(), "{rollout}");

        let failed = run(&[&["twin", "show", "twins/none"], &at[..]].concat());
        let message = String::from_utf8_lossy(&failed.stderr).into_owned();
        assert!(!failed.status.success());
        assert!(message.contains("twins/"), "an error says what to do: {message}");
        assert!(!message.contains("panicked"), "{message}");
    })
    .await
    .unwrap();
}

fn text(value: &Value, field: &str) -> String {
    let found = value[field].as_str();
    found.unwrap_or_else(|| panic!("no `{field}` in {value}")).to_owned()
}
