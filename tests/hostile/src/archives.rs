//! Archives: written entry by entry, so that they can lie about sizes, names and places.

use std::io::{Cursor, Read as _, Write as _};

use rand::RngExt as _;
use zip::{CompressionMethod, ZipArchive, ZipWriter, write::SimpleFileOptions};

use crate::{
    Fault, Rng, damage,
    samples::{self, FileMap},
};

/// Faults of archives.
pub const FAULTS: &[Fault] = &[
    Fault { what: "an archive with damage", make: |rng| damaged(rng, damage::any) },
    Fault { what: "an archive that is cut off", make: |rng| damaged(rng, damage::cut) },
    Fault { what: "damage in the directory", make: damaged_directory },
    Fault { what: "an entry that unpacks a thousandfold", make: bomb },
    Fault { what: "many entries that unpack a thousandfold", make: many_bombs },
    Fault { what: "entries that share their bytes", make: overlapping },
    Fault { what: "an entry that claims another size", make: lying_size },
    Fault { what: "an entry that claims four gigabytes", make: huge_size },
    Fault { what: "names that leave the folder", make: climbing },
    Fault { what: "two entries of one name", make: duplicate },
    Fault { what: "a link for a file", make: link },
    Fault { what: "a device for a file", make: device },
    Fault { what: "an entry that lies outside the archive", make: outside },
    Fault { what: "a directory of empty entries", make: many_entries },
    Fault { what: "a directory that claims entries it lacks", make: claimed_entries },
    Fault { what: "an unknown compression", make: unknown_method },
    Fault { what: "an archive in an archive", make: nested },
    Fault { what: "an entry under a password", make: encrypted },
    Fault { what: "the directory of a larger archive", make: zip64 },
    Fault { what: "text for an archive", make: |rng| noise(rng, b"PK\x03\x04") },
];

/// An entry as it will stand in the archive, true or not.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Name, any bytes.
    pub name: Vec<u8>,
    /// 0 stored, 8 deflated.
    pub method: u16,
    /// The lowest bit says that it is encrypted.
    pub flags: u16,
    /// Checksum of the content.
    pub crc: u32,
    /// Bytes in the archive.
    pub packed: Vec<u8>,
    /// Size of the content that the entry claims.
    pub size: u32,
    /// Size in the archive that the entry claims.
    pub packed_size: u32,
    /// Unix mode, kind of file included.
    pub mode: u32,
    /// Offset of the local header that the directory claims, if not the true one.
    pub offset: Option<u32>,
}

impl Entry {
    /// A file without compression.
    pub fn stored(name: &str, content: &[u8]) -> Self {
        let size = content.len() as u32;
        Self {
            name: name.as_bytes().to_vec(),
            method: 0,
            flags: 0,
            crc: crc32fast::hash(content),
            packed: content.to_vec(),
            size,
            packed_size: size,
            mode: 0o100_644,
            offset: None,
        }
    }

    /// A compressed file.
    pub fn deflated(name: &str, content: &[u8]) -> Self {
        let packed = deflate(content);
        Self {
            method: 8,
            packed_size: packed.len() as u32,
            packed,
            ..Self { packed: Vec::new(), ..Self::stored(name, content) }
        }
    }

    /// Fields that the local header and the directory have alike.
    fn shared(&self) -> Vec<u8> {
        let mut out = Vec::new();
        for n in [self.flags, self.method, 0, 0x21] {
            out.extend(n.to_le_bytes());
        }
        for n in [self.crc, self.packed_size, self.size] {
            out.extend(n.to_le_bytes());
        }
        out.extend((self.name.len() as u16).to_le_bytes());
        out.extend([0; 2]);
        out
    }
}

/// An archive of these entries.
pub fn write(entries: &[Entry]) -> Vec<u8> {
    let (mut out, mut directory) = (Vec::new(), Vec::new());
    for entry in entries {
        let offset = entry.offset.unwrap_or(out.len() as u32);
        directory.extend(b"PK\x01\x02\x14\x03\x14\x00");
        directory.extend(entry.shared());
        // Comment, disk, internal attributes.
        directory.extend([0; 6]);
        directory.extend((entry.mode << 16).to_le_bytes());
        directory.extend(offset.to_le_bytes());
        directory.extend(&entry.name);
        if entry.offset.is_none() {
            out.extend(b"PK\x03\x04\x14\x00");
            out.extend(entry.shared());
            out.extend(&entry.name);
            out.extend(&entry.packed);
        }
    }
    end(&mut out, &directory, entries.len() as u16);
    out
}

/// Appends a directory that claims `count` entries.
fn end(out: &mut Vec<u8>, directory: &[u8], count: u16) {
    let start = out.len() as u32;
    out.extend(directory);
    out.extend(b"PK\x05\x06\0\0\0\0");
    out.extend(count.to_le_bytes());
    out.extend(count.to_le_bytes());
    out.extend((directory.len() as u32).to_le_bytes());
    out.extend(start.to_le_bytes());
    out.extend([0; 2]);
}

