use bendtwin_core::quality::Level;

use super::*;
use crate::{
    Kind, ListQuery, NewFit, NewTwin, TwinFacts,
    database::testing::{On, on_both},
    sql::{query, query_scalar},
    store::tests::{Bench, lease_of, new_capture, new_fit},
};

on_both! {
    what_a_change_does_not_name_stays,
    tags_are_bounded_and_go_with_their_resource,
    a_creation_is_repeatable_after_a_change_of_name,
    a_renamed_fit_is_announced_and_names_its_twin,
    rows_from_before_are_filled_in_when_the_store_opens,
}

fn tagged(tags: &[&str]) -> LabelChange {
    let add_tags = tags.iter().map(|&t| t.to_owned()).collect();
    LabelChange { add_tags, ..LabelChange::default() }
}

fn named(name: &str) -> LabelChange {
    LabelChange { display_name: Some(name.to_owned()), ..LabelChange::default() }
}

async fn what_a_change_does_not_name_stays(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    assert_eq!(capture.labels, Labels { display_name: "a rope".into(), ..Labels::default() });
    let captures = bench.store.captures();
    let note = LabelChange { note: Some("left hand\nslow".into()), ..tagged(&["wet", "blue"]) };
    let first = captures.update(capture.id, &note.into()).await.unwrap().labels;
    assert_eq!((first.display_name.as_str(), first.note.as_str()), ("a rope", "left hand\nslow"));
    assert_eq!(first.tags, ["blue", "wet"]);
    // Two clients that change different tags do not undo each other.
    let less = LabelChange { remove_tags: vec!["wet".into()], ..tagged(&["blue", "long"]) };
    let second = captures.update(capture.id, &less.into()).await.unwrap().labels;
    assert_eq!(second, Labels { tags: vec!["blue".into(), "long".into()], ..first });
    let whole = LabelChange { tags: Some(vec!["only".into()]), ..named("b") };
    let third = captures.update(capture.id, &whole.clone().into()).await.unwrap();
    assert_eq!(
        (third.labels.display_name.as_str(), &third.labels.tags[..]),
        ("b", &["only".to_owned()][..])
    );
    assert_eq!(captures.get(capture.id).await.unwrap(), third);
    let gone = captures.update(bendtwin_core::ids::CaptureId::generate(), &whole.into()).await;
    assert!(matches!(gone, Err(Error::NotFound { .. })));
}

async fn tags_are_bounded_and_go_with_their_resource(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let captures = bench.store.captures();
    let many: Vec<String> = (0..MAX_TAGS).map(|i| format!("t{i:02}")).collect();
    let all = LabelChange { tags: Some(many.clone()), ..LabelChange::default() };
    captures.update(capture.id, &all.into()).await.unwrap();
    let refused = captures.update(capture.id, &tagged(&["one-more"]).into()).await;
    assert!(matches!(refused, Err(Error::TooManyTags { limit: MAX_TAGS, .. })));
    assert_eq!(captures.get(capture.id).await.unwrap().labels.tags, many);
    captures.delete(capture.id).await.unwrap();
    let left: i64 = query_scalar("select count(*) from tags")
        .fetch_one(bench.store.inner.database.read())
        .await
        .unwrap();
    assert_eq!(left, 0);
}

/// A client that repeats its creation knows nothing of what people called the result since.
async fn a_creation_is_repeatable_after_a_change_of_name(on: On) {
    let bench = Bench::new(on).await;
    let store = &bench.store;
    let again = async || crate::NewCapture {
        request_id: Some("capture".into()),
        ..new_capture("a rope", bench.stage("a").await)
    };
    let capture = store.captures().create(again().await).await.unwrap();
    store.captures().update(capture.id, &named("renamed").into()).await.unwrap();
    assert_eq!(store.captures().create(again().await).await.unwrap().id, capture.id);

    for name in ["", "first try"] {
        let display_name = name.to_owned();
        let new =
            NewFit { request_id: Some(format!("fit {name}")), display_name, ..new_fit(&capture) };
        let fit = store.jobs().create_fit(new.clone()).await.unwrap();
        let called = if name.is_empty() { "renamed" } else { name };
        assert_eq!(fit.labels.display_name, called);
        store.jobs().update_fit(fit.id.fit().unwrap(), &named("other")).await.unwrap();
        assert_eq!(store.jobs().create_fit(new.clone()).await.unwrap().id, fit.id);
        let other = store.jobs().create_fit(NewFit { display_name: "x".into(), ..new }).await;
        assert!(matches!(other, Err(Error::RequestIdTaken { .. })));
    }

    let twin = async || NewTwin {
        display_name: "a twin".into(),
        request_id: Some("twin".into()),
        facts: TwinFacts::default(),
        content: bench.stage("twin").await,
        creator: crate::Creator::default(),
    };
    let first = store.twins().create(twin().await).await.unwrap();
    store.twins().update(first.id, &named("renamed")).await.unwrap();
    assert_eq!(store.twins().create(twin().await).await.unwrap().id, first.id);
}

