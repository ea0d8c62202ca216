use std::{
    convert::Infallible,
    sync::{
        Barrier,
        atomic::{AtomicUsize, Ordering},
    },
};

use super::*;

#[test]
fn a_value_is_made_once_however_many_ask() {
    let (memo, made, together) = (Memo::default(), AtomicUsize::new(0), Barrier::new(8));
    let ask = || {
        together.wait();
        memo.get_or_make("key", || Ok::<_, Infallible>(made.fetch_add(1, Ordering::Relaxed)))
    };
    std::thread::scope(|threads| {
        let asking: Vec<_> = (0..8).map(|_| threads.spawn(ask)).collect();
        asking.into_iter().for_each(|t| assert_eq!(t.join().unwrap(), Ok(0)));
    });
    assert_eq!(memo.values(), [0]);
}

#[test]
fn different_keys_do_not_wait_for_each_other() {
    // Each is made only while the other is.
    let (memo, both) = (Memo::default(), Barrier::new(2));
    let make = |key: u32| {
        memo.get_or_make(key, || {
            both.wait();
            Ok::<_, Infallible>(key)
        })
    };
    std::thread::scope(|threads| {
        let one = threads.spawn(|| make(1));
        assert_eq!(make(2), Ok(2));
        assert_eq!(one.join().unwrap(), Ok(1));
    });
}

#[test]
fn a_failure_is_not_kept() {
    let memo = Memo::default();
    assert_eq!(memo.get_or_make(1, || Err::<u32, _>("no")), Err("no"));
    assert!(memo.values().is_empty());
    assert_eq!(memo.get_or_make(1, || Ok::<_, &str>(7)), Ok(7));
}
