use bendtwin_core::Problem as _;

use super::*;
use crate::authority::{Order, Role, Written, tests::order};

fn authority() -> (tempfile::TempDir, Authority) {
    let folder = tempfile::tempdir().unwrap();
    Authority::create(folder.path()).unwrap();
    let authority = Authority::open(folder.path()).unwrap();
    (folder, authority)
}

fn issue(authority: &Authority, name: &str) -> Written {
    let order = Order { renew: true, ..order(name, Role::Worker) };
    authority.issue(&order).unwrap()
}

fn words(words: &[&str]) -> Vec<String> {
    words.iter().map(|word| (*word).to_owned()).collect()
}

/// Serial numbers of what the list in a folder revokes.
fn revoked(folder: &Path) -> Vec<String> {
    let der = pem::revocation_lists(&Authority::list_path(folder)).unwrap();
    RevocationList::of(&der[0]).unwrap().revoked.into_keys().collect()
}

#[test]
fn a_new_authority_has_revoked_nothing() {
    let (folder, authority) = authority();
    assert!(revoked(folder.path()).is_empty());
    assert!(issued(folder.path()).unwrap().is_empty());
    // One from before there were lists is given one.
    std::fs::remove_file(Authority::list_path(folder.path())).unwrap();
    assert_eq!(authority.revoke(&[]).unwrap().number, 1);
    assert!(revoked(folder.path()).is_empty());
}

#[test]
fn certificates_are_revoked_by_file_name_and_serial_number() {
    let (folder, authority) = authority();
    let [a, b, c, d] = ["a", "b", "c", "d"].map(|name| issue(&authority, name));
    let file = a.certificate.to_str().unwrap().to_owned();
    let with_colons: Vec<_> =
        c.facts.serial.as_bytes().chunks(2).map(|pair| str::from_utf8(pair).unwrap()).collect();
    let serial = with_colons.join(":").to_uppercase();
    let first = authority.revoke(&words(&[&file, "b"])).unwrap();
    let second = authority.revoke(&[serial]).unwrap();
    assert_eq!((first.total, second.total, second.number), (2, 3, first.number + 1));
    let mut expected = [&a, &b, &c].map(|written| written.facts.serial.clone());
    expected.sort();
    assert_eq!(revoked(folder.path()), expected);
    let all = issued(folder.path()).unwrap();
    assert_eq!(all.iter().filter(|one| one.revoked.is_none()).count(), 1);
    assert_eq!(all.last().unwrap().facts, d.facts);
    // Revoking again changes no time.
    let again = authority.revoke(&words(&["b"])).unwrap();
    let seconds = |at: Option<Timestamp>| at.unwrap().as_second();
    assert_eq!(seconds(again.asked[0].revoked), seconds(first.asked[1].revoked));
    assert_eq!(again.total, 3);
}

#[test]
fn a_name_stands_for_all_certificates_that_had_it() {
    let (folder, authority) = authority();
    let (before, after) = (issue(&authority, "gpu1"), issue(&authority, "gpu1"));
    assert_ne!(before.facts.serial, after.facts.serial);
    let done = authority.revoke(&words(&["gpu1"])).unwrap();
    assert_eq!(done.asked.len(), 2);
    let next = issue(&authority, "gpu1");
    assert!(!revoked(folder.path()).contains(&next.facts.serial));
}

#[test]
fn what_it_did_not_issue_is_not_revoked() {
    let (folder, authority) = authority();
    issue(&authority, "gpu1");
    let (_other, stranger) = self::authority();
    let file = issue(&stranger, "gpu1").certificate;
    let file = file.to_str().unwrap();
    let own = Authority::paths(folder.path()).0;
    for (word, reason) in [
        ("gpu2", "CERTIFICATE_UNKNOWN"),
        ("00", "CERTIFICATE_UNKNOWN"),
        (file, "INVALID_ARGUMENT"),
        (own.to_str().unwrap(), "INVALID_ARGUMENT"),
    ] {
        let refused = authority.revoke(&words(&["gpu1", word])).unwrap_err();
        assert_eq!(refused.reason(), reason, "{refused}");
    }
    assert!(revoked(folder.path()).is_empty(), "nothing is done by halves");
}

#[test]
fn a_list_that_cannot_be_read_is_not_replaced() {
    let (folder, authority) = authority();
    issue(&authority, "gpu1");
    let (other, _) = self::authority();
    let path = Authority::list_path(folder.path());
    std::fs::copy(Authority::list_path(other.path()), &path).unwrap();
    assert!(matches!(authority.revoke(&words(&["gpu1"])), Err(Error::OfAnother { .. })));
    std::fs::write(&path, "no list").unwrap();
    assert_eq!(authority.revoke(&words(&["gpu1"])).unwrap_err().reason(), "TLS_FILE_UNUSABLE");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "no list");
}

#[test]
fn two_that_revoke_at_the_same_time_lose_nothing() {
    let (folder, authority) = authority();
    let names: Vec<_> = (0..8).map(|n| format!("gpu{n}")).collect();
    for name in &names {
        issue(&authority, name);
    }
    std::thread::scope(|scope| {
        for name in &names {
            let folder = folder.path();
            scope.spawn(move || {
                Authority::open(folder).unwrap().revoke(std::slice::from_ref(name)).unwrap();
            });
        }
    });
    assert_eq!(revoked(folder.path()).len(), names.len());
}
