//! TLS from files of certificates and keys (PEM): they are read and checked ([`files`]), read again
//! when they change ([`Reloaded`]), and become settings of listeners ([`Public`]), of clients
//! ([`client_config`]) and of peers that show each other certificates of one private authority
//! ([`Mutual`]), which may have revoked some of them ([`RevocationList`]). [`authority`] is such an
//! authority. [`Connector`] opens the connections of clients, and [`TlsError`] says what to do about
//! one that failed.

mod accept;
pub mod authority;
mod certificate;
mod config;
mod connect;
mod error;
pub mod files;
mod peer;
mod reload;
mod revocation;
mod stream;

pub use accept::{Accepted, is_client_hello};
pub use certificate::{Certificate, Validity, tell};
pub use config::{Mutual, MutualPaths, PairPaths, Public, client_config, unverified_client_config};
pub use connect::Connector;
pub use error::TlsError;
pub use files::FileError;
pub use peer::Peer;
pub use reload::Reloaded;
pub use revocation::{RevocationList, tell_lists};
pub use rustls::{ClientConfig, ServerConfig};
pub use stream::Stream;

#[cfg(test)]
mod tests;
