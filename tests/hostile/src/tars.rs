//! Tar archives, plain and compressed: written header by header, so that they can lie about sizes,
//! names and kinds.

use std::io::Write as _;

use flate2::{Compression, write::GzEncoder};
use rand::RngExt as _;
use tar::{EntryType, Header};

use crate::{
    Fault, Rng,
    archives::{any_files, noise},
    damage,
    samples::FileMap,
};

/// Faults of tar archives.
pub const FAULTS: &[Fault] = &[
    Fault { what: "a tar archive with damage", make: |rng| damaged(rng, damage::any) },
    Fault { what: "a tar archive that is cut off", make: |rng| damaged(rng, damage::cut) },
    Fault { what: "damage in a compressed tar archive", make: damaged_gzip },
    Fault { what: "a tar archive that unpacks a thousandfold", make: bomb },
    Fault { what: "a member that claims another size", make: lying_size },
    Fault { what: "a member whose extended header claims a size", make: extended_size },
    Fault { what: "a name of megabytes", make: long_name },
    Fault { what: "members that leave the folder", make: climbing },
    Fault { what: "two members of one name", make: duplicate },
    Fault { what: "a member of another kind", make: other_kind },
    Fault { what: "a member with a wrong checksum", make: wrong_checksum },
    Fault { what: "text for a compressed archive", make: |rng| noise(rng, b"\x1f\x8b\x08\0") },
];

/// A member as it will stand in the archive, true or not.
#[derive(Clone, Debug)]
pub struct Member {
    /// Name, cut after 100 bytes.
    pub name: Vec<u8>,
    /// Kind by its letter.
    pub kind: EntryType,
    /// Size that the header claims.
    pub size: u64,
    /// Content that follows.
    pub content: Vec<u8>,
    /// Added to the right checksum.
    pub checksum_error: u32,
}

impl Member {
    /// A regular file.
    pub fn file(name: &str, content: &[u8]) -> Self {
        Self {
            name: name.as_bytes().to_vec(),
            kind: EntryType::Regular,
            size: content.len() as u64,
            content: content.to_vec(),
            checksum_error: 0,
        }
    }
}

/// An archive of these members.
pub fn write(members: &[Member]) -> Vec<u8> {
    let mut out = Vec::new();
    for member in members {
        let mut header = Header::new_gnu();
        let name = &member.name[..member.name.len().min(100)];
        header.as_mut_bytes()[..name.len()].copy_from_slice(name);
        header.set_mode(0o644);
        header.set_size(member.size);
        header.set_entry_type(member.kind);
        header.set_cksum();
        let sum = header.cksum().unwrap_or(0).wrapping_add(member.checksum_error);
        let digits = format!("{sum:06o}\0 ");
        header.as_mut_bytes()[148..156].copy_from_slice(&digits.as_bytes()[..8]);
        out.extend(header.as_bytes());
        out.extend(&member.content);
        out.resize(out.len().next_multiple_of(512), 0);
    }
    out.resize(out.len() + 1024, 0);
    out
}

/// Files as an archive.
pub fn pack(files: &FileMap) -> Vec<u8> {
    write(&members(files))
}

/// Bytes compressed with gzip.
pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).expect("it is written");
    encoder.finish().expect("it is written")
}

fn members(files: &FileMap) -> Vec<Member> {
    files.iter().map(|(name, content)| Member::file(name, content)).collect()
}

/// The bytes, raw or compressed.
fn either(rng: &mut Rng, bytes: Vec<u8>) -> Vec<u8> {
    if rng.random() { gzip(&bytes) } else { bytes }
}

fn damaged(rng: &mut Rng, damage: fn(&mut Rng, &[u8]) -> Vec<u8>) -> Vec<u8> {
    let bytes = pack(&any_files(rng));
    let bytes = damage(rng, &bytes);
    either(rng, bytes)
}

fn damaged_gzip(rng: &mut Rng) -> Vec<u8> {
    let bytes = gzip(&pack(&any_files(rng)));
    damage::any(rng, &bytes)
}

fn bomb(rng: &mut Rng) -> Vec<u8> {
    let mut members = members(&any_files(rng));
    let size = rng.random_range(33..48) << 20;
    members.push(Member::file("color/0/99.png", &vec![0; size]));
    gzip(&write(&members))
}

/// A tar with a changed member.
fn changed(rng: &mut Rng, change: impl FnOnce(&mut Member)) -> Vec<u8> {
    let mut members = members(&any_files(rng));
    let index = rng.random_range(0..members.len());
    change(&mut members[index]);
    let bytes = write(&members);
    either(rng, bytes)
}

fn lying_size(rng: &mut Rng) -> Vec<u8> {
    let claimed = [0, 1, 511, 512, 1 << 20, 1 << 32, u64::MAX >> 1, u64::MAX - 510, u64::MAX];
    let size = claimed[rng.random_range(0..claimed.len())];
    changed(rng, |member| member.size = size)
}

fn extended_size(rng: &mut Rng) -> Vec<u8> {
    let claimed = ["0", "99999999", "18446744073709551615", "-1", "1e9", ""];
    let text = format!("size={}\n", claimed[rng.random_range(0..claimed.len())]);
    let mut members = members(&any_files(rng));
    let record = format!("{} {text}", text.len() + 3);
    let extended = Member { kind: EntryType::XHeader, ..Member::file("pax", record.as_bytes()) };
    members.insert(rng.random_range(0..members.len()), extended);
    let bytes = write(&members);
    either(rng, bytes)
}

fn long_name(rng: &mut Rng) -> Vec<u8> {
    let mut members = members(&any_files(rng));
    let kinds = [EntryType::GNULongName, EntryType::GNULongLink, EntryType::XHeader];
    let name = vec![b'n'; rng.random_range(1000..2 << 20)];
    let kind = kinds[rng.random_range(0..kinds.len())];
    let long = Member { kind, size: name.len() as u64, content: name, ..Member::file("long", b"") };
    members.insert(rng.random_range(0..members.len()), long);
    gzip(&write(&members))
}

fn climbing(rng: &mut Rng) -> Vec<u8> {
    const NAMES: [&str; 7] = [
        "../../harm.txt",
        "/tmp/harm.txt",
        "..\\..\\harm.txt",
        "C:\\harm.txt",
        "a/../../harm.txt",
        "./././../harm",
        "",
    ];
    let mut members = members(&any_files(rng));
    members.push(Member::file(NAMES[rng.random_range(0..NAMES.len())], b"harm"));
    let bytes = write(&members);
    either(rng, bytes)
}

fn duplicate(rng: &mut Rng) -> Vec<u8> {
    let mut members = members(&any_files(rng));
    let index = rng.random_range(0..members.len());
    members.push(members[index].clone());
    write(&members)
}

fn other_kind(rng: &mut Rng) -> Vec<u8> {
    let letters = b"12345670SKLxgDMNV\0\xff";
    let kind = EntryType::new(letters[rng.random_range(0..letters.len())]);
    changed(rng, |member| member.kind = kind)
}

fn wrong_checksum(rng: &mut Rng) -> Vec<u8> {
    let by = rng.random_range(1..1000);
    changed(rng, |member| member.checksum_error = by)
}
