use std::io::Write;

use bendtwin_core::{Appearance, Problem};
use flate2::{Compression, write::GzEncoder};

use super::*;
use crate::testing;

fn gaussians() -> Gaussians {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    Gaussians {
        means_m: vec![[0.0, 0.5, -1.0], [0.25, -2.0, 3.0]],
        scales_m: vec![[0.01, 0.02, 0.03], [0.5, 0.25, 0.125]],
        rotations: vec![[0.0, 0.0, 0.0, 1.0], [half, 0.0, -half, 0.0]],
        opacities: vec![0.75, 0.125],
        colors: vec![[0.0, 0.5, 1.0], [0.25, 0.75, 0.1]],
    }
}

fn ply(gaussians: &Gaussians) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_ply(gaussians, &mut bytes).unwrap();
    bytes
}

fn assert_near(a: &Gaussians, b: &Gaussians, tolerance: f32) {
    let numbers = |g: &Gaussians| {
        let threes = [&g.means_m, &g.scales_m, &g.colors];
        let mut all: Vec<f32> = threes.into_iter().flatten().flatten().copied().collect();
        all.extend(g.rotations.iter().flatten());
        all.extend(&g.opacities);
        all
    };
    let (a, b) = (numbers(a), numbers(b));
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(&b) {
        assert!((a - b).abs() <= tolerance, "{a} {b}");
    }
}

#[test]
fn a_ply_reads_back_unchanged() {
    let loaded = read(&ply(&gaussians())).unwrap();
    assert_near(&loaded.gaussians, &gaussians(), 1e-5);
    assert_eq!(loaded.left_out_harmonics, 0);
}

#[test]
fn other_properties_and_view_dependence_are_passed_over() {
    let written = ply(&gaussians());
    let text = String::from_utf8_lossy(&written).into_owned();
    let header = &text[..text.find("end_header").unwrap()];
    let body = &written[header.len() + "end_header\n".len()..];
    let mut more = header.replace("property float opacity", "property uchar flag\nproperty float f_rest_0\nproperty float f_rest_1\nproperty float f_rest_2\nproperty float opacity").into_bytes();
    more.extend(b"end_header\r\n");
    for vertex in body.chunks(14 * 4) {
        more.extend(&vertex[..24]);
        more.extend([7; 13]);
        more.extend(&vertex[24..]);
    }
    let loaded = read(&more).unwrap();
    assert_near(&loaded.gaussians, &gaussians(), 1e-5);
    assert_eq!(loaded.left_out_harmonics, 1);
}

#[test]
fn a_spz_is_decoded() {
    for version in [2u32, 3] {
        let loaded = read(&spz(version, 1, &[])).unwrap();
        let q = if version == 2 { [100.0 / 127.5 - 1.0, 0.0, 0.0] } else { [-0.5, 0.0, 0.0] };
        let [x, y, z, w] = loaded.gaussians.rotations[0];
        assert!((x - q[0]).abs() < 5e-3 && y.abs() < 5e-3 && z.abs() < 5e-3, "{x} {y} {z}");
        assert!((w - (1.0 - x * x).sqrt()).abs() < 5e-3, "{w}");
        // y and z are turned round.
        assert_eq!(loaded.gaussians.means_m, [[1.5, 2.0, -0.25]]);
        assert!((loaded.gaussians.scales_m[0][0] - (-4f32).exp()).abs() < 1e-6);
        assert!((loaded.gaussians.opacities[0] - 0.8).abs() < 1e-6);
        assert!((loaded.gaussians.colors[0][1] - 0.5).abs() < 4e-3);
        assert_eq!(loaded.left_out_harmonics, 3);
    }
}

