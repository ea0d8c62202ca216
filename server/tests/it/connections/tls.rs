//! TLS of clients, and of workers on other hosts.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::Duration,
};

use bendtwin_client::{Client, ListQuery};
use bendtwin_contract::worker_key;
use bendtwin_proto::{
    fault,
    worker::v1::{RegisterRequest, worker_link_client::WorkerLinkClient},
};
use bendtwin_server::{Tls, WorkerTls};
use bendtwin_tls::{
    ClientConfig, Connector, Mutual, MutualPaths, PairPaths, TlsError,
    authority::{Authority, Order, Role},
    client_config,
};
use tokio::{
    io::{AsyncReadExt as _, AsyncWriteExt as _},
    net::TcpStream,
    time::timeout,
};
use tonic::{
    Code, Request, Status,
    transport::{Channel, Endpoint},
};

use crate::harness::{Server, TOKEN};

/// Ample time for anything that has to happen.
const SOON: Duration = Duration::from_secs(30);

/// An authority in a temporary folder.
struct Ca(tempfile::TempDir);

impl Ca {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        Authority::create(folder.path()).unwrap();
        Self(folder)
    }

    fn path(&self) -> PathBuf {
        Authority::paths(self.0.path()).0
    }

    fn revoke(&self, name: &str) {
        Authority::open(self.0.path()).unwrap().revoke(&[name.to_owned()]).unwrap();
    }

    fn issue(&self, name: &str, days: i64) -> PairPaths {
        let hosts = vec!["127.0.0.1".to_owned()];
        let order = Order { name: name.to_owned(), hosts, role: Role::Server, days, renew: true };
        let written = Authority::open(self.0.path()).unwrap().issue(&order).unwrap();
        PairPaths { certificate: written.certificate, key: written.key }
    }

    /// Settings of a worker that demands a server of `ca`.
    fn worker(&self, name: &str, days: i64, ca: &Ca) -> Arc<ClientConfig> {
        let paths = MutualPaths { pair: self.issue(name, days), ca: ca.path(), crl: None };
        Mutual::load(&paths).unwrap().client
    }
}

fn public(pair: &PairPaths) -> Option<Tls> {
    Some(Tls { certificate: pair.certificate.clone(), key: pair.key.clone() })
}

async fn client(server: &Server, ca: &Path) -> Result<Client, bendtwin_client::Error> {
    let url = format!("https://{}", server.handle.local_addr());
    Client::connect_with(&url, None, Some(ca)).await
}

/// The metrics, from the listener that has no TLS.
async fn metrics(server: &Server) -> String {
    let url = format!("http://{}/metrics", server.handle.worker_addr());
    reqwest::get(url).await.unwrap().text().await.unwrap()
}

