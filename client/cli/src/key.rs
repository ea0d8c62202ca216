//! `bendtwin key`: make, list and revoke the keys of a server.

pub(crate) mod login;

use std::path::PathBuf;

use anyhow::Context as _;
use bendtwin_client::{KeyId, KeyQuotas, MadeKey, NewKey, token};
use clap::{Args, Subcommand};
use jiff::{Span, SpanRelativeTo, Timestamp};

use crate::{failure::Usage, global::Global, output, table::Table};

#[derive(Debug, Args)]
pub(crate) struct Key {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Make a key and print it, which is done only once
    Create(Create),
    /// List keys, with revoked and expired ones
    List,
    /// Revoke keys, or all sign-ins of a person: no server accepts them 30 s later
    Revoke {
        /// keys/{uuid}
        #[arg(required_unless_present = "sign_ins_of")]
        names: Vec<KeyId>,
        /// Revoke all sign-ins of this owner
        #[arg(long, value_name = "OWNER")]
        sign_ins_of: Option<String>,
    },
}

#[derive(Debug, Args)]
struct Create {
    /// Name of the key: who uses it, and for what
    name: String,
    /// Scopes: admin, captures:read, captures:write, fits:read, fits:write,
    /// rollouts:run, twins:read, twins:write
    #[arg(long = "scope", value_name = "SCOPE,...", value_delimiter = ',', required = true)]
    scopes: Vec<String>,
    /// Owner of what is made with it [default: its name]
    #[arg(long, value_name = "NAME", default_value = "", hide_default_value = true)]
    owner: String,
    /// Time after which it is refused, for example 90d or 12h [default: it does not expire]
    #[arg(long, value_name = "TIME", value_parser = later)]
    expires: Option<Timestamp>,
    /// Most fits and ingests of its owner that wait for a worker
    #[arg(long, value_name = "N")]
    max_queued_jobs: Option<u64>,
    /// Most that captures, twins and uploads of its owner take [bytes]
    #[arg(long, value_name = "BYTES")]
    max_stored_bytes: Option<u64>,
    /// Most rollouts of its owner at a time
    #[arg(long, value_name = "N")]
    max_rollouts: Option<u64>,
    /// Write the key to this file, which others cannot read, instead of printing it
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
}

pub(crate) async fn run(args: Key, global: &Global) -> anyhow::Result<()> {
    match args.command {
        Command::Create(args) => create(args, global).await,
        Command::List => list(global).await,
        Command::Revoke { names, sign_ins_of } => {
            let client = global.connect().await?;
            for name in &names {
                client.keys().revoke(*name).await?;
            }
            let Some(owner) = sign_ins_of else {
                return output::print(global, &names, || format!("revoked {}", names.len()));
            };
            let count = client.sign_ins().revoke_all(&owner).await?;
            output::print(global, &count, || format!("revoked {count} sign-ins of {owner}"))
        }
    }
}

async fn create(args: Create, global: &Global) -> anyhow::Result<()> {
    let new = NewKey {
        display_name: args.name,
        owner: args.owner,
        scopes: args.scopes,
        expire_time: args.expires,
        quotas: KeyQuotas {
            queued_jobs: args.max_queued_jobs,
            stored_bytes: args.max_stored_bytes,
            rollouts: args.max_rollouts,
        },
    };
    // A key that cannot be kept is not made.
    let file = args.output.map(|path| {
        let file = token::create_private(&path)
            .with_context(|| format!("cannot write the key to {}", path.display()))?;
        Ok::<_, anyhow::Error>((path, file))
    });
    let file = file.transpose()?;
    let made = make(new, global).await;
    if let (Err(_), Some((path, _))) = (&made, &file) {
        let _ = std::fs::remove_file(path);
    }
    let made = made?;
    let Some((path, mut file)) = file else {
        return output::print(global, &made, || made.secret_key.clone());
    };
    std::io::Write::write_all(&mut file, format!("{}\n", made.secret_key).as_bytes())
        .with_context(|| format!("cannot write the key to {}", path.display()))?;
    output::print(global, &made.key, || format!("{} is in {}", made.key.name, path.display()))
}

async fn make(new: NewKey, global: &Global) -> anyhow::Result<MadeKey> {
    Ok(global.connect().await?.keys().create(new).await?)
}

async fn list(global: &Global) -> anyhow::Result<()> {
    let keys = global.connect().await?.keys().all().await?;
    let now = Timestamp::now();
    output::print(global, &keys, || {
        let header = ["NAME", "CREATED", "LAST USE", "STATE", "OWNER", "SCOPES", "WHAT"];
        let mut table = Table::new(header);
        for key in &keys {
            let state = match (key.revoke_time, key.expire_time) {
                (Some(time), _) => format!("revoked {time:.0}"),
                (None, Some(time)) if time <= now => format!("expired {time:.0}"),
                (None, Some(time)) if key.is_sign_in => format!("signed in until {time:.0}"),
                (None, Some(time)) => format!("until {time:.0}"),
                (None, None) => "valid".to_owned(),
            };
            table.row([
                key.name.to_string(),
                format!("{:.0}", key.create_time),
                key.last_use_time.map(|time| format!("{time:.0}")).unwrap_or_default(),
                state,
                key.owner.clone(),
                key.scopes.join(","),
                key.display_name.clone(),
            ]);
        }
        table.text()
    })
}

/// The time after a span: `90d`, `12h`.
fn later(text: &str) -> Result<Timestamp, Usage> {
    let time = text.parse::<Span>().and_then(|span| {
        Timestamp::now().checked_add(span.to_duration(SpanRelativeTo::days_are_24_hours())?)
    });
    time.map_err(|_| Usage(format!("`{text}` is not a duration: give one like 90d or 12h")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_are_read_as_times() {
        let hours = |text: &str| {
            let left = later(text).unwrap().duration_since(Timestamp::now());
            (left.as_secs_f64() / 3600.0).round()
        };
        assert_eq!((hours("12h"), hours("90d"), hours("2 days")), (12.0, 2160.0, 48.0));
        for wrong in ["", "soon", "1y", "99999999d"] {
            assert!(later(wrong).is_err(), "{wrong}");
        }
    }
}
