//! Options of TLS: certificates of the listeners, and the refusal to be open without.

use std::{net::SocketAddr, path::PathBuf};

use bendtwin_tls::{MutualPaths, PairPaths};
use serde::{Deserialize, Serialize};

use super::{ClientTokenPolicy, Options};

/// Certificate that clients are shown. Its files are read again when they change.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tls {
    /// PEM file of the certificate, and after it those that issued it.
    pub certificate: PathBuf,
    /// PEM file of its key, which other users of the machine must not be able to read.
    pub key: PathBuf,
}

/// Listener for workers on other hosts. Both sides show certificates of a private authority. The
/// files are read again when they change.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorkerTls {
    /// Address to listen on; port 0 takes a free one.
    pub listen: SocketAddr,
    /// PEM file of the server's certificate among its workers.
    pub certificate: PathBuf,
    /// PEM file of its key, which other users of the machine must not be able to read.
    pub key: PathBuf,
    /// PEM file of the authority whose certificates workers have.
    pub client_ca: PathBuf,
    /// PEM file of the list of certificates that this authority has revoked, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crl: Option<PathBuf>,
}

impl Tls {
    pub(crate) fn paths(&self) -> PairPaths {
        PairPaths { certificate: self.certificate.clone(), key: self.key.clone() }
    }
}

impl WorkerTls {
    pub(crate) fn paths(&self) -> MutualPaths {
        let pair = PairPaths { certificate: self.certificate.clone(), key: self.key.clone() };
        MutualPaths { pair, ca: self.client_ca.clone(), crl: self.crl.clone() }
    }
}

impl Options {
    /// Faults of a server that would be open to a network.
    pub(super) fn openness(&self) -> Vec<String> {
        let mut faults = Vec::new();
        let has_tls = |name| name == "listen" && self.tls.is_some();
        for (name, address) in [("listen", self.listen), ("worker_listen", self.worker_listen)] {
            if address.ip().is_loopback() || self.insecure {
                continue;
            }
            let is_published_locally = name == "listen" && self.published_locally;
            if !has_tls(name) && !self.tls_terminated_by_proxy && !is_published_locally {
                faults.push(without_tls(name, address));
            }
            if name == "listen" && self.client_token == ClientTokenPolicy::None {
                faults.push(format!(
                    "listen is {address}, which others can reach, and client_token is `none`: set \
                     it to `required`, or set insecure (--insecure) if everyone who reaches the \
                     address may do everything"
                ));
            }
        }
        if self.worker_tls.is_some() && self.worker_token.is_none() {
            faults.push(
                "worker_tls is for workers on other hosts, which have to show worker_token as \
                 well: set it (BENDTWIN_WORKER_TOKEN)"
                    .to_owned(),
            );
        }
        faults
    }
}

fn without_tls(name: &str, address: SocketAddr) -> String {
    let own = match name {
        "listen" => {
            "give a certificate and its key (--tls-certificate, --tls-key), or set \
             published_locally (--published-locally) in a container whose port is published to this \
             machine alone"
        }
        _ => "give workers on other hosts a separate listener (worker_tls)",
    };
    format!(
        "{name} is {address}, which others can reach, and there is no TLS: listen on 127.0.0.1, \
         or {own}, or put a proxy with TLS in front and set tls_terminated_by_proxy \
         (--tls-terminated-by-proxy), or set insecure (--insecure) if everyone on the network may \
         read and change what passes"
    )
}