#[tokio::test]
async fn clients_call_and_upload_over_tls() {
    let ca = Ca::new();
    let server = Server::start_with(|o| o.tls = public(&ca.issue("twin", 1))).await;
    let client = client(&server, &ca.path()).await.unwrap();
    assert!(!client.readiness().await.unwrap().checks.is_empty());
    let file = server.dir.path().join("rope.zip");
    std::fs::write(&file, "an archive").unwrap();
    let captures = client.captures();
    let whole = captures.upload(&file, "rope").await.unwrap();
    let pushed = captures.upload_resumable(&file, "another rope", |_| ()).await.unwrap();
    assert_eq!(captures.get(whole.name).await.unwrap().display_name, "rope");
    assert_ne!(whole.name, pushed.name);
    assert!(
        metrics(&server)
            .await
            .contains(r#"bendtwin_certificate_end_timestamp_seconds{listener="public"}"#)
    );
}

#[tokio::test]
async fn what_fits_not_is_refused_with_advice() {
    let ca = Ca::new();
    let server = Server::start_with(|o| o.tls = public(&ca.issue("twin", 1))).await;
    let unknown = client(&server, &Ca::new().path()).await.unwrap_err();
    assert_eq!(unknown.reason(), "TLS_CERTIFICATE_REFUSED", "{unknown}");
    // Without TLS, over either transport.
    let url = server.url("");
    let plain = Client::connect_with_token(&url, None).await.unwrap();
    for refused in [
        plain.captures().all(&ListQuery::default()).await.unwrap_err(),
        plain.readiness().await.unwrap_err(),
    ] {
        assert_eq!(refused.reason(), "TLS_REQUIRED", "{refused}");
        assert!(refused.message().contains("https://"), "{refused}");
    }
}

#[tokio::test]
async fn a_new_certificate_is_for_new_connections() {
    let (before, after) = (Ca::new(), Ca::new());
    let pair = before.issue("twin", 1);
    let server = Server::start_with(|o| o.tls = public(&pair)).await;
    let old = client(&server, &before.path()).await.unwrap();
    let new = after.issue("twin", 1);
    std::fs::copy(&new.certificate, &pair.certificate).unwrap();
    std::fs::copy(&new.key, &pair.key).unwrap();
    let reloaded = async {
        while client(&server, &after.path()).await.is_err() {
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    };
    timeout(SOON, reloaded).await.expect("the certificate is not reloaded");
    old.captures().all(&ListQuery::default()).await.unwrap();
    assert_eq!(
        client(&server, &before.path()).await.unwrap_err().reason(),
        "TLS_CERTIFICATE_REFUSED"
    );
}

#[tokio::test]
async fn stalled_handshakes_are_cut_off_and_counted() {
    let ca = Ca::new();
    let server = Server::start_with(|o| {
        o.tls = public(&ca.issue("twin", 1));
        o.limits.head_timeout_s = 0.2;
    })
    .await;
    for start in [&b""[..], b"\x16", b"\x16\x03\x01\x02\x00\x01\x00", b"\x16\xff\xff\xff\xff"] {
        let mut stream = TcpStream::connect(server.handle.local_addr()).await.unwrap();
        stream.write_all(start).await.unwrap();
        let ended = timeout(SOON, stream.read_to_end(&mut Vec::new())).await;
        let _ = ended.expect("the connection stays open");
    }
    let counted = r#"bendtwin_connections_ended_total{listener="public",why="handshake"} 4"#;
    let text = metrics(&server).await;
    assert!(text.contains(counted), "{text}");
    // A good one is served as before.
    client(&server, &ca.path()).await.unwrap().captures().all(&ListQuery::default()).await.unwrap();
}

#[tokio::test]
async fn stalled_handshakes_make_room() {
    let ca = Ca::new();
    let server = Server::start_with(|o| {
        o.tls = public(&ca.issue("twin", 1));
        o.limits.connections = 4;
        o.limits.connections_per_peer = 4;
        o.limits.head_timeout_s = 3600.0;
    })
    .await;
    let mut stalled = Vec::new();
    for _ in 0..12 {
        let mut stream = TcpStream::connect(server.handle.local_addr()).await.unwrap();
        stream.write_all(b"\x16\x03").await.unwrap();
        stalled.push(stream);
    }
    let client = timeout(SOON, client(&server, &ca.path())).await.expect("there is no room");
    client.unwrap().captures().all(&ListQuery::default()).await.unwrap();
}

/// A server with a listener for workers on other hosts.
async fn with_workers(ca: &Ca) -> Server {
    let PairPaths { certificate, key } = ca.issue("twin", 1);
    let listen = ([127, 0, 0, 1], 0).into();
    let client_ca = ca.path();
    let crl = Some(Authority::list_path(ca.0.path()));
    Server::start_with(|o| {
        o.worker_tls = Some(WorkerTls { listen, certificate, key, client_ca, crl });
    })
    .await
}

/// A channel of a worker to a URL of the server.
fn link(url: String, tls: Option<Arc<ClientConfig>>) -> WorkerLinkClient<Channel> {
    let connector = Connector::new(SOON);
    let connector = match tls {
        Some(tls) => connector.with_tls(move || tls.clone()),
        None => connector,
    };
    let endpoint = Endpoint::from_shared(url).unwrap();
    WorkerLinkClient::new(endpoint.connect_with_connector_lazy(connector))
}

/// Registers a worker at a URL of the server.
async fn register(
    url: String,
    tls: Option<Arc<ClientConfig>>,
    token: &str,
    endpoint: &str,
) -> Result<(), Status> {
    register_over(&mut link(url, tls), token, endpoint).await
}

/// Registers a new worker over a channel.
async fn register_over(
    link: &mut WorkerLinkClient<Channel>,
    token: &str,
    endpoint: &str,
) -> Result<(), Status> {
    let (key, id) = worker_key::generate();
    let mut request = Request::new(RegisterRequest {
        worker: id.to_string(),
        endpoint: endpoint.to_owned(),
        ..RegisterRequest::default()
    });
    let entries = request.metadata_mut();
    entries.insert("authorization", format!("Bearer {token}").parse().unwrap());
    entries.insert(worker_key::METADATA, key.parse().unwrap());
    link.register(request).await.map(drop)
}

#[tokio::test]
async fn workers_show_a_certificate_of_the_authority() {
    let (ours, theirs) = (Ca::new(), Ca::new());
    let server = with_workers(&ours).await;
    let address = server.handle.worker_tls_addr().unwrap();
    let url = || format!("https://{address}");
    let endpoint = "https://127.0.0.1:1";

    let mut without = client_config(Some(&ours.path())).unwrap();
    without.alpn_protocols = vec![b"h2".to_vec()];
    for (tls, what) in [
        (Arc::new(without), "demands a certificate"),
        (theirs.worker("gpu1", 1, &ours), "another authority"),
        (ours.worker("gpu2", -1, &ours), "has expired"),
    ] {
        let refused = register(url(), Some(tls), TOKEN, endpoint).await.unwrap_err();
        let found = TlsError::find(&refused, "the server");
        let found = found.unwrap_or_else(|| panic!("{what}: {refused:?}")).to_string();
        assert!(found.contains(what), "{found}");
    }
    let plain = register(format!("http://{address}"), None, TOKEN, endpoint).await.unwrap_err();
    assert_eq!(fault::fault(&plain).reason, "TLS_REQUIRED");

    let good = ours.worker("gpu3", 1, &ours);
    let stranger = register(url(), Some(good.clone()), "a-token-of-others", endpoint).await;
    assert_eq!(stranger.unwrap_err().code(), Code::Unauthenticated);
    let clear = register(url(), Some(good.clone()), TOKEN, "http://127.0.0.1:1").await;
    assert_eq!(clear.unwrap_err().code(), Code::InvalidArgument);
    register(url(), Some(good), TOKEN, endpoint).await.unwrap();
    let counted = r#"bendtwin_connections_ended_total{listener="workers_tls",why="handshake"} 3"#;
    assert!(metrics(&server).await.contains(counted));

    // The clients' address is no way around it.
    let around = register(server.url(""), None, TOKEN, "http://127.0.0.1:1").await.unwrap_err();
    assert_eq!(around.code(), Code::Unimplemented, "{around:?}");
}

#[tokio::test]
async fn a_revoked_worker_is_cut_off_and_refused() {
    let ca = Ca::new();
    let server = with_workers(&ca).await;
    let url = format!("https://{}", server.handle.worker_tls_addr().unwrap());
    let (leaver, stayer) = (ca.worker("gpu1", 1, &ca), ca.worker("gpu2", 1, &ca));
    let endpoint = "https://127.0.0.1:1";
    let (mut leaving, mut staying) = (link(url.clone(), Some(leaver)), link(url, Some(stayer)));
    register_over(&mut staying, TOKEN, endpoint).await.unwrap();
    register_over(&mut leaving, TOKEN, endpoint).await.unwrap();

    ca.revoke("gpu1");
    // Over the same connection, until it ends.
    let cut_off = async {
        while register_over(&mut leaving, TOKEN, endpoint).await.is_ok() {
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    };
    timeout(SOON, cut_off).await.expect("the revoked worker may continue");
    let refused = register_over(&mut leaving, TOKEN, endpoint).await.unwrap_err();
    let found = TlsError::find(&refused, "the server").unwrap();
    assert!(found.to_string().contains("was revoked"), "{found}");
    let ended = r#"bendtwin_connections_ended_total{listener="workers_tls",why="certificate"} 1"#;
    assert!(metrics(&server).await.contains(ended), "{}", metrics(&server).await);
    register_over(&mut staying, TOKEN, endpoint).await.unwrap();
}

#[tokio::test]
async fn a_server_says_what_is_wrong_with_its_files() {
    let ca = Ca::new();
    let (one, other) = (ca.issue("one", 1), ca.issue("other", 1));
    let dir = tempfile::tempdir().unwrap();
    let mut options = crate::harness::options(&dir);
    options.tls = Some(Tls { certificate: one.certificate, key: other.key });
    let error = bendtwin_server::Service::start(options.clone()).await.unwrap_err();
    assert!(error.to_string().contains("made together"), "{error}");
    options.tls = None;
    let crl = dir.path().join("crl.pem");
    std::fs::write(&crl, "no list").unwrap();
    let PairPaths { certificate, key } = ca.issue("two", 1);
    let (listen, client_ca) = (([127, 0, 0, 1], 0).into(), ca.path());
    options.worker_tls =
        Some(WorkerTls { listen, certificate, key, client_ca, crl: Some(crl.clone()) });
    let error = bendtwin_server::Service::start(options.clone()).await.unwrap_err();
    assert!(error.to_string().contains("no revocation list"), "{error}");
    options.worker_tls = None;
    assert!(!options.data_dir.exists());
    options.tls = None;
    options.listen = ([0, 0, 0, 0], 0).into();
    let open = bendtwin_server::Service::start(options).await.unwrap_err();
    assert!(open.to_string().contains("--tls-certificate"), "{open}");
}
