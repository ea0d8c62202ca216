//! Archives of other kinds than the usual, and files that are no archives.

use std::io::Write as _;

use ::tar::{Builder, EntryType, Header};
use ::zip::{CompressionMethod, ZipWriter, write::SimpleFileOptions};
use flate2::{Compression, write::GzEncoder};

use super::*;
use crate::{
    check::{
        testing::{FileMap, bundle, pack},
        tests::rope,
    },
    read_bytes,
};

fn tar_of(files: &FileMap) -> Vec<u8> {
    let mut builder = Builder::new(Vec::new());
    for (name, bytes) in files {
        append(&mut builder, name, bytes);
    }
    builder.into_inner().unwrap()
}

fn append(builder: &mut Builder<Vec<u8>>, name: &str, bytes: &[u8]) {
    let mut header = Header::new_gnu();
    header.set_size(bytes.len() as u64);
    header.set_mode(0o644);
    builder.append_data(&mut header, name, bytes).unwrap();
}

/// An entry with a name that a builder would refuse.
fn append_raw(builder: &mut Builder<Vec<u8>>, name: &str, kind: EntryType, bytes: &[u8]) {
    let mut header = Header::new_gnu();
    header.as_mut_bytes()[..name.len()].copy_from_slice(name.as_bytes());
    header.set_entry_type(kind);
    header.set_size(bytes.len() as u64);
    header.set_cksum();
    builder.append(&header, bytes).unwrap();
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn reason_of(bytes: &[u8], limits: &Limits) -> &'static str {
    use bendtwin_core::Problem as _;
    read_bytes("x", bytes, limits).map_or_else(|e| e.reason(), |_| "no error")
}

fn reason(bytes: &[u8]) -> &'static str {
    reason_of(bytes, &Limits::default())
}

