use std::{fs, io::Write as _};

use rcgen::{CertificateRevocationListParams, Issuer, KeyIdMethod, KeyPair, date_time_ymd};

use super::*;
use crate::{Mutual, MutualPaths, authority::Authority, tests::Folder};

/// Fault for which a file is refused as the list beside an authority.
fn refusal(paths: &MutualPaths) -> String {
    Mutual::load(paths).err().map(|error| error.to_string()).unwrap_or_default()
}

#[test]
fn a_list_states_what_was_revoked() {
    let folder = Folder::new();
    let paths = folder.peer("gpu1");
    folder.issue("gpu2");
    folder.revoke(&["gpu2"]);
    let loaded = Mutual::load(&paths).unwrap();
    let list = &loaded.lists[0];
    assert_eq!((loaded.lists.len(), list.revoked.len(), list.number), (1, 1, 2));
    let authority = loaded.certificate.unwrap().issuer;
    assert_eq!(list.issuer, authority);
    // It ends with the authority, not before.
    let ca = files::certificates(&folder.ca()).unwrap();
    let ca = crate::Certificate::of(&ca[0]).unwrap();
    assert_eq!(list.next_update, Some(ca.not_after));
}

#[test]
fn a_list_that_cannot_be_used_is_refused_with_advice() {
    let (folder, other) = (Folder::new(), Folder::new());
    let paths = folder.peer("gpu1");
    let own = fs::read(folder.crl()).unwrap();

    fs::write(folder.crl(), "-----BEGIN X509 CRL-----\nAAAA\n-----END X509 CRL-----\n").unwrap();
    assert!(refusal(&paths).contains("damaged"), "{}", refusal(&paths));
    fs::copy(folder.ca(), folder.crl()).unwrap();
    assert!(refusal(&paths).contains("no revocation list"), "{}", refusal(&paths));
    fs::copy(other.crl(), folder.crl()).unwrap();
    assert!(refusal(&paths).contains("not signed by an authority"), "{}", refusal(&paths));
    fs::remove_file(folder.crl()).unwrap();
    assert!(refusal(&paths).contains("cannot read"), "{}", refusal(&paths));

    fs::write(folder.crl(), &own).unwrap();
    assert_eq!(refusal(&paths), "");
    let twice = fs::OpenOptions::new().append(true).open(folder.crl());
    twice.unwrap().write_all(&own).unwrap();
    assert!(refusal(&paths).contains("second one"), "{}", refusal(&paths));
}

/// A list of the authority of a folder, signed with this key, that ends in a year.
fn list(folder: &Folder, key: KeyPair, year: i32) -> String {
    let ca = fs::read_to_string(folder.ca()).unwrap();
    CertificateRevocationListParams {
        this_update: date_time_ymd(2020, 1, 1),
        next_update: date_time_ymd(year, 1, 1),
        crl_number: 7.into(),
        issuing_distribution_point: None,
        revoked_certs: Vec::new(),
        key_identifier_method: KeyIdMethod::Sha256,
    }
    .signed_by(&Issuer::from_ca_cert_pem(&ca, key).unwrap())
    .unwrap()
    .pem()
    .unwrap()
}

#[test]
fn the_signature_and_the_end_of_a_list_count() {
    let folder = Folder::new();
    let paths = folder.peer("gpu1");
    let (_, key) = Authority::paths(folder.path());
    let own = || KeyPair::from_pem(&fs::read_to_string(&key).unwrap()).unwrap();
    fs::write(folder.crl(), list(&folder, own(), 9999)).unwrap();
    assert_eq!(refusal(&paths), "");
    // The name of an authority is not enough.
    fs::write(folder.crl(), list(&folder, KeyPair::generate().unwrap(), 9999)).unwrap();
    assert!(refusal(&paths).contains("not signed by an authority"), "{}", refusal(&paths));
    fs::write(folder.crl(), list(&folder, own(), 2021)).unwrap();
    assert!(refusal(&paths).contains("ended at 2021-01-01"), "{}", refusal(&paths));
}

#[test]
fn each_authority_has_its_list() {
    let (old, new) = (Folder::new(), Folder::new());
    let paths = new.peer("gpu1");
    let both = [fs::read(new.ca()).unwrap(), fs::read(old.ca()).unwrap()].concat();
    fs::write(new.ca(), both).unwrap();
    assert!(refusal(&paths).contains("no list of"), "{}", refusal(&paths));
    let lists = [fs::read(new.crl()).unwrap(), fs::read(old.crl()).unwrap()].concat();
    fs::write(new.crl(), lists).unwrap();
    assert_eq!(Mutual::load(&paths).unwrap().lists.len(), 2);
}
