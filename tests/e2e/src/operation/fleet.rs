//! A fleet as docs/run/fleet.md describes it, by commands alone: PostgreSQL, S3, two servers, two
//! workers, TLS on every connection and a key; and the loss of a server in the middle of a fit.

use std::{
    net::TcpListener,
    path::{Path, PathBuf},
    process::Child,
    time::Duration,
};

use serde_json::Value;

use super::on_s3;
use crate::harness::{
    Postgres,
    command::{bendtwin, run_json, run_ok},
    process::Processes,
    reference::capture,
    until, waiting,
};

const SOON: Duration = Duration::from_secs(60);
const WORKER_TOKEN: &str = "workers-of-the-fleet";
/// Settings of a fit of some seconds, as arguments of the command line.
const SETTINGS: [&str; 10] = [
    "--set",
    "graph.max_nodes=40",
    "--set",
    "search.starts=1",
    "--set",
    "search.generations=60",
    "--set",
    "search.population=8",
    "--set",
    "refine.passes=24",
];

struct Fleet {
    folder: tempfile::TempDir,
    processes: Processes,
    /// Each with its port for clients and its port for workers.
    servers: Vec<(Child, u16, u16)>,
    workers: Vec<Child>,
    _postgres: Postgres,
}

impl Fleet {
    fn path(&self, name: &str) -> String {
        path(self.folder.path(), name)
    }

    fn url(&self, server: usize) -> String {
        format!("https://127.0.0.1:{}", self.servers[server].1)
    }

    /// The arguments with which a command calls a server, and shows what is in a file.
    fn to(&self, server: usize, token_file: &str) -> Vec<String> {
        let (url, ca) = (self.url(server), self.path("ca/ca.pem"));
        ["--server", &url, "--ca", &ca, "--token-file", &self.path(token_file)]
            .map(str::to_owned)
            .to_vec()
    }

    fn json(&self, server: usize, arguments: &[&str]) -> Value {
        let to = self.to(server, "robot.key");
        run_json(
            &to.iter().map(String::as_str).chain(arguments.iter().copied()).collect::<Vec<_>>(),
        )
    }
}

impl Drop for Fleet {
    fn drop(&mut self) {
        let servers = self.servers.iter_mut().map(|(child, ..)| child);
        for child in self.workers.iter_mut().chain(servers) {
            child.kill().ok();
            child.wait().ok();
        }
        if std::thread::panicking() {
            let log = std::fs::read_to_string(self.path("log")).unwrap_or_default();
            let tail: Vec<_> = log.lines().rev().take(40).collect();
            tail.into_iter().rev().for_each(|line| eprintln!("  {line}"));
        }
    }
}

fn path(folder: &Path, name: &str) -> String {
    folder.join(name).to_string_lossy().into_owned()
}

fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

fn issue(folder: &Path, role: &str, name: &str) {
    let ca = path(folder, "ca");
    let hosts = ["--host", "127.0.0.1", "--host", "localhost"];
    run_ok(&[&["ca", "issue", &ca, "--role", role, "--name", name][..], &hosts].concat());
}

