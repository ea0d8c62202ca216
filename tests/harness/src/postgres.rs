//! A PostgreSQL server of a test's own, which it may stop and start ([tests/postgres](../../postgres)).

use std::{path::PathBuf, process::Command};

use tempfile::TempDir;

/// A server in a temporary folder.
pub struct Postgres {
    folder: TempDir,
    url: String,
}

impl Postgres {
    /// Starts a server, or says that there is none to start.
    pub async fn start_or_skip() -> Option<Self> {
        if !script().arg("available").status().is_ok_and(|status| status.success()) {
            eprintln!("SKIPPED: PostgreSQL is missing");
            return None;
        }
        let folder = tempfile::Builder::new().prefix("bendtwin-pg-").tempdir().unwrap();
        let mut server = Self { folder, url: String::new() };
        server.url = server.start().await;
        Some(server)
    }

    /// URL of its database, with a password for which it does not ask.
    pub fn url_with_password(&self, password: &str) -> String {
        self.url.replacen("bendtwin@", &format!("bendtwin:{password}@"), 1)
    }

    /// Starts it again after [`Postgres::kill`]; returns its URL.
    pub async fn start(&self) -> String {
        self.run("start", None).await
    }

    /// Ends it as a crash would.
    pub async fn kill(&self) {
        self.run("kill", None).await;
    }

    /// Lets it hang: it accepts connections, and answers nothing.
    pub async fn stall(&self) {
        self.run("stall", None).await;
    }

    /// Lets it answer again after [`Postgres::stall`].
    pub async fn resume(&self) {
        self.run("resume", None).await;
    }

    /// The answer to statements, line by line, of the superuser.
    pub async fn query(&self, statements: &str) -> String {
        self.run("query", Some(statements.to_owned())).await
    }

    async fn run(&self, what: &'static str, statements: Option<String>) -> String {
        let place = self.place();
        let run = move || script().arg(what).arg(place).args(statements).output();
        let done = tokio::task::spawn_blocking(run);
        let done = done.await.unwrap().unwrap();
        assert!(done.status.success(), "{what}: {}", String::from_utf8_lossy(&done.stderr));
        String::from_utf8(done.stdout).unwrap().trim().to_owned()
    }

    fn place(&self) -> PathBuf {
        self.folder.path().join("server")
    }
}

impl Drop for Postgres {
    fn drop(&mut self) {
        script().arg("remove").arg(self.place()).status().ok();
    }
}

fn script() -> Command {
    Command::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../postgres"))
}
