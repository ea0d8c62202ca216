//! Damaged and malicious archives.

use std::io::{Cursor, Write};

use zip::{CompressionMethod, ZipWriter, write::SimpleFileOptions};

use crate::{
    Broken,
    Expected::{self, Damaged, Refused},
    Make, Sample, broken,
    files::FileMap,
};

/// Magic numbers of an entry in the data and in the directory of an archive.
const LOCAL: &[u8] = b"PK\x03\x04";
const CENTRAL: &[u8] = b"PK\x01\x02";

/// All recordings of this kind.
pub fn all() -> Vec<Broken> {
    let archive = |name, expected: Expected, pack| broken(name, expected, Make::Archive(pack));
    vec![
        archive("an archive that was cut off", Refused("ARCHIVE_DAMAGED"), |f| {
            let mut bytes = pack(f);
            bytes.truncate(bytes.len() * 2 / 3);
            bytes
        }),
        archive("gzip for ZIP", Refused("UNKNOWN_CAPTURE_KIND"), |f| {
            [b"\x1f\x8b\x08\x00\x00\x00\x00\x00\x00\x03".to_vec(), pack(f)[64..4096].to_vec()]
                .concat()
        }),
        archive("an empty file", Refused("UNKNOWN_CAPTURE_KIND"), |_| Vec::new()),
        archive(
            "an archive of nothing",
            Refused("UNKNOWN_CAPTURE_KIND"),
            |_| pack(&FileMap::new()),
        ),
        archive("a bomb for an image", Damaged("ARCHIVE_BOMB"), |f| {
            let mut files = f.clone();
            files.insert("color/0/4.png".to_owned(), vec![0; 48 << 20]);
            pack(&files)
        }),
        archive("a bomb for a description", Refused("ARCHIVE_BOMB"), |f| {
            let mut files = f.clone();
            files.insert("metadata.json".to_owned(), vec![b' '; 48 << 20]);
            pack(&files)
        }),
        archive("a name that climbs out", Refused("ARCHIVE_UNSAFE_NAME"), |f| {
            with(f, "../../harm.txt")
        }),
        archive("an absolute name", Refused("ARCHIVE_UNSAFE_NAME"), |f| with(f, "/tmp/harm.txt")),
        archive("a name of a kilobyte", Refused("ARCHIVE_UNSAFE_NAME"), |f| {
            with(f, &"n".repeat(1024))
        }),
        archive("a link for an image", Damaged("ARCHIVE_NOT_A_FILE"), |f| {
            let mut files = f.clone();
            files.remove("color/1/8.png");
            let mut zip = opened(&files);
            zip.add_symlink("color/1/8.png", "/etc/hosts", options()).expect("links can be packed");
            closed(zip)
        }),
        archive("two entries of one name", Refused("ARCHIVE_DUPLICATE_NAME"), |f| {
            let mut files = f.clone();
            files.insert("color/0/x.png".to_owned(), vec![1]);
            let mut bytes = pack(&files);
            replace(&mut bytes, b"color/0/x.png", b"color/0/7.png");
            bytes
        }),
        archive("entries that share their bytes", Refused("ARCHIVE_OVERLAP"), |f| {
            let mut files = f.clone();
            files.remove("color/0/7.png");
            let mut zip = opened(&files);
            zip.shallow_copy_file("color/0/6.png", "color/0/7.png").expect("entries can be shared");
            closed(zip)
        }),
        archive("entries under a password", Refused("ARCHIVE_NOT_A_FILE"), |f| {
            let mut bytes = pack(f);
            // The lowest bit of an entry's flags.
            for (start, flags) in [(LOCAL, 6), (CENTRAL, 8)] {
                for at in places(&bytes, start) {
                    bytes[at + flags] |= 1;
                }
            }
            bytes
        }),
        archive("100,001 entries", Refused("ARCHIVE_TOO_MANY_ENTRIES"), |_| {
            let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
            for i in 0..100_001 {
                zip.start_file(i.to_string(), options()).expect("it is written");
            }
            closed(zip)
        }),
        archive("two recordings in one archive", Refused("SEVERAL_CAPTURES"), |f| {
            let few = f.iter().filter(|(name, _)| !name.contains('/') || name.contains("/0/0"));
            let twice = few.flat_map(|(name, bytes)| {
                ["a", "b"].map(|folder| (format!("{folder}/{name}"), bytes.clone()))
            });
            pack(&twice.collect())
        }),
        archive("an entry that claims four gigabytes", Damaged("ARCHIVE_BOMB"), |f| {
            let mut bytes = pack(f);
            let name = b"color/0/4.png";
            // In the directory, the size stands 22 bytes before the name.
            for at in places(&bytes, name).into_iter().skip(1) {
                bytes[at - 22..at - 18].copy_from_slice(&[0xF0, 0xFF, 0xFF, 0xFF]);
            }
            bytes
        }),
    ]
}

/// Files as an archive.
pub fn pack(files: &FileMap) -> Vec<u8> {
    closed(opened(files))
}

/// An archive in a file.
pub(crate) fn stored(bytes: &[u8]) -> Sample {
    let folder = tempfile::tempdir().expect("there is room for it");
    let path = folder.path().join("recording.zip");
    std::fs::write(&path, bytes).expect("there is room for it");
    Sample::Stored(folder, path)
}

type Writer = ZipWriter<Cursor<Vec<u8>>>;

fn opened(files: &FileMap) -> Writer {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        zip.start_file(name.as_str(), options()).expect("it is written");
        zip.write_all(bytes).expect("it is written");
    }
    zip
}

fn closed(zip: Writer) -> Vec<u8> {
    zip.finish().expect("it is written").into_inner()
}

fn options() -> SimpleFileOptions {
    SimpleFileOptions::default().compression_method(CompressionMethod::Deflated)
}

/// The files and one more, of this name.
fn with(files: &FileMap, name: &str) -> Vec<u8> {
    let mut zip = opened(files);
    zip.start_file(name, options()).expect("any name can be packed");
    zip.write_all(b"harm").expect("it is written");
    closed(zip)
}

fn places(bytes: &[u8], of: &[u8]) -> Vec<usize> {
    let windows = bytes.windows(of.len()).enumerate();
    windows.filter(|(_, window)| *window == of).map(|(at, _)| at).collect()
}

fn replace(bytes: &mut [u8], from: &[u8], to: &[u8]) {
    for at in places(bytes, from) {
        bytes[at..at + from.len()].copy_from_slice(&to[..from.len()]);
    }
}
