use bendtwin_core::Problem as _;

use super::*;
use crate::{
    AttemptEnd, JobReport, Kind, Lease,
    database::testing::{On, on_both},
    store::tests::{Bench, LEASE, lease_of, new_fit},
};

on_both! {
    losses_are_kept_by_stage_and_model_until_the_fit_is_deleted,
    a_resumed_attempt_replaces_the_losses_that_it_recomputes,
    long_curves_are_thinned_out_and_keep_their_last,
    no_worker_can_fill_the_disk_with_losses,
}

fn loss(stage: Stage, variant: &str, iteration: u32) -> ModelLoss {
    let loss = Some(1.0 / f64::from(iteration));
    // Only some have a preview.
    let error_m = loss.filter(|_| iteration.is_multiple_of(2));
    ModelLoss { stage, variant: variant.to_owned(), iteration, loss, best_loss: loss, error_m }
}

fn refined(iterations: impl IntoIterator<Item = u32>) -> Vec<ModelLoss> {
    iterations.into_iter().map(|i| loss(Stage::Refine, "bending", i)).collect()
}

async fn report(bench: &Bench, lease: Lease, losses: &[ModelLoss]) -> Result<()> {
    let report = JobReport { losses, ..JobReport::default() };
    bench.store.jobs().report(lease, report, LEASE).await.map(drop)
}

/// A running fit.
async fn running(bench: &Bench) -> (FitId, Lease) {
    let capture = bench.capture("a").await;
    bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
    claimed(bench).await
}

async fn claimed(bench: &Bench) -> (FitId, Lease) {
    let job = bench.claim(Kind::Fit).await.unwrap();
    (job.id.fit().unwrap(), lease_of(&job))
}

async fn iterations(bench: &Bench, fit: FitId) -> Vec<u32> {
    bench.store.jobs().losses(fit).await.unwrap().iter().map(|l| l.iteration).collect()
}

async fn losses_are_kept_by_stage_and_model_until_the_fit_is_deleted(on: On) {
    let bench = Bench::new(on).await;
    let (fit, lease) = running(&bench).await;
    assert!(bench.store.jobs().losses(fit).await.unwrap().is_empty());
    let curves = [
        (Stage::Search, "bending 2/12"),
        (Stage::Search, "bending 10/12"),
        (Stage::Search, "axial 1/12"),
        (Stage::Refine, "bending 2/12"),
        (Stage::Refine, "axial 1/12"),
    ];
    let all: Vec<_> = curves.iter().flat_map(|(s, v)| [loss(*s, v, 1), loss(*s, v, 2)]).collect();
    let mut sent = all.clone();
    sent.reverse();
    report(&bench, lease, &sent).await.unwrap();
    // Sent twice, as after a lost reply.
    report(&bench, lease, &sent[..3]).await.unwrap();
    assert_eq!(bench.store.jobs().losses(fit).await.unwrap(), all);
    bench.store.jobs().end_attempt(lease, AttemptEnd::Cancelled).await.unwrap();
    let bench = bench.reopen().await;
    assert_eq!(bench.store.jobs().losses(fit).await.unwrap(), all);
    bench.store.jobs().delete(fit).await.unwrap();
    let gone = bench.store.jobs().losses(fit).await.unwrap_err();
    assert_eq!(gone.reason(), "NOT_FOUND");
    let rows: i64 = crate::sql::query_scalar("select count(*) from losses")
        .fetch_one(bench.store.inner.database.read())
        .await
        .unwrap();
    assert_eq!(rows, 0);
}

/// Losses computed after the checkpoint from which a worker's successor resumes are not part of the
/// path to the twin.
async fn a_resumed_attempt_replaces_the_losses_that_it_recomputes(on: On) {
    let bench = Bench::new(on).await;
    let (fit, first) = running(&bench).await;
    report(&bench, first, &refined(1..=9)).await.unwrap();
    bench.store.jobs().end_attempt(first, AttemptEnd::Released).await.unwrap();
    let (_, second) = claimed(&bench).await;
    assert!(matches!(report(&bench, first, &refined([10])).await, Err(Error::StaleLease { .. })));
    assert_eq!(iterations(&bench, fit).await, [1, 2, 3, 4, 5, 6, 7, 8, 9]);
    report(&bench, second, &refined([5, 6])).await.unwrap();
    assert_eq!(iterations(&bench, fit).await, [1, 2, 3, 4, 5, 6]);
    bench.store.jobs().end_attempt(second, AttemptEnd::Released).await.unwrap();
    // From the beginning: nothing of the later stage stays.
    let (_, third) = claimed(&bench).await;
    let search = [loss(Stage::Search, "bending", 1)];
    report(&bench, third, &search).await.unwrap();
    assert_eq!(bench.store.jobs().losses(fit).await.unwrap(), search);
}

async fn long_curves_are_thinned_out_and_keep_their_last(on: On) {
    let bench = Bench::new(on).await;
    let (fit, lease) = running(&bench).await;
    let most = MOST as usize;
    for first in (1..=20_000).step_by(1000) {
        report(&bench, lease, &refined(first..first + 1000)).await.unwrap();
        let kept = iterations(&bench, fit).await;
        assert!(kept.len() <= most, "{}", kept.len());
        assert_eq!(kept.last(), Some(&(first + 999)));
        let (_, multiples) = kept.split_last().unwrap();
        let stride = multiples[0];
        let expected: Vec<u32> = (1..first + 999).filter(|i| i % stride == 0).collect();
        assert_eq!(multiples, expected, "of {}", first + 999);
    }
    assert!(iterations(&bench, fit).await.len() > most / 4);
}

async fn no_worker_can_fill_the_disk_with_losses(on: On) {
    let bench = Bench::new(on).await;
    let (fit, lease) = running(&bench).await;
    for batch in 0..9 {
        let nonsense: Vec<_> =
            (0..1000).map(|i| loss(Stage::Refine, &format!("{batch} {i}"), 1)).collect();
        report(&bench, lease, &nonsense).await.unwrap();
        assert!(bench.store.jobs().losses(fit).await.unwrap().len() <= MOST as usize);
    }
}
