use super::*;
use crate::Color;

fn canvas(color: Color) -> Canvas {
    Canvas::new(6.0, 4.0, color).unwrap()
}

#[test]
fn frames_come_back_unchanged_with_their_times() {
    let mut bytes = Vec::new();
    let mut animation = Animation::new(&mut bytes, [6, 4], 2, 29.97).unwrap();
    animation.push(&canvas(Color(200, 10, 30)), 1).unwrap();
    animation.push(&canvas(Color(1, 2, 3)), 3).unwrap();
    animation.finish().unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let control = reader.info().animation_control.unwrap();
    assert_eq!((control.num_frames, control.num_plays), (2, 0));
    for (color, delay) in [([200, 10, 30], (100, 2997)), ([1, 2, 3], (300, 2997))] {
        let mut pixels = vec![0; 6 * 4 * 3];
        reader.next_frame(&mut pixels).unwrap();
        assert!(pixels.chunks(3).all(|p| p == color), "{pixels:?}");
        let shown = reader.info().frame_control.unwrap();
        assert_eq!((shown.delay_num, shown.delay_den), delay);
    }
}

#[test]
fn frames_that_do_not_belong_together_are_refused() {
    let mut animation = Animation::new(Vec::new(), [6, 4], 2, 30.0).unwrap();
    let other = Canvas::new(5.0, 4.0, Color(0, 0, 0)).unwrap();
    assert!(matches!(animation.push(&other, 1), Err(Error::Size { .. })));
    animation.push(&canvas(Color(0, 0, 0)), 1).unwrap();
    assert!(animation.finish().is_err());
    assert!(Animation::new(Vec::new(), [6, 4], 0, 30.0).is_err());
}

#[test]
fn a_full_disk_is_no_fault_of_the_encoder() {
    let mut full = [0; 120];
    let mut animation = Animation::new(&mut full[..], [6, 4], 1, 30.0).unwrap();
    let pushed = animation.push(&canvas(Color(0, 0, 0)), 1);
    let ended = pushed.and_then(|()| animation.finish());
    assert!(matches!(ended, Err(Error::Write(_))), "{ended:?}");
}
