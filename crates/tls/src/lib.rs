//! TLS from files of certificates and keys (PEM): they are read and checked ([`files`]), read again
//! when they change ([`Reloaded`]), and become settings of listeners ([`Public`]), of clients
//! ([`client_config`]) and of peers that show each other certificates of one private authority
//! ([`Mutual`]). [`Connector`] opens the connections of clients, and [`TlsError`] says what to do
//! about one that failed.

mod accept;
mod certificate;
mod config;
mod connect;
mod error;
pub mod files;
mod reload;

pub use accept::{Accepted, is_client_hello};
pub use certificate::{Certificate, Validity, tell};
pub use config::{Mutual, MutualPaths, PairPaths, Public, client_config};
pub use connect::{Connector, Stream};
pub use error::TlsError;
pub use files::FileError;
pub use reload::Reloaded;
pub use rustls::{ClientConfig, ServerConfig};

#[cfg(test)]
mod tests;
