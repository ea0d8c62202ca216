//! `bendtwin twin share`, `shares` and `unshare`: links by which people without a token look at a twin and
//! play with it.

use std::time::Duration;

use bendtwin_client::{NewShare, Share as Made, ShareId, TwinId};
use clap::Args;
use jiff::Timestamp;
use serde_json::json;

use crate::{global::Global, output, table::Table};

#[derive(Debug, Args)]
pub(crate) struct Share {
    /// twins/{uuid}
    name: TwinId,
    /// Days until the link expires, at most 90
    #[arg(long, value_name = "N", default_value_t = 7, value_parser = clap::value_parser!(u64).range(1..=90))]
    days: u64,
    /// For whom it is, as `twin shares` lists it
    #[arg(long = "for", value_name = "TEXT", default_value = "", hide_default_value = true)]
    whom: String,
    /// Let those who have the link download the twin
    #[arg(long)]
    allow_export: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Shares {
    /// twins/{uuid}
    name: TwinId,
}

#[derive(Debug, Args)]
pub(crate) struct Unshare {
    /// shares/{uuid}
    #[arg(required = true)]
    names: Vec<ShareId>,
}

/// Makes a link and prints it.
pub(super) async fn share(args: Share, global: &Global) -> anyhow::Result<()> {
    let shares = global.connect().await?.shares();
    let new = NewShare {
        display_name: args.whom,
        ttl: Some(Duration::from_secs(args.days * 86_400)),
        allow_export: args.allow_export,
    };
    match shares.create(args.name, new).await {
        Ok(made) => output::print(global, &made, || made.link.clone()),
        Err(error) if error.reason() == "SHARE_NOT_NEEDED" => {
            eprintln!("{error}");
            let link = shares.plain_link(args.name);
            output::print(global, &json!({ "share": null, "link": link }), || link.clone())
        }
        Err(error) => Err(error.into()),
    }
}

/// Lists the links of a twin.
pub(super) async fn list(args: Shares, global: &Global) -> anyhow::Result<()> {
    let all = global.connect().await?.shares().all(args.name).await?;
    let now = Timestamp::now();
    output::print(global, &all, || {
        let header = ["NAME", "CREATED", "LAST USE", "STATE", "EXPORT", "OWNER", "FOR"];
        let mut table = Table::new(header);
        for share in &all {
            table.row([
                share.name.to_string(),
                format!("{:.0}", share.create_time),
                share.last_use_time.map(|time| format!("{time:.0}")).unwrap_or_default(),
                state(share, now),
                if share.allow_export { "yes" } else { "no" }.to_owned(),
                share.owner.clone(),
                share.display_name.clone(),
            ]);
        }
        table.text()
    })
}

/// Revokes links.
pub(super) async fn revoke(args: Unshare, global: &Global) -> anyhow::Result<()> {
    let shares = global.connect().await?.shares();
    for name in &args.names {
        shares.revoke(*name).await?;
    }
    output::print(global, &args.names, || format!("revoked {}", args.names.len()))
}

fn state(share: &Made, now: Timestamp) -> String {
    match share.revoke_time {
        Some(time) => format!("revoked {time:.0}"),
        None if share.expire_time <= now => format!("expired {:.0}", share.expire_time),
        None => format!("until {:.0}", share.expire_time),
    }
}
