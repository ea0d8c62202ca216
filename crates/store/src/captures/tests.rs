use bendtwin_core::{Category, Problem, ids::CaptureId};

use crate::{
    CaptureChange, Error, LabelChange, ListQuery, NewCapture, PageRequest,
    database::testing::{On, on_both},
    store::tests::{Bench, new_capture, new_fit},
};

on_both! {
    a_request_id_makes_creation_idempotent,
    stays_while_fits_need_it,
    pages_newest_first_without_gaps,
    who_recorded_it_is_kept_changed_and_listed_by,
    an_empty_page_has_no_overviews,
}

async fn create(bench: &Bench, content: &'static str, key: &str) -> crate::Result<CaptureId> {
    let content = bench.stage(content).await;
    let new = NewCapture { request_id: Some(key.to_owned()), ..new_capture("rope", content) };
    bench.store.captures().create(new).await.map(|c| c.id)
}

async fn a_request_id_makes_creation_idempotent(on: On) {
    let bench = Bench::new(on).await;
    let first = create(&bench, "a", "key").await.unwrap();
    assert_eq!(create(&bench, "a", "key").await.unwrap(), first);
    let other = create(&bench, "b", "key").await.unwrap_err();
    assert_eq!((other.category(), other.reason()), (Category::AlreadyExists, "REQUEST_ID_TAKEN"));
    assert_eq!(bench.blob_count().await, 1);
    assert_ne!(create(&bench, "a", "other key").await.unwrap(), first);
}

async fn stays_while_fits_need_it(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    let fit = bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
    let refused = bench.store.captures().delete(capture.id).await;
    assert!(matches!(refused, Err(Error::CaptureInUse { fits: 1, .. })));
    bench.store.jobs().cancel(fit.id).await.unwrap();
    bench.store.captures().delete(capture.id).await.unwrap();
    let gone = bench.store.captures().delete(capture.id).await;
    assert!(matches!(gone, Err(Error::NotFound { .. })));
    let orphan = bench.store.jobs().create_fit(new_fit(&capture)).await;
    assert!(matches!(orphan, Err(Error::NotFound { .. })));
}

async fn an_empty_page_has_no_overviews(on: On) {
    let bench = Bench::new(on).await;
    let overviews = bench.store.captures().overviews(&ListQuery::default()).await.unwrap();
    assert!(overviews.items.is_empty());
}

async fn who_recorded_it_is_kept_changed_and_listed_by(on: On) {
    let bench = Bench::new(on).await;
    let captures = bench.store.captures();
    let mut new = new_capture("rope", bench.stage("a").await);
    new.facts.recorded_by = "Ada".to_owned();
    let capture = captures.create(new).await.unwrap();
    let other = bench.capture("b").await;
    assert_eq!((capture.recorded_by.as_str(), other.recorded_by.as_str()), ("Ada", ""));
    let by = async |name: &str| {
        let query = ListQuery { recorded_by: name.to_owned(), ..ListQuery::default() };
        let items = captures.list(&query).await.unwrap().items;
        items.into_iter().map(|capture| capture.id).collect::<Vec<_>>()
    };
    assert_eq!(by("Ada").await, [capture.id]);
    assert_eq!(by("ada").await, []);
    let change = CaptureChange { recorded_by: Some("Grace".into()), ..CaptureChange::default() };
    let changed = captures.update(other.id, &change).await.unwrap();
    assert_eq!((changed.recorded_by.as_str(), &changed.labels), ("Grace", &other.labels));
    let renamed = LabelChange { display_name: Some("b".into()), ..LabelChange::default() };
    let renamed = captures.update(other.id, &renamed.into()).await.unwrap();
    assert_eq!((renamed.recorded_by.as_str(), &*renamed.labels.display_name), ("Grace", "b"));
    let mut query = ListQuery::from(PageRequest { size: 1, token: String::new() });
    query.page.token = captures.list(&query).await.unwrap().next_token;
    query.recorded_by = "Grace".to_owned();
    let refused = captures.list(&query).await;
    assert!(matches!(refused, Err(Error::InvalidPageToken)), "a token belongs to its filters");
}

async fn pages_newest_first_without_gaps(on: On) {
    let bench = Bench::new(on).await;
    let mut ids = Vec::new();
    for _ in 0..7 {
        ids.insert(0, bench.capture("a").await.id);
    }
    let mut seen = Vec::new();
    let mut query = ListQuery::from(PageRequest { size: 3, token: String::new() });
    loop {
        let got = bench.store.captures().list(&query).await.unwrap();
        seen.extend(got.items.iter().map(|c| c.id));
        if got.next_token.is_empty() {
            break;
        }
        query.page.token = got.next_token;
    }
    assert_eq!(seen, ids);
    for token in ["x", "-", &query.page.token[1..], "00000000000000000000000000000000-00000000"] {
        let page = PageRequest { size: 3, token: token.to_owned() };
        let refused = bench.store.captures().list(&page.into()).await;
        assert!(matches!(refused, Err(Error::InvalidPageToken)), "{token}");
    }
    // A token of one listing is refused by another.
    let refused = bench.store.twins().list(&query).await;
    assert!(matches!(refused, Err(Error::InvalidPageToken)));
}
