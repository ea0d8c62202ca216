//! Data folders that released versions left behind (`tests/old`), opened by this build: everything is
//! listed as the version itself listed it, served and simulated, a fit resumes from its checkpoint, and
//! files open with the library.

use std::{
    path::{Path, PathBuf},
    time::Duration,
};

use bendtwin_core::Twin;
use flate2::read::GzDecoder;
use serde_json::Value;

use crate::harness::{
    Setup, TestCluster,
    command::{run, run_ok},
    http::Http,
};

/// Longest time for the rest of the fit.
const FIT: Duration = Duration::from_secs(120);
/// Largest distance of a simulated node from where the old version had it [m]: processors add in
/// different orders.
const ROLLOUT_TOLERANCE_M: f64 = 5e-4;
/// Largest difference of the error of the resumed fit from that of the old version [m].
const FIT_TOLERANCE_M: f64 = 2e-3;
/// Facts that are not of the data: they depend on the time, or on options of the server.
const PASSING: [&str; 3] = ["purge_time", "next_page_token", "last_use_time"];
/// Ten years: what the old version deleted is in the trash whenever the test runs.
const TRASH_S: &str = "315360000";

/// A released version.
struct Version {
    /// Folder in a temporary one with the version's data folder.
    folder: tempfile::TempDir,
    /// What `tests/old/make` wrote down.
    record: Value,
}

impl Version {
    /// Every version that was recorded.
    fn all() -> Vec<Self> {
        let old = Path::new(env!("CARGO_MANIFEST_DIR")).join("../old");
        let entries = std::fs::read_dir(old).unwrap().map(|entry| entry.unwrap().path());
        let mut folders: Vec<PathBuf> = entries.filter(|path| path.is_dir()).collect();
        folders.sort();
        assert!(!folders.is_empty(), "no version is recorded");
        folders.iter().map(|folder| Self::copy(folder)).collect()
    }

    fn copy(recorded: &Path) -> Self {
        let folder = tempfile::Builder::new().prefix("bendtwin-old-").tempdir().unwrap();
        let archive = std::fs::File::open(recorded.join("data.tar.gz")).unwrap();
        tar::Archive::new(GzDecoder::new(archive)).unpack(folder.path()).unwrap();
        let record = std::fs::read(recorded.join("record.json")).unwrap();
        Self { folder, record: serde_json::from_slice(&record).unwrap() }
    }

    fn name(&self) -> &str {
        self.record["version"].as_str().unwrap()
    }

    fn data(&self) -> PathBuf {
        self.folder.path().join("data")
    }

    /// Entries of a recorded list.
    fn entries(&self, path: &str) -> &[Value] {
        entries(&self.record["lists"][path])
    }

    fn setup(&self) -> Setup {
        Setup {
            data_dir: Some(self.data()),
            environment: vec![("BENDTWIN_TRASH", TRASH_S.to_owned())],
            ..Setup::default()
        }
    }
}

/// The only array of a page.
fn entries(page: &Value) -> &[Value] {
    page.as_object().unwrap().values().find_map(Value::as_array).unwrap()
}

/// Every fact of `old` that `new` does not have, by its path. New facts may have come.
fn lost(old: &Value, new: &Value, path: &str, into: &mut Vec<String>) {
    match (old, new) {
        (Value::Object(old), Value::Object(new)) => {
            for (name, value) in old.iter().filter(|(name, _)| !PASSING.contains(&name.as_str())) {
                let found = new.get(name).unwrap_or(&Value::Null);
                lost(value, found, &format!("{path}/{name}"), into);
            }
        }
        (Value::Array(old), Value::Array(new)) if old.len() == new.len() => {
            for (at, (old, new)) in old.iter().zip(new).enumerate() {
                lost(old, new, &format!("{path}/{at}"), into);
            }
        }
        _ if old == new => {}
        _ => into.push(format!("{path}: {old} is now {new}")),
    }
}

#[tokio::test]
async fn data_of_every_released_version_is_served_simulated_and_continued() {
    for version in Version::all() {
        println!("data of {}", version.name());
        let mut server = TestCluster::start(version.setup()).await;
        let http = server.http();
        listed(&version, &http).await;
        served(&version, &http).await;
        rolled_out(&version, &http).await;
        resumed(&version, &server).await;
        server.kill();
        drop(server);
        // The check refuses a store whose migrations were not made.
        let folder = version.data().display().to_string();
        let checked =
            tokio::task::spawn_blocking(move || run_ok(&["store", "check", &folder])).await;
        println!("{}", checked.unwrap());
        accepts_its_keys(&version).await;
    }
}

