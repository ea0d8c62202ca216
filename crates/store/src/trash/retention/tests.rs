use bendtwin_core::Problem as _;

use super::*;
use crate::{
    Capture, CaptureChange, Creator, Kind, LabelChange, NewCapture, NewFit, TwinFacts,
    database::testing::{On, on_databases},
    sql::query,
    store::tests::{Bench, lease_of, new_capture, new_fit},
};

on_databases! {
    rules_are_kept_until_they_are_deleted,
    a_rule_matches_what_fulfils_all_of_its_conditions,
    what_is_needed_is_kept_with_the_reason,
    what_only_a_deleted_twin_needed_goes_in_the_same_sweep,
    a_sweep_deletes_a_bounded_number_the_oldest_first,
    what_a_rule_deletes_can_be_restored,
}

const DAY: Duration = Duration::from_secs(86_400);

fn rule(collection: Collection, days: u32) -> NewRule {
    NewRule {
        display_name: format!("old {}", collection.name()),
        collection,
        min_age: days * DAY,
        owner: String::new(),
        tag: String::new(),
        verdict: String::new(),
    }
}

fn tagged(tag: &str) -> LabelChange {
    LabelChange { add_tags: vec![tag.to_owned()], ..LabelChange::default() }
}

async fn tag(bench: &Bench, capture: &Capture, tag: &str) {
    let change = CaptureChange::from(tagged(tag));
    bench.store.captures().update(capture.id, &change).await.unwrap();
}

/// What the rules would delete, and what they keep with the reason.
async fn preview(bench: &Bench, rules: &[NewRule]) -> (Vec<Resource>, Vec<(Resource, Kept)>) {
    let found = bench.store.retention().preview(rules, 100).await.unwrap();
    assert!(!found.truncated);
    let deleted = found.matches.iter().filter(|found| found.kept.is_none());
    let kept = found.matches.iter().filter_map(|found| Some((found.resource, found.kept?)));
    (deleted.map(|found| found.resource).collect(), kept.collect())
}

/// What the rules deleted, which is what the preview said.
async fn apply(bench: &Bench, rules: &[NewRule]) -> Vec<Resource> {
    let expected = preview(bench, rules).await.0;
    let moved = bench.store.retention().apply(rules, 7 * DAY, 100).await.unwrap();
    let moved: Vec<Resource> = moved.into_iter().map(|found| found.resource).collect();
    assert_eq!(moved, expected);
    assert_eq!(preview(bench, rules).await.0, []);
    moved
}

async fn twin_of(bench: &Bench, capture: &Capture) -> (FitId, TwinId) {
    bench.store.jobs().create_fit(new_fit(capture)).await.unwrap();
    let lease = lease_of(&bench.claim(Kind::Fit).await.unwrap());
    let content = bench.stage("twin").await;
    let twin =
        bench.store.jobs().complete_fit(lease, &TwinFacts::default(), content).await.unwrap();
    (lease.job.fit().unwrap(), twin)
}

async fn rules_are_kept_until_they_are_deleted(on: On) {
    let bench = Bench::new(on).await;
    let retention = bench.store.retention();
    let conditions = NewRule {
        owner: "ada".to_owned(),
        tag: "trial".to_owned(),
        verdict: "unusable".to_owned(),
        ..rule(Collection::Captures, 30)
    };
    let made = retention.create(conditions.clone()).await.unwrap();
    assert_eq!(made.conditions, conditions);
    assert_eq!(retention.get(made.id).await.unwrap(), made);
    assert_eq!(retention.list().await.unwrap(), std::slice::from_ref(&made));
    for _ in 1..super::rules::MOST {
        retention.create(rule(Collection::Fits, 1)).await.unwrap();
    }
    let refused = retention.create(conditions).await.unwrap_err();
    assert_eq!(refused.reason(), "TOO_MANY_RETENTION_RULES");
    retention.delete(made.id).await.unwrap();
    for gone in [retention.get(made.id).await.map(drop), retention.delete(made.id).await] {
        assert!(matches!(gone, Err(Error::NotFound { .. })));
    }
    assert_eq!(retention.list().await.unwrap().len(), 99);
}

