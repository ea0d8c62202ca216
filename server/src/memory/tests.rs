use axum::body::Body;
use bendtwin_contract::rollout;
use bendtwin_core::Problem as _;
use bytes::Bytes;
use futures::stream;

use super::*;

const MIB: u64 = 1 << 20;

fn chunked(chunks: Vec<Bytes>) -> Body {
    Body::from_stream(stream::iter(chunks.into_iter().map(Ok::<_, std::io::Error>)))
}

fn unseen(_: &[u8]) -> Result<(), rollout::Error> {
    Ok(())
}

/// A body that sends some bytes and then nothing.
fn stuck(first: Vec<u8>) -> Body {
    use futures::StreamExt as _;
    let first = stream::iter([Ok::<_, std::io::Error>(Bytes::from(first))]);
    Body::from_stream(first.chain(stream::pending()))
}

#[tokio::test]
async fn a_declared_body_takes_its_memory_before_it_is_read() {
    let memory = Memory::new(64 * MIB);
    let received =
        memory.receive(Body::from(vec![1; 1000]), Kind::Json, MIB, unseen).await.unwrap();
    assert_eq!((received.bytes.len(), memory.state().0), (1000, 8192));
    // Once it is decoded the text is gone.
    received.memory.decoded(1000);
    assert_eq!(memory.state().0, 4096);
    drop(received);
    assert_eq!(memory.state().0, 0);
    // 21 MiB are given to one body: 2.6 MiB of JSON.
    let body = Body::from(vec![1; 4 << 20]);
    let refused = memory.receive(body, Kind::Json, 16 * MIB, unseen).await.unwrap_err();
    let ReceiveError::Memory(error) = refused else { panic!("{refused:?}") };
    assert!(error.to_string().contains("at most 22020096"), "{error}");
    let body = Body::from(vec![1; 2000]);
    let refused = memory.receive(body, Kind::Json, 1000, unseen).await.unwrap_err();
    assert!(matches!(refused, ReceiveError::TooLong), "{refused:?}");
}

#[tokio::test]
async fn a_body_of_unknown_length_takes_memory_in_steps() {
    let memory = Memory::new(64 * MIB);
    let chunks = vec![Bytes::from(vec![7; 50_000]); 20];
    let received = memory.receive(chunked(chunks), Kind::Protobuf, 2 * MIB, unseen).await.unwrap();
    assert!(received.bytes.len() == 1_000_000 && received.bytes.iter().all(|b| *b == 7));
    let used = memory.state().0;
    assert!((3_000_000..7_000_000).contains(&used), "{used}");
    let chunks = vec![Bytes::from(vec![7; 50_000]); 20];
    let refused =
        memory.receive(chunked(chunks), Kind::Protobuf, 900_000, unseen).await.unwrap_err();
    assert!(matches!(refused, ReceiveError::TooLong), "{refused:?}");
}

#[tokio::test]
async fn a_grpc_message_takes_its_memory_when_its_length_is_known() {
    let memory = Memory::new(64 * MIB);
    let message = |length: u32| [&[0][..], &length.to_be_bytes()].concat();
    // In pieces of any size, and what follows is left out.
    let bytes = [message(10), vec![9; 20]].concat();
    for size in [1, 3, 7, 40] {
        let chunks = bytes.chunks(size).map(Bytes::copy_from_slice).collect();
        let received = memory.receive_message(chunked(chunks), MIB, unseen).await.unwrap();
        assert_eq!(received.bytes, bytes[..15], "{size}");
    }
    // Memory for the whole is taken as soon as the first bytes have arrived.
    let body = stuck(message(1 << 20));
    let waiting = memory.receive_message(body, MIB, unseen);
    assert!(tokio::time::timeout(Duration::from_millis(50), waiting).await.is_err());
    let mut waiting = Box::pin(memory.receive_message(stuck(message(1 << 20)), MIB, unseen));
    assert!(futures::poll!(&mut waiting).is_pending());
    assert!(memory.state().0 >= 3 * MIB, "{}", memory.state().0);
    drop(waiting);
    // One that is too long is refused by the service: nothing of it is read.
    let received = memory.receive_message(stuck(message(u32::MAX)), MIB, unseen).await.unwrap();
    assert_eq!(received.bytes, message(u32::MAX));
}

/// A fault in the beginning is reported without waiting for the rest.
#[tokio::test]
async fn a_body_is_refused_before_it_has_come() {
    let memory = Memory::new(64 * MIB);
    let look = |beginning: &[u8]| match beginning.get(..3) {
        Some([7, 7, 7]) => Err(rollout::Error::field("actions", "are too many")),
        _ => Ok(()),
    };
    let refused = memory.receive(stuck(vec![7; 100]), Kind::Protobuf, MIB, look).await;
    assert!(matches!(refused, Err(ReceiveError::Refused(_))), "{refused:?}");
    let message = [&[0][..], &(1u32 << 19).to_be_bytes(), &[7; 100]].concat();
    let refused = memory.receive_message(stuck(message), MIB, look).await;
    assert!(matches!(refused, Err(ReceiveError::Refused(_))), "{refused:?}");
    assert_eq!(memory.state().0, 0);
    // One that is compressed is not looked into.
    let message = [&[1][..], &100u32.to_be_bytes(), &[7; 100]].concat();
    assert!(memory.receive_message(stuck(message), MIB, look).await.is_ok());
}

#[tokio::test]
async fn waiting_for_memory_ends() {
    let longest_wait = Duration::from_millis(20);
    let memory = Memory { longest_wait, ..Memory::new(64 * MIB) };
    let held = memory.receive(Body::from(vec![0; 6 << 20]), Kind::Protobuf, 16 * MIB, unseen).await;
    let refused =
        memory.receive(Body::from(vec![0; 6 << 20]), Kind::Protobuf, 16 * MIB, unseen).await;
    let ReceiveError::Memory(error) = refused.unwrap_err() else { panic!() };
    assert!(error.retry_after().is_some(), "{error}");
    // Replies do not wait for bodies.
    memory.reply(4 * MIB).await.unwrap();
    // Neither do small bodies.
    memory.receive(Body::from(vec![0; 1000]), Kind::Document, MIB, unseen).await.unwrap();
    drop(held);
    memory.receive(Body::from(vec![0; 6 << 20]), Kind::Protobuf, 16 * MIB, unseen).await.unwrap();
}
