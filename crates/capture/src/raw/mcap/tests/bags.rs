//! Recordings of several files, in folders and archives, compressed as a whole or message by message.

use std::{fs, path::Path};

use ruzstd::encoding::{CompressionLevel, compress_to_vec};

use super::{
    Wishes, expect_whole, file as written,
    made::{Message, camera, file, healthy},
};
use crate::{
    Error, Limits, Opened,
    check::testing::{FileMap, pack},
    files_read, open,
    raw::{
        self, Recording,
        testing::{FRAMES, color_at, folder, reason},
    },
};

const METADATA: &str =
    "rosbag2_bagfile_information:\n  relative_file_paths:\n    - bag_0.mcap\n    - bag_1.mcap\n";

fn zstd(bytes: &[u8]) -> Vec<u8> {
    compress_to_vec(bytes, CompressionLevel::Fastest)
}

fn opened(files: &FileMap) -> (tempfile::TempDir, Result<Recording, Error>) {
    let folder = folder(files);
    let recording = raw::open(folder.path(), &Limits::default());
    (folder, recording)
}

/// Checks that both cameras have all frames.
fn expect_all(recording: Result<Recording, Error>) {
    let recording = recording.unwrap();
    assert_eq!((recording.cameras.len(), recording.frame_count), (2, FRAMES));
    for camera in 0..2 {
        let mut frames = recording.source.frames(camera).unwrap();
        for frame in 0..FRAMES {
            let color = frames.color(frame).unwrap().unwrap();
            assert_eq!(color.get(3, 2), Some(color_at(camera, frame, 3, 2)));
            assert!(frames.depth(frame).unwrap().is_some());
        }
    }
}

/// The healthy recording in two files, one after the other.
fn split() -> [Vec<u8>; 2] {
    let (mut first, mut second): (Vec<Message>, Vec<Message>) = (Vec::new(), Vec::new());
    for message in healthy() {
        let half = super::made::stamp(FRAMES / 2);
        if message.ns < half { first.push(message) } else { second.push(message) }
    }
    [file(&first), file(&second)]
}

fn bag(names: [&str; 2], files: [Vec<u8>; 2]) -> FileMap {
    names.into_iter().map(str::to_owned).zip(files).collect()
}

#[test]
fn a_folder_with_one_file_is_opened() {
    let mut files = FileMap::from([("run_0.mcap".to_owned(), written(&Wishes::default()))]);
    files.insert("metadata.yaml".to_owned(), b"rosbag2".to_vec());
    let one = folder(&files);
    assert!(matches!(open(one.path(), &Limits::default()).unwrap(), Opened::Raw(_)));
    assert_eq!(reason(crate::read(one.path(), &Limits::default())), "RAW_CAPTURE");
    // The name does not matter: uploads lose it.
    fs::write(one.path().join("blob"), written(&Wishes::default())).unwrap();
    assert!(open(&one.path().join("blob"), &Limits::default()).is_ok());
}

#[test]
fn a_split_recording_is_one() {
    let mut files = bag(["bag_0.mcap", "bag_1.mcap"], split());
    // By names and times alone, in any order of the names.
    expect_all(opened(&files).1);
    expect_all(opened(&bag(["run_10.mcap", "run_9.mcap"], split())).1);
    expect_all(opened(&bag(["a.mcap", "B.MCAP"], split())).1);
    // With the list of a recorder, and another file beside it.
    files.insert("metadata.yaml".to_owned(), METADATA.into());
    files.insert("old.mcap".to_owned(), written(&Wishes::default()));
    let (_guard, recording) = opened(&files);
    let left_out = recording.as_ref().unwrap().sources.left_out.clone();
    assert!(left_out.iter().any(|l| l.from == "old.mcap" && l.because.contains("metadata.yaml")));
    expect_all(recording);
    files.remove("bag_1.mcap");
    assert_eq!(reason(opened(&files).1), "MISSING_FILE");
    // Each camera in its own file.
    let cameras = [camera(0, "/cam0"), camera(1, "/cam1")].map(|messages| file(&messages));
    expect_all(opened(&bag(["left.mcap", "right.mcap"], cameras)).1);
}

#[test]
fn several_recordings_in_a_folder_are_refused() {
    let twice = bag(["run_0.mcap", "run_1.mcap"], [file(&healthy()), file(&healthy())]);
    let (_guard, recording) = opened(&twice);
    let text = recording.as_ref().unwrap_err().to_string();
    assert_eq!(reason(recording), "SEVERAL_CAPTURES");
    assert!(text.contains("mcap merge run_0.mcap run_1.mcap"), "{text}");
    let later = |seconds: i64| {
        let moved =
            healthy().into_iter().map(|m| Message { ns: m.ns + seconds * 1_000_000_000, ..m });
        file(&moved.collect::<Vec<_>>())
    };
    let apart = bag(["run_0.mcap", "run_1.mcap"], [file(&healthy()), later(60)]);
    assert_eq!(reason(opened(&apart).1), "SEVERAL_CAPTURES");
}

