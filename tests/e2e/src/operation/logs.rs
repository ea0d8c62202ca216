//! The log of a server and of its own workers, in the form that a flag asks for.

use serde_json::Value;

use crate::harness::{cluster::START, command::bendtwin, process::Processes, until};

#[tokio::test]
async fn the_format_of_a_flag_holds_for_own_workers() {
    let folder = tempfile::Builder::new().prefix("bendtwin-e2e-").tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let processes = Processes::new(folder.path());
    let mut command = bendtwin();
    command.env_remove("BENDTWIN_LOG_FORMAT").env("XDG_STATE_HOME", path("state"));
    command.args(["--log-format", "json", "server", "--listen", "127.0.0.1:0", "--workers", "1"]);
    command.arg("--data-dir").arg(path("data"));
    let mut server = processes.start(&mut command, &path("log"));
    let lines = || -> Vec<String> {
        let log = std::fs::read_to_string(path("log")).unwrap_or_default();
        // Results are on standard output: they are for people.
        let whole = log[..log.rfind('\n').unwrap_or(0)].lines();
        whole.filter(|line| !line.starts_with("BendTwin answers")).map(str::to_owned).collect()
    };
    until("a line of the worker", START, async || {
        lines().iter().any(|line| line.contains("bendtwin_worker")).then_some(())
    })
    .await;
    server.kill().unwrap();
    server.wait().unwrap();
    let lines = lines();
    let of_worker = lines.iter().find(|line| line.contains("bendtwin_worker")).unwrap();
    let read: Value = serde_json::from_str(of_worker).unwrap_or_else(|_| panic!("{of_worker}"));
    assert!(read["target"].as_str().unwrap().starts_with("bendtwin_worker"), "{read}");
}
