use bytes::Bytes;
use futures::TryStreamExt;

use crate::{
    Digest, Error,
    store::tests::{Bench, new_capture},
};

#[tokio::test]
async fn content_comes_back_as_it_was() {
    let bench = Bench::new().await;
    let content: Vec<u8> = (0..20_000_000u32).map(|i| (i % 251) as u8).collect();
    let mut upload = bench.store.blobs().upload(1 << 30).await.unwrap();
    for chunk in content.chunks(777_777) {
        upload.write(Bytes::copy_from_slice(chunk)).await.unwrap();
    }
    let content_digest = blake3::hash(&content);
    let staged = upload.finish(Some(content_digest)).await.unwrap();
    let new = new_capture("", staged);
    let capture = bench.store.captures().create(new).await.unwrap();
    assert_eq!((capture.size_bytes, capture.digest), (20_000_000, content_digest));
    let (_, read) = bench.store.captures().content(capture.id).await.unwrap();
    assert_eq!(read.size_bytes, 20_000_000);
    let chunks: Vec<Bytes> = read.chunks.try_collect().await.unwrap();
    assert!(chunks.concat() == content);
}

#[tokio::test]
async fn refuses_too_much_and_the_wrong_digest() {
    let bench = Bench::new().await;
    let mut upload = bench.store.blobs().upload(4).await.unwrap();
    upload.write(Bytes::from_static(b"1234")).await.unwrap();
    let over = upload.write(Bytes::from_static(b"5")).await;
    assert!(matches!(over, Err(Error::TooLarge { limit: 4 })));
    drop(upload);
    let mut upload = bench.store.blobs().upload(4).await.unwrap();
    upload.write(Bytes::from_static(b"1234")).await.unwrap();
    let wrong = upload.finish(Some(Digest::from_bytes([7; 32]))).await;
    assert!(matches!(wrong, Err(Error::DigestMismatch { .. })));
    let bench = bench.reopen().await;
    assert_eq!(bench.blob_count().await, 0);
    assert!(!bench.dir.path().join("blobs/incoming").exists());
}

#[tokio::test]
async fn equal_content_is_shared_until_the_last_reference_goes() {
    let bench = Bench::new().await;
    let (a, b) = (bench.capture("same").await, bench.capture("same").await);
    assert_eq!(bench.blob_count().await, 1);
    bench.store.captures().delete(a.id).await.unwrap();
    let (_, content) = bench.store.captures().content(b.id).await.unwrap();
    bench.store.captures().delete(b.id).await.unwrap();
    assert_eq!(bench.blob_count().await, 0);
    // Open readers are not affected.
    assert_eq!(content.chunks.try_collect::<Vec<_>>().await.unwrap().concat(), b"same");
}
