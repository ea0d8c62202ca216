use super::*;

#[test]
fn as_many_fit_as_there_is_time_for() {
    assert_eq!(fitting(10.0, 100, 1, 2.0), 6);
    assert_eq!(fitting(10.0, 4, 1, 2.0), 4, "no more than asked for");
    assert_eq!(fitting(-3.0, 100, 2, 2.0), 2, "what is done is done");
    assert_eq!(fitting(10.0, 100, 2, 0.0), 100, "no time at all");
    assert_eq!(fitting(f64::INFINITY, u32::MAX, 2, 1.0), u32::MAX);
}

#[test]
fn time_spent_before_counts() {
    let mut limit = TimeLimit::new(1000.0);
    let fresh = limit.passes(10_000, 2, 1.0);
    limit.resume(500.0);
    let resumed = limit.passes(10_000, 2, 1.0);
    assert!((490..=510).contains(&(fresh - resumed)), "{fresh} and {resumed}");
    assert!(!limit.is_over(1.0) && limit.is_over(450.0));
}
