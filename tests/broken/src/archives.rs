//! Damaged and malicious archives.

use std::io::{Cursor, Write};

use zip::{CompressionMethod, ZipWriter, write::SimpleFileOptions};

use crate::{
    Broken,
    Expected::{self, Damaged, Refused, Sound},
    Make, Sample, broken,
    files::FileMap,
};

/// Magic numbers of an entry in the data and in the directory of an archive.
const LOCAL: &[u8] = b"PK\x03\x04";
const CENTRAL: &[u8] = b"PK\x01\x02";

/// All recordings of this kind.
pub fn all() -> Vec<Broken> {
    [faults(), kinds()].concat()
}

fn faults() -> Vec<Broken> {
    let archive = |name, expected: Expected, pack| broken(name, expected, Make::Archive(pack));
    vec![
        archive("an archive that was cut off", Refused("ARCHIVE_DAMAGED"), |f| {
            let mut bytes = pack(f);
            bytes.truncate(bytes.len() * 2 / 3);
            bytes
        }),
        archive("gzip of nothing", Refused("ARCHIVE_DAMAGED"), |f| {
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

/// Recordings in other kinds of archives than the usual, and in files that are no archives.
fn kinds() -> Vec<Broken> {
    let archive = |name, expected: Expected, pack| broken(name, expected, Make::Archive(pack));
    vec![
        archive("a tar archive", Sound("MASK_LABELS"), tar),
        archive("a compressed tar archive", Sound("MASK_LABELS"), |f| gzip(&tar(f))),
        archive("a tar archive that was cut off", Refused("ARCHIVE_DAMAGED"), |f| {
            let bytes = tar(f);
            bytes[..bytes.len() / 2].to_vec()
        }),
        archive("a bomb in a compressed tar archive", Refused("ARCHIVE_BOMB"), |_| {
            gzip(&tar(&FileMap::from([("metadata.json".to_owned(), vec![b' '; 48 << 20])])))
        }),
        archive("a ZIP archive in bzip2", Sound("MASK_LABELS"), |f| {
            let options = options().compression_method(CompressionMethod::Bzip2);
            closed(opened_with(f, options))
        }),
        archive("a ZIP archive in LZMA", Refused("ARCHIVE_COMPRESSION_NOT_READ"), |f| {
            let mut bytes = pack(f);
            for (start, method) in [(LOCAL, 8), (CENTRAL, 10)] {
                for at in places(&bytes, start) {
                    bytes[at + method] = 14;
                }
            }
            bytes
        }),
        archive("a case three folders deep", Sound("MASK_LABELS"), |f| {
            let deep = |(name, bytes): (&String, &Vec<u8>)| {
                (format!("data/different_types/toy/{name}"), bytes.clone())
            };
            pack(&f.iter().map(deep).collect())
        }),
        archive("a bag of ROS 1", Refused("FORMAT_NOT_READ"), |_| {
            [b"#ROSBAG V2.0\n".to_vec(), vec![b' '; 5000]].concat()
        }),
        archive("a database of ROS 2", Refused("FORMAT_NOT_READ"), |_| {
            [b"SQLite format 3\0".to_vec(), vec![0; 5000]].concat()
        }),
        archive("a video", Refused("FORMAT_NOT_READ"), |_| {
            [b"\0\0\0\x20ftypisom".to_vec(), vec![0; 5000]].concat()
        }),
    ]
}

fn tar(files: &FileMap) -> Vec<u8> {
    let mut tar = tar::Builder::new(Vec::new());
    for (name, bytes) in files {
        let mut header = tar::Header::new_ustar();
        header.set_size(bytes.len() as u64);
        tar.append_data(&mut header, name, bytes.as_slice()).expect("it is written");
    }
    tar.into_inner().expect("it is written")
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    gzip.write_all(bytes).expect("it is written");
    gzip.finish().expect("it is written")
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
    opened_with(files, options())
}

fn opened_with(files: &FileMap, options: SimpleFileOptions) -> Writer {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        zip.start_file(name.as_str(), options).expect("it is written");
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
