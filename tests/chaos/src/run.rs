//! The state that all parts of a run share.

use std::{
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

use bendtwin_harness::{Api, http::Http};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

use crate::{
    clock::Clock, disk::Disk, ledger::Ledger, reference::References, server::Server, tally::Tally,
};

/// A run.
pub(crate) struct Run {
    pub(crate) seed: u64,
    /// Its time with faults.
    pub(crate) length: Duration,
    pub(crate) started: Instant,
    pub(crate) server: Arc<Server>,
    pub(crate) references: References,
    pub(crate) ledger: Ledger,
    pub(crate) tally: Arc<Tally>,
    pub(crate) clock: Option<Clock>,
    pub(crate) disk: Option<Disk>,
    /// The twin that all rollouts ask for.
    pub(crate) twin: Mutex<String>,
    /// The end of the last fault that stopped or ended a process.
    disturbed: Mutex<Instant>,
    next: AtomicU64,
}

impl Run {
    pub(crate) fn new(
        seed: u64,
        length: Duration,
        server: Arc<Server>,
        references: References,
        ledger: Ledger,
        tally: Arc<Tally>,
        (clock, disk): (Option<Clock>, Option<Disk>),
    ) -> Self {
        Self {
            seed,
            length,
            started: Instant::now(),
            server,
            references,
            ledger,
            tally,
            clock,
            disk,
            twin: Mutex::default(),
            disturbed: Mutex::new(Instant::now()),
            next: AtomicU64::new(0),
        }
    }

    /// True until the load ends.
    pub(crate) fn goes_on(&self) -> bool {
        self.started.elapsed() < self.length
    }

    pub(crate) fn api(&self) -> Api {
        self.server.api()
    }

    pub(crate) fn http(&self) -> Http {
        self.server.http()
    }

    /// A source of chance for a client of the load.
    pub(crate) fn chance(&self, client: u64) -> ChaCha8Rng {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(1000 + client);
        random
    }

    /// A name or a request id that no other call has.
    pub(crate) fn fresh(&self, prefix: &str) -> String {
        format!("{prefix}-{}", self.next.fetch_add(1, Ordering::Relaxed))
    }

    pub(crate) fn twin(&self) -> String {
        self.twin.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// A process was stopped or ended until now.
    pub(crate) fn disturb(&self) {
        *self.disturbance() = Instant::now();
    }

    pub(crate) fn last_disturbance(&self) -> Instant {
        *self.disturbance()
    }

    fn disturbance(&self) -> MutexGuard<'_, Instant> {
        self.disturbed.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
