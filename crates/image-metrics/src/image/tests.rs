use super::*;

#[test]
fn sizes_and_numbers_are_checked() {
    let pixels = vec![[0.5; 3]; 6];
    assert!(Image::new(3, 2, &pixels).is_ok());
    assert_eq!(Image::new(0, 2, &[]).unwrap_err(), Error::Empty { width: 0, height: 2 });
    let short = Error::Length { what: "colours", found: 6, width: 4, height: 2 };
    assert_eq!(Image::new(4, 2, &pixels).unwrap_err(), short);
    assert!(Image::new(u32::MAX, u32::MAX, &pixels).is_err());
    let mut broken = pixels;
    broken[4][1] = f32::NAN;
    assert_eq!(Image::new(3, 2, &broken).unwrap_err(), Error::NotFinite { pixel: 4 });
}

#[test]
fn pairs_have_one_size() {
    let pixels = vec![[0.5; 3]; 6];
    let (wide, tall) = (Image::new(3, 2, &pixels).unwrap(), Image::new(2, 3, &pixels).unwrap());
    assert_eq!(Pair::new(wide, tall, None).unwrap_err(), Error::Sizes { a: [3, 2], b: [2, 3] });
    assert!(Pair::new(wide, wide, Some(&[true; 6])).is_ok());
    assert!(Pair::new(wide, wide, Some(&[true; 5])).is_err());
}
