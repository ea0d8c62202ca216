//! `bendtwin healthcheck` beside a server and a worker with TLS, as the health checks of containers run
//! it: with their options in the environment.

use std::{
    net::TcpListener,
    path::Path,
    process::{Child, Command},
    time::Duration,
};

use crate::harness::{
    command::{bendtwin, run_ok},
    process::Processes,
    until,
};

const SOON: Duration = Duration::from_secs(60);

/// Programs that end with the test.
struct Running(Vec<Child>);

impl Drop for Running {
    fn drop(&mut self) {
        for child in &mut self.0 {
            child.kill().ok();
            child.wait().ok();
        }
    }
}

fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

/// Exit status, and what it says.
async fn checked(arguments: &[&str], environment: &[(&str, String)]) -> (Option<i32>, String) {
    let mut command = bendtwin();
    command.arg("healthcheck").args(arguments).envs(environment.iter().cloned());
    let run = move || command.output().unwrap();
    let done = tokio::task::spawn_blocking(run).await.unwrap();
    let said = [done.stdout, done.stderr].concat();
    (done.status.code(), String::from_utf8(said).unwrap())
}

fn issue(folder: &Path, role: &str, hosts: &[&str]) {
    let ca = folder.join("ca").to_string_lossy().into_owned();
    let hosts: Vec<&str> = hosts.iter().flat_map(|host| ["--host", host]).collect();
    run_ok(&[&["ca", "issue", &ca, "--role", role, "--name", role][..], &hosts].concat());
}

#[tokio::test(flavor = "multi_thread")]
async fn a_server_and_a_worker_with_tls_are_found_healthy_by_their_options() {
    let folder = tempfile::Builder::new().prefix("bendtwin-health-").tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    run_ok(&["ca", "init", &path("ca")]);
    // Neither is called by the address at which it is asked.
    issue(folder.path(), "server", &["twin.example", "localhost"]);
    issue(folder.path(), "worker", &["worker.example", "localhost"]);
    let (clients, workers, rollouts) = (free_port(), free_port(), free_port());
    let of_server = [
        ("BENDTWIN_LISTEN", format!("0.0.0.0:{clients}")),
        ("BENDTWIN_DATA_DIR", path("data")),
        ("BENDTWIN_WORKERS", "0".to_owned()),
        ("BENDTWIN_WORKER_TOKEN", "token-of-the-workers".to_owned()),
        ("BENDTWIN_TLS_CERTIFICATE", path("ca/server.pem")),
        ("BENDTWIN_TLS_KEY", path("ca/server.key")),
        ("BENDTWIN_LISTEN_WORKERS_TLS", format!("127.0.0.1:{workers}")),
        ("BENDTWIN_WORKER_TLS_CERTIFICATE", path("ca/server.pem")),
        ("BENDTWIN_WORKER_TLS_KEY", path("ca/server.key")),
        ("BENDTWIN_WORKER_TLS_CA", path("ca/ca.pem")),
    ];
    let of_worker = [
        ("BENDTWIN_SERVER", format!("https://localhost:{workers}")),
        ("BENDTWIN_WORKER_TOKEN", "token-of-the-workers".to_owned()),
        ("BENDTWIN_CA", path("ca/ca.pem")),
        ("BENDTWIN_WORKER_CERTIFICATE", path("ca/worker.pem")),
        ("BENDTWIN_WORKER_KEY", path("ca/worker.key")),
        ("BENDTWIN_WORKER_LISTEN", format!("0.0.0.0:{rollouts}")),
        ("BENDTWIN_WORKER_ADVERTISE", format!("https://localhost:{rollouts}")),
    ];
    let (status, said) = checked(&[], &of_server).await;
    assert!(status == Some(1) && said.contains("does not answer"), "{said}");
    let (status, said) = checked(&["worker"], &of_worker).await;
    assert!(status == Some(1) && said.contains("does not answer"), "{said}");

    let processes = Processes::new(folder.path());
    let start = |command: &mut Command| processes.start(command, &folder.path().join("log"));
    let server = start(bendtwin().arg("server").envs(of_server.iter().cloned()));
    let mut running = Running(vec![server]);
    until("the server to be ready but for workers", SOON, async || {
        (checked(&["--without", "workers"], &of_server).await.0 == Some(0)).then_some(())
    })
    .await;
    let (status, said) = checked(&[], &of_server).await;
    assert!(status == Some(1) && said.contains("workers: "), "{said}");
    let (status, said) = checked(&["--without", "worker"], &of_server).await;
    assert!(status == Some(1) && said.contains("`worker`"), "{said}");

    let mut worker = bendtwin();
    worker.args(["worker", "--backend", "cpu"]).envs(of_worker.iter().cloned());
    running.0.push(start(&mut worker));
    until("the worker to be healthy", SOON, async || {
        (checked(&["worker"], &of_worker).await.0 == Some(0)).then_some(())
    })
    .await;
    until("the server to be ready", SOON, async || {
        (checked(&[], &of_server).await.0 == Some(0)).then_some(())
    })
    .await;
    // What answers there is another program.
    let other = ("BENDTWIN_WORKER_LISTEN", format!("127.0.0.1:{clients}"));
    let mistaken: Vec<_> = of_worker.iter().cloned().chain([other]).collect();
    let (status, said) = checked(&["worker"], &mistaken).await;
    assert_eq!(status, Some(1), "{said}");
}
