//! `bendtwin store`: check and repair of a data folder, backup and restore of any store, and its move to
//! PostgreSQL and S3, for its administrator.

mod report;

use std::path::PathBuf;

use bendtwin_core::{Category, Fault};
use bendtwin_server::{
    DatabaseUrl, ObjectsUrl, Options,
    maintenance::{self, Depth, Site},
};
use clap::{Args, Subcommand};

use crate::{
    failure::{self, Failed},
    global::Global,
    output,
};

#[derive(Debug, Args)]
pub(crate) struct Store {
    #[command(subcommand)]
    command: Command,
}

/// The folder that a command works on.
#[derive(Debug, Args)]
struct Folder {
    /// Data folder of the server [default: bendtwin-data]
    #[arg(long, env = "BENDTWIN_DATA_DIR", value_name = "DIR")]
    data_dir: Option<PathBuf>,
}

/// The whereabouts of a store, with the variables of its servers.
#[derive(Debug, Args)]
struct Whereabouts {
    #[command(flatten)]
    folder: Folder,
    /// PostgreSQL database with the rows, postgres://USER@HOST:PORT/DATABASE [default: SQLite in the data
    /// folder]
    #[arg(long, env = "BENDTWIN_DATABASE_URL", value_name = "URL", hide_env_values = true)]
    database: Option<String>,
    /// Place of the content, s3://BUCKET/PREFIX (keys and region from AWS_* in the environment) or
    /// file:///FOLDER [default: the data folder]
    #[arg(long, env = "BENDTWIN_OBJECTS", value_name = "URL")]
    objects: Option<String>,
    /// File with the token of clients [default: client-token in the data folder]
    #[arg(long, env = "BENDTWIN_CLIENT_TOKEN_FILE", value_name = "FILE")]
    client_token_file: Option<PathBuf>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Compare the database with its own rules and all content with its rows; a server may run
    Check {
        /// A backup or a data folder, in place of --data-dir
        path: Option<PathBuf>,
        #[command(flatten)]
        folder: Folder,
        /// Compare only sizes, without reading the content
        #[arg(long)]
        sizes: bool,
    },
    /// Repair the store and set unreferenced content aside; no server may run
    Repair {
        #[command(flatten)]
        folder: Folder,
    },
    /// Move all rows to an empty PostgreSQL database, or all content to a bucket; no server may run
    Migrate {
        #[command(flatten)]
        folder: Folder,
        /// URL of the database, postgres://USER@HOST:PORT/DATABASE
        #[arg(
            long,
            env = "BENDTWIN_DATABASE_URL",
            value_name = "URL",
            hide_env_values = true,
            required_unless_present = "to_objects"
        )]
        to: Option<String>,
        /// New place of all content, s3://BUCKET/PREFIX or file:///FOLDER; rows stay
        #[arg(long, value_name = "URL")]
        to_objects: Option<String>,
    },
    /// Copy all rows and all content to a folder, or bring an earlier backup there up to date; servers may
    /// run
    Backup {
        #[command(flatten)]
        store: Whereabouts,
        /// Folder of the backup. It has secrets: hashes of keys, and the client token
        to: PathBuf,
    },
    /// Restore a backup to a new store of any kind; an interrupted restore is run again
    Restore {
        #[command(flatten)]
        store: Whereabouts,
        /// Folder of the backup
        from: PathBuf,
    },
}

impl Folder {
    fn path(self) -> PathBuf {
        self.data_dir.unwrap_or_else(|| Options::default().data_dir)
    }
}

impl Whereabouts {
    fn site(self) -> anyhow::Result<Site> {
        let database = self.database.map(|url| DatabaseUrl::parse(&url));
        let objects = self.objects.map(|url| ObjectsUrl::parse(&url));
        Ok(Site {
            data_dir: self.folder.path(),
            database: database.transpose().map_err(failure::failed)?,
            objects: objects.transpose().map_err(failure::failed)?,
            client_token: self.client_token_file,
        })
    }
}

pub(crate) async fn run(args: Store, global: &Global) -> anyhow::Result<()> {
    match args.command {
        Command::Check { path, folder, sizes } => {
            let depth = if sizes { Depth::Sizes } else { Depth::Digests };
            let path = path.unwrap_or_else(|| folder.path());
            let report = maintenance::check(&path, depth).await.map_err(failure::failed)?;
            output::print(global, &report, || report::check(&report))?;
            require(report.is_sound(), "the store is damaged: run `bendtwin store repair`")
        }
        Command::Repair { folder } => {
            let done = maintenance::repair(&folder.path()).await.map_err(failure::failed)?;
            output::print(global, &done, || report::repair(&done))?;
            let advice = "content stays lost: upload the same archives and import the same twin \
                          files again, or restore a backup";
            require(done.lost.is_empty(), advice)
        }
        Command::Migrate { folder, to_objects: Some(to), .. } => {
            let url = ObjectsUrl::parse(&to).map_err(failure::failed)?;
            let done =
                maintenance::relocate(&folder.path(), &url).await.map_err(failure::failed)?;
            output::print(global, &done, || report::relocation(&done))?;
            let advice = "damaged content was left in the old folder: upload the same archives and \
                          import the same twin files again";
            require(done.damaged.is_empty(), advice)
        }
        Command::Migrate { folder, to, to_objects: None } => {
            let to = to.unwrap_or_default();
            let url = DatabaseUrl::parse(&to).map_err(failure::failed)?;
            let done = maintenance::migrate(&folder.path(), &url).await.map_err(failure::failed)?;
            output::print(global, &done, || report::migration(&done))
        }
        Command::Backup { store, to } => {
            let done = maintenance::backup(&store.site()?, &to).await.map_err(failure::failed)?;
            output::print(global, &done, || report::backup(&done))?;
            let advice =
                "the store lacks content, and so does its backup: run `bendtwin store check`";
            require(done.lost.is_empty(), advice)
        }
        Command::Restore { store, from } => {
            let done =
                maintenance::restore(&from, &store.site()?).await.map_err(failure::failed)?;
            output::print(global, &done, || report::restore(&done))?;
            let advice = "the backup lacks content, and so does the restored store: upload the same \
                          archives and import the same twin files again, or restore another backup";
            require(done.lost.is_empty(), advice)
        }
    }
}

/// Fails with this advice unless all is well.
fn require(is_sound: bool, advice: &str) -> anyhow::Result<()> {
    if is_sound {
        return Ok(());
    }
    let fault = Fault {
        category: Category::DataLoss,
        reason: "STORE_DAMAGED".to_owned(),
        message: advice.to_owned(),
    };
    Err(Failed(fault).into())
}
