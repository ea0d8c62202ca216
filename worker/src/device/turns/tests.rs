use super::*;

/// Flows that always have work, served for a number of milliseconds a slice; returns the device
/// time of each [ms] after `total` of them.
fn busy(fit_share: f64, flows: &[(Priority, u64)], total: u64) -> Vec<u64> {
    let mut turns = Turns::new(fit_share);
    let made: Vec<_> = flows.iter().map(|(priority, _)| Flow::new(*priority)).collect();
    for (index, flow) in made.iter().enumerate() {
        turns.push(flow, index);
    }
    let mut used = vec![0; flows.len()];
    while used.iter().sum::<u64>() < total {
        let (flow, index) = turns.take().unwrap();
        let took = flows[index].1;
        used[index] += took;
        turns.served(&flow, Duration::from_millis(took));
        turns.push(&flow, index);
    }
    used
}

#[test]
fn a_fit_keeps_its_share_beside_greedy_rollouts() {
    use Priority::{Background, Interactive};
    for fit_slice in [5, 30, 100] {
        let mut flows = vec![(Interactive, 30); 8];
        flows.push((Background, fit_slice));
        let used = busy(0.25, &flows, 60_000);
        assert!((14_500..15_500).contains(&used[8]), "{used:?}");
    }
    assert_eq!(busy(0.0, &[(Interactive, 30), (Background, 30)], 3_000)[1], 0);
}

#[test]
fn requests_share_by_time_and_not_by_slices() {
    let used = busy(0.25, &[(Priority::Interactive, 10), (Priority::Interactive, 100)], 20_000);
    assert!(used.iter().all(|ms| (9_000..11_000).contains(ms)), "{used:?}");
}

#[test]
fn accounts_share_by_time_however_many_requests_each_has() {
    let mut turns = Turns::new(0.25);
    let (many, one) = (Arc::<Standing>::default(), Arc::<Standing>::default());
    let made: Vec<_> = (0..33)
        .map(|n| Flow::of(Priority::Interactive, if n < 32 { &many } else { &one }.clone()))
        .collect();
    made.iter().enumerate().for_each(|(n, flow)| turns.push(flow, n));
    let mut used = [0; 33];
    while used.iter().sum::<u64>() < 40_000 {
        let (flow, n) = turns.take().unwrap();
        used[n] += 20;
        turns.served(&flow, Duration::from_millis(20));
        turns.push(&flow, n);
    }
    assert!((19_900..20_100).contains(&used[32]), "{used:?}");
    // Within the account, too, all have the same.
    assert!(used[..32].iter().all(|ms| (560..=700).contains(ms)), "{used:?}");
}

#[test]
fn an_account_that_returns_is_not_served_for_its_absence() {
    let mut turns = Turns::new(0.25);
    let away = Arc::<Standing>::default();
    let (busy, first) =
        (Flow::new(Priority::Interactive), Flow::of(Priority::Interactive, away.clone()));
    turns.push(&first, "away");
    turns.push(&busy, "busy");
    for _ in 0..1_000 {
        let (flow, what) = turns.take().unwrap();
        turns.served(&flow, Duration::from_millis(20));
        if what == "busy" {
            turns.push(&busy, what);
        }
    }
    let again = Flow::of(Priority::Interactive, away);
    turns.push(&again, "away");
    let mut in_a_row = 0;
    while turns.take().unwrap().1 == "away" {
        turns.served(&again, Duration::from_millis(20));
        turns.push(&again, "away");
        in_a_row += 1;
    }
    assert!((1..=7).contains(&in_a_row), "{in_a_row}");
}

#[test]
fn a_new_request_is_next_but_one_in_any_line() {
    let mut turns = Turns::new(0.25);
    let large: Vec<_> = (0..8).map(|_| Flow::new(Priority::Interactive)).collect();
    large.iter().for_each(|flow| turns.push(flow, "large"));
    for _ in 0..8 {
        let (flow, what) = turns.take().unwrap();
        turns.served(&flow, Duration::from_millis(30));
        turns.push(&flow, what);
    }
    for _ in 0..100 {
        let (flow, _) = turns.take().unwrap();
        let small = Flow::new(Priority::Interactive);
        turns.push(&small, "small");
        turns.served(&flow, Duration::from_millis(30));
        turns.push(&flow, "large");
        let (flow, what) = turns.take().unwrap();
        assert_eq!(what, "small");
        turns.served(&flow, Duration::from_millis(1));
    }
}

#[test]
fn a_stream_of_small_requests_does_not_starve_a_large_one() {
    let mut turns = Turns::new(0.25);
    let large = Flow::new(Priority::Interactive);
    turns.push(&large, true);
    let mut of_large = 0;
    turns.push(&Flow::new(Priority::Interactive), false);
    for _ in 0..1_000 {
        let (flow, is_large) = turns.take().unwrap();
        turns.served(&flow, Duration::from_millis(10));
        of_large += usize::from(is_large);
        if is_large {
            turns.push(&large, true);
        } else {
            turns.push(&Flow::new(Priority::Interactive), false);
        }
    }
    assert!((400..600).contains(&of_large), "{of_large}");
}

#[test]
fn rollouts_go_first_where_they_are_few() {
    let mut turns = Turns::new(0.25);
    let fit = Flow::new(Priority::Background);
    turns.push(&fit, "fit");
    for _ in 0..50 {
        turns.push(&Flow::new(Priority::Interactive), "rollout");
        let (flow, what) = turns.take().unwrap();
        assert_eq!(what, "rollout");
        turns.served(&flow, Duration::from_millis(20));
        let (flow, what) = turns.take().unwrap();
        assert_eq!(what, "fit");
        turns.served(&flow, Duration::from_millis(30));
        turns.push(&fit, "fit");
    }
}

#[test]
fn a_slice_that_cannot_be_cut_is_repaid_over_time() {
    let mut turns = Turns::new(0.25);
    let (fit, rollout) = (Flow::new(Priority::Background), Flow::new(Priority::Interactive));
    turns.push(&fit, ());
    turns.push(&rollout, ());
    turns.served(&rollout, Duration::from_secs(3600));
    let mut slices = 0;
    while turns.take().unwrap().0.priority == Priority::Background {
        turns.served(&fit, Duration::from_millis(30));
        turns.push(&fit, ());
        slices += 1;
    }
    assert!((1..=20).contains(&slices), "{slices}");
}

#[test]
fn work_of_one_flow_keeps_its_order() {
    let mut turns = Turns::new(0.25);
    let flow = Flow::new(Priority::Background);
    (0..5).for_each(|n| turns.push(&flow, n));
    let order: Vec<i32> = std::iter::from_fn(|| turns.take()).map(|(_, n)| n).collect();
    assert_eq!(order, [0, 1, 2, 3, 4]);
    assert!(turns.drain().is_empty());
}