/// Writers leave out harmonics of degree 0, whose stream would be empty.
#[test]
fn a_spz_of_version_4_is_decoded() {
    let usual = read(&spz(3, 1, &[])).unwrap();
    for degree in [0, 1] {
        let loaded = read(&spz_4(degree, &[])).unwrap();
        assert_near(&loaded.gaussians, &usual.gaussians, 0.0);
        assert_eq!(loaded.left_out_harmonics, usize::from(degree) * 3);
    }
    // An unknown extension, and the one that names the axes: left, up, forward.
    let words = |words: &[u32]| words.iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<_>>();
    let extensions = [words(&[0xADBE_0002, 12]), vec![7; 12], words(&[0xADBE_0003, 4, 7])].concat();
    let loaded = read(&spz_4(1, &extensions)).unwrap().gaussians;
    let [x, y, z] = usual.gaussians.means_m[0];
    assert_eq!(loaded.means_m, [[-x, y, -z]]);
    let [x, y, z, w] = usual.gaussians.rotations[0];
    assert_eq!(loaded.rotations, [[-x, y, -z, w]]);
    let exchanged = words(&[0xADBE_0003, 4, 9]);
    assert_eq!(read(&spz_4(1, &exchanged)).unwrap_err().reason(), "SPLATS_UNSUPPORTED");
    let good = spz_4(1, &extensions);
    for at in 0..good.len() {
        assert!(read(&good[..at]).is_err(), "{at}");
    }
    let mut other = good;
    other[4] = 5;
    assert_eq!(read(&other).unwrap_err().reason(), "SPLATS_UNSUPPORTED");
}

/// The Gaussian of [`spz`] as version 4 has it.
fn spz_4(degree: u8, extensions: &[u8]) -> Vec<u8> {
    let mut plain = Vec::new();
    std::io::Read::read_to_end(&mut flate2::read::GzDecoder::new(&*spz(3, 1, &[])), &mut plain)
        .unwrap();
    let mut rest = &plain[16..];
    let mut streams = Vec::new();
    for bytes in [9, 1, 3, 3, 4, 9 * usize::from(degree)] {
        let (stream, after) = rest.split_at(bytes);
        rest = after;
        if !stream.is_empty() {
            let level = ruzstd::encoding::CompressionLevel::Fastest;
            streams.push((stream.len(), ruzstd::encoding::compress_to_vec(stream, level)));
        }
    }
    let mut bytes = b"NGSP".to_vec();
    for word in [4, 1_u32] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend([degree, 12, if extensions.is_empty() { 0 } else { 2 }, streams.len() as u8]);
    bytes.extend((32 + extensions.len() as u32).to_le_bytes());
    bytes.extend([0; 12]);
    bytes.extend(extensions);
    for (length, packed) in &streams {
        bytes.extend((packed.len() as u64).to_le_bytes());
        bytes.extend((*length as u64).to_le_bytes());
    }
    bytes.extend(streams.into_iter().flat_map(|(_, packed)| packed));
    bytes
}

/// A Gaussian, or a header that claims more.
fn spz(version: u32, count: u32, extra: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for word in [0x5053_474e, version, count] {
        bytes.extend(u32::to_le_bytes(word));
    }
    bytes.extend([1, 12, 0, 0]);
    for position in [1.5f32, -2.0, 0.25] {
        bytes.extend(&((position * 4096.0) as i32).to_le_bytes()[..3]);
    }
    bytes.push(204);
    bytes.extend([255, 128, 0]);
    bytes.extend([96, 96, 96]);
    if version == 2 {
        bytes.extend([100, 127, 128]);
    } else {
        // w is the largest; x is negative, 0.5 of 0.7071.
        let size = (0.5 * 2f32.sqrt() * 511.0).round() as u32;
        bytes.extend(((3 << 30) | ((512 | size) << 20)).to_le_bytes());
    }
    bytes.extend([128; 9]);
    bytes.extend(extra);
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(&bytes).unwrap();
    encoder.finish().unwrap()
}

