//! MCAP files: records and chunks that lie about lengths, checksums and compression.

use rand::RngExt as _;

use crate::{Fault, Rng, damage, samples};

/// Faults of MCAP files.
pub const FAULTS: &[Fault] = &[
    Fault { what: "a recording with damage", make: |rng| damaged(rng, damage::any) },
    Fault { what: "a recording that is cut off", make: |rng| damaged(rng, damage::cut) },
    Fault { what: "a recording with damage in a chunk", make: inside },
    Fault { what: "a record of a wrong length", make: wrong_length },
    Fault { what: "a chunk of a wrong size", make: wrong_size },
    Fault { what: "a chunk with a wrong checksum", make: wrong_checksum },
    Fault { what: "a chunk of an unknown compression", make: unknown_compression },
    Fault { what: "a chunk of noise", make: noisy_chunk },
    Fault { what: "a chunk that unpacks a thousandfold", make: bomb },
    Fault { what: "many chunks that unpack a thousandfold", make: many_bombs },
    Fault { what: "chunks in chunks", make: nested },
    Fault { what: "records in another order", make: reordered },
    Fault { what: "records without end", make: many_records },
    Fault { what: "channels without end", make: many_channels },
    Fault { what: "transforms that turn in circles", make: renamed },
    Fault { what: "an attachment of a wrong length", make: attachment },
];

const MAGIC: &[u8] = b"\x89MCAP0\r\n";
pub(crate) const SCHEMA: u8 = 3;
pub(crate) const CHANNEL: u8 = 4;
const CHUNK: u8 = 6;
const ATTACHMENT: u8 = 9;
const DATA_END: u8 = 15;

/// A record: its opcode and its content.
pub type Record = (u8, Vec<u8>);

/// The records of a file, up to the end of its data; those of chunks instead of the chunks.
pub fn records(file: &[u8]) -> Vec<Record> {
    let mut found = Vec::new();
    let mut rest = &file[MAGIC.len()..];
    while let Some((&[opcode, ref length @ ..], after)) = rest.split_first_chunk::<9>() {
        let Some((content, after)) = after.split_at_checked(u64::from_le_bytes(*length) as usize)
        else {
            break;
        };
        rest = after;
        if opcode == CHUNK {
            let inside = [MAGIC, &unpacked(content)].concat();
            found.extend(records(&inside));
        } else {
            found.push((opcode, content.to_vec()));
        }
        if opcode == DATA_END {
            break;
        }
    }
    found
}

/// The records of a chunk.
fn unpacked(chunk: &[u8]) -> Vec<u8> {
    let name = u32::from_le_bytes([chunk[28], chunk[29], chunk[30], chunk[31]]) as usize;
    let packed = &chunk[32 + name + 8..];
    let mut out = Vec::new();
    let read = match &chunk[32..32 + name] {
        b"lz4" => {
            std::io::Read::read_to_end(&mut lz4_flex::frame::FrameDecoder::new(packed), &mut out)
        }
        b"zstd" => {
            let decoder = ruzstd::decoding::StreamingDecoder::new(packed);
            std::io::Read::read_to_end(&mut decoder.expect("the sample is whole"), &mut out)
        }
        _ => Ok(out.len()),
    };
    read.expect("the sample is whole");
    out
}

/// Records one after the other.
pub fn plain(records: &[Record]) -> Vec<u8> {
    let mut out = Vec::new();
    for (opcode, content) in records {
        out.push(*opcode);
        out.extend((content.len() as u64).to_le_bytes());
        out.extend(content);
    }
    out
}

/// A file of these records.
pub fn file(records: &[Record]) -> Vec<u8> {
    [MAGIC, &plain(records), &plain(&[(2, vec![0; 20])]), MAGIC].concat()
}

/// The content of a chunk.
pub fn chunk(unpacked: u64, crc: u32, compression: &str, packed: &[u8]) -> Vec<u8> {
    let mut out = vec![0; 16];
    out.extend(unpacked.to_le_bytes());
    out.extend(crc.to_le_bytes());
    out.extend((compression.len() as u32).to_le_bytes());
    out.extend(compression.as_bytes());
    out.extend((packed.len() as u64).to_le_bytes());
    out.extend(packed);
    out
}