/// Files as an archive without compression.
pub fn pack(files: &FileMap) -> Vec<u8> {
    write(&entries(files))
}

/// The files with one of them replaced or added, as an archive.
pub fn with(mut files: FileMap, name: &str, content: Vec<u8>) -> Vec<u8> {
    files.insert(name.to_owned(), content);
    pack(&files)
}

fn entries(files: &FileMap) -> Vec<Entry> {
    files.iter().map(|(name, content)| Entry::stored(name, content)).collect()
}

/// The bytes of an entry that holds `content`.
fn deflate(content: &[u8]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    zip.start_file("a", options).expect("it is written");
    zip.write_all(content).expect("it is written");
    let bytes = zip.finish().expect("it is written").into_inner();
    let mut zip = ZipArchive::new(Cursor::new(bytes)).expect("it was just written");
    let mut packed = Vec::new();
    let mut raw = zip.by_index_raw(0).expect("it has an entry");
    raw.read_to_end(&mut packed).expect("it is whole");
    packed
}

/// Files of a capture of any of the four kinds.
pub fn any_files(rng: &mut Rng) -> FileMap {
    match rng.random_range(0..4) {
        0 => samples::observation(),
        1 => samples::case(),
        2 => samples::raw_bundle(),
        _ => samples::raw_case(),
    }
}

fn damaged(rng: &mut Rng, damage: fn(&mut Rng, &[u8]) -> Vec<u8>) -> Vec<u8> {
    let bytes = valid(rng);
    damage(rng, &bytes)
}

fn valid(rng: &mut Rng) -> Vec<u8> {
    pack(&any_files(rng))
}

/// An archive with a changed entry.
fn changed(rng: &mut Rng, change: impl FnOnce(&mut Entry)) -> Vec<u8> {
    let mut entries = entries(&any_files(rng));
    let index = rng.random_range(0..entries.len());
    change(&mut entries[index]);
    write(&entries)
}

fn damaged_directory(rng: &mut Rng) -> Vec<u8> {
    let bytes = valid(rng);
    let start = bytes.windows(4).position(|w| w == b"PK\x01\x02").unwrap_or(0);
    let (data, directory) = bytes.split_at(start);
    [data.to_vec(), damage::any(rng, directory)].concat()
}

/// A file of zeros, some of which a reader will want.
fn zeros(rng: &mut Rng) -> (String, Vec<u8>, FileMap) {
    let files = any_files(rng);
    let names: Vec<&String> = files.keys().collect();
    let name = names[rng.random_range(0..names.len())].clone();
    (name, vec![0; rng.random_range(33..48) << 20], files)
}

fn bomb(rng: &mut Rng) -> Vec<u8> {
    let (name, content, files) = zeros(rng);
    let mut entries = entries(&files);
    entries.retain(|entry| entry.name != name.as_bytes());
    entries.push(Entry::deflated(&name, &content));
    write(&entries)
}

/// Each just below the size at which its ratio is looked at.
fn many_bombs(rng: &mut Rng) -> Vec<u8> {
    let bomb = Entry::deflated("x", &vec![0; (4 << 20) - rng.random_range(1..100)]);
    let files = any_files(rng);
    let replace = |entry: Entry| {
        let keep = entry.name.ends_with(b".json") || entry.name.ends_with(b".pkl");
        if keep { entry } else { Entry { name: entry.name, ..bomb.clone() } }
    };
    write(&entries(&files).into_iter().map(replace).collect::<Vec<_>>())
}

/// Entries that name the local header of one image.
fn overlapping(rng: &mut Rng) -> Vec<u8> {
    let mut all = entries(&samples::raw_bundle());
    let mut at = 0;
    let mut image: Option<(u32, Entry)> = None;
    for entry in &mut all {
        let is_image = entry.name.ends_with(b".png");
        match &image {
            Some((offset, first)) if is_image => {
                let name = entry.name.clone();
                *entry = Entry { name, offset: Some(*offset), ..first.clone() };
            }
            _ => {
                if is_image {
                    image = Some((at, entry.clone()));
                }
                at += (30 + entry.name.len() + entry.packed.len()) as u32;
            }
        }
    }
    let (offset, first) = image.expect("the recording has images");
    for index in 0..rng.random_range(100..1200) {
        let name = format!("cameras/0/color/{:06}.png", 1000 + index).into_bytes();
        all.push(Entry { name, offset: Some(offset), ..first.clone() });
    }
    write(&all)
}

