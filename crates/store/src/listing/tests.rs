use super::*;
use crate::{
    Capture, Job, Kind, LabelChange, TwinFacts,
    database::testing::{On, on_both},
    sql::{query, row::row},
    store::tests::{Bench, lease_of, new_fit},
};

on_both! {
    lists_have_the_order_that_is_asked_for,
    pages_stay_right_while_rows_come_and_go,
    a_renamed_row_hides_no_other,
    lists_are_filtered,
    a_token_belongs_to_its_filters_and_order,
    the_first_page_counts_what_matches,
}

const ORDERS: [(OrderKey, bool); 6] = [
    (OrderKey::CreateTime, true),
    (OrderKey::CreateTime, false),
    (OrderKey::Name, true),
    (OrderKey::Name, false),
    (OrderKey::Error, true),
    (OrderKey::Error, false),
];

/// Fits of one capture with these names and errors [mm], in the order of their creation.
async fn fits(bench: &Bench, given: &[(&str, Option<f64>)]) -> (Capture, Vec<Job>) {
    let capture = bench.capture("a").await;
    let mut made = Vec::new();
    for (name, error_mm) in given {
        made.push(fit(bench, &capture, name, *error_mm).await);
    }
    (capture, made)
}

async fn fit(bench: &Bench, capture: &Capture, name: &str, error_mm: Option<f64>) -> Job {
    let jobs = bench.store.jobs();
    let new = crate::NewFit { display_name: name.to_owned(), ..new_fit(capture) };
    let fit = jobs.create_fit(new).await.unwrap();
    if let Some(error_mm) = error_mm {
        let lease = lease_of(&bench.claim(Kind::Fit).await.unwrap());
        let error_m = 1e-3 * error_mm;
        let quality = format!(
            r#"{{"scores": [{{"predictor": "bending", "train": {{}}, "future": {{"track_m": {error_m}}}}}]}}"#
        );
        let facts = TwinFacts { quality, ..TwinFacts::default() };
        jobs.complete_fit(lease, &facts, bench.stage("twin").await).await.unwrap();
    }
    jobs.get(fit.id).await.unwrap()
}

fn by(key: OrderKey, descending: bool) -> ListQuery {
    ListQuery { order: Order { key, descending }, ..ListQuery::default() }
}

/// Names of all fits of a list, page by page; `meanwhile` runs after each page.
async fn names(bench: &Bench, mut query: ListQuery, meanwhile: impl AsyncFn()) -> Vec<String> {
    query.page.size = 2;
    let mut seen = Vec::new();
    loop {
        let page = bench.store.jobs().fits(&query).await.unwrap();
        seen.extend(page.items.into_iter().map(|fit| fit.labels.display_name));
        if page.next_token.is_empty() {
            return seen;
        }
        query.page.token = page.next_token;
        meanwhile().await;
    }
}

async fn list(bench: &Bench, query: ListQuery) -> Vec<String> {
    names(bench, query, async || ()).await
}

async fn lists_have_the_order_that_is_asked_for(on: On) {
    let bench = Bench::new(on).await;
    let given = [
        ("beta", Some(3.0)),
        ("Alpha", None),
        ("alpha", Some(20.0)),
        ("Ünder", Some(0.5)),
        ("c", None),
    ];
    fits(&bench, &given.map(|(name, _)| (name, None))).await;
    let set = "update jobs set error_m = $2 where display_name = $1";
    for (name, error) in given {
        bench.tell(query(set).bind(name).bind(error.map_or(1e300, |e| e * 1e-3))).await;
    }
    for (key, descending) in ORDERS {
        let mut expected = match key {
            OrderKey::CreateTime => ["beta", "Alpha", "alpha", "Ünder", "c"],
            OrderKey::Name => ["Alpha", "alpha", "beta", "c", "Ünder"],
            OrderKey::Error => ["Ünder", "beta", "alpha", "Alpha", "c"],
        };
        if descending {
            expected.reverse();
        }
        assert_eq!(list(&bench, by(key, descending)).await, expected, "{key:?} {descending}");
    }
}

