use super::*;

/// TIFF data with one entry before the orientation.
fn tiff(orientation: u16, little: bool) -> Vec<u8> {
    let short = |n: u16| if little { n.to_le_bytes() } else { n.to_be_bytes() };
    let long = |n: u32| if little { n.to_le_bytes() } else { n.to_be_bytes() };
    let mut out = if little { b"II\x2a\0".to_vec() } else { b"MM\0\x2a".to_vec() };
    out.extend(long(8));
    out.extend(short(2));
    for (tag, value) in [(0x0100, 7), (TAG, orientation)] {
        out.extend([short(tag), short(3)].concat());
        out.extend(long(1));
        out.extend([short(value), [0, 0]].concat());
    }
    out.extend(long(0));
    out
}

fn jpeg_with(exif: &[u8]) -> Vec<u8> {
    let plain = include_bytes!("../../../../testdata/plain.jpg");
    let mut out = plain[..2].to_vec();
    out.extend(b"\xff\xe1");
    out.extend((exif.len() as u16 + 8).to_be_bytes());
    out.extend(b"Exif\0\0");
    out.extend(exif);
    out.extend(&plain[2..]);
    out
}

#[test]
fn orientations_are_read_from_jpeg() {
    for number in 1..=8 {
        for little in [false, true] {
            let (size, found) = peek(&jpeg_with(&tiff(number, little))).unwrap();
            assert_eq!(u16::from(found.number()), number);
            assert_eq!(size, peek(include_bytes!("../../../../testdata/plain.jpg")).unwrap().0);
        }
    }
    for wrong in [0, 9, 300] {
        assert_eq!(of(&jpeg_with(&tiff(wrong, true))), Orientation::NONE);
    }
}

#[test]
fn orientations_are_read_from_png() {
    let png = crate::raw::testing::png_file(2, 1, ::png::ColorType::Grayscale, false, &[1, 2]);
    assert_eq!(peek(&png), Some(([2, 1], Orientation::NONE)));
    let exif = tiff(6, true);
    // Before the pixels: after the header, which takes 25 bytes.
    let mut with = png[..33].to_vec();
    with.extend((exif.len() as u32).to_be_bytes());
    with.extend(b"eXIf");
    with.extend(&exif);
    with.extend([0; 4]);
    with.extend(&png[33..]);
    assert_eq!(peek(&with), Some(([2, 1], Orientation(6))));
}

#[test]
fn data_that_are_cut_off_declare_nothing() {
    let whole = jpeg_with(&tiff(3, false));
    for length in 0..whole.len().min(120) {
        let _ = peek(&whole[..length]);
        let _ = of(&whole[..length]);
    }
    let mut circular = tiff(3, true);
    circular[4..8].copy_from_slice(&u32::MAX.to_le_bytes());
    assert_eq!(of(&jpeg_with(&circular)), Orientation::NONE);
}

/// The letter F, 2 x 3 pixels as shown, stored under each orientation as EXIF's definition has it.
#[test]
fn pictures_are_turned_as_they_are_to_be_shown() {
    let shown = [1, 2, 3, 4, 5, 6];
    for (number, size, stored) in [
        (1, [2, 3], [1, 2, 3, 4, 5, 6]),
        (2, [2, 3], [2, 1, 4, 3, 6, 5]),
        (3, [2, 3], [6, 5, 4, 3, 2, 1]),
        (4, [2, 3], [5, 6, 3, 4, 1, 2]),
        (5, [3, 2], [1, 3, 5, 2, 4, 6]),
        (6, [3, 2], [2, 4, 6, 1, 3, 5]),
        (7, [3, 2], [6, 4, 2, 5, 3, 1]),
        (8, [3, 2], [5, 3, 1, 6, 4, 2]),
    ] {
        let samples = Samples { size, channels: 1, deep: false, data: stored.to_vec() };
        let turned = Orientation(number).turn(samples);
        assert_eq!((turned.size, turned.data.as_slice()), ([2, 3], shown.as_slice()), "{number}");
    }
}
