use super::*;
use crate::{
    Limits,
    files::Files,
    raw::testing::{self, HEIGHT, WIDTH},
};

fn painted(seed: usize) -> Image<Option<Region>> {
    let pixel = |i: usize| match (i * 7 + seed) / 5 % 3 {
        0 => None,
        1 => Some(Region::Object),
        _ => Some(Region::Manipulator),
    };
    Image { width: 300, height: 2, pixels: (0..600).map(pixel).collect() }
}

#[test]
fn what_is_set_is_read_back_and_no_pixel_is_in_both_masks() {
    let mut set = MaskSet::new([[300, 2], [300, 2]], 3);
    assert!(set.is_empty());
    for (camera, frame) in [(0, 0), (1, 2)] {
        set.set(camera, frame, &painted(frame));
        assert_eq!(set.shown(camera, frame).unwrap(), painted(frame));
        let [object, hand] = FOLDERS.map(|(_, region)| set.mask(camera, frame, region).unwrap());
        assert!(object.pixels.iter().zip(&hand.pixels).all(|(a, b)| !(*a && *b)));
    }
    // Runs longer than seven bits.
    let whole = Image::filled(300, 2, Some(Region::Object));
    set.set(0, 1, &whole);
    assert_eq!(set.shown(0, 1).unwrap(), whole);
    assert!(set.shown(1, 0).is_none() && set.shown(2, 0).is_none());
    let before = set.clone();
    set.set(0, 1, &Image::filled(2, 300, None));
    set.set(0, 3, &whole);
    set.set(2, 0, &whole);
    assert_eq!(set, before, "what does not exist is not set");
}

#[test]
fn a_recording_has_the_masks_that_it_is_given() {
    let folder = testing::folder(&testing::case());
    let recording = crate::raw::open(folder.path(), &Limits::default()).unwrap();
    let own = MaskSet::of(&recording).unwrap();
    assert!(!own.is_empty());
    let mut other = MaskSet::empty(&recording);
    other.set(0, 1, &Image::filled(WIDTH, HEIGHT, Some(Region::Manipulator)));
    let given = recording.clone().with_masks(Arc::new(other.clone()));
    assert_eq!(MaskSet::of(&given).unwrap(), other);
    assert_eq!(given.source.files(), recording.source.files());
    assert_eq!(given.usable().source.color_stem(1, 2).as_deref(), Some("2"));
    let color = |r: &Recording| r.source.frames(0).unwrap().color(0).unwrap();
    assert_eq!(color(&given), color(&recording));
}

#[test]
fn an_archive_of_masks_is_read_back() {
    let folder = testing::folder(&testing::case());
    let recording = crate::raw::open(folder.path(), &Limits::default()).unwrap();
    let masks = MaskSet::of(&recording).unwrap();
    let path = folder.path().join("masks.zip");
    masks.write_zip(&path, &[("mask/following.json", b"{}".to_vec())]).unwrap();
    let limits = Limits::default();
    let read = recording.clone().with_mask_files(&path, &limits).unwrap();
    assert_eq!(MaskSet::of(&read).unwrap(), masks);
    assert_eq!(read.source.color_stem(1, 2).as_deref(), Some("2"));
    let mut files = Files::open(&path, &Limits::default()).unwrap();
    assert_eq!(files.read("mask/following.json").unwrap(), b"{}");
    // Masks of another size are refused before they are decoded.
    let mut narrow = recording;
    narrow.cameras.iter_mut().for_each(|camera| camera.width -= 1);
    let refused = narrow.with_mask_files(&path, &limits).and_then(|read| MaskSet::of(&read));
    assert!(matches!(refused, Err(Error::ImageSize { .. })));
}
