//! The choice of the next job: turns of owners, and requirements.

use semver::Version;

use super::*;
use crate::{
    Capabilities, Claimant, Creator, NewIngest, Quotas, Requirements,
    jobs::requirements::MAX_DIFFERENT, sql, store::tests::new_capture,
};

on_both! {
    owners_take_turns_at_one_worker,
    owners_share_several_workers,
    a_higher_priority_comes_before_the_turn_of_others,
    a_fit_waits_for_a_worker_that_it_asks_for,
    a_fit_of_a_newer_version_waits_for_workers_and_servers_that_know_it,
    requirements_are_part_of_a_repeated_request,
    an_ingest_waits_for_a_worker_that_it_asks_for,
    an_ingest_that_outgrew_its_time_is_brief_no_more,
    the_queue_has_a_bounded_number_of_different_requirements,
}

async fn queue(
    bench: &Bench,
    capture: &crate::Capture,
    owner: &str,
    priority: i32,
) -> crate::JobId {
    let creator = Creator { owner: owner.to_owned(), quotas: Quotas::default() };
    bench.clock.advance(Duration::from_secs(1));
    let new = NewFit { creator, priority, ..new_fit(capture) };
    bench.store.jobs().create_fit(new).await.unwrap().id
}

fn labels(words: &[&str]) -> Vec<String> {
    words.iter().map(|word| (*word).to_owned()).collect()
}

/// Owners of the next jobs, each ended before the next claim if `one_at_a_time`.
async fn served(bench: &Bench, one_at_a_time: bool) -> String {
    let mut owners = String::new();
    while let Some(fit) = claim(bench).await {
        bench.clock.advance(Duration::from_secs(1));
        owners.push_str(&fit.owner);
        if one_at_a_time {
            let end = AttemptEnd::FailedForGood(fault());
            bench.store.jobs().end_attempt(lease_of(&fit), end).await.unwrap();
        }
    }
    owners
}

async fn owners_take_turns_at_one_worker(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    for owner in ["a", "a", "a", "a", "b", "b", "c"] {
        queue(&bench, &capture, owner, 0).await;
    }
    assert_eq!(served(&bench, true).await, "abcabaa");
    // A newcomer does not wait for those who have been served.
    for owner in ["a", "a", "d"] {
        queue(&bench, &capture, owner, 0).await;
    }
    assert_eq!(served(&bench, true).await, "daa");
}

async fn owners_share_several_workers(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    for owner in ["a", "a", "a"] {
        queue(&bench, &capture, owner, 0).await;
    }
    let mut running = Vec::new();
    for _ in 0..3 {
        running.push(claim(&bench).await.unwrap());
        bench.clock.advance(Duration::from_secs(1));
    }
    for owner in ["a", "b", "b", "b", "b"] {
        queue(&bench, &capture, owner, 0).await;
    }
    // Three of the one run: the other has as many before they take turns.
    assert_eq!(served(&bench, false).await, "bbbab");
}

async fn a_higher_priority_comes_before_the_turn_of_others(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    for (owner, priority) in [("a", 0), ("b", 0), ("a", 1), ("a", 1)] {
        queue(&bench, &capture, owner, priority).await;
    }
    assert_eq!(served(&bench, true).await, "aaba");
}

async fn a_fit_waits_for_a_worker_that_it_asks_for(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let wanted = [
        Requirements { backend: "cuda".into(), ..Requirements::default() },
        Requirements { memory_bytes: 1 << 34, ..Requirements::default() },
        Requirements { labels: labels(&["lab=2", "ecc"]), ..Requirements::default() },
    ];
    let mut ids = Vec::new();
    for requirements in &wanted {
        let new = NewFit { requirements: requirements.clone(), ..new_fit(&capture) };
        let fit = bench.store.jobs().create_fit(new).await.unwrap();
        ids.push(fit.id);
    }
    let stored = bench.store.jobs().get(ids[2]).await.unwrap().requirements;
    assert_eq!(stored.labels, ["ecc", "lab=2"]);
    let last = queue(&bench, &capture, "", 0).await;
    let claim_with = async |capabilities: &Capabilities| {
        let claimant =
            Claimant { capabilities: capabilities.clone(), ..Claimant::from(WorkerId::generate()) };
        bench.store.jobs().claim(Kind::Fit, claimant, LEASE).await.unwrap().map(|job| job.id)
    };
    let plain = Capabilities {
        backend: "cpu".into(),
        memory_bytes: 1 << 30,
        labels: labels(&["ecc"]),
        ..Capabilities::default()
    };
    assert_eq!(claim_with(&plain).await, Some(last));
    assert_eq!(claim_with(&plain).await, None);
    let labelled = Capabilities { labels: labels(&["ecc", "big", "lab=2"]), ..plain.clone() };
    assert_eq!(claim_with(&labelled).await, Some(ids[2]));
    let large = Capabilities { memory_bytes: 1 << 34, ..plain.clone() };
    assert_eq!(claim_with(&large).await, Some(ids[1]));
    let cuda = Capabilities { backend: "cuda".into(), ..plain };
    assert_eq!(claim_with(&cuda).await, Some(ids[0]));
}

