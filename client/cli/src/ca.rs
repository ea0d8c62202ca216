//! `bendtwin ca`: a private authority for the certificates of servers and workers.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use bendtwin_tls::{
    Certificate, Validity,
    authority::{AUTHORITY_DAYS, Authority, DAYS, Issued, Order, Role, Written, issued},
    files,
};
use clap::{Args, Subcommand, ValueEnum};
use jiff::{SignedDuration, Timestamp};
use serde::Serialize;

use crate::{failure::failed, global::Global, output, table::Table};

#[derive(Debug, Args)]
pub(crate) struct Ca {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Make an authority: ca.pem, and its key ca.key, which stays on this machine
    Init {
        /// Folder of the authority, made if missing
        folder: PathBuf,
    },
    /// Issue a certificate with its key: NAME.pem and NAME.key in the folder
    Issue(Issue),
    /// Renew all certificates that end soon, for the same hosts and as long as before: for a timer
    Renew {
        /// Folder of the authority
        folder: PathBuf,
        /// Time to the end of a certificate within which it is renewed, in days
        #[arg(long, value_name = "DAYS", default_value = "30d", value_parser = days)]
        within: u32,
    },
    /// Revoke certificates: write crl.pem, the list that servers and workers read, in the folder
    Revoke(Revoke),
    /// List the certificates that an authority has issued, with those that it has revoked
    List {
        /// Folder of the authority
        folder: PathBuf,
    },
    /// Show the certificates of a file, with their hosts and expiry
    Show {
        /// PEM file
        file: PathBuf,
    },
}

#[derive(Debug, Args)]
struct Issue {
    /// Folder of the authority
    folder: PathBuf,
    /// Role of the holder
    #[arg(long, value_enum, value_name = "ROLE")]
    role: RoleArg,
    /// Name of the holder: the name of the files, and its first host
    #[arg(long, value_name = "NAME")]
    name: String,
    /// Further host or address by which it is reached [default for a server: localhost, 127.0.0.1
    /// and ::1]
    #[arg(long = "host", value_name = "HOST")]
    hosts: Vec<String>,
    /// Days for which the certificate is valid
    #[arg(long, value_name = "N", default_value_t = DAYS,
        value_parser = clap::value_parser!(u32).range(1..=i64::from(AUTHORITY_DAYS)))]
    days: u32,
    /// Replace the certificate of that name, and its key
    #[arg(long)]
    renew: bool,
}

#[derive(Debug, Args)]
struct Revoke {
    /// Folder of the authority
    folder: PathBuf,
    /// Name (all certificates that had it), serial number or file of a certificate; without any the
    /// list is written unchanged
    #[arg(value_name = "NAME|SERIAL|FILE")]
    certificates: Vec<String>,
}

/// Roles of holders, as users write them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum RoleArg {
    /// A server, for its clients or its workers on other hosts
    Server,
    /// A worker on another host
    Worker,
}

/// Facts of a certificate, for people and scripts.
#[derive(Serialize)]
struct CertificateFacts {
    name: String,
    serial: String,
    issuer: String,
    hosts: Vec<String>,
    is_authority: bool,
    not_before: Timestamp,
    not_after: Timestamp,
}

/// List of revoked certificates that was written.
#[derive(Serialize)]
struct List {
    list: PathBuf,
    number: u64,
    certificates: Vec<Row>,
    total: usize,
}

/// Certificate that was issued.
#[derive(Serialize)]
struct Row {
    name: String,
    serial: String,
    hosts: Vec<String>,
    not_after: Timestamp,
    revoke_time: Option<Timestamp>,
}

/// Files that were written.
#[derive(Serialize)]
struct Files {
    certificate: PathBuf,
    key: PathBuf,
    not_after: Timestamp,
}

