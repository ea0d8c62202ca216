use super::*;
use crate::{Public, tests::Folder};

#[test]
fn a_bad_pair_keeps_the_one_before() {
    let folder = Folder::new();
    let (first, second) = (folder.issue("first"), folder.issue("second"));
    let paths = first.clone();
    let settings = Reloaded::new(first.all(), move || Public::load(&paths)).unwrap();
    let name = || settings.get().certificate.as_ref().unwrap().common_name.clone();
    assert!(!settings.refresh(), "nothing has changed");
    // The certificate without its key: half of a replacement.
    std::fs::copy(&second.certificate, &first.certificate).unwrap();
    assert!(!settings.refresh());
    assert_eq!(name(), "first");
    std::fs::copy(&second.key, &first.key).unwrap();
    assert!(settings.refresh());
    assert_eq!(name(), "second");
    std::fs::remove_file(&first.key).unwrap();
    assert!(!settings.refresh());
    assert_eq!(name(), "second");
}