async fn start(postgres: Postgres, endpoint: &str) -> Fleet {
    let folder = tempfile::Builder::new().prefix("bendtwin-fleet-").tempdir().unwrap();
    let processes = Processes::new(folder.path());
    run_ok(&["ca", "init", &path(folder.path(), "ca")]);
    issue(folder.path(), "server", "server");
    let log = folder.path().join("log");
    let mut servers = Vec::new();
    for number in 0..2 {
        let (clients, workers) = (free_port(), free_port());
        let mut command = bendtwin();
        command
            .args(["server", "--workers", "0", "--listen", &format!("127.0.0.1:{clients}")])
            .args(["--listen-workers-tls", &format!("127.0.0.1:{workers}")])
            .args(["--data-dir", &path(folder.path(), &format!("server-{number}"))])
            .args(["--tls-certificate", &path(folder.path(), "ca/server.pem")])
            .args(["--tls-key", &path(folder.path(), "ca/server.key")])
            .args(["--worker-tls-certificate", &path(folder.path(), "ca/server.pem")])
            .args(["--worker-tls-key", &path(folder.path(), "ca/server.key")])
            .args(["--worker-tls-ca", &path(folder.path(), "ca/ca.pem")])
            .env("BENDTWIN_DATABASE_URL", postgres.url_with_password("none"))
            .env("BENDTWIN_WORKER_TOKEN", WORKER_TOKEN)
            .envs(on_s3::environment(endpoint, &format!("fleet-{}", std::process::id())));
        let child = processes.start(&mut command, &log);
        servers.push((child, clients, workers));
        // The token exists once it has opened the store.
        let token = folder.path().join(format!("server-{number}/client-token"));
        until("the server's token", SOON, async || token.exists().then_some(())).await;
    }
    let urls: Vec<String> =
        servers.iter().map(|(.., port)| format!("https://127.0.0.1:{port}")).collect();
    let mut workers = Vec::new();
    for name in ["worker1", "worker2"] {
        issue(folder.path(), "worker", name);
        let pair = |kind: &str| path(folder.path(), &format!("ca/{name}.{kind}"));
        let mut command = bendtwin();
        command
            .args(["worker", "--backend", "cpu", "--label", name])
            .args(["--server", &urls.join(","), "--ca", &path(folder.path(), "ca/ca.pem")])
            .args(["--certificate", &pair("pem"), "--key", &pair("key")])
            .env("BENDTWIN_WORKER_TOKEN", WORKER_TOKEN);
        workers.push(processes.start(&mut command, &log));
    }
    Fleet { folder, processes, servers, workers, _postgres: postgres }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_fleet_fits_and_plans_through_tls_while_a_server_dies() {
    let Ok(endpoint) = std::env::var("BENDTWIN_TEST_S3") else {
        return eprintln!("SKIPPED: BENDTWIN_TEST_S3 names no S3 server");
    };
    let Some(postgres) = Postgres::start_or_skip().await else { return };
    let _slot = waiting::shared_slot().await;
    let mut fleet = start(postgres, &endpoint).await;

    // A key, made with the token of one server, is as good at the other.
    let admin = fleet.to(0, "server-0/client-token");
    let admin: Vec<&str> = admin.iter().map(String::as_str).collect();
    let scopes = "captures:write,captures:read,fits:write,fits:read,twins:read,rollouts:run";
    let key = fleet.path("robot.key");
    run_ok(
        &[&admin[..], &["key", "create", "robot", "--scope", scopes, "--output", &key]].concat(),
    );
    let names = until("both workers at the second server", SOON, async || {
        let listed = fleet.json(1, &["worker", "list"]);
        let names: Vec<String> = labels(&listed);
        (names.len() == 2).then_some(names)
    })
    .await;
    assert_eq!(names, ["worker1", "worker2"]);

    let archive = PathBuf::from(fleet.path("rope.zip"));
    std::fs::write(&archive, capture().await).unwrap();
    let stored = fleet.json(0, &["capture", "push", &archive.to_string_lossy()]);
    let stored = stored["name"].as_str().unwrap();
    let order = ["fit", "start", stored, "--worker-label", "worker2"];
    let fit = fleet.json(0, &[&order[..], &SETTINGS].concat());
    let fit = fit["name"].as_str().unwrap();
    let show = |server: usize| fleet.json(server, &["fit", "show", fit]);
    until("the fit to be under way", SOON, async || {
        let job = &show(1)["job"];
        (job["progress"]["fraction"].as_f64()? > 0.0).then_some(())
    })
    .await;
    let (first, ..) = &mut fleet.servers[0];
    first.kill().unwrap();
    first.wait().unwrap();

    // At the other server it continues, and its twin answers a planner.
    let ended = fleet.json(1, &["fit", "watch", fit]);
    assert_eq!(
        (&ended["job"]["state"], &ended["job"]["attempts"]),
        (&"SUCCEEDED".into(), &1.into())
    );
    let twin = ended["twin"].as_str().unwrap();
    let moved = fleet.json(1, &["rollout", twin, "--frames", "10"]);
    assert!(moved.is_object(), "{moved}");
    assert_eq!(fleet.processes.workers().len(), 2, "none had to be started again");
}

/// The labels of all workers, sorted.
fn labels(listed: &Value) -> Vec<String> {
    let workers = listed.as_array().or_else(|| listed["workers"].as_array()).unwrap();
    let labels = workers.iter().flat_map(|worker| worker["labels"].as_array().unwrap());
    let mut names: Vec<String> = labels.map(|label| label.as_str().unwrap().to_owned()).collect();
    names.sort();
    names
}
