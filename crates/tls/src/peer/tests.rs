use std::time::Duration;

use tokio::{
    io::{AsyncReadExt as _, AsyncWriteExt as _},
    net::TcpListener,
    time::timeout,
};
use tower::Service as _;

use super::*;
use crate::{Accepted, Connector, MutualPaths, Stream, tests::Folder};

const LIMIT: Duration = Duration::from_secs(20);

fn load(paths: &MutualPaths) -> Reloaded<Mutual> {
    let files = paths.clone();
    Reloaded::new(paths.all(), move || Mutual::load(&files)).unwrap()
}

/// A connection of two peers: the side that was called, and the one that called.
async fn connect(called: &Reloaded<Mutual>, calling: &Reloaded<Mutual>) -> (Stream, Stream) {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let url = format!("https://{}", listener.local_addr().unwrap());
    let settings = called.clone();
    let accepting = tokio::spawn(async move {
        let (stream, _) = listener.accept().await.unwrap();
        let accepted = Accepted::shake_hands(settings.get().server.clone(), stream).await;
        accepted.unwrap().among_peers(settings)
    });
    let mut connector = Connector::new(LIMIT).with_peer(calling.clone());
    let mut begun = connector.call(url.parse().unwrap()).await.unwrap().into_inner();
    let mut accepted = accepting.await.unwrap();
    // Both have begun to use it.
    begun.write_u8(1).await.unwrap();
    assert_eq!(accepted.read_u8().await.unwrap(), 1);
    (accepted, begun)
}

/// End of the wait of one side for the other one.
async fn end(stream: &mut Stream) -> TlsError {
    let error = timeout(LIMIT, stream.read_u8()).await.expect("it stays open").unwrap_err();
    TlsError::find(&error, "-").unwrap_or_else(|| panic!("{error:?}"))
}

#[tokio::test]
async fn a_revoked_peer_is_cut_off_on_either_side() {
    let folder = Folder::new();
    let (server, worker) = (load(&folder.peer("twin")), load(&folder.peer("gpu1")));
    // The server alone reads the list again.
    let (mut accepted, mut calling) = connect(&server, &worker).await;
    let (_accepted, mut begun) = connect(&worker, &server).await;
    folder.issue("gpu2");
    folder.revoke(&["gpu2"]);
    assert!(server.refresh());
    // Another one's revocation changes nothing.
    calling.write_u8(2).await.unwrap();
    assert_eq!(accepted.read_u8().await.unwrap(), 2);
    folder.revoke(&["gpu1"]);
    assert!(server.refresh());
    for stream in [&mut accepted, &mut begun] {
        let found = end(stream).await;
        assert!(found.to_string().contains("was revoked"), "{found}");
    }
}

#[tokio::test]
async fn a_revoked_peer_is_refused_at_the_handshake() {
    let folder = Folder::new();
    let (server, worker) = (load(&folder.peer("twin")), load(&folder.peer("gpu1")));
    folder.revoke(&["gpu1"]);
    assert!(server.refresh());
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let url = format!("https://{}", listener.local_addr().unwrap());
    let settings = server.get().server.clone();
    let accepting = tokio::spawn(async move {
        let (stream, _) = listener.accept().await.unwrap();
        Accepted::shake_hands(settings, stream).await.map(drop)
    });
    let mut connector = Connector::new(LIMIT).with_peer(worker.clone());
    let mut begun = connector.call(url.parse().unwrap()).await.unwrap().into_inner();
    let reported = end(&mut begun).await;
    assert!(reported.to_string().contains("which was revoked"), "{reported}");
    assert!(accepting.await.unwrap().unwrap_err().to_string().contains("Revoked"));

    // And so it is when it is called.
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let url = format!("https://{}", listener.local_addr().unwrap());
    tokio::spawn(async move {
        let (stream, _) = listener.accept().await.unwrap();
        let _ = Accepted::shake_hands(worker.get().server.clone(), stream).await;
    });
    let refused = Connector::new(LIMIT).with_peer(server).call(url.parse().unwrap()).await;
    let refused = TlsError::find(&refused.unwrap_err(), "-").unwrap();
    assert!(refused.to_string().contains("was revoked by its authority"), "{refused}");
}

#[tokio::test]
async fn a_list_that_cannot_be_used_leaves_the_one_before_in_force() {
    let folder = Folder::new();
    let server = load(&folder.peer("twin"));
    folder.issue("gpu1");
    folder.revoke(&["gpu1"]);
    assert!(server.refresh());
    std::fs::write(folder.crl(), "no list").unwrap();
    assert!(!server.refresh());
    std::fs::remove_file(folder.crl()).unwrap();
    assert!(!server.refresh());
    assert_eq!(server.get().lists[0].revoked.len(), 1);
}
