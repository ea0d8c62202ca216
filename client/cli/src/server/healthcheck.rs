//! `bendtwin healthcheck`: whether the server, or the worker, that was started on this machine with the
//! same options is healthy. It is for the health checks of containers: its options are those of
//! `bendtwin server` and `bendtwin worker`, from the same variables and the same file, so that it finds
//! the port and speaks TLS where they do.

use std::{
    net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr},
    time::Duration,
};

use bendtwin_core::{Category, Fault};
use bendtwin_tls::{Connector, unverified_client_config};
use bendtwin_worker::{Health, health};
use clap::{Args, Subcommand};
use serde::Deserialize;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};

use crate::{
    failure::{self, Failed, Usage},
    global::Global,
    output,
    server::Server,
    worker::Listener,
};

/// Largest answer that is read [bytes].
const MOST: u64 = 64 << 10;

/// Without a command it asks the server.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(crate) struct Healthcheck {
    #[command(subcommand)]
    command: Option<Command>,
    /// Checks of readiness to leave out: running, writes, disk, workers
    #[arg(
        long,
        env = "BENDTWIN_HEALTHCHECK_WITHOUT",
        value_name = "CHECK,...",
        value_delimiter = ','
    )]
    without: Vec<String>,
    #[command(flatten)]
    patience: Patience,
    #[command(flatten)]
    server: Box<Server>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Ask the worker, which is healthy once a server has registered it
    Worker(Worker),
}

#[derive(Debug, Args)]
struct Worker {
    #[command(flatten)]
    listener: Listener,
    #[command(flatten)]
    patience: Patience,
}

#[derive(Debug, Args)]
struct Patience {
    /// Longest wait for the answer [s]
    #[arg(long, value_name = "S", default_value_t = 5.0)]
    timeout: f64,
}

impl Patience {
    fn time(&self) -> Result<Duration, Usage> {
        let time = Duration::try_from_secs_f64(self.timeout).ok().filter(|time| !time.is_zero());
        time.ok_or_else(|| Usage("--timeout is a number of seconds above 0".to_owned()))
    }
}

pub(crate) async fn run(args: Healthcheck, global: &Global) -> anyhow::Result<()> {
    match &args.command {
        None => server(&args).await,
        Some(Command::Worker(args)) => worker(args, global).await,
    }
}

async fn worker(args: &Worker, global: &Global) -> anyhow::Result<()> {
    let address = own_address(args.listener.worker_listen, "--worker-listen")?;
    let tls = args.listener.tls(global)?;
    match health(address, tls.as_ref(), args.patience.time()?).await.map_err(failure::failed)? {
        Health::Serving => output::line("the worker answers rollouts"),
        Health::NotRegistered => {
            Err(unhealthy("no server has registered the worker yet: see its log"))
        }
        Health::Silent(why) => {
            Err(unhealthy(format!("the worker at {address} does not answer: {why}")))
        }
    }
}

async fn server(args: &Healthcheck) -> anyhow::Result<()> {
    let options = args.server.options()?;
    let address = own_address(options.listen, "--listen")?;
    let (time, has_tls) = (args.patience.time()?, options.tls.is_some());
    let path = match args.without.join(",") {
        none if none.is_empty() => "/readyz".to_owned(),
        without => format!("/readyz?without={without}"),
    };
    let asked = tokio::time::timeout(time, ask(address, has_tls, &path, time)).await;
    let silent = |why: &dyn std::fmt::Display| {
        unhealthy(format!("the server at {address} does not answer: {why}"))
    };
    let (status, body) = match asked {
        Ok(Ok(answer)) => answer,
        Ok(Err(error)) => return Err(silent(&error)),
        Err(_) => return Err(silent(&"no answer in time")),
    };
    match (status, serde_json::from_str::<Answer>(&body)) {
        (200, Ok(_)) => output::line("the server is ready"),
        (_, Ok(answer)) => Err(unhealthy(answer.fault())),
        (status, Err(_)) => {
            let fault = format!("what answers at {address} is not a server of BendTwin ({status})");
            Err(unhealthy(fault))
        }
    }
}

