use bytes::Bytes;
use futures::TryStreamExt;

use crate::{
    Digest, Error,
    database::testing::{On, on_both},
    store::tests::{Bench, new_capture},
};

on_both! {
    content_reads_back_unchanged,
    refuses_too_much_and_the_wrong_digest,
    equal_content_is_shared_until_the_last_reference_goes,
    content_of_another_size_is_refused,
    changed_content_never_arrives_whole,
    ranges_are_the_bytes_asked_for,
}

async fn content_reads_back_unchanged(on: On) {
    let bench = Bench::new(on).await;
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

async fn refuses_too_much_and_the_wrong_digest(on: On) {
    let bench = Bench::new(on).await;
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
    // In a folder that servers share it may be another's that is under way.
    let alone = bench.postgres.is_none();
    assert!(!alone || !bench.dir.path().join("blobs/incoming").exists());
}

async fn equal_content_is_shared_until_the_last_reference_goes(on: On) {
    let bench = Bench::new(on).await;
    let (a, b) = (bench.capture("same").await, bench.capture("same").await);
    assert_eq!(bench.blob_count().await, 1);
    bench.store.captures().delete(a.id).await.unwrap();
    let (_, content) = bench.store.captures().content(b.id).await.unwrap();
    bench.store.captures().delete(b.id).await.unwrap();
    assert_eq!(bench.blob_count().await, 0);
    // Open readers are not affected.
    assert_eq!(content.chunks.try_collect::<Vec<_>>().await.unwrap().concat(), b"same");
}

/// Content of more than one chunk, and its capture.
async fn large(bench: &Bench) -> (Vec<u8>, crate::Capture) {
    let content: Vec<u8> = (0..3_000_000u32).map(|i| (i % 251) as u8).collect();
    let mut upload = bench.store.blobs().upload(1 << 30).await.unwrap();
    upload.write(Bytes::copy_from_slice(&content)).await.unwrap();
    let staged = upload.finish(None).await.unwrap();
    (content, bench.store.captures().create(new_capture("", staged)).await.unwrap())
}

async fn content_of_another_size_is_refused(on: On) {
    let bench = Bench::new(on).await;
    let (content, capture) = large(&bench).await;
    for size in [0, 1, content.len() - 1, content.len() + 1] {
        let mut other = content.clone();
        other.resize(size, 0);
        bench.damage(&capture.digest, Some(other)).await;
        let refused = bench.store.captures().content(capture.id).await.unwrap_err();
        assert!(matches!(refused, Error::ContentDamaged { .. }), "{size}: {refused}");
    }
    bench.damage(&capture.digest, None).await;
    let refused = bench.store.captures().content(capture.id).await.unwrap_err();
    assert!(matches!(refused, Error::ContentLost { .. }), "{refused}");
}

async fn changed_content_never_arrives_whole(on: On) {
    let bench = Bench::new(on).await;
    let (content, capture) = large(&bench).await;
    for at in [0, content.len() / 2, content.len() - 1] {
        let mut other = content.clone();
        other[at] ^= 1;
        bench.damage(&capture.digest, Some(other)).await;
        let (_, mut read) = bench.store.captures().content(capture.id).await.unwrap();
        let mut got = 0;
        let end = loop {
            match read.chunks.try_next().await {
                Ok(Some(chunk)) => got += chunk.len(),
                end => break end,
            }
        };
        assert!(matches!(end, Err(Error::ContentDamaged { .. })), "{at}: {end:?}");
        assert!(got < content.len());
    }
    // Content of one chunk is refused before any of it is sent.
    let small = bench.capture("small").await;
    bench.damage(&small.digest, Some(b"Small".to_vec())).await;
    let refused = bench.store.captures().content(small.id).await.unwrap_err();
    assert!(matches!(refused, Error::ContentDamaged { .. }), "{refused}");
}

async fn ranges_are_the_bytes_asked_for(on: On) {
    let bench = Bench::new(on).await;
    let (content, capture) = large(&bench).await;
    let end = content.len() as u64;
    for range in [0..1, 5..2_000_005, end - 1..end, 0..end, 7..2 * end] {
        let (_, read) = bench.store.captures().content(capture.id).await.unwrap();
        let part = read.range(range.clone()).await.unwrap();
        assert_eq!((part.size_bytes, part.digest), (end, capture.digest));
        let got = part.chunks.try_collect::<Vec<_>>().await.unwrap().concat();
        assert_eq!(got, content[range.start as usize..range.end.min(end) as usize], "{range:?}");
    }
    let (_, read) = bench.store.captures().content(capture.id).await.unwrap();
    assert!(read.range(end..end + 1).await.is_err());
    let empty = bench.capture("").await;
    let (_, read) = bench.store.captures().content(empty.id).await.unwrap();
    assert!(read.chunks.try_collect::<Vec<_>>().await.unwrap().is_empty());
}
