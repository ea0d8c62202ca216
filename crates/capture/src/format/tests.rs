use std::fs;

use super::*;
use crate::{Error, Limits, files::Files};

/// A folder with these files, empty but for what is needed to know them.
fn folder(files: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        let content: &[u8] = if name.ends_with(".mcap") { b"\x89MCAP0\r\n" } else { b"{}" };
        fs::write(path, content).unwrap();
    }
    folder
}

fn detect(path: &Path) -> Result<Format, Error> {
    Ok(match Place::at(path) {
        Place::Arrays(_) => Format::MotionCapture,
        Place::Markers(_) => Format::Markers,
        Place::Mcap(_) => Format::Mcap,
        Place::Files(path) => {
            let mut files = Files::open(path, &Limits::default())?;
            let is_there = files.settle(Format::is_in)?;
            let format = Format::detect(&files.list("")).filter(|_| is_there);
            format.ok_or_else(|| files.unknown())?
        }
    })
}

#[test]
fn a_folder_is_read_as_the_first_of_its_formats() {
    for (files, format) in [
        (&["recordings.json", "a/capture.json"][..], Format::Recordings),
        (&["capture.json", "final_data.pkl"], Format::Bundle),
        (&["final_data.pkl", "metadata.json", "color/0/0.png"], Format::PhysTwin),
        (&["transforms.json", "metadata.json", "color/0/0.png"], Format::Nerfstudio),
        (&["metadata.json", "color/0/0.png"], Format::RawPhysTwin),
        (&["rope.npz", "rope.json"], Format::MotionCapture),
        (&["rope.c3d", "rope.json"], Format::Markers),
        (&["take.csv"], Format::Markers),
        (&["notes.csv", "case/transforms.json"], Format::Nerfstudio),
        (&["rope.trc", "metadata.json", "color/0/0.png"], Format::RawPhysTwin),
        (&["capture.json", "bag.mcap"], Format::Mcap),
        (&["a.mcap", "b.mcap"], Format::Mcap),
        (&["take/a_0.mcap.zstd", "take/metadata.yaml"], Format::Mcap),
        (&["inner/deeper/transforms.json"], Format::Nerfstudio),
    ] {
        assert_eq!(detect(folder(files).path()).unwrap(), format, "{files:?}");
    }
}

#[test]
fn a_path_may_be_the_file_that_says_it() {
    let folder = folder(&["capture.json", "rope.npz", "bags/bag.mcap"]);
    let at = |name: &str| detect(&folder.path().join(name)).unwrap();
    assert_eq!(at("capture.json"), Format::Bundle);
    assert_eq!(at("rope.npz"), Format::MotionCapture);
    assert_eq!(at("bags/bag.mcap"), Format::Mcap);
}

#[test]
fn nothing_and_two_captures_are_refused() {
    let fault = detect(folder(&["readme.txt"]).path()).unwrap_err();
    assert!(matches!(fault, Error::UnknownKind { .. }), "{fault}");
    let fault = detect(folder(&["a/capture.json", "b/capture.json"]).path()).unwrap_err();
    assert!(matches!(fault, Error::Several(_)), "{fault}");
    let fault = detect(folder(&["a/a.mcap", "b/b.mcap.zstd"]).path()).unwrap_err();
    assert!(matches!(fault, Error::Several(_)), "{fault}");
    assert!(matches!(detect(Path::new("nowhere")), Err(Error::NotFound(_))));
}
