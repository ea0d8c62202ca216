//! Owners take turns at one worker: a short fit does not wait for another owner's long one, which
//! resumes and ends in the same twin.

use std::{
    path::PathBuf,
    process::{Child, Command},
    time::Duration,
};

use serde_json::Value;

use crate::harness::{
    cluster::START,
    command::bendtwin,
    process::Processes,
    reference::{FIT, SETTINGS, capture, reference},
    until,
    waiting::shared_slot,
};

/// Time within which a fit starts beside another owner's long one.
const STARTS: Duration = Duration::from_secs(60);

/// The most work that settings allow, which takes weeks.
const MAXIMAL: &str = r#"{
    "search": {"starts": 64, "generations": 10000, "population": 8},
    "refine": {"passes": 100000}
}"#;

/// A fit of well under a second.
const SHORT: &str =
    r#"{"graph": {"max_nodes": 20}, "search": {"generations": 1}, "refine": {"passes": 1}}"#;

/// A server with one worker, which asks for keys and lets fits make way after half a second.
struct Site {
    folder: tempfile::TempDir,
    server: Child,
    url: String,
    _processes: Processes,
}

impl Site {
    async fn start() -> Self {
        let folder = tempfile::Builder::new().prefix("bendtwin-e2e-").tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let options =
            "listen = \"127.0.0.1:0\"\n[workers]\nbackend = \"cpu\"\n[queue]\nslice_s = 0.5\n";
        std::fs::write(path("config.toml"), options).unwrap();
        let processes = Processes::new(folder.path());
        let mut command = bendtwin();
        command.arg("server").arg("--config").arg(path("config.toml"));
        command.arg("--data-dir").arg(path("data")).arg("--port-file").arg(path("port"));
        let server = processes.start(command.env("XDG_STATE_HOME", path("state")), &path("log"));
        let port: u16 = until("the port", START, async || {
            std::fs::read_to_string(path("port")).ok()?.trim().parse().ok()
        })
        .await;
        Self { folder, server, url: format!("http://127.0.0.1:{port}"), _processes: processes }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// A new file with this content.
    fn file(&self, name: &str, content: &[u8]) -> String {
        std::fs::write(self.path(name), content).unwrap();
        self.path(name).display().to_string()
    }

    fn token(&self) -> String {
        std::fs::read_to_string(self.path("data/client-token")).unwrap().trim().to_owned()
    }

    /// The output of a command of the holder of this key.
    fn run(&self, key: &str, arguments: &[&str]) -> Value {
        let mut command: Command = bendtwin();
        command.args(arguments).args(["--json", "--server", &self.url]);
        let output = command.env("BENDTWIN_TOKEN", key).output().unwrap();
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let fault = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "bendtwin {}: {text}{fault}", arguments.join(" "));
        let last = text.trim().lines().last().unwrap_or_default();
        serde_json::from_str(&text)
            .or_else(|_| serde_json::from_str(last))
            .unwrap_or_else(|e| panic!("{arguments:?}: {e}: {text}"))
    }

    /// The key of a person who fits.
    fn key(&self, name: &str) -> String {
        let scopes = "captures:read,captures:write,fits:read,fits:write,twins:read";
        let made = self.run(&self.token(), &["key", "create", name, "--scope", scopes]);
        made["secret_key"].as_str().unwrap().to_owned()
    }

    /// Starts a fit; returns its name.
    fn fit(&self, key: &str, capture: &str, settings: &str) -> String {
        let file = self.file("settings.json", settings.as_bytes());
        let fit = self.run(key, &["fit", "start", capture, "--settings", &file]);
        fit["name"].as_str().unwrap().to_owned()
    }

    /// The job of a fit, once it is as wanted.
    async fn job(&self, key: &str, fit: &str, time: Duration, wanted: &[&str]) -> Value {
        until(&format!("{fit} to be one of {wanted:?}"), time, async || {
            let shown = self.run(key, &["fit", "show", fit]);
            let state = shown["job"]["state"].as_str().unwrap().to_uppercase();
            assert_ne!(state, "FAILED", "{shown}");
            wanted.contains(&state.as_str()).then_some(shown)
        })
        .await
    }

    fn log(&self) -> String {
        std::fs::read_to_string(self.path("log")).unwrap()
    }
}

impl Drop for Site {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("{}", self.log());
        }
        self.server.kill().ok();
        self.server.wait().ok();
    }
}

#[tokio::test]
async fn a_short_fit_starts_soon_beside_a_maximal_one_which_loses_nothing() {
    let undisturbed = reference().await;
    let _slot = shared_slot().await;
    let site = Site::start().await;
    let (ada, bob) = (site.key("ada"), site.key("bob"));
    let archive = site.file("rope.zip", &capture().await);
    let rope = site.run(&ada, &["capture", "push", &archive, "--name", "e2e"]);
    let rope = rope["name"].as_str().unwrap();

    let maximal = site.fit(&ada, rope, MAXIMAL);
    site.job(&ada, &maximal, START, &["RUNNING"]).await;
    let short = site.fit(&bob, rope, SHORT);
    site.job(&bob, &short, STARTS, &["RUNNING", "SUCCEEDED"]).await;
    site.job(&bob, &short, FIT, &["SUCCEEDED"]).await;
    let resumed = site.job(&ada, &maximal, STARTS, &["RUNNING"]).await;
    assert_eq!(resumed["job"]["attempts"], 1);
    site.run(&ada, &["fit", "cancel", &maximal]);

    // Interrupted again and again, a fit ends in the twin of one that was not.
    let long = site.fit(&ada, rope, SETTINGS);
    for _ in 0..4 {
        site.job(&ada, &long, FIT, &["RUNNING", "SUCCEEDED"]).await;
        let short = site.fit(&bob, rope, SHORT);
        site.job(&bob, &short, FIT, &["SUCCEEDED"]).await;
    }
    site.job(&ada, &long, FIT, &["SUCCEEDED"]).await;
    let ended = site.run(&ada, &["fit", "show", &long]);
    assert_eq!(ended["job"]["attempts"], 1, "{ended}");
    let curves = ended["losses"].as_array().unwrap();
    for (curve, iterations) in curves.iter().zip([12, 24]) {
        let each: Vec<u32> = (1..=iterations).collect();
        assert_eq!(curve["iterations"], serde_json::json!(each), "{curve}");
    }
    assert_eq!(curves.len(), 2);
    let twin = site.run(&ada, &["twin", "show", ended["twin"].as_str().unwrap()]);
    assert_eq!(twin["digest"], undisturbed.digest, "the twin is another one");
    let released = site.log().matches("makes way").count();
    assert!(released >= 2, "{released}");
}
