//! A user who asks what is amiss: without a server, beside one, at a port that another program
//! has; and a server that cannot listen, which leaves nothing behind.

use std::net::TcpListener;

use serde_json::Value;

use crate::harness::{
    Setup, TestCluster,
    command::{bendtwin, run},
};

/// Findings of the command, as names, states and messages.
async fn doctor(arguments: &[&str]) -> Vec<[String; 3]> {
    let mut command = bendtwin();
    command.args(["--json", "doctor"]).args(arguments);
    let output = tokio::task::spawn_blocking(move || command.output().unwrap()).await.unwrap();
    let checks: Vec<Value> = serde_json::from_slice(&output.stdout).unwrap();
    let text = |check: &Value, key: &str| check[key].as_str().unwrap().to_owned();
    let checks: Vec<[String; 3]> =
        checks.iter().map(|c| ["name", "state", "message"].map(|key| text(c, key))).collect();
    let is_well = checks.iter().all(|[_, state, _]| state != "problem");
    assert_eq!(output.status.success(), is_well, "{checks:#?}");
    checks
}

/// Requires a check of this name and state whose message contains a text.
fn require(checks: &[[String; 3]], name: &str, state: &str, text: &str) {
    let is_it = |[n, s, message]: &[String; 3]| n == name && s == state && message.contains(text);
    assert!(checks.iter().any(is_it), "no {name} {state} with `{text}`: {checks:#?}");
}

#[tokio::test]
async fn a_healthy_server_is_healthy_and_what_is_amiss_is_named() {
    let server = TestCluster::start(Setup::default()).await;
    let (url, folder) = (server.url(), server.data_dir().display().to_string());
    let listen = url.trim_start_matches("http://").to_owned();
    // An address without a scheme will do.
    let arguments = ["--server", &listen, "--listen", &listen, "--data-dir", &folder];
    let checks = doctor(&arguments).await;
    assert!(checks.iter().all(|[_, state, _]| state != "problem"), "{checks:#?}");
    require(&checks, "data", "ok", "a server has it open");
    require(&checks, "address", "ok", "bendtwin");
    require(&checks, "worker", "ok", "workers/");
}

#[tokio::test]
async fn a_taken_port_is_reported_and_leaves_no_folder() {
    let other = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = other.local_addr().unwrap().to_string();
    let folder = tempfile::tempdir().unwrap();
    let data_dir = folder.path().join("data");
    let (shown, listen) = (data_dir.display().to_string(), address.clone());
    let refused = tokio::task::spawn_blocking(move || {
        run(&["server", "--listen", &listen, "--data-dir", &shown])
    });
    let refused = refused.await.unwrap();
    let message = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(!refused.status.success() && message.contains("--listen"), "{message}");
    assert!(!data_dir.exists());

    // It never answers, as another kind of server may.
    std::thread::spawn(move || other.incoming().for_each(drop));
    let checks = doctor(&["--listen", &address, "--server", "127.0.0.1:1"]).await;
    require(&checks, "address", "problem", "another program");
    require(&checks, "server", "problem", "bendtwin server");
}

#[tokio::test]
async fn a_data_folder_that_cannot_be_one_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "x").unwrap();
    let shown = file.display().to_string();
    let refused = {
        let shown = shown.clone();
        let starting = move || run(&["server", "--listen", "127.0.0.1:0", "--data-dir", &shown]);
        tokio::task::spawn_blocking(starting).await.unwrap()
    };
    let message = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(!refused.status.success() && message.contains(&shown), "{message}");
    let checks = doctor(&["--data-dir", &shown, "--listen", "127.0.0.1:0"]).await;
    require(&checks, "data", "problem", &shown);
}