#[test]
fn tar_and_gzip_are_read_as_zip_is() {
    let files = bundle(&rope());
    let long =
        "a folder with a name that does not fit into the hundred letters of a header".repeat(3);
    for prefix in ["", "./", "take 1/", &format!("{long}/")] {
        let placed = files.iter().map(|(n, b)| (format!("{prefix}{n}"), b.clone())).collect();
        let tar = tar_of(&placed);
        for bytes in [gzip(&tar), tar] {
            assert_eq!(read_bytes("x", &bytes, &Limits::default()).unwrap(), rope(), "{prefix}");
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("toy.v2.tar.gz");
    std::fs::write(&path, gzip(&tar_of(&files))).unwrap();
    assert_eq!(Files::open(&path, &Limits::default()).unwrap().name, "toy.v2");
}

/// A second name of a file is that file.
#[test]
fn hard_links_of_a_tar_are_read() {
    let link = |builder: &mut Builder<Vec<u8>>, name: &str, target: &str| {
        let mut header = Header::new_gnu();
        header.set_entry_type(EntryType::Link);
        header.set_size(0);
        builder.append_link(&mut header, name, target).unwrap();
    };
    let files = bundle(&rope());
    let mut builder = Builder::new(Vec::new());
    for (name, bytes) in &files {
        append(&mut builder, &format!("./first/{name}x"), bytes);
    }
    for name in files.keys() {
        link(&mut builder, &format!("./rope/{name}"), &format!("./first/{name}x"));
    }
    let tar = builder.into_inner().unwrap();
    assert_eq!(read_bytes("x", &tar, &Limits::default()).unwrap(), rope());
    // Names count for what they unpack to.
    let tight = Limits { unpacked_bytes: 1000, unpacked_per_byte: 1, ..Limits::default() };
    let mut builder = Builder::new(Vec::new());
    append(&mut builder, "a", &[7; 4000]);
    (0..100).for_each(|i| link(&mut builder, &format!("b{i}"), "a"));
    assert_eq!(reason_of(&builder.into_inner().unwrap(), &tight), "CAPTURE_TOO_LARGE");
    let mut builder = Builder::new(Vec::new());
    link(&mut builder, "capture.json", "elsewhere");
    assert_eq!(reason(&builder.into_inner().unwrap()), "ARCHIVE_NOT_A_FILE");
}

/// What is said of files that are no capture, by their names and contents.
#[test]
fn files_in_disguise_are_named_with_what_to_do() {
    let pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 7\n".to_vec();
    let page = b"\n<!DOCTYPE html><html><body>Quota exceeded".to_vec();
    let inner = pack(&bundle(&rope()));
    let mcap = b"\x89MCAP0\r\n".to_vec();
    for (name, bytes, words) in [
        ("toy.zip", pointer.clone(), "a Git LFS pointer, not the file itself: run `git lfs pull`"),
        ("toy.mcap", pointer.clone(), "git lfs pull"),
        ("toy.zip", page.clone(), "an HTML page"),
        ("toy.mcap.gz", gzip(&mcap), "MCAP file inside: unpack it with `gunzip toy.mcap.gz`"),
        ("toy.zip.gz", gzip(&inner), "ZIP archive inside"),
        ("toy.pkl.gz", gzip(b"text"), "gunzip toy.pkl.gz"),
        ("toy.7z", b"7z\xbc\xaf\x27\x1c".to_vec(), "7z x toy.7z"),
        ("toy.tar.xz", b"\xfd7zXZ\0".to_vec(), "unxz toy.tar.xz"),
        ("toy.mcap.zst", b"\x28\xb5\x2f\xfd".to_vec(), "zstd"),
        ("train.pkl", b"\x80\x04N.".to_vec(), "docs/formats/capture.md, section 3"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, &bytes).unwrap();
        // By itself, and in a folder.
        for path in [path.as_path(), folder.path()] {
            let text = crate::open(path, &Limits::default()).unwrap_err().to_string();
            let words = words.trim_start_matches("MCAP file inside: ");
            let is_inside = words.starts_with("ZIP archive inside") && path == folder.path();
            assert!(text.contains(words) || is_inside, "{name}: {text}");
        }
    }
    for (name, bytes) in [("toy.zip", inner), ("a.pkl", b"N.".to_vec())] {
        let outer = pack(&FileMap::from([(name.to_owned(), bytes)]));
        assert_eq!(reason(&outer), "FORMAT_NOT_READ", "{name}");
    }
    // In the place of any file that is read.
    for bytes in [pointer, page, gzip(b"{}")] {
        for name in ["capture.json", "object_points.npy"] {
            let mut files = bundle(&rope());
            files.insert(name.to_owned(), bytes.clone());
            assert_eq!(reason(&pack(&files)), "FORMAT_NOT_READ", "{name}");
        }
    }
}

#[test]
fn entries_in_other_compressions_are_read() {
    let files = bundle(&rope());
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in &files {
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Bzip2);
        zip.start_file(name.as_str(), options).unwrap();
        zip.write_all(bytes).unwrap();
    }
    let bytes = zip.finish().unwrap().into_inner();
    assert_eq!(read_bytes("x", &bytes, &Limits::default()).unwrap(), rope());
    // The number of the compression stands 8 bytes into an entry, and 10 into that of the directory.
    let patched = |method: u16, content: &dyn Fn(&[u8]) -> Vec<u8>| {
        let packed: FileMap = files.iter().map(|(n, b)| (n.clone(), content(b))).collect();
        let mut bytes = pack_stored(&packed);
        for at in 0..bytes.len() - 4 {
            let offset = match &bytes[at..at + 4] {
                b"PK\x03\x04" => 8,
                b"PK\x01\x02" => 10,
                _ => continue,
            };
            bytes[at + offset..at + offset + 2].copy_from_slice(&method.to_le_bytes());
        }
        bytes
    };
    let same = |bytes: &[u8]| bytes.to_vec();
    for (method, name) in [(14, "LZMA"), (95, "xz"), (98, "PPMd"), (1, "method 1")] {
        let error = read_bytes("x", &patched(method, &same), &Limits::default()).unwrap_err();
        let text = error.to_string();
        assert!(text.contains(&format!("compressed with {name}")), "{text}");
    }
    // Marked as Zstandard, but not Zstandard.
    assert_eq!(reason(&patched(93, &same)), "FILE_DAMAGED");
}

#[test]
fn zstandard_is_read_within_the_limits() {
    let content = b"{\"format\": \"bendtwin-capture\"} and more".repeat(50);
    let packed = ruzstd::encoding::compress_to_vec(
        content.as_slice(),
        ruzstd::encoding::CompressionLevel::Fastest,
    );
    let entry = |crc: u32, size: u32| {
        let mut shared = Vec::new();
        for n in [0_u16, 93, 0, 0x21] {
            shared.extend(n.to_le_bytes());
        }
        for n in [crc, packed.len() as u32, size] {
            shared.extend(n.to_le_bytes());
        }
        shared.extend(1_u16.to_le_bytes());
        shared.extend([0; 2]);
        let mut out =
            [b"PK\x03\x04\x3f\x00".to_vec(), shared.clone(), b"a".to_vec(), packed.clone()]
                .concat();
        let start = out.len() as u32;
        out.extend(
            [b"PK\x01\x02\x3f\x03\x3f\x00".to_vec(), shared, vec![0; 14], b"a".to_vec()].concat(),
        );
        let length = out.len() as u32 - start;
        out.extend(b"PK\x05\x06\0\0\0\0\x01\0\x01\0");
        out.extend(length.to_le_bytes());
        out.extend(start.to_le_bytes());
        out.extend([0; 2]);
        out
    };
    let read = |bytes: &[u8]| Files::from_bytes("x", bytes, &Limits::default()).unwrap().read("a");
    let crc = crc32fast::hash(&content);
    assert_eq!(read(&entry(crc, content.len() as u32)).unwrap(), content);
    for wrong in [entry(crc ^ 1, content.len() as u32), entry(crc, 5), entry(crc, u32::MAX - 9)] {
        assert!(read(&wrong).is_err());
    }
}

fn pack_stored(files: &FileMap) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
        zip.start_file(name.as_str(), options).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

#[test]
fn every_truncation_of_a_tar_archive_is_an_error() {
    let tar = tar_of(&bundle(&rope()));
    let packed = gzip(&tar);
    // The blocks of zeros at the end may be cut, but for one.
    let end = tar.iter().rposition(|b| *b != 0).unwrap();
    for length in (0..end).step_by(331).chain((512..end).step_by(512)) {
        assert_ne!(reason(&tar[..length]), "no error", "{length}");
    }
    for length in (0..packed.len()).step_by(53) {
        assert_ne!(reason(&packed[..length]), "no error", "{length}");
    }
}

#[test]
fn hostile_tar_archives_are_refused() {
    let with = |name: &str, kind: EntryType, bytes: &[u8]| {
        let mut builder = Builder::new(Vec::new());
        for (name, bytes) in bundle(&rope()) {
            append(&mut builder, &name, &bytes);
        }
        append_raw(&mut builder, name, kind, bytes);
        builder.into_inner().unwrap()
    };
    for name in ["../harm", "/tmp/harm", "a/../../harm", "C:\\harm"] {
        assert_eq!(
            reason(&with(name, EntryType::Regular, b"harm")),
            "ARCHIVE_UNSAFE_NAME",
            "{name}"
        );
    }
    assert_eq!(reason(&with("capture.json", EntryType::Regular, b"{}")), "ARCHIVE_DUPLICATE_NAME");
    for kind in [EntryType::Symlink, EntryType::Link, EntryType::Char, EntryType::Fifo] {
        let mut builder = Builder::new(Vec::new());
        append_raw(&mut builder, "capture.json", kind, b"");
        assert_eq!(reason(&builder.into_inner().unwrap()), "ARCHIVE_NOT_A_FILE", "{kind:?}");
    }
    let few = Limits { archive_entries: 2, ..Limits::default() };
    assert_eq!(reason_of(&tar_of(&bundle(&rope())), &few), "ARCHIVE_TOO_MANY_ENTRIES");
    let mut builder = Builder::new(Vec::new());
    append_raw(&mut builder, "././@LongLink", EntryType::GNULongName, &vec![b'n'; 4 << 20]);
    append(&mut builder, "a", b"");
    let long = builder.into_inner().unwrap();
    let tight = Limits { archive_entries: 100, ..Limits::default() };
    assert_eq!(reason_of(&long, &tight), "ARCHIVE_DAMAGED");
    assert_eq!(reason(&long), "ARCHIVE_UNSAFE_NAME");
    // A size beyond the end, by which the next header would lie anywhere.
    let mut huge = with("a", EntryType::Regular, b"");
    let at = huge.windows(2).rposition(|w| w == b"a\0").unwrap();
    huge[at + 124..at + 136].copy_from_slice(b"777777777777");
    assert_eq!(reason(&huge), "ARCHIVE_DAMAGED");
}

#[test]
fn compressed_archives_are_unpacked_within_the_limits() {
    let zeros = gzip(&tar_of(&FileMap::from([("a".to_owned(), vec![0; 40 << 20])])));
    assert_eq!(reason(&zeros), "ARCHIVE_BOMB");
    let tar = tar_of(&bundle(&rope()));
    let unpacked_bytes = tar.len() as u64 - 1;
    let tight = Limits { unpacked_bytes, unpacked_per_byte: 0, ..Limits::default() };
    assert_eq!(reason_of(&gzip(&tar), &tight), "ARCHIVE_TOO_LARGE_FOR_MEMORY");
    assert_eq!(reason_of(&tar, &tight), "no error");
    // Its size is taken from what may be read.
    let packed = gzip(&tar);
    let files = Files::from_bytes("x", &packed, &Limits::default()).unwrap();
    assert_eq!(files.limits.total_bytes, Limits::default().total_bytes - tar.len() as u64);
    assert_eq!(reason(&gzip(b"text")), "FORMAT_NOT_READ");
}

#[test]
fn formats_to_convert_are_recognized_by_their_content() {
    let mut bag = b"#ROSBAG V2.0\n".to_vec();
    bag.resize(10_000, b' ');
    let realsense = [bag.clone(), b"topic=/device_0/sensor_0/Depth_0/image/data".to_vec()].concat();
    let video = [b"\0\0\0\x20ftypisom".to_vec(), vec![0; 100]].concat();
    for (bytes, what, command) in [
        (bag, "bag of ROS 1", "mcap convert x recording.mcap"),
        (realsense, "RealSense", "rs.align(rs.stream.color)"),
        (b"SQLite format 3\0 and more".to_vec(), "ROS 2", "mcap convert x recording.mcap"),
        (video, "video", "ffmpeg -i x "),
        (b"7z\xbc\xaf\x27\x1c\0\0".to_vec(), "7z archive", "`7z x x`"),
        (b"BZh91AY".to_vec(), "bzip2", "`bunzip2 x`"),
    ] {
        let error = read_bytes("x", &bytes, &Limits::default()).unwrap_err();
        let text = error.to_string();
        assert!(matches!(error, Error::OtherFormat { .. }), "{error:?}");
        assert!(text.contains(what) && text.contains(command), "{text}");
    }
    // Alone in a folder, as recorders leave them.
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("take_0.db3"), b"SQLite format 3\0").unwrap();
    std::fs::write(folder.path().join("metadata.yaml"), "a: 1").unwrap();
    let text = crate::read(folder.path(), &Limits::default()).unwrap_err().to_string();
    assert!(text.contains("mcap convert take_0.db3"), "{text}");
    let packed = pack(&FileMap::from([("take/take_0.mcap".to_owned(), vec![0])]));
    let text = read_bytes("x", &packed, &Limits::default()).unwrap_err().to_string();
    assert!(text.contains("`take` is a raw recording"), "{text}");
}

#[test]
fn what_lies_there_is_named() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["rgb", "depth"] {
        std::fs::create_dir(folder.path().join(name)).unwrap();
    }
    std::fs::write(folder.path().join("notes.txt"), "a").unwrap();
    let text = crate::read(folder.path(), &Limits::default()).unwrap_err().to_string();
    assert!(text.contains("2 folders (depth, rgb) and one file (notes.txt)"), "{text}");
}
