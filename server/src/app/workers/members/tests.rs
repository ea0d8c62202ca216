use std::sync::Arc;

use bendtwin_harness::Postgres;
use bendtwin_store::{
    CaptureFacts, Creator, DatabaseUrl, JobId, Kind, LeaseTerms, ManualClock, NewCapture,
    NewWorker, State, Store,
};

use super::*;
use crate::{metrics::Metrics, options::Options, tls::Certificates};

const LEASE: Duration = Duration::from_secs(12);
const STEP: Duration = Duration::from_secs(1);
const TOKEN: &str = "a-token-of-workers";

#[test]
fn a_member_is_silent_while_its_sign_stays() {
    let (members, member) = (Members::default(), Uuid::new_v4());
    let at = Duration::from_secs;
    assert_eq!(members.silence(member, 7, at(10)), at(0), "it is new here");
    assert_eq!(members.silence(member, 7, at(14)), at(4));
    assert_eq!(members.silence(member, 8, at(15)), at(0));
    assert!(members.is_due(member, at(3), at(15)) && !members.is_due(member, at(3), at(17)));
    assert!(members.is_due(member, at(3), at(18)));
    members.keep(&HashSet::new());
    assert_eq!(members.silence(member, 8, at(30)), at(0), "it came again");
}

/// A server, and the rows of another that is not there.
struct Fleet {
    app: App,
    clock: Arc<ManualClock>,
    other: ServerId,
    _folder: tempfile::TempDir,
    _postgres: Postgres,
}

impl Fleet {
    async fn start_or_skip() -> Option<Self> {
        let postgres = Postgres::start_or_skip().await?;
        let folder = tempfile::tempdir().unwrap();
        let clock = Arc::new(ManualClock::default());
        let store = Store::open(bendtwin_store::Options {
            database: Some(DatabaseUrl::parse(&postgres.url_with_password("none")).unwrap()),
            clock: clock.clone(),
            ..bendtwin_store::Options::new(folder.path())
        });
        let (certificates, metrics) = (Certificates::default(), Metrics::new());
        let options = Options { worker_token: Some(TOKEN.to_owned()), ..Options::default() };
        let app = App::new(options, store.await.unwrap(), certificates, metrics, None);
        app.recover().await.unwrap();
        let other = ServerId::generate();
        Some(Self { app, clock, other, _folder: folder, _postgres: postgres })
    }

    /// Registers a worker, which a server has started or somebody else.
    async fn registered(&self, server: Option<ServerId>) -> Worker {
        let registration = NewWorker {
            id: WorkerId::generate(),
            endpoint: "http://127.0.0.1:1".to_owned(),
            backend: "cpu".to_owned(),
            device: "a processor".to_owned(),
            build: bendtwin_core::BUILD.to_owned(),
            lanes: 1,
            labels: Vec::new(),
            server,
        };
        self.app.store.workers().register(registration).await.unwrap()
    }

    /// Leases a job to a process of the other server.
    async fn leased(&self) -> JobId {
        let store = &self.app.store;
        let worker = self.registered(Some(self.other)).await.registration.id;
        let content = store.blobs().upload(1).await.unwrap().finish(None).await.unwrap();
        let new = NewCapture {
            facts: CaptureFacts { ingest: "{}".to_owned(), ..CaptureFacts::default() },
            request_id: None,
            content,
            creator: Creator::default(),
            trace_parent: None,
        };
        store.captures().create(new).await.unwrap();
        let claimed = store.jobs().claim(Kind::Ingest, worker, LEASE).await.unwrap();
        claimed.unwrap().id
    }

    /// Lets time pass in the steps of a server that runs, while the other one renews its row or not.
    async fn pass(&self, time: Duration, other_lives: bool) {
        for _ in 0..time.as_secs() {
            self.clock.advance(STEP);
            if other_lives {
                self.app.store.servers().seen(self.other, "a build").await.unwrap();
            }
            self.app.sweep(LeaseTerms { lease: LEASE, step: 2 * STEP }).await.unwrap();
        }
    }
}

/// The lease of its job ends first, because the server has renewed its row since it was renewed.
#[tokio::test]
async fn a_job_is_not_blamed_for_the_end_of_the_server_of_its_worker() {
    let Some(fleet) = Fleet::start_or_skip().await else { return };
    let job = fleet.leased().await;
    let state = async || {
        let job = fleet.app.store.jobs().get(job).await.unwrap();
        (job.state, job.attempts, job.attempt_faults.len())
    };
    fleet.pass(2 * LEASE, true).await;
    assert_eq!(state().await, (State::Running, 1, 0), "its server judges it");
    fleet.pass(LEASE + 2 * STEP, false).await;
    assert_eq!(state().await, (State::Queued, 0, 0), "it ended with its server");
}

/// The row of the worker was read before it left, and is taken over afterwards.
#[tokio::test]
async fn a_worker_that_has_left_does_not_come_back_by_an_old_row() {
    let Some(fleet) = Fleet::start_or_skip().await else { return };
    let row = fleet.registered(None).await;
    let id = row.registration.id;
    assert_eq!(fleet.app.dispatch.learn(row.clone()).await.unwrap(), Learned::Known);
    assert!(fleet.app.dispatch.knows(id));
    fleet.app.worker_left(id).await.unwrap();
    assert_eq!(fleet.app.dispatch.learn(row).await.unwrap(), Learned::Gone);
    assert!(!fleet.app.dispatch.knows(id));
    // Nor by a heartbeat that comes late.
    assert!(matches!(fleet.app.require_known(id).await, Err(Error::WorkerUnknown(_))));
}
