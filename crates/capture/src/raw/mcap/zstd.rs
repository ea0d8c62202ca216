//! Zstandard in chunks, in messages that were compressed one by one, and in files as a whole.

use std::io::{BufRead, BufReader, Read};

use ruzstd::decoding::{FrameDecoder, StreamingDecoder};

use crate::{Error, Limits, files::Section};

/// First bytes of a frame.
pub(super) const MAGIC: &[u8] = b"\x28\xb5\x2f\xfd";

/// Window allowed for chunks and messages of any size: the window that every decoder has to support
/// (RFC 8878). A decoder fills its window before it gives the first byte.
pub(super) const MOST_WINDOW: u64 = 8 << 20;

/// Bytes of one block at most.
const MOST_BLOCK: u64 = 128 << 10;

/// Window allowed for whole files, which are unpacked in memory anyway.
pub(super) const MOST_FILE_WINDOW: u64 = 128 << 20;

/// Bytes unpacked between two checks of the total.
const STEP: u64 = 1 << 20;

/// Unpacks at most `most` bytes of frames that lie one after another.
pub(super) fn unpack(packed: &[u8], most: u64, window: u64) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let mut rest = packed;
    while !rest.is_empty() && (bytes.len() as u64) < most {
        let decoder = StreamingDecoder::new_with_max_window_size(&mut rest, window)
            .map_err(|e| e.to_string())?;
        let left = most - bytes.len() as u64;
        decoder.take(left).read_to_end(&mut bytes).map_err(|e| e.to_string())?;
    }
    Ok(bytes)
}

/// Bytes that a message unpacks to, as its first frame announces, or else its window: as many are
/// unpacked before the first byte is given.
pub(super) fn announced(packed: &[u8]) -> u64 {
    let mut decoder = FrameDecoder::new();
    decoder.set_max_window_size(MOST_WINDOW);
    let known = decoder.init(packed).is_ok().then(|| decoder.content_size());
    match (known, packed) {
        (Some(size), _) if size > 0 => size,
        // RFC 8878, 3.1.1.1: without a single segment the second byte of the header is the window.
        (Some(_), [_, _, _, _, descriptor, window, ..]) if descriptor & 0x20 == 0 => {
            let base = 1_u64 << (10 + (window >> 3));
            (base + base / 8 * u64::from(window & 7)).max(MOST_BLOCK)
        }
        _ => 0,
    }
}

/// Unpacks a file into memory, at most `left` bytes; `left` is less by them afterwards.
pub(super) fn unpack_file(
    name: &str,
    file: &Section,
    limits: &Limits,
    left: &mut u64,
) -> Result<Vec<u8>, Error> {
    let damaged =
        |fault: String| Error::Damaged { at: name.to_owned(), fault: format!("zstd: {fault}") };
    let limit = limits.unpacked_of(file.len()).min(*left);
    let mut reader = BufReader::new(file.reader());
    let mut bytes = Vec::new();
    while !reader.fill_buf().map_err(|e| damaged(e.to_string()))?.is_empty() {
        let mut decoder = StreamingDecoder::new_with_max_window_size(&mut reader, MOST_FILE_WINDOW)
            .map_err(|e| damaged(e.to_string()))?;
        loop {
            let read = decoder.by_ref().take(STEP).read_to_end(&mut bytes);
            if read.map_err(|e| damaged(e.to_string()))? == 0 {
                break;
            }
            let unpacked = bytes.len() as u64;
            let ratio = unpacked / file.len().max(1);
            if unpacked >= limits.ratio_from_bytes && ratio > limits.compression_ratio {
                let limit = limits.compression_ratio;
                return Err(Error::ArchiveRatio { at: name.to_owned(), ratio, limit });
            }
            if unpacked > limit {
                return Err(Error::McapInMemory { at: name.to_owned(), limit });
            }
        }
    }
    bytes.shrink_to_fit();
    *left -= bytes.len() as u64;
    Ok(bytes)
}
