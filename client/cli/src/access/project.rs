//! `bendtwin project`: sets of owners who share what each of them has.

use bendtwin_client::{Project as Shared, ProjectChange, ProjectId};
use clap::{Args, Subcommand};

use crate::{global::Global, output, table::Table};

#[derive(Debug, Args)]
pub(crate) struct Project {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Make a project
    Create {
        /// Display name of the project
        name: String,
        /// Owners who share, as `bendtwin key list` shows them
        #[arg(long = "member", value_name = "OWNER,...", value_delimiter = ',')]
        members: Vec<String>,
    },
    /// List the projects of your key's owner, or all with the scope admin
    List,
    /// Show a project
    Show {
        /// projects/{uuid}
        name: ProjectId,
    },
    /// Add members: they share with the others within 30 s
    Add {
        /// projects/{uuid}
        name: ProjectId,
        /// Owners
        #[arg(required = true)]
        members: Vec<String>,
    },
    /// Take members away: they share no more 30 s later
    Remove {
        /// projects/{uuid}
        name: ProjectId,
        /// Owners
        #[arg(required = true)]
        members: Vec<String>,
    },
    /// Delete projects: their members keep what they have, and share it no more
    Delete {
        /// projects/{uuid}
        #[arg(required = true)]
        names: Vec<ProjectId>,
    },
}

pub(crate) async fn run(args: Project, global: &Global) -> anyhow::Result<()> {
    let projects = global.connect().await?.projects();
    let project = match args.command {
        Command::Create { name, members } => projects.create(name, members).await?,
        Command::Show { name } => projects.get(name).await?,
        Command::Add { name, members } => {
            let change = ProjectChange { add_members: members, ..ProjectChange::default() };
            projects.update(name, change).await?
        }
        Command::Remove { name, members } => {
            let change = ProjectChange { remove_members: members, ..ProjectChange::default() };
            projects.update(name, change).await?
        }
        Command::List => {
            let all = projects.all().await?;
            return output::print(global, &all, || text(&all));
        }
        Command::Delete { names } => {
            for name in &names {
                projects.delete(*name).await?;
            }
            return output::print(global, &names, || format!("deleted {}", names.len()));
        }
    };
    output::print(global, &project, || text(std::slice::from_ref(&project)))
}

fn text(projects: &[Shared]) -> String {
    let mut table = Table::new(["NAME", "CREATED", "WHAT", "MEMBERS"]);
    for project in projects {
        table.row([
            project.name.to_string(),
            format!("{:.0}", project.create_time),
            project.display_name.clone(),
            project.members.join(", "),
        ]);
    }
    table.text()
}
