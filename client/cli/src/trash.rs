//! `bendtwin trash`: what was deleted and can be restored.

pub(crate) mod retention;

use std::str::FromStr;

use bendtwin_client::{CaptureId, Client, FitId, Trashed, TwinId};
use clap::{Args, Subcommand};
use serde::{Serialize, Serializer};

use crate::{failure::Usage, global::Global, output, table::Table};

#[derive(Debug, Args)]
pub(crate) struct Trash {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// List deleted captures, fits and twins
    List {
        /// List only those of this owner
        #[arg(long, value_name = "NAME", default_value = "", hide_default_value = true)]
        owner: String,
    },
    /// Restore deleted captures, fits and twins
    Restore {
        /// captures/{uuid}, fits/{uuid} or twins/{uuid}
        #[arg(required = true)]
        names: Vec<Name>,
    },
    /// Delete captures, fits and twins for good, in the trash or not
    Delete {
        /// captures/{uuid}, fits/{uuid} or twins/{uuid}
        #[arg(required = true)]
        names: Vec<Name>,
    },
    /// Delete all that is in the trash for good
    #[command(group = clap::ArgGroup::new("whose").required(true))]
    Empty {
        /// That of this owner
        #[arg(long, value_name = "NAME", group = "whose")]
        owner: Option<String>,
        /// That of all owners
        #[arg(long, group = "whose")]
        all: bool,
    },
}

/// Name of something that can be deleted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Name {
    Capture(CaptureId),
    Fit(FitId),
    Twin(TwinId),
}

impl FromStr for Name {
    type Err = Usage;
    fn from_str(text: &str) -> Result<Self, Usage> {
        let fault = |fault: bendtwin_client::InvalidName| Usage(fault.to_string());
        match text.split_once('/').map(|(collection, _)| collection) {
            Some("captures") => text.parse().map(Self::Capture).map_err(fault),
            Some("fits") => text.parse().map(Self::Fit).map_err(fault),
            Some("twins") => text.parse().map(Self::Twin).map_err(fault),
            _ => Err(Usage(format!(
                "`{text}` is not of the form captures/{{uuid}}, fits/{{uuid}} or twins/{{uuid}}"
            ))),
        }
    }
}

impl std::fmt::Display for Name {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Capture(id) => id.fmt(f),
            Self::Fit(id) => id.fmt(f),
            Self::Twin(id) => id.fmt(f),
        }
    }
}

impl Serialize for Name {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

pub(crate) async fn run(args: Trash, global: &Global) -> anyhow::Result<()> {
    let client = global.connect().await?;
    match args.command {
        Command::List { owner } => {
            let trashed = all(&client, &owner).await?;
            output::print(global, &trashed, || table(&trashed))
        }
        Command::Restore { names } => {
            let trash = client.trash();
            for name in &names {
                match *name {
                    Name::Capture(id) => drop(trash.restore_capture(id).await?),
                    Name::Fit(id) => drop(trash.restore_fit(id).await?),
                    Name::Twin(id) => drop(trash.restore_twin(id).await?),
                }
            }
            output::print(global, &names, || format!("restored {}", names.len()))
        }
        Command::Delete { names } => {
            for name in &names {
                purge(&client, *name).await?;
            }
            output::print(global, &names, || format!("deleted {} for good", names.len()))
        }
        Command::Empty { owner, all: _ } => {
            let names = all(&client, &owner.unwrap_or_default()).await?;
            let names: Vec<Name> =
                names.iter().map(|trashed| trashed.name.parse()).collect::<Result<_, _>>()?;
            for name in &names {
                purge(&client, *name).await?;
            }
            output::print(global, &names, || format!("deleted {} for good", names.len()))
        }
    }
}

async fn purge(client: &Client, name: Name) -> anyhow::Result<()> {
    match name {
        Name::Capture(id) => client.captures().purge(id).await?,
        Name::Fit(id) => client.fits().purge(id).await?,
        Name::Twin(id) => client.twins().purge(id).await?,
    }
    Ok(())
}

/// The whole trash, or what an owner has in it.
async fn all(client: &Client, owner: &str) -> anyhow::Result<Vec<Trashed>> {
    let trash = client.trash();
    let mut all = trash.captures(owner).await?;
    all.extend(trash.fits(owner).await?);
    all.extend(trash.twins(owner).await?);
    Ok(all)
}

fn table(trashed: &[Trashed]) -> String {
    let mut table = Table::new(["NAME", "DELETED", "BY", "UNTIL", "SIZE", "OWNER", "WHAT"]);
    for t in trashed {
        let size = if t.size_bytes > 0 { output::bytes(t.size_bytes) } else { String::new() };
        table.row([
            t.name.clone(),
            format!("{:.0}", t.delete_time),
            t.deleted_by.clone(),
            format!("{:.0}", t.purge_time),
            size,
            t.owner.clone(),
            t.display_name.clone(),
        ]);
    }
    table.text()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_by_their_collection() {
        let id = "0199aaaa-0000-7000-8000-000000000000";
        for collection in ["captures", "fits", "twins"] {
            let name = format!("{collection}/{id}");
            assert_eq!(name.parse::<Name>().unwrap().to_string(), name);
        }
        for wrong in [id, "captures/x", "workers/0199aaaa-0000-7000-8000-000000000000", ""] {
            assert!(wrong.parse::<Name>().is_err(), "{wrong}");
        }
    }
}
