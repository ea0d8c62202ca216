use super::*;

fn images(at: &str, numbers: impl IntoIterator<Item = u64>) -> Images {
    let by_number = numbers.into_iter().map(|n| (n, format!("{at}/{n}.png"))).collect();
    Images { at: at.to_owned(), by_number }
}

fn aligned(all: &[&Images], count: Option<usize>) -> Result<(u64, usize), String> {
    let numbering = align(all, count.map(|count| ("`frame_count`", count)), &Limits::default());
    numbering.map(|n| (n.first, n.frame_count)).map_err(|e| e.to_string())
}

#[test]
fn the_number_ends_a_name_or_is_the_only_one() {
    for (stem, expected) in [
        ("12", Some(12)),
        ("000012", Some(12)),
        ("cam0_frame_12", Some(12)),
        ("12_color", Some(12)),
        ("cam0_12_color", None),
        ("1699.25", None),
        ("color", None),
        ("99999999999999999999999", None),
    ] {
        assert_eq!(number(stem), expected, "{stem}");
    }
}

#[test]
fn frame_0_has_the_first_number_unless_first_frames_are_missing() {
    let whole = images("a", 0..10);
    assert_eq!(aligned(&[&whole], Some(10)), Ok((0, 10)));
    assert_eq!(aligned(&[&images("a", 1..11)], Some(10)), Ok((1, 10)));
    assert_eq!(aligned(&[&images("a", 500..510), &images("b", 501..510)], Some(10)), Ok((500, 10)));
    // Frames 0 and 1 were dropped.
    assert_eq!(aligned(&[&images("a", 2..10)], Some(10)), Ok((0, 10)));
    assert_eq!(aligned(&[&images("a", 2..10)], None), Ok((2, 8)));
    assert_eq!(aligned(&[], Some(10)), Ok((0, 10)));
}

#[test]
fn numbers_that_give_no_frames_are_refused() {
    let (from_0, from_1) = (images("color/0", 0..10), images("depth/0", 1..11));
    for text in [
        aligned(&[&from_0, &from_1], None).unwrap_err(),
        aligned(&[&images("color/0", 5..16), &images("depth/0", 1..12)], Some(11)).unwrap_err(),
    ] {
        assert!(text.contains("`color/0` from ") && text.contains("`depth/0` from 1"), "{text}");
    }
    let times = images("color/0", (0..10).map(|i| 1_700_000_000_000 + 33 * i));
    assert!(aligned(&[&times], None).unwrap_err().contains("(10 images)"));
    assert!(aligned(&[&images("a", [0, u64::MAX])], None).is_err());
    assert!(aligned(&[&images("a", [3, u64::MAX])], Some(2)).is_err());
}

#[test]
fn a_count_that_is_not_that_of_the_images_is_refused() {
    let whole = images("a", 1..11);
    assert!(expect_all(&[&whole], "`frame_num`", 10).is_ok());
    for wrong in [9, 12, 100] {
        assert!(expect_all(&[&whole], "`frame_num`", wrong).is_err(), "{wrong}");
    }
    assert!(expect_all(&[&images("a", 0..10)], "`frame_num`", 11).is_err());
    // The first was dropped.
    assert!(expect_all(&[&images("a", 1..10)], "`frame_num`", 10).is_ok());
}
