use bendtwin_core::Problem as _;

use super::*;
use crate::{
    AttemptEnd, JobReport, Kind, Lease, TwinFacts,
    database::testing::{On, on_both},
    store::tests::{Bench, LEASE, lease_of, new_fit},
};

on_both! {
    the_newest_preview_is_kept_until_the_fit_has_a_twin,
    the_preview_of_a_fit_without_a_twin_goes_with_it,
}

async fn report(bench: &Bench, lease: Lease, preview: &str) -> Result<()> {
    let report = JobReport { preview: Some(preview), ..JobReport::default() };
    bench.store.jobs().report(lease, report, LEASE).await.map(drop)
}

/// A running fit.
async fn running(bench: &Bench) -> (FitId, Lease) {
    let capture = bench.capture("a").await;
    bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
    let job = bench.claim(Kind::Fit).await.unwrap();
    (job.id.fit().unwrap(), lease_of(&job))
}

async fn shown(bench: &Bench, fit: FitId) -> Result<String> {
    bench.store.jobs().preview(fit).await.map(|preview| preview.content)
}

async fn rows(bench: &Bench) -> i64 {
    crate::sql::query_scalar("select count(*) from previews")
        .fetch_one(bench.store.inner.database.read())
        .await
        .unwrap()
}

async fn the_newest_preview_is_kept_until_the_fit_has_a_twin(on: On) {
    let bench = Bench::new(on).await;
    let (fit, lease) = running(&bench).await;
    assert_eq!(shown(&bench, fit).await.unwrap_err().reason(), "PREVIEW_MISSING");
    report(&bench, lease, "first").await.unwrap();
    report(&bench, lease, "second").await.unwrap();
    assert_eq!(shown(&bench, fit).await.unwrap(), "second");
    // A report without news leaves it.
    bench.store.jobs().report(lease, None, LEASE).await.unwrap();
    bench.store.jobs().end_attempt(lease, AttemptEnd::Released).await.unwrap();
    let bench = bench.reopen().await;
    assert_eq!(shown(&bench, fit).await.unwrap(), "second");
    assert!(matches!(report(&bench, lease, "late").await, Err(Error::StaleLease { .. })));
    let job = bench.claim(Kind::Fit).await.unwrap();
    let twin = bench.stage("a twin").await;
    let facts = TwinFacts { quality: "{}".to_owned(), ..TwinFacts::default() };
    bench.store.jobs().complete_fit(lease_of(&job), &facts, twin).await.unwrap();
    assert_eq!(shown(&bench, fit).await.unwrap_err().reason(), "PREVIEW_MISSING");
    assert_eq!(rows(&bench).await, 0);
}

async fn the_preview_of_a_fit_without_a_twin_goes_with_it(on: On) {
    let bench = Bench::new(on).await;
    let (fit, lease) = running(&bench).await;
    report(&bench, lease, "all there is").await.unwrap();
    bench.store.jobs().end_attempt(lease, AttemptEnd::Cancelled).await.unwrap();
    assert_eq!(shown(&bench, fit).await.unwrap(), "all there is");
    bench.store.jobs().delete(fit).await.unwrap();
    assert_eq!(shown(&bench, fit).await.unwrap_err().reason(), "NOT_FOUND");
    assert_eq!(rows(&bench).await, 0);
}
