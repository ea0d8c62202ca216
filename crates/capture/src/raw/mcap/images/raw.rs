//! Raw pixels of any encoding into colours: samples, YUV with shared colours, and Bayer patterns.

use super::super::encodings::Pixels;
use crate::raw::decode::Size;

/// Bytes of a row, and rows, that an image of this size has in memory; `None` for a size that the
/// encoding cannot have.
pub(super) fn extent(pixels: Pixels, [width, height]: Size) -> Option<[usize; 2]> {
    match pixels {
        Pixels::Samples { count, deep, .. } => {
            Some([width.checked_mul(count)?.checked_mul(if deep { 2 } else { 1 })?, height])
        }
        Pixels::Yuv422(_) => (width.is_multiple_of(2)).then_some([width.checked_mul(2)?, height]),
        Pixels::Nv { .. } => {
            let even = width.is_multiple_of(2) && height.is_multiple_of(2);
            even.then_some([width, height.checked_add(height / 2)?])
        }
        Pixels::Bayer { deep, .. } => Some([width.checked_mul(if deep { 2 } else { 1 })?, height]),
    }
}

/// Colours of rows of bytes that have [`extent`].
pub(super) fn colors(
    pixels: Pixels,
    [width, height]: Size,
    rows: &[&[u8]],
    big_endian: bool,
) -> Vec<[u8; 3]> {
    let high = usize::from(!big_endian);
    let mut out = Vec::with_capacity(width * height);
    match pixels {
        Pixels::Samples { count, order, deep } => {
            let (size, at) = if deep { (2, high) } else { (1, 0) };
            for row in rows {
                let pixels = row.chunks_exact(count * size);
                out.extend(pixels.map(|p| order.map(|sample| p[sample * size + at])));
            }
        }
        Pixels::Yuv422([first, second, blue, red]) => {
            for row in rows {
                for p in row.as_chunks::<4>().0 {
                    out.extend([first, second].map(|luma| rgb(p[luma], p[blue], p[red])));
                }
            }
        }
        Pixels::Nv { blue } => {
            for (r, row) in rows.iter().take(height).enumerate() {
                let Some(shared) = rows.get(height + r / 2) else { continue };
                for (c, luma) in row.iter().enumerate() {
                    let pair = &shared[c / 2 * 2..c / 2 * 2 + 2];
                    out.push(rgb(*luma, pair[blue], pair[1 - blue]));
                }
            }
        }
        Pixels::Bayer { pattern, deep } => {
            let (size, at) = if deep { (2, high) } else { (1, 0) };
            let sample = |c: usize, r: usize| rows.get(r).and_then(|row| row.get(c * size + at));
            demosaic(pattern, [width, height], sample, &mut out);
        }
    }
    out
}

/// Colours from one colour for each pixel: `pattern` has those of 2 x 2 pixels.
pub(super) fn demosaic<'a>(
    pattern: [usize; 4],
    [width, height]: Size,
    sample: impl Fn(usize, usize) -> Option<&'a u8>,
    out: &mut Vec<[u8; 3]>,
) {
    let color = |c: usize, r: usize| pattern[r % 2 * 2 + c % 2];
    for r in 0..height {
        for c in 0..width {
            // The mean of the neighbours that have a colour: bilinear interpolation.
            let (mut sums, mut counts) = ([0_u32; 3], [0_u32; 3]);
            for row in r.saturating_sub(1)..=r + 1 {
                for column in c.saturating_sub(1)..=c + 1 {
                    let inside = column < width;
                    let Some(value) = sample(column, row).filter(|_| inside) else { continue };
                    sums[color(column, row)] += u32::from(*value);
                    counts[color(column, row)] += 1;
                }
            }
            let mut pixel = std::array::from_fn(|i| (sums[i] / counts[i].max(1)) as u8);
            if let Some(own) = sample(c, r) {
                pixel[color(c, r)] = *own;
            }
            out.push(pixel);
        }
    }
}

