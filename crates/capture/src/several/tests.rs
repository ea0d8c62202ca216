use std::io::Cursor;

use bendtwin_synth::{MakeOptions, Scene, make};

use super::*;
use crate::{
    Limits,
    check::testing::{FileMap, bundle, pack},
    digest, read_bytes, write_bundle,
};

/// A recording with its points moved.
fn recording(name: &str, by: f32) -> Capture {
    let made = make(Scene::Rope, &MakeOptions::tiny(3)).unwrap();
    let mut capture = Capture { name: name.into(), ..made };
    capture.sequences[0].points.iter_mut().for_each(|p| p[0] += by);
    capture
}

fn several() -> Capture {
    let others = vec![recording("drag", 0.1), recording("shake", 0.2)];
    Capture { others, ..recording("lift", 0.0) }
}

fn bytes(capture: &Capture) -> Vec<u8> {
    write_bundle(capture, Cursor::new(Vec::new())).unwrap().into_inner()
}

/// A document beside these folders with a recording each.
fn packed(document: &str, folders: &[&str]) -> Vec<u8> {
    let mut files = FileMap::new();
    files.insert("toy/recordings.json".into(), document.into());
    for folder in folders {
        let own = bundle(&recording(folder, 0.1));
        files.extend(own.into_iter().map(|(name, bytes)| (format!("toy/{folder}/{name}"), bytes)));
    }
    pack(&files)
}

#[test]
fn several_recordings_are_written_and_read() {
    let capture = several();
    let read = read_bytes("lift", &bytes(&capture), &Limits::default()).unwrap();
    assert!(read == capture, "{} recordings", read.others.len());
    assert_eq!(digest(&read), digest(&capture));
    // The others count; a single recording has the digest that it always had.
    let alone = Capture { others: Vec::new(), ..capture.clone() };
    assert_ne!(digest(&alone), digest(&capture));
    assert_eq!(digest(&alone), digest(&recording("another name", 0.0)));
    assert_eq!(bytes(&capture), bytes(&read));
    // It is no second format beside the document that names it.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lift.zip");
    std::fs::write(&path, bytes(&capture)).unwrap();
    let Opened::Several(parts) = crate::open(&path, &Limits::default()).unwrap() else {
        panic!("not several")
    };
    let is_taken = |part: &Part| match &part.opened {
        Opened::Observed(_, notes) => notes.findings.iter().any(|note| note.code == "FORMAT_TAKEN"),
        _ => true,
    };
    assert!(!parts.iter().any(is_taken));
    // The reference lies where a reader of a single recording looks.
    let mut files = bundle(&capture);
    assert!(files.remove("recordings.json").is_some());
    files.retain(|name, _| !name.starts_with("recording-"));
    let reference = read_bytes("lift", &pack(&files), &Limits::default()).unwrap();
    assert_eq!(digest(&reference), digest(&alone));
}

#[test]
fn folders_are_recordings_by_name() {
    let document = r#"{"format": "bendtwin-recordings", "version": 1}"#;
    let capture =
        read_bytes("toys", &packed(document, &["b", "a", ".git"]), &Limits::default()).unwrap();
    let names: Vec<&str> = capture.others.iter().map(|r| r.name.as_str()).collect();
    assert_eq!((capture.name.as_str(), names.as_slice()), ("toy", ["b"].as_slice()));
    assert!(capture.recordings().all(|r| !r.sequences[0].is_held_out()));
}

#[test]
fn the_document_orders_names_and_holds_out() {
    let document = r#"{"format": "bendtwin-recordings", "version": 1, "recordings": [
        {"folder": "b"}, {"folder": "a", "name": "the first try", "held_out": true}]}"#;
    let zip = packed(document, &["a", "b", "c"]);
    let capture = read_bytes("toys", &zip, &Limits::default()).unwrap();
    assert_eq!(capture.others.len(), 1);
    assert_eq!(capture.others[0].name, "the first try");
    assert!(capture.others[0].sequences[0].is_held_out());
    // The same from a folder on disk.
    let root = tempfile::tempdir().unwrap();
    let mut archive = zip::ZipArchive::new(Cursor::new(zip)).unwrap();
    archive.extract(root.path()).unwrap();
    let Opened::Several(parts) = crate::open(root.path(), &Limits::default()).unwrap() else {
        panic!("not several")
    };
    let names: Vec<_> = parts.iter().map(|p| (p.name.as_str(), p.held_out)).collect();
    assert_eq!(names, [("b", false), ("the first try", true)]);
    let read = crate::read(root.path(), &Limits::default()).unwrap();
    assert!(read == capture, "{} recordings", read.others.len());
}

#[test]
fn wrong_documents_are_refused() {
    let refused = |document: &str, folders: &[&str]| {
        read_bytes("toys", &packed(document, folders), &Limits::default()).unwrap_err().to_string()
    };
    let of = |recordings: &str| {
        format!(r#"{{"format": "bendtwin-recordings", "version": 1, "recordings": {recordings}}}"#)
    };
    let newer = r#"{"format": "bendtwin-recordings", "version": 2}"#;
    assert!(refused(newer, &["a"]).contains("version 2"));
    assert!(refused(&of(r#"[{"folder": "z"}]"#), &["a"]).contains("no folder `z`"));
    assert!(refused(&of(r#"[{"folder": "../a"}]"#), &["a"]).contains("no folder `../a`"));
    assert!(refused(&of(r#"[{"folder": "a"}, {"folder": "a"}]"#), &["a"]).contains("twice"));
    assert!(refused(&of("[]"), &[]).contains("no folder with a recording"));
    let many: Vec<String> =
        (0..17).map(|i| format!(r#"{{"folder": "a", "name": "{i}"}}"#)).collect();
    let error = refused(&of(&format!("[{}]", many.join(","))), &["a"]);
    assert!(error.contains("recordings") && error.contains("16"), "{error}");
    // A fault of a recording is reported with its name.
    let empty = pack(&FileMap::from([
        ("recordings.json".into(), of(r#"[{"folder": "a"}]"#).into_bytes()),
        ("a/notes.txt".into(), b"nothing".to_vec()),
    ]));
    let error = read_bytes("toys", &empty, &Limits::default()).unwrap_err();
    assert!(matches!(&error, Error::InRecording { name, .. } if name == "a"), "{error}");
    assert_eq!(bendtwin_core::Problem::reason(&error), "UNKNOWN_CAPTURE_KIND");
    let mut nested = several();
    nested.others[0].others.push(recording("deeper", 0.3));
    assert!(write_bundle(&nested, Cursor::new(Vec::new())).is_err());
}

#[test]
fn recordings_share_one_budget() {
    let capture = several();
    let alone = Capture { others: Vec::new(), ..capture.clone() };
    let least = (1..200)
        .map(|i| Limits { total_bytes: i * 2048, ..Limits::default() })
        .find(|limits| read_bytes("one", &bytes(&alone), limits).is_ok())
        .unwrap();
    assert!(read_bytes("three", &bytes(&capture), &least).is_err());
}
