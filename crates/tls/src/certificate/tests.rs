use super::*;
use crate::{files, tests::Folder};

#[test]
fn a_certificate_tells_its_hosts_and_its_end() {
    let folder = Folder::new();
    let der = files::certificates(&folder.issue("twin").certificate).unwrap();
    let found = Certificate::of(&der[0]).unwrap();
    assert_eq!(found.hosts, ["twin", "localhost", "127.0.0.1", "::1"]);
    assert_eq!(found.validity(Timestamp::now()), Validity::Valid);
    let second = SignedDuration::from_secs(1);
    assert_eq!(found.validity(found.not_before - second), Validity::NotYet);
    assert_eq!(found.validity(found.not_after), Validity::Soon);
    assert_eq!(found.validity(found.not_after + second), Validity::Expired);
    assert_eq!(Certificate::of(&CertificateDer::from(vec![1, 2, 3])), None);
}

#[test]
fn the_end_of_a_certificate_comes_into_sight() {
    let now = Timestamp::now();
    let valid_for = |hours| Certificate {
        serial: "1".to_owned(),
        common_name: "twin".to_owned(),
        issuer: "authority".to_owned(),
        hosts: Vec::new(),
        not_before: now,
        not_after: now + SignedDuration::from_hours(hours),
        is_authority: false,
    };
    let second = SignedDuration::from_secs(1);
    for (hours, before_end) in [(365 * 24, 14 * 24), (90 * 24, 14 * 24), (30, 10)] {
        let certificate = valid_for(hours);
        let near = certificate.not_after - SignedDuration::from_hours(before_end);
        assert_eq!(certificate.validity(near), Validity::Valid, "{hours}");
        assert_eq!(certificate.validity(near + second), Validity::Soon, "{hours}");
    }
}