/// A file whose only record is a chunk.
pub fn of_chunk(content: Vec<u8>) -> Vec<u8> {
    file(&[(CHUNK, content), (DATA_END, vec![0; 4])])
}

/// Compresses the content of a chunk.
pub fn pack(compression: &str, bytes: &[u8]) -> Vec<u8> {
    match compression {
        "lz4" => {
            let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
            std::io::Write::write_all(&mut encoder, bytes).expect("it is written");
            encoder.finish().expect("it is written")
        }
        "zstd" => {
            let level = ruzstd::encoding::CompressionLevel::Fastest;
            ruzstd::encoding::compress_to_vec(bytes, level)
        }
        _ => bytes.to_vec(),
    }
}

fn damaged(rng: &mut Rng, damage: fn(&mut Rng, &[u8]) -> Vec<u8>) -> Vec<u8> {
    let bytes = whole(rng);
    damage(rng, &bytes)
}

/// The valid recording, with its chunks or with these dissolved.
fn whole(rng: &mut Rng) -> Vec<u8> {
    let [lz4, zstd] = samples::mcap();
    match rng.random_range(0..3) {
        0 => lz4,
        1 => zstd,
        _ => file(&records(&lz4)),
    }
}

pub(crate) fn valid_records() -> Vec<Record> {
    let [lz4, _] = samples::mcap();
    records(&lz4)
}

fn compression(rng: &mut Rng) -> &'static str {
    ["lz4", "zstd", ""][rng.random_range(0..3)]
}

/// All records but the last in one chunk.
fn in_chunk(rng: &mut Rng, change: impl FnOnce(&mut Rng, &mut Vec<u8>)) -> Vec<u8> {
    let all = valid_records();
    let (end, inner) = all.split_last().expect("the sample has records");
    let compression = compression(rng);
    let mut bytes = plain(inner);
    change(rng, &mut bytes);
    let content = chunk(bytes.len() as u64, 0, compression, &pack(compression, &bytes));
    file(&[(CHUNK, content), end.clone()])
}

fn inside(rng: &mut Rng) -> Vec<u8> {
    in_chunk(rng, |rng, bytes| *bytes = damage::any(rng, bytes))
}

fn wrong_length(rng: &mut Rng) -> Vec<u8> {
    let mut out = file(&valid_records());
    let mut starts = Vec::new();
    let mut at = MAGIC.len();
    while let Some(length) = out.get(at + 1..at + 9).and_then(|b| b.try_into().ok()) {
        starts.push(at + 1);
        at += 9 + u64::from_le_bytes(length) as usize;
    }
    let at = starts[rng.random_range(0..starts.len())];
    let lengths = [0, 1, 1 << 20, 1 << 40, u64::MAX, u64::MAX - 8, i64::MAX as u64];
    let length = lengths[rng.random_range(0..lengths.len())];
    out[at..at + 8].copy_from_slice(&length.to_le_bytes());
    out
}

fn wrong_size(rng: &mut Rng) -> Vec<u8> {
    let bytes = plain(&valid_records());
    let compression = compression(rng);
    let sizes = [0, 1, bytes.len() as u64 - 1, bytes.len() as u64 + 1, 1 << 40, u64::MAX];
    let size = sizes[rng.random_range(0..sizes.len())];
    of_chunk(chunk(size, 0, compression, &pack(compression, &bytes)))
}

fn wrong_checksum(rng: &mut Rng) -> Vec<u8> {
    let bytes = plain(&valid_records());
    let compression = compression(rng);
    of_chunk(chunk(bytes.len() as u64, rng.random(), compression, &pack(compression, &bytes)))
}

fn unknown_compression(rng: &mut Rng) -> Vec<u8> {
    let long = "z".repeat(rng.random_range(1..5000));
    let name = ["gzip", "LZ4", "zstd\0", &long][rng.random_range(0..4)];
    of_chunk(chunk(100, 0, name, &[0; 100]))
}

