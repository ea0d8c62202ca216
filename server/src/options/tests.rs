use super::Options;

#[test]
fn defaults_are_valid() {
    Options::default().validate().unwrap();
}

#[test]
fn all_faults_are_reported_at_once() {
    let mut options = Options { lease_s: f64::NAN, ..Options::default() };
    options.workers.count = 1000;
    options.workers.backend = "gpu".to_owned();
    options.limits.json_bytes = 0;
    options.limits.rollout.request_bytes = 3 << 30;
    options.worker_token = Some("short".to_owned());
    assert_eq!(options.validate().unwrap_err().len(), 6);
}

#[test]
fn options_survive_json_and_unknown_fields_are_refused() {
    let json = serde_json::to_string(&Options::default()).unwrap();
    assert_eq!(serde_json::from_str::<Options>(&json).unwrap(), Options::default());
    assert!(serde_json::from_str::<Options>(r#"{"lisen": "127.0.0.1:1"}"#).is_err());
}

#[test]
fn the_token_is_not_printed() {
    let options = Options { worker_token: Some("0123456789abcdef".into()), ..Options::default() };
    assert!(!format!("{options:?}").contains("0123456789abcdef"));
}

#[test]
fn the_former_name_of_the_heartbeat_interval_is_read() {
    let options: Options = serde_json::from_str(r#"{"beat_interval_s": 7.0}"#).unwrap();
    assert_eq!(options.heartbeat_interval_s, 7.0);
}
