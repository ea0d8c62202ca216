use super::*;
use crate::Image;

#[test]
fn ratio_of_known_errors() {
    let (a, b) = (vec![[0.5; 3]; 12], vec![[0.6; 3]; 12]);
    let (a, b) = (Image::new(4, 3, &a).unwrap(), Image::new(4, 3, &b).unwrap());
    let pair = Pair::new(a, b, None).unwrap();
    assert!((psnr(&pair) - 20.0).abs() < 1e-5);
    assert_eq!(psnr(&Pair::new(a, a, None).unwrap()), f64::INFINITY);
    // Three of twelve pixels count, the mean is over twelve: 10 log10(4) more.
    let valid: Vec<bool> = (0..12).map(|p| p < 3).collect();
    let masked = Pair::new(a, b, Some(&valid)).unwrap();
    assert!((psnr(&masked) - (20.0 + 10.0 * 4f64.log10())).abs() < 1e-5);
}