/// Every row that exists throughout comes exactly once, while others come and go between two pages.
async fn pages_stay_right_while_rows_come_and_go(on: On) {
    for (key, descending) in ORDERS {
        let bench = Bench::new(on).await;
        let given: Vec<_> =
            (0..7).map(|i| (["a", "B", "c", "D", "e", "F", "g"][i], Some(i as f64))).collect();
        let (capture, _) = fits(&bench, &given).await;
        let added = std::cell::Cell::new(0);
        let seen = names(&bench, by(key, descending), async || {
            // Not for ever: what comes is at the end in some orders.
            if added.get() >= 9 {
                return;
            }
            // Before everything and after everything in each order, and in between.
            for (name, error) in [("A", -1.0), ("zz", 99.0), ("dd", 2.5)] {
                added.set(added.get() + 1);
                fit(&bench, &capture, &format!("{name}+"), Some(error)).await;
            }
        })
        .await;
        let old: Vec<_> = seen.iter().filter(|name| !name.ends_with('+')).collect();
        let mut expected: Vec<_> = given.iter().map(|(name, _)| *name).collect();
        if descending {
            expected.reverse();
        }
        assert_eq!(old, expected.iter().collect::<Vec<_>>(), "{key:?} {descending}");
        assert_eq!(added.get(), 9);
    }
}

async fn a_renamed_row_hides_no_other(on: On) {
    let bench = Bench::new(on).await;
    let (_, fits) = fits(&bench, &[("a", None), ("b", None), ("c", None), ("d", None)]).await;
    let last = fits[1].id.fit().unwrap();
    let rename = async || {
        // The row that the token names moves to the end.
        let change = LabelChange { display_name: Some("z".into()), ..LabelChange::default() };
        bench.store.jobs().update_fit(last, &change).await.unwrap();
    };
    let seen = names(&bench, by(OrderKey::Name, false), rename).await;
    assert_eq!(seen, ["a", "b", "c", "d", "z"]);
}

async fn lists_are_filtered(on: On) {
    let bench = Bench::new(on).await;
    let (capture, fits) =
        fits(&bench, &[("50% rope", None), ("50 ropes", None), ("a\\b_c", None)]).await;
    let jobs = bench.store.jobs();
    let change = LabelChange {
        note: Some("Nässe, LINKE Hand".into()),
        add_tags: vec!["wet".into()],
        ..LabelChange::default()
    };
    jobs.update_fit(fits[1].id.fit().unwrap(), &change).await.unwrap();
    jobs.cancel(fits[2].id).await.unwrap();
    let search = |text: &str| ListQuery { search: text.to_owned(), ..ListQuery::default() };
    for (text, found) in [
        ("ROPE", &["50 ropes", "50% rope"][..]),
        ("0% r", &["50% rope"]),
        ("a\\B_", &["a\\b_c"]),
        ("a%c", &[]),
        ("_", &["a\\b_c"]),
        ("nÄSSE", &["50 ropes"]),
        ("linke", &["50 ropes"]),
        ("'", &[]),
    ] {
        assert_eq!(list(&bench, search(text)).await, found, "{text}");
    }
    for (key, descending) in ORDERS {
        let tagged = ListQuery { tag: "wet".into(), ..by(key, descending) };
        assert_eq!(list(&bench, tagged).await, ["50 ropes"]);
    }
    // Tags are whole words.
    assert!(list(&bench, ListQuery { tag: "we".into(), ..ListQuery::default() }).await.is_empty());
    let cancelled = ListQuery { state: Some(State::Cancelled), ..ListQuery::default() };
    assert_eq!(list(&bench, cancelled).await, ["a\\b_c"]);
    let all = ListQuery { capture: Some(capture.id), ..search("0") };
    assert_eq!(list(&bench, all.clone()).await.len(), 2);
    let other = bench.capture("b").await.id;
    assert!(list(&bench, ListQuery { capture: Some(other), ..all }).await.is_empty());
    assert!(bench.store.twins().list(&search("rope")).await.unwrap().items.is_empty());
    assert_eq!(bench.store.captures().list(&search("rope")).await.unwrap().items.len(), 2);
}

