use ::png::ColorType;

use super::*;
use crate::{Limits, limits::Budget, npy, raw::testing::png_file};

fn jpeg() -> Vec<u8> {
    // 16 x 8 pixels of one colour, baseline, written by Pillow.
    include_bytes!("../../../testdata/plain.jpg").to_vec()
}

#[test]
fn colour_comes_from_every_kind_of_png() {
    let of = |color, deep, data: &[u8]| {
        super::color("c", &png_file(1, 1, color, deep, data), [1, 1]).unwrap().pixels[0]
    };
    assert_eq!(of(ColorType::Rgb, false, &[1, 2, 3]), [1, 2, 3]);
    assert_eq!(of(ColorType::Rgba, false, &[1, 2, 3, 4]), [1, 2, 3]);
    assert_eq!(of(ColorType::Grayscale, false, &[7]), [7; 3]);
    assert_eq!(of(ColorType::GrayscaleAlpha, false, &[7, 1]), [7; 3]);
    assert_eq!(of(ColorType::Rgb, true, &[1, 99, 2, 99, 3, 99]), [1, 2, 3]);
}

#[test]
fn colour_comes_from_jpeg() {
    let image = super::color("c", &jpeg(), [16, 8]).unwrap();
    let near = |p: &[u8; 3]| (0..3).all(|i| p[i].abs_diff([200, 100, 50][i]) <= 3);
    assert!(image.pixels.iter().all(near), "{:?}", image.pixels[0]);
    assert!(matches!(super::color("c", &jpeg(), [8, 8]), Err(Error::ImageSize { .. })));
    let bytes = jpeg();
    for length in 0..bytes.len() - 8 {
        assert!(super::color("c", &bytes[..length], [16, 8]).is_err(), "{length}");
    }
}

#[test]
fn alpha_is_no_mask() {
    let of = |color, data: &[u8]| {
        super::mask("m", &png_file(1, 1, color, false, data), [1, 1]).unwrap().pixels[0]
    };
    assert!(of(ColorType::Grayscale, &[1]));
    assert!(of(ColorType::Rgb, &[0, 0, 1]));
    assert!(!of(ColorType::Rgba, &[0, 0, 0, 255]));
    assert!(!of(ColorType::GrayscaleAlpha, &[0, 255]));
}

#[test]
fn depth_is_in_metres_and_holes_are_zero() {
    let budget = &mut Budget::new(&Limits::default());
    let png = png_file(2, 1, ColorType::Grayscale, true, &[0x03, 0xE8, 0, 0]);
    assert_eq!(
        super::depth("d", &png, DepthUnit::Declared(0.001), [2, 1], budget).unwrap().pixels,
        [1.0, 0.0]
    );
    let floats = [1.5_f32, f32::NAN, -1.0, f32::INFINITY];
    let data: Vec<u8> = floats.iter().flat_map(|x| x.to_le_bytes()).collect();
    let array = npy::write("<f4", &[1, 4], &data);
    let depth = super::depth("d", &array, DepthUnit::Declared(1.0), [4, 1], budget).unwrap();
    assert_eq!(depth.pixels, [1.5, 0.0, 0.0, 0.0]);
    let color = png_file(2, 1, ColorType::Rgb, true, &[0; 12]);
    assert!(matches!(
        super::depth("d", &color, DepthUnit::Declared(0.001), [2, 1], budget),
        Err(Error::Dtype { .. })
    ));
    let shallow = png_file(2, 1, ColorType::Grayscale, false, &[0; 2]);
    assert!(matches!(
        super::depth("d", &shallow, DepthUnit::Declared(0.001), [2, 1], budget),
        Err(Error::Dtype { .. })
    ));
}

#[test]
fn png_files_that_are_cut_off_anywhere_are_refused() {
    let bytes = png_file(4, 4, ColorType::Rgb, false, &[9; 48]);
    for length in 0..bytes.len() - 12 {
        assert!(super::color("c", &bytes[..length], [4, 4]).is_err(), "{length}");
    }
}

/// Zero rows are half a pixel from the one row of a flat image, so the ratio alone lets them pass.
#[test]
fn depth_without_rows_or_columns_is_refused() {
    let budget = &mut Budget::new(&Limits::default());
    for (shape, size) in [([0, 1], [8, 1]), ([0, 4], [8, 1]), ([1, 0], [1, 8])] {
        let array = npy::write("<f4", &shape, &[]);
        let depth = super::depth("d", &array, DepthUnit::Declared(1.0), size, budget);
        assert!(matches!(depth, Err(Error::ImageSize { .. })), "{shape:?} {size:?}");
    }
}
