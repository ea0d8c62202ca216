use super::*;
use crate::{predict, scene};

fn models<'a>(twin: &'a Twin, trajectory: &'a Trajectory) -> [Model<'a>; 2] {
    ["with", "without"].map(|name| Model { name, twin, trajectory })
}

fn prediction(capture: &Capture, twin: &Twin) -> Trajectory {
    let backend = bendtwin_engine::cpu_with_threads(1);
    predict(&*backend, twin, capture, &Default::default()).unwrap().remove(0)
}

#[test]
fn the_picture_is_a_png_with_both_models_in_it() {
    let capture = scene::chain(8, 12, 8, [0.01, 0.02, 0.0]);
    let twin = scene::chain_twin(8);
    let trajectory = prediction(&capture, &twin);
    let models = models(&twin, &trajectory);
    let picture = Picture { capture: &capture, sequence: 0, models: &models, columns: 4 };
    let bytes = picture.to_png().unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert!(info.width > 1200 && info.height > 400);
    for Color(r, g, b) in [MODELS[0], MODELS[1], FUTURE] {
        assert!(pixels.chunks_exact(3).any(|p| p == [r, g, b]), "{r} {g} {b} is missing");
    }
    assert_eq!(bytes, picture.to_png().unwrap(), "the same input gives the same file");
}

#[test]
fn nothing_to_draw_is_an_error() {
    let mut capture = scene::chain(4, 5, 3, [0.0; 3]);
    let twin = scene::chain_twin(4);
    let trajectory = prediction(&capture, &twin);
    let models = models(&twin, &trajectory);
    let draw = |capture: &Capture, sequence: usize| {
        Picture { capture, sequence, models: &models, columns: 3 }.to_png()
    };
    assert!(draw(&capture, 1).is_err());
    capture.sequences[0].visible.fill(false);
    assert!(draw(&capture, 0).is_err());
}

#[test]
fn frames_of_training_and_future_are_shown() {
    let shown = |frames: usize, train: usize, columns: usize| {
        shown_frames(&scene::chain(3, frames, train, [0.0; 3]).sequences[0], columns)
    };
    assert_eq!(shown(100, 70, 4), [34, 69, 84, 99]);
    assert_eq!(shown(10, 0, 3), [3, 6, 9]);
    assert_eq!(shown(10, 10, 2), [4, 9]);
    assert_eq!(shown(2, 1, 4), [0, 1]);
}
