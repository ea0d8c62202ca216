//! A capture that cannot be fitted ends its fit at the first attempt, with a reason that its owner
//! can act on, and harms nothing else.

use std::{
    collections::BTreeMap,
    io::{Cursor, Read as _, Write as _},
    time::Duration,
};

use bendtwin_proto::v1::job::State;
use bytes::Bytes;
use zip::{CompressionMethod, ZipArchive, ZipWriter, write::SimpleFileOptions};

use crate::harness::{
    TestCluster,
    api::has_ended,
    reference::{SETTINGS, capture},
};

const MANIFEST: &str = "capture.json";

/// The fault, the archive, the expected reason.
type Case = (&'static str, Bytes, &'static str);

#[tokio::test]
async fn broken_captures_end_their_fits_with_a_reason() {
    let server = TestCluster::ordinary().await;
    let api = server.api();
    let cases = cases(&capture().await);
    let mut fits = Vec::new();
    for (what, archive, reason) in cases {
        let stored = api.upload(&archive, "").await.unwrap();
        let fit = api.fit(&stored.name, SETTINGS, 0).await.unwrap();
        fits.push((what, reason, fit.name));
    }
    let mut wrong = Vec::new();
    for (what, reason, name) in &fits {
        let fit = api.fit_when(name, "over", Duration::from_secs(60), has_ended).await;
        let job = fit.job.clone().unwrap_or_default();
        let fault = job.fault.unwrap_or_default();
        // No worker ever had the fit: the capture's ingest failed.
        if fit.state() != State::Failed || fault.reason != *reason || job.attempts != 0 {
            wrong.push(format!("{what}: expected {reason}, got {:?} {fault:?}", fit.state()));
        }
        let told_well = fault.message.len() > 20 && !fault.message.contains("panicked");
        if !told_well {
            wrong.push(format!("{what}: the message tells too little: {:?}", fault.message));
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
    let captures = api.list_captures().await.unwrap();
    assert!(captures.iter().all(|c| c.ingest.as_ref().is_some_and(|i| i.attempts == 1)));
    assert!(captures.iter().all(|c| c.verdict == "unusable"), "there is a report in any case");
    assert_eq!(api.list_twins().await.unwrap(), []);
    println!("{} broken captures explained", fits.len());
}

fn cases(good: &Bytes) -> Vec<Case> {
    let files = unpack(good);
    let manifest = String::from_utf8(files[MANIFEST].clone()).unwrap();
    let document: serde_json::Value = serde_json::from_str(&manifest).unwrap();
    let declared = |edit: &dyn Fn(&mut serde_json::Map<String, serde_json::Value>)| {
        let mut document = document.clone();
        edit(document.as_object_mut().unwrap());
        with(&files, MANIFEST, Some(document.to_string().into_bytes()))
    };
    let points = files.keys().find(|name| name.ends_with("object_points.npy")).unwrap().clone();
    let array = &files[&points];
    let patched = |from: &str, to: &str| {
        let at = array.windows(from.len()).position(|part| part == from.as_bytes()).unwrap();
        let mut bytes = array.clone();
        bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
        with(&files, &points, Some(bytes))
    };
    let noise = (0..10_000u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8);
    vec![
        ("noise", noise.collect(), "UNKNOWN_CAPTURE_KIND"),
        ("half an archive", good.slice(..good.len() / 2), "ARCHIVE_DAMAGED"),
        ("an empty archive", pack(&BTreeMap::new()), "UNKNOWN_CAPTURE_KIND"),
        ("no manifest", with(&files, MANIFEST, None), "UNKNOWN_CAPTURE_KIND"),
        (
            "half a manifest",
            {
                let half = manifest.as_bytes()[..manifest.len() / 2].to_vec();
                with(&files, MANIFEST, Some(half))
            },
            "INVALID_DOCUMENT",
        ),
        ("no up axis", declared(&|d| drop(d.remove("up_axis"))), "INVALID_AXES"),
        ("a left-handed frame", declared(&|d| set(d, "handedness", "left")), "INVALID_AXES"),
        ("furlongs", declared(&|d| set(d, "units", "furlong")), "UNKNOWN_UNITS"),
        (
            "the next version",
            { declared(&|d| drop(d.insert("version".to_owned(), 99.into()))) },
            "UNSUPPORTED_VERSION",
        ),
        ("no points", with(&files, &points, None), "MISSING_FILE"),
        (
            "half the points",
            {
                let half = array[..array.len() / 2].to_vec();
                with(&files, &points, Some(half))
            },
            "HEADER_CLAIMS_TOO_MUCH",
        ),
        ("complex numbers", patched("<f4", "<c8"), "WRONG_DTYPE"),
        (
            "a decompression bomb",
            { with(&files, &points, Some(vec![0; 64 << 20])) },
            "ARCHIVE_BOMB",
        ),
        (
            "a name that leaves the archive",
            { with(&files, "../../outside.npy", Some(vec![1])) },
            "ARCHIVE_UNSAFE_NAME",
        ),
        (
            "two captures",
            {
                let inside = |folder| {
                    let files = files.iter();
                    files.map(move |(name, content)| (format!("{folder}/{name}"), content.clone()))
                };
                pack(&inside("first").chain(inside("second")).collect())
            },
            "SEVERAL_CAPTURES",
        ),
    ]
}

fn set(document: &mut serde_json::Map<String, serde_json::Value>, key: &str, value: &str) {
    document.insert(key.to_owned(), value.into());
}

pub(crate) fn unpack(archive: &Bytes) -> BTreeMap<String, Vec<u8>> {
    let mut archive = ZipArchive::new(Cursor::new(archive)).unwrap();
    let count = archive.len();
    let read = |i| {
        let mut entry = archive.by_index(i).unwrap();
        let mut content = Vec::new();
        entry.read_to_end(&mut content).unwrap();
        (entry.name().unwrap().into_owned(), content)
    };
    (0..count).map(read).collect()
}

/// The archive with one file replaced, added or left out.
fn with(files: &BTreeMap<String, Vec<u8>>, name: &str, content: Option<Vec<u8>>) -> Bytes {
    let mut files = files.clone();
    match content {
        Some(content) => drop(files.insert(name.to_owned(), content)),
        None => drop(files.remove(name)),
    }
    pack(&files)
}

pub(crate) fn pack(files: &BTreeMap<String, Vec<u8>>) -> Bytes {
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    for (name, content) in files {
        writer.start_file(name.as_str(), options).unwrap();
        writer.write_all(content).unwrap();
    }
    writer.finish().unwrap().into_inner().into()
}
