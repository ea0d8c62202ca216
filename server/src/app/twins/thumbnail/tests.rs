use super::*;

fn picture(bytes: usize) -> Thumbnail {
    let source = Digest::from_bytes([bytes as u8; 32]);
    Thumbnail { bytes: vec![0; bytes].into(), media_type: "image/png", source }
}

#[test]
fn the_oldest_pictures_go_when_there_are_too_many_bytes() {
    let drawing = Drawing::default();
    let third = KEPT_BYTES / 3;
    let pictures: Vec<_> = (0..4).map(|i| picture(third - i)).collect();
    for one in &pictures {
        drawing.keep((one.source, 160), one);
    }
    let is_kept = |one: &Thumbnail| drawing.find((one.source, 160)).is_some();
    assert_eq!(pictures.iter().map(is_kept).collect::<Vec<_>>(), [false, true, true, true]);
    // The same once more takes no more room, and another width is another picture.
    for _ in 0..10 {
        drawing.keep((pictures[3].source, 160), &pictures[3]);
    }
    assert!(is_kept(&pictures[1]));
    assert!(drawing.find((pictures[3].source, 161)).is_none());
}

#[test]
fn a_capture_shows_the_first_image_that_was_recorded() {
    let motion = r#""motion": {"point_count": 2, "origin": [1, 0, 0], "scale_m": 0.001, "points": [0, 24], "colors": null}"#;
    let head = |cameras: &str| -> Sequence {
        serde_json::from_str(&format!(r#"{{{motion}, "cameras": [{cameras}]}}"#)).unwrap()
    };
    let empty = r#"{"images": {"lengths": [0, 0], "bytes": [100, 0]}}"#;
    let late = r#"{"images": {"lengths": [0, 7, 9], "bytes": [100, 16]}}"#;
    assert_eq!(head("").first_image(), None);
    assert_eq!(head(&format!("{empty}, {late}")).first_image(), Some([100, 7]));

    let numbers = [1000i16, 0, -5, i16::MIN, i16::MIN, i16::MIN];
    let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
    let points = head("").motion.positions(&bytes);
    assert_eq!(points[0], [2.0, 0.0, -0.005]);
    assert!(points[1].iter().all(|x| x.is_nan()));
}
