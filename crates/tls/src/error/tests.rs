use std::{sync::Arc, time::Duration};

use tokio::{
    io::{AsyncReadExt as _, AsyncWriteExt as _},
    net::TcpListener,
};
use tower::Service as _;

use super::*;
use crate::{Accepted, Connector, Mutual, MutualPaths, Public, client_config, tests::Folder};

const LIMIT: Duration = Duration::from_secs(20);

/// Calls a listener that shows a certificate; the error of the call.
async fn call(certificate: &Folder, trusted: &Folder, host: &str) -> Option<TlsError> {
    let server = Public::load(&certificate.issue("twin")).unwrap().server;
    let listener = TcpListener::bind((host, 0)).await.unwrap();
    let port = listener.local_addr().unwrap().port();
    tokio::spawn(async move {
        let (stream, _) = listener.accept().await.unwrap();
        let _ = Accepted::shake_hands(server, stream).await;
    });
    let client = Arc::new(client_config(Some(&trusted.ca())).unwrap());
    let mut connector = Connector::new(LIMIT).with_tls(move || client.clone());
    let called = connector.call(format!("https://{host}:{port}").parse().unwrap()).await;
    called.err().map(|error| TlsError::find(&error, "-").unwrap())
}

#[tokio::test]
async fn what_is_wrong_with_a_server_is_said() {
    let (ours, theirs) = (Folder::new(), Folder::new());
    assert_eq!(call(&ours, &ours, "127.0.0.1").await, None);
    let unknown = call(&ours, &theirs, "127.0.0.1").await.unwrap();
    assert!(unknown.message.contains("--ca FILE"), "{unknown}");
    assert_eq!(unknown.reason(), "TLS_CERTIFICATE_REFUSED");
    let name = call(&ours, &ours, "127.0.0.2").await.unwrap();
    let names = "for twin, localhost, 127.0.0.1";
    assert!(name.message.contains("127.0.0.2") && name.message.contains(names), "{name}");
    let late = Folder { days: -1, ..Folder::new() };
    let expired = call(&late, &late, "127.0.0.1").await.unwrap();
    assert!(expired.message.contains("has expired"), "{expired}");
}

#[tokio::test]
async fn servers_without_tls_are_named() {
    for answer in [&b"HTTP/1.1 400 Bad Request\r\n\r\n"[..], b""] {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        tokio::spawn(async move {
            let (mut stream, _) = listener.accept().await.unwrap();
            stream.read_u8().await.unwrap();
            stream.write_all(answer).await.unwrap();
            stream.shutdown().await.unwrap();
            // Until the client has read the answer.
            let _ = stream.read_to_end(&mut Vec::new()).await;
        });
        let client = Arc::new(client_config(None).unwrap());
        let mut connector = Connector::new(LIMIT).with_tls(move || client.clone());
        let called = connector.call(format!("https://{address}").parse().unwrap()).await;
        let found = TlsError::find(&called.unwrap_err(), "-").unwrap();
        assert_eq!(found.reason(), "TLS_NOT_SPOKEN", "{found}");
        assert!(found.message.contains("http://"), "{found}");
    }
    let mut without = Connector::new(LIMIT);
    let called = without.call("https://127.0.0.1:9".parse().unwrap()).await;
    assert!(called.is_err());
}

#[tokio::test]
async fn what_is_wrong_with_the_own_certificate_is_said() {
    let (ours, theirs) = (Folder::new(), Folder::new());
    let load = |folder: &Folder, name: &str| {
        Mutual::load(&MutualPaths { pair: folder.issue(name), ca: ours.ca(), crl: None }).unwrap()
    };
    let server = load(&ours, "twin").server;
    let late = Folder { days: -1, dir: ours.dir.clone() };
    for (client, what) in [
        (Arc::new(client_config(Some(&ours.ca())).unwrap()), "demands a certificate"),
        (load(&theirs, "gpu1").client, "another authority"),
        (load(&late, "gpu2").client, "has expired"),
    ] {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let server = server.clone();
        let refused = tokio::spawn(async move {
            let (stream, _) = listener.accept().await.unwrap();
            Accepted::shake_hands(server, stream).await.is_err()
        });
        let mut connector = Connector::new(LIMIT).with_tls(move || client.clone());
        let stream = connector.call(format!("https://{address}").parse().unwrap()).await.unwrap();
        // The client hears of it when it reads: in TLS 1.3 its own part is over by then.
        let error = stream.into_inner().read_u8().await.unwrap_err();
        assert!(refused.await.unwrap());
        let found = TlsError::find(&error, "the server").unwrap();
        assert_eq!(found.reason(), "TLS_CLIENT_CERTIFICATE_REFUSED", "{found}");
        assert!(found.message.contains(what), "{found}");
    }
}
