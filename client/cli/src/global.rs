//! Options that every command shares: the server and the form of the output.

use bendtwin_client::Client;
use clap::Args;

/// Address of a server on this machine with default options.
pub(crate) const DEFAULT_SERVER: &str = "http://127.0.0.1:7070";

/// Options of every command.
#[derive(Clone, Debug, Args)]
pub(crate) struct Global {
    /// Address of the server
    #[arg(long, global = true, env = "BENDTWIN_SERVER", value_name = "URL", default_value = DEFAULT_SERVER)]
    pub(crate) server: String,
    /// Print results as JSON, for scripts
    #[arg(long, global = true)]
    pub(crate) json: bool,
}

impl Global {
    /// Connects to the server.
    pub(crate) async fn connect(&self) -> anyhow::Result<Client> {
        Ok(Client::connect(&self.server).await?)
    }
}
