use proptest::prelude::*;

use super::{
    runs::{Runs, of_text},
    *,
};

const SIZE: Size = [5, 4];

fn pixels(runs: &Runs) -> Vec<u32> {
    let mut pixels = vec![0; SIZE[0] * SIZE[1]];
    runs.each(SIZE, |index, label| pixels[index] = label);
    pixels
}

proptest! {
    #[test]
    fn runs_have_the_labels_that_they_were_made_of(
        labels in proptest::collection::vec(0_u32..4, SIZE[0] * SIZE[1]),
    ) {
        let mut budget = Budget::new(&Limits::default());
        let runs = Runs::of(labels.iter().copied(), "a", &mut budget).unwrap();
        prop_assert_eq!(pixels(&runs), labels);
    }

    /// Neither text nor lengths that are too long leave the image.
    #[test]
    fn any_text_is_read_or_refused(text in "[0-~]{0,40}") {
        if let Some(lengths) = of_text(&text) {
            pixels(&Runs::Columns(lengths));
        }
    }
}

#[test]
fn columns_are_turned_into_rows() {
    // One pixel of background, then the second to the fifth, down the columns.
    let shown = pixels(&Runs::Columns(vec![1, 4, 15]));
    assert_eq!(shown, [0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0]);
}

#[test]
fn what_is_neither_array_nor_document_is_damaged() {
    let expected = Expected { size: SIZE, frames: 1, whole: false };
    let limits = Limits::default();
    for bytes in [&b""[..], b"text", b"PK\x05\x06", b"\x93NUMPY", b"{", b"[]"] {
        assert!(read("a", bytes, expected, &limits, &mut Budget::new(&limits)).is_err());
    }
}
