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
