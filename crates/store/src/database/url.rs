//! The URL of a database, whose password stays in it: messages and logs show it without.

use std::{fmt, str::FromStr as _};

use serde::{Deserialize, Serialize};
use sqlx::postgres::PgConnectOptions;

use crate::{Error, Result};

/// URL of a PostgreSQL database, `postgres://user:password@host:port/database`.
#[derive(Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct DatabaseUrl(String);

impl DatabaseUrl {
    /// Reads a URL.
    ///
    /// # Errors
    /// [`Error::InvalidDatabaseUrl`], which does not repeat it.
    pub fn parse(url: &str) -> Result<Self> {
        let url = Self(url.to_owned());
        url.options().map(|_| url)
    }

    /// The options of its connections. What it leaves out is taken from PostgreSQL's environment
    /// variables and password file.
    ///
    /// # Errors
    /// [`Error::InvalidDatabaseUrl`]: it was not read by [`DatabaseUrl::parse`].
    pub(crate) fn options(&self) -> Result<PgConnectOptions> {
        let known = ["postgres://", "postgresql://"];
        if !known.iter().any(|scheme| self.0.starts_with(scheme)) {
            return Err(Error::InvalidDatabaseUrl);
        }
        // The message of sqlx may repeat parts of it.
        PgConnectOptions::from_str(&self.0).map_err(|_| Error::InvalidDatabaseUrl)
    }

    /// The URL with its password, for a process that connects to the same database.
    pub fn reveal(&self) -> &str {
        &self.0
    }
}

/// User, host and database alone.
impl fmt::Display for DatabaseUrl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Ok(options) = self.options() else { return f.write_str("postgres://?") };
        let place = match options.get_socket() {
            Some(socket) => socket.display().to_string(),
            None => format!("{}:{}", options.get_host(), options.get_port()),
        };
        let database = options.get_database().unwrap_or_default();
        write!(f, "postgres://{}@{place}/{database}", options.get_username())
    }
}

impl fmt::Debug for DatabaseUrl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "DatabaseUrl({self})")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_password_is_shown_nowhere() {
        let url = DatabaseUrl::parse("postgres://ann:se%23cret@db.example:5433/twins").unwrap();
        assert_eq!(url.to_string(), "postgres://ann@db.example:5433/twins");
        assert_eq!(format!("{url:?}"), "DatabaseUrl(postgres://ann@db.example:5433/twins)");
        let query = DatabaseUrl::parse("postgres://db.example/twins?user=ann&password=secret");
        assert_eq!(query.unwrap().to_string(), "postgres://ann@db.example:5432/twins");
        for wrong in ["mysql://a:secret@h/d", "secret", "postgres://a:secret@h:port/d", ""] {
            let refused = DatabaseUrl::parse(wrong).unwrap_err();
            assert!(!format!("{refused} {refused:?}").contains("secret"), "{refused:?}");
        }
    }
}