/// What the server says: its checks, or why it refuses the question.
#[derive(Deserialize)]
#[serde(untagged)]
enum Answer {
    Readiness { checks: Vec<Check> },
    Problem { detail: String },
}

#[derive(Deserialize)]
struct Check {
    name: String,
    ok: bool,
    message: String,
}

impl Answer {
    fn fault(&self) -> String {
        match self {
            Self::Problem { detail } => detail.clone(),
            Self::Readiness { checks } => {
                let failed = checks.iter().filter(|check| !check.ok);
                let failed = failed.map(|check| format!("{}: {}", check.name, check.message));
                failed.collect::<Vec<_>>().join("; ")
            }
        }
    }
}

/// Status and body of the answer to a GET. Nothing secret is sent, so that the certificate does not
/// matter.
async fn ask(
    address: SocketAddr,
    has_tls: bool,
    path: &str,
    time: Duration,
) -> anyhow::Result<(u16, String)> {
    let settings = std::sync::Arc::new(unverified_client_config()?);
    let connector = Connector::new(time).at(address).with_tls(move || settings.clone());
    let scheme = if has_tls { "https" } else { "http" };
    let mut stream = connector.connect(format!("{scheme}://localhost").parse()?).await?;
    // HTTP/1.0: the answer is not chunked, and the connection ends with it.
    let request = format!("GET {path} HTTP/1.0\r\nHost: localhost\r\n\r\n");
    stream.write_all(request.as_bytes()).await?;
    stream.flush().await?;
    let mut answer = Vec::new();
    let read = stream.take(MOST).read_to_end(&mut answer).await;
    if answer.is_empty() {
        read?;
    }
    let answer = String::from_utf8_lossy(&answer);
    let (head, body) = answer.split_once("\r\n\r\n").unwrap_or((&answer, ""));
    let status = head.split(' ').nth(1).and_then(|status| status.parse().ok());
    let status = status.ok_or_else(|| anyhow::anyhow!("the answer is not one of HTTP"))?;
    Ok((status, body.to_owned()))
}

/// The address at which this machine reaches a listener.
fn own_address(listen: SocketAddr, option: &str) -> Result<SocketAddr, Usage> {
    if listen.port() == 0 {
        let fault = format!("{option} leaves the port to the system: name the one that is in use");
        return Err(Usage(fault));
    }
    let ip = match listen.ip() {
        IpAddr::V4(ip) if ip.is_unspecified() => Ipv4Addr::LOCALHOST.into(),
        IpAddr::V6(ip) if ip.is_unspecified() => Ipv6Addr::LOCALHOST.into(),
        ip => ip,
    };
    Ok(SocketAddr::new(ip, listen.port()))
}

fn unhealthy(message: impl Into<String>) -> anyhow::Error {
    let fault = Fault {
        category: Category::FailedPrecondition,
        reason: "NOT_HEALTHY".to_owned(),
        message: message.into(),
    };
    Failed(fault).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_own_address_is_where_the_listener_is_reached() {
        for (listen, own) in [
            ("0.0.0.0:7070", "127.0.0.1:7070"),
            ("[::]:7070", "[::1]:7070"),
            ("10.0.0.4:7071", "10.0.0.4:7071"),
        ] {
            let found = own_address(listen.parse().unwrap(), "--listen").unwrap();
            assert_eq!(found, own.parse().unwrap());
        }
        assert!(own_address("0.0.0.0:0".parse().unwrap(), "--listen").is_err());
    }

    #[test]
    fn failed_checks_are_named() {
        let body = r#"{"ready": false, "checks": [
            {"name": "running", "ok": true, "message": "the server runs"},
            {"name": "writes", "ok": false, "message": "the store cannot write"}]}"#;
        let answer: Answer = serde_json::from_str(body).unwrap();
        assert_eq!(answer.fault(), "writes: the store cannot write");
    }
}
