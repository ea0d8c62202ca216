use super::*;

/// The share of `total_ms` in which it is the fit's turn, sampled every 100 µs.
fn share_of_fit(state: &mut State, from: Instant, total_ms: u32) -> f64 {
    let steps = total_ms * 10;
    let mut of_fit = 0;
    for step in 1..=steps {
        state.advance(from + Duration::from_micros(100) * step);
        of_fit += u32::from(state.is_turn_of_fit);
    }
    f64::from(of_fit) / f64::from(steps)
}

#[test]
fn a_fit_that_waits_for_endless_rollouts_gets_its_share() {
    let now = Instant::now();
    for fit_share in [0.1, 0.25, 0.9] {
        let mut state = State::new(fit_share, now);
        (state.rollouts, state.fits_waiting) = (1, 1);
        let share = share_of_fit(&mut state, now, 1_000);
        assert!((share - fit_share).abs() < 0.05, "{share} of {fit_share}");
    }
    let mut state = State::new(0.0, now);
    (state.rollouts, state.fits_waiting) = (1, 1);
    assert_eq!(share_of_fit(&mut state, now, 1_000), 0.0);
}

#[test]
fn without_a_fit_rollouts_never_wait() {
    let now = Instant::now();
    let mut state = State::new(0.25, now);
    state.rollouts = 3;
    assert_eq!(share_of_fit(&mut state, now, 1_000), 0.0);
}

#[test]
fn a_closed_loop_that_leaves_time_to_the_fit_owes_it_nothing() {
    let mut now = Instant::now();
    let mut state = State::new(0.25, now);
    for _ in 0..1_000 {
        // A millisecond of a rollout, then one of the client's.
        (state.rollouts, state.fits_waiting) = (1, 1);
        now += Duration::from_millis(1);
        state.advance(now);
        assert!(!state.is_turn_of_fit);
        (state.rollouts, state.fits_waiting) = (0, 0);
        now += Duration::from_millis(1);
        state.advance(now);
    }
}

#[test]
fn a_turn_of_the_fit_is_short_and_a_long_frame_of_it_is_made_up_for() {
    let now = Instant::now();
    let mut state = State::new(0.25, now);
    (state.rollouts, state.fits_waiting) = (1, 1);
    let turn = now + state.time_to_fit();
    state.advance(turn);
    assert!(state.is_turn_of_fit);
    assert!(state.time_to_rollouts() < Duration::from_millis(6));
    // The frame takes 100 ms, and the rollouts have three times as long after it.
    let ended = turn + Duration::from_millis(100);
    state.advance(ended);
    assert!(!state.is_turn_of_fit);
    assert!(state.time_to_fit() > Duration::from_millis(290), "{:?}", state.time_to_fit());
}

#[test]
fn a_fit_pauses_for_a_rollout_and_resumes_after_it() {
    let alternation = Alternation::new(0.0);
    let cancel = CancelToken::default();
    let fit = alternation.token(Priority::Background, &cancel);
    assert!(!fit.is_cancelled());
    let rollout = alternation.begin();
    let (done, ended) = std::sync::mpsc::channel();
    let waits = fit.clone();
    let fitting = std::thread::spawn(move || {
        let cancelled = waits.is_cancelled();
        done.send(()).unwrap();
        cancelled
    });
    while alternation.0.lock().fits_waiting == 0 {
        std::thread::yield_now();
    }
    assert!(ended.try_recv().is_err());
    drop(rollout);
    ended.recv().unwrap();
    assert!(!fitting.join().unwrap());
    // A fit that is cancelled does not wait for rollouts to end.
    let _rollout = alternation.begin();
    cancel.cancel();
    assert!(fit.is_cancelled());
}

#[test]
fn a_rollout_waits_for_the_turn_of_the_fit_to_end() {
    let alternation = Alternation::new(0.25);
    let _under_way = alternation.begin();
    let rollout = alternation.token(Priority::Interactive, &CancelToken::default());
    let turn = Duration::from_millis(8);
    let started = Instant::now();
    {
        let mut state = alternation.0.lock();
        state.advance(started);
        (state.owed_s, state.is_turn_of_fit) = (0.75 * turn.as_secs_f64(), true);
    }
    assert!(!rollout.is_cancelled());
    assert!(started.elapsed() >= turn);
    assert!(!alternation.0.lock().is_turn_of_fit);
}
