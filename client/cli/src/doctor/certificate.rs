//! Certificates that services on this machine show or trust.

use std::path::{Path, PathBuf};

use bendtwin_server::Options;
use bendtwin_tls::{Certificate, Validity, files};
use jiff::Timestamp;

use super::check::Check;

const NAME: &str = "certificate";

/// Checks of the certificates of a server with these options, and of further files.
pub(super) fn checks(options: &Options, further: &[&PathBuf]) -> Vec<Check> {
    let public = options.tls.iter().map(|tls| &tls.certificate);
    let workers = options.worker_tls.iter().flat_map(|tls| [&tls.certificate, &tls.client_ca]);
    let mut paths: Vec<_> = public.chain(workers).chain(further.iter().copied()).collect();
    // Listeners may share a file.
    paths.sort();
    paths.dedup();
    paths.into_iter().map(|path| check(path, Timestamp::now())).collect()
}

/// The check of a file: of the certificate in it that ends first.
fn check(path: &Path, now: Timestamp) -> Check {
    let found = match files::certificates(path) {
        Ok(found) => found,
        Err(error) => return Check::problem(NAME, error.to_string()),
    };
    let facts = found.iter().filter_map(Certificate::of);
    let shown = path.display();
    match facts.min_by_key(|facts| facts.not_after) {
        Some(facts) => judged(&shown.to_string(), &facts, now),
        None => Check::problem(NAME, format!("{shown} has no certificate that can be read")),
    }
}

fn judged(path: &str, facts: &Certificate, now: Timestamp) -> Check {
    let (begin, end) = (facts.not_before, facts.not_after);
    let advice = match facts.is_authority {
        true => "make another authority (`bendtwin ca init`), and give its certificate to everyone",
        false => "renew it (`bendtwin ca renew`) where its authority is, and replace the files",
    };
    match facts.validity(now) {
        Validity::Valid => Check::ok(NAME, format!("{path} is valid until {end:.0}")),
        Validity::Soon => Check::note(NAME, format!("{path} ends soon, at {end:.0}: {advice}")),
        Validity::Expired => Check::problem(NAME, format!("{path} expired at {end:.0}: {advice}")),
        Validity::NotYet => {
            let advice = "is the clock of this machine right?";
            Check::problem(NAME, format!("{path} is not valid before {begin:.0}: {advice}"))
        }
    }
}

#[cfg(test)]
mod tests {
    use bendtwin_tls::authority::{Authority, Order, Role};
    use jiff::SignedDuration;

    use super::*;
    use crate::doctor::check::State;

    #[test]
    fn the_end_of_a_certificate_is_announced() {
        let folder = tempfile::tempdir().unwrap();
        Authority::create(folder.path()).unwrap();
        let authority = Authority::open(folder.path()).unwrap();
        let issue = |name: &str, days| {
            let (name, hosts, role) = (name.to_owned(), Vec::new(), Role::Server);
            let order = Order { name, hosts, role, days, renew: false };
            authority.issue(&order).unwrap().certificate
        };
        let state = |path: &Path| check(path, Timestamp::now());
        assert_eq!(state(&issue("far", 100)).state, State::Ok);
        let soon =
            check(&issue("soon", 100), Timestamp::now() + SignedDuration::from_hours(90 * 24));
        assert!(soon.state == State::Note && soon.message.contains("ca renew"), "{soon:?}");
        let over = state(&issue("over", -1));
        assert!(over.state == State::Problem && over.message.contains("ca renew"), "{over:?}");
        let (ca, _) = Authority::paths(folder.path());
        assert_eq!(state(&ca).state, State::Ok);
        let missing = state(&folder.path().join("missing.pem"));
        assert!(missing.state == State::Problem && missing.message.contains("missing.pem"));
    }
}
