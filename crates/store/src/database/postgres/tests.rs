//! Behaviour of PostgreSQL that SQLite does not have: rows that change behind a transaction, plans,
//! connections that break, notifications and its own clock.

use std::{
    sync::{Arc, atomic::Ordering},
    time::Duration,
};

use bendtwin_core::{Category, Problem as _, ids::WorkerId};
use jiff::Timestamp;

use crate::{
    Clock, Error, Kind, LeaseTerms, NewFit, Options, State, Store, SystemClock, TwinFacts,
    WorkerEnd,
    database::testing::{On, TestDatabase, on_both},
    sql::{Query, query, query_scalar},
    store::{
        clock::micros,
        tests::{Bench, LEASE, lease_of, new_fit},
    },
};

on_both! {
    a_worker_that_lost_its_lease_never_ends_the_attempt_of_another,
    claimants_never_get_the_same_job,
    abandoned_writes_block_no_other,
}

/// Runs the race between a completion and the loss of its lease until it goes wrong, or for
/// `rounds`. Returns true if it went wrong: the stale worker's completion was accepted although the
/// job belongs to another.
async fn race(bench: &Bench, rounds: usize) -> bool {
    let capture = bench.capture("a").await;
    let jobs = bench.store.jobs();
    for round in 0..rounds {
        let fit = jobs.create_fit(new_fit(&capture)).await.unwrap();
        let worker = WorkerId::generate();
        let first = jobs.claim(Kind::Fit, worker, LEASE).await.unwrap().unwrap();
        assert_eq!(first.id, fit.id);
        let facts = TwinFacts { quality: "{}".into(), ..TwinFacts::default() };
        let twin = bench.stage("twin").await;
        let take_over = async {
            // Either may come first.
            tokio::time::sleep(Duration::from_micros(100 * (round as u64 % 30))).await;
            jobs.forfeit(worker, WorkerEnd::ByServer).await.unwrap();
            jobs.claim(Kind::Fit, WorkerId::generate(), LEASE).await.unwrap()
        };
        let (completed, second) =
            tokio::join!(jobs.complete_fit(lease_of(&first), &facts, twin), take_over);
        match (&completed, &second) {
            (Ok(_), Some(_)) => return true,
            (Ok(_), None) => {}
            (Err(Error::StaleLease { .. }), Some(second)) => {
                let found = jobs.get(fit.id).await.unwrap();
                assert_eq!((found.state, found.worker), (State::Running, second.worker));
                jobs.end_attempt(lease_of(second), crate::AttemptEnd::Cancelled).await.unwrap();
            }
            other => panic!("{other:?}"),
        }
    }
    false
}

async fn a_worker_that_lost_its_lease_never_ends_the_attempt_of_another(on: On) {
    assert!(!race(&Bench::new(on).await, 60).await);
}

/// The race does go wrong where transactions do not exclude each other: what a completion has read
/// is not true any more when it writes.
#[tokio::test]
async fn without_the_lock_a_stale_completion_is_accepted() {
    let Some(on) = On::postgres_or_skip() else { return };
    let bench = Bench::new(on).await;
    bench.store.inner.database.server().without_lock.store(true, Ordering::SeqCst);
    assert!(race(&bench, 3000).await, "then the lock is not what prevents it");
}

async fn claimants_never_get_the_same_job(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    for _ in 0..40 {
        bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
    }
    let claimants = (0..8).map(|_| async {
        let mut mine = Vec::new();
        while let Some(job) = bench.claim(Kind::Fit).await {
            mine.push(job.id);
        }
        mine
    });
    let mut all = futures::future::join_all(claimants).await.concat();
    assert_eq!(all.len(), 40);
    all.sort();
    all.dedup();
    assert_eq!(all.len(), 40);
}

