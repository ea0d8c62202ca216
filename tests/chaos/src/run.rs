//! The state that all parts of a run share.

use std::{
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU64, AtomicUsize, Ordering},
    },
    time::{Duration, Instant},
};

use bendtwin_harness::{Api, http::Http};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

use crate::{
    clock::Clock, disk::Disk, ledger::Ledger, reference::References, supervised::Excuses,
    system::System, tally::Tally,
};

/// Longest load, as a multiple of the time with faults.
const MOST: u32 = 3;

/// Events without which the load does not end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wanted {
    /// The time with faults.
    pub(crate) length: Duration,
    /// Fits that are ordered.
    pub(crate) fits: usize,
    /// Number of faults; 0 for as many as the time allows.
    pub(crate) faults: usize,
}

/// A run.
pub(crate) struct Run {
    pub(crate) seed: u64,
    /// Duration of the faults.
    pub(crate) length: Duration,
    /// Fits that have to be ordered before the load ends.
    wanted_fits: usize,
    /// Faults that have to happen before it ends.
    faults_to_come: AtomicUsize,
    pub(crate) started: Instant,
    pub(crate) system: System,
    pub(crate) excuses: Excuses,
    pub(crate) references: References,
    pub(crate) ledger: Ledger,
    pub(crate) tally: Arc<Tally>,
    /// The clocks of the machines.
    pub(crate) clocks: Vec<Clock>,
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
        Wanted { length, fits, faults }: Wanted,
        (system, excuses): (System, Excuses),
        references: References,
        ledger: Ledger,
        tally: Arc<Tally>,
        (clocks, disk): (Vec<Clock>, Option<Disk>),
    ) -> Self {
        Self {
            seed,
            length,
            wanted_fits: fits,
            faults_to_come: faults.into(),
            started: Instant::now(),
            system,
            excuses,
            references,
            ledger,
            tally,
            clocks,
            disk,
            twin: Mutex::default(),
            disturbed: Mutex::new(Instant::now()),
            next: AtomicU64::new(0),
        }
    }

    /// True until the load ends.
    pub(crate) fn is_under_load(&self) -> bool {
        let elapsed = self.started.elapsed();
        let lacks_fits = self.ledger.things().fits.len() < self.wanted_fits;
        let lacks = lacks_fits || self.faults_to_come() > 0;
        elapsed < self.length || (lacks && elapsed < MOST * self.length)
    }

    /// Number of faults that were asked for and have not happened.
    pub(crate) fn faults_to_come(&self) -> usize {
        self.faults_to_come.load(Ordering::Relaxed)
    }

    /// Notes that a fault has happened.
    pub(crate) fn fault_happened(&self) {
        let one_less = |left: usize| left.checked_sub(1);
        let _ = self.faults_to_come.fetch_update(Ordering::Relaxed, Ordering::Relaxed, one_less);
    }

    /// Number of fits that a client has under way.
    pub(crate) fn fits_under_way(&self) -> usize {
        if self.system.fleet().is_some() { 6 } else { 3 }
    }

    pub(crate) fn api(&self) -> Api {
        self.system.api()
    }

    pub(crate) fn http(&self) -> Http {
        self.system.http()
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
