use super::*;

/// A rollout that takes a worker of the assumed speed this many seconds. Each client has a separate owner, unless its name has one before a slash.
fn ask(client: &str, seconds: f64) -> Ask {
    let owner = client.split_once('/').map_or(client, |(owner, _)| owner);
    Ask { owner: owner.into(), client: client.into(), work: 4e7 * seconds }
}

/// True if it has its slot.
fn has_begun(place: &mut Place) -> bool {
    let Some(turn) = &mut place.turn else { return true };
    let begun = turn.try_recv().is_ok();
    if begun {
        place.turn = None;
    }
    begun
}

fn join(line: &Line, client: &str, seconds: f64) -> Place {
    line.join(&ask(client, seconds)).unwrap()
}

#[test]
fn slots_are_kept_for_small_ones() {
    let line = Line::new(8, 64);
    let greedy = |nth: usize| ["one", "two"][nth % 2];
    let mut large: Vec<Place> = (0..8).map(|n| join(&line, greedy(n), 100.0)).collect();
    assert_eq!(large.iter_mut().map(has_begun).filter(|b| *b).count(), 2);
    let mut medium: Vec<Place> = (0..8).map(|n| join(&line, greedy(n), 5.0)).collect();
    assert_eq!(medium.iter_mut().map(has_begun).filter(|b| *b).count(), 3);
    for _ in 0..20 {
        let mut small: Vec<Place> = (0..3).map(|n| join(&line, greedy(n), 0.1)).collect();
        assert!(small.iter_mut().all(has_begun));
    }
    assert_eq!(line.waiting(), [0, 5, 6]);
    drop(large);
    assert_eq!(medium.iter_mut().map(has_begun).filter(|b| *b).count(), 5);
}

#[test]
fn a_slot_goes_to_each_larger_size_however_many_small_ones_come() {
    for slots in [1, 2, 3, 8] {
        let line = Line::new(slots, 64);
        let mut small: Vec<Place> = (0..12).map(|_| join(&line, "many", 0.1)).collect();
        let mut large = join(&line, "one", 100.0);
        let mut passed = 0;
        while !has_begun(&mut large) {
            let done = small.iter_mut().position(has_begun).expect("something is under way");
            small.remove(done);
            small.push(join(&line, "many", 0.1));
            passed += 1;
            assert!(passed <= 16, "with {slots} slots");
        }
    }
}

#[test]
fn clients_take_turns_by_work() {
    let line = Line::new(1, 400);
    let mut under_way = join(&line, "first", 0.5);
    assert!(has_begun(&mut under_way));
    let mut waiting: Vec<(&str, f64, Place)> = Vec::new();
    for _ in 0..60 {
        waiting.push(("greedy", 0.4, join(&line, "greedy", 0.4)));
    }
    for _ in 0..120 {
        waiting.push(("modest", 0.1, join(&line, "modest", 0.1)));
    }
    let mut work = HashMap::from([("greedy", 0.0), ("modest", 0.0)]);
    for _ in 0..60 {
        drop(under_way);
        let next = waiting.iter_mut().position(|(_, _, p)| has_begun(p)).unwrap();
        let (client, seconds, place) = waiting.swap_remove(next);
        *work.get_mut(client).unwrap() += seconds;
        under_way = place;
    }
    assert!((work["greedy"] - work["modest"]).abs() <= 0.81, "{work:?}");
}

#[test]
fn an_owner_leaves_a_slot_of_each_size_to_others() {
    for seconds in [0.1, 5.0, 100.0] {
        let line = Line::new(8, 64);
        let _many: Vec<Place> =
            (0..32).map(|n| join(&line, &format!("many/{n}"), seconds)).collect();
        let mut one = join(&line, "one/1", seconds);
        assert!(has_begun(&mut one), "{seconds} s");
    }
}

