//! `bendtwin key`: make, list and revoke the keys of a server.

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
    /// Revoke keys, with the links to twins that were made with them: no server accepts them
    /// 30 s later
    Revoke {
        /// keys/{uuid}
        #[arg(required_unless_present = "owner")]
        names: Vec<KeyId>,
        /// Revoke all keys of this owner, sign-ins and links included, for example of a person who leaves
        #[arg(long, value_name = "NAME", conflicts_with = "names")]
        owner: Option<String>,
        /// Revoke only the sign-ins of the owner, for example of a person who changes groups
        #[arg(long, requires = "owner")]
        sign_ins: bool,
    },
}

#[derive(Debug, Args)]
struct Create {
    /// Name of the key: who uses it, and for what
    name: String,
    /// Scopes: admin, captures:read, captures:write, fits:read, fits:write,
    /// metrics:read, rollouts:run, twins:read, twins:write. Those of captures,
    /// fits, rollouts and twins may end in :own, for what its owner and the
    /// owner's projects have
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
    /// Most that is stored for its owner: captures with all that is made of them, twins, checkpoints
    /// and uploads [bytes]
    #[arg(long, value_name = "BYTES")]
    max_stored_bytes: Option<u64>,
    /// Most rollouts of its owner at a time
    #[arg(long, value_name = "N")]
    max_rollouts: Option<u64>,
    /// Most fits and ingests of its owner that run at workers; others wait
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    max_running_jobs: Option<u64>,
    /// Longest time for which a fit may run, for example 12h [default: the server's bound]
    #[arg(long, value_name = "TIME", value_parser = seconds)]
    max_fit_run: Option<u64>,
    /// Highest priority of its fits, up to 100 [default: 0, or 100 with the scope admin]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..=100))]
    max_priority: Option<u32>,
    /// Write the key to this file, which others cannot read, instead of printing it
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
}

pub(crate) async fn run(args: Key, global: &Global) -> anyhow::Result<()> {
    match args.command {
        Command::Create(args) => create(args, global).await,
        Command::List => list(global).await,
        Command::Revoke { names, owner, sign_ins } => {
            let client = global.connect().await?;
            let names = match owner {
                Some(owner) => of_owner(&client.keys().all().await?, &owner, sign_ins)?,
                None => names,
            };
            for name in &names {
                client.keys().revoke(*name).await?;
            }
            output::print(global, &names, || format!("revoked {}", names.len()))
        }
    }
}

/// Keys of an owner that are not revoked, or only the sign-ins among them. An owner without any is
/// refused: it may be mistyped, and somebody would keep their access.
fn of_owner(
    keys: &[bendtwin_client::Key],
    owner: &str,
    sign_ins: bool,
) -> Result<Vec<KeyId>, Usage> {
    let valid = keys.iter().filter(|key| key.revoke_time.is_none());
    let valid: Vec<_> = valid.filter(|key| key.is_sign_in || !sign_ins).collect();
    let found: Vec<_> = valid.iter().filter(|key| key.owner == owner).map(|key| key.name).collect();
    if !found.is_empty() {
        return Ok(found);
    }
    let is_other_case = |other: &&str| other.to_lowercase() == owner.to_lowercase();
    let what = if sign_ins { "sign-in" } else { "key" };
    let advice = match valid.iter().map(|key| key.owner.as_str()).find(is_other_case) {
        Some(other) => format!("there is one of `{other}`, whose case differs"),
        None => "`bendtwin key list` shows owners".to_owned(),
    };
    Err(Usage(format!("no {what} of `{owner}` is valid: {advice}")))
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
            running_jobs: args.max_running_jobs,
            fit_run_s: args.max_fit_run,
            priority: args.max_priority,
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
        let header = ["NAME", "CREATED", "LAST USE", "STATE", "OWNER", "SCOPES", "BOUNDS", "WHAT"];
        let mut table = Table::new(header);
        for key in &keys {
            let state = match (key.revoke_time, key.expire_time) {
                (Some(time), _) => format!("revoked {time:.0}"),
                (None, Some(time)) if time <= now => format!("expired {time:.0}"),
                (None, Some(time)) if key.is_sign_in => format!("signed in until {time:.0}"),
                (None, Some(time)) if key.twin.is_some() => format!("shared until {time:.0}"),
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
                bounds(&key.quotas),
                key.display_name.clone(),
            ]);
        }
        table.text()
    })
}

