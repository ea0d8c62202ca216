//! Certificates of the server: the one that clients are shown, and the one among its workers. Both
//! are read again when their files change.

use std::{sync::Arc, time::Duration};

use bendtwin_tls::{
    Accepted, Certificate, Connector, FileError, Mutual, Public, Reloaded, ServerConfig, tell,
    tell_lists,
};
use tokio_util::sync::CancellationToken;

use crate::{metrics::Metrics, options::Options};

/// Longest time for connecting to a worker, TLS included.
const DIAL_TIMEOUT: Duration = Duration::from_secs(2);

/// Certificates in force. Clones share them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Certificates {
    public: Option<Reloaded<Public>>,
    workers: Option<Reloaded<Mutual>>,
}

/// Settings of the TLS of a listener, asked for at each connection.
#[derive(Clone, Debug)]
pub(crate) enum Handshakes {
    Public(Reloaded<Public>),
    Workers(Reloaded<Mutual>),
}

impl Handshakes {
    pub(crate) fn settings(&self) -> Arc<ServerConfig> {
        match self {
            Self::Public(settings) => settings.get().server.clone(),
            Self::Workers(settings) => settings.get().server.clone(),
        }
    }

    /// Waits until the peer of an open connection is refused, which says why.
    pub(crate) fn refused(&self, accepted: &Accepted) -> impl Future<Output = String> + use<> {
        let among_workers = match self {
            Self::Public(_) => None,
            Self::Workers(settings) => Some(settings.clone().refused(accepted.shown())),
        };
        async {
            match among_workers {
                Some(refused) => refused.await.to_string(),
                None => std::future::pending().await,
            }
        }
    }
}

impl Certificates {
    /// Reads the files that the options name.
    pub(crate) fn load(options: &Options) -> Result<Self, FileError> {
        let public = options.tls.as_ref().map(|tls| {
            let paths = tls.paths();
            Reloaded::new(paths.all(), move || {
                let loaded = Public::load(&paths)?;
                tell("public", loaded.certificate.as_ref());
                Ok(loaded)
            })
        });
        let workers = options.worker_tls.as_ref().map(|tls| {
            let paths = tls.paths();
            Reloaded::new(paths.all(), move || {
                let loaded = Mutual::load(&paths)?;
                tell("workers_tls", loaded.certificate.as_ref());
                tell_lists("workers_tls", &loaded.lists);
                Ok(loaded)
            })
        });
        Ok(Self { public: public.transpose()?, workers: workers.transpose()? })
    }

    /// Looks for changes of the files until `stop`.
    pub(crate) fn watch(&self, stop: &CancellationToken) {
        if let Some(public) = self.public.clone() {
            tokio::spawn(public.watch(stop.clone()));
        }
        if let Some(workers) = self.workers.clone() {
            tokio::spawn(workers.watch(stop.clone()));
        }
    }

    pub(crate) fn public(&self) -> Option<Handshakes> {
        self.public.clone().map(Handshakes::Public)
    }

    pub(crate) fn workers(&self) -> Option<Handshakes> {
        self.workers.clone().map(Handshakes::Workers)
    }

    /// The connector to workers, with the server's certificate if it has one among them.
    pub(crate) fn dialer(&self) -> Connector {
        let dialer = Connector::new(DIAL_TIMEOUT);
        match self.workers.clone() {
            Some(workers) => dialer.with_peer(workers),
            None => dialer,
        }
    }

    /// Sets the gauges of their ends.
    pub(crate) fn measure(&self, metrics: &Metrics) {
        let set = |listener, certificate: Option<&Certificate>| {
            if let Some(certificate) = certificate {
                metrics.certificate_end(listener, certificate.not_after);
            }
        };
        if let Some(public) = &self.public {
            set("public", public.get().certificate.as_ref());
        }
        if let Some(workers) = &self.workers {
            set("workers_tls", workers.get().certificate.as_ref());
        }
    }
}