fn noisy_chunk(rng: &mut Rng) -> Vec<u8> {
    let compression = compression(rng);
    let mut packed = pack(compression, &plain(&valid_records()));
    for _ in 0..rng.random_range(1..50) {
        packed = damage::any(rng, &packed);
    }
    of_chunk(chunk(rng.random_range(0..10_000), 0, compression, &packed))
}

/// A record of an unknown kind, of zeros.
fn zeros(mib: usize) -> Vec<u8> {
    plain(&[(0x80, vec![0; mib << 20])])
}

fn bomb(rng: &mut Rng) -> Vec<u8> {
    let compression = ["lz4", "zstd"][rng.random_range(0..2)];
    let bytes = zeros(rng.random_range(8..32));
    let size = if rng.random() { bytes.len() as u64 } else { 1000 };
    of_chunk(chunk(size, 0, compression, &pack(compression, &bytes)))
}

fn many_bombs(rng: &mut Rng) -> Vec<u8> {
    let bytes = zeros(4);
    let content = chunk(bytes.len() as u64, 0, "zstd", &pack("zstd", &bytes));
    let mut all = vec![(CHUNK, content); rng.random_range(10..400)];
    all.push((DATA_END, vec![0; 4]));
    file(&all)
}

fn nested(rng: &mut Rng) -> Vec<u8> {
    let compression = compression(rng);
    let mut bytes = plain(&valid_records());
    for _ in 0..rng.random_range(2..50) {
        let content = chunk(bytes.len() as u64, 0, compression, &pack(compression, &bytes));
        bytes = plain(&[(CHUNK, content)]);
    }
    [MAGIC, &bytes, &plain(&[(DATA_END, vec![0; 4])]), MAGIC].concat()
}

fn reordered(rng: &mut Rng) -> Vec<u8> {
    let mut all = valid_records();
    for _ in 0..rng.random_range(1..10) {
        let (a, b) = (rng.random_range(0..all.len() - 1), rng.random_range(0..all.len() - 1));
        all.swap(a, b);
    }
    if rng.random() {
        all.remove(rng.random_range(0..all.len()));
    }
    file(&all)
}

fn many_records(rng: &mut Rng) -> Vec<u8> {
    let mut all = vec![(0x80, Vec::new()); rng.random_range(1000..50_000)];
    all.push((DATA_END, vec![0; 4]));
    file(&all)
}

fn many_channels(rng: &mut Rng) -> Vec<u8> {
    let all = valid_records();
    let channel = all.iter().find(|(opcode, _)| *opcode == CHANNEL).expect("it has channels");
    let schemas = all.iter().filter(|(opcode, _)| *opcode == SCHEMA).cloned();
    let channels = (0..rng.random_range(100..6000_u16)).map(|id| {
        let mut content = channel.1.clone();
        content[..2].copy_from_slice(&id.to_le_bytes());
        (CHANNEL, content)
    });
    let mut all: Vec<Record> = schemas.chain(channels).collect();
    all.push((DATA_END, vec![0; 4]));
    file(&all)
}

/// Frames take the names of others, so that a tree becomes a circle, or loses its root.
fn renamed(rng: &mut Rng) -> Vec<u8> {
    let mut all = valid_records();
    let names: [&[u8]; 3] = [b"world", b"mount", b"cam0_"];
    let (from, to) = (names[rng.random_range(0..3)], names[rng.random_range(0..3)]);
    for (_, content) in &mut all {
        let places: Vec<usize> = content
            .windows(from.len())
            .enumerate()
            .filter(|(_, window)| *window == from)
            .map(|(at, _)| at)
            .collect();
        for at in places {
            if rng.random() {
                content[at..at + to.len()].copy_from_slice(to);
            }
        }
    }
    file(&all)
}

fn attachment(rng: &mut Rng) -> Vec<u8> {
    let mut content = vec![0; 16];
    for text in ["toy.obj", "model/obj"] {
        content.extend((text.len() as u32).to_le_bytes());
        content.extend(text.as_bytes());
    }
    let length = [0, 7, 8, 1 << 30, 1 << 40, u64::MAX][rng.random_range(0..6)];
    content.extend(u64::to_le_bytes(length));
    content.extend(b"v 0 0 0");
    let mut all = valid_records();
    all.insert(0, (ATTACHMENT, content));
    file(&all)
}
