#![cfg(unix)]

use std::os::unix::fs::PermissionsExt as _;

use super::*;
use crate::{MutualPaths, PairPaths, Public, tests::Folder};

#[test]
fn faults_of_files_are_named() {
    let folder = Folder::new();
    let pair = folder.issue("twin");
    let says = |paths: &PairPaths, what: &str| {
        let fault = Public::load(paths).unwrap_err().to_string();
        assert!(fault.contains(what), "{fault}");
    };
    Public::load(&pair).unwrap();
    let missing = folder.path().join("none.pem");
    says(&PairPaths { certificate: missing, ..pair.clone() }, "none.pem: No such file");
    says(&PairPaths { certificate: pair.key.clone(), ..pair.clone() }, "no certificate in");
    let key = folder.path().join("no.key");
    std::fs::write(&key, "nothing").unwrap();
    std::fs::set_permissions(&key, std::fs::Permissions::from_mode(0o600)).unwrap();
    says(&PairPaths { key, ..pair.clone() }, "without a passphrase");
    let other = folder.issue("other");
    says(&PairPaths { key: other.key, ..pair.clone() }, "made together");
    let ca = pair.key.clone();
    let mutual = MutualPaths { pair, ca, crl: None };
    assert!(crate::Mutual::load(&mutual).unwrap_err().to_string().contains("no certificate in"));
}

#[test]
fn a_key_is_read_by_owner_and_group_alone() {
    let folder = Folder::new();
    let pair = folder.issue("twin");
    for (mode, is_read) in [(0o600, true), (0o640, true), (0o644, false), (0o606, false)] {
        std::fs::set_permissions(&pair.key, std::fs::Permissions::from_mode(mode)).unwrap();
        match key(&pair.key) {
            Ok(_) => assert!(is_read, "{mode:o}"),
            Err(error) => {
                assert!(!is_read, "{mode:o}");
                assert_eq!(error.reason(), "KEY_FILE_OPEN");
                assert!(error.to_string().contains("chmod o="), "{error}");
            }
        }
    }
}
