//! Files that are incomplete or mean harm.

use super::{Encoding, Wishes, encode::repack, file, opened, outcome};
use crate::raw::testing::reason;

#[test]
fn what_is_missing_is_named() {
    let standard = Wishes::default;
    assert_eq!(outcome(&standard()), "no error");
    let depth_frame = Some("depth_optical");
    assert_eq!(outcome(&Wishes { depth_frame, ..standard() }), "DEPTH_NOT_ALIGNED");
    assert_eq!(outcome(&Wishes { without_tf: true, ..standard() }), "INVALID_CAMERA");
    assert_eq!(outcome(&Wishes { without_info: true, ..standard() }), "INVALID_CAMERA");
    assert_eq!(outcome(&Wishes { extra_color: true, ..standard() }), "TOPICS_UNCLEAR");
    let rotation = Some([0.0; 4]);
    assert_eq!(outcome(&Wishes { rotation, ..standard() }), "INVALID_CAMERA");
    let rotation = Some([f64::NAN, 0.0, 0.0, 1.0]);
    assert_eq!(outcome(&Wishes { rotation, ..standard() }), "INVALID_CAMERA");
    for (key, value) in [
        ("world_frame", "moon"),
        ("ground_height_m", "NaN"),
        ("train_frame_count", "-1"),
        ("up_axis", "up"),
        ("depth_unit_m", "mm"),
        ("depth_unit_m:/no/topic", "0.001"),
        ("depth_units", "0.001"),
    ] {
        let settings = [(key.to_owned(), value.to_owned())].into();
        let expected = if key == "up_axis" { "INVALID_AXES" } else { "INVALID_DOCUMENT" };
        assert_eq!(outcome(&Wishes { settings, ..standard() }), expected, "{key}");
    }
    let settings = [("train_frame_count".to_owned(), "99".to_owned())].into();
    assert_eq!(outcome(&Wishes { settings, ..standard() }), "SPLIT_OUT_OF_RANGE");
}

#[test]
fn cut_off_files_are_refused() {
    for chunked in [false, true] {
        let bytes = file(&Wishes { chunked, ..Wishes::default() });
        let data_end = bytes.len() / 2;
        for length in (8..data_end).step_by(97) {
            assert_eq!(reason(opened(&bytes[..length]).1), "FILE_DAMAGED", "{length}");
        }
    }
    assert_eq!(reason(opened(&[]).1), "UNKNOWN_CAPTURE_KIND");
    assert_eq!(reason(opened(b"\x89MCAP0\r").1), "UNKNOWN_CAPTURE_KIND");
}

/// A file of one record.
fn with_record(opcode: u8, length: u64, body: &[u8]) -> &'static str {
    let mut bytes = b"\x89MCAP0\r\n".to_vec();
    bytes.push(opcode);
    bytes.extend(length.to_le_bytes());
    bytes.extend(body);
    reason(opened(&bytes).1)
}

fn chunk(unpacked: u64, compression: &str, packed: &[u8]) -> Vec<u8> {
    let mut body = vec![0; 16];
    body.extend(unpacked.to_le_bytes());
    body.extend([0; 4]);
    body.extend((compression.len() as u32).to_le_bytes());
    body.extend(compression.as_bytes());
    body.extend((packed.len() as u64).to_le_bytes());
    body.extend(packed);
    body
}