fn lying_size(rng: &mut Rng) -> Vec<u8> {
    let by = rng.random_range(1..1000);
    let both = rng.random();
    changed(rng, |entry| {
        entry.size = entry.size.wrapping_add(by);
        if both {
            entry.packed_size = entry.packed_size.wrapping_add(by);
        }
    })
}

fn huge_size(rng: &mut Rng) -> Vec<u8> {
    let packed = rng.random();
    changed(rng, |entry| {
        entry.size = 0xFFFF_FFF0;
        if packed {
            entry.packed_size = 0xFFFF_FFF0;
        }
    })
}

fn climbing(rng: &mut Rng) -> Vec<u8> {
    const NAMES: [&str; 9] = [
        "../../harm.txt",
        "/tmp/harm.txt",
        "..\\..\\harm.txt",
        "C:\\harm.txt",
        "a/../../harm.txt",
        "\\\\host\\share\\harm.txt",
        "harm\0.txt",
        "./././../harm",
        "",
    ];
    let mut entries = entries(&any_files(rng));
    entries.push(Entry::stored(NAMES[rng.random_range(0..NAMES.len())], b"harm"));
    write(&entries)
}

fn duplicate(rng: &mut Rng) -> Vec<u8> {
    let mut entries = entries(&any_files(rng));
    let index = rng.random_range(0..entries.len());
    let twice = Entry { packed: Vec::new(), size: 0, packed_size: 0, ..entries[index].clone() };
    entries.push(twice);
    write(&entries)
}

fn link(rng: &mut Rng) -> Vec<u8> {
    let target = [&b"/etc/passwd"[..], b"/dev/zero", b"../../.."][rng.random_range(0..3)];
    changed(rng, |entry| {
        let name = String::from_utf8_lossy(&entry.name).into_owned();
        *entry = Entry { mode: 0o120_777, ..Entry::stored(&name, target) };
    })
}

fn device(rng: &mut Rng) -> Vec<u8> {
    let mode = [0o020_666, 0o060_666, 0o010_666, 0o140_666][rng.random_range(0..4)];
    changed(rng, |entry| entry.mode = mode)
}

fn outside(rng: &mut Rng) -> Vec<u8> {
    let offset = [u32::MAX - 1, 0, 1 << 20, 7][rng.random_range(0..4)];
    changed(rng, |entry| entry.offset = Some(offset))
}

fn many_entries(rng: &mut Rng) -> Vec<u8> {
    let mut entries = entries(&any_files(rng));
    let empty = |i: u32| Entry { offset: Some(0), ..Entry::stored(&i.to_string(), b"") };
    entries.extend((0..rng.random_range(1000..20_000)).map(empty));
    write(&entries)
}

fn claimed_entries(rng: &mut Rng) -> Vec<u8> {
    let mut bytes = valid(rng);
    let count = bytes.len() - 22 + 8;
    bytes[count..count + 4].fill(0xFE);
    bytes
}

fn unknown_method(rng: &mut Rng) -> Vec<u8> {
    let method = [1, 6, 9, 12, 14, 93, 95, 97, 98, 99, 0xFFFF][rng.random_range(0..11)];
    changed(rng, |entry| entry.method = method)
}

fn nested(rng: &mut Rng) -> Vec<u8> {
    let mut bytes = valid(rng);
    for depth in 0..rng.random_range(1..5) {
        let name = if depth % 2 == 0 { "capture.json" } else { "final_data.pkl" };
        bytes = write(&[Entry::stored(name, &bytes)]);
    }
    bytes
}

fn encrypted(rng: &mut Rng) -> Vec<u8> {
    changed(rng, |entry| entry.flags |= 1)
}

/// Numbers of the larger format, which point anywhere.
fn zip64(rng: &mut Rng) -> Vec<u8> {
    let mut bytes = valid(rng);
    let tail = bytes.split_off(bytes.len() - 22);
    let at = bytes.len() as u64;
    bytes.extend(b"PK\x06\x06");
    bytes.extend(44_u64.to_le_bytes());
    bytes.extend([45, 0, 45, 0]);
    bytes.extend([0; 8]);
    for _ in 0..4 {
        let any = [0, 1, 1 << 20, u64::MAX >> 1, u64::MAX][rng.random_range(0..5)];
        bytes.extend(any.to_le_bytes());
    }
    bytes.extend(b"PK\x06\x07\0\0\0\0");
    bytes.extend(at.to_le_bytes());
    bytes.extend(1_u32.to_le_bytes());
    bytes.extend(&tail[..8]);
    bytes.extend([0xFF; 12]);
    bytes.extend([0; 2]);
    bytes
}

/// Bytes by chance behind the first ones of a format.
pub fn noise(rng: &mut Rng, magic: &[u8]) -> Vec<u8> {
    let mut bytes = magic.to_vec();
    bytes.extend((0..rng.random_range(0..2000)).map(|_| rng.random::<u8>()));
    bytes
}
