//! `bendtwin server`: the control plane, which starts its own workers.

pub(crate) mod healthcheck;
mod options;

use std::{
    io::IsTerminal as _,
    path::{Path, PathBuf},
};

use anyhow::Context as _;
use bendtwin_backends as backends;
use bendtwin_client::token;
use bendtwin_server::Service;
use clap::Args;
use serde::Serialize;

use crate::{
    access::console::{local, login_address},
    failure, logging, output, signals,
};

/// Options of the server. Flags take precedence over the environment, that over the file, and that
/// over the defaults.
// Serialized, a flag has the name of its key in the file, with dots between tables.
#[derive(Debug, Args, Serialize)]
pub(crate) struct Server {
    /// TOML file with options (deploy/config.toml has all of them)
    #[arg(long, env = "BENDTWIN_CONFIG", value_name = "FILE")]
    #[serde(skip)]
    config: Option<PathBuf>,
    /// Address for HTTP and gRPC; port 0 takes a free one [default: 127.0.0.1:7070]
    #[arg(long, env = "BENDTWIN_LISTEN", value_name = "ADDRESS")]
    listen: Option<std::net::SocketAddr>,
    /// Address at which clients reach the server, where it differs: behind a proxy, or at the
    /// published port of a container; it is printed at start [default: the address that it listens
    /// on]
    #[arg(long, env = "BENDTWIN_PUBLIC_URL", value_name = "URL")]
    public_url: Option<String>,
    /// Name by which clients may call the server, in addition to localhost and addresses; * allows
    /// all
    #[arg(
        long = "allowed-host",
        env = "BENDTWIN_ALLOWED_HOSTS",
        value_name = "NAME,...",
        value_delimiter = ','
    )]
    allowed_hosts: Option<Vec<String>>,
    /// Whether clients must send the token in DIR/client-token, or a key: required or none
    /// [default: required]
    #[arg(long, env = "BENDTWIN_CLIENT_TOKEN", value_name = "POLICY", value_parser = ["required", "none"])]
    client_token: Option<String>,
    /// File with the token of clients, which is the same for all servers of a fleet [default:
    /// DIR/client-token, made at the first start]
    #[arg(long, env = "BENDTWIN_CLIENT_TOKEN_FILE", value_name = "FILE")]
    client_token_file: Option<PathBuf>,
    /// Certificate for clients, for https://: a PEM file, reloaded when it changes
    #[arg(long, env = "BENDTWIN_TLS_CERTIFICATE", value_name = "FILE", requires = "tls_key")]
    #[serde(rename = "tls.certificate")]
    tls_certificate: Option<PathBuf>,
    /// Key of this certificate: a PEM file that other users cannot read
    #[arg(long, env = "BENDTWIN_TLS_KEY", value_name = "FILE", requires = "tls_certificate")]
    #[serde(rename = "tls.key")]
    tls_key: Option<PathBuf>,
    /// Address for workers on other hosts, which need a certificate [default: none]. Requires the
    /// three files below, and --worker-token
    #[arg(
        long = "listen-workers-tls",
        env = "BENDTWIN_LISTEN_WORKERS_TLS",
        value_name = "ADDRESS",
        requires_all = ["worker_tls_certificate", "worker_tls_key", "worker_tls_ca"]
    )]
    #[serde(rename = "worker_tls.listen")]
    worker_tls_listen: Option<std::net::SocketAddr>,
    /// Certificate of the server for its workers: a PEM file, reloaded when it changes
    #[arg(
        long,
        env = "BENDTWIN_WORKER_TLS_CERTIFICATE",
        value_name = "FILE",
        requires = "worker_tls_listen"
    )]
    #[serde(rename = "worker_tls.certificate")]
    worker_tls_certificate: Option<PathBuf>,
    /// Key of this certificate: a PEM file that other users cannot read
    #[arg(
        long,
        env = "BENDTWIN_WORKER_TLS_KEY",
        value_name = "FILE",
        requires = "worker_tls_listen"
    )]
    #[serde(rename = "worker_tls.key")]
    worker_tls_key: Option<PathBuf>,
    /// Certificate of the authority of the workers' certificates: a PEM file
    #[arg(
        long,
        env = "BENDTWIN_WORKER_TLS_CA",
        value_name = "FILE",
        requires = "worker_tls_listen"
    )]
    #[serde(rename = "worker_tls.client_ca")]
    worker_tls_ca: Option<PathBuf>,
    /// List of the workers' certificates that this authority has revoked (`bendtwin ca revoke`): a
    /// PEM file, reloaded when it changes [default: none]
    #[arg(
        long,
        env = "BENDTWIN_WORKER_TLS_CRL",
        value_name = "FILE",
        requires = "worker_tls_listen"
    )]
    #[serde(rename = "worker_tls.crl")]
    worker_tls_crl: Option<PathBuf>,
    /// Listen on an address that is not loopback, behind a proxy that terminates TLS [default:
    /// false]
    #[arg(
        long,
        env = "BENDTWIN_TLS_TERMINATED_BY_PROXY",
        value_name = "true|false",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "true"
    )]
    tls_terminated_by_proxy: Option<bool>,
    /// Listen on an address that is not loopback, in a container whose port is published to this
    /// machine alone: no TLS, a token, and a link that logs in among the output [default: false]
    #[arg(
        long,
        env = "BENDTWIN_PUBLISHED_LOCALLY",
        value_name = "true|false",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "true"
    )]
    published_locally: Option<bool>,
    /// Listen on an address that is not loopback without TLS, and with --client-token none
    /// [default: false]
    #[arg(
        long,
        env = "BENDTWIN_INSECURE",
        value_name = "true|false",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "true"
    )]
    insecure: Option<bool>,
    /// Folder of the database and of all content [default: bendtwin-data]
    #[arg(long, env = "BENDTWIN_DATA_DIR", value_name = "DIR")]
    data_dir: Option<PathBuf>,
    /// PostgreSQL database for everything except content, postgres://USER@HOST:PORT/DATABASE
    /// [default: SQLite in the data folder]. Other users of the machine see arguments: give a
    /// password by the environment, or in PostgreSQL's password file
    #[arg(long, env = "BENDTWIN_DATABASE_URL", value_name = "URL", hide_env_values = true)]
    #[serde(rename = "database_url")]
    database: Option<String>,
    /// Place of all content, s3://BUCKET/PREFIX (keys and region from AWS_* in the environment) or
    /// file:///FOLDER [default: the data folder]
    #[arg(long, env = "BENDTWIN_OBJECTS", value_name = "URL")]
    #[serde(rename = "objects_url")]
    objects: Option<String>,
    /// Number of worker processes that the server starts itself [default: 1]
    #[arg(long, env = "BENDTWIN_WORKERS", value_name = "N")]
    #[serde(rename = "workers.count")]
    workers: Option<u32>,
    /// Backend of these workers: auto (CUDA if this machine has it), cpu or cuda [default: auto]
    #[arg(long, env = "BENDTWIN_BACKEND", value_name = "BACKEND")]
    #[serde(rename = "workers.backend", serialize_with = "as_text")]
    backend: Option<backends::Choice>,
    /// CUDA devices of these workers, assigned in turn, counted from 0 [default: 0]
    #[arg(long, env = "BENDTWIN_DEVICES", value_name = "N,...", value_delimiter = ',')]
    #[serde(rename = "workers.devices")]
    devices: Option<Vec<u32>>,
    /// Memory of all current requests together [MiB; default: an eighth of the machine's, at most
    /// 2048]
    #[arg(long, env = "BENDTWIN_MEMORY_MIB", value_name = "MIB")]
    memory_mib: Option<u64>,
    /// Memory of the server's own workers together [MiB; default: half of the machine's]
    #[arg(long, env = "BENDTWIN_WORKERS_MEMORY_MIB", value_name = "MIB")]
    #[serde(rename = "workers.memory_mib")]
    workers_memory_mib: Option<u64>,
    /// Token of separately started workers; at least 16 characters
    #[arg(long, env = "BENDTWIN_WORKER_TOKEN", value_name = "TOKEN", hide_env_values = true)]
    worker_token: Option<String>,
    /// Address only for workers and health checks; port 0 takes a free one [default: 127.0.0.1:0]
    #[arg(long = "listen-workers", env = "BENDTWIN_LISTEN_WORKERS", value_name = "ADDRESS")]
    worker_listen: Option<std::net::SocketAddr>,
    /// Time for which an interrupted upload can be resumed after its last byte [s] [default:
    /// 604800]
    #[arg(long, env = "BENDTWIN_UPLOAD_EXPIRY", value_name = "SECONDS")]
    #[serde(rename = "upload_expiry_s")]
    upload_expiry: Option<f64>,
    /// Free space of the disk below which new captures, twins and fits are refused [MiB] [default:
    /// 256]
    #[arg(long, env = "BENDTWIN_DISK_FLOOR_MIB", value_name = "MIB")]
    disk_floor_mib: Option<u64>,
    /// Time for which what was deleted can be restored [s]; 0 deletes for good [default: 604800]
    #[arg(long, env = "BENDTWIN_TRASH", value_name = "SECONDS")]
    #[serde(rename = "trash_s")]
    trash: Option<f64>,
    /// Write the port to this file once the server answers
    #[arg(long, value_name = "FILE")]
    #[serde(skip)]
    port_file: Option<PathBuf>,
    /// Exit when the standard input ends
    #[arg(long)]
    #[serde(skip)]
    exit_with_parent: bool,
}

