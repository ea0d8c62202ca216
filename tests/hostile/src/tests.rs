use std::collections::BTreeSet;

use bendtwin_capture::{Limits, phystwin::results::TrainResult, read_bytes};
use bendtwin_core::Twin;

use super::*;

/// Longest file: what one claims may be large, but it is sent.
const MOST_BYTES: usize = 4 << 20;

#[test]
fn a_seed_gives_the_same_files_again() {
    for of in [
        |s| captures(s).take(120).collect(),
        |s| twins(s).take(40).collect(),
        |s| rollouts(s).take(40).collect::<Vec<_>>(),
    ] {
        let first: Vec<Hostile> = of(7);
        assert_eq!(first, of(7));
        assert_ne!(first, of(8));
        let names: BTreeSet<&String> = first.iter().map(|file| &file.name).collect();
        assert_eq!(names.len(), first.len(), "names repeat");
        assert!(first.iter().all(|file| file.bytes.len() <= MOST_BYTES), "a file is too long");
    }
}

#[test]
fn every_kind_comes_before_one_comes_again() {
    let kinds: BTreeSet<&str> = captures(3).take(200).map(|file| file.what).collect();
    let first: BTreeSet<&str> = captures(3).take(kinds.len()).map(|file| file.what).collect();
    assert!(kinds.len() >= 50, "{}", kinds.len());
    assert_eq!(first, kinds);
}

#[test]
fn what_they_are_made_from_is_valid() {
    let limits = Limits::default();
    for files in [samples::observation(), samples::case()] {
        read_bytes("sample", &archives::pack(&files), &limits).unwrap();
        read_bytes("sample", &tars::pack(&files), &limits).unwrap();
        read_bytes("sample", &tars::gzip(&tars::pack(&files)), &limits).unwrap();
    }
    for masks in masks::valid() {
        let [whole, _] = masks::capture(masks);
        let mut file = tempfile::NamedTempFile::new().unwrap();
        std::io::Write::write_all(&mut file, &whole).unwrap();
        bendtwin_capture::raw::open(file.path(), &limits).unwrap();
    }
    for twin in [samples::twin(), samples::cable()] {
        assert_eq!(Twin::decode(&twin_files::encoded(&twin)).unwrap(), twin);
    }
    TrainResult::decode("a.pth", &torch_files::valid(), &limits).unwrap();
    for (name, bytes) in [
        ("a.glb", meshes::glb()),
        ("a.obj", meshes::OBJ_TEXT.to_vec()),
        ("a.ply", meshes::PLY_TEXT.to_vec()),
        ("b.ply", meshes::binary_ply()),
    ] {
        bendtwin_mesh::parse(name, &bytes, &bendtwin_mesh::Limits::default()).unwrap();
    }
}
