//! The token of a server: its user's commands find it by themselves, others are refused, and
//! nothing that the server writes can be read by them.

use std::{
    os::unix::fs::PermissionsExt as _,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use crate::harness::{
    cluster::START,
    command::{bendtwin, run_ok},
    process::Processes,
    until,
};

/// Files and folders below a folder, itself included.
fn all(path: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
    let below = entries.flat_map(|entry| all(&entry.path()));
    std::iter::once(path.to_owned()).chain(below).collect()
}

#[tokio::test]
async fn commands_of_the_user_need_no_setting_and_others_are_refused() {
    let folder = tempfile::Builder::new().prefix("bendtwin-e2e-").tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let processes = Processes::new(folder.path());
    let mut command = bendtwin();
    command
        .args(["server", "--listen", "127.0.0.1:0", "--workers", "0", "--data-dir"])
        .args([path("data").as_os_str(), "--port-file".as_ref(), path("port").as_os_str()])
        .env("XDG_STATE_HOME", path("state"));
    let mut server = processes.start(&mut command, &path("log"));
    let port: u16 = until("the port", START, async || {
        std::fs::read_to_string(path("port")).ok()?.trim().parse().ok()
    })
    .await;

    let archive = path("rope.zip").display().to_string();
    run_ok(&["capture", "make", "rope", &archive, "--tiny"]);
    let push = |state: &str, change: &dyn Fn(&mut Command)| -> Output {
        let mut push = bendtwin();
        push.args(["capture", "push", &archive, "--server", &format!("http://127.0.0.1:{port}")]);
        change(push.env("XDG_STATE_HOME", path(state)));
        push.output().unwrap()
    };
    let own = push("state", &|_| {});
    assert!(own.status.success(), "{}", String::from_utf8_lossy(&own.stderr));
    let other = push("nothing", &|_| {});
    let stderr = String::from_utf8_lossy(&other.stderr).into_owned();
    assert!(!other.status.success() && stderr.contains("BENDTWIN_TOKEN"), "{stderr}");
    let usage = |form: &[&str]| {
        let mut usage = bendtwin();
        usage.args(["admin", "usage", "--server", &format!("http://127.0.0.1:{port}")]).args(form);
        usage.env("XDG_STATE_HOME", path("state")).output().unwrap().stdout
    };
    let owners: serde_json::Value = serde_json::from_slice(&usage(&["--json"])).unwrap();
    let size = std::fs::metadata(&archive).unwrap().len();
    assert_eq!((&owners[0]["owner"], &owners[0]["captures"]), (&"local".into(), &1.into()));
    assert_eq!(owners[0]["stored_bytes"]["captures"], size, "{owners}");
    assert!(String::from_utf8_lossy(&usage(&[])).lines().nth(1).unwrap().starts_with("local"));
    let mut doctor = bendtwin();
    doctor.args(["doctor", "--server", &format!("127.0.0.1:{port}"), "--listen", "127.0.0.1:0"]);
    let doctor = doctor.env("XDG_STATE_HOME", path("nothing")).output().unwrap();
    let found = String::from_utf8_lossy(&doctor.stdout).into_owned();
    assert!(!doctor.status.success() && found.contains("PROBLEM  token"), "{found}");
    // With the folder of a server on this machine it finds the token by itself.
    let mut doctor = bendtwin();
    let (address, data) = (format!("127.0.0.1:{port}"), path("data"));
    doctor.args(["doctor", "--server", &address, "--listen", &address, "--data-dir"]).arg(data);
    let doctor = doctor.env("XDG_STATE_HOME", path("nothing")).output().unwrap();
    let found = String::from_utf8_lossy(&doctor.stdout).into_owned();
    assert!(!found.contains("PROBLEM  token"), "{found}");
    let file = path("data/client-token");
    let token = std::fs::read_to_string(&file).unwrap().trim().to_owned();
    assert!(
        push("nothing", &|c| {
            c.env("BENDTWIN_TOKEN", &token);
        })
        .status
        .success()
    );
    assert!(
        push("nothing", &|c| {
            c.arg("--token-file").arg(&file);
        })
        .status
        .success()
    );

    let written = [all(&path("data")), all(&path("state"))].concat();
    assert!(written.len() > 6, "{written:?}");
    for file in written {
        // A file of the database may have gone meanwhile.
        let Ok(metadata) = std::fs::metadata(&file) else { continue };
        let mode = metadata.permissions().mode();
        assert_eq!(mode & 0o077, 0, "{} has {mode:o}", file.display());
    }

    let left = path("state").join("bendtwin/tokens").join(port.to_string());
    assert_eq!(std::fs::read_to_string(&left).unwrap().trim(), token);
    let mut end = Command::new("kill");
    assert!(end.args(["-TERM", &server.id().to_string()]).status().unwrap().success());
    until("the end of the server", START, async || server.try_wait().unwrap()).await;
    assert!(!left.exists(), "the token of a server that has ended is left");
}

/// The image of the container starts so; its output is no terminal.
#[tokio::test]
async fn a_server_that_is_published_locally_prints_a_link_that_logs_in() {
    let folder = tempfile::Builder::new().prefix("bendtwin-e2e-").tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let processes = Processes::new(folder.path());
    let mut command = bendtwin();
    command
        .args(["server", "--listen", "0.0.0.0:0", "--published-locally", "--workers", "0"])
        .args(["--public-url", "http://127.0.0.1:8080/", "--port-file"])
        .args([path("port").as_os_str(), "--data-dir".as_ref(), path("data").as_os_str()])
        .env("XDG_STATE_HOME", path("state"));
    let mut server = processes.start(&mut command, &path("log"));
    let log = until("the link", START, async || {
        std::fs::read_to_string(path("log")).ok().filter(|log| log.contains("/#/?token="))
    })
    .await;
    let (_, link) = log.split_once("Open the console: ").unwrap();
    let token = link.trim().strip_prefix("http://127.0.0.1:8080/#/?token=").unwrap();
    assert!(!log.contains("WARN"), "{log}");
    let port = std::fs::read_to_string(path("port")).unwrap();
    let mut list = bendtwin();
    list.args(["twin", "list", "--server", &format!("http://127.0.0.1:{}", port.trim())]);
    list.env("XDG_STATE_HOME", path("nothing"));
    assert!(!list.output().unwrap().status.success());
    assert!(list.env("BENDTWIN_TOKEN", token.lines().next().unwrap()).status().unwrap().success());
    server.kill().unwrap();
    server.wait().unwrap();
}
