//! `bendtwin retention`: the rules by which a server deletes by itself.

use bendtwin_client::{NewRetentionRule, RetentionId, RetentionPreview, RetentionRule};
use clap::{Args, Subcommand};

use crate::{global::Global, output, table::Table};

#[derive(Debug, Args)]
pub(crate) struct Retention {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// List the rules, also those of the server's configuration
    List,
    /// Make a rule: what fulfils all of its conditions is moved to the trash
    Create(Create),
    /// Delete rules that were made with `create`
    Delete {
        /// retention/{uuid}
        #[arg(required = true)]
        names: Vec<RetentionId>,
    },
    /// Show what the rules would delete now, and what they match but is kept and why
    Preview,
}

#[derive(Debug, Args)]
struct Create {
    /// Name of the rule: what it is for
    name: String,
    /// What it deletes
    #[arg(value_parser = ["captures", "fits", "twins"])]
    collection: String,
    /// Delete only what was created at least this long ago [days]
    #[arg(long, value_name = "DAYS")]
    min_age_days: f64,
    /// Delete only what this owner has
    #[arg(long, value_name = "NAME", default_value = "", hide_default_value = true)]
    owner: String,
    /// Delete only what has this tag
    #[arg(long, value_name = "TAG", default_value = "", hide_default_value = true)]
    tag: String,
    /// Delete only captures whose report has this verdict: good, usable or unusable
    #[arg(long, value_name = "VERDICT", default_value = "", hide_default_value = true)]
    verdict: String,
}

pub(crate) async fn run(args: Retention, global: &Global) -> anyhow::Result<()> {
    let retention = global.connect().await?.retention();
    match args.command {
        Command::List => {
            let rules = retention.list().await?;
            output::print(global, &rules, || table(&rules))
        }
        Command::Create(args) => {
            let new = NewRetentionRule {
                display_name: args.name,
                collection: args.collection,
                min_age_days: args.min_age_days,
                owner: args.owner,
                tag: args.tag,
                verdict: args.verdict,
            };
            let rule = retention.create(new).await?;
            output::print(global, &rule, || {
                rule.name.map(|name| name.to_string()).unwrap_or_default()
            })
        }
        Command::Delete { names } => {
            for name in &names {
                retention.delete(*name).await?;
            }
            output::print(global, &names, || format!("deleted {}", names.len()))
        }
        Command::Preview => {
            let preview = retention.preview().await?;
            output::print(global, &preview, || shown(&preview))
        }
    }
}

fn table(rules: &[RetentionRule]) -> String {
    let header = ["NAME", "DELETES", "DAYS", "OWNER", "TAG", "VERDICT", "WHAT"];
    let mut table = Table::new(header);
    for rule in rules {
        let name = rule.name.map(|name| name.to_string());
        table.row([
            name.unwrap_or_else(|| "(configuration)".to_owned()),
            rule.collection.clone(),
            rule.min_age_days.to_string(),
            rule.owner.clone(),
            rule.tag.clone(),
            rule.verdict.clone(),
            rule.display_name.clone(),
        ]);
    }
    table.text()
}

fn shown(preview: &RetentionPreview) -> String {
    let mut table = Table::new(["NAME", "CREATED", "SIZE", "OWNER", "RULE", "OUTCOME", "WHAT"]);
    for found in &preview.outcomes {
        let size =
            if found.size_bytes > 0 { output::bytes(found.size_bytes) } else { String::new() };
        let outcome = match &found.kept_because {
            None => "is deleted".to_owned(),
            Some(reason) => format!("is kept: {reason}"),
        };
        table.row([
            found.name.clone(),
            format!("{:.0}", found.create_time),
            size,
            found.owner.clone(),
            found.rule.clone(),
            outcome,
            found.display_name.clone(),
        ]);
    }
    let deleted = preview.outcomes.iter().filter(|found| found.kept_because.is_none());
    let bytes = output::bytes(deleted.clone().map(|found| found.size_bytes).sum());
    let more = if preview.truncated { "; there are more than are listed" } else { "" };
    let kept = preview.outcomes.len() - deleted.clone().count();
    format!("{}\n{} to delete ({bytes}), {kept} kept{more}", table.text(), deleted.count())
}
