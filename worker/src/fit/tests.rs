use super::*;

#[test]
fn settings_default_and_refuse() {
    assert_eq!(settings_of("").unwrap(), FitSettings::default());
    assert_eq!(settings_of("{\"seed\": 7}").unwrap().seed, 7);
    for wrong in ["{", "{\"sed\": 7}", "{\"refine\": {\"learning_rate\": -1.0}}"] {
        let fault = settings_of(wrong).unwrap_err();
        assert_eq!(fault.category, Category::InvalidArgument);
        assert_eq!(fault.reason, "INVALID_SETTINGS");
    }
}

#[tokio::test]
async fn the_first_reason_to_stop_counts() {
    let stop = Stop::default();
    assert_eq!(stop.reason(), None);
    stop.stop(Reason::Cancelled);
    stop.stop(Reason::Drained);
    stop.stopped().await;
    assert_eq!(stop.reason(), Some(Reason::Cancelled));
    assert!(stop.token().is_cancelled());
}

#[tokio::test]
async fn a_fit_makes_way_at_a_checkpoint_while_it_is_asked_to() {
    let stop = Stop::default();
    stop.make_way(true);
    stop.make_way(false);
    stop.at_checkpoint();
    assert_eq!(stop.reason(), None);
    stop.make_way(true);
    assert_eq!(stop.reason(), None);
    stop.at_checkpoint();
    stop.stopped().await;
    assert_eq!(stop.reason(), Some(Reason::MakesWay));
    assert!(stop.token().is_cancelled());
}

#[tokio::test]
async fn a_cancelled_fit_does_not_wait_for_a_thread_that_hears_nothing() {
    let (done, thread) = oneshot::channel();
    let stop = Stop::default();
    stop.stop(Reason::Cancelled);
    let (outcome, straggler) = finish(thread, &stop).await;
    assert!(matches!(outcome, Outcome::Failed(fault) if fault.category == Category::Cancelled));
    // The next job waits for it.
    assert!(done.send(Outcome::Panicked("late".to_owned())).is_ok());
    assert!(straggler.unwrap().await.is_ok());
}

#[tokio::test]
async fn a_fit_that_is_handed_back_is_waited_for() {
    let (done, thread) = oneshot::channel();
    let stop = Stop::default();
    stop.stop(Reason::Drained);
    tokio::spawn(async move {
        tokio::time::sleep(CANCEL_GRACE + Duration::from_millis(100)).await;
        let _ = done.send(Outcome::Failed(cancelled()));
    });
    let (outcome, straggler) = finish(thread, &stop).await;
    assert!(matches!(outcome, Outcome::Failed(_)) && straggler.is_none());
}
