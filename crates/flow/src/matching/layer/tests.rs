use bendtwin_capture::raw::Image;

use super::Layer;

/// A grey disc on white, and where it is.
fn disc() -> (Image<[u8; 3]>, Vec<bool>) {
    let mut image = Image::filled(60, 50, [255, 255, 255]);
    let mut inside = vec![false; 60 * 50];
    for (i, pixel) in image.pixels.iter_mut().enumerate() {
        let (x, y) = (i as f64 % 60.0 - 33.0, (i / 60) as f64 - 21.0);
        if x.hypot(y) < 12.0 {
            *pixel = [51, 102, 153];
            inside[i] = true;
        }
    }
    (image, inside)
}

#[test]
fn the_background_leaks_into_no_level() {
    let (image, inside) = disc();
    let layer = Layer::new(&image, &inside, 1.0, 4).unwrap();
    assert_eq!(layer.levels.len(), 4);
    for level in &layer.levels {
        for (x, y) in [(33.0, 21.0), (30.3, 25.7), (33.0, 10.5), (44.6, 21.0)] {
            let (color, coverage) = level.sample([x, y]).unwrap();
            assert!(coverage > 0.1 && coverage < 1.001);
            for (found, there) in color.iter().zip([0.2, 0.4, 0.6]) {
                assert!((found - there).abs() < 1e-5, "{found} is not {there}");
            }
        }
    }
}

#[test]
fn far_from_the_region_there_is_nothing() {
    let (image, inside) = disc();
    let layer = Layer::new(&image, &inside, 0.0, 2).unwrap();
    for at in [[2.0, 2.0], [-5.0, 20.0], [59.5, 49.5], [f32::NAN, 20.0], [1e30, 1e30]] {
        assert!(layer.levels.iter().all(|level| level.sample(at).is_none()));
    }
    assert!(Layer::new(&image, &[false; 60 * 50], 0.8, 4).is_none());
}