async fn a_renamed_fit_is_announced_and_names_its_twin(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let jobs = bench.store.jobs();
    let fit = jobs.create_fit(new_fit(&capture)).await.unwrap();
    let mut changes = jobs.changes();
    let id = fit.id.fit().unwrap();
    let renamed = jobs.update_fit(id, &named("stiffer")).await.unwrap();
    assert_eq!((renamed.revision, changes.try_recv().unwrap()), (fit.revision + 1, fit.id));
    // The same again changes nothing.
    assert_eq!(jobs.update_fit(id, &named("stiffer")).await.unwrap(), renamed);
    let lease = lease_of(&bench.claim(Kind::Fit).await.unwrap());
    let facts = TwinFacts { quality: QUALITY.to_owned(), ..TwinFacts::default() };
    let twin = jobs.complete_fit(lease, &facts, bench.stage("twin").await).await.unwrap();
    let twin = bench.store.twins().get(twin).await.unwrap();
    assert_eq!((twin.labels.display_name.as_str(), twin.error_m), ("stiffer", Some(0.005)));
    let ended = jobs.get(id).await.unwrap();
    assert_eq!((ended.error_m, ended.measure), (Some(0.005), Some(Measure::Track)));
}

const QUALITY: &str = r#"{"assessment": {"level": "fair", "why": "", "next": ""}, "scores": [{"predictor": "bending", "train": {},
    "future": {"track_m": 0.005, "chamfer_l1_m": 0.002}}]}"#;

/// Rows as the migration leaves them are searched, sorted and compared like new ones.
async fn rows_from_before_are_filled_in_when_the_store_opens(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let new = NewFit { request_id: Some("fit".into()), ..new_fit(&capture) };
    let fit = bench.store.jobs().create_fit(new.clone()).await.unwrap();
    let lease = lease_of(&bench.claim(Kind::Fit).await.unwrap());
    let facts = TwinFacts { quality: QUALITY.to_owned(), ..TwinFacts::default() };
    let twin = bench.stage("twin").await;
    let twin = bench.store.jobs().complete_fit(lease, &facts, twin).await.unwrap();
    let before = (
        bench.store.captures().get(capture.id).await.unwrap(),
        bench.store.jobs().get(fit.id).await.unwrap(),
        bench.store.twins().get(twin).await.unwrap(),
    );
    for statement in [
        "update captures set search_text = null, name_key = ''",
        "update twins set search_text = null, name_key = '', error_m = 1e300, level = null",
        "update jobs set search_text = null, name_key = '', error_m = 1e300, display_name = '',
             first_name = null",
    ] {
        bench.tell(query(statement)).await;
    }
    let bench = bench.reopen().await;
    let after = (
        bench.store.captures().get(capture.id).await.unwrap(),
        bench.store.jobs().get(fit.id).await.unwrap(),
        bench.store.twins().get(twin).await.unwrap(),
    );
    assert_eq!(after, before);
    assert_eq!(bench.store.jobs().create_fit(new).await.unwrap().id, fit.id);
    let query = ListQuery { search: "ROPE".into(), ..ListQuery::default() };
    assert_eq!(bench.store.captures().list(&query).await.unwrap().items.len(), 1);
    assert_eq!(bench.store.jobs().fits(&query).await.unwrap().items.len(), 1);
    assert_eq!(bench.store.twins().list(&query).await.unwrap().items.len(), 1);
    let fair = ListQuery { level: Some(Level::Fair), ..ListQuery::default() };
    assert_eq!(bench.store.twins().list(&fair).await.unwrap().items.len(), 1);
}
