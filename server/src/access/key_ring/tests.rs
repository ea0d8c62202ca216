use std::sync::atomic::{AtomicUsize, Ordering};

use bendtwin_core::Problem as _;
use bendtwin_store::{Digest, Options, Quotas};
use futures::future::join_all;
use tokio::time::sleep;

use super::*;

/// State of the store that keys are read from.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Answer {
    /// Answers after this time.
    After(Duration),
    Refuses,
    /// Does not answer.
    Hangs,
}

const SOON: Answer = Answer::After(Duration::from_millis(5));

/// A ring over a store that does what a test says.
struct Bench {
    ring: KeyRing,
    answer: Arc<Mutex<Answer>>,
    stored: Arc<Mutex<Vec<Key>>>,
    readings: Arc<AtomicUsize>,
    _folder: tempfile::TempDir,
}

impl Bench {
    async fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(Options::new(folder.path().join("data"))).await.unwrap();
        let answer = Arc::new(Mutex::new(SOON));
        let stored = Arc::new(Mutex::new(vec![key(), key()]));
        let readings = Arc::new(AtomicUsize::new(0));
        let (answers, keys, count) = (answer.clone(), stored.clone(), readings.clone());
        let source = move || {
            count.fetch_add(1, Ordering::SeqCst);
            let (answer, keys) = (*answers.lock().unwrap(), keys.lock().unwrap().clone());
            async move {
                match answer {
                    Answer::After(time) => {
                        sleep(time).await;
                        Ok((keys, Memberships::default()))
                    }
                    Answer::Refuses => Err(Error::DatabaseUnavailable),
                    Answer::Hangs => std::future::pending().await,
                }
            }
            .boxed()
        };
        let ring = KeyRing::with_source(Arc::new(source), store, Quotas::default());
        Self { ring, answer, stored, readings, _folder: folder }
    }

    fn set(&self, answer: Answer) {
        *self.answer.lock().unwrap() = answer;
    }

    /// Makes what was read, and the last failure, older by this time.
    fn pass(&self, time: Duration) {
        let mut state = self.ring.lock();
        if let Some((_, began)) = &mut state.keys {
            *began -= time;
        }
        if let Some(failed) = &mut state.failed {
            *failed -= time;
        }
    }

    fn known(&self) -> KeyId {
        self.stored.lock().unwrap()[0].id
    }

    fn readings(&self) -> usize {
        self.readings.load(Ordering::SeqCst)
    }

    /// Whether twelve concurrent calls with a key find it, and the time that all of them take.
    async fn twelve(&self, id: KeyId) -> (Vec<Result<bool>>, Duration) {
        let started = Instant::now();
        let calls = (0..12).map(|_| self.ring.find(id));
        let found = join_all(calls).await.into_iter();
        (found.map(|found| found.map(|key| key.is_some())).collect(), started.elapsed())
    }
}

fn key() -> Key {
    Key {
        id: KeyId::generate(),
        display_name: "robot".to_owned(),
        owner: "robot".to_owned(),
        hash: Digest::from_bytes([7; 32]),
        scopes: vec!["twins:read".to_owned()],
        quotas: Quotas::default(),
        created: Timestamp::UNIX_EPOCH,
        expires: None,
        revoked: None,
        used: None,
        signed_in_as: None,
        share: None,
    }
}

fn all_found(found: &[Result<bool>]) -> bool {
    found.iter().all(|found| matches!(found, Ok(true)))
}

fn all_unavailable(found: &[Result<bool>]) -> bool {
    let is = |found: &Result<bool>| {
        found.as_ref().is_err_and(|error| error.reason() == "DATABASE_UNAVAILABLE")
    };
    found.iter().all(is)
}

#[tokio::test]
async fn callers_share_a_reading() {
    let bench = Bench::new().await;
    bench.set(Answer::After(Duration::from_millis(500)));
    let (found, took) = bench.twelve(bench.known()).await;
    assert!(all_found(&found) && took < PATIENCE, "{found:?} after {took:?}");
    assert_eq!(bench.readings(), 1);
    bench.pass(FRESH_IF_UNKNOWN);
    let (strangers, _) = bench.twelve(KeyId::generate()).await;
    assert!(strangers.iter().all(|found| matches!(found, Ok(false))), "{strangers:?}");
    assert_eq!(bench.readings(), 2, "one for all strangers");
}