#[test]
fn hostile_files_give_errors_with_advice() {
    let good = ply(&gaussians());
    let text = |from: &str, to: &str| {
        let header = String::from_utf8_lossy(&good[..400]).replace(from, to).into_bytes();
        [header, good[400..].to_vec()].concat()
    };
    let mut broken = good.clone();
    let end = broken.len();
    broken[end - 4..].copy_from_slice(&f32::NAN.to_le_bytes());
    for (bytes, reason) in [
        (b"nothing".to_vec(), "SPLATS_FORMAT_UNKNOWN"),
        (good[..good.len() - 1].to_vec(), "SPLATS_DAMAGED"),
        (b"ply\n".to_vec(), "SPLATS_DAMAGED"),
        (text("vertex 2", "vertex 3000000"), "SPLATS_DAMAGED"),
        (text("vertex 2", "vertex 99999999999"), "SPLATS_TOO_MANY"),
        (text("vertex 2", "vertex 0"), "SPLATS_EMPTY"),
        (text("binary_little_endian", "ascii"), "SPLATS_UNSUPPORTED"),
        (text("rot_0", "rot_9"), "SPLATS_UNSUPPORTED"),
        (broken, "SPLATS_OUT_OF_RANGE"),
        (spz(1, 1, &[]), "SPLATS_UNSUPPORTED"),
        (spz(3, 3_999_999, &[]), "SPLATS_DAMAGED"),
        (spz(3, u32::MAX, &[]), "SPLATS_TOO_MANY"),
    ] {
        let error = read(&bytes).unwrap_err();
        assert_eq!(error.reason(), reason, "{error}");
    }
    for at in 0..good.len() {
        let _ = read(&good[..at]);
    }
}

#[test]
fn gaussians_are_placed_cropped_and_carried() {
    let twin = testing::twin();
    let skin = twin.skin.positions(&twin.graph.rest_positions);
    // The file is ten times as large and turned by 90 degrees around z; one Gaussian is far away.
    let there = |p: [f32; 3]| [10.0 * p[1], -10.0 * p[0], 10.0 * p[2]];
    let mut source = Gaussians::default();
    for p in [skin[0], skin[1], [9.0, 9.0, 9.0]] {
        source.means_m.push(there(p));
        source.scales_m.push([0.1, 0.2, 0.3]);
        source.rotations.push([0.0, 0.0, 0.0, 1.0]);
        source.opacities.push(0.5);
        source.colors.push([0.1, 0.2, 0.3]);
    }
    let back =
        [[0.0, -0.1, 0.0, 0.0], [0.1, 0.0, 0.0, 0.0], [0.0, 0.0, 0.1, 0.0], [0.0, 0.0, 0.0, 1.0]];
    let placed = place(&source, &twin, Some(similarity_of(back).unwrap())).unwrap();
    assert_eq!((placed.splats.len(), placed.dropped), (2, 1));
    assert_eq!(placed.splats.check(twin.graph.node_count()), Ok(()));
    let mut dressed = twin;
    let splats = placed.splats;
    dressed.appearance = Some(Appearance { skin_colors: Vec::new(), splats: Some(splats) });
    let found = of_twin(&dressed).unwrap();
    for (found, expected) in found.means_m.iter().zip(&skin) {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?}");
    }
    assert!((found.scales_m[0][2] - 0.03).abs() < 1e-6);
    let [x, y, z, w] = found.rotations[0].map(f32::abs);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    assert!(x < 1e-6 && y < 1e-6 && (z - half).abs() < 1e-6 && (w - half).abs() < 1e-6);
}

#[test]
fn only_similarities_are_transforms() {
    let identity =
        [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    assert!(similarity_of(identity).is_ok());
    for (row, column, value) in
        [(0, 0, -1.0), (0, 0, 2.0), (3, 3, 2.0), (1, 3, f64::NAN), (0, 1, 0.5)]
    {
        let mut matrix = identity;
        matrix[row][column] = value;
        assert!(similarity_of(matrix).is_err(), "{row} {column} {value}");
    }
}
