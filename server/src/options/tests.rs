use std::path::PathBuf;

use super::{Options, Tls, WorkerTls};

#[test]
fn defaults_are_valid() {
    Options::default().validate().unwrap();
}

#[test]
fn faults_are_reported_together() {
    let mut options = Options { lease_s: f64::NAN, ..Options::default() };
    options.workers.count = 1000;
    options.workers.backend = "gpu".to_owned();
    options.limits.json_bytes = 0;
    options.limits.rollout.request_bytes = 3 << 30;
    options.worker_token = Some("short".to_owned());
    assert_eq!(options.validate().unwrap_err().len(), 6);
}

#[test]
fn a_server_is_not_open_to_a_network_by_accident() {
    let public = || Options { listen: ([0, 0, 0, 0], 7070).into(), ..Options::default() };
    let faults = public().validate().unwrap_err();
    assert_eq!(faults.len(), 1);
    assert!(faults[0].contains("--tls-terminated-by-proxy") && faults[0].contains("--insecure"));
    Options { tls_terminated_by_proxy: true, ..public() }.validate().unwrap();
    Options { insecure: true, ..public() }.validate().unwrap();
    let (certificate, key) = (PathBuf::from("twin.pem"), PathBuf::from("twin.key"));
    let tls = Some(Tls { certificate: certificate.clone(), key: key.clone() });
    Options { tls: tls.clone(), ..public() }.validate().unwrap();
    // It is for clients alone, and takes no place of a token.
    let workers = Options { worker_listen: "[::]:0".parse().unwrap(), tls, ..Options::default() };
    let faults = workers.validate().unwrap_err();
    assert!(faults.len() == 1 && faults[0].contains("worker_tls"), "{faults:?}");
    let client_ca = PathBuf::from("ca.pem");
    let listen = ([0, 0, 0, 0], 7071).into();
    let worker_tls = Some(WorkerTls { listen, certificate, key, client_ca, crl: None });
    let without_token = Options { worker_tls, ..Options::default() };
    let faults = without_token.validate().unwrap_err();
    assert!(faults.len() == 1 && faults[0].contains("worker_token"), "{faults:?}");
    let token = Some("a-token-of-the-tests".to_owned());
    Options { worker_token: token, ..without_token }.validate().unwrap();
    // Without a token not even behind a proxy.
    let open = Options {
        client_token: super::ClientTokenPolicy::None,
        tls_terminated_by_proxy: true,
        ..public()
    };
    let faults = open.validate().unwrap_err();
    assert!(faults.len() == 1 && faults[0].contains("client_token"), "{faults:?}");
    Options { insecure: true, ..open }.validate().unwrap();
    let workers = Options { worker_listen: "[::]:0".parse().unwrap(), ..Options::default() };
    assert!(workers.validate().unwrap_err()[0].starts_with("worker_listen"));
    let local = Options { listen: "[::1]:0".parse().unwrap(), ..Options::default() };
    local.validate().unwrap();
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