pub(crate) fn run(args: Ca, global: &Global) -> anyhow::Result<()> {
    match args.command {
        Command::Init { folder } => init(&folder, global),
        Command::Issue(args) => issue(args, global),
        Command::Renew { folder, within } => renew(&folder, within, global),
        Command::Revoke(args) => revoke(&args, global),
        Command::List { folder } => list(&folder, global),
        Command::Show { file } => show(&file, global),
    }
}

fn init(folder: &Path, global: &Global) -> anyhow::Result<()> {
    let written = Authority::create(folder).map_err(failed)?;
    print(&written, global, |files| {
        let folder = folder.display();
        format!(
            "{files}\nKeep the key here: its holder can impersonate every server and worker.\n\
             Next: bendtwin ca issue {folder} --role server --name NAME --host HOST"
        )
    })
}

fn issue(args: Issue, global: &Global) -> anyhow::Result<()> {
    let role = match args.role {
        RoleArg::Server => Role::Server,
        RoleArg::Worker => Role::Worker,
    };
    let days = i64::from(args.days);
    let order = Order { name: args.name, hosts: args.hosts, role, days, renew: args.renew };
    let authority = Authority::open(&args.folder).map_err(failed)?;
    let written = authority.issue(&order).map_err(failed)?;
    let (ca, _) = Authority::paths(&args.folder);
    print(&written, global, |files| {
        let (certificate, key) = (written.certificate.display(), written.key.display());
        let (ca, hosts) = (ca.display(), written.facts.hosts.join(", "));
        let crl = Authority::list_path(&args.folder);
        let crl = crl.display();
        let next = match role {
            Role::Server => format!(
                "For clients: bendtwin server --tls-certificate {certificate} --tls-key {key}; \
                 they are given {ca} (--ca, BENDTWIN_CA)\n\
                 For workers on other hosts: bendtwin server --listen-workers-tls ADDRESS \
                 --worker-tls-certificate {certificate} --worker-tls-key {key} --worker-tls-ca {ca} \
                 --worker-tls-crl {crl}"
            ),
            Role::Worker => format!(
                "Next: copy both files and {ca} to the worker's host, and there\n\
                 bendtwin worker --server https://SERVER:PORT --ca ca.pem --certificate {0}.pem \
                 --key {0}.key",
                order.name
            ),
        };
        format!("{files}\nfor {hosts}\n{next}")
    })
}

fn print(
    written: &Written,
    global: &Global,
    text: impl FnOnce(String) -> String,
) -> anyhow::Result<()> {
    let files = Files::of(written);
    output::print(global, &files, || {
        text(format!(
            "wrote {} and its key {}, until {:.0}",
            files.certificate.display(),
            files.key.display(),
            files.not_after
        ))
    })
}

/// A number of days, as `30` or `30d`.
fn days(text: &str) -> Result<u32, String> {
    let days = text.strip_suffix('d').unwrap_or(text).parse().map_err(|_| "give days, as 30d")?;
    let longest = AUTHORITY_DAYS;
    if days <= longest { Ok(days) } else { Err(format!("give at most {longest}d")) }
}

fn renew(folder: &Path, within: u32, global: &Global) -> anyhow::Result<()> {
    let authority = Authority::open(folder).map_err(failed)?;
    let within = SignedDuration::from_hours(24 * i64::from(within));
    let renewed = authority.renew(within).map_err(failed)?;
    let (end, now) = (authority.end(), Timestamp::now());
    if end.duration_since(now) <= within {
        tracing::warn!(
            "the authority itself ends at {end:.0}: make another one, and give its certificate to everyone"
        );
    }
    let files: Vec<_> = renewed.iter().map(Files::of).collect();
    output::print(global, &files, || {
        if files.is_empty() {
            return "No certificate ends soon.".to_owned();
        }
        let lines = files.iter().map(|one| {
            let (certificate, key) = (one.certificate.display(), one.key.display());
            format!("renewed {certificate} and its key {key}, until {:.0}\n", one.not_after)
        });
        let lines: String = lines.collect();
        format!(
            "{lines}Servers and workers that have these files read them within seconds; copy the others"
        )
    })
}

