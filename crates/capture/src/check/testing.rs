//! Test captures as maps from file name to bytes, easy to break.

use std::{
    collections::BTreeMap,
    io::{Cursor, Read, Write},
};

use bendtwin_core::Capture;
use zip::{ZipArchive, ZipWriter, write::SimpleFileOptions};

use crate::write_bundle;

pub(crate) type FileMap = BTreeMap<String, Vec<u8>>;

pub(crate) fn pack(files: &FileMap) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        zip.start_file(name.as_str(), SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

pub(crate) fn unpack(bytes: &[u8]) -> FileMap {
    let mut zip = ZipArchive::new(Cursor::new(bytes)).unwrap();
    let mut files = FileMap::new();
    for index in 0..zip.len() {
        let mut entry = zip.by_index(index).unwrap();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        files.insert(entry.name().unwrap().into_owned(), bytes);
    }
    files
}

pub(crate) fn bundle(capture: &Capture) -> FileMap {
    unpack(&write_bundle(capture, Cursor::new(Vec::new())).unwrap().into_inner())
}