async fn a_rule_matches_what_fulfils_all_of_its_conditions(on: On) {
    let bench = Bench::new(on).await;
    let creator = Creator { owner: "ada".to_owned(), ..Creator::default() };
    let of_ada = NewCapture { creator, ..new_capture("rope", bench.stage("a").await) };
    let of_ada = bench.store.captures().create(of_ada).await.unwrap();
    let ended = query("update jobs set state = 'succeeded'");
    bench.tell(ended).await;
    let trial = bench.capture("b").await;
    tag(&bench, &trial, "trial").await;
    let unusable = bench.capture("c").await;
    let report = query(
        "insert into reports (capture, created_at, verdict, json_digest, html_digest)
         values ($1, 0, 'unusable', 'x', 'x')",
    );
    bench.tell(report.bind(unusable.id.uuid().to_string())).await;
    bench.clock.advance(2 * DAY);
    let young = bench.capture("d").await;

    let any = rule(Collection::Captures, 2);
    let with = async |rule: NewRule| preview(&bench, &[rule]).await.0;
    let [a, b, c, d] = [&of_ada, &trial, &unusable, &young].map(|capture| capture.id.into());
    assert_eq!(with(any.clone()).await, [a, b, c]);
    assert_eq!(with(NewRule { min_age: Duration::ZERO, ..any.clone() }).await, [a, b, c, d]);
    assert_eq!(with(NewRule { min_age: Duration::MAX, ..any.clone() }).await, []);
    assert_eq!(with(NewRule { owner: "ada".to_owned(), ..any.clone() }).await, [a]);
    assert_eq!(with(NewRule { tag: "trial".to_owned(), ..any.clone() }).await, [b]);
    assert_eq!(with(NewRule { verdict: "unusable".to_owned(), ..any.clone() }).await, [c]);
    let both = NewRule { owner: "ada".to_owned(), tag: "trial".to_owned(), ..any.clone() };
    assert_eq!(with(both).await, []);
    for collection in [Collection::Fits, Collection::Twins] {
        assert_eq!(with(rule(collection, 0)).await, [], "ingests are no fits");
    }
    let first =
        NewRule { display_name: "first".to_owned(), owner: "ada".to_owned(), ..any.clone() };
    let found = bench.store.retention().preview(&[first, any], 100).await.unwrap().matches;
    let rules: Vec<&str> = found.iter().map(|found| &*found.rule).collect();
    assert_eq!(rules, ["first", "old captures", "old captures"], "each stands once");
}

async fn what_is_needed_is_kept_with_the_reason(on: On) {
    let bench = Bench::new(on).await;
    let tagged_one = bench.capture("a").await;
    tag(&bench, &tagged_one, KEEP_TAG).await;
    let with_twin = bench.capture("c").await;
    let (fit, twin) = twin_of(&bench, &with_twin).await;
    let with_fit = bench.capture("d").await;
    let settings = format!(r#"{{"start_from":"{twin}"}}"#);
    let new = NewFit { settings, ..new_fit(&with_fit) };
    let queued = bench.store.jobs().create_fit(new).await.unwrap().id.fit().unwrap();
    let unread = bench.fresh_capture("e").await;
    let ingest = bench.store.jobs().ingest_of(unread.id).await.unwrap().id;
    let crate::JobId::Ingest(ingest) = ingest else { unreachable!() };

    let rules = Collection::ALL.map(|collection| rule(collection, 0));
    let (deleted, kept) = preview(&bench, &rules).await;
    assert_eq!(deleted, []);
    let expected: [(Resource, Kept); 7] = [
        (twin.into(), Kept::Fit(queued)),
        (fit.into(), Kept::Twin(twin)),
        (queued.into(), Kept::UnderWay),
        (tagged_one.id.into(), Kept::Tagged),
        (with_twin.id.into(), Kept::Twin(twin)),
        (with_fit.id.into(), Kept::Fit(queued)),
        (unread.id.into(), Kept::Ingest(ingest)),
    ];
    assert_eq!(kept, expected);
    assert!(Kept::Twin(twin).to_string().contains(&twin.to_string()));
    assert_eq!(apply(&bench, &rules).await, []);
    bench.claim(Kind::Fit).await.unwrap();
    bench.claim(Kind::Ingest).await.unwrap();
    assert_eq!(preview(&bench, &rules).await.1, expected, "running is like queued");
}

async fn what_only_a_deleted_twin_needed_goes_in_the_same_sweep(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let (fit, twin) = twin_of(&bench, &capture).await;
    let captures = rule(Collection::Captures, 0);
    assert_eq!(apply(&bench, std::slice::from_ref(&captures)).await, []);
    let rules = [captures, rule(Collection::Fits, 0), rule(Collection::Twins, 0)];
    assert_eq!(apply(&bench, &rules).await, [twin.into(), fit.into(), capture.id.into()]);
}

async fn a_sweep_deletes_a_bounded_number_the_oldest_first(on: On) {
    let bench = Bench::new(on).await;
    let mut ids = Vec::new();
    for n in 0..5 {
        let capture = bench.capture("a").await;
        if n == 0 {
            tag(&bench, &capture, KEEP_TAG).await;
        } else {
            ids.push(Resource::from(capture.id));
        }
    }
    let rules = [rule(Collection::Captures, 0)];
    let retention = bench.store.retention();
    let found = retention.preview(&rules, 3).await.unwrap();
    assert!(found.truncated);
    assert_eq!(found.matches.len(), 4, "three that go, and the one that is kept");
    let moved = retention.apply(&rules, DAY, 3).await.unwrap();
    assert_eq!(moved.iter().map(|found| found.resource).collect::<Vec<_>>(), ids[..3]);
    let moved = retention.apply(&rules, DAY, 3).await.unwrap();
    assert_eq!(moved.iter().map(|found| found.resource).collect::<Vec<_>>(), ids[3..]);
}

async fn what_a_rule_deletes_can_be_restored(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let rules = [rule(Collection::Captures, 0)];
    apply(&bench, &rules).await;
    let trashed = bench.store.trash().get(capture.id).await.unwrap();
    assert_eq!(trashed.deleted_by, "retention: old captures");
    assert_eq!(trashed.purged.duration_since(trashed.deleted).as_hours(), 7 * 24);
    bench.store.trash().restore(capture.id, &Creator::default()).await.unwrap();
    tag(&bench, &capture, KEEP_TAG).await;
    assert_eq!(apply(&bench, &rules).await, []);
    bench.store.captures().content(capture.id).await.unwrap();
}
