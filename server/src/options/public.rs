//! Address at which clients reach the server: behind a proxy, or at the published port of a container.

use url::Url;

use super::{Options, is_local};
use crate::http::origin::Hosts;

impl Options {
    /// Address at which clients reach the server, if the options name one.
    pub fn public_url(&self) -> Option<&str> {
        let of_sign_in = self.sign_in.as_ref().map(|sign_in| sign_in.public_url.as_str());
        let url = self.public_url.as_deref().or(of_sign_in)?;
        Some(url.trim_end_matches('/'))
    }

    /// True if nothing but its publication to this machine alone protects the address for clients.
    pub fn is_published_locally(&self) -> bool {
        self.published_locally
            && self.tls.is_none()
            && !self.tls_terminated_by_proxy
            && !self.insecure
    }

    /// Faults of the public address.
    pub(super) fn public_url_faults(&self) -> Vec<String> {
        let Some(text) = &self.public_url else { return Vec::new() };
        let url = Url::parse(text).ok().filter(is_origin);
        let Some((url, host)) = url.as_ref().and_then(|url| Some((url, url.host_str()?))) else {
            return vec![format!(
                "public_url is `{text}`: give the scheme, the name and the port, as in \
                 https://twin.example.org:8443"
            )];
        };
        let mut faults = Vec::new();
        if !Hosts::new(&self.allowed_hosts).allows(host) {
            faults.push(host_not_allowed("public_url", host));
        }
        if self.is_published_locally() && !is_local(url) {
            faults.push(format!(
                "public_url is {text}, which others can reach, and published_locally says that the \
                 port is published to this machine alone: give a certificate (--tls-certificate, \
                 --tls-key), or set tls_terminated_by_proxy if a proxy in front has one"
            ));
        }
        faults
    }
}

/// The fault of a public address under whose name the server would refuse to answer.
pub(super) fn host_not_allowed(setting: &str, host: &str) -> String {
    format!(
        "{setting} has the host {host}, which is not among allowed_hosts, so the server would refuse \
         browsers that come there: add it (--allowed-host {host})"
    )
}

fn is_origin(url: &Url) -> bool {
    ["http", "https"].contains(&url.scheme())
        && url.path() == "/"
        && url.username().is_empty()
        && url.password().is_none()
        && url.query().is_none()
        && url.fragment().is_none()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::{ClientTokenPolicy, SignIn};

    /// Options of a container, with a public address.
    fn container(url: &str) -> Options {
        let listen = ([0, 0, 0, 0], 7070).into();
        let public_url = (!url.is_empty()).then(|| url.to_owned());
        Options { listen, public_url, published_locally: true, ..Options::default() }
    }

    #[test]
    fn a_port_that_is_published_to_this_machine_takes_no_tls_but_a_token() {
        for url in ["", "http://127.0.0.1:8080", "http://localhost:8080/", "http://[::1]:7070"] {
            container(url).validate().unwrap();
        }
        let open = Options { client_token: ClientTokenPolicy::None, ..container("") };
        let faults = open.validate().unwrap_err();
        assert!(faults.len() == 1 && faults[0].contains("client_token"), "{faults:?}");
        // Workers are not published.
        let workers = Options { worker_listen: ([0, 0, 0, 0], 7071).into(), ..container("") };
        assert!(workers.validate().unwrap_err()[0].starts_with("worker_listen"));
    }

    #[test]
    fn an_address_of_others_contradicts_a_port_of_this_machine() {
        let allowed_hosts = vec!["twin.example".to_owned()];
        let public = Options { allowed_hosts, ..container("https://twin.example") };
        let faults = public.validate().unwrap_err();
        assert!(faults.len() == 1 && faults[0].contains("published_locally"), "{faults:?}");
        let behind_proxy = Options { tls_terminated_by_proxy: true, ..public };
        assert!(!behind_proxy.is_published_locally());
        behind_proxy.validate().unwrap();
    }

    #[test]
    fn the_public_address_is_one_that_the_server_answers_to() {
        for wrong in ["127.0.0.1:7070", "ftp://127.0.0.1", "http://127.0.0.1/a", "http://a:b@[::1]"]
        {
            let faults = container(wrong).validate().unwrap_err();
            assert!(faults.len() == 1 && faults[0].contains("public_url"), "{wrong}: {faults:?}");
        }
        let other = Options { insecure: true, ..container("http://lab:7070") };
        assert!(other.validate().unwrap_err()[0].contains("--allowed-host lab"));
    }

    #[test]
    fn the_address_of_the_sign_in_is_public() {
        let sign_in = Some(SignIn::new("https://id.example", "bendtwin", "https://twin.example/"));
        let options = Options { sign_in, ..Options::default() };
        assert_eq!(options.public_url(), Some("https://twin.example"));
        let other = Options { public_url: Some("https://other.example".into()), ..options };
        assert_eq!(other.public_url(), Some("https://other.example"));
        assert_eq!(Options::default().public_url(), None);
    }
}