async fn listed(version: &Version, http: &Http) {
    let mut faults = Vec::new();
    for (path, _) in version.record["lists"].as_object().unwrap() {
        let page = http.get_json(path).await;
        for old in version.entries(path) {
            let new = entries(&page).iter().find(|new| new["name"] == old["name"]);
            // The fit runs meanwhile.
            let mut old = old.clone();
            if old["name"] == version.record["unfinished"] {
                old.as_object_mut().unwrap().retain(|fact, _| fact == "capture" || fact == "name");
            }
            lost(&old, new.unwrap_or(&Value::Null), path, &mut faults);
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
    for path in ["/v1/captures", "/v1/fits", "/v1/twins", "/v1/keys", "/v1/trash/captures"] {
        assert!(!version.entries(path).is_empty(), "the record has nothing of {path}");
    }
}

async fn served(version: &Version, http: &Http) {
    for resource in ["/v1/captures", "/v1/twins"].iter().flat_map(|path| version.entries(path)) {
        let name = resource["name"].as_str().unwrap();
        let content = http.get(&format!("/v1/{name}/content")).await.bytes().await.unwrap();
        let digest = blake3::hash(&content).to_hex().to_string();
        assert_eq!(resource["digest"], digest, "{name}");
        let thumbnail = http.get(&format!("/v1/{name}/thumbnail")).await;
        assert_eq!(thumbnail.status(), 200, "{name}");
    }
    for path in version.record["served"].as_array().unwrap() {
        let reply = http.get(path.as_str().unwrap()).await;
        assert_eq!(reply.status(), 200, "{path}");
        assert!(!reply.bytes().await.unwrap().is_empty(), "{path}");
    }
    let trashed = version.entries("/v1/trash/captures")[0]["name"].as_str().unwrap();
    let undelete = format!("/v1/{trashed}/undelete");
    let restored = http.request(reqwest::Method::POST, &undelete).send().await.unwrap();
    assert_eq!(restored.status(), 200, "{}", restored.text().await.unwrap());
}

async fn rolled_out(version: &Version, http: &Http) {
    for rollout in version.record["rollouts"].as_array().unwrap() {
        let twin = rollout["twin"].as_str().unwrap();
        let request = http.request(reqwest::Method::POST, &format!("/v1/{twin}/rollouts"));
        let reply: Value =
            request.json(&rollout["request"]).send().await.unwrap().json().await.unwrap();
        let (old, new) = (numbers(&rollout["positions"]), numbers(&reply["positions"]));
        assert!(!old.is_empty() && old.len() == new.len(), "{twin}: {reply}");
        let furthest = old.iter().zip(&new).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(furthest <= ROLLOUT_TOLERANCE_M, "{twin} is {furthest} m away");
    }
}

/// All numbers of nested lists.
fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(values) => values.iter().flat_map(numbers).collect(),
        number => number.as_f64().into_iter().collect(),
    }
}

async fn resumed(version: &Version, server: &TestCluster) {
    let fit = version.record["unfinished"].as_str().unwrap();
    let ended = server.api().succeeded(fit, FIT).await;
    let log = server.log();
    assert!(log.contains("fit leased resumed=true"), "it had no checkpoint");
    assert!(!log.contains("restarting the fit"), "its checkpoint was not used");
    let expected = version.record["unfinished_error_m"].as_f64().unwrap();
    let error = ended.error_m.unwrap();
    assert!((error - expected).abs() < FIT_TOLERANCE_M, "{error} m instead of {expected} m");
    assert!(!server.api().export(&ended.twin).await.unwrap().is_empty());
}

/// Keys and the token hold as before.
async fn accepts_its_keys(version: &Version) {
    let mut setup = Setup { own_workers: 0, ..version.setup() };
    setup.environment.push(("BENDTWIN_CLIENT_TOKEN", "required".to_owned()));
    let server = TestCluster::start(setup).await;
    let token = std::fs::read_to_string(version.data().join("client-token")).unwrap();
    let key = version.record["key"].as_str().unwrap();
    for (secret, owner) in [(token.trim(), "local"), (key, "ada")] {
        let asked = server.http().request(reqwest::Method::GET, "/v1/caller").bearer_auth(secret);
        let caller: Value = asked.send().await.unwrap().json().await.unwrap();
        assert_eq!(caller["owner"], owner, "{caller}");
    }
}

#[test]
fn files_of_every_released_version_open_with_the_library() {
    for version in Version::all() {
        let blob = |resource: &Value| {
            let digest = resource["digest"].as_str().unwrap();
            version.data().join("blobs/blake3").join(&digest[..2]).join(digest)
        };
        for twin in version.entries("/v1/twins") {
            let opened = Twin::decode(&std::fs::read(blob(twin)).unwrap()).unwrap();
            assert_eq!(twin["node_count"], opened.graph.node_count() as u64);
        }
        for capture in version.entries("/v1/captures") {
            let archive = version.folder.path().join("capture.zip");
            std::fs::copy(blob(capture), &archive).unwrap();
            let checked = run(&["capture", "check", archive.to_str().unwrap()]);
            let said = String::from_utf8_lossy(&checked.stderr).into_owned();
            assert!(checked.status.success(), "{}: {said}", capture["display_name"]);
        }
    }
}

#[test]
fn a_lost_fact_is_found() {
    let old = serde_json::json!({"name": "a", "tags": ["x"], "purge_time": 1, "size": 2});
    let faults = |new: &Value| {
        let mut faults = Vec::new();
        lost(&old, new, "", &mut faults);
        faults
    };
    assert!(
        faults(&serde_json::json!({"name": "a", "tags": ["x"], "size": 2, "new": 1})).is_empty()
    );
    assert_eq!(faults(&serde_json::json!({"name": "a", "tags": [], "size": 3})).len(), 2);
    assert_eq!(faults(&Value::Null), [format!(": {old} is now null")]);
}