#[test]
fn archives_have_recordings_too() {
    let mut files = bag(["bag_0.mcap", "bag_1.mcap"], split());
    files.insert("metadata.yaml".to_owned(), METADATA.into());
    let inner: FileMap = files.iter().map(|(n, b)| (format!("take/{n}"), b.clone())).collect();
    let folder = folder(&files);
    let stored = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        raw::open(&path, &Limits::default())
    };
    expect_all(stored("deflated.zip", &pack(&inner)));
    let read = files_read(folder.path(), &Limits::default()).unwrap();
    assert_eq!(read.files, ["bag_0.mcap", "bag_1.mcap", "metadata.yaml"]);
    let packed = stored_zip(&inner);
    expect_all(stored("stored.zip", &packed));
    assert!(stored("cut.zip", &packed[..packed.len() / 2]).is_err());
    expect_all(stored("bag.tar", &tar(folder.path())));
}

fn stored_zip(files: &FileMap) -> Vec<u8> {
    use std::io::Write;
    let options =
        zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, bytes) in files {
        zip.start_file(name.as_str(), options).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

fn tar(folder: &Path) -> Vec<u8> {
    let mut tar = tar::Builder::new(Vec::new());
    for name in ["bag_0.mcap", "bag_1.mcap", "metadata.yaml"] {
        tar.append_path_with_name(folder.join(name), format!("take/{name}")).unwrap();
    }
    tar.into_inner().unwrap()
}

#[test]
fn messages_that_were_compressed_one_by_one_are_unpacked() {
    let packed: Vec<Message> =
        healthy().into_iter().map(|m| Message { data: zstd(&m.data), ..m }).collect();
    let (_guard, recording) = super::opened(&file(&packed));
    expect_all(recording);
}

#[test]
fn files_that_were_compressed_as_a_whole_are_unpacked() {
    let bytes = written(&Wishes { chunked: true, ..Wishes::default() });
    expect_whole(&zstd(&bytes));
    // As several frames.
    expect_whole(&[zstd(&bytes[..500]), zstd(&bytes[500..])].concat());
    let [first, second] = split();
    let names = ["bag_0.mcap.zstd", "bag_1.mcap.zstd"];
    let mut files = bag(names, [zstd(&first), zstd(&second)]);
    files.insert("metadata.yaml".to_owned(), METADATA.replace(".mcap", ".mcap.zstd").into());
    expect_all(opened(&files).1);
    // A player unpacks files beside the compressed ones.
    files.insert("bag_0.mcap".to_owned(), first);
    expect_all(opened(&files).1);
}

#[test]
fn what_unpacks_a_thousandfold_is_refused() {
    let zeros = zstd(&vec![0; 64 << 20]);
    let start = &file(&healthy())[..8];
    assert_eq!(reason(super::opened(&[&zstd(start)[..], &zeros].concat()).1), "ARCHIVE_BOMB");
    let small = Limits { total_bytes: 4 << 20, ..Limits::default() };
    let folder = folder(&FileMap::from([("a.mcap.zstd".to_owned(), zeros[..].to_vec())]));
    let path = folder.path().join("a.mcap.zstd");
    let some = [zstd(start), zstd(&vec![7; 3 << 20])].concat();
    fs::write(&path, some).unwrap();
    for path in [path.as_path(), folder.path()] {
        assert_eq!(reason(raw::open(path, &small)), "MCAP_TOO_LARGE_FOR_MEMORY");
    }
    // Messages of 4 MiB of zeros that say so: a single segment, and blocks of four bytes each.
    let mut frame = b"\x28\xb5\x2f\xfd\xa0\x00\x00\x40\x00".to_vec();
    for block in 0..32_u32 {
        let head = (128 << 10 << 3) | (1 << 1) | u32::from(block == 31);
        frame.extend(&head.to_le_bytes()[..3]);
        frame.push(0);
    }
    let bombs: Vec<Message> =
        healthy().into_iter().map(|m| Message { data: frame.clone(), ..m }).collect();
    assert_eq!(reason(super::opened(&file(&bombs)).1), "ARCHIVE_BOMB");
    // Damaged messages.
    let mut damaged = healthy();
    for message in damaged.iter_mut().filter(|m| m.kind == "Image") {
        message.data = zstd(&message.data)[..20].to_vec();
    }
    assert_eq!(reason(super::opened(&file(&damaged)).1), "FILE_DAMAGED");
}

#[test]
fn a_pointer_of_git_lfs_is_named() {
    let pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n";
    let (_guard, recording) = opened(&FileMap::from([("a.mcap".to_owned(), pointer.to_vec())]));
    assert!(recording.unwrap_err().to_string().contains("git lfs pull"));
}
