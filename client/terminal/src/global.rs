//! Options that every command shares: the server and the form of the output.

use std::path::PathBuf;

use bendtwin_client::{Client, token};
use clap::Args;

/// Address of a server on this machine with default options.
pub const DEFAULT_SERVER: &str = "http://127.0.0.1:7070";

/// Options of every command.
#[derive(Clone, Debug, Args)]
pub struct Global {
    /// Address of the server
    #[arg(long, global = true, env = "BENDTWIN_SERVER", value_name = "URL", default_value = DEFAULT_SERVER)]
    pub server: String,
    /// File with a key, or with the token of the server, `client-token` in its data folder; other
    /// users must not be able to read it [default: BENDTWIN_TOKEN, or the sign-in of `bendtwin login`,
    /// or the token of a server of this user on this machine]
    #[arg(long, global = true, env = "BENDTWIN_TOKEN_FILE", value_name = "FILE")]
    pub token_file: Option<PathBuf>,
    /// File with the certificate of the authority of the server, for https:// [default: the
    /// authorities of this system]
    #[arg(long, global = true, env = "BENDTWIN_CA", value_name = "FILE")]
    pub ca: Option<PathBuf>,
    /// Print results as JSON, for scripts
    #[arg(long, global = true)]
    pub json: bool,
}

impl Global {
    /// The key or the token for the server, if there is one.
    pub fn token(&self) -> anyhow::Result<Option<String>> {
        Ok(match &self.token_file {
            Some(path) => Some(token::read(path)?),
            None => token::find(&self.server)?,
        })
    }

    /// Connects to the server.
    pub async fn connect(&self) -> anyhow::Result<Client> {
        let token = self.token()?;
        Ok(Client::connect_with(&self.server, token.as_deref(), self.ca.as_deref()).await?)
    }
}
