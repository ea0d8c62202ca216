use std::time::Duration;

use super::*;

const MIB: u64 = 1 << 20;

#[test]
fn shares_come_back_when_dropped() {
    let budget = Budget::new(64 * MIB);
    assert_eq!((budget.total(), budget.most(), budget.used()), (64 * MIB, 56 * MIB, 0));
    let share = budget.try_take(50 * MIB).unwrap();
    assert_eq!((share.bytes(), budget.used()), (50 * MIB, 50 * MIB));
    let refused = budget.try_take(10 * MIB).unwrap_err();
    assert_eq!(refused, Exhausted::InUse { asked: 10 * MIB, free: 14 * MIB, most: 56 * MIB });
    drop(share);
    assert_eq!(budget.used(), 0);
    budget.try_take(10 * MIB).unwrap();
}

#[test]
fn what_never_fits_is_said_to_be_too_large() {
    let budget = Budget::new(64 * MIB);
    let refused = budget.try_take(57 * MIB).unwrap_err();
    assert_eq!(refused, Exhausted::TooLarge { asked: 57 * MIB, most: 56 * MIB });
    assert!(matches!(budget.try_take(u64::MAX), Err(Exhausted::TooLarge { .. })));
}

#[test]
fn sizes_are_rounded_up() {
    let budget = Budget::new(64 * MIB);
    let share = budget.try_take(1).unwrap();
    assert_eq!(share.bytes(), PAGE);
    assert_eq!(budget.try_take(0).unwrap().bytes(), 0);
}

#[test]
fn a_share_shrinks() {
    let budget = Budget::new(64 * MIB);
    let mut share = budget.try_take(40 * MIB).unwrap();
    share.shrink(10 * MIB);
    assert_eq!((share.bytes(), budget.used()), (10 * MIB, 10 * MIB));
    share.shrink(30 * MIB);
    assert_eq!(share.bytes(), 10 * MIB);
}

#[tokio::test]
async fn a_large_share_that_waits_does_not_bar_small_ones() {
    let budget = Budget::new(64 * MIB);
    let held = budget.take(56 * MIB).await.unwrap();
    let other = budget.clone();
    let waiting = tokio::spawn(async move { other.take(20 * MIB).await });
    tokio::task::yield_now().await;
    let small = tokio::time::timeout(Duration::from_secs(5), budget.take(MIB)).await;
    small.unwrap().unwrap();
    assert!(!waiting.is_finished());
    drop(held);
    waiting.await.unwrap().unwrap();
}
