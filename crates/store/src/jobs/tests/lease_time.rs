//! Leases end by the time that passes in a process that runs, and by nothing else.

use std::time::Duration;

use super::claim;
use crate::{
    database::testing::{On, on_both},
    store::tests::{Bench, LEASE, lease_of, new_fit},
};

on_both! {
    a_clock_that_is_set_neither_ends_a_lease_nor_prolongs_it,
    a_process_that_stood_still_ends_no_lease,
    after_a_restart_a_lease_lasts_as_long_as_a_new_one,
}

const DAY_MICROS: i64 = 86_400_000_000;

async fn a_clock_that_is_set_neither_ends_a_lease_nor_prolongs_it(on: On) {
    for set in [-DAY_MICROS, DAY_MICROS] {
        let bench = Bench::new(on).await;
        let capture = bench.capture("a").await;
        bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
        claim(&bench).await.unwrap();
        assert!(bench.pass(LEASE / 2).await.is_empty());
        bench.clock.set(set);
        assert!(bench.pass(LEASE / 2).await.is_empty());
        assert_eq!(bench.pass(Duration::from_secs(1)).await.len(), 1);
    }
}

async fn a_process_that_stood_still_ends_no_lease(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("a").await;
    bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
    let lease = lease_of(&claim(&bench).await.unwrap());
    assert!(bench.pass(LEASE / 2).await.is_empty());
    bench.clock.advance(10 * LEASE);
    assert!(bench.sweep().await.is_empty());
    // There is time to report, and a worker that does not is gone.
    assert!(bench.pass(LEASE / 3).await.is_empty());
    bench.store.jobs().report(lease, None, LEASE).await.unwrap();
    assert!(bench.pass(LEASE).await.is_empty());
    assert_eq!(bench.pass(Duration::from_secs(1)).await.len(), 1);
}

async fn after_a_restart_a_lease_lasts_as_long_as_a_new_one(on: On) {
    for set in [-DAY_MICROS, 0, DAY_MICROS] {
        let bench = Bench::new(on).await;
        let capture = bench.capture("a").await;
        bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
        claim(&bench).await.unwrap();
        bench.clock.set(set);
        let bench = bench.reopen().await;
        assert!(bench.pass(LEASE).await.is_empty());
        assert_eq!(bench.pass(Duration::from_secs(1)).await.len(), 1);
    }
}
