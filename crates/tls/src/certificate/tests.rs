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
    assert_eq!(found.validity(found.not_after + second), Validity::Expired);
    assert_eq!(Certificate::of(&CertificateDer::from(vec![1, 2, 3])), None);
}