async fn abandoned_writes_block_no_other(on: On) {
    let bench = Bench::new(on).await;
    for steps in 0..60 {
        let mut write = Box::pin(bench.store.probe_write());
        for _ in 0..steps {
            if futures::poll!(&mut write).is_ready() {
                break;
            }
            tokio::time::sleep(Duration::from_micros(100)).await;
        }
        drop(write);
        let done = tokio::time::timeout(Duration::from_secs(5), bench.store.probe_write()).await;
        done.expect("the lock is still held").unwrap();
    }
}

/// The plan of a statement.
async fn plan(bench: &Bench, statement: Query) -> String {
    let steps: Vec<(String,)> =
        statement.explained("explain").fetch_all(bench.store.inner.database.read()).await.unwrap();
    steps.into_iter().map(|(step,)| step + "\n").collect()
}

/// Without statistics and with them, and also while most of the table has ended.
#[tokio::test]
async fn a_claim_among_twenty_thousand_reads_the_first_of_an_index() {
    let Some(on) = On::postgres_or_skip() else { return };
    let bench = Bench::new(on).await;
    let claim = || {
        let allowed = [String::new(), r#"{"backend":"cuda"}"#.to_owned()];
        crate::jobs::claim_statement(Kind::Fit, WorkerId::generate(), (1, 2), &allowed)
    };
    let waiting = || crate::jobs::waiting_statement("ada", 0, true, &[String::new()]);
    let check = async |when: &str| {
        let different = query(crate::jobs::DIFFERENT_REQUIREMENTS).bind(Kind::Fit.as_str());
        let claims = plan(&bench, different).await + &plan(&bench, claim()).await;
        let plan = claims + &plan(&bench, waiting()).await;
        assert!(
            plan.contains("jobs_by_queue") && !plan.contains("Seq Scan on jobs"),
            "{when}: {plan}"
        );
    };
    let fill = "insert into jobs (id, kind, capture, state, priority, settings, created_at, due_at)
         select cast(gen_random_uuid() as text), case when n % 4 = 0 then 'ingest' else 'fit' end,
             cast(gen_random_uuid() as text), $1,
             n % 3, '{}', n, n
         from generate_series(cast($2 as bigint), cast($3 as bigint)) as n";
    bench.tell(query(fill).bind("queued").bind(1_i64).bind(20_000_i64)).await;
    check("without statistics").await;
    bench.tell(query("analyze jobs")).await;
    check("with statistics").await;
    bench.tell(query(fill).bind("succeeded").bind(20_001_i64).bind(60_000_i64)).await;
    bench.tell(query("analyze jobs")).await;
    check("among many that have ended").await;
    let began = std::time::Instant::now();
    for _ in 0..20 {
        bench.claim(Kind::Fit).await.unwrap();
    }
    let each = began.elapsed() / 20;
    assert!(each < Duration::from_millis(100), "{each:?} for a claim");
}

#[tokio::test]
async fn pages_deep_in_a_list_begin_at_their_place() {
    let Some(on) = On::postgres_or_skip() else { return };
    let bench = Bench::new(on).await;
    let fill = "insert into captures (id, display_name, created_at, size_bytes, digest, name_key)
         select cast(gen_random_uuid() as text), 'rope ' || n, n, 1, repeat('a', 64), 'rope ' || n
         from generate_series(1, 20000) as n";
    bench.tell(query(fill)).await;
    bench.tell(query("analyze captures")).await;
    use crate::{ListQuery, Order, OrderKey, labels::Collection};
    for key in [OrderKey::CreateTime, OrderKey::Name] {
        let order = Order { key, descending: true };
        let mut list = ListQuery { order, ..ListQuery::default() };
        for _ in 0..2 {
            let plan = plan(&bench, list.select(Collection::Captures).unwrap().build()).await;
            assert!(plan.contains("Index Scan") && !plan.contains("Sort"), "{key:?}: {plan}");
            list.page.token = bench.store.captures().list(&list).await.unwrap().next_token;
        }
    }
}

/// Breaks all connections, as a restart of the server does.
async fn break_connections(database: &TestDatabase) {
    let name = database.url.options().unwrap();
    let mut connection = super::connect(&name).await.unwrap();
    let end = "select count(pg_terminate_backend(pid)) from pg_stat_activity
         where datname = current_database() and pid <> pg_backend_pid()";
    let ended: i64 = query_scalar(end).fetch_one(&mut connection).await.unwrap();
    assert!(ended > 0);
}

#[tokio::test]
async fn connections_that_broke_are_replaced() {
    let Some(on) = On::postgres_or_skip() else { return };
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    for _ in 0..3 {
        break_connections(bench.postgres.as_ref().unwrap()).await;
        bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
        bench.store.captures().get(capture.id).await.unwrap();
    }
    // One in mid-transaction says that it may be tried again.
    let mut tx = bench.store.inner.database.write().await.unwrap();
    break_connections(bench.postgres.as_ref().unwrap()).await;
    let broken = query("select 1").execute(&mut tx).await.unwrap_err();
    assert_eq!(
        (broken.category(), broken.reason()),
        (Category::Unavailable, "DATABASE_UNAVAILABLE")
    );
    drop(tx);
    bench.store.probe_write().await.unwrap();
}

/// Another server on the same database, with a folder that has the same identity.
async fn second(bench: &Bench) -> (tempfile::TempDir, Store) {
    let dir = tempfile::tempdir().unwrap();
    std::fs::create_dir(dir.path().join("blobs")).unwrap();
    let identity = "blobs/identity";
    std::fs::copy(bench.dir.path().join(identity), dir.path().join(identity)).unwrap();
    let options = Options {
        data_dir: dir.path().to_owned(),
        database: bench.url(),
        objects: None,
        clock: Arc::new(SystemClock),
        observer: None,
    };
    let store = Store::open(options).await.unwrap();
    (dir, store)
}

#[tokio::test]
async fn a_job_that_another_server_queues_wakes_a_claimant() {
    let Some(on) = On::postgres_or_skip() else { return };
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let (_dir, other) = second(&bench).await;
    for broken in [false, true] {
        if broken {
            break_connections(bench.postgres.as_ref().unwrap()).await;
        }
        let wait = Duration::from_secs(60);
        let jobs = bench.store.jobs();
        let claim = jobs.claim_within(Kind::Fit, WorkerId::generate(), LEASE, wait);
        let queue = async {
            tokio::time::sleep(Duration::from_millis(300)).await;
            let new = NewFit { display_name: "wanted".into(), ..new_fit(&capture) };
            other.jobs().create_fit(new).await.unwrap();
            std::time::Instant::now()
        };
        let (claimed, queued) = tokio::join!(claim, queue);
        assert!(claimed.unwrap().is_some());
        // By a notification, before the claimant looks again (after 10 s); if the listener is broken, by either.
        let limit = if broken { super::LISTEN_AGAIN * 11 } else { Duration::from_secs(8) };
        assert!(queued.elapsed() < limit, "{:?}", queued.elapsed());
    }
}

/// A clock that is a day ahead of the database's.
#[derive(Debug)]
struct Ahead;

impl Clock for Ahead {
    fn now(&self) -> Timestamp {
        Timestamp::now() + jiff::SignedDuration::from_hours(24)
    }

    fn monotonic(&self) -> Duration {
        SystemClock.monotonic()
    }
}

#[tokio::test]
async fn leases_are_measured_by_the_clock_of_the_database() {
    let Some(on) = On::postgres_or_skip() else { return };
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
    bench.store.close().await;
    let options = Options {
        data_dir: bench.dir.path().to_owned(),
        database: bench.url(),
        objects: None,
        clock: Arc::new(Ahead),
        observer: None,
    };
    let bench = Bench { store: Store::open(options).await.unwrap(), ..bench };
    let lease = Duration::from_millis(1500);
    let terms = LeaseTerms { lease, step: Duration::from_secs(10) };
    let job =
        bench.store.jobs().claim(Kind::Fit, WorkerId::generate(), lease).await.unwrap().unwrap();
    let until = micros(job.lease_until.unwrap());
    let left = until - micros(Timestamp::now());
    assert!((0..=1_500_000).contains(&left), "the lease ends in {left} us");
    let sweep = async || bench.store.jobs().sweep(terms, |_| Some(WorkerEnd::Lost)).await.unwrap();
    assert!(sweep().await.is_empty());
    // Renewed by another server, which this one has not heard of.
    let id = job.id.uuid().to_string();
    let renew = "update jobs set lease_until = lease_until + 3000000 where id = $1";
    bench.tell(query(renew).bind(&id)).await;
    tokio::time::sleep(lease + Duration::from_millis(200)).await;
    assert!(sweep().await.is_empty(), "another server renewed it");
    let ended = async {
        loop {
            if let Some(job) = sweep().await.pop() {
                return job;
            }
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    };
    let ended = tokio::time::timeout(Duration::from_secs(20), ended).await.unwrap();
    assert_eq!((ended.id, ended.state), (job.id, State::Queued));
    let stale = bench.store.jobs().report(lease_of(&job), None, lease).await;
    assert!(matches!(stale, Err(Error::StaleLease { .. })));
}

/// Adds a column as a server of a newer version does, while all connections have read the table;
/// returns the refusals of the calls after that.
async fn refusals_after_a_migration(bench: &Bench) -> Vec<Error> {
    for _ in 0..20 {
        let readers = (0..super::READERS).map(|_| async {
            bench.store.servers().all().await.unwrap();
        });
        futures::future::join_all(readers).await;
    }
    bench.tell(query("alter table servers add column later bigint")).await;
    let mut refused = Vec::new();
    for _ in 0..40 {
        refused.extend(bench.store.servers().all().await.err());
    }
    assert!(refused.iter().all(|error| matches!(error, Error::DatabaseBusy)), "{refused:?}");
    refused
}

/// A single call fails and may be repeated.
#[tokio::test]
async fn a_column_that_is_added_meanwhile_fails_one_call_at_most() {
    let Some(on) = On::postgres_or_skip() else { return };
    let refused = refusals_after_a_migration(&Bench::new(on).await).await;
    assert!(refused.len() <= 1, "{refused:?}");
}

/// Each connection has a cached plan that is refused.
#[tokio::test]
async fn a_column_fails_several_calls_where_connections_are_kept() {
    let Some(on) = On::postgres_or_skip() else { return };
    let bench = Bench::new(on).await;
    bench.store.inner.database.server().keeps_plans.store(true, Ordering::SeqCst);
    let refused = refusals_after_a_migration(&bench).await;
    assert!(refused.len() > 1, "then nothing is to be replaced: {refused:?}");
}

/// Two servers with one content: none removes what the other is about to refer to.
#[tokio::test]
async fn content_that_another_server_has_just_put_in_place_stays() {
    let Some(on) = On::postgres_or_skip() else { return };
    let bench = Bench::new(on).await;
    let other = Store::open(Options {
        database: bench.url(),
        clock: bench.clock.clone(),
        ..Options::new(bench.dir.path())
    });
    let other = other.await.unwrap();
    let content = bench.stage("wanted here, unused there").await;
    let digest = content.digest().to_hex();
    let published = bench.store.publish(content).await.unwrap();
    other.release(&digest).await.unwrap();
    assert!(other.blobs().place().has(&digest).await.unwrap());
    drop(published);

    // Once the row exists, it keeps the content.
    let capture = bench.capture("kept").await;
    other.release(&capture.digest.to_hex()).await.unwrap();
    bench.store.captures().content(capture.id).await.unwrap();
    other.close().await;
}
