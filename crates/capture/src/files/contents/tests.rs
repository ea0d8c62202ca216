use super::*;
use crate::{
    check::{testing::bundle, tests::rope},
    raw::testing::{case, folder},
};

fn read_of(files: &crate::check::testing::FileMap) -> FilesRead {
    files_read(folder(files).path(), &Limits::default()).unwrap()
}

#[test]
fn what_is_read_is_listed_and_nothing_else() {
    let mut files = case();
    files.insert("pcd/0.npz".into(), Vec::new());
    files.insert("color/0.mp4".into(), Vec::new());
    files.insert("depth/0/0.png".into(), Vec::new());
    let read = read_of(&files);
    assert_eq!(read.files, case().into_keys().collect::<Vec<_>>());
    assert_eq!((read.folder.as_str(), read.format.contains("raw PhysTwin")), ("", true));
    let points = read_of(&bundle(&rope()));
    assert_eq!(points.files, bundle(&rope()).into_keys().collect::<Vec<_>>());
}

#[test]
fn a_folder_of_a_capture_is_found_and_named() {
    let deep = case().into_iter().map(|(name, bytes)| (format!("data/toy/{name}"), bytes));
    let read = read_of(&deep.chain([("data/notes.txt".to_owned(), Vec::new())]).collect());
    assert_eq!((read.name.as_str(), read.folder.as_str()), ("toy", "data/toy/"));
    assert_eq!(read.files, case().into_keys().collect::<Vec<_>>());
}

#[test]
fn several_recordings_are_listed_together() {
    let document = br#"{"format": "bendtwin-recordings", "version": 1}"#;
    let at = |folder: &str, files: crate::check::testing::FileMap| {
        let moved = files.into_iter().map(|(name, bytes)| (format!("toys/{folder}/{name}"), bytes));
        moved.collect::<Vec<_>>()
    };
    let mut files: crate::check::testing::FileMap =
        at("points", bundle(&rope())).into_iter().chain(at("raw", case())).collect();
    files.insert("toys/recordings.json".into(), document.to_vec());
    let expected = files.keys().map(|name| name["toys/".len()..].to_owned()).collect::<Vec<_>>();
    files.insert("toys/raw/pcd/0.npz".into(), Vec::new());
    let read = read_of(&files);
    assert_eq!((read.folder.as_str(), read.format.contains("several")), ("toys/", true));
    assert_eq!(read.files, expected);
}
