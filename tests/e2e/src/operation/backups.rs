//! The rehearsal of docs/run/storage.md: a fleet on PostgreSQL and S3 is backed up while it works, all of
//! it is destroyed, and the backup is restored to another fleet and to a laptop. Backup and restore are
//! killed on the way.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    time::Duration,
};

use bendtwin_proto::v1::RollOutResponse;
use bytes::Bytes;
use reqwest::{Method, StatusCode};
use serde_json::{Value, json};

use super::on_s3::{self, endpoint_or_skip};
use crate::{
    harness::{
        Api, Postgres, Setup, TestCluster,
        command::bendtwin,
        reference::{FIT, SETTINGS, capture, reference},
        until,
    },
    rollouts,
};

const STATE: Duration = Duration::from_secs(60);
const TOKEN: &str = "0123456789abcdef0123456789abcdef";

/// The whereabouts of a store, as variables of the environment.
type Environment = Vec<(&'static str, String)>;

fn command(arguments: &[&str], data_dir: &Path, environment: &Environment) -> Command {
    let mut command = bendtwin();
    command.arg("store").args(arguments).arg("--data-dir").arg(data_dir).arg("--json");
    command.envs(environment.iter().map(|(name, value)| (name, value)));
    command
}

/// Runs `bendtwin store`. An error is what it printed as one.
async fn store(
    arguments: &[&str],
    data_dir: &Path,
    environment: &Environment,
) -> Result<Value, String> {
    let mut command = command(arguments, data_dir, environment);
    let done = tokio::task::spawn_blocking(move || command.output()).await.unwrap().unwrap();
    match done.status.success() {
        true => Ok(serde_json::from_slice(&done.stdout).unwrap()),
        false => Err(String::from_utf8_lossy(&done.stderr).into_owned()),
    }
}

/// Starts `bendtwin store` and kills it once a file is there.
async fn killed(arguments: &[&str], data_dir: &Path, environment: &Environment, file: &Path) {
    let mut command = command(arguments, data_dir, environment);
    let mut child: Child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    until("the command to begin", STATE, async || any(file).then_some(())).await;
    child.kill().unwrap();
    child.wait().unwrap();
}

/// True if there is a file of this name, or any below a folder of this name.
fn any(path: &Path) -> bool {
    let mut entries = std::fs::read_dir(path).into_iter().flatten().flatten();
    path.is_file() || entries.any(|entry| any(&entry.path()))
}

/// Twin files by name.
async fn twins(api: &Api) -> BTreeMap<String, Bytes> {
    let mut files = BTreeMap::new();
    for twin in api.list_twins().await.unwrap() {
        files.insert(twin.name.clone(), api.export(&twin.name).await.unwrap());
    }
    files
}

/// A reply without what differs from call to call.
fn content(reply: RollOutResponse) -> RollOutResponse {
    RollOutResponse { timing: None, worker: String::new(), ..reply }
}

async fn rolled_out(api: &Api, name: &str) -> RollOutResponse {
    let (twin, file) = (api.get_twin(name).await.unwrap(), api.export(name).await.unwrap());
    let request = rollouts::request(&twin, &rollouts::rest_controls(&file));
    content(api.roll_out(request).await.unwrap())
}

/// All captures have their content.
async fn check_captures(server: &TestCluster, least: usize) {
    let captures = server.api().list_captures().await.unwrap();
    assert!(captures.len() >= least, "{} of {least}", captures.len());
    for found in captures {
        let content = server.http().get(&format!("/v1/{}/content", found.name)).await;
        let digest = blake3::hash(&content.bytes().await.unwrap()).to_hex().to_string();
        assert_eq!(digest, found.digest, "{}", found.name);
    }
}

#[tokio::test]
async fn a_fleet_is_backed_up_destroyed_and_restored_elsewhere() {
    let Some(endpoint) = endpoint_or_skip() else { return };
    let Some(postgres) = Postgres::start_or_skip().await else { return };
    let prefix = |what: &str| format!("backup-{what}-{}", std::process::id());
    let bucket = on_s3::environment(&endpoint, &prefix("original"));
    let database = Some(postgres.url_with_password("unused"));
    let setup = Setup { database, environment: bucket.clone(), ..Setup::default() };
    let mut first = TestCluster::start(setup.clone()).await;
    let mut second = TestCluster::start(Setup { own_workers: 0, ..setup }).await;
    let api = first.api();

    let stored = api.upload(&capture().await, "the capture").await.unwrap();
    let fit = api.fit(&stored.name, SETTINGS, 0).await.unwrap();
    let fitted = api.succeeded(&fit.name, FIT).await;
    api.import(&reference().await.file).await.unwrap();
    let (files, reply) = (twins(&api).await, rolled_out(&api, &fitted.twin).await);
    assert_eq!(files.len(), 2);
    let new = json!({"display_name": "robot", "scopes": ["twins:read"]});
    let made = first.http().request(Method::POST, "/v1/keys").json(&new).send().await.unwrap();
    let made: Value = made.json().await.unwrap();
    let key = made["secret_key"].as_str().unwrap_or_else(|| panic!("{made}")).to_owned();
    std::fs::write(first.data_dir().join("client-token"), TOKEN).unwrap();

    // Content comes and goes at the other server all the time.
    let busy = second.api();
    let writes = tokio::spawn(async move {
        for nth in 0_u64.. {
            let content = Bytes::from(nth.to_le_bytes().repeat(1000));
            let Ok(new) = busy.upload(&content, &nth.to_string()).await else { return };
            if nth % 3 == 0 {
                let gone = bendtwin_proto::v1::DeleteCaptureRequest { name: new.name, purge: true };
                busy.captures().delete_capture(gone).await.ok();
            }
        }
    });
    let some = async || (api.list_captures().await.ok()?.len() > 20).then_some(());
    until("some captures", STATE, some).await;

    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let backup = path("backup");
    let at = backup.to_str().unwrap();
    let mut environment = bucket;
    environment.push(("BENDTWIN_DATABASE_URL", postgres.url_with_password("unused")));
    let (backing_up, data_dir) = (["backup", at], first.data_dir());
    killed(&backing_up, &data_dir, &environment, &backup.join("blobs/blake3")).await;
    let done = store(&backing_up, &data_dir, &environment).await.unwrap();
    assert!(done["lost"] == json!([]) && done["client_token"] == true, "{done}");
    // Killed on the way to the next one, the first is still there.
    let later = api.upload(&Bytes::from_static(b"later"), "later").await.unwrap();
    killed(&backing_up, &data_dir, &environment, &backup.join("database.partial")).await;
    store(&["check", at], &path("none"), &Vec::new()).await.unwrap();
    let done = store(&backing_up, &data_dir, &environment).await.unwrap();
    assert!(done["brought"].as_u64() < done["blobs"].as_u64(), "{done}");
    let checked = store(&["check", at], &path("none"), &Vec::new()).await.unwrap();
    assert_eq!((&checked["damaged"], &checked["unreferenced"]), (&json!([]), &json!([])));
    let rows = |done: &Value, table: &str| {
        let tables = done["tables"].as_array().unwrap();
        let found = tables.iter().find(|found| found["name"] == table);
        found.unwrap()["rows"].as_u64().unwrap()
    };
    let captures = rows(&done, "captures");

    // Everything goes: both servers, their folders, the database. The new ones have another prefix.
    writes.abort();
    first.kill();
    second.kill();
    drop((first, second, postgres));

    let restoring = ["restore", at];
    let postgres = Postgres::start_or_skip().await.unwrap();
    let bucket = on_s3::environment(&endpoint, &prefix("restored"));
    let database = postgres.url_with_password("unused");
    let mut environment = bucket.clone();
    environment.push(("BENDTWIN_DATABASE_URL", database.clone()));
    let data_dir = path("fleet");
    let begun = data_dir.join("restoring/restore.json");
    killed(&restoring, &data_dir, &environment, &begun).await;
    let done = store(&restoring, &data_dir, &environment).await.unwrap();
    assert!(done["lost"] == json!([]) && rows(&done, "captures") == captures, "{done}");
    let refused = store(&restoring, &data_dir, &environment).await.unwrap_err();
    assert!(refused.contains("DATA_DIR_NOT_EMPTY"), "{refused}");
    let setup = Setup {
        database: Some(database),
        environment: bucket,
        data_dir: Some(data_dir.clone()),
        ..Setup::default()
    };
    let server = TestCluster::start(setup).await;
    let restored = server.api();
    assert_eq!(twins(&restored).await, files);
    assert_eq!(rolled_out(&restored, &fitted.twin).await, reply);
    assert_eq!(restored.get_fit(&fit.name).await.unwrap().twin, fitted.twin);
    check_captures(&server, captures as usize).await;
    assert!(restored.list_captures().await.unwrap().iter().any(|c| c.name == later.name));

    // A laptop has the same, and takes the same keys.
    drop(server);
    let data_dir = path("laptop");
    killed(&restoring, &data_dir, &Vec::new(), &data_dir.join("restoring/restore.json")).await;
    let done = store(&restoring, &data_dir, &Vec::new()).await.unwrap();
    assert_eq!((rows(&done, "captures"), &done["client_token"]), (captures, &json!(true)));
    let setup = Setup { data_dir: Some(data_dir.clone()), ..Setup::default() };
    let mut server = TestCluster::start(setup.clone()).await;
    assert_eq!(twins(&server.api()).await, files);
    assert_eq!(rolled_out(&server.api(), &fitted.twin).await, reply);
    check_captures(&server, captures as usize).await;
    server.kill();
    // Frees a place among the clusters that may run together.
    drop(server);
    let required = vec![("BENDTWIN_CLIENT_TOKEN", "required".to_owned())];
    let server = TestCluster::start(Setup { own_workers: 0, environment: required, ..setup }).await;
    let twin = format!("/v1/{}", fitted.twin);
    for (shown, status) in [
        (key.as_str(), StatusCode::OK),
        (TOKEN, StatusCode::OK),
        ("bt_of_nobody", StatusCode::UNAUTHORIZED),
    ] {
        let request = server.http().request(Method::GET, &twin).bearer_auth(shown);
        assert_eq!(request.send().await.unwrap().status(), status, "{shown}");
    }
    let laptop: PathBuf = data_dir;
    assert!(laptop.join("bendtwin.sqlite").exists() && !laptop.join("restoring").exists());
}
