use std::os::unix::fs::PermissionsExt as _;

use bendtwin_core::Problem as _;

use super::*;

pub(crate) fn order(name: &str, role: Role) -> Order {
    Order { name: name.to_owned(), hosts: Vec::new(), role, days: 30, renew: false }
}

#[test]
fn nothing_is_overwritten_and_keys_are_private() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().join("ca");
    let written = Authority::create(&folder).unwrap();
    assert!(written.facts.is_authority);
    assert_eq!(Authority::create(&folder).unwrap_err().reason(), "CA_FILE_EXISTS");
    let authority = Authority::open(&folder).unwrap();
    let issued = authority.issue(&order("gpu1", Role::Worker)).unwrap();
    for key in [&written.key, &issued.key] {
        let mode = std::fs::metadata(key).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600, "{}", key.display());
    }
    let before = std::fs::read(&issued.certificate).unwrap();
    let again = authority.issue(&order("gpu1", Role::Worker)).unwrap_err();
    assert!(again.to_string().contains("--renew"), "{again}");
    assert_eq!(std::fs::read(&issued.certificate).unwrap(), before);
    authority.issue(&Order { renew: true, ..order("gpu1", Role::Worker) }).unwrap();
    assert_ne!(std::fs::read(&issued.certificate).unwrap(), before);
    // A key that others can read is refused.
    std::fs::set_permissions(&written.key, std::fs::Permissions::from_mode(0o644)).unwrap();
    assert_eq!(Authority::open(&folder).err().unwrap().reason(), "KEY_FILE_OPEN");
}

#[test]
fn hosts_are_those_of_the_order() {
    let folder = tempfile::tempdir().unwrap();
    Authority::create(folder.path()).unwrap();
    let authority = Authority::open(folder.path()).unwrap();
    let server = authority.issue(&order("twin", Role::Server)).unwrap();
    assert_eq!(server.facts.hosts, ["twin", "localhost", "127.0.0.1", "::1"]);
    let hosts = vec!["10.0.0.5".to_owned(), "gpu1.example.org".to_owned()];
    let worker = authority.issue(&Order { hosts, ..order("gpu1", Role::Worker) }).unwrap();
    assert_eq!(worker.facts.hosts, ["gpu1", "10.0.0.5", "gpu1.example.org"]);
    assert_eq!(worker.facts.issuer, authority.certificate.common_name);
    assert_eq!(worker.facts.name(), "gpu1");
}

#[test]
fn orders_with_faults_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let missing = Authority::open(folder.path()).err().unwrap();
    assert!(missing.to_string().contains("bendtwin ca init"), "{missing}");
    Authority::create(folder.path()).unwrap();
    let authority = Authority::open(folder.path()).unwrap();
    for name in ["", "ca", "crl", "../gpu", "a/b", "-a", "a.", "a b", &"a".repeat(64)] {
        let refused = authority.issue(&order(name, Role::Worker)).unwrap_err();
        assert!(matches!(refused, Error::Name(_)), "{name}: {refused}");
    }
    for host in ["http://gpu1", "gpu1:70", "a..b", ""] {
        let hosts = vec![host.to_owned()];
        let refused = authority.issue(&Order { hosts, ..order("gpu1", Role::Worker) });
        assert!(matches!(refused, Err(Error::Host(_))), "{host}");
    }
    for days in [i64::MAX, i64::from(AUTHORITY_DAYS) + 1] {
        let refused = authority.issue(&Order { days, ..order("gpu1", Role::Worker) });
        assert!(matches!(refused, Err(Error::Days(_))), "{days}");
    }
    // Its certificate, its key and its list.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3);
}

#[test]
fn what_ends_soon_is_renewed_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    Authority::create(folder.path()).unwrap();
    let authority = Authority::open(folder.path()).unwrap();
    let hosts = vec!["twin.example.org".to_owned(), "10.0.0.5".to_owned()];
    let soon = Order { hosts, days: 20, ..order("twin", Role::Server) };
    let soon = authority.issue(&soon).unwrap();
    let later = authority.issue(&Order { days: 90, ..order("gpu1", Role::Worker) }).unwrap();
    authority.issue(&Order { days: 20, ..order("gpu2", Role::Worker) }).unwrap();
    authority.revoke(&["gpu2".to_owned()]).unwrap();
    // An earlier one of the same name, which is not in use any more.
    authority.issue(&Order { days: 20, ..order("gpu3", Role::Worker) }).unwrap();
    let newest = Order { days: 90, renew: true, ..order("gpu3", Role::Worker) };
    authority.issue(&newest).unwrap();

    let within = SignedDuration::from_hours(30 * 24);
    let renewed = authority.renew(within).unwrap();
    assert_eq!(renewed.len(), 1, "{renewed:?}");
    let new = &renewed[0].facts;
    assert_eq!((&new.common_name, &new.hosts), (&soon.facts.common_name, &soon.facts.hosts));
    assert_eq!(new.not_after.duration_since(soon.facts.not_after).as_hours(), 0, "20 days again");
    assert!(new.serial != soon.facts.serial && renewed[0].certificate == soon.certificate);
    assert!(std::fs::read_to_string(&later.certificate).is_ok());
    assert_eq!(authority.renew(SignedDuration::from_hours(24)).unwrap(), []);
}
