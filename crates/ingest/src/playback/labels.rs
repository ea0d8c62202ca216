//! Masks at the size of the small images, as run lengths. `docs/formats/playback.md` specifies them.

use bendtwin_capture::raw::Mask;

use super::images::small_size;

/// Labels of pixels.
const NOTHING: u64 = 0;
const OBJECT: u64 = 1;
const HAND: u64 = 2;

/// The runs of equal labels of the small image, row by row: `length * 4 + label` of each as LEB128. Empty
/// without masks; the hand covers the object.
pub(super) fn runs(object: Option<&Mask>, hand: Option<&Mask>) -> Vec<u8> {
    let Some(any) = object.or(hand) else { return Vec::new() };
    let [width, height] = small_size(any.width, any.height);
    let mut out = Vec::new();
    let mut run = (NOTHING, 0);
    for y in 0..height {
        for x in 0..width {
            // The middle of what the small pixel covers.
            let (column, row) =
                ((2 * x + 1) * any.width / (2 * width), (2 * y + 1) * any.height / (2 * height));
            let shows = |mask: Option<&Mask>| mask.is_some_and(|m| m.row(row)[column]);
            let label = match (shows(hand), shows(object)) {
                (true, _) => HAND,
                (false, true) => OBJECT,
                (false, false) => NOTHING,
            };
            if label == run.0 {
                run.1 += 1;
            } else {
                push(&mut out, run);
                run = (label, 1);
            }
        }
    }
    push(&mut out, run);
    out
}

fn push(out: &mut Vec<u8>, (label, length): (u64, u64)) {
    if length == 0 {
        return;
    }
    let mut number = length * 4 + label;
    while number >= 0x80 {
        out.push((number & 0x7f) as u8 | 0x80);
        number >>= 7;
    }
    out.push(number as u8);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_have_all_pixels_in_their_order() {
        let mut object = Mask::filled(4, 2, false);
        object.pixels[1..5].fill(true);
        let mut hand = Mask::filled(4, 2, false);
        hand.pixels[4..6].fill(true);
        // One of nothing, three of the object, two of the hand, two of nothing.
        assert_eq!(runs(Some(&object), Some(&hand)), [4, 13, 10, 8]);
        assert_eq!(runs(None, None), Vec::<u8>::new());
        assert_eq!(runs(None, Some(&Mask::filled(10, 10, false))), [0x90, 0x03]);
        // A large one has as many pixels as its small image: 424 x 240.
        assert_eq!(runs(Some(&Mask::filled(848, 480, true)), None), [0x81, 0xec, 0x18]);
    }
}