async fn a_fit_of_a_newer_version_waits_for_workers_and_servers_that_know_it(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let requirements =
        Requirements { version: Some(Version::new(0, 10, 0)), ..Requirements::default() };
    let fit = NewFit { requirements, ..new_fit(&capture) };
    let fit = bench.store.jobs().create_fit(fit).await.unwrap();
    let claim_with = async |version: Option<Version>| {
        let capabilities = Capabilities { version, ..Capabilities::default() };
        let claimant = Claimant { capabilities, ..Claimant::from(WorkerId::generate()) };
        bench.store.jobs().claim(Kind::Fit, claimant, LEASE).await.unwrap().map(|job| job.id)
    };
    for older in [None, Some(Version::new(0, 9, 3))] {
        assert_eq!(claim_with(older).await, None);
    }
    // A requirement that this version does not know: it is read, and left to others.
    let unknown = r#"{"backend":"","memory_bytes":0,"labels":[],"version":"0.9.0","colour":"red"}"#;
    let changed = sql::query("update jobs set requirements = $1 where kind = 'fit'").bind(unknown);
    bench.tell(changed).await;
    assert_eq!(claim_with(Some(Version::new(0, 9, 3))).await, None);
    let read = bench.store.jobs().get(fit.id).await.unwrap().requirements;
    assert_eq!(read.version, Some(Version::new(0, 9, 0)));

    let known = sql::query("update jobs set requirements = $1 where kind = 'fit'");
    bench.tell(known.bind(read.to_text().unwrap())).await;
    assert_eq!(claim_with(Some(Version::new(0, 9, 3))).await, Some(fit.id));
}

async fn an_ingest_waits_for_a_worker_that_it_asks_for(on: On) {
    let bench = Bench::new(on).await;
    let requirements = Requirements { labels: labels(&["lab=2"]), ..Requirements::default() };
    let content = bench.stage("a").await;
    let mut new = new_capture("a", content);
    new.facts.requirements = requirements.clone();
    let capture = bench.store.captures().create(new).await.unwrap();
    let claim_with = async |of_worker: &[&str]| {
        let capabilities = Capabilities { labels: labels(of_worker), ..Capabilities::default() };
        let claimant = Claimant { capabilities, ..Claimant::from(WorkerId::generate()) };
        bench.store.jobs().claim(Kind::Ingest, claimant, LEASE).await.unwrap()
    };
    assert!(claim_with(&[]).await.is_none());
    let claimed = claim_with(&["lab=2"]).await.unwrap();
    assert_eq!((claimed.capture, &claimed.requirements), (capture.id, &requirements));
    let end = AttemptEnd::FailedForGood(fault());
    bench.store.jobs().end_attempt(lease_of(&claimed), end).await.unwrap();

    let again = NewIngest {
        capture: capture.id,
        settings: "{}".to_owned(),
        request_id: Some("key".to_owned()),
        trace_parent: None,
        creator: Creator::default(),
        requirements,
    };
    bench.store.jobs().create_ingest(again.clone()).await.unwrap();
    assert!(claim_with(&[]).await.is_none());
    bench.store.jobs().create_ingest(again.clone()).await.unwrap();
    let other = NewIngest { requirements: Requirements::default(), ..again };
    let other = bench.store.jobs().create_ingest(other).await;
    assert!(matches!(other, Err(Error::RequestIdTaken { .. })));
    assert!(claim_with(&["lab=2"]).await.is_some());
}