async fn a_token_belongs_to_its_filters_and_order(on: On) {
    let bench = Bench::new(on).await;
    fits(&bench, &[("a", None), ("b", None), ("c", None)]).await;
    let mut query = by(OrderKey::Name, false);
    query.page.size = 1;
    query.page.token = bench.store.jobs().fits(&query).await.unwrap().next_token;
    assert_eq!(bench.store.jobs().fits(&query).await.unwrap().items[0].labels.display_name, "b");
    for wrong in [
        ListQuery { order: Order { key: OrderKey::Name, descending: true }, ..query.clone() },
        ListQuery { order: Order { key: OrderKey::Error, descending: false }, ..query.clone() },
        ListQuery { search: "a".into(), ..query.clone() },
        ListQuery { tag: "a".into(), ..query.clone() },
    ] {
        let refused = bench.store.jobs().fits(&wrong).await;
        assert!(matches!(refused, Err(Error::InvalidPageToken)), "{wrong:?}");
    }
    let token = query.page.token.clone();
    for token in [format!("{token}x"), format!("{token}61"), format!("{token}ü"), "-".into()] {
        query.page.token = token;
        let refused = bench.store.jobs().fits(&query).await;
        assert!(matches!(refused, Err(Error::InvalidPageToken)));
    }
}

/// Steps by which the database answers a query.
async fn plan(bench: &Bench, list: &ListQuery, collection: Collection) -> Vec<String> {
    let select = list.select(collection).unwrap().build();
    let steps = select.explained("explain query plan");
    let steps: Vec<Step> = steps.fetch_all(bench.store.inner.database.read()).await.unwrap();
    steps.into_iter().map(|step| step.detail).collect()
}

row! {
    struct Step {
        detail: String,
    }
}

#[tokio::test]
async fn no_page_sorts_or_reads_what_comes_before_it() {
    let bench = Bench::new(On::Sqlite).await;
    for collection in [Collection::Captures, Collection::Fits, Collection::Twins] {
        for (key, descending) in ORDERS {
            if collection == Collection::Captures && key == OrderKey::Error {
                continue;
            }
            let mut query = by(key, descending);
            let steps = plan(&bench, &query, collection).await;
            let in_order = |step: &String| step.contains("INDEX") && !step.contains("TEMP B-TREE");
            assert!(steps.iter().all(in_order), "{collection:?} {key:?}: {steps:?}");
            // Later pages begin at their place.
            let listing = query.listing(collection);
            let row = ((), CaptureId::generate().uuid(), query.key("a", 0.5));
            let page = PageRequest { size: 1, token: String::new() };
            let cut = crate::Page::cut(vec![&row, &row], &page, &listing, |r| (r.1, r.2.clone()));
            query.page.token = cut.next_token;
            let steps = plan(&bench, &query, collection).await;
            let starts = |step: &String| in_order(step) && step.starts_with("SEARCH");
            assert!(steps.iter().all(starts), "{collection:?} {key:?}: {steps:?}");
        }
        let tagged = ListQuery { tag: "a".into(), ..ListQuery::default() };
        let steps = plan(&bench, &tagged, collection).await;
        assert!(steps.iter().all(|s| s.starts_with("SEARCH") && s.contains("INDEX")), "{steps:?}");
    }
    let of_capture = ListQuery { capture: Some(CaptureId::generate()), ..ListQuery::default() };
    for (query, collection) in [
        (of_capture.clone(), Collection::Fits),
        (of_capture, Collection::Twins),
        (ListQuery { state: Some(State::Failed), ..ListQuery::default() }, Collection::Fits),
    ] {
        let steps = plan(&bench, &query, collection).await;
        assert!(steps.len() == 1 && steps[0].starts_with("SEARCH"), "{steps:?}");
    }
}

async fn the_first_page_counts_what_matches(on: On) {
    let bench = Bench::new(on).await;
    fits(&bench, &[("a", Some(1.0)), ("b", None), ("ab", None)]).await;
    let mut asked = ListQuery { search: "a".into(), ..ListQuery::default() };
    asked.page.size = 1;
    let page = bench.store.jobs().fits(&asked).await.unwrap();
    assert_eq!((page.items.len(), page.total), (1, Some(2)));
    asked.page.token = page.next_token;
    assert_eq!(bench.store.jobs().fits(&asked).await.unwrap().total, None);
    let tagged = ListQuery { tag: "wet".into(), ..ListQuery::default() };
    assert_eq!(bench.store.captures().list(&tagged).await.unwrap().total, Some(0));
    assert_eq!(bench.store.captures().list(&ListQuery::default()).await.unwrap().total, Some(1));
    // The twin has no assessment.
    let fair = ListQuery { level: Some(Level::Fair), ..ListQuery::default() };
    assert_eq!(bench.store.twins().list(&fair).await.unwrap().total, Some(0));
    bench.tell(query("update twins set level = 'fair'")).await;
    let page = bench.store.twins().list(&fair).await.unwrap();
    assert_eq!((page.items.len(), page.total), (1, Some(1)));
}