fn revoke(args: &Revoke, global: &Global) -> anyhow::Result<()> {
    let authority = Authority::open(&args.folder).map_err(failed)?;
    let done = authority.revoke(&args.certificates).map_err(failed)?;
    let certificates: Vec<_> = done.asked.iter().map(Row::of).collect();
    let list = List { list: done.list, number: done.number, certificates, total: done.total };
    output::print(global, &list, || {
        let revoked =
            list.certificates.iter().map(|one| format!("revoked {} ({})\n", one.name, one.serial));
        let (path, total) = (list.list.display(), list.total);
        format!(
            "{}wrote {path}, with {total} revoked in all\n\
             Next: copy it over the file of --worker-tls-crl of each server, and of --crl of each \
             worker: within seconds they read it, and end the connections of revoked certificates",
            revoked.collect::<String>()
        )
    })
}

fn list(folder: &Path, global: &Global) -> anyhow::Result<()> {
    let rows: Vec<_> = issued(folder).map_err(failed)?.iter().map(Row::of).collect();
    let now = Timestamp::now();
    output::print(global, &rows, || {
        let mut table = Table::new(["NAME", "HOSTS", "UNTIL", "STATE", "SERIAL"]);
        for row in &rows {
            let state = match row.revoke_time {
                Some(at) => format!("revoked at {at:.0}"),
                None if row.not_after < now => "expired".to_owned(),
                None => "valid".to_owned(),
            };
            let (hosts, until) = (row.hosts.join(","), format!("{:.0}", row.not_after));
            table.row([row.name.clone(), hosts, until, state, row.serial.clone()]);
        }
        table.text()
    })
}

impl Files {
    fn of(written: &Written) -> Self {
        Self {
            certificate: written.certificate.clone(),
            key: written.key.clone(),
            not_after: written.facts.not_after,
        }
    }
}

impl Row {
    fn of(issued: &Issued) -> Self {
        let facts = &issued.facts;
        Self {
            name: facts.common_name.clone(),
            serial: facts.serial.clone(),
            hosts: facts.hosts.clone(),
            not_after: facts.not_after,
            revoke_time: issued.revoked,
        }
    }
}

fn show(file: &Path, global: &Global) -> anyhow::Result<()> {
    let found = files::certificates(file).map_err(failed)?;
    let found = found.iter().map(|der| Certificate::of(der).context("a certificate is damaged"));
    let found = found.collect::<anyhow::Result<Vec<_>>>()?;
    let shown = found.iter().map(|certificate| CertificateFacts {
        name: certificate.name().to_owned(),
        serial: certificate.serial.clone(),
        issuer: certificate.issuer.clone(),
        hosts: certificate.hosts.clone(),
        is_authority: certificate.is_authority,
        not_before: certificate.not_before,
        not_after: certificate.not_after,
    });
    let shown: Vec<_> = shown.collect();
    output::print(global, &shown, || {
        found
            .iter()
            .map(|certificate| line(certificate, Timestamp::now()))
            .collect::<Vec<_>>()
            .join("\n")
    })
}

fn line(certificate: &Certificate, now: Timestamp) -> String {
    let what = match certificate.is_authority {
        true => format!("authority {}", certificate.common_name),
        false => format!("{}, issued by {}", certificate.hosts.join(", "), certificate.issuer),
    };
    let days = certificate.not_after.duration_since(now).as_hours() / 24;
    let (begin, end) = (certificate.not_before, certificate.not_after);
    match certificate.validity(now) {
        Validity::Valid | Validity::Soon => format!("{what}: until {end:.0} ({days} days)"),
        Validity::Expired => format!("{what}: EXPIRED at {end:.0}"),
        Validity::NotYet => format!("{what}: NOT VALID before {begin:.0}"),
    }
}