/// BT.601 with luma from 16 to 235, as cameras and OpenCV have it.
fn rgb(luma: u8, blue: u8, red: u8) -> [u8; 3] {
    let y = 1.164 * (f32::from(luma) - 16.0);
    let (b, r) = (f32::from(blue) - 128.0, f32::from(red) - 128.0);
    // Conversion to an integer saturates.
    [y + 1.596 * r, y - 0.813 * r - 0.392 * b, y + 2.017 * b].map(|x| x.round() as u8)
}

#[cfg(test)]
mod tests {
    use super::{super::super::encodings::pixels, *};

    fn of(encoding: &str, size: Size, data: &[u8], big_endian: bool) -> Vec<[u8; 3]> {
        let kind = pixels(encoding).unwrap();
        let [row, rows] = extent(kind, size).unwrap();
        assert_eq!(data.len(), row * rows);
        colors(kind, size, &data.chunks(row).collect::<Vec<_>>(), big_endian)
    }

    #[test]
    fn samples_come_in_the_order_of_their_encoding() {
        assert_eq!(of("rgb8", [1, 1], &[1, 2, 3], false), [[1, 2, 3]]);
        assert_eq!(of("bgra8", [1, 1], &[1, 2, 3, 4], false), [[3, 2, 1]]);
        assert_eq!(of("mono8", [2, 1], &[1, 2], false), [[1; 3], [2; 3]]);
        assert_eq!(of("mono16", [1, 1], &[1, 2], false), [[2; 3]]);
        assert_eq!(of("rgb16", [1, 1], &[1, 2, 3, 4, 5, 6], true), [[1, 3, 5]]);
    }

    #[test]
    fn yuv_has_the_colours_of_opencv() {
        // White, black and red, as cv2.cvtColor gives them.
        for (encoding, data) in
            [("yuv422_yuy2", [235, 128, 16, 128]), ("yuv422", [128, 235, 128, 16])]
        {
            assert_eq!(of(encoding, [2, 1], &data, false), [[255; 3], [0; 3]], "{encoding}");
        }
        let red = of("yuyv", [2, 1], &[81, 90, 81, 240], false);
        assert!(red[0][0] >= 254 && red[0][1] <= 1 && red[0][2] <= 1, "{red:?}");
        let nv12 = of("nv12", [2, 2], &[81, 81, 81, 81, 90, 240], false);
        let nv21 = of("nv21", [2, 2], &[81, 81, 81, 81, 240, 90], false);
        assert_eq!((&nv12[..], &nv21[..]), (&[red[0]; 4][..], &[red[0]; 4][..]));
        assert_eq!(extent(pixels("nv12").unwrap(), [2, 3]), None);
        assert_eq!(extent(pixels("yuyv").unwrap(), [3, 2]), None);
    }

    #[test]
    fn patterns_of_bayer_become_the_colour_that_they_filter() {
        let color = [200, 100, 50];
        for (encoding, order) in [
            ("bayer_rggb8", [0, 1, 1, 2]),
            ("bayer_bggr8", [2, 1, 1, 0]),
            ("bayer_gbrg8", [1, 2, 0, 1]),
            ("bayer_grbg8", [1, 0, 2, 1]),
        ] {
            let data: Vec<u8> = (0..24).map(|i| color[order[i / 6 % 2 * 2 + i % 6 % 2]]).collect();
            assert_eq!(of(encoding, [6, 4], &data, false), [color; 24], "{encoding}");
        }
        let deep: Vec<u8> = [200, 100, 100, 50].iter().flat_map(|x| [7, *x]).collect();
        assert_eq!(of("bayer_rggb16", [2, 2], &deep, false), [color; 4]);
        // A slope stays one.
        let slope: Vec<u8> = (0..64).map(|i| (i % 8 * 10) as u8).collect();
        let all = of("bayer_grbg8", [8, 8], &slope, false);
        assert_eq!(all[3 * 8 + 4], [40; 3]);
    }
}