async fn an_ingest_that_outgrew_its_time_is_brief_no_more(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let jobs = bench.store.jobs();
    let claim_as = async |brief: bool| {
        let capabilities = Capabilities { brief, ..Capabilities::default() };
        let claimant = Claimant { worker: WorkerId::generate(), capabilities };
        bench.store.jobs().claim(Kind::Ingest, claimant, LEASE).await.unwrap()
    };
    let requirements = Requirements { backend: String::new(), ..Requirements::default() };
    let again = NewIngest {
        capture: capture.id,
        settings: "{}".to_owned(),
        request_id: Some("key".to_owned()),
        trace_parent: None,
        creator: Creator::default(),
        requirements,
    };
    if let Some(first) = claim_as(true).await {
        let end = AttemptEnd::FailedForGood(fault());
        jobs.end_attempt(lease_of(&first), end).await.unwrap();
    }
    let asked = jobs.create_ingest(again.clone()).await.unwrap();
    let brief = claim_as(true).await.unwrap();
    let handed_on = jobs.end_attempt(lease_of(&brief), AttemptEnd::Outgrown).await.unwrap();
    assert_eq!((handed_on.state, handed_on.attempts), (State::Queued, 0));
    assert!(handed_on.requirements.long && handed_on.attempt_faults.is_empty());
    assert!(claim_as(true).await.is_none());
    // That is not what anybody asked for: the same request is the same ingest.
    assert_eq!(jobs.create_ingest(again.clone()).await.unwrap().id, asked.id);
    let long = claim_as(false).await.unwrap();
    assert_eq!((long.id, long.attempts), (asked.id, 1));
    jobs.end_attempt(lease_of(&long), AttemptEnd::FailedForGood(fault())).await.unwrap();
    // Read again, it may be quick.
    jobs.create_ingest(NewIngest { request_id: None, ..again }).await.unwrap();
    assert!(claim_as(true).await.is_some());
}

async fn requirements_are_part_of_a_repeated_request(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let requirements = Requirements { backend: "cpu".into(), ..Requirements::default() };
    let new = NewFit { request_id: Some("key".into()), requirements, ..new_fit(&capture) };
    let first = bench.store.jobs().create_fit(new.clone()).await.unwrap();
    assert_eq!(bench.store.jobs().create_fit(new.clone()).await.unwrap(), first);
    let other = NewFit { requirements: Requirements::default(), ..new };
    let other = bench.store.jobs().create_fit(other).await;
    assert!(matches!(other, Err(Error::RequestIdTaken { .. })));
}

async fn the_queue_has_a_bounded_number_of_different_requirements(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let create = async |bytes: u64| {
        let requirements = Requirements { memory_bytes: bytes, ..Requirements::default() };
        bench.store.jobs().create_fit(NewFit { requirements, ..new_fit(&capture) }).await
    };
    for bytes in 1..=MAX_DIFFERENT as u64 {
        create(bytes).await.unwrap();
    }
    let refused = create(1 << 40).await.unwrap_err();
    assert!(matches!(refused, Error::TooManyRequirements { .. }), "{refused}");
    create(1).await.unwrap();
    create(0).await.unwrap();
}

/// However many jobs there are and have been: none of the steps reads them all.
#[tokio::test]
async fn a_claim_reads_indexes_of_what_waits_and_of_what_runs() {
    let bench = Bench::new(On::Sqlite).await;
    let allowed = [String::new()];
    let worker = WorkerId::generate();
    let claim = crate::jobs::claim_statement(Kind::Fit, worker, (1, 2), &allowed);
    let steps: Vec<(i64, i64, i64, String)> = claim
        .explained("explain query plan")
        .fetch_all(bench.store.inner.database.read())
        .await
        .unwrap();
    let plan: String = steps.into_iter().map(|(.., step)| step + "\n").collect();
    assert!(!plan.contains("SCAN jobs") && !plan.contains("SCAN j\n"), "{plan}");
    for index in ["j USING INDEX jobs_by_queue", "r USING COVERING INDEX jobs_running_by_owner"] {
        assert!(plan.contains(index), "{plan}");
    }
}