/// The bounds of a key in a few words; empty if it has none, and fits of normal priority.
fn bounds(quotas: &KeyQuotas) -> String {
    let of = |n: Option<u64>, what: &str| n.map(|n| format!("{n} {what}"));
    let parts = [
        of(quotas.queued_jobs, "queued"),
        of(quotas.running_jobs, "running"),
        of(quotas.fit_run_s, "s a fit"),
        of(quotas.priority.filter(|n| *n > 0).map(u64::from), "priority"),
        of(quotas.stored_bytes, "bytes"),
        of(quotas.rollouts, "rollouts"),
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// Seconds of a span, at least one: `12h`.
fn seconds(text: &str) -> Result<u64, Usage> {
    let span =
        text.parse::<Span>().and_then(|s| s.to_duration(SpanRelativeTo::days_are_24_hours()));
    let seconds = span.ok().and_then(|span| u64::try_from(span.as_secs()).ok());
    seconds.filter(|seconds| *seconds > 0).ok_or_else(|| no_duration(text))
}

fn no_duration(text: &str) -> Usage {
    Usage(format!("`{text}` is not a duration: give one like 90d or 12h"))
}

/// The time after a span: `90d`, `12h`.
fn later(text: &str) -> Result<Timestamp, Usage> {
    let time = text.parse::<Span>().and_then(|span| {
        Timestamp::now().checked_add(span.to_duration(SpanRelativeTo::days_are_24_hours())?)
    });
    time.map_err(|_| no_duration(text))
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
        assert_eq!((seconds("12h").unwrap(), seconds("2 days").unwrap()), (43_200, 172_800));
        for wrong in ["", "soon", "0s", "-1h", "10ms"] {
            assert!(seconds(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn an_owner_without_keys_is_refused() {
        let key = |owner: &str, is_sign_in| bendtwin_client::Key {
            name: KeyId::generate(),
            display_name: String::new(),
            owner: owner.to_owned(),
            scopes: Vec::new(),
            create_time: Timestamp::now(),
            expire_time: None,
            revoke_time: None,
            last_use_time: None,
            quotas: KeyQuotas::default(),
            is_sign_in,
            twin: None,
        };
        let keys = [key("ada@example.org", true), key("bob", false)];
        let found = of_owner(&keys, "ada@example.org", true).unwrap();
        assert_eq!(found, [keys[0].name]);
        assert_eq!(of_owner(&keys, "bob", false).unwrap(), [keys[1].name]);
        let refused = |owner: &str| of_owner(&keys, owner, true).unwrap_err().to_string();
        assert!(refused("Ada@example.org").contains("`ada@example.org`, whose case differs"));
        assert!(refused("bob").contains("no sign-in of `bob`"));
        let revoked =
            bendtwin_client::Key { revoke_time: Some(Timestamp::now()), ..key("c", true) };
        assert!(of_owner(&[revoked], "c", true).is_err());
    }

    #[test]
    fn bounds_are_listed_in_words() {
        let quotas = KeyQuotas {
            running_jobs: Some(2),
            fit_run_s: Some(3600),
            priority: Some(50),
            ..KeyQuotas::default()
        };
        assert_eq!(bounds(&quotas), "2 running, 3600 s a fit, 50 priority");
        assert_eq!(bounds(&KeyQuotas { priority: Some(0), ..KeyQuotas::default() }), "");
    }
}
