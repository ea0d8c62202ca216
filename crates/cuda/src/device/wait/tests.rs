use super::*;

/// Looks of a wait for work that ends after so long, and how late the last one comes.
fn looks(ends: Duration, look: Duration) -> (usize, Duration) {
    let (mut now, mut sleeps) = (Duration::ZERO, 0);
    while now < ends {
        match sleep_after(now, look) {
            Some(sleep) => {
                now += sleep;
                sleeps += 1;
            }
            None => now += Duration::from_micros(1),
        }
    }
    (sleeps, now - ends)
}

#[test]
fn a_wait_is_late_by_an_eighth_or_a_short_sleep() {
    for us in [1, 49, 51, 200, 999, 5_000, 80_000] {
        let ends = Duration::from_micros(us);
        let (_, late) = looks(ends, LOOK);
        assert!(late <= (ends / 8).max(SHORTEST_SLEEP), "{us}: {late:?}");
        assert!(late <= LONGEST_SLEEP, "{us}: {late:?}");
    }
}

#[test]
fn a_long_wait_looks_seldom() {
    let (sleeps, _) = looks(Duration::from_millis(100), LOOK);
    assert!(sleeps < 300, "{sleeps}");
}

#[test]
fn urgent_work_of_a_few_milliseconds_never_sleeps() {
    let (sleeps, late) = looks(Duration::from_millis(15), URGENT_LOOK);
    assert_eq!((sleeps, late), (0, Duration::ZERO));
}