fn as_text<S: serde::Serializer>(
    choice: &Option<backends::Choice>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    choice.map(|choice| choice.to_string()).serialize(serializer)
}

pub(crate) async fn run(args: Server, logging: &logging::Options) -> anyhow::Result<()> {
    let shutdown = signals::shutdown();
    if args.exit_with_parent {
        signals::end_with_parent(shutdown.clone());
    }
    let mut options = args.options()?;
    let of_logs = logging.environment().into_iter();
    options.workers.environment = of_logs.map(|(name, value)| (name.to_owned(), value)).collect();
    let scheme = if options.tls.is_some() { "https" } else { "http" };
    let public_url = options.public_url().map(str::to_owned);
    let is_published_locally = options.is_published_locally();
    let workers = options.workers.count;
    let data_dir = options.data_dir.display().to_string();
    let handle = Service::start(options).await.map_err(failure::failed)?;
    let address = handle.local_addr();
    let client_token = handle.client_token().map(str::to_owned);
    match &client_token {
        Some(shown) => {
            if let Err(error) = token::publish(address.port(), shown) {
                tell_unpublished(&error);
            }
        }
        None => token::withdraw_any(address.port()),
    }
    if let Some(path) = &args.port_file {
        write_port(path, address.port())?;
    }
    let url = public_url.unwrap_or_else(|| format!("{scheme}://{}", local(address)));
    // The output of a container goes to its log, which only those can read who can read its volumes.
    let is_private = is_published_locally || std::io::stdout().is_terminal();
    output::line(&format!(
        "BendTwin answers HTTP and gRPC at {url} ({workers} workers, data in {data_dir}; API at {url}/docs). {}",
        console_hint(&url, client_token.as_deref(), is_private)
    ))?;
    if let Some(address) = handle.worker_tls_addr() {
        output::line(&format!("Workers on other hosts reach it at https://{address}"))?;
    }
    shutdown.cancelled().await;
    handle.shutdown().await;
    if let Some(shown) = client_token {
        token::withdraw(address.port(), &shown);
    }
    Ok(())
}

/// Says why commands on this machine do not find the token. In a container whose files are read-only that is as
/// it was arranged.
fn tell_unpublished(error: &std::io::Error) {
    if error.kind() == std::io::ErrorKind::ReadOnlyFilesystem {
        tracing::info!("commands on this machine need --token-file: the home folder is read-only");
    } else {
        tracing::warn!(%error, "cannot leave the token for local clients, which need it now");
    }
}

/// Where to look first. A token is shown only where the output is private, not in every log.
fn console_hint(url: &str, token: Option<&str>, is_private: bool) -> String {
    match token {
        Some(_) if !is_private => "`bendtwin console` opens the console, logged in".to_owned(),
        token => format!("Open the console: {}", login_address(url, "/", token)),
    }
}

/// Writes the whole file or nothing: a reader that waits for it must not read half a number.
fn write_port(path: &Path, port: u16) -> anyhow::Result<()> {
    let write = || {
        let partial = path.with_extension("partial");
        std::fs::write(&partial, format!("{port}\n"))?;
        std::fs::rename(&partial, path)
    };
    write().with_context(|| format!("cannot write the port to {}", path.display()))
}