/// The longest time of twelve calls during an outage; one after the other they would take a minute.
const SOON_ENOUGH: Duration = Duration::from_secs(6);

async fn check_outage(away: Answer) {
    let bench = Bench::new().await;
    let known = bench.known();
    assert!(all_found(&bench.twelve(known).await.0));
    bench.set(away);
    bench.pass(FRESH);
    for round in 0..3 {
        let (found, took) = bench.twelve(known).await;
        assert!(all_found(&found) && took < SOON_ENOUGH, "{round}: {found:?} after {took:?}");
        let (found, took) = bench.twelve(KeyId::generate()).await;
        assert!(all_unavailable(&found) && took < SOON_ENOUGH, "{round}: {found:?}, {took:?}");
        bench.pass(AGAIN);
    }
    // One for all callers, at most one in a second, and one that the last ones of a round may begin.
    let readings = bench.readings();
    assert!((2..=8).contains(&readings), "{readings} readings");
    bench.pass(GOOD_WHILE_AWAY);
    let (found, took) = bench.twelve(known).await;
    assert!(all_unavailable(&found) && took < SOON_ENOUGH, "{found:?} after {took:?}");

    bench.set(SOON);
    let back = async {
        while !matches!(bench.ring.find(known).await, Ok(Some(_))) {
            bench.pass(AGAIN);
        }
    };
    timeout(2 * SOON_ENOUGH, back).await.unwrap();
    let stranger = bench.ring.find(KeyId::generate()).await;
    assert!(matches!(stranger, Ok(None)), "{stranger:?}");
}

#[tokio::test]
async fn known_keys_are_good_and_others_refused_soon_while_the_store_refuses() {
    check_outage(Answer::Refuses).await;
}

#[tokio::test]
async fn known_keys_are_good_and_others_refused_soon_while_the_store_hangs() {
    check_outage(Answer::Hangs).await;
}

/// No reading is needed to know what was changed here, and an earlier one does not take it back.
#[tokio::test]
async fn changes_made_here_count_immediately() {
    let bench = Bench::new().await;
    assert!(all_found(&bench.twelve(bench.known()).await.0));
    bench.set(Answer::After(Duration::from_millis(200)));
    bench.pass(FRESH);
    let mut revoked = bench.stored.lock().unwrap()[0].clone();
    let reading = {
        let mut ended = {
            let mut state = bench.ring.lock();
            bench.ring.renew(&mut state).unwrap()
        };
        async move { ended.changed().await.unwrap() }
    };
    timeout(SOON_ENOUGH, async {
        while bench.readings() < 2 {
            tokio::task::yield_now().await;
        }
    })
    .await
    .expect("a reading is under way, with the keys of before");
    revoked.revoked = Some(Timestamp::UNIX_EPOCH);
    let made = key();
    bench.ring.learn(&revoked);
    bench.ring.learn(&made);
    reading.await;
    bench.set(Answer::Hangs);
    for key in [&revoked, &made] {
        let found = bench.ring.find(key.id).await.unwrap().unwrap().key;
        assert_eq!((found.id, found.revoked), (key.id, key.revoked));
    }
}

/// What a reading under way finds of projects may be from before a change here.
#[tokio::test]
async fn a_reading_from_before_a_change_of_projects_does_not_count() {
    let bench = Bench::new().await;
    assert!(all_found(&bench.twelve(bench.known()).await.0));
    bench.set(Answer::After(Duration::from_millis(100)));
    bench.pass(FRESH);
    let before = bench.readings();
    let found = {
        let _ended = bench.ring.renew(&mut bench.ring.lock()).unwrap();
        bench.ring.forget();
        bench.ring.find(bench.known()).await.unwrap()
    };
    assert!(found.is_some());
    assert_eq!(bench.readings(), before + 2);
}
