//! A worker whose certificate is revoked: by commands alone, it loses its connections and its fit,
//! and a newly issued certificate lets it in again.

use std::{path::Path, process::Child, time::Duration};

use serde_json::Value;

use crate::harness::{
    Setup, TestCluster,
    command::{bendtwin, run, run_json, run_ok},
    process::Processes,
    reference::capture,
    until,
};

const SOON: Duration = Duration::from_secs(60);
const WORKER_TOKEN: &str = "end-to-end-worker-token";
/// Settings of a fit that is under way for as long as the test needs it.
const SETTINGS: [&str; 8] = [
    "--set",
    "graph.max_nodes=40",
    "--set",
    "search.starts=1",
    "--set",
    "search.generations=2000",
    "--set",
    "search.population=8",
];

/// Workers with certificates, each with a separate log.
struct Workers {
    processes: Processes,
    children: Vec<Child>,
}

impl Workers {
    fn start(&mut self, folder: &Path, server: &str, name: &str) {
        let path = |name: &str| folder.join(name).to_string_lossy().into_owned();
        let mut command = bendtwin();
        command
            .args(["worker", "--backend", "cpu", "--label", name, "--server", server])
            .args(["--ca", &path("ca/ca.pem"), "--crl", &path("ca/crl.pem")])
            .args(["--certificate", &path(&format!("ca/{name}.pem"))])
            .args(["--key", &path(&format!("ca/{name}.key"))])
            .env("BENDTWIN_WORKER_TOKEN", WORKER_TOKEN);
        self.children.push(self.processes.start(&mut command, &folder.join(name)));
    }
}

impl Drop for Workers {
    fn drop(&mut self) {
        for child in &mut self.children {
            child.kill().ok();
            child.wait().ok();
        }
    }
}

fn issue(ca: &str, role: &str, name: &str, more: &[&str]) {
    let order = ["ca", "issue", ca, "--role", role, "--name", name, "--host", "127.0.0.1"];
    run_ok(&[&order[..], more].concat());
}

/// The label of the worker that has a fit; `None` while no worker has one.
fn fitting(workers: &Value) -> Option<String> {
    let mut all = workers.as_array().unwrap().iter();
    let worker = all.find(|worker| worker["fit"].is_string())?;
    worker["labels"][0].as_str().map(str::to_owned)
}

#[tokio::test(flavor = "multi_thread")]
async fn a_revoked_worker_loses_its_fit_and_comes_back_with_another_certificate() {
    let folder = tempfile::tempdir().unwrap();
    let ca = folder.path().join("ca");
    let file = |name: &str| ca.join(name).to_string_lossy().into_owned();
    let ca = ca.to_str().unwrap();
    run_ok(&["ca", "init", ca]);
    issue(ca, "server", "server", &[]);
    let port = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let environment = vec![
        ("BENDTWIN_LISTEN_WORKERS_TLS", format!("127.0.0.1:{port}")),
        ("BENDTWIN_WORKER_TLS_CERTIFICATE", file("server.pem")),
        ("BENDTWIN_WORKER_TLS_KEY", file("server.key")),
        ("BENDTWIN_WORKER_TLS_CA", file("ca.pem")),
        ("BENDTWIN_WORKER_TLS_CRL", file("crl.pem")),
    ];
    let cluster =
        TestCluster::start(Setup { own_workers: 0, environment, ..Setup::default() }).await;
    let mut workers = Workers { processes: Processes::new(folder.path()), children: Vec::new() };
    for name in ["gpu1", "gpu2"] {
        issue(ca, "worker", name, &[]);
        workers.start(folder.path(), &format!("https://127.0.0.1:{port}"), name);
    }
    let url = cluster.url();
    let json = |arguments: &[&str]| run_json(&[&["--server", &url], arguments].concat());
    let count = |listed: &Value| listed.as_array().unwrap().len();
    let all = |number: usize| {
        until("the workers", SOON, async move || {
            (count(&json(&["worker", "list"])) == number).then_some(())
        })
    };
    all(2).await;

    let archive = cluster.path("rope.zip");
    std::fs::write(&archive, capture().await).unwrap();
    let stored = json(&["capture", "push", &archive]);
    json(&[&["fit", "start", stored["name"].as_str().unwrap()][..], &SETTINGS].concat());
    let holder =
        until("a worker to take the fit", SOON, async || fitting(&json(&["worker", "list"]))).await;
    run_ok(&["ca", "revoke", ca, &holder]);
    let next = until("the other worker to take the fit", SOON, async || {
        fitting(&json(&["worker", "list"])).filter(|label| *label != holder)
    })
    .await;
    assert_ne!(next, holder);
    assert!(cluster.log().contains("connection ended for its certificate"), "{}", cluster.log());
    all(1).await;
    let log = || std::fs::read_to_string(folder.path().join(&holder)).unwrap();
    until("the worker to say why", SOON, async || log().contains("was revoked").then_some(()))
        .await;

    let issued = run_json(&["ca", "list", ca]);
    let revoked: Vec<_> =
        issued.as_array().unwrap().iter().filter(|one| one["revoke_time"].is_string()).collect();
    assert_eq!(revoked.len(), 1, "{issued}");
    assert_eq!(revoked[0]["name"], *holder);
    // A list that is damaged changes nothing, and the log says so.
    let good = std::fs::read(file("crl.pem")).unwrap();
    std::fs::write(file("crl.pem"), "no list").unwrap();
    until("the log to tell of the damaged list", SOON, async || {
        cluster.log().contains("those before stay in force").then_some(())
    })
    .await;
    assert!(!run(&["ca", "revoke", ca, "gpu1"]).status.success());
    std::fs::write(file("crl.pem"), good).unwrap();
    assert_eq!(count(&json(&["worker", "list"])), 1);

    issue(ca, "worker", &holder, &["--renew"]);
    all(2).await;
}
