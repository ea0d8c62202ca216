//! Images: PNG and JPEG, as colour, depth and masks.

use bendtwin_capture::raw::{ColorImage, DepthImage, Mask};

use crate::limits;

/// A PNG image.
pub fn png(data: &[u8]) {
    let side = |at: usize| {
        let bytes = data.get(at..at + 4)?.try_into().ok()?;
        usize::try_from(u32::from_be_bytes(bytes)).ok()
    };
    // As a camera would have declared it.
    read(data, side(16).zip(side(20)));
}

/// A JPEG image.
pub fn jpeg(data: &[u8]) {
    let frame = data.windows(9).find(|w| w[0] == 0xFF && [0xC0, 0xC1, 0xC2].contains(&w[1]));
    let side = |w: &[u8], at: usize| usize::from(u16::from_be_bytes([w[at], w[at + 1]]));
    read(data, frame.map(|w| (side(w, 7), side(w, 5))));
}

fn read(data: &[u8], declared: Option<(usize, usize)>) {
    let limits = limits();
    let (width, height) = declared.unwrap_or_default();
    let small = width.checked_mul(height).is_some_and(|n| (1..=limits.image_pixels).contains(&n));
    let [width, height] = if small { [width, height] } else { [16, 12] };
    let size = [width, height];
    if let Ok(image) = ColorImage::decode("fuzz", data, size) {
        assert_eq!(image.pixels.len(), width * height);
        let written = image.encode().expect("what was read can be written");
        assert_eq!(ColorImage::decode("again", &written, size).ok(), Some(image));
    }
    if let Ok(mask) = Mask::decode("fuzz", data, size) {
        assert_eq!(mask.pixels.len(), width * height);
        let written = mask.encode().expect("what was read can be written");
        assert_eq!(Mask::decode("again", &written, size).ok(), Some(mask));
    }
    // Depth may have another resolution than colour.
    for size in [size, [2 * width, 2 * height]] {
        if let Ok(depth) = DepthImage::decode("fuzz", data, 0.001, size, &limits) {
            assert_eq!(depth.pixels.len(), size[0] * size[1]);
            assert!(depth.pixels.iter().all(|m| m.is_finite() && *m >= 0.0));
        }
    }
}