#[test]
fn lengths_are_not_believed() {
    assert_eq!(with_record(5, u64::MAX, b""), "FILE_DAMAGED");
    assert_eq!(with_record(5, 10, &[0; 10]), "FILE_DAMAGED");
    assert_eq!(with_record(6, 10, &[0; 10]), "FILE_DAMAGED");
    let bomb = chunk(1 << 40, "zstd", &[0; 100]);
    assert_eq!(with_record(6, bomb.len() as u64, &bomb), "CAPTURE_TOO_LARGE");
    let noise = chunk(1000, "zstd", &[7; 100]);
    assert_eq!(with_record(6, noise.len() as u64, &noise), "FILE_DAMAGED");
    let noise = chunk(1000, "lz4", &[7; 100]);
    assert_eq!(with_record(6, noise.len() as u64, &noise), "FILE_DAMAGED");
    // Zeros that unpack to more than they announce.
    let level = ruzstd::encoding::CompressionLevel::Fastest;
    let zeros = ruzstd::encoding::compress_to_vec(&vec![0; 1 << 20][..], level);
    let more = chunk(1000, "zstd", &zeros);
    assert_eq!(with_record(6, more.len() as u64, &more), "FILE_DAMAGED");
    // A chunk in a chunk in a chunk.
    let mut nested = Vec::new();
    for _ in 0..10_000 {
        let mut record = vec![6];
        let body = chunk(nested.len() as u64, "", &nested);
        record.extend((body.len() as u64).to_le_bytes());
        record.extend(body);
        nested = record;
        if nested.len() > 1 << 20 {
            break;
        }
    }
    let body = chunk(nested.len() as u64, "", &nested);
    assert_eq!(with_record(6, body.len() as u64, &body), "FILE_DAMAGED");
}

#[test]
fn many_small_bombs_are_one_bomb() {
    // A record of an unknown kind, of zeros.
    let mut records = vec![0; 48 << 20];
    records[0] = 0x80;
    let length = records.len() as u64 - 9;
    records[1..9].copy_from_slice(&length.to_le_bytes());
    let level = ruzstd::encoding::CompressionLevel::Fastest;
    let packed = ruzstd::encoding::compress_to_vec(&records[..], level);
    let body = chunk(records.len() as u64, "zstd", &packed);
    for count in [1, 4] {
        let mut bytes = b"\x89MCAP0\r\n".to_vec();
        for _ in 0..count {
            bytes.push(6);
            bytes.extend((body.len() as u64).to_le_bytes());
            bytes.extend(&body);
        }
        assert_eq!(reason(opened(&bytes).1), "ARCHIVE_BOMB", "{count} chunks");
    }
}

/// A decoder fills its window before it gives the first byte, however few are wanted.
#[test]
fn windows_are_bounded() {
    // A frame of 128 MiB of zeros: a window of 64 MiB, and blocks of four bytes for 128 KiB each.
    let mut frame = b"\x28\xb5\x2f\xfd\x00\x80".to_vec();
    for block in 0..1024_u32 {
        let head = (128 << 10 << 3) | (1 << 1) | u32::from(block == 1023);
        frame.extend(&head.to_le_bytes()[..3]);
        frame.push(0);
    }
    let body = chunk(1000, "zstd", &frame);
    let mut bytes = b"\x89MCAP0\r\n\x06".to_vec();
    bytes.extend((body.len() as u64).to_le_bytes());
    bytes.extend(&body);
    let error = opened(&bytes).1.unwrap_err().to_string();
    assert!(error.contains("window"), "{error}");
}

#[test]
fn damage_anywhere_is_survived() {
    for encoding in [Encoding::Ros2, Encoding::Ros1, Encoding::Protobuf] {
        let bytes = file(&Wishes { encoding, chunked: true, ..Wishes::default() });
        let packed = repack(&bytes, "lz4");
        for (original, step) in [(&bytes, 61), (&packed, 211)] {
            for at in (8..original.len() / 2).step_by(step) {
                let mut damaged = original.clone();
                damaged[at] ^= 0xFF;
                let (_guard, recording) = opened(&damaged);
                let Ok(recording) = recording else { continue };
                for camera in 0..recording.cameras.len() {
                    let mut frames = recording.source.frames(camera).unwrap();
                    for frame in 0..recording.frame_count.min(8) {
                        let _ = frames.color(frame);
                        let _ = frames.depth(frame);
                    }
                }
            }
        }
    }
}
