//! Chunks: records that were compressed together.

use std::io::Read;

use super::{record::Fields, zstd};

/// Bytes that a chunk may have in memory. Writers make chunks of about a megabyte, or of one
/// message where that is larger.
pub(super) const MAX_CHUNK: u64 = 128 << 20;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Compression {
    None,
    Zstd,
    Lz4,
}

/// A chunk in a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chunk {
    pub(super) compression: Compression,
    /// Offset of its (compressed) records in the file, and their bytes.
    pub(super) start: u64,
    pub(super) length: u64,
    /// Bytes of its records.
    pub(super) unpacked: u64,
    /// CRC-32 of its records; 0 where it was not computed.
    crc: u32,
}

impl Chunk {
    /// From the start of its record's content, which lies at `at` and has `length` bytes.
    pub(super) fn parse(prefix: &[u8], at: u64, length: u64) -> Result<Self, String> {
        const CUT: &str = "the header of a chunk is cut off";
        let mut fields = Fields(prefix);
        let mut header = || {
            fields.take(16)?;
            let (unpacked, crc) = (fields.u64()?, fields.u32()?);
            let (name, packed) = (fields.text()?, fields.u64()?);
            Some((unpacked, crc, name, packed, (prefix.len() - fields.0.len()) as u64))
        };
        let (unpacked, crc, name, packed, header) = header().ok_or(CUT)?;
        let compression = match name.as_str() {
            "" => Compression::None,
            "zstd" => Compression::Zstd,
            "lz4" => Compression::Lz4,
            other => {
                let name: String = other.chars().take(20).collect();
                return Err(format!("a chunk is compressed with `{name}`: zstd and lz4 are known"));
            }
        };
        if packed > length.saturating_sub(header) {
            return Err("a chunk claims more bytes than it has".to_owned());
        }
        if compression == Compression::None && packed != unpacked {
            return Err("an uncompressed chunk claims two different sizes".to_owned());
        }
        Ok(Self { compression, start: at + header, length: packed, unpacked, crc })
    }

    /// Unpacks the chunk's records from its compressed bytes.
    pub(super) fn unpack(&self, packed: &[u8]) -> Result<Vec<u8>, String> {
        let failed = |e: &dyn std::fmt::Display| format!("a chunk does not decompress: {e}");
        let mut bytes = Vec::new();
        // One byte more than announced shows that there is more.
        let limit = self.unpacked.saturating_add(1);
        match self.compression {
            Compression::None => bytes.extend_from_slice(packed),
            Compression::Lz4 => {
                lz4_flex::frame::FrameDecoder::new(packed)
                    .take(limit)
                    .read_to_end(&mut bytes)
                    .map_err(|e| failed(&e))?;
            }
            Compression::Zstd => {
                let window = self.unpacked.max(zstd::MOST_WINDOW);
                bytes = zstd::unpack(packed, limit, window).map_err(|e| failed(&e))?;
            }
        }
        if bytes.len() as u64 != self.unpacked {
            return Err("a chunk holds another number of bytes than it announces".to_owned());
        }
        if self.crc != 0 && crc32fast::hash(&bytes) != self.crc {
            return Err("the checksum of a chunk is wrong".to_owned());
        }
        Ok(bytes)
    }
}
