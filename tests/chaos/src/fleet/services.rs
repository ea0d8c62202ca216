//! PostgreSQL (`tests/postgres`) and a server of S3's protocol (`tests/s3`), on a separate machine.
//!
//! The second keeps everything in memory, so it is stopped and cut off, but not ended.

use std::{
    ffi::OsString,
    path::{Path, PathBuf},
    process::Command,
};

use anyhow::{Context as _, bail};

use super::network::Network;

/// Environment of `tests/chaos/run`: the folder into which `tests/s3` was installed.
const S3: &str = "CHAOS_S3";
const PORT: u16 = 5432;

/// Both services.
pub(crate) struct Services {
    postgres: PathBuf,
    s3: PathBuf,
    environment: Vec<(&'static str, String)>,
    /// Starts PostgreSQL again.
    start: Box<dyn Fn() -> Command + Send + Sync>,
}

impl Services {
    /// Starts both.
    pub(super) async fn start(
        folder: &Path,
        network: &std::sync::Arc<Network>,
    ) -> anyhow::Result<Self> {
        let installed = std::env::var_os(S3);
        let installed =
            installed.context("start this with tests/chaos/run, which installs moto")?;
        let (postgres, s3) = (folder.join("postgres/server"), folder.join("s3"));
        std::fs::create_dir_all(&s3)?;
        let port = network.free_port(super::Fleet::MACHINES, PORT)?;
        let address = network.database();
        let (place, on) = (postgres.clone(), network.clone());
        let start = move || {
            let mut command = script("postgres", ["start".into(), place.clone().into()]);
            command.env("BENDTWIN_POSTGRES_ADDRESS", format!("{address}:{port}"));
            // A crash takes what it has not synced with it.
            command.env("BENDTWIN_POSTGRES_SYNC", "1");
            on.beside_services(&command)
        };
        output(&mut start())?;
        let mut command = script("s3", ["start".into(), installed, s3.clone().into()]);
        command.env("BENDTWIN_S3_ADDRESS", network.objects().to_string());
        let endpoint = output(&mut network.beside_services(&command))?;
        let url = format!("postgres://bendtwin:none@{address}:{port}/postgres?sslmode=disable");
        let environment = vec![
            ("BENDTWIN_DATABASE_URL", url),
            ("BENDTWIN_OBJECTS", "s3://bendtwin-test/fleet".to_owned()),
            ("AWS_ENDPOINT_URL", endpoint),
            ("AWS_REGION", "us-east-1".to_owned()),
            ("AWS_ACCESS_KEY_ID", "test".to_owned()),
            ("AWS_SECRET_ACCESS_KEY", "secret".to_owned()),
        ];
        Ok(Self { postgres, s3, environment, start: Box::new(start) })
    }

    /// Environment of a server.
    pub(super) fn environment(&self) -> Vec<(&'static str, String)> {
        self.environment.clone()
    }

    /// Ends PostgreSQL as a crash would.
    pub(crate) fn kill_database(&self) -> anyhow::Result<()> {
        let mut kill = script("postgres", ["kill".into(), self.postgres.clone().into()]);
        output(&mut kill).map(drop)
    }

    /// Starts PostgreSQL again.
    pub(crate) fn start_database(&self) -> anyhow::Result<()> {
        output(&mut (self.start)()).map(drop)
    }

    /// Ids of PostgreSQL's processes.
    pub(crate) fn database_pids(&self) -> anyhow::Result<Vec<u32>> {
        let file = std::fs::read_to_string(self.postgres.join("data/postmaster.pid"))?;
        let first: u32 = file.lines().next().unwrap_or_default().trim().parse()?;
        let children = std::fs::read_to_string(format!("/proc/{first}/task/{first}/children"))?;
        let children = children.split_whitespace().filter_map(|pid| pid.parse().ok());
        Ok(std::iter::once(first).chain(children).collect())
    }

    /// Id of the server of S3's protocol.
    pub(crate) fn objects_pid(&self) -> anyhow::Result<u32> {
        Ok(std::fs::read_to_string(self.s3.join("server.pid"))?.trim().parse()?)
    }

    /// The answer of the database, a line a row, columns divided by `|`.
    pub(super) fn database(&self, statements: &str) -> anyhow::Result<String> {
        let arguments = ["query".into(), self.postgres.clone().into(), statements.into()];
        output(&mut script("postgres", arguments))
    }
}

impl Drop for Services {
    fn drop(&mut self) {
        output(&mut script("postgres", ["remove".into(), self.postgres.clone().into()])).ok();
        output(&mut script("s3", ["stop".into(), OsString::new(), self.s3.clone().into()])).ok();
    }
}

fn script<const N: usize>(name: &str, arguments: [OsString; N]) -> Command {
    let mut command = Command::new(format!("{}/../{name}", env!("CARGO_MANIFEST_DIR")));
    command.args(arguments);
    command
}

fn output(command: &mut Command) -> anyhow::Result<String> {
    let output = command.output()?;
    if !output.status.success() {
        bail!("{command:?}: {}", String::from_utf8_lossy(&output.stderr).trim());
    }
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