#[test]
fn owners_take_turns_however_many_clients_each_has() {
    let line = Line::new(1, 400);
    let mut under_way = join(&line, "many/first", 0.1);
    assert!(has_begun(&mut under_way));
    let mut waiting: Vec<(bool, Place)> = Vec::new();
    for nth in 0..96 {
        let place = join(&line, &format!("many/{}", nth % 32), 0.1);
        waiting.push((false, place));
    }
    for _ in 0..12 {
        waiting.push((true, join(&line, "one/1", 0.1)));
    }
    let mut of_one = 0;
    for _ in 0..20 {
        drop(under_way);
        let next = waiting.iter_mut().position(|(_, place)| has_begun(place)).unwrap();
        let (is_of_one, place) = waiting.swap_remove(next);
        of_one += usize::from(is_of_one);
        under_way = place;
    }
    assert!((9..=11).contains(&of_one), "{of_one} of 20");
}

#[test]
fn no_owner_takes_all_places() {
    let line = Line::new(1, 64);
    let _under_way = join(&line, "many/0", 0.1);
    let joined = |nth: usize| line.join(&ask(&format!("many/{nth}"), 0.1)).ok();
    let many: Vec<Place> = (0..100).filter_map(joined).collect();
    assert!((48..64).contains(&many.len()), "{}", many.len());
    assert!(line.join(&ask("one/1", 0.1)).is_ok());
}

#[test]
fn no_client_and_no_size_takes_all_places() {
    let line = Line::new(1, 16);
    let _under_way = join(&line, "greedy", 0.1);
    let take = |client: &str, seconds: f64| {
        std::iter::from_fn(|| line.join(&ask(client, seconds)).ok()).collect::<Vec<_>>()
    };
    let large = take("greedy", 100.0);
    assert_eq!(line.waiting()[2], large.len());
    assert!(large.len() < 8, "{}", large.len());
    let other = take("other", 100.0);
    assert!(!other.is_empty() && large.len() + other.len() <= 8);
    let small = take("greedy", 0.1);
    assert!(!small.is_empty());
    assert!(line.join(&ask("other", 0.1)).is_ok());
}

#[test]
fn a_client_that_leaves_frees_its_place() {
    let line = Line::new(1, 2);
    let first = join(&line, "a", 0.1);
    let (second, mut third) = (join(&line, "a", 0.1), join(&line, "a", 0.1));
    assert!(line.join(&ask("a", 0.1)).is_err());
    assert_eq!(line.len(), 3);
    drop(second);
    assert!(!has_begun(&mut third));
    drop(first);
    assert!(has_begun(&mut third));
    drop(third);
    assert_eq!((line.len(), line.ahead_s()), (0, 0.0));
}

#[test]
fn the_wait_is_the_work_ahead_at_the_measured_speed() {
    let line = Line::new(1, 1);
    let under_way = join(&line, "a", 40.0);
    let _waiting = join(&line, "a", 60.0);
    let wait = |seconds: f64| line.join(&ask("b", seconds)).unwrap_err().retry_after.as_secs_f64();
    assert!((wait(100.0) - 100.0).abs() < 0.1, "{}", wait(100.0));
    assert!((line.ahead_s() - 100.0).abs() < 0.1);
    line.set_fit(true);
    assert!((wait(100.0) - 133.3).abs() < 0.1, "{}", wait(100.0));
    line.set_fit(false);
    // It turns out to be ten times as fast.
    under_way.computed(4.0);
    assert!((9.0..13.0).contains(&wait(1e3)), "{}", wait(1e3));
    // Bounded for any numbers.
    under_way.computed(1e9);
    assert_eq!(wait(1e12), 600.0);
    under_way.computed(f64::NAN);
    under_way.computed(1e-12);
    assert!((1.0..=600.0).contains(&wait(1e12)));
}

#[test]
fn sizes_follow_the_measured_speed() {
    let line = Line::new(8, 64);
    let place = join(&line, "a", 4.0);
    assert_eq!(line.lock().size(&ask("a", 4.0)), Size::Medium);
    place.computed(0.04);
    assert_eq!(line.lock().size(&ask("a", 4.0)), Size::Small);
}
